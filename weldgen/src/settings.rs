//! Settings of a weld as users give them: what is not set is chosen for the part.

use sdf_bake::{BLEND_REACH, BakeOptions, Mesh};
use serde::Serialize;

use crate::access::ToolShape;
use crate::bead::{BeadProfile, BeadShape, FormRequest};
use crate::dials::{HEIGHT, LENGTH, RIPPLE_PITCH, WEAVE_PITCH, WIDTH};
use crate::difficulty::Difficulty;
use crate::request::{Placement, Stitch, WeldRequest};
use crate::setting_fault::SettingFault;

/// User's settings of the weld; the other properties are chosen for the part.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct WeldSettings {
    /// Preset of the dials that are not set below.
    pub difficulty: Difficulty,
    /// Number of welds; the default is one.
    pub count: Option<u16>,
    /// Placement of the welds.
    pub placement: Placement,
    /// Intermittent welds instead of continuous ones.
    pub stitch: Option<Stitch>,
    /// Cross-section on a face.
    pub shape: BeadShape,
    /// Rise of a fillet's face above the chord between its toes [widths].
    pub convexity: f64,
    /// Ripples, craters, imperfections.
    pub form: FormRequest,
    /// Least radius of the toes in the field [m]; sharp without it.
    pub toe_radius: Option<f64>,
    /// Length of the centreline, a range [m].
    pub length: Option<[f64; 2]>,
    /// Width of the bead [m].
    pub width: Option<f64>,
    /// Height of the bead [m].
    pub height: Option<f64>,
    /// Root mean square of the geodesic curvature, a range [1/m].
    pub curvature: Option<[f64; 2]>,
    /// Largest geodesic curvature [1/m].
    pub curvature_max: Option<f64>,
    /// Correlation length of the geodesic curvature [m].
    pub correlation: Option<f64>,
    /// Least exposure along the weld, a range within 0 to 1.
    pub exposure: Option<[f64; 2]>,
    /// Length of the exposure rays [m]; geometry farther away does not shade.
    pub exposure_reach: Option<f64>,
    /// Tool of the access measurement.
    pub tool: ToolShape,
    /// Least mean tool access along the weld, 0 to 1.
    pub min_access: Option<f64>,
}

impl WeldSettings {
    /// Makes the request for a part with the user's settings; sizes set by the user are never shrunk.
    ///
    /// - `voxel`: voxel [m] of the field in which the part is welded
    pub fn request(&self, part: &Mesh, voxel: f64) -> WeldRequest {
        let chosen = WeldRequest::of_difficulty(part, voxel, self.difficulty);
        let width = self.width.unwrap_or(chosen.width);
        let sized = self.length.is_some() || self.width.is_some() || self.height.is_some();
        let fixed = sized || self.exposure.is_some() || self.min_access.is_some();
        // A requested range may exceed the part's default; three times the root mean square allows any shape.
        let sharpest = self.curvature.map_or(chosen.curvature_max, |[_, high]| 3.0 * high);
        WeldRequest {
            placement: self.placement,
            stitch: self.stitch,
            shape: self.shape,
            convexity: self.convexity,
            form: self.form,
            length: self.length.unwrap_or(chosen.length),
            width,
            height: self.height.unwrap_or(chosen.height * width / chosen.width),
            curvature_rms: self.curvature.unwrap_or(chosen.curvature_rms),
            curvature_max: self.curvature_max.unwrap_or(sharpest),
            correlation: self.correlation,
            exposure: self.exposure.unwrap_or(chosen.exposure),
            exposure_reach: self.exposure_reach.unwrap_or(chosen.exposure_reach),
            tool: self.tool,
            min_access: self.min_access.unwrap_or(chosen.min_access),
            gap: chosen.gap.max(width),
            may_shrink: !fixed,
            reasons: if sized { Vec::new() } else { chosen.reasons },
            ..chosen
        }
    }
    /// Refuses values that are impossible for a part of any shape.
    ///
    /// # Errors
    /// The first such value, with its flag.
    pub fn check(&self, request: &WeldRequest, baking: &BakeOptions) -> Result<(), SettingFault> {
        self.check_sizes(baking.voxel)?;
        request.check().map_err(|fault| SettingFault::Dial { fault })?;
        // A fillet has the angle of its seam and is checked after placement.
        if matches!(request.placement, Placement::Seam | Placement::Mixed) {
            return Ok(());
        }
        self.check_toes(&BeadProfile::on_face(request.shape, request.width, request.height), baking)
    }

    /// Checks that the round toes of a bead stay within the band.
    ///
    /// # Errors
    /// The requested radius, with the greatest that is accepted.
    pub fn check_toes(&self, profile: &BeadProfile, baking: &BakeOptions) -> Result<(), SettingFault> {
        let Some(radius) = self.toe_radius else { return Ok(()) };
        let band = baking.band_voxels * baking.voxel;
        // The blend's radius is proportional to that of the toes.
        let most = BLEND_REACH * band * radius / profile.blend_radius(radius);
        if radius <= most {
            return Ok(());
        }
        Err(SettingFault::Toes { radius, most, bead: [profile.width, profile.height], band })
    }

    /// Refuses sizes far below the voxel.
    fn check_sizes(&self, voxel: f64) -> Result<(), SettingFault> {
        let sizes = [
            (LENGTH, self.length.map(|[low, _]| low), 1.0),
            (WIDTH, self.width, 1.0),
            (HEIGHT, self.height, 0.05),
            // A wave needs two samples per period (Shannon 1949).
            (RIPPLE_PITCH, self.form.ripples.map(|ripples| ripples.pitch), 2.0),
            (WEAVE_PITCH, self.form.weave.map(|weave| weave.pitch), 2.0),
        ];
        for (dial, size, voxels) in sizes {
            if let Some(size) = size.filter(|&size| size < voxels * voxel) {
                return Err(SettingFault::BelowVoxel { dial, size, voxel, least: voxels * voxel });
            }
        }
        Ok(())
    }
}
