//! A request for a weld: its dials.

use sdf_bake::Mesh;
use serde::{Deserialize, Serialize};

use crate::access::ToolShape;
use crate::bead::{BeadShape, FormRequest};
use crate::dial_fault::{DialFault, shown, shown_mm};
use crate::dials::{
    ABOVE_ZERO, CONVEXITY, CORRELATION, CURVATURE_MAX, CURVATURE_RMS, Dial, EXPOSURE, EXPOSURE_REACH, HEIGHT,
    LEAST_ACCESS, LENGTH, OVERLAP, STITCH_LENGTH, STITCH_PITCH, TOOL_RADIUS, TOOL_WIDTH, Unit, WIDTH,
};
use crate::difficulty::Difficulty;

/// Voxels per diagonal of the part, for the voxel that is usually given to [`WeldRequest::for_part`].
pub const VOXELS_PER_DIAGONAL: f64 = 256.0;

/// Least bead width that baking resolves [voxels].
const VOXELS_PER_WIDTH: f64 = 12.0;
/// Width of an ordinary bead [m].
const ORDINARY_WIDTH: f64 = 0.010;
/// Greatest ratio of the curvature's root mean square to its maximum; a limited curve comes no closer.
const MOST_RMS: f64 = 0.95;
/// Least length of a weld [bead widths].
pub(crate) const WIDTHS_PER_LENGTH: f64 = 3.0;

/// Location of a weld.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Placement {
    /// On a smooth surface.
    #[default]
    Surface,
    /// In a concave edge, as a fillet weld; the geometry of the edge gives the curvature.
    Seam,
    /// Along a plane cut through a smooth surface without concave edges, as a butt joint of two halves; the part gives
    /// the curvature.
    Butt,
    /// Along a seam or on a smooth surface, drawn with the seed; on the other if the first has no space.
    Mixed,
}

/// Kind of joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Joint {
    /// A bead on a plate, without a joint.
    BeadOnPlate,
    /// A fillet weld between two walls of a corner.
    Fillet,
    /// A butt weld between two halves that meet in a plane.
    Butt,
}

/// Dimensions of an intermittent weld.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Stitch {
    /// Length of a bead [m].
    pub length: f64,
    /// Distance from the start of one bead to the start of the next [m].
    pub pitch: f64,
}

/// Request for a weld. Ranges are inclusive; length and curvature are drawn from theirs with the seed.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WeldRequest {
    /// Length of the centreline [m].
    pub length: [f64; 2],
    /// Root mean square of the geodesic curvature over the curve [1/m].
    pub curvature_rms: [f64; 2],
    /// Greatest geodesic curvature [1/m]; the root mean square must stay below 0.95 of it.
    pub curvature_max: f64,
    /// Correlation length of the geodesic curvature [m]; `None` for half the length of the weld.
    pub correlation: Option<f64>,
    /// Width of the bead [m].
    pub width: f64,
    /// Height of the bead [m].
    pub height: f64,
    /// Location of the weld.
    pub placement: Placement,
    /// Cross-section of a weld on a face.
    pub shape: BeadShape,
    /// Rise of a fillet's face above the chord between its toes [widths]; concave below 0.
    pub convexity: f64,
    /// Form deviations, such as ripples and craters.
    pub form: FormRequest,
    /// Intermittent weld with beads of this length and pitch [m], instead of one bead along the whole curve.
    pub stitch: Option<Stitch>,
    /// Range of the least exposure along the curve, in [0, 1].
    pub exposure: [f64; 2],
    /// Distance beyond which nothing occludes [m].
    pub exposure_reach: f64,
    /// The tool whose access is measured.
    pub tool: ToolShape,
    /// Least mean tool access along the curve, in [0, 1].
    pub min_access: f64,
    /// Edges whose normals differ by more than this [rad] are not crossed.
    pub sharp_angle: f64,
    /// Distance to other welds, from base to base [m].
    pub gap: f64,
    /// Proposals tried at each stage.
    pub attempts: usize,
    /// True if less may be tried when nothing fits: a different exposure, a shorter weld, then a smaller bead (see
    /// [`crate::place::STAGES`]).
    pub may_shrink: bool,
    /// Default choices, with reasons, as sentences.
    pub reasons: Vec<String>,
}

