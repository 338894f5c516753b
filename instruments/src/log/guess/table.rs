//! Guesses as a commented table for `trial.toml`.

use super::{Candidate, Confidence, Guesses, Role};

impl Guesses {
    /// The table `[log.columns]`. Comments give the reason of each line, other candidates, and every required quantity
    /// that was not found.
    pub fn table(&self) -> String {
        let mut table = String::from("[log.columns]\n");
        for role in Role::ALL {
            let key = role.key();
            match self.of(role) {
                [] if role.is_required() => {
                    let unit = role.units()[0];
                    table.push_str(&format!(
                        "# no channel has a name for it: {key} = {{ column = \"\", unit = \"{unit}\" }}\n"
                    ));
                }
                [] => {}
                [best, others @ ..] => {
                    table.push_str(&format!("# {}: {}\n", best.confidence.name(), one_line(&best.reason)));
                    table.push_str(&format!("{key} = {}\n", best.entry()));
                    for other in others {
                        table.push_str(&format!("# or: {key} = {}\n", other.entry()));
                    }
                }
            }
        }
        table
    }
}

impl Candidate {
    /// The value of its line: column, unit, and the sign if it is not 1.
    fn entry(&self) -> String {
        let sign = if self.sign < 0 { ", sign = -1" } else { "" };
        format!("{{ column = {}, unit = {}{sign} }}", quoted(&self.name), quoted(&self.unit))
    }
}

impl Confidence {
    /// Name for messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Clear => "clear",
            Self::Likely => "likely",
            Self::Doubtful => "doubtful",
        }
    }
}

/// A text in TOML quotes.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            c if c.is_control() => quoted.push_str(&format!("\\u{:04X}", u32::from(c))),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
