//! Form deviations of manual beads: ripples, craters, weaving, slow changes of width and height.
//!
//! Every deviation is a function of the position on the bead. Heights above the toes are multiplied by a positive
//! factor, and lateral offsets are scaled and shifted. So the toes stay on the surface and the bead does not intersect
//! itself.

use std::f64::consts::{PI, TAU};

use rand::RngExt;
use serde::Serialize;

use super::defect::{Defect, DefectKind, overlap, pores, sag};
use crate::curvature::CurvatureProfile;
use crate::dial_fault::{DialFault, shown, shown_mm};
use crate::dials::{
    BURN_THROUGH, CRATER_DEPTH, Dial, HEIGHT_VARIATION, OVERLAP, PORES, RIPPLE_CHEVRON, RIPPLE_HEIGHT, RIPPLE_PITCH,
    SAGGING, SPATTER, START_HUMP, UNDERCUT, WEAVE, WEAVE_PITCH, WIDTH_VARIATION,
};

/// Least factor of the crown's height after ripples, crater and variation.
const LEAST_HEIGHT: f64 = 0.1;

/// Greatest number of pores of a bead, and of drops of spatter.
pub const MOST_DEFECTS: u32 = 1000;
/// Greatest number of burnt holes of a bead.
pub const MOST_HOLES: u32 = 10;

/// Greatest width of an undercut's groove [bead widths].
pub(crate) const WIDEST_GROOVE: f64 = 0.3;
/// Height of an overlap's lobe above the toes [bead heights].
const LOBE_HEIGHT: f64 = 0.5;

/// Ripples: the solidified edges of the weld pool.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Ripples {
    /// Distance between ripples along the weld [m].
    pub pitch: f64,
    /// Height from trough to crest [bead heights].
    pub height: f64,
    /// Distance by which a ripple trails at the toes [bead widths]: 0 is straight across, 0.5 a half circle.
    pub chevron: f64,
}

/// The crater where the arc was extinguished, and the hump where it was struck.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Crater {
    /// Depth at the end of the weld [bead heights] (ISO 6520-1: 2025, end crater pipe or crater).
    pub depth: f64,
    /// Height of the hump at the start, above the bead [bead heights].
    pub hump: f64,
}

/// Weaving of the torch across the seam.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Weave {
    /// Greatest lateral offset [m].
    pub amplitude: f64,
    /// Length of one oscillation along the weld [m].
    pub pitch: f64,
}

/// Requested form of a bead; all `None` and 0 is a plain bead.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct FormRequest {
    /// Ripples.
    pub ripples: Option<Ripples>,
    /// End crater and start.
    pub crater: Option<Crater>,
    /// Weaving.
    pub weave: Option<Weave>,
    /// Greatest slow change of the width [widths].
    pub width_variation: f64,
    /// Greatest slow change of the height [heights].
    pub height_variation: f64,
    /// Number of surface pores.
    pub pores: u32,
    /// Depth of a sag [heights]; 0 for none.
    pub sagging: f64,
    /// Number of drops of spatter.
    pub spatter: u32,
    /// Overhang of a lobe over a toe [widths]; 0 for none.
    pub overlap: f64,
    /// Depth of a groove along a toe [heights]; 0 for none.
    pub undercut: f64,
    /// Number of holes through bead and part.
    pub burn_through: u32,
}

/// The form of one bead.
#[derive(Clone, Debug, PartialEq)]
pub struct BeadForm {
    request: FormRequest,
    /// Length of the centreline and width of the bead [m].
    size: [f64; 2],
    /// Slow changes of width and height, between -1 and 1.
    slow: [CurvatureProfile; 2],
    /// Pores, sags and overlaps.
    defects: Vec<Defect>,
    height: f64,
}