impl WeldRequest {
    /// Request of medium difficulty from [`WeldRequest::of_difficulty`].
    pub fn for_part(part: &Mesh, voxel: f64) -> Self {
        Self::of_difficulty(part, voxel, Difficulty::Medium)
    }

    /// Request with dials suited to a part.
    ///
    /// - `voxel`: voxel [m] of the later baking; diagonal / [`VOXELS_PER_DIAGONAL`] if undecided
    ///
    /// The bead is 10 mm wide, or 1/20 of the diagonal if that is less, but at least 12 voxels; its height is 0.3 times
    /// its width. Lengths are shares of the diagonal, and at least three widths. Curvatures are multiples of
    /// 1/diagonal, and at most half of 1/width.
    pub fn of_difficulty(part: &Mesh, voxel: f64, difficulty: Difficulty) -> Self {
        let diagonal = part.diagonal();
        let ([lengths, curvatures, exposure], sharpest) = difficulty.dials();
        let (width, why) = bead_width(diagonal, voxel);
        let height = 0.3 * width;
        let length = lengths.map(|share| (share * diagonal).max(WIDTHS_PER_LENGTH * width));
        let curvature_max = (sharpest / diagonal).min(0.5 / width);
        let mm = |x: f64| 1e3 * x;
        let [short, long] = length.map(mm);
        let [least, most] = lengths;
        let reasons = vec![
            format!("bead width {:.3} mm: {why}; height {:.3} mm: 0.3 of the width", mm(width), mm(height)),
            format!(
                "length {short:.2} to {long:.2} mm: {least} to {most} of the part's diagonal of {:.2} mm, at least 3 widths",
                mm(diagonal)
            ),
        ];
        Self {
            length,
            curvature_rms: curvatures.map(|c| (c / diagonal).min(MOST_RMS * curvature_max)),
            curvature_max,
            correlation: None,
            width,
            height,
            placement: Placement::Surface,
            shape: BeadShape::Parabolic,
            convexity: 0.0,
            form: FormRequest::default(),
            stitch: None,
            exposure,
            exposure_reach: 0.25 * diagonal,
            tool: ToolShape::default(),
            min_access: 0.0,
            sharp_angle: 35f64.to_radians(),
            gap: width,
            attempts: 256,
            may_shrink: true,
            reasons,
        }
    }

    /// Checks every dial before the part is examined.
    ///
    /// # Errors
    /// The first dial that is out of range.
    pub fn check(&self) -> Result<(), DialFault> {
        let checks = self.curve_checks().into_iter().chain(self.bead_checks());
        match checks.into_iter().find(|(_, _, good, _)| !good) {
            Some((dial, found, _, accepted)) => Err(DialFault { dial, found, accepted }),
            None => self.form.check(self.width),
        }
    }

    fn curve_checks(&self) -> Vec<DialCheck> {
        let ordered = |[low, high]: [f64; 2], least: f64| low >= least && high >= low && high.is_finite();
        let range = |dial: &Dial, [low, high]: [f64; 2], good, want: &str| {
            let [low, high] = [low, high].map(|end| dial.shown(end));
            (dial.name, if low == high { low } else { format!("{low} to {high}") }, good, want.to_owned())
        };
        let (rms, max) = (self.curvature_rms, self.curvature_max);
        let correlation = self.correlation.unwrap_or(self.width);
        let most_rms = format!("at most {} 1/m, 0.95 of the curvature maximum", shown(MOST_RMS * max));
        let half_width = format!("at least {}, half the bead's width", shown_mm(0.5 * self.width));
        let open = self.exposure.iter().all(|&share| EXPOSURE.accepts(share));
        vec![
            range(&LENGTH, self.length, ordered(self.length, f64::MIN_POSITIVE), "above zero, the lower first"),
            range(&CURVATURE_RMS, rms, ordered(rms, 0.0), "0 or more, the lower first"),
            related(&CURVATURE_MAX, max, max >= 0.0, "0 or more"),
            range(&CURVATURE_RMS, rms, rms[1] <= MOST_RMS * max, &most_rms),
            related(&CORRELATION, correlation, correlation >= 0.5 * self.width, &half_width),
            range(&EXPOSURE, self.exposure, open, &EXPOSURE.accepted()),
            range(&EXPOSURE, self.exposure, ordered(self.exposure, 0.0), "a range, the lower first"),
            plain(&EXPOSURE_REACH, self.exposure_reach),
            plain(&TOOL_RADIUS, self.tool.radius),
            plain(&TOOL_WIDTH, self.tool.width),
            plain(&LEAST_ACCESS, self.min_access),
            plain(&SHARP_ANGLE, self.sharp_angle),
            related(&GAP, self.gap, self.gap >= 0.0, "0 or more"),
            related(&ATTEMPTS, self.attempts as f64, self.attempts > 0, "at least 1"),
        ]
    }

