//! Position of the vertex of a piece of the surface.
//!
//! Every voxel has a tangent plane: through its closest surface point, perpendicular to its gradient. The planes of a
//! cell's corners meet in the edge or corner of the surface within the cell, which is the point where the sum of the
//! squared distances from them is minimal (Ju et al. 2002, "Dual contouring of Hermite data", whose data were at
//! crossed edges).

use glam::{DMat3, DVec3, IVec3};

use crate::grid::cell_corner;
use crate::tangent::Tangent;

/// Greatest distance outside its cell at which an edge of the surface is accepted, and a closest point used [voxels].
const MARGIN: f64 = 0.1;
/// [`MARGIN`] if the surface does not cross the cell that contains the edge, or if both faces have points in this cell.
const TIP: f64 = 0.7;
/// Greatest distance outside the cell of the closest points of voxels around it [voxels].
const WIDER: f64 = 1.1;
/// Greatest distance between the intersection point and each of its planes [voxels].
const CONSISTENT: f64 = 0.02;
/// Weight of the tangents' own normals in the height of a smooth face; the rest is the mean normal's. One half would
/// put vertices on the surface; one third more lifts them by a twelfth of the curvature, as much as the triangles sag
/// between them.
const BALANCE: f64 = 5.0 / 6.0;
/// Share of the largest eigenvalue above which planes count as facing in different directions: normals about 23° apart.
const FACES: f64 = 0.04;
/// Cosine of the angle within which planes belong to one smooth face.
const SAME_FACE: f64 = 0.7;

/// Cosine of the angle from the mean normal within which planes may belong to one curved face.
const CURVED: f64 = 0.8;
/// Root mean square distance between the planes of a curved face and their intersection point [voxels].
const MISSED: f64 = 0.045;
/// |φ| of the trilinear field above which a point does not count as a point of a face [voxels].
const OFF_FACE: f64 = 0.15;
/// Greatest |φ| of the trilinear field on a sharp edge or corner [voxels].
const OFF_EDGE: f64 = 0.6;

/// Number of alternating projections onto a plane and into the cell.
const ONTO_PLANE: usize = 8;

/// Number of bisections towards φ = 0.
const HALVINGS: usize = 20;

/// A vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    /// Position in the cell, 0 to 1 on each axis, or next to it.
    pub(super) at: DVec3,
    pub(super) shape: Shape,
    /// The same position or, if that is not well within the cell, a position near it that is.
    pub(super) home: DVec3,
}

/// Shape of the surface at a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Smooth,
    /// On a convex edge or corner.
    Outer,
    /// On a concave edge or corner.
    Inner,
}

/// Data around a piece of the surface in a cell; positions in voxels from the cell's lowest corner.
pub(super) struct Site<'a> {
    /// Tangents of the corners next to the piece.
    pub(super) tangents: Vec<Tangent>,
    /// Mean of the piece's edge crossings.
    pub(super) centre: DVec3,
    /// φ at the cell's corners, relative to the level below which they are inside [voxels].
    pub(super) phi: [f64; 8],
    /// Distance of homes from the borders of their cell [voxels], equal to minus that level.
    pub(super) inset: f64,
    /// φ [voxels], trilinear, up to a voxel outside the cell.
    pub(super) height: &'a dyn Fn(DVec3) -> f64,
    /// Returns true if the surface crosses the cell at an offset from this one.
    pub(super) is_crossed: &'a dyn Fn(IVec3) -> bool,
    /// Tangents of more voxels around; `None` if those of all corners are known.
    pub(super) wider: Option<&'a dyn Fn() -> Vec<Tangent>>,
}

