//! Checks of a requested weld before anything is baked, and warnings on a placed weld.

use anyhow::{Result, anyhow, bail};
use sdf_bake::{BLEND_REACH, BakeOptions};
use weldgen::dials::{Dial, HEIGHT, LENGTH, RIPPLE_PITCH, TOE_RADIUS, WEAVE_PITCH, WIDTH};
use weldgen::{BeadProfile, DialFault, Placement, Weld, WeldRequest};

use super::WeldSettings;

/// Diameter of the thinnest welding wire [m]; no bead is narrower.
const THINNEST_WIRE: f64 = 0.6e-3;

/// Refuses values that are impossible for a part of any shape, naming their flags.
pub(super) fn check(wishes: &WeldSettings, request: &WeldRequest, baking: &BakeOptions) -> Result<()> {
    check_sizes(wishes, baking.voxel)?;
    request.check().map_err(|fault| anyhow!("{}{fault}", flag_of(&fault)))?;
    check_toe_radius(wishes, request, baking)
}

/// Returns the flag of a dial as the prefix of a message; empty if no flag sets it.
fn flag_of(fault: &DialFault) -> String {
    Dial::named(fault.dial).map_or(String::new(), |dial| format!("--{}: ", dial.key))
}

/// Refuses sizes far below the voxel, because the ground truth would have them and the field would not.
fn check_sizes(wishes: &WeldSettings, voxel: f64) -> Result<()> {
    for (dial, wish, voxels) in [
        (LENGTH, wishes.length.map(|[low, _]| low), 1.0),
        (WIDTH, wishes.width, 1.0),
        (HEIGHT, wishes.height, 0.05),
        // A wave needs two samples per period (Shannon 1949).
        (RIPPLE_PITCH, wishes.form.ripples.map(|ripples| ripples.pitch), 2.0),
        (WEAVE_PITCH, wishes.form.weave.map(|weave| weave.pitch), 2.0),
    ] {
        if let Some(size) = wish.filter(|&size| size < voxels * voxel) {
            bail!(
                "--{} {:?}: with a voxel of {:.4} mm, {:.4} mm or more is accepted; a smaller --voxel-mm allows less",
                dial.key,
                size * 1e3,
                voxel * 1e3,
                voxels * voxel * 1e3
            );
        }
    }
    Ok(())
}

/// Checks the round toes of a bead on a face. A fillet has the angle of its seam and is checked after placement.
fn check_toe_radius(wishes: &WeldSettings, request: &WeldRequest, baking: &BakeOptions) -> Result<()> {
    if matches!(request.placement, Placement::Seam | Placement::Mixed) {
        return Ok(());
    }
    let profile = BeadProfile::on_face(request.shape, request.width, request.height);
    check_blend(&profile, wishes.toe_radius, baking)
}

/// Checks that the round toes [m] of a bead stay within the band.
pub(super) fn check_blend(profile: &BeadProfile, toe_radius: Option<f64>, baking: &BakeOptions) -> Result<()> {
    let Some(radius) = toe_radius else { return Ok(()) };
    let band = baking.band_voxels * baking.voxel;
    // The blend's radius is proportional to that of the toes.
    let most = BLEND_REACH * band * radius / profile.blend_radius(radius);
    if radius <= most {
        return Ok(());
    }
    bail!(
        "--{} {:?}: 0 to {:.4} mm are accepted for a bead {:.3} mm wide and {:.3} mm high in a band of {:.3} mm; a \
         wider --band allows more",
        TOE_RADIUS.key,
        radius * 1e3,
        most * 1e3,
        profile.width * 1e3,
        profile.height * 1e3,
        band * 1e3
    )
}

/// Lists implausible or unmet properties of a weld.
pub(super) fn bead_warnings(weld: &Weld) -> Vec<String> {
    let width = weld.profile.width;
    let thin = (width < THINNEST_WIRE).then(|| {
        format!(
            "the bead is {:.3} mm wide, and the thinnest welding wire is {} mm: check --unit and the size of the part, or give \
             --width-mm",
            width * 1e3,
            THINNEST_WIRE * 1e3
        )
    });
    thin.into_iter().chain(weld.shortfalls()).collect()
}
