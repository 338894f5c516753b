//! Report of the faults and changes found in cleaning.

use serde::Serialize;

/// Counts of a mesh before, during and after cleaning.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct CleanReport {
    /// Vertices as read.
    pub vertices_before: usize,
    /// Triangles as read.
    pub triangles_before: usize,
    /// Vertices merged into another at exactly the same position.
    pub merged_equal: usize,
    /// Boundary vertices merged into another within `weld_tolerance`.
    pub merged_near: usize,
    /// Largest gap that was closed [m].
    pub weld_tolerance: f64,
    /// Dropped triangles with a repeated corner, or without height in double precision.
    pub degenerate_faces: usize,
    /// Edges swapped so that a triangle without height could be removed without leaving a gap.
    pub swapped_edges: usize,
    /// Dropped triangles with the corners and orientation of another one.
    pub duplicate_faces: usize,
    /// Dropped vertices that no triangle uses.
    pub unused_vertices: usize,
    /// Vertices after cleaning.
    pub vertices: usize,
    /// Triangles after cleaning.
    pub triangles: usize,
    /// Edges of one triangle.
    pub boundary_edges: usize,
    /// Edges of more than two triangles.
    pub non_manifold_edges: usize,
    /// Edges that are not used equally often in both directions, except boundary edges.
    pub inconsistent_edges: usize,
    /// Components that share no vertex; solids that touch at one are one body.
    pub bodies: usize,
    /// Components that share no edge.
    pub shells: usize,
    /// Pairs of triangles with the same corners and opposite orientation, where solids touch.
    pub coincident_pairs: usize,
    /// Triangles flipped to agree with their neighbours.
    pub flipped_triangles: usize,
    /// Closed shells flipped as a whole, because they or the shell around them enclosed a negative volume.
    pub flipped_shells: usize,
    /// True if no edge has an odd number of triangles: the surface has no boundary.
    pub closed: bool,
    /// True if every edge of two or more triangles is used equally often in both directions.
    pub consistently_oriented: bool,
}

impl CleanReport {
    /// True if every edge has exactly two triangles, in opposite directions.
    pub fn is_watertight(&self) -> bool {
        self.closed && self.consistently_oriented && self.non_manifold_edges == 0
    }

    /// Number of changes, except merging equal positions, which a file without indices needs.
    pub fn repairs(&self) -> usize {
        self.merged_near
            + self.degenerate_faces
            + self.swapped_edges
            + self.duplicate_faces
            + self.unused_vertices
            + self.flipped_triangles
            + self.flipped_shells
    }

    /// Sentences on each change and each remaining fault; empty for a perfect mesh.
    pub fn notes(&self) -> Vec<String> {
        let tolerance = format!("boundary vertices closer than {:.3e} mm", self.weld_tolerance * 1e3);
        let lines = [
            ("merged", self.merged_equal, "vertices at equal positions"),
            ("merged", self.merged_near, tolerance.as_str()),
            ("dropped", self.degenerate_faces, "degenerate faces"),
            ("swapped", self.swapped_edges, "edges beside triangles without height"),
            ("dropped", self.duplicate_faces, "duplicate faces"),
            ("dropped", self.unused_vertices, "unused vertices"),
            ("turned", self.flipped_triangles, "triangles to agree with their neighbours"),
            ("turned", self.flipped_shells, "inside-out shells"),
            ("left", self.boundary_edges, "boundary edges: the surface is open there"),
            ("left", self.non_manifold_edges, "edges of more than two triangles"),
            ("left", self.coincident_pairs, "pairs of coincident faces where solids touch"),
            ("left", self.inconsistent_edges, "edges where orientations disagree"),
        ];
        lines
            .iter()
            .filter(|(_, count, _)| *count > 0)
            .map(|(verb, count, what)| format!("{verb} {count} {what}"))
            .collect()
    }
}
