//! Length of one file unit.
//!
//! Only glTF states its unit. For the other formats the rule is defined here, and the reason is stored with the mesh,
//! so that a wrong guess is visible: ABC's OBJ files are in millimetres, its STL files in metres (Koch et al. 2019).

use std::fmt;
use std::str::FromStr;

use serde::Serialize;

use super::Format;

/// Longest side [file units] below which an OBJ is assumed to be in metres.
const OBJ_METRES_BELOW: f64 = 0.1;
/// Longest side [file units] below which an STL or PLY is assumed to be in metres.
const SCAN_METRES_BELOW: f64 = 2.0;
/// Factor around the limit within which the guess is doubtful: parts of one workshop differ in size by as much.
const DOUBTFUL: f64 = 10.0;

/// Requested unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum UnitChoice {
    /// Automatic, from format, names, comments and size.
    #[default]
    Auto,
    /// One file unit is 1 m.
    Metre,
    /// One file unit is 0.001 m.
    Millimetre,
    /// One file unit is 0.0254 m.
    Inch,
}

impl FromStr for UnitChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            "m" => Ok(Self::Metre),
            "mm" => Ok(Self::Millimetre),
            "inch" => Ok(Self::Inch),
            other => Err(format!("unit `{other}` is unknown; auto, mm, m or inch is accepted")),
        }
    }
}

/// The length of one file unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Unit {
    /// 1 m.
    Metre,
    /// 0.001 m.
    Millimetre,
    /// 0.0254 m.
    Inch,
}

impl Unit {
    /// Length of one unit [m].
    pub fn metres(self) -> f64 {
        match self {
            Self::Metre => 1.0,
            Self::Millimetre => 1e-3,
            Self::Inch => 0.0254,
        }
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Metre => "metres",
            Self::Millimetre => "millimetres",
            Self::Inch => "inches",
        })
    }
}

/// A unit with a sentence that gives the reason.
pub(super) struct Decision {
    pub(super) unit: Unit,
    pub(super) reason: String,
    pub(super) assumed: bool,
    pub(super) doubtful: bool,
}

/// Information used to find the unit.
pub(super) struct Evidence<'a> {
    pub(super) format: Format,
    /// File name.
    pub(super) name: &'a str,
    /// Header or comments.
    pub(super) header: &'a str,
    /// Longest side of the bounding box [file units].
    pub(super) longest: f64,
}

pub(super) fn decide(choice: UnitChoice, evidence: &Evidence) -> Decision {
    let asked = match choice {
        UnitChoice::Auto => return decide_from(evidence),
        UnitChoice::Metre => Unit::Metre,
        UnitChoice::Millimetre => Unit::Millimetre,
        UnitChoice::Inch => Unit::Inch,
    };
    Decision { unit: asked, reason: format!("The unit is {asked}, as asked for."), assumed: false, doubtful: false }
}

fn decide_from(evidence: &Evidence) -> Decision {
    let known = |unit: Unit, reason: String| Decision { unit, reason, assumed: false, doubtful: false };
    if evidence.format == Format::Gltf {
        return known(Unit::Metre, "The unit is metres: the glTF specification fixes it.".into());
    }
    if let Some(unit) = stated(evidence.name) {
        return known(unit, format!("The unit is {unit}: the file name {} says so.", evidence.name));
    }
    if let Some(unit) = stated(evidence.header) {
        return known(unit, format!("The unit is {unit}: the file's header or comments say so."));
    }
    let (below, usual) = match evidence.format {
        Format::Obj => (OBJ_METRES_BELOW, "OBJ files of CAD parts usually are in millimetres"),
        _ => (SCAN_METRES_BELOW, "that is large for a part in metres"),
    };
    let format = evidence.format;
    let (unit, because) = if evidence.longest < below {
        (Unit::Metre, format!("below {below} for {format} means metres"))
    } else {
        (Unit::Millimetre, usual.to_string())
    };
    let other = if unit == Unit::Metre { "mm" } else { "m" };
    let reason = format!(
        "The unit is assumed to be {unit}: the {format} file states none and its longest side is {:.4} file units ({because}); `--unit {other}` or `--unit inch` overrides.",
        evidence.longest
    );
    let doubtful = (below / DOUBTFUL..=below * DOUBTFUL).contains(&evidence.longest);
    Decision { unit, reason, assumed: true, doubtful }
}

/// Returns a unit named in a text: `mm` on its own, or any unit after the word `unit` or `units`.
///
/// `inch` or `meter` alone do not count, because they are also parts of names (`3_inch_flange`, `flow_meter`).
pub(super) fn stated(text: &str) -> Option<Unit> {
    let lower = text.to_lowercase();
    let mut announced = false;
    for word in lower.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty()) {
        let bare = word.strip_prefix("units").or(word.strip_prefix("unit"));
        let unit = match bare.unwrap_or(word) {
            "mm" | "millimeter" | "millimeters" | "millimetre" | "millimetres" => return Some(Unit::Millimetre),
            "m" | "meter" | "meters" | "metre" | "metres" => Some(Unit::Metre),
            "in" | "inch" | "inches" => Some(Unit::Inch),
            _ => None,
        };
        if unit.is_some() && (announced || bare.is_some()) {
            return unit;
        }
        announced = bare == Some("");
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_clear_statement_of_the_unit_counts() {
        for (text, unit) in [
            ("counter.unitsmm.STL", Some(Unit::Millimetre)),
            ("part_mm.obj", Some(Unit::Millimetre)),
            ("exported, units = m", Some(Unit::Metre)),
            ("UNITS: inches", Some(Unit::Inch)),
            ("3_inch_flange.stl", None),
            ("flow_meter.stl", None),
            ("unit_cube.stl", None),
            ("plate_10mm.stl", None),
        ] {
            assert_eq!(stated(text), unit, "{text}");
        }
    }

    #[test]
    fn the_size_rule_says_how_to_override_it() {
        let evidence = |format, longest| Evidence { format, name: "part", header: "", longest };
        for (format, longest, unit) in [
            (Format::Obj, 0.09, Unit::Metre),
            (Format::Obj, 0.1, Unit::Millimetre),
            (Format::Stl, 1.9, Unit::Metre),
            (Format::Ply, 2.0, Unit::Millimetre),
        ] {
            let decision = decide(UnitChoice::Auto, &evidence(format, longest));
            assert_eq!(decision.unit, unit);
            assert!(decision.assumed && decision.reason.contains("--unit"), "{}", decision.reason);
        }
        let asked = decide(UnitChoice::Inch, &evidence(Format::Gltf, 1.0));
        assert_eq!((asked.unit, asked.assumed), (Unit::Inch, false));
    }
}
