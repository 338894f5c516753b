//! Cleans a triangle mesh and reports every change.
//!
//! Real CAD exports repeat vertices and faces, are open, have triangles of opposite orientation, and contain touching
//! solids. The steps, in order: finite coordinates → weld equal positions → degenerate and duplicate faces → close
//! cracks → unused vertices → edges → one orientation for each patch → outward normals for each outermost shell →
//! report. All run in O(n log n), except the test for nested shells.
//!
//! Holes are not filled and touching solids are not separated; the report counts them.

use crate::Mesh;

mod caps;
mod edges;
mod faces;
mod nesting;
mod orient;
mod report;
mod weld;

pub use edges::{EdgeMap, EdgeUse};
pub(crate) use orient::disagreeing;
pub use report::CleanReport;

/// Least number of triangles of a closed surface.
const TETRAHEDRON: usize = 4;

/// Reason why a mesh cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CleanError {
    /// A coordinate is infinite or not a number.
    #[error("vertex {vertex} is ({x}, {y}, {z}): coordinates must be finite numbers")]
    NonFinite {
        /// Vertex index.
        vertex: usize,
        /// x [m].
        x: f64,
        /// y [m].
        y: f64,
        /// z [m].
        z: f64,
    },
    /// A triangle refers to a vertex that does not exist.
    #[error("triangle {triangle} names vertex {vertex}, and there are {vertices}")]
    NoSuchVertex {
        /// Triangle index.
        triangle: usize,
        /// Index found.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// Fewer triangles than a tetrahedron.
    #[error("{} cannot enclose a volume; at least 4 are needed{}", count(*left), dropped(*before, *left))]
    TooFewTriangles {
        /// Number of triangles as given.
        before: usize,
        /// Number of triangles that are neither degenerate nor duplicate.
        left: usize,
    },
}

fn count(triangles: usize) -> String {
    if triangles == 1 { "1 triangle".into() } else { format!("{triangles} triangles") }
}

fn dropped(before: usize, left: usize) -> String {
    if before == left { String::new() } else { format!(" ({} of {before} are degenerate or duplicate)", before - left) }
}

/// Cleans a mesh; returns it with a report of the changes.
pub fn clean(mut mesh: Mesh) -> Result<(Mesh, CleanReport), CleanError> {
    check(&mesh)?;
    let mut report = CleanReport {
        vertices_before: mesh.positions.len(),
        triangles_before: mesh.triangles.len(),
        unused_vertices: faces::drop_unused_vertices(&mut mesh),
        ..CleanReport::default()
    };
    report.merged_equal = weld::merge_equal(&mut mesh);
    drop_faces(&mut mesh, &mut report);
    (report.merged_near, report.weld_tolerance) = weld::close_cracks(&mut mesh);
    drop_faces(&mut mesh, &mut report);
    // Vertices that welding replaced are counted as merged.
    report.unused_vertices += faces::drop_unused_vertices(&mut mesh) - report.merged_near;
    if mesh.triangles.len() < TETRAHEDRON {
        return Err(CleanError::TooFewTriangles { before: report.triangles_before, left: mesh.triangles.len() });
    }
    let edges = EdgeMap::new(&mesh);
    let turned = orient::orient(&mut mesh, &edges);
    (report.flipped_triangles, report.flipped_shells) = (turned.triangles, turned.shells);
    let edges = if turned.triangles + turned.shells > 0 { EdgeMap::new(&mesh) } else { edges };
    measure(&mesh, &edges, &mut report);
    Ok((mesh, report))
}

/// Runs before cracks are closed, because a duplicate hides a boundary edge, and again after.
fn drop_faces(mesh: &mut Mesh, report: &mut CleanReport) {
    report.degenerate_faces += faces::drop_collapsed(mesh);
    report.duplicate_faces += faces::drop_duplicates(mesh);
    report.swapped_edges += caps::swap_long_edges(mesh);
    report.degenerate_faces += faces::drop_flat(mesh);
    report.duplicate_faces += faces::drop_duplicates(mesh);
}

fn check(mesh: &Mesh) -> Result<(), CleanError> {
    let vertices = mesh.positions.len();
    if let Some((vertex, p)) = mesh.positions.iter().enumerate().find(|(_, p)| !p.length_squared().is_finite()) {
        return Err(CleanError::NonFinite { vertex, x: p.x, y: p.y, z: p.z });
    }
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&vertex| vertex as usize >= vertices) {
            return Err(CleanError::NoSuchVertex { triangle, vertex, vertices });
        }
    }
    Ok(())
}

/// Sets the counts of the mesh in its current state.
fn measure(mesh: &Mesh, edges: &EdgeMap, report: &mut CleanReport) {
    report.vertices = mesh.positions.len();
    report.triangles = mesh.triangles.len();
    report.boundary_edges = edges.boundary_count();
    report.non_manifold_edges = edges.non_manifold_count();
    let shared = edges.indices().filter(|&edge| edges.uses(edge).len() > 1);
    report.inconsistent_edges = shared.filter(|&edge| !edges.is_balanced(edge)).count();
    (_, report.shells) = edges.components(|_| true);
    report.bodies = connected_vertices(mesh);
    report.coincident_pairs = faces::coincident_pairs(mesh, edges);
    report.closed = edges.indices().all(|edge| edges.uses(edge).len().is_multiple_of(2));
    report.consistently_oriented = report.inconsistent_edges == 0;
}

/// Number of components connected through vertices, in a mesh without unused vertices.
fn connected_vertices(mesh: &Mesh) -> usize {
    let mut parent: Vec<u32> = (0..mesh.positions.len() as u32).collect();
    let mut parts = parent.len();
    for &[a, b, c] in &mesh.triangles {
        for (from, to) in [(a, b), (a, c)] {
            let (from, to) = (root(&mut parent, from), root(&mut parent, to));
            if from != to {
                parent[from.max(to) as usize] = from.min(to);
                parts -= 1;
            }
        }
    }
    parts
}

fn root(parent: &mut [u32], mut vertex: u32) -> u32 {
    while parent[vertex as usize] != vertex {
        let above = parent[parent[vertex as usize] as usize];
        parent[vertex as usize] = above;
        vertex = above;
    }
    vertex
}