impl FormRequest {
    /// Checks all values of the request for a bead of a given width [m].
    ///
    /// # Errors
    /// The first value that is out of range.
    pub fn check(&self, width: f64) -> Result<(), DialFault> {
        let lengths = self.lengths(width).into_iter().map(|(Dial { name: dial, .. }, length, [low, high])| {
            let (lowest, highest) = (shown_mm(low * width), shown_mm(high * width));
            let widths = format!("{} to {} widths", shown(low), shown(high));
            let good = (low * width..=high * width).contains(&length);
            (good, DialFault { dial, found: shown_mm(length), accepted: format!("{lowest} to {highest}, {widths}") })
        });
        let shares = self.shares().into_iter().map(|(dial, value)| {
            let (unit, [low, high]) = (dial.unit.suffix(), dial.range.map(shown));
            let found = format!("{}{unit}", shown(value));
            (dial.accepts(value), DialFault { dial: dial.name, found, accepted: format!("{low} to {high}{unit}") })
        });
        lengths.chain(shares).find(|(good, _)| !good).map_or(Ok(()), |(_, fault)| Err(fault))
    }

    /// Requested lengths [m] with their accepted ranges [bead widths].
    fn lengths(&self, width: f64) -> Vec<(Dial, f64, [f64; 2])> {
        let mut lengths = Vec::new();
        if let Some(ripples) = self.ripples {
            lengths.push((RIPPLE_PITCH, ripples.pitch, [0.25, 10.0]));
        }
        if let Some(Weave { amplitude, pitch }) = self.weave {
            lengths.push((WEAVE, amplitude, [0.0, 0.5]));
            // With steeper oscillations the bead would fold over.
            lengths.push((WEAVE_PITCH, pitch, [1.5 + TAU * amplitude / width, 1e3]));
        }
        lengths
    }

    /// Requested shares and counts.
    fn shares(&self) -> [(Dial, f64); 12] {
        let Ripples { height, chevron, .. } = self.ripples.unwrap_or(Ripples { pitch: 0.0, height: 0.0, chevron: 0.0 });
        let Crater { depth, hump } = self.crater.unwrap_or(Crater { depth: 0.0, hump: 0.0 });
        let [pores, spatter, holes] = [self.pores, self.spatter, self.burn_through].map(f64::from);
        [
            (RIPPLE_HEIGHT, height),
            (RIPPLE_CHEVRON, chevron),
            (CRATER_DEPTH, depth),
            (START_HUMP, hump),
            (WIDTH_VARIATION, self.width_variation),
            (HEIGHT_VARIATION, self.height_variation),
            (SAGGING, self.sagging),
            (OVERLAP, self.overlap),
            (UNDERCUT, self.undercut),
            (BURN_THROUGH, holes),
            (PORES, pores),
            (SPATTER, spatter),
        ]
    }

    /// Greatest distance from the centreline [m] that a point at this nominal distance [m] can reach.
    pub(crate) fn half_reach(&self, half_width: f64) -> f64 {
        let groove = if self.undercut > 0.0 { WIDEST_GROOVE } else { 0.0 };
        let beside = 2.0 * self.overlap.max(groove);
        (1.0 + self.width_variation + beside) * half_width + self.weave.map_or(0.0, |weave| weave.amplitude)
    }
}

impl BeadForm {
    /// Draws the form of a bead of given length, width and height [m].
    ///
    /// Slow changes are random, with a correlation length of three widths.
    pub fn new(request: FormRequest, size @ [length, width, height]: [f64; 3], rng: &mut impl RngExt) -> Self {
        let reach = length + width;
        let mut slow = || CurvatureProfile::random(reach, 3.0 * width, rng).limited_to(0.5, 1.0, [0.0, length]);
        let slow = [slow(), slow()];
        let mut defects = pores(request.pores, size, rng);
        defects.extend(sag(request.sagging, size, rng));
        defects.extend(overlap(request.overlap, size, rng));
        Self { request, size: [length, width], slow, defects, height }
    }

    /// Pores, sags and overlaps relative to the bead's outline, before weaving and width variation.
    pub fn defects(&self) -> &[Defect] {
        &self.defects
    }

