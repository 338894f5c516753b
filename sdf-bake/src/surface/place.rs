//! Where a piece of the surface has its vertex.
//!
//! Every voxel knows a plane: through its closest surface point, across its gradient. The planes of the corners of a
//! cell meet in the edge or corner of the surface that the cell holds, which is the point where the sum of the squared
//! distances from them is least (Ju et al. 2002, "Dual contouring of Hermite data", whose data were at crossed edges).

use glam::{DMat3, DVec3, IVec3};

use crate::tangent::Tangent;

/// How far outside its cell an edge of the surface may be found, and a closest point used [voxels].
const MARGIN: f64 = 0.1;
/// As [`MARGIN`], where the surface does not cross the cell that holds the edge.
const TIP: f64 = 0.7;
/// Share of the tangents' own normals in the height of a smooth face, the rest is the mean normal's. A half would put
/// vertices on the surface; a third more lifts them by a twelfth of the curvature, as much as the triangles sag between.
const BALANCE: f64 = 5.0 / 6.0;
/// Share of the largest eigenvalue above which planes count as facing another way: normals about 23° apart.
const FACES: f64 = 0.04;
/// Cosine of the angle within which planes belong to one smooth face.
const SAME_FACE: f64 = 0.7;

/// A vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    /// Place in the cell, 0 to 1 on each axis.
    pub(super) at: DVec3,
    pub(super) shape: Shape,
}

/// How the surface is bent at a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Smooth,
    /// On an edge or corner that stands out.
    Outer,
    /// On one that is a groove.
    Inner,
}

/// The vertex of a piece with these tangents whose crossed edges have their middle at `centre`. `is_crossed` tells whether
/// the surface crosses the cell at an offset from this one.
pub(super) fn place(mut tangents: Vec<Tangent>, centre: DVec3, is_crossed: impl Fn(IVec3) -> bool) -> Vertex {
    let found = sharp_point(&tangents, centre);
    // A tip may lie in a cell whose corners are all on one side: then no other vertex stands for it.
    let alone = |at: &DVec3| outside_by(*at) <= TIP && !is_crossed(at.floor().as_ivec3());
    if let Some(at) = found.filter(|at| outside_by(*at) <= MARGIN || alone(at)) {
        return Vertex { at, shape: bend(&tangents) };
    }
    // Perhaps the edge is not in this cell, and a voxel's closest point is beyond it.
    tangents.retain(|tangent| outside_by(tangent.foot) <= MARGIN);
    if let Some(at) = sharp_point(&tangents, centre).filter(|at| outside_by(*at) <= MARGIN) {
        return Vertex { at, shape: bend(&tangents) };
    }
    Vertex { at: smooth_point(&tangents, centre).clamp(DVec3::ZERO, DVec3::ONE), shape: Shape::Smooth }
}

/// Outer where the feet lie below each other's planes.
fn bend(tangents: &[Tangent]) -> Shape {
    let pairs = tangents.iter().flat_map(|a| tangents.iter().map(move |b| a.normal.dot(b.foot - a.foot)));
    if pairs.sum::<f64>() <= 0.0 { Shape::Outer } else { Shape::Inner }
}

/// Distance of a point from the unit cell on the axis where it is farthest.
fn outside_by(at: DVec3) -> f64 {
    (-at).max(at - 1.0).max_element()
}

/// The point nearest to `centre` at which planes of different faces meet, or `None` if all face one way.
fn sharp_point(tangents: &[Tangent], centre: DVec3) -> Option<DVec3> {
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for Tangent { foot, normal } in tangents {
        matrix += DMat3::from_cols(*normal * normal.x, *normal * normal.y, *normal * normal.z);
        right += *normal * normal.dot(*foot - centre);
    }
    let (values, axes) = eigen(matrix);
    let largest = values.max_element();
    let count = values.to_array().iter().filter(|&&value| value > FACES * largest).count();
    if !(largest > 0.0 && count >= 2) {
        return None;
    }
    let along = |i: usize| {
        let axis = axes.col(i);
        if values[i] > FACES * largest { axis * (axis.dot(right) / values[i]) } else { DVec3::ZERO }
    };
    Some(centre + along(0) + along(1) + along(2))
}

