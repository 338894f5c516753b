//! Names of the looks of a photograph.

use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Name for no look at all.
pub const NO_LOOKS: &str = "none";

/// A name that no look has.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("{0}: {names} is accepted", names = Look::names())]
pub struct UnknownLook(pub String);

/// A look that can be left out, to measure what it teaches.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Look {
    /// Stains and orange peel on the workpiece, grain or stains on the table.
    Texture,
    /// Arcs of the pad's orbit on the sanded metal.
    Swirl,
    /// A primer that shows where little coating is left.
    Primer,
    /// Luminous panels that glossy surfaces mirror.
    Studio,
    /// Defocus, motion, vignetting, colour balance.
    Optics,
    /// Losses of JPEG.
    Compression,
    /// A glossy coating.
    ClearCoat,
    /// Dust on workpiece and table.
    Dust,
    /// Things beside, on and before the workpiece.
    Clutter,
    /// Interference colours of the oxide around welds.
    HeatTint,
    /// Rust and mill scale on bare metal.
    Rust,
    /// Droplets of weld metal beside the welds.
    Spatter,
    /// A table of boards, brushed steel or cloth.
    Table,
    /// The tool over or on the workpiece.
    Tool,
}

impl Look {
    /// All looks.
    pub const ALL: [Self; 14] = [
        Self::Texture,
        Self::Swirl,
        Self::Primer,
        Self::Studio,
        Self::Optics,
        Self::Compression,
        Self::ClearCoat,
        Self::Dust,
        Self::Clutter,
        Self::HeatTint,
        Self::Rust,
        Self::Spatter,
        Self::Table,
        Self::Tool,
    ];

    /// Returns the name in flags and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Texture => "texture",
            Self::Swirl => "swirl",
            Self::Primer => "primer",
            Self::Studio => "studio",
            Self::Optics => "optics",
            Self::Compression => "compression",
            Self::ClearCoat => "clear-coat",
            Self::Dust => "dust",
            Self::Clutter => "clutter",
            Self::HeatTint => "heat-tint",
            Self::Rust => "rust",
            Self::Spatter => "spatter",
            Self::Table => "table",
            Self::Tool => "tool",
        }
    }

    /// Returns a short description for the help.
    pub fn about(self) -> &'static str {
        match self {
            Self::Texture => "stains, orange peel, grain of the table",
            Self::Swirl => "arcs of the pad's orbit on sanded metal",
            Self::Primer => "a primer below the coating",
            Self::Studio => "luminous panels mirrored by glossy surfaces",
            Self::Optics => "defocus, motion, vignetting, colour balance",
            Self::Compression => "losses of JPEG",
            Self::ClearCoat => "a glossy coating",
            Self::Dust => "dust on workpiece and table",
            Self::Clutter => "things beside, on and before the workpiece",
            Self::HeatTint => "interference colours around welds",
            Self::Rust => "rust and mill scale on bare metal",
            Self::Spatter => "droplets beside the welds",
            Self::Table => "boards, brushed steel, cloth",
            Self::Tool => "a pad or wheel over or on the workpiece",
        }
    }

    /// Returns the names that are accepted, for a message.
    pub fn names() -> String {
        Self::ALL.map(Self::name).join(", ") + ", or " + NO_LOOKS + " alone"
    }

    /// Returns the looks of these names in their order; all of them if there is no name.
    ///
    /// # Errors
    /// [`UnknownLook`] for a name that no look has.
    pub fn chosen(names: &[String]) -> Result<Vec<Self>, UnknownLook> {
        match names {
            [] => return Ok(Self::ALL.to_vec()),
            [name] if name == NO_LOOKS => return Ok(Vec::new()),
            _ => {}
        }
        let of = |name: &String| {
            let found = Self::ALL.into_iter().find(|look| look.name() == name);
            found.ok_or_else(|| UnknownLook(name.clone()))
        };
        let mut looks = names.iter().map(of).collect::<Result<Vec<Self>, _>>()?;
        looks.sort_unstable();
        looks.dedup();
        Ok(looks)
    }

    /// Returns these looks as [`Look::chosen`] takes them, separated by commas.
    pub fn listed(looks: &[Self]) -> String {
        let names: Vec<&str> = looks.iter().map(|look| look.name()).collect();
        if names.is_empty() { NO_LOOKS.to_owned() } else { names.join(",") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn looks_are_found_by_name_in_their_order() {
        let chosen = |names: &[&str]| Look::chosen(&names.iter().map(|&name| name.to_owned()).collect::<Vec<_>>());
        assert_eq!(chosen(&[]), Ok(Look::ALL.to_vec()));
        assert_eq!(chosen(&["none"]), Ok(Vec::new()));
        assert_eq!(chosen(&["rust", "swirl", "rust"]), Ok(vec![Look::Swirl, Look::Rust]));
        let message = chosen(&["swirl", "none"]).unwrap_err().to_string();
        assert!(message.starts_with("none: texture, swirl") && message.ends_with("tool, or none alone is accepted"));
        for looks in [&Look::ALL[..], &[Look::Dust], &[]] {
            let words: Vec<String> = Look::listed(looks).split(',').map(str::to_owned).collect();
            assert_eq!(Look::chosen(&words), Ok(looks.to_vec()));
        }
    }
}
