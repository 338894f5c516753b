//! The table of dials: every number that can be requested of a weld, with its unit and the range accepted on any part.
//!
//! Limits that depend on a part or on other dials are checked by [`crate::WeldRequest::check`]. Flags, messages and
//! checks use the same rows.

use crate::bead::{MOST_DEFECTS, MOST_HOLES};
use crate::dial_fault::{shown, shown_mm};

/// A dial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dial {
    /// Name in messages, such as `ripple pitch`.
    pub name: &'static str,
    /// Name in flags and files, with the unit of lengths there, such as `ripple-pitch-mm`.
    pub key: &'static str,
    /// Unit of its values.
    pub unit: Unit,
    /// Least and greatest accepted value, both included.
    pub range: [f64; 2],
}

/// Unit of a dial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// A length: metres internally, millimetres in flags and files.
    Length,
    /// 1/m.
    PerMetre,
    /// Shares and counts.
    One,
    /// Bead widths.
    Widths,
    /// Bead heights.
    Heights,
}

/// All positive numbers.
pub const ABOVE_ZERO: [f64; 2] = [f64::from_bits(1), f64::MAX];
const SHARE: [f64; 2] = [0.0, 1.0];
/// Curvatures up to a limit that no part reaches.
const CURVATURES: [f64; 2] = [0.0, 1e4];

const fn length(name: &'static str, key: &'static str) -> Dial {
    Dial { name, key, unit: Unit::Length, range: ABOVE_ZERO }
}

const fn number(name: &'static str, key: &'static str, unit: Unit, range: [f64; 2]) -> Dial {
    Dial { name, key, unit, range }
}

const fn count(name: &'static str, key: &'static str, most: u32) -> Dial {
    Dial { name, key, unit: Unit::One, range: [0.0, most as f64] }
}

/// Length of the centreline.
pub const LENGTH: Dial = length("length", "length-mm");
/// Root mean square of the geodesic curvature.
pub const CURVATURE_RMS: Dial = number("curvature RMS", "curvature-per-m", Unit::PerMetre, CURVATURES);
/// Largest geodesic curvature.
pub const CURVATURE_MAX: Dial = number("curvature maximum", "curvature-max-per-m", Unit::PerMetre, CURVATURES);
/// Correlation length of the geodesic curvature.
pub const CORRELATION: Dial = length("correlation length", "correlation-mm");
/// Least exposure along the weld.
pub const EXPOSURE: Dial = number("exposure", "exposure", Unit::One, SHARE);
/// Distance beyond which the part does not reduce the exposure of a point.
pub const EXPOSURE_REACH: Dial = length("exposure reach", "exposure-reach-mm");
/// Radius of the tool whose access is measured.
pub const TOOL_RADIUS: Dial = length("tool radius", "access-radius-mm");
/// Width of this tool along its axis.
pub const TOOL_WIDTH: Dial = length("tool width", "access-width-mm");
/// Least mean share of this tool's poses without collision.
pub const LEAST_ACCESS: Dial = number("least access", "min-access", Unit::One, SHARE);
/// Width of the bead between its toes.
pub const WIDTH: Dial = length("width", "width-mm");
/// Height of the bead above the surface.
pub const HEIGHT: Dial = length("height", "height-mm");
/// Rise of a fillet's face above the chord between its toes.
pub const CONVEXITY: Dial = number("convexity", "convexity", Unit::Widths, [-0.2, 0.25]);
/// Length of each bead of an intermittent weld.
pub const STITCH_LENGTH: Dial = length("stitch length", "stitch-mm");
/// Distance from the start of one bead of an intermittent weld to the start of the next.
pub const STITCH_PITCH: Dial = length("stitch pitch", "stitch-pitch-mm");
/// Least radius of the toes in the distance field.
pub const TOE_RADIUS: Dial = length("toe radius", "toe-radius-mm");
/// Distance between ripples.
pub const RIPPLE_PITCH: Dial = length("ripple pitch", "ripple-pitch-mm");
/// Height of ripples from trough to crest.
pub const RIPPLE_HEIGHT: Dial = number("ripple height", "ripple-height", Unit::Heights, [0.0, 0.5]);
/// Distance by which ripples trail at the toes.
pub const RIPPLE_CHEVRON: Dial = number("ripple chevron", "ripple-chevron", Unit::Widths, [0.0, 1.0]);
/// Depth of the end crater.
pub const CRATER_DEPTH: Dial = number("crater depth", "crater", Unit::Heights, [0.0, 0.8]);
/// Height of the hump at the start, above the bead.
pub const START_HUMP: Dial = number("start hump", "start-hump", Unit::Heights, [0.0, 0.5]);
/// Greatest lateral offset of weaving.
pub const WEAVE: Dial = length("weave", "weave-mm");
/// Length of one oscillation of weaving.
pub const WEAVE_PITCH: Dial = length("weave pitch", "weave-pitch-mm");
/// Greatest slow change of the width.
pub const WIDTH_VARIATION: Dial = number("width variation", "width-variation", Unit::Widths, [0.0, 0.3]);
/// Greatest slow change of the height.
pub const HEIGHT_VARIATION: Dial = number("height variation", "height-variation", Unit::Heights, [0.0, 0.3]);
/// Depth of a sag of the crown.
pub const SAGGING: Dial = number("sagging", "sagging", Unit::Heights, [0.0, 0.7]);
/// Overhang of a lobe over a toe.
pub const OVERLAP: Dial = number("overlap", "overlap", Unit::Widths, [0.0, 0.3]);
/// Depth of a groove along a toe.
pub const UNDERCUT: Dial = number("undercut", "undercut", Unit::Heights, [0.0, 0.5]);
/// Number of surface pores.
pub const PORES: Dial = count("number of pores", "pores", MOST_DEFECTS);
/// Number of drops of spatter.
pub const SPATTER: Dial = count("number of drops of spatter", "spatter", MOST_DEFECTS);
/// Number of holes burnt through bead and part.
pub const BURN_THROUGH: Dial = count("number of burnt holes", "burn-through", MOST_HOLES);