impl Site<'_> {
    /// Computes the piece's vertex.
    pub(super) fn vertex(mut self) -> Vertex {
        let (at, shape) = self.place();
        Vertex { at, shape, home: self.home(at, shape) }
    }

    /// Position well within the cell for a vertex that is not: on one of the planes and near all faces that they form.
    /// Near an edge the planes are exact, but the trilinear field is not.
    fn home(&self, at: DVec3, shape: Shape) -> DVec3 {
        let within = |at: DVec3| at.clamp(DVec3::splat(self.inset), DVec3::splat(1.0 - self.inset));
        let near = within(at);
        if (near - at).abs().max_element() <= self.inset {
            return within(self.near_field(near));
        }
        let off = |at: DVec3| {
            let heights = self.tangents.iter().map(|t| t.normal.dot(at - t.foot));
            match shape {
                Shape::Smooth => (self.height)(at).abs(),
                Shape::Outer => heights.fold(f64::NEG_INFINITY, f64::max).abs(),
                Shape::Inner => heights.fold(f64::INFINITY, f64::min).abs(),
            }
        };
        let onto = |t: &Tangent| (0..ONTO_PLANE).fold(near, |at, _| within(at - t.normal * t.normal.dot(at - t.foot)));
        let best = self.tangents.iter().map(onto).min_by(|a, b| off(*a).total_cmp(&off(*b)));
        within(self.near_field(best.unwrap_or(near)))
    }

    fn place(&mut self) -> (DVec3, Shape) {
        // Most cells are smooth, and have no edge near them.
        let is_smooth = self.wider.is_none() && all_face_one_way(&self.tangents);
        if !is_smooth && let Some(vertex) = self.sharp_vertex(&self.tangents, MARGIN) {
            return vertex;
        }
        // The edge may be outside this cell, and a voxel's closest point beyond it. If both faces have points in this
        // cell, the edge is close.
        self.tangents.retain(|tangent| outside_by(tangent.foot) <= MARGIN);
        if !is_smooth && let Some(vertex) = self.sharp_vertex(&self.tangents, TIP) {
            return vertex;
        }
        let by_distance = |a: &&Tangent, b: &&Tangent| {
            a.foot.distance_squared(self.centre).total_cmp(&b.foot.distance_squared(self.centre))
        };
        let Some(nearest) = self.tangents.iter().min_by(by_distance) else {
            return (self.near_field(self.centre), Shape::Smooth);
        };
        // The edge may be in this cell although no corner of the cell has a tangent on its other face.
        let sharp = self.wider.and_then(|wider| {
            let mut wider = wider();
            wider.retain(|tangent| outside_by(tangent.foot) <= WIDER);
            if make_consistent(&mut wider, self.centre) { self.sharp_vertex(&wider, MARGIN) } else { None }
        });
        sharp.unwrap_or_else(|| (self.face_point(nearest), Shape::Smooth))
    }

    /// Returns a point of the nearest face in the cell and near φ = 0. If planes of several faces meet outside and the
    /// field is far from 0 at that point, returns the point of the plane at which φ is nearest to 0.
    fn face_point(&self, nearest: &Tangent) -> DVec3 {
        let within = |at: DVec3| at.clamp(DVec3::ZERO, DVec3::ONE);
        let off = |at: &DVec3| (self.height)(*at).abs();
        let on_face = within(smooth_point(&self.tangents, nearest, self.centre));
        if off(&on_face) <= OFF_FACE {
            return on_face;
        }
        if all_face_one_way(&self.tangents) {
            return self.near_field(on_face);
        }
        let on_plane = |t: &Tangent| within(self.centre - t.normal * t.normal.dot(self.centre - t.foot));
        let on_planes = self.tangents.iter().map(on_plane);
        let best = std::iter::once(on_face).chain(on_planes).min_by(|a, b| off(a).total_cmp(&off(b)));
        self.near_field(best.unwrap_or(on_face))
    }

    /// Returns the point itself or, if the field is farther from 0 there than on an edge, a point on φ = 0.
    fn near_field(&self, at: DVec3) -> DVec3 {
        if (self.height)(at).abs() <= OFF_EDGE { at } else { onto_zero(at, &self.phi, self.inset, self.height) }
    }

    /// Returns the vertex at the intersection of the planes, if it is at most `margin` outside the cell or no other
    /// cell represents it.
    fn sharp_vertex(&self, tangents: &[Tangent], margin: f64) -> Option<(DVec3, Shape)> {
        let sharp = sharp_point(tangents, self.centre)?;
        let at = sharp.along.and_then(|along| clipped(sharp.at, along)).unwrap_or(sharp.at);
        // A tip may lie in a cell whose corners are all on one side: then no other vertex represents it.
        let alone = outside_by(at) <= TIP && !(self.is_crossed)(at.floor().as_ivec3());
        let near = outside_by(at) <= margin || alone;
        let meets = near && !is_curved(tangents, at) && (self.height)(at).abs() <= OFF_EDGE;
        meets.then(|| (at, self.bend(tangents)))
    }

    /// Outer if φ is closer to the greatest height above the planes than to the least.
    fn bend(&self, tangents: &[Tangent]) -> Shape {
        let (mut outer, mut inner) = (0.0, 0.0);
        for (i, phi) in self.phi.iter().enumerate() {
            let heights = tangents.iter().map(|t| t.normal.dot(cell_corner(i).as_dvec3() - t.foot));
            outer += (heights.clone().fold(f64::NEG_INFINITY, f64::max) - phi).abs();
            inner += (heights.fold(f64::INFINITY, f64::min) - phi).abs();
        }
        if outer <= inner { Shape::Outer } else { Shape::Inner }
    }
}

