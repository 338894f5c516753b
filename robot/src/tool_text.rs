//! One-line notation of a tool: `wheel:radius=50mm,width=20mm`.

use std::path::PathBuf;
use std::str::FromStr;

use crate::Tool;

/// A tool in one-line notation.
#[derive(Clone, Debug)]
pub enum ToolText {
    /// A shape with given sizes.
    Solid(Tool),
    /// A mesh file.
    Mesh(PathBuf),
}

impl FromStr for ToolText {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = |why: String| format!("{why}; {} is expected", tool_notations());
        let (kind, rest) = text.split_once(':').ok_or_else(|| wrong("a kind and its sizes are missing".to_owned()))?;
        if kind == "mesh" {
            return Ok(Self::Mesh(rest.into()));
        }
        let known = Tool::NOTATIONS.iter().find(|(name, _)| *name == kind);
        let (_, (names, tool)) = known.ok_or_else(|| wrong(format!("no tool is called `{kind}`")))?;
        Ok(Self::Solid(tool(&sizes(rest, names).map_err(wrong)?)))
    }
}

/// Accepted notations, for messages and help.
pub fn tool_notations() -> String {
    let example = |(kind, (names, _)): &(&str, (&[&str], _))| {
        let sizes: Vec<String> = names.iter().zip([50, 20]).map(|(name, size)| format!("{name}={size}mm")).collect();
        format!("{kind}:{}", sizes.join(","))
    };
    format!("{} or mesh:FILE", Tool::NOTATIONS.iter().map(example).collect::<Vec<_>>().join(", "))
}

/// Parses sizes [m] from a text such as `radius=50mm,width=20mm`.
fn sizes(text: &str, names: &[&str]) -> Result<Vec<f64>, String> {
    let mut found = vec![None; names.len()];
    for part in text.split(',').filter(|part| !part.is_empty()) {
        let (name, value) =
            part.split_once('=').ok_or_else(|| format!("`{part}` is not a size such as {}=10mm", names[0]))?;
        let index = names.iter().position(|known| *known == name.trim());
        let index = index.ok_or_else(|| format!("it has no size `{name}`; accepted are {}", names.join(" and ")))?;
        found[index] = Some(
            length(value.trim())
                .ok_or_else(|| format!("`{value}` is not a length from 0.01 mm to 10 m, such as 20mm"))?,
        );
    }
    let size = |(found, name): (Option<f64>, &&str)| found.ok_or_else(|| format!("the size `{name}` is missing"));
    found.into_iter().zip(names).map(size).collect()
}

/// Parses a length [m] with its unit.
fn length(text: &str) -> Option<f64> {
    let (number, unit) = [("mm", 1e-3), ("um", 1e-6), ("m", 1.0)]
        .into_iter()
        .find_map(|(unit, size)| text.strip_suffix(unit).map(|number| (number, size)))?;
    let length = number.trim().parse::<f64>().ok()? * unit;
    (1e-5..=10.0).contains(&length).then_some(length)
}
