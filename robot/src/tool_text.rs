//! One-line notation of a tool: `wheel:radius=50mm,width=20mm`.

use std::path::PathBuf;
use std::str::FromStr;

use crate::{Pad, Sphere, Tool, Wheel};

/// Accepted notations, for messages.
const TOOLS: &str = "wheel:radius=50mm,width=20mm, pad:radius=25mm, sphere:radius=10mm or mesh:FILE";

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
        let wrong = |why: String| format!("{why}; {TOOLS} is expected");
        let (kind, rest) = text.split_once(':').ok_or_else(|| wrong("a kind and its sizes are missing".to_owned()))?;
        Ok(Self::Solid(match kind {
            "wheel" => {
                let [radius, width] = sizes(rest, ["radius", "width"]).map_err(wrong)?;
                Wheel::cylinder(radius, width).into()
            }
            "pad" => Pad { radius: sizes(rest, ["radius"]).map_err(wrong)?[0] }.into(),
            "sphere" => Sphere { radius: sizes(rest, ["radius"]).map_err(wrong)?[0] }.into(),
            "mesh" => return Ok(Self::Mesh(rest.into())),
            _ => return Err(wrong(format!("no tool is called `{kind}`"))),
        }))
    }
}

/// Parses sizes [m] from a text such as `radius=50mm,width=20mm`.
fn sizes<const N: usize>(text: &str, names: [&str; N]) -> Result<[f64; N], String> {
    let mut found = [None; N];
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
    let mut sizes = [0.0; N];
    for ((size, found), name) in sizes.iter_mut().zip(found).zip(names) {
        *size = found.ok_or_else(|| format!("the size `{name}` is missing"))?;
    }
    Ok(sizes)
}

/// Parses a length [m] with its unit.
fn length(text: &str) -> Option<f64> {
    let (number, unit) = [("mm", 1e-3), ("um", 1e-6), ("m", 1.0)]
        .into_iter()
        .find_map(|(unit, size)| text.strip_suffix(unit).map(|number| (number, size)))?;
    let length = number.trim().parse::<f64>().ok()? * unit;
    (1e-5..=10.0).contains(&length).then_some(length)
}