/// Returns the point on φ = 0 on the segment from a point of a cell to the nearest corner on the other side; `phi` at
/// the corners, `inset` and `height` as in [`Site`].
pub(super) fn onto_zero(at: DVec3, phi: &[f64; 8], inset: f64, height: impl Fn(DVec3) -> f64) -> DVec3 {
    let is_inside_at = |at: DVec3| height(at) < -inset;
    let is_inside = is_inside_at(at);
    let beyond = (0..8).filter(|&i| (phi[i] < 0.0) != is_inside).map(|i| cell_corner(i).as_dvec3());
    let nearest = beyond.min_by(|a, b| a.distance_squared(at).total_cmp(&b.distance_squared(at)));
    let (mut near, mut far) = (at, nearest.expect("a crossed cell has corners on both sides"));
    for _ in 0..HALVINGS {
        let middle = 0.5 * (near + far);
        if is_inside_at(middle) == is_inside { near = middle } else { far = middle }
    }
    near
}

/// Removes planes that miss the intersection point of the others, the farthest first. Returns true if at least half of
/// them remain. On a curved face hardly any planes meet.
fn make_consistent(tangents: &mut Vec<Tangent>, centre: DVec3) -> bool {
    let least = tangents.len().div_ceil(2);
    while let Some(SharpPoint { at, .. }) = sharp_point(tangents, centre) {
        let away = |t: &Tangent| t.normal.dot(at - t.foot).abs();
        let farthest = (0..tangents.len()).max_by(|&a, &b| away(&tangents[a]).total_cmp(&away(&tangents[b])));
        match farthest.filter(|&i| away(&tangents[i]) > CONSISTENT) {
            Some(_) if tangents.len() <= least => return false,
            Some(i) => tangents.remove(i),
            None => return true,
        };
    }
    false
}

/// True if similar planes miss their intersection point, as those of a strongly curved face do.
fn is_curved(tangents: &[Tangent], at: DVec3) -> bool {
    let mean = tangents.iter().map(|t| t.normal).sum::<DVec3>().normalize_or_zero();
    let missed: f64 = tangents.iter().map(|t| t.normal.dot(at - t.foot).powi(2)).sum();
    tangents.iter().all(|t| t.normal.dot(mean) > CURVED) && missed > tangents.len() as f64 * MISSED * MISSED
}