/// A point of the smooth face above or below `centre`. On a curved face a tangent plane lies above the surface's top by
/// as much as its foot lies below it.
fn smooth_point(tangents: &[Tangent], centre: DVec3) -> DVec3 {
    let by_distance =
        |a: &&Tangent, b: &&Tangent| a.foot.distance_squared(centre).total_cmp(&b.foot.distance_squared(centre));
    let Some(nearest) = tangents.iter().min_by(by_distance) else {
        return centre;
    };
    let face: Vec<&Tangent> = tangents.iter().filter(|t| t.normal.dot(nearest.normal) > SAME_FACE).collect();
    let normal = face.iter().map(|t| t.normal).sum::<DVec3>().normalize();
    let height: f64 = face.iter().map(|t| normal.lerp(t.normal, BALANCE).dot(t.foot - centre)).sum();
    centre + normal * (height / face.len() as f64)
}

/// Eigenvalues of a symmetric matrix and their unit eigenvectors as columns, by Jacobi rotations.
fn eigen(mut matrix: DMat3) -> (DVec3, DMat3) {
    let mut axes = DMat3::IDENTITY;
    for _ in 0..8 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let off = matrix.col(q)[p];
            if off.abs() < 1e-15 {
                continue;
            }
            let angle = 0.5 * (2.0 * off).atan2(matrix.col(q)[q] - matrix.col(p)[p]);
            let (sin, cos) = angle.sin_cos();
            let mut turn = DMat3::IDENTITY;
            turn.col_mut(p)[p] = cos;
            turn.col_mut(q)[q] = cos;
            turn.col_mut(p)[q] = -sin;
            turn.col_mut(q)[p] = sin;
            matrix = turn.transpose() * matrix * turn;
            axes *= turn;
        }
    }
    (DVec3::new(matrix.x_axis.x, matrix.y_axis.y, matrix.z_axis.z), axes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plane(normal: DVec3, through: DVec3, foot_of: DVec3) -> Tangent {
        let normal = normal.normalize();
        Tangent { foot: foot_of - normal * normal.dot(foot_of - through), normal }
    }

    #[test]
    fn three_planes_meet_in_their_corner_and_two_in_their_edge() {
        let corner = DVec3::new(0.3, 0.6, 0.45);
        let normals = [DVec3::new(1.0, 0.2, 0.1), DVec3::new(-0.1, 1.0, 0.0), DVec3::new(0.2, -0.3, 1.0)];
        let tangents: Vec<Tangent> = normals.iter().map(|&n| plane(n, corner, DVec3::splat(0.5))).collect();
        let vertex = place(tangents.clone(), DVec3::splat(0.5), |_| true);
        assert!(vertex.shape == Shape::Outer && vertex.at.distance(corner) < 1e-12, "{vertex:?}");
        let vertex = place(tangents[..2].to_vec(), DVec3::splat(0.5), |_| true);
        let edge = normals[0].cross(normals[1]).normalize();
        assert!(vertex.shape == Shape::Outer && (vertex.at - corner).reject_from(edge).length() < 1e-12, "{vertex:?}");
    }

    #[test]
    fn an_edge_beyond_the_cell_is_none_of_its_own() {
        let tangents = vec![
            plane(DVec3::X, DVec3::splat(0.4), DVec3::new(1.0, 0.0, 0.5)),
            plane(DVec3::X, DVec3::splat(0.4), DVec3::new(1.0, 1.0, 0.5)),
            plane(DVec3::Y, DVec3::splat(1.6), DVec3::new(0.0, 1.0, 0.5)),
        ];
        let vertex = place(tangents.clone(), DVec3::new(0.3, 0.5, 0.5), |at| at == IVec3::Y);
        assert!(vertex.shape == Shape::Smooth && vertex.at.distance(DVec3::new(0.4, 0.5, 0.5)) < 1e-12, "{vertex:?}");
        let vertex = place(tangents, DVec3::new(0.3, 0.5, 0.5), |_| false);
        assert!(
            vertex.shape == Shape::Outer && vertex.at.distance(DVec3::new(0.4, 1.6, 0.5)) < 1e-12,
            "the edge of a tip: {vertex:?}"
        );
    }

    #[test]
    fn on_a_ball_the_vertex_is_on_the_ball() {
        let (centre, radius) = (DVec3::new(0.5, 0.5, -9.5), 10.0);
        let tangents = [(0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 0.0, 1.0)];
        let tangents = tangents.iter().map(|&(x, y, z)| {
            let normal = (DVec3::new(x, y, z) - centre).normalize();
            Tangent { foot: centre + normal * radius, normal }
        });
        let vertex = place(tangents.collect(), DVec3::splat(0.5), |_| true);
        let lift = vertex.at.distance(centre) - radius;
        assert!(lift > 0.0 && lift < 0.02, "lifted by about a sixth of the curvature, not by {lift}");
    }
}
