//! Choice of the rule for the sign, with its reason.

use super::columns::{self, Insides};
use super::error::BakeError;
use super::holes::{ClosedSurface, close};
use super::normals::{self, Normals};
use super::options::{BakeOptions, SignChoice, SignMethod};
use super::scatter::{BrickTriangles, scatter};
use super::sign::Surface;
use super::skin::{Corners, Skin};
use super::walls::{self, Bodies, Sides};
use crate::clean::EdgeMap;
use crate::grid::BrickGrid;
use crate::mesh::Mesh;

/// Rule for the sign of a surface.
pub(super) enum Plan<'a> {
    /// Crossings of the closed surface along columns.
    Columns(ClosedSurface<'a>),
    /// Normals of the surface; its crossings are counted only to find overlapping bodies.
    Normals(ClosedSurface<'a>),
    /// Generalised winding number of a surface that is hardly connected.
    Winding(&'a Mesh),
    /// Shell of a thickness around the surface.
    Shell,
}

/// A rule prepared for evaluation.
pub(super) enum Side<'a> {
    Columns(Insides),
    Normals(Normals<'a>),
    Winding(Surface),
    Shell,
}

/// All data that filling bricks reads.
pub(super) struct Scene<'a> {
    pub(super) skin: Skin,
    pub(super) near: BrickTriangles,
    pub(super) side: Side<'a>,
    /// Triangles that lie inside another body, entirely or partly.
    pub(super) inner_triangles: usize,
}

impl<'a> Plan<'a> {
    /// # Errors
    /// If normals are requested on a surface where they can be wrong.
    pub(super) fn new(mesh: &'a Mesh, edges: &EdgeMap, options: &BakeOptions) -> Result<Self, BakeError> {
        if options.shell.is_some() {
            return Ok(Self::Shell);
        }
        if options.sign == SignChoice::Normal {
            return match normals::doubt(mesh, edges) {
                Some(reason) => Err(BakeError::NormalsUnsafe { reason }),
                None => Ok(Self::Normals(ClosedSurface::as_it_is(mesh))),
            };
        }
        Ok(close(mesh, edges).map_or(Self::Winding(mesh), Self::Columns))
    }

    /// Corners [m] of the patches over holes that leave the sign ambiguous.
    pub(super) fn guesses(&self) -> &[Corners] {
        match self {
            Self::Columns(closed) => &closed.guesses,
            _ => &[],
        }
    }

    pub(super) fn method(&self) -> SignMethod {
        match self {
            Self::Columns(closed) if closed.holes == 0 => SignMethod::Crossings,
            Self::Columns(_) => SignMethod::Patched,
            Self::Normals(_) => SignMethod::Normals,
            Self::Winding(_) => SignMethod::Winding,
            Self::Shell => SignMethod::Shell,
        }
    }

    /// Reason for this rule, as a sentence.
    pub(super) fn reason(&self, edges: &EdgeMap) -> String {
        match self {
            Self::Columns(ClosedSurface { holes: 0, turned: 0, .. }) => {
                "every edge is passed equally often both ways: crossings are exact".into()
            }
            Self::Columns(ClosedSurface { holes, turned, .. }) => format!(
                "{} boundary edges; {holes} holes patched and {turned} triangles turned, for the sign only",
                edges.boundary_count()
            ),
            Self::Normals(_) => {
                "asked for; the surface is closed, has one orientation and no wall inside a body".into()
            }
            Self::Winding(_) => {
                format!("{} boundary edges: patches would be as large as the surface", edges.boundary_count())
            }
            Self::Shell => "asked for: what is within half the thickness of the surface is inside".into(),
        }
    }

    /// - `skin`: facets of the mesh as given
    /// - `reach`: greatest distance to triangles that is computed [voxels]
    pub(super) fn scene<'b>(&'b self, skin: Skin, edges: &'b EdgeMap, grid: &BrickGrid, reach: f64) -> Scene<'b> {
        match self {
            Self::Columns(closed) => united(closed, skin, edges, grid, reach),
            Self::Normals(closed) => {
                let scene = united(closed, skin, edges, grid, reach);
                Scene { side: Side::Normals(Normals::new(&closed.mesh, edges)), ..scene }
            }
            Self::Winding(mesh) => {
                let near = scatter(&skin, grid, reach);
                Scene { skin, near, side: Side::Winding(Surface::new(mesh, edges)), inner_triangles: 0 }
            }
            Self::Shell => {
                let near = scatter(&skin, grid, reach);
                Scene { skin, near, side: Side::Shell, inner_triangles: 0 }
            }
        }
    }
}

/// Signs of a closed surface from crossings; walls inside other bodies are removed from the distance.
fn united<'a>(closed: &ClosedSurface, skin: Skin, edges: &EdgeMap, grid: &BrickGrid, reach: f64) -> Scene<'a> {
    let whole = closed.patches.is_empty() && closed.turned == 0;
    let mut skin = if whole { skin } else { Skin::new(&closed.patches, &closed.mesh, &[], grid.voxel) };
    let ((bodies, sides), (mut near, mut insides)) = rayon::join(
        || {
            let bodies = Bodies::of(&closed.mesh, edges);
            let sides = bodies.are_close().then(|| Sides::of(closed, grid.voxel));
            (bodies, sides)
        },
        || {
            let near = scatter(&skin, grid, reach);
            let insides = columns::insides(&near, &skin, grid);
            (near, insides)
        },
    );
    let found = bodies.suspects(&closed.mesh, insides.deepest > 1).and_then(|suspects| {
        let sides = sides.unwrap_or_else(|| Sides::of(closed, grid.voxel));
        walls::within(&closed.mesh, edges, &suspects, &sides, grid.voxel)
    });
    let inner_triangles = found.as_ref().map_or(0, |walls| walls.sign_only.len());
    if let Some(walls) = found {
        let sign_only = [&closed.patches[..], &walls.sign_only].concat();
        skin = Skin::new(&sign_only, &walls.kept, &walls.distance_only, grid.voxel);
        near = scatter(&skin, grid, reach);
        insides = columns::insides(&near, &skin, grid);
    }
    Scene { skin, near, side: Side::Columns(insides), inner_triangles }
}