/// Distance of a point outside the unit cell on the axis where it is greatest.
pub(super) fn outside_by(at: DVec3) -> f64 {
    (-at).max(at - 1.0).max_element()
}

/// Returns the point of a line nearest to `at` within the cell and its margin; `None` if the line misses them.
fn clipped(at: DVec3, along: DVec3) -> Option<DVec3> {
    let (a, b) = ((-MARGIN - at) / along, (1.0 + MARGIN - at) / along);
    let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
    (enter <= leave).then(|| at + along * 0f64.clamp(enter, leave))
}

/// Intersection of planes of different faces.
struct SharpPoint {
    at: DVec3,
    /// Direction of the intersection line, if it is a line.
    along: Option<DVec3>,
}

/// Returns the point nearest to `centre` at which planes of different faces meet; `None` if all face in one direction.
fn sharp_point(tangents: &[Tangent], centre: DVec3) -> Option<SharpPoint> {
    if all_face_one_way(tangents) {
        return None;
    }
    let (mut matrix, mut right) = (DMat3::ZERO, DVec3::ZERO);
    for Tangent { foot, normal } in tangents {
        matrix += DMat3::from_cols(*normal * normal.x, *normal * normal.y, *normal * normal.z);
        right += *normal * normal.dot(*foot - centre);
    }
    let (values, axes) = eigen(matrix);
    let largest = values.max_element();
    let faces = values.to_array().map(|value| value > FACES * largest);
    let count = faces.iter().filter(|&&faces| faces).count();
    if !(largest > 0.0 && count >= 2) {
        return None;
    }
    let step = |i: usize| {
        let axis = axes.col(i);
        if faces[i] { axis * (axis.dot(right) / values[i]) } else { DVec3::ZERO }
    };
    let along = (0..3).find(|&i| !faces[i]).map(|i| axes.col(i));
    Some(SharpPoint { at: centre + step(0) + step(1) + step(2), along })
}

/// True if the planes have only one large eigenvalue, by a cheap bound: it is at least the sum of squares along the
/// mean normal, and all three add up to the number of planes.
fn all_face_one_way(tangents: &[Tangent]) -> bool {
    let mean = tangents.iter().map(|t| t.normal).sum::<DVec3>().normalize_or_zero();
    let along: f64 = tangents.iter().map(|t| t.normal.dot(mean).powi(2)).sum();
    let across: f64 = tangents.iter().map(|t| t.normal.reject_from_normalized(mean).length_squared()).sum();
    across < FACES * along
}

/// Returns a point above or below `centre` on the smooth face to which one of the tangents belongs. On a curved face a
/// tangent plane lies above the surface's top by as much as its foot lies below it.
fn smooth_point(tangents: &[Tangent], one: &Tangent, centre: DVec3) -> DVec3 {
    let face = tangents.iter().filter(|t| t.normal.dot(one.normal) > SAME_FACE);
    let normal = face.clone().map(|t| t.normal).sum::<DVec3>().normalize();
    let heights = face.map(|t| normal.lerp(t.normal, BALANCE).dot(t.foot - centre));
    let (sum, count) = heights.fold((0.0, 0.0), |(sum, count), height| (sum + height, count + 1.0));
    centre + normal * (sum / count)
}

