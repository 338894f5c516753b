//! Reasons why proposals do not fit, and their counts.

use std::collections::BTreeMap;
use std::fmt;

use serde::Serialize;

use crate::trace::TraceEnd;

/// Reason why a proposal was rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rejection {
    /// Sharp edges on both sides leave too short a run.
    SharpEdge,
    /// The surface ends on both sides of too short a run.
    Boundary,
    /// Edges with more than two faces, or faces of opposite orientation, leave too short a run.
    NonManifold,
    /// Faces without area, or too many faces in the way.
    BadFaces,
    /// The surface bends too tightly along the curve.
    Bend,
    /// The curve comes too close to itself.
    OwnPass,
    /// A hole or a cliff under the bead.
    Hole,
    /// A wall or a rise of the surface under or beside the bead.
    Wall,
    /// The surface beside the curve tilts too much.
    Tilt,
    /// The surface curves away so much that the root would be too deep.
    DeepRoot,
    /// The part is too thin for the root.
    Thin,
    /// The part is too thick to burn through.
    Thick,
    /// The surface is concave along a butt joint.
    Hollow,
    /// The face is hidden inside the part or turned inwards.
    Inside,
    /// Exposure below the range.
    Exposure,
    /// Exposure above the range.
    TooOpen,
    /// Too few tool poses without collision.
    Access,
    /// Facing down, while a proposal that does not face down fits.
    Overhead,
    /// Too close to another weld.
    OtherWeld,
    /// Neighbouring sections of the bead would cross.
    Fold,
}

impl Rejection {
    /// Rejection of a run that was cut short by `end`.
    pub(crate) fn cut_short(end: TraceEnd) -> Self {
        match end {
            TraceEnd::Sharp => Self::SharpEdge,
            TraceEnd::Boundary => Self::Boundary,
            TraceEnd::NonManifold => Self::NonManifold,
            TraceEnd::Hollow => Self::Hollow,
            TraceEnd::Length | TraceEnd::Degenerate | TraceEnd::Steps => Self::BadFaces,
        }
    }

    /// Explanation, with the dial that changes it.
    fn explain(self) -> &'static str {
        match self {
            Self::SharpEdge => {
                "met a sharp edge before the length was reached (shorter length, narrower bead, larger sharp angle)"
            }
            Self::Boundary => {
                "met the end of the surface before the length was reached (shorter length, narrower bead, closed part)"
            }
            Self::NonManifold => "met a non-manifold edge before the length was reached (shorter length, cleaner mesh)",
            Self::BadFaces => "met faces without area (cleaner mesh)",
            Self::Bend => "ran over a surface that bends too tightly for the bead (narrower bead)",
            Self::OwnPass => "came back to itself closer than the bead (lower curvature, shorter length)",
            Self::Hole => "had a hole or cliff under the bead (narrower bead)",
            Self::Wall => "had a wall beside the bead (narrower bead)",
            Self::Tilt => "had a surface that tilts away under the bead (narrower bead)",
            Self::DeepRoot => "needed a root deeper than the bead is high (narrower bead)",
            Self::Thin => "were on a sheet thinner than the root (narrower bead)",
            Self::Thick => "were on ground thicker than a bead's width, which does not burn through (wider bead)",
            Self::Hollow => "met a hollow before the length of the butt joint was reached (shorter length)",
            Self::Inside => "lay on faces inside the part or turned inwards (cleaner mesh)",
            Self::Exposure => "saw too little of the sky (lower least exposure)",
            Self::TooOpen => "saw too much of the sky (higher largest exposure)",
            Self::Access => "left the tool too few free poses (lower least access, smaller tool)",
            Self::Overhead => "faced down (another side of the part upwards)",
            Self::OtherWeld => "came too near to another weld (fewer welds, smaller gap)",
            Self::Fold => "turned too tightly for the bead (lower curvature, narrower bead)",
        }
    }
}

/// Number of rejected proposals by reason.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Tally(BTreeMap<Rejection, usize>);

impl Tally {
    pub(crate) fn count(&mut self, rejection: Rejection) {
        *self.0.entry(rejection).or_default() += 1;
    }

    /// Number of rejected proposals.
    pub fn total(&self) -> usize {
        self.0.values().sum()
    }

    /// Number of proposals rejected for one reason.
    pub fn of(&self, rejection: Rejection) -> usize {
        self.0.get(&rejection).copied().unwrap_or(0)
    }
}

impl fmt::Display for Tally {
    /// Writes the reasons, most frequent first.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut rows: Vec<(Rejection, usize)> = self.0.iter().map(|(reason, count)| (*reason, *count)).collect();
        rows.sort_by_key(|&(reason, count)| (std::cmp::Reverse(count), reason));
        for (i, (reason, count)) in rows.iter().enumerate() {
            write!(f, "{}{count} {}", if i == 0 { "" } else { "; " }, reason.explain())?;
        }
        Ok(())
    }
}
