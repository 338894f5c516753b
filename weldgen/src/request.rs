//! What is asked of a weld: the dials.

use sdf_bake::Mesh;
use serde::Serialize;

/// The voxel that [`WeldRequest::for_part`] is usually given is the part's diagonal over this.
pub const VOXELS_PER_DIAGONAL: f64 = 256.0;

/// A bead narrower than this many voxels is not resolved by the bake.
const VOXELS_PER_WIDTH: f64 = 12.0;
/// Width [m] of an ordinary bead.
const ORDINARY_WIDTH: f64 = 0.010;
/// Least length of a weld, in bead widths.
pub(crate) const WIDTHS_PER_LENGTH: f64 = 3.0;

/// What is asked of a weld.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WeldRequest {
    /// Length of the centreline [m]; `None` lets the seed choose from `length_range`.
    pub length: Option<f64>,
    /// Lengths [m] to choose from.
    pub length_range: [f64; 2],
    /// Root mean square of the geodesic curvature over the curve [1/m].
    pub curvature_rms: f64,
    /// Largest geodesic curvature [1/m]; it scales the whole curve's curvature down where the two disagree.
    pub curvature_max: f64,
    /// Width of the bead [m].
    pub width: f64,
    /// Height of the bead [m].
    pub height: f64,
    /// Least exposure along the curve, in [0, 1].
    pub min_exposure: f64,
    /// What lies farther than this [m] hides nothing.
    pub exposure_reach: f64,
    /// Edges whose normals differ by more than this [rad] are not crossed.
    pub sharp_angle: f64,
    /// Proposals tried at each stage.
    pub attempts: usize,
    /// Whether a shorter weld, then a smaller bead, may be tried when nothing fits (see [`crate::place::STAGES`]).
    pub may_shrink: bool,
    /// What was chosen by default, and why, in sentences.
    pub reasons: Vec<String>,
}

impl WeldRequest {
    /// Defaults that suit a part.
    ///
    /// - `voxel`: voxel [m] of the bake to come; diagonal / [`VOXELS_PER_DIAGONAL`] when undecided
    ///
    /// The bead is 10 mm wide, or 1/20 of the diagonal where that is less, but never narrower than 12 voxels; it is 0.3
    /// times as high as wide. The length is 1/4 to 1/2 of the diagonal and at least three widths. The curve turns by
    /// about one radian over a third of the diagonal.
    pub fn for_part(part: &Mesh, voxel: f64) -> Self {
        let diagonal = part.diagonal();
        let small = ORDINARY_WIDTH.min(diagonal / 20.0);
        let width = small.max(VOXELS_PER_WIDTH * voxel);
        let height = 0.3 * width;
        let least = WIDTHS_PER_LENGTH * width;
        let length_range = [(0.25 * diagonal).max(least), (0.5 * diagonal).max(least)];
        let mm = |x: f64| 1e3 * x;
        let why = match (small < ORDINARY_WIDTH, width > small) {
            (_, true) => format!("{VOXELS_PER_WIDTH} voxels of {:.4} mm, so that the bake resolves it", mm(voxel)),
            (true, false) => "1/20 of the part's diagonal".to_owned(),
            (false, false) => "an ordinary bead".to_owned(),
        };
        let reasons = vec![
            format!("bead width {:.3} mm: {why}; height {:.3} mm: 0.3 of the width", mm(width), mm(height)),
            format!(
                "length {:.2} to {:.2} mm: 1/4 to 1/2 of the part's diagonal of {:.2} mm, at least 3 widths",
                mm(length_range[0]),
                mm(length_range[1]),
                mm(diagonal)
            ),
        ];
        Self {
            length: None,
            length_range,
            curvature_rms: 3.0 / diagonal,
            curvature_max: (8.0 / diagonal).min(0.5 / width),
            width,
            height,
            min_exposure: 0.5,
            exposure_reach: 0.25 * diagonal,
            sharp_angle: 35f64.to_radians(),
            attempts: 256,
            may_shrink: true,
            reasons,
        }
    }

    /// The first dial that is out of range, in words.
    pub(crate) fn fault(&self) -> Option<String> {
        let positive = |x: f64| x.is_finite() && x > 0.0;
        let [low, high] = self.length_range;
        let checks = [
            ("width", self.width, positive(self.width), "positive"),
            ("height", self.height, positive(self.height), "positive"),
            ("length", self.length.unwrap_or(low), positive(self.length.unwrap_or(low)), "positive"),
            ("longest length", high, high.is_finite() && high >= low, "at least the shortest length"),
            (
                "curvature RMS",
                self.curvature_rms,
                self.curvature_rms.is_finite() && self.curvature_rms >= 0.0,
                "0 or more",
            ),
            ("curvature maximum", self.curvature_max, self.curvature_max >= 0.0, "0 or more"),
            ("minimum exposure", self.min_exposure, (0.0..=1.0).contains(&self.min_exposure), "within 0 to 1"),
            ("exposure reach", self.exposure_reach, positive(self.exposure_reach), "positive"),
            ("sharp angle", self.sharp_angle, positive(self.sharp_angle), "positive"),
            ("attempts", self.attempts as f64, self.attempts > 0, "at least 1"),
        ];
        let bad = checks.iter().find(|(_, _, good, _)| !good);
        bad.map(|(name, value, _, want)| format!("the {name} is {value}; it must be {want}"))
    }
}
