//! Baking: triangles to an exact narrow band with inside and outside known everywhere.
//!
//! The road: each triangle is scattered to the bricks within one band of it (`scatter.rs`); each brick takes
//! the exact distance to its own triangles (`distance.rs`); a closed surface is signed by counting crossings along the
//! lattice's columns (`columns.rs`), any other by the generalised winding number (`sign.rs`, [`WindingTree`]); what has
//! no brick is flooded.

mod columns;
mod distance;
mod facet;
mod scatter;
mod sign;
mod skin;
mod winding;

use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::clean::EdgeMap;
use crate::grid::{BRICK_SIDE, BRICK_VOXELS, BrickGrid, INSIDE};
use crate::implicit::entry_brick;
use crate::mesh::Mesh;
use columns::Insides;
use distance::{Brick, Distances, Scratch};
use scatter::BrickTriangles;
use sign::Surface;
use skin::Skin;

pub use winding::WindingTree;

/// How inside and outside are told apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SignChoice {
    /// Winding number; refuses an open surface whose inside is unclear.
    #[default]
    Auto,
    /// Winding number, also where an open surface leaves the inside to a guess.
    Winding,
}

/// What to bake.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BakeOptions {
    /// Distance between voxels [m].
    pub voxel: f64,
    /// Half width of the band [voxels].
    pub band_voxels: f64,
    /// Sign rule.
    pub sign: SignChoice,
}

impl BakeOptions {
    /// A band of ±3 voxels with the automatic sign.
    pub fn with_voxel(voxel: f64) -> Self {
        Self { voxel, band_voxels: 3.0, sign: SignChoice::Auto }
    }
}

/// Where inside and outside came from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SignMethod {
    /// Signed crossings along columns of voxels: exact, for surfaces whose edges are all passed equally often both ways.
    #[default]
    Crossings,
    /// Generalised winding number, for open or inconsistently oriented surfaces.
    Winding,
}

impl std::fmt::Display for SignMethod {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Crossings => "signed crossings (the surface is closed)",
            Self::Winding => "winding number (the surface is open or inconsistently oriented)",
        })
    }
}

/// What baking did.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BakeReport {
    /// Distance between voxels [m].
    pub voxel_m: f64,
    /// Half width of the band [voxels].
    pub band_voxels: f64,
    /// Bricks in the pool.
    pub bricks: usize,
    /// Voxels with |φ| < band.
    pub active_voxels: usize,
    /// Where inside and outside came from.
    pub sign_method: SignMethod,
    /// Edges with one triangle only.
    pub boundary_edges: usize,
    /// Share of the judged voxels whose winding number is farther than 0.25 from a whole number.
    pub ambiguous_share: f64,
}

/// Why a mesh cannot be baked.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BakeError {
    /// The mesh has no triangles.
    #[error("the mesh has no triangles: nothing to bake")]
    Empty,
    /// The voxel size or band is not usable.
    #[error(
        "a voxel of {voxel} m with a band of {band_voxels} voxels cannot be baked: both must be positive, the band at least 2"
    )]
    Options {
        /// Asked voxel [m].
        voxel: f64,
        /// Asked band [voxels].
        band_voxels: f64,
    },
    /// The grid would not fit.
    #[error(
        "{cells:.2e} index bricks are too many (limit {limit:.0e}): a voxel of at least {least_voxel:.3e} m would fit"
    )]
    TooFine {
        /// Index entries needed.
        cells: f64,
        /// Index entries allowed.
        limit: f64,
        /// Smallest voxel that fits [m].
        least_voxel: f64,
    },
    /// Open surface whose inside is a guess.
    #[error(
        "open surface: {boundary_edges} boundary edges leave {:.1} % of the band without a clear inside; \
         use --sign winding to accept the guess, or close the mesh", 100.0 * share
    )]
    Open {
        /// Edges with one triangle only.
        boundary_edges: usize,
        /// Ambiguous share of the band, 0 to 1.
        share: f64,
    },
    /// No voxel is inside.
    #[error(
        "the surface encloses nothing at a voxel of {voxel} m: it is a sheet, or thinner than a voxel ({boundary_edges} boundary edges)"
    )]
    NoInside {
        /// Voxel [m].
        voxel: f64,
        /// Edges with one triangle only.
        boundary_edges: usize,
    },
}

/// Largest top-level index [bricks]: 512 MiB of entries.
const MAX_INDEX: f64 = 1.28e8;

/// Largest ambiguous share of the band that the automatic sign accepts.
const AMBIGUOUS_LIMIT: f64 = 0.005;

/// Bakes a mesh into a brick grid.
///
/// Distances within the band are exact to about 1e-6 voxels. Overlapping and nested bodies are united:
/// a point is inside where the winding number (Jacobson et al. 2013) exceeds one half.
///
/// # Errors
/// [`BakeError`] for an empty mesh, unusable options, a grid that cannot fit, or a surface without a clear inside.
pub fn bake(mesh: &Mesh, options: &BakeOptions) -> Result<(BrickGrid, BakeReport), BakeError> {
    let mut grid = frame(mesh, options)?;
    let skin = Skin::of(mesh, grid.voxel);
    let (near, edges) = rayon::join(|| scatter::scatter(&skin, &grid), || EdgeMap::new(mesh));
    let side = if edges.indices().all(|edge| edges.is_balanced(edge)) {
        Inside::Masks(columns::insides(&near, &skin, &grid))
    } else {
        Inside::Judged(Surface::new(mesh, &edges))
    };
    let mut phi = vec![0.0; near.brick_count() * BRICK_VOXELS];
    let filled: Vec<Filled> = phi
        .par_chunks_exact_mut(BRICK_VOXELS)
        .enumerate()
        .map_init(Scratch::default, |scratch, (b, phi)| fill(b, &near, &skin, &side, &grid, phi, scratch))
        .collect();
    collect(phi, &filled, &near, &mut grid);
    match &side {
        Inside::Masks(insides) => insides.gaps.iter().for_each(|gap| grid.index[gap.clone()].fill(INSIDE)),
        Inside::Judged(_) => sign::flood_empty(&mut grid),
    }
    let report = BakeReport {
        voxel_m: options.voxel,
        band_voxels: options.band_voxels,
        bricks: grid.brick_count(),
        active_voxels: filled.iter().map(|brick| brick.in_band).sum(),
        sign_method: side.method(),
        boundary_edges: edges.boundary_count(),
        ambiguous_share: ambiguous_share(&filled),
    };
    check(&report, &filled, options)?;
    Ok((grid, report))
}