    /// Pores, sags and overlaps at their actual offsets from the centreline.
    pub fn made_defects(&self) -> Vec<Defect> {
        let made = |defect: &Defect| Defect { offset: self.made_offset(defect.arc_length, defect.offset), ..*defect };
        self.defects.iter().map(made).collect()
    }

    /// Actual offset to the left of the centreline [m] of a point of the bead's outline, at an arc length [m].
    pub(crate) fn made_offset(&self, s: f64, outline_offset: f64) -> f64 {
        self.shift(s) + self.width_factor(s) * outline_offset
    }

    /// Greatest distance from the centreline [m] that a point at this nominal distance [m] can reach.
    pub(crate) fn half_reach(&self, half_width: f64) -> f64 {
        self.request.half_reach(half_width)
    }

    /// Factor on the width at an arc length [m].
    pub fn width_factor(&self, s: f64) -> f64 {
        1.0 + self.request.width_variation * self.slow[0].at(s)
    }

    /// Factor on the height at an arc length [m], without ripples.
    pub fn height_factor(&self, s: f64) -> f64 {
        1.0 + self.request.height_variation * self.slow[1].at(s)
    }

    /// Shift of the bead to the left at an arc length [m]; it fades in over the first half width and out over the last.
    pub fn shift(&self, s: f64) -> f64 {
        let [length, width] = self.size;
        let fade = (2.0 * s.min(length - s) / width).clamp(0.0, 1.0);
        self.request.weave.map_or(0.0, |weave| fade * weave.amplitude * (TAU * s / weave.pitch).sin())
    }

    /// Factor on the height above the toes at a position: arc length [m], also beyond the ends, and lateral offset [m]
    /// before scaling.
    pub fn relief(&self, s: f64, y: f64) -> f64 {
        let [length, width] = self.size;
        let mut factor = self.height_factor(s.clamp(0.0, length));
        if let Some(Crater { depth, hump }) = self.request.crater {
            let bell = |x: f64, radius: f64| (-0.5 * (x * x + y * y) / (radius * radius)).exp();
            factor *= 1.0 - depth * bell(s - length, 0.25 * width) + hump * bell(s, 0.4 * width);
        }
        if let Some(Ripples { pitch, height, chevron }) = self.request.ripples {
            let trail = chevron * width * (2.0 * y / width).powi(2);
            let phase = ((s + trail) / pitch).rem_euclid(1.0);
            // Ripples rise slowly and fall steeply behind: half a sine, skewed backwards.
            factor *= 1.0 + height * ((PI * phase.powf(RIPPLE_SKEW)).sin() - 0.5);
        }
        for defect in &self.defects {
            let (along, across) =
                (2.0 * (s - defect.arc_length) / defect.size, 2.0 * (y - defect.offset) / defect.size);
            factor -= defect.depth / self.height
                * match defect.kind {
                    DefectKind::SurfacePore => (1.0 - along * along - across * across).max(0.0).sqrt(),
                    DefectKind::Sagging => defect.swell(s),
                    _ => 0.0,
                };
        }
        factor.max(LEAST_HEIGHT)
    }

    /// Shift to the left [m] of an outline point at an offset y and a height above the toes [m]: lobes that overhang a
    /// toe.
    ///
    /// ```text
    ///      '-.
    ///         '-.__
    ///          .___)   lobe, with its greatest overhang at a quarter of the bead's height
    ///   ------o----------
    /// ```
    pub fn lobe(&self, s: f64, y: f64, above: f64) -> f64 {
        let share = (above / (LOBE_HEIGHT * self.height)).clamp(0.0, 1.0);
        let out = |defect: &Defect| {
            let beyond = (0.5 * self.size[1] - y.abs()).max(0.0) + defect.depth;
            y.signum() * (PI * share).sin() * defect.swell(s) * beyond
        };
        let hangs = |defect: &&Defect| defect.kind == DefectKind::Overlap && defect.offset * y > 0.0;
        self.defects.iter().filter(hangs).map(out).sum()
    }
}

/// Skew exponent of ripples; below 1 the crest moves towards the weld's start.
const RIPPLE_SKEW: f64 = 0.7;