    fn bead_checks(&self) -> Vec<DialCheck> {
        let round = self.shape != BeadShape::CircularSegment || self.height <= 0.5 * self.width;
        let fillets = matches!(self.placement, Placement::Seam | Placement::Mixed);
        let lobed = self.form.overlap == 0.0 || !fillets;
        let half = format!("at most {}, half of the width, for a circular segment", shown_mm(0.5 * self.width));
        let mut checks = vec![
            plain(&WIDTH, self.width),
            plain(&HEIGHT, self.height),
            related(&HEIGHT, self.height, round, &half),
            (
                "shape",
                "fillet".to_owned(),
                self.shape != BeadShape::Fillet,
                "one for faces; fillets are for seams".to_owned(),
            ),
            related(&OVERLAP, self.form.overlap, lobed, "0 where fillets may be laid: they have no lobes"),
            plain(&CONVEXITY, self.convexity),
        ];
        if let Some(Stitch { length, pitch }) = self.stitch {
            let least = length + 1.5 * self.width;
            let long = format!("at least {}, the bead's width", shown_mm(self.width));
            let apart = format!("at least {}, the stitch and 1.5 widths", shown_mm(least));
            checks.push(related(&STITCH_LENGTH, length, length >= self.width, &long));
            checks.push(related(&STITCH_PITCH, pitch, pitch >= least, &apart));
        }
        checks
    }
}

/// Dial of the sharp angle, which users cannot set; used for checks only.
const SHARP_ANGLE: Dial = Dial { name: "sharp angle", key: "", unit: Unit::One, range: ABOVE_ZERO };
const GAP: Dial = Dial { name: "gap", key: "", unit: Unit::Length, range: ABOVE_ZERO };
const ATTEMPTS: Dial = Dial { name: "number of attempts", key: "", unit: Unit::One, range: ABOVE_ZERO };

/// Checks a dial against its row of the table.
fn plain(dial: &Dial, value: f64) -> DialCheck {
    (dial.name, dial.shown(value), dial.accepts(value), dial.accepted())
}

/// Checks a dial against others.
fn related(dial: &Dial, value: f64, good: bool, want: &str) -> DialCheck {
    (dial.name, dial.shown(value), good, want.to_owned())
}

/// Name of a dial, its value, true if it is accepted, and the accepted values.
type DialCheck = (&'static str, String, bool, String);

/// Bead width [m] suited to a part, and the reason.
fn bead_width(diagonal: f64, voxel: f64) -> (f64, String) {
    let small = ORDINARY_WIDTH.min(diagonal / 20.0);
    let width = small.max(VOXELS_PER_WIDTH * voxel);
    let why = match (small < ORDINARY_WIDTH, width > small) {
        (_, true) => format!("{VOXELS_PER_WIDTH} voxels of {:.4} mm, so that the bake resolves it", 1e3 * voxel),
        (true, false) => "1/20 of the part's diagonal".to_owned(),
        (false, false) => "an ordinary bead".to_owned(),
    };
    (width, why)
}
