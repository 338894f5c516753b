//! Words shared by several parts of the page.

use study::with_raised_powers;
use trials::trial::Role;

/// Returns the name of a pass's role.
pub(super) fn role(role: Role) -> &'static str {
    match role {
        Role::Calibration => "calibration",
        Role::Evaluation => "evaluation",
    }
}

/// Builds an HTML list; empty without items.
pub(super) fn list(items: &[String]) -> String {
    if items.is_empty() {
        return String::new();
    }
    let item = |item: &String| format!("<li>{}</li>\n", crate::escape(&with_raised_powers(item)));
    let items: String = items.iter().map(item).collect();
    format!("<ul>\n{items}</ul>\n")
}
