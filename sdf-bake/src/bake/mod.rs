//! Baking: converts triangles to an exact narrow band, with the sign known everywhere.
//!
//! Steps: the surface is closed for the sign (`holes.rs`, `patch.rs`), and walls inside other bodies are removed from
//! the distance (`walls.rs`). Each triangle is scattered to the bricks within one band of it (`scatter.rs`). Each brick
//! gets the exact distance to its own triangles (`distance.rs`), and its signs from crossings counted along the
//! lattice's columns (`columns.rs`). The signs of a soup come from the generalised winding number instead (`sign.rs`,
//! [`WindingTree`]).

mod closed;
mod columns;
mod cuts;
mod distance;
mod error;
mod facet;
mod fill;
mod holes;
mod normals;
mod options;
mod patch;
mod scatter;
mod side;
mod sign;
mod skin;
mod walls;
mod winding;

use std::ops::Range;

use crate::clean::EdgeMap;
use crate::grid::{BRICK_SIDE, BrickGrid, INSIDE};
use crate::index::entry_brick;
use crate::mesh::Mesh;
use fill::{Counts, fill};
use side::{Plan, Side};
use skin::Skin;

pub use error::BakeError;
use error::FARTHEST;
pub use options::{BakeOptions, BakeReport, SignChoice, SignMethod};
pub use winding::WindingTree;

/// Greatest size of the box around a part [bricks].
const MAX_INDEX: f64 = 1.28e8;

/// Greatest ambiguous share of the band that the automatic sign accepts.
const AMBIGUOUS_LIMIT: f64 = 0.005;

/// Least thickness of a shell [voxels]; thinner shells may fall between voxels.
const LEAST_SHELL: f64 = 2.0;

/// Bakes a mesh into a brick grid.
///
/// Distances within the band are exact to about 1e-6 voxels. Overlapping, nested and touching bodies are united: a
/// point is inside if the winding number (Jacobson et al. 2013) exceeds one half, and φ is the distance to the surface
/// of the union. Holes are patched for the sign only.
///
/// # Errors
/// [`BakeError`] for an empty mesh, unusable options, a grid that is too large, or a surface with an ambiguous inside.
pub fn bake(mesh: &Mesh, options: &BakeOptions) -> Result<(BrickGrid, BakeReport), BakeError> {
    let mut grid = frame(mesh, options)?;
    let (edges, skin) = rayon::join(|| EdgeMap::new(mesh), || Skin::of(mesh, grid.voxel));
    let plan = Plan::new(mesh, &edges, options)?;
    let reach = options.band_voxels + options.half_shell() / options.voxel;
    let scene = plan.scene(skin, &edges, &grid, reach);
    if options.sign == SignChoice::Normal && scene.inner_triangles > 0 {
        let reason = format!("{} triangles lie inside another body", scene.inner_triangles);
        return Err(BakeError::NormalsUnsafe { reason });
    }
    let filled = fill(&scene, options, reach, &mut grid);
    match &scene.side {
        Side::Columns(insides) => insides.gaps.iter().for_each(|gap| fill_column(&mut grid, gap)),
        Side::Winding(_) | Side::Normals(_) => sign::flood_empty(&mut grid),
        Side::Shell => {}
    }
    grid.index.tidy();
    let guessed = sign::ambiguous_share(plan.guesses(), &scene.near, &grid);
    let report = BakeReport {
        voxel_m: options.voxel,
        band_voxels: options.band_voxels,
        bricks: grid.brick_count(),
        active_voxels: filled.in_band,
        sign_method: plan.method(),
        sign_reason: plan.reason(&edges),
        boundary_edges: edges.boundary_count(),
        ambiguous_share: filled.ambiguous_share().max(guessed),
        inner_triangles: scene.inner_triangles,
    };
    check(&report, &filled, options)?;
    Ok((grid, report))
}

/// Marks a run of bricks in a column as inside.
fn fill_column(grid: &mut BrickGrid, entries: &Range<usize>) {
    let (low, last) = (entry_brick(entries.start, grid.dims), entry_brick(entries.end - 1, grid.dims));
    grid.index.fill(low, last + 1, INSIDE);
}

/// Rejects a surface with an ambiguous inside.
fn check(report: &BakeReport, filled: &Counts, options: &BakeOptions) -> Result<(), BakeError> {
    let BakeReport { boundary_edges, ambiguous_share: share, .. } = *report;
    if filled.inside == 0 {
        return Err(BakeError::NoInside { voxel: options.voxel, boundary_edges, share });
    }
    if boundary_edges > 0 && share > AMBIGUOUS_LIMIT && options.sign == SignChoice::Auto {
        return Err(BakeError::Open { boundary_edges, share });
    }
    Ok(())
}

/// Makes an empty grid whose index extends one brick beyond the band on every side.
fn frame(mesh: &Mesh, options: &BakeOptions) -> Result<BrickGrid, BakeError> {
    let BakeOptions { voxel, band_voxels, shell, .. } = *options;
    if !(voxel > 0.0 && voxel.is_finite() && band_voxels >= 2.0 && band_voxels.is_finite()) {
        return Err(BakeError::Options { voxel, band_voxels });
    }
    let least = LEAST_SHELL * voxel;
    // Written so that a NaN thickness is rejected too.
    if let Some(thickness) = shell.filter(|&thickness| !(thickness >= least && thickness.is_finite())) {
        return Err(BakeError::ThinShell { thickness, voxel, least });
    }
    let (low, high) = mesh.bounds().filter(|_| !mesh.triangles.is_empty()).ok_or(BakeError::Empty)?;
    let (band, reach) = (band_voxels * voxel, band_voxels * voxel + options.half_shell());
    let brick = BRICK_SIDE as f64 * voxel;
    let first = ((low - reach) / brick).floor() - 1.0;
    let dims = ((high + reach) / brick).floor() + 1.0 - first + 1.0;
    let cells = dims.element_product();
    let away = first.abs().max((first + dims).abs()).max_element() * brick;
    // With a NaN coordinate both are false.
    let (fits, is_near) = (cells <= MAX_INDEX, away <= FARTHEST * voxel);
    if !fits {
        let least_voxel = (voxel * (cells / MAX_INDEX).cbrt()).max(away / FARTHEST);
        return Err(BakeError::TooFine { cells, limit: MAX_INDEX, least_voxel });
    }
    if !is_near {
        return Err(BakeError::FarAway { away, voxel });
    }
    Ok(BrickGrid::empty(voxel, band as f32, first.as_ivec3(), dims.as_ivec3()))
}

#[cfg(test)]
mod tests;
