//! Checks of the NanoVDB files: sane values, boxes that agree with the meshes, labels that cover the weld metal.

use glam::DVec3;
use sdf_bake::BrickGrid;

use crate::asset::{AssetFields, Check, Imperfection, Meshes, PHI_FILE, WELD_FILE, WeldTruth, Welds};

/// Greatest difference between the boxes of mesh and field [voxels].
const BOX_TOLERANCE: f64 = 1.0;

pub(super) fn check(fields: &AssetFields, meshes: &Meshes, truth: Option<&Welds>) -> Vec<Check> {
    let mut checks = Vec::new();
    for (name, grid) in [("phi", &fields.welded), ("target", &fields.target)] {
        let sane = grid.sanity_check();
        let found = sane.clone().err().unwrap_or_else(|| format!("{} bricks", grid.brick_count()));
        checks.push(Check::new(PHI_FILE, format!("{name} is finite and within its band"), sane.is_ok(), found));
    }
    checks.push(compare_boxes("target and workpiece.glb have one box", &fields.target, meshes.part.mesh.bounds()));
    checks.push(compare_boxes("phi and welded.glb have one box", &fields.welded, meshes.welded_bounds()));
    checks.push(check_union(fields, &truth.map_or_else(Vec::new, |truth| cut_open(truth, &fields.welded))));
    checks.push(check_labels(fields));
    checks
}

fn compare_boxes(rule: &str, grid: &BrickGrid, mesh: Option<(DVec3, DVec3)>) -> Check {
    let (Some(crossed), Some(near), Some(mesh)) = (grid.surface_bounds(), grid.near_surface_bounds(), mesh) else {
        return Check::new(PHI_FILE, rule, false, "one of them has no surface");
    };
    let apart =
        |field: (DVec3, DVec3)| (field.0 - mesh.0).abs().max((field.1 - mesh.1).abs()).max_element() / grid.voxel;
    let (crossed, near) = (apart(crossed), apart(near));
    let found = match crossed <= BOX_TOLERANCE {
        true => format!("at most {crossed:.3} voxels apart"),
        false => format!("{crossed:.3} voxels apart where φ < 0, {near:.3} with tips thinner than a voxel"),
    };
    Check::new(PHI_FILE, rule, crossed.min(near) <= BOX_TOLERANCE, found)
}

/// Returns balls [m] around the parts that imperfections removed: a groove or a hole, and the band around it.
fn cut_open(truth: &Welds, grid: &BrickGrid) -> Vec<(DVec3, f64)> {
    let ball = |weld: &WeldTruth, cut: &Imperfection| {
        let curve = &weld.curve;
        let place = curve.arc_length.partition_point(|s| s * 1e3 < cut.arc_length_mm);
        let place = place.min(curve.position.len().checked_sub(1)?);
        let centre = *curve.position.get(place)? + cut.offset_mm * 1e-3 * *curve.side.get(place)?;
        let reach_mm = 0.5 * cut.size_mm + cut.depth_mm + 0.3 * weld.width_mm + weld.toe_height_mm;
        Some((centre, reach_mm * 1e-3 + f64::from(grid.band)))
    };
    let of_weld = |weld| move |cut| ball(weld, cut);
    truth
        .welds
        .iter()
        .flat_map(|weld| weld.imperfections.iter().filter(|i| i.cuts()).filter_map(of_weld(weld)))
        .collect()
}

/// Checks that welding only adds metal: outside the cut-out balls, the welded field is nowhere above the bare part's.
fn check_union(fields: &AssetFields, cut_open: &[(DVec3, f64)]) -> Check {
    let is_cut = |voxel| {
        let place = fields.welded.position(voxel);
        cut_open.iter().any(|(centre, reach)| centre.distance(place) < *reach)
    };
    let above = |(slot, &brick): (usize, &glam::IVec3)| {
        let first = slot * sdf_bake::grid::BRICK_VOXELS;
        let voxel = |offset| sdf_bake::grid::voxel_at(brick, offset);
        (0..sdf_bake::grid::BRICK_VOXELS)
            .filter(|&offset| fields.welded.phi[first + offset] > fields.target.phi_at(voxel(offset)))
            .filter(|&offset| !is_cut(voxel(offset)))
            .count()
    };
    let above: usize = fields.welded.bricks.iter().enumerate().map(above).sum();
    let rule = "phi is nowhere above target, but where imperfections cut the part";
    Check::new(PHI_FILE, rule, above == 0, format!("{above} voxels above"))
}

/// Checks that every voxel with weld metal has a weld id.
fn check_labels(fields: &AssetFields) -> Check {
    let bare = fields.share.iter().zip(&fields.welded.label).filter(|&(&share, &id)| share > 0.0 && id == 0).count();
    let range = fields.share.iter().all(|share| (0.0..=1.0).contains(share));
    let found = format!("{bare} voxels with weld metal and no id");
    Check::new(WELD_FILE, "voxels with weld metal carry an id, shares are 0 to 1", bare == 0 && range, found)
}