/// Moves the bricks that hold a part of the band, or both sides, into the grid, and says of the others where they are.
fn collect(mut phi: Vec<f32>, filled: &[Filled], near: &BrickTriangles, grid: &mut BrickGrid) {
    for (b, brick) in filled.iter().enumerate() {
        let entry = near.entry(b);
        if brick.in_band > 0 || (brick.inside > 0 && brick.inside < BRICK_VOXELS) {
            let slot = grid.bricks.len();
            grid.index[entry] = slot as u32;
            grid.bricks.push(grid.origin + entry_brick(entry, grid.dims));
            if slot < b {
                phi.copy_within(b * BRICK_VOXELS..(b + 1) * BRICK_VOXELS, slot * BRICK_VOXELS);
            }
        } else if brick.inside > 0 {
            grid.index[entry] = INSIDE;
        }
    }
    phi.truncate(grid.bricks.len() * BRICK_VOXELS);
    grid.phi = phi;
}

fn ambiguous_share(filled: &[Filled]) -> f64 {
    let ambiguous: usize = filled.iter().map(|brick| brick.ambiguous).sum();
    ambiguous as f64 / (filled.len() * BRICK_VOXELS).max(1) as f64
}

/// Refuses a surface without a clear inside.
fn check(report: &BakeReport, filled: &[Filled], options: &BakeOptions) -> Result<(), BakeError> {
    let BakeReport { boundary_edges, ambiguous_share: share, .. } = *report;
    if boundary_edges > 0 && share > AMBIGUOUS_LIMIT && options.sign == SignChoice::Auto {
        return Err(BakeError::Open { boundary_edges, share });
    }
    if filled.iter().all(|brick| brick.inside == 0) {
        return Err(BakeError::NoInside { voxel: options.voxel, boundary_edges });
    }
    Ok(())
}

/// An empty grid whose index reaches one brick beyond the band on every side.
fn frame(mesh: &Mesh, options: &BakeOptions) -> Result<BrickGrid, BakeError> {
    let BakeOptions { voxel, band_voxels, .. } = *options;
    if !(voxel > 0.0 && voxel.is_finite() && band_voxels >= 2.0 && band_voxels.is_finite()) {
        return Err(BakeError::Options { voxel, band_voxels });
    }
    let (low, high) = mesh.bounds().filter(|_| !mesh.triangles.is_empty()).ok_or(BakeError::Empty)?;
    let band = band_voxels * voxel;
    let brick = BRICK_SIDE as f64 * voxel;
    let first = ((low - band) / brick).floor() - 1.0;
    let dims = ((high + band) / brick).floor() + 1.0 - first + 1.0;
    let cells = dims.element_product();
    let farthest = first.abs().max((first + dims).abs());
    // Written so that a coordinate that is no number is refused too.
    if !(cells <= MAX_INDEX && farthest.cmple(DVec3::splat(1e8)).all()) {
        let least_voxel = voxel * (cells / MAX_INDEX).cbrt().max(1.0);
        return Err(BakeError::TooFine { cells, limit: MAX_INDEX, least_voxel });
    }
    Ok(BrickGrid::empty(voxel, band as f32, first.as_ivec3(), dims.as_ivec3()))
}

/// Counts of a brick's voxels.
struct Filled {
    in_band: usize,
    ambiguous: usize,
    inside: usize,
}

/// What tells inside from outside.
enum Inside {
    Masks(Insides),
    Judged(Surface),
}

impl Inside {
    fn method(&self) -> SignMethod {
        match self {
            Self::Masks(_) => SignMethod::Crossings,
            Self::Judged(_) => SignMethod::Winding,
        }
    }
}

fn fill(
    b: usize,
    near: &BrickTriangles,
    skin: &Skin,
    inside: &Inside,
    grid: &BrickGrid,
    phi: &mut [f32],
    scratch: &mut Scratch,
) -> Filled {
    let brick = grid.origin + entry_brick(near.entry(b), grid.dims);
    let centre = brick.as_dvec3() * BRICK_SIDE as f64 + 3.5;
    let band = (f64::from(grid.band) / grid.voxel) as f32;
    let brick_triangles = Brick { centre, triangles: near.triangles(b), skin, band };
    let in_band = pulp::Arch::new().dispatch(Distances { brick: brick_triangles, grid, scratch, phi });
    let (ambiguous, inside) = match inside {
        Inside::Masks(insides) => (0, columns::apply(&insides.masks[b], phi)),
        Inside::Judged(surface) => sign::judge(brick, phi, surface, grid),
    };
    Filled { in_band, ambiguous, inside }
}

#[cfg(test)]
mod tests;