/// Eigenvalues of a symmetric matrix and their unit eigenvectors as columns, by Jacobi rotations (Golub & Van Loan
/// 2013, section 8.5).
fn eigen(mut matrix: DMat3) -> (DVec3, DMat3) {
    let mut axes = DMat3::IDENTITY;
    let small = 1e-14 * (matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z);
    for _ in 0..8 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let off = matrix.col(q)[p];
            if off.abs() <= small {
                continue;
            }
            let ratio = (matrix.col(q)[q] - matrix.col(p)[p]) / (2.0 * off);
            let tan = 1f64.copysign(ratio) / (ratio.abs() + (ratio * ratio + 1.0).sqrt());
            let cos = (tan * tan + 1.0).sqrt().recip();
            let turned = |m: &DMat3| [cos * m.col(p) - cos * tan * m.col(q), cos * tan * m.col(p) + cos * m.col(q)];
            for _ in 0..2 {
                [*matrix.col_mut(p), *matrix.col_mut(q)] = turned(&matrix);
                matrix = matrix.transpose();
            }
            [*axes.col_mut(p), *axes.col_mut(q)] = turned(&axes);
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

    fn vertex(tangents: &[Tangent], centre: DVec3, is_crossed: &dyn Fn(IVec3) -> bool) -> Vertex {
        let heights = |at: DVec3| tangents.iter().map(move |t| t.normal.dot(at - t.foot));
        let phi = std::array::from_fn(|i| heights(cell_corner(i).as_dvec3()).fold(f64::NEG_INFINITY, f64::max));
        let height = |at: DVec3| heights(at).fold(f64::NEG_INFINITY, f64::max);
        Site {
            tangents: tangents.to_vec(),
            centre,
            phi,
            inset: 0.0,
            height: &height,
            is_crossed,
            wider: Some(&Vec::new),
        }
        .vertex()
    }

    #[test]
    fn three_planes_meet_in_their_corner_and_two_in_their_edge() {
        let (corner, within) = (DVec3::new(0.3, 0.6, 0.45), DVec3::new(0.1, 0.3, 0.2));
        let normals = [DVec3::new(1.0, 0.2, 0.1), DVec3::new(-0.1, 1.0, 0.0), DVec3::new(0.2, -0.3, 1.0)];
        let tangents: Vec<Tangent> = normals.iter().map(|&n| plane(n, corner, within)).collect();
        let found = vertex(&tangents, DVec3::splat(0.5), &|_| true);
        assert!(found.shape == Shape::Outer && found.at.distance(corner) < 1e-12, "{found:?}");
        let found = vertex(&tangents[..2], DVec3::splat(0.5), &|_| true);
        let edge = normals[0].cross(normals[1]).normalize();
        assert!(found.shape == Shape::Outer && (found.at - corner).reject_from(edge).length() < 1e-12, "{found:?}");
    }

    #[test]
    fn an_edge_beyond_the_cell_is_its_own_only_where_no_other_cell_has_it() {
        let tangents = [
            plane(DVec3::X, DVec3::splat(0.4), DVec3::new(1.0, 0.0, 0.5)),
            plane(DVec3::X, DVec3::splat(0.4), DVec3::new(1.0, 1.0, 0.5)),
            plane(DVec3::Y, DVec3::splat(1.6), DVec3::new(0.0, 1.0, 0.5)),
        ];
        let centre = DVec3::new(0.3, 0.5, 0.5);
        let found = vertex(&tangents, centre, &|at| at == IVec3::Y);
        assert!(found.shape == Shape::Smooth && found.at.distance(DVec3::new(0.4, 0.5, 0.5)) < 1e-12, "{found:?}");
        let found = vertex(&tangents, centre, &|_| false);
        assert!(found.shape == Shape::Outer && found.at.distance(DVec3::new(0.4, 1.6, 0.5)) < 1e-12, "{found:?}");
    }

    #[test]
    fn on_a_ball_the_vertex_is_lifted_by_what_the_triangles_sag() {
        let (centre, radius) = (DVec3::new(0.5, 0.5, -9.5), 10.0);
        let tangents = [(0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 0.0, 1.0)];
        let tangents = tangents.map(|(x, y, z)| {
            let normal = (DVec3::new(x, y, z) - centre).normalize();
            Tangent { foot: centre + normal * radius, normal }
        });
        let found = vertex(&tangents, DVec3::splat(0.5), &|_| true);
        let lift = found.at.distance(centre) - radius;
        assert!(lift > 0.0 && lift < 0.02, "{lift} where a sixth of the curvature is wanted");
    }
}