/// All numeric dials, from the curve to the imperfections.
pub const DIALS: [Dial; 30] = [
    LENGTH,
    CURVATURE_RMS,
    CURVATURE_MAX,
    CORRELATION,
    EXPOSURE,
    EXPOSURE_REACH,
    TOOL_RADIUS,
    TOOL_WIDTH,
    LEAST_ACCESS,
    WIDTH,
    HEIGHT,
    CONVEXITY,
    STITCH_LENGTH,
    STITCH_PITCH,
    TOE_RADIUS,
    RIPPLE_PITCH,
    RIPPLE_HEIGHT,
    RIPPLE_CHEVRON,
    CRATER_DEPTH,
    START_HUMP,
    WEAVE,
    WEAVE_PITCH,
    WIDTH_VARIATION,
    HEIGHT_VARIATION,
    SAGGING,
    OVERLAP,
    UNDERCUT,
    PORES,
    SPATTER,
    BURN_THROUGH,
];

impl Dial {
    /// Returns the dial with this name in messages.
    pub fn named(name: &str) -> Option<&'static Self> {
        DIALS.iter().find(|dial| dial.name == name)
    }

    /// True if a value is within the accepted range; lengths may be in metres or in millimetres.
    pub fn accepts(&self, value: f64) -> bool {
        let [least, most] = self.range;
        (least..=most).contains(&value)
    }

    /// Formats a value [SI]; lengths with their unit.
    pub(crate) fn shown(&self, value: f64) -> String {
        if self.unit == Unit::Length { shown_mm(value) } else { shown(value) }
    }

    /// Returns the unit of the flag's values in brackets; empty for shares and counts.
    pub fn flag_unit(&self) -> &'static str {
        match self.unit {
            Unit::Length => "[mm]",
            Unit::PerMetre => "[1/m]",
            Unit::One => "",
            Unit::Widths => "[bead widths]",
            Unit::Heights => "[bead heights]",
        }
    }

    /// Formats the accepted range.
    pub fn accepted(&self) -> String {
        let [least, most] = self.range;
        match self.range {
            ABOVE_ZERO => "above zero".to_owned(),
            _ => format!("within {least} to {most}{}", self.unit.suffix()),
        }
    }
}

impl Unit {
    /// Unit after a value in messages; empty for lengths, which are formatted in millimetres with their unit.
    pub(crate) fn suffix(self) -> &'static str {
        match self {
            Self::Length | Self::One => "",
            Self::PerMetre => " 1/m",
            Self::Widths => " widths",
            Self::Heights => " heights",
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn names_and_keys_are_distinct_and_keys_tell_the_unit() {
        let distinct = |word: fn(&Dial) -> &'static str| DIALS.iter().map(word).collect::<BTreeSet<_>>().len();
        assert_eq!([distinct(|dial| dial.name), distinct(|dial| dial.key)], [DIALS.len(); 2]);
        for dial in &DIALS {
            assert_eq!(dial.key.ends_with("-mm"), dial.unit == Unit::Length, "{}", dial.key);
            assert_eq!(dial.key.ends_with("-per-m"), dial.unit == Unit::PerMetre, "{}", dial.key);
            assert_eq!(Dial::named(dial.name), Some(dial));
        }
    }

    #[test]
    fn what_is_accepted_is_told_in_words() {
        assert!(
            WIDTH.accepts(1e-300) && [0.0, -1.0, f64::INFINITY, f64::NAN].iter().all(|&width| !WIDTH.accepts(width))
        );
        assert!([-0.2, 0.25].iter().all(|&rise| CONVEXITY.accepts(rise)) && !CONVEXITY.accepts(0.26));
        assert_eq!(WIDTH.accepted(), "above zero");
        assert_eq!(LEAST_ACCESS.accepted(), "within 0 to 1");
        assert_eq!(CONVEXITY.accepted(), "within -0.2 to 0.25 widths");
    }
}
