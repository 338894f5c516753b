//! The pages, and the files that they load.

mod bench;
mod home;
mod sets;
mod weld;

pub(crate) use bench::bench;
pub(crate) use home::home;
pub(crate) use sets::set;
pub(crate) use weld::weld;

use maud::{DOCTYPE, Markup, html};

/// Returns media type and text of a file that pages load; it is compiled into the program.
pub(crate) fn asset(name: &str) -> Option<(&'static str, String)> {
    const SCRIPT: &str = "text/javascript; charset=utf-8";
    Some(match name {
        "look.css" => {
            let [of_pages, of_reports] = report::study::STYLE;
            ("text/css; charset=utf-8", format!("{of_pages}{of_reports}{}", include_str!("../assets/workbench.css")))
        }
        "hover.js" => (SCRIPT, report::study::HOVER.to_owned()),
        "workbench.js" => (SCRIPT, include_str!("../assets/workbench.js").to_owned()),
        "part.js" => (SCRIPT, include_str!("../assets/part.js").to_owned()),
        "home.js" => (SCRIPT, include_str!("../assets/home.js").to_owned()),
        "panels.js" => (SCRIPT, include_str!("../assets/panels.js").to_owned()),
        "motion.js" => (SCRIPT, include_str!("../assets/motion.js").to_owned()),
        "region.js" => (SCRIPT, include_str!("../assets/region.js").to_owned()),
        "set.js" => (SCRIPT, include_str!("../assets/set.js").to_owned()),
        "assets.js" => (SCRIPT, include_str!("../assets/assets.js").to_owned()),
        "images.js" => (SCRIPT, include_str!("../assets/images.js").to_owned()),
        "divider.js" => (SCRIPT, include_str!("../assets/divider.js").to_owned()),
        "orbit.js" => (SCRIPT, include_str!("../assets/orbit.js").to_owned()),
        "weld.js" => (SCRIPT, include_str!("../assets/weld.js").to_owned()),
        "dom.js" => (SCRIPT, include_str!("../assets/dom.js").to_owned()),
        _ => return None,
    })
}

/// Builds the document around a page.
///
/// - `script`: module that the page runs, if any
fn document(title: &str, script: Option<&str>, content: Markup) -> Markup {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) " \u{2013} RoboFin workbench" }
                link rel="stylesheet" href="/asset/look.css";
                link rel="icon" href="data:,";
                @if let Some(script) = script { script type="module" src={ "/asset/" (script) } {} }
            }
            body.workbench { (content) }
        }
    }
}
