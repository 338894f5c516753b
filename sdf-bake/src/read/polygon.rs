//! Polygons to triangles by constrained Delaunay triangulation.
//!
//! A fan is wrong for a concave face: it folds over itself.

use glam::{DVec2, DVec3};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use super::{Format, ReadError};
use crate::Mesh;

/// More corners than a face of any sensible file has; the cost of a crooked one grows with their square.
const MAX_CORNERS: usize = 10_000;

type Triangulated = ConstrainedDelaunayTriangulation<Point2<f64>>;

/// Adds a face's triangles to a mesh; `face` holds valid indices into its positions.
pub(super) fn append_face(
    mesh: &mut Mesh,
    format: Format,
    face: impl ExactSizeIterator<Item = u32>,
) -> Result<(), ReadError> {
    if face.len() > MAX_CORNERS {
        let reason = format!("a face has {} corners; up to {MAX_CORNERS} are accepted", face.len());
        return Err(ReadError::malformed(format, reason));
    }
    let face: Vec<u32> = face.collect();
    if let [a, b, c] = face[..] {
        mesh.triangles.push([a, b, c]);
        return Ok(());
    }
    let corners: Vec<_> = face.iter().map(|&vertex| mesh.positions[vertex as usize]).collect();
    mesh.triangles.extend(triangulate(&corners).into_iter().map(|t| t.map(|corner| face[corner])));
    Ok(())
}

/// Splits a polygon into triangles of the same orientation.
///
/// `corners`: positions in order. Returns indices into them; empty for fewer than three corners.
/// A polygon that crosses or touches itself, or is flat to a line, becomes a fan.
fn triangulate(corners: &[DVec3]) -> Vec<[usize; 3]> {
    match corners.len() {
        0..3 => Vec::new(),
        3 => vec![[0, 1, 2]],
        n => delaunay(corners).unwrap_or_else(|| (2..n).map(|i| [0, i - 1, i]).collect()),
    }
}

/// Constrained Delaunay triangulation of the polygon in its own plane, where the polygon is simple.
fn delaunay(corners: &[DVec3]) -> Option<Vec<[usize; 3]>> {
    let points = flatten(corners)?;
    let mut mesh = Triangulated::new();
    let mut handles = Vec::with_capacity(points.len());
    for (corner, p) in points.iter().enumerate() {
        let handle = mesh.insert(Point2::new(p.x, p.y)).ok()?;
        // Two corners at one place share a vertex: not a simple polygon.
        if handle.index() != corner {
            return None;
        }
        handles.push(handle);
    }
    for (i, &from) in handles.iter().enumerate() {
        let to = handles[(i + 1) % handles.len()];
        if !mesh.can_add_constraint(from, to) {
            return None;
        }
        mesh.add_constraint(from, to);
    }
    let inside = inside_faces(&mesh);
    let triangles: Vec<[usize; 3]> = mesh
        .inner_faces()
        .filter(|face| inside[face.index()])
        .map(|face| face.vertices().map(|vertex| vertex.fix().index()))
        .collect();
    (triangles.len() == corners.len() - 2).then_some(triangles)
}

/// Corners in the polygon's plane, scaled to about one; `None` where they have no extent.
fn flatten(corners: &[DVec3]) -> Option<Vec<DVec2>> {
    let size = corners.iter().map(|p| (p - corners[0]).abs().max_element()).fold(0.0, f64::max);
    if size.is_nan() || size <= 0.0 {
        return None;
    }
    let (u, v) = newell_normal(corners).any_orthonormal_pair();
    // Below this, spade takes no coordinate but zero.
    let tidy = |x: f64| if x.abs() < 1e-15 { 0.0 } else { x };
    let flat = |p: &DVec3| {
        let p = (p - corners[0]) / size;
        DVec2::new(tidy(p.dot(u)), tidy(p.dot(v)))
    };
    Some(corners.iter().map(flat).collect())
}

/// Whether each face lies in the polygon: from the face around everything, each side of the polygon leads in or out.
fn inside_faces(mesh: &Triangulated) -> Vec<bool> {
    let mut neighbours = vec![Vec::new(); mesh.num_all_faces()];
    for edge in mesh.undirected_edges() {
        let (one, other) = (edge.as_directed().face().index(), edge.as_directed().rev().face().index());
        neighbours[one].push((other, edge.is_constraint_edge()));
        neighbours[other].push((one, edge.is_constraint_edge()));
    }
    let mut inside = vec![None; neighbours.len()];
    let outer = mesh.outer_face().index();
    inside[outer] = Some(false);
    let mut stack = vec![(outer, false)];
    while let Some((face, is_inside)) = stack.pop() {
        for &(neighbour, crosses) in &neighbours[face] {
            if inside[neighbour].is_none() {
                inside[neighbour] = Some(is_inside != crosses);
                stack.push((neighbour, is_inside != crosses));
            }
        }
    }
    inside.into_iter().map(|is_inside| is_inside == Some(true)).collect()
}

/// Normal of a polygon, also of a slightly bent one (Newell's method, Sutherland et al. 1974).
fn newell_normal(corners: &[DVec3]) -> DVec3 {
    let origin = corners[0];
    let mut sum = DVec3::ZERO;
    for (i, &p) in corners.iter().enumerate() {
        sum += (p - origin).cross(corners[(i + 1) % corners.len()] - origin);
    }
    sum.try_normalize().unwrap_or(DVec3::Z)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn areas(corners: &[DVec3]) -> Vec<f64> {
        let normal = newell_normal(corners);
        let area = |[a, b, c]: [usize; 3]| (corners[b] - corners[a]).cross(corners[c] - corners[a]).dot(normal) / 2.0;
        triangulate(corners).into_iter().map(area).collect()
    }

    #[test]
    fn a_concave_polygon_is_covered_once() {
        let arrow = [(0.0, 0.0), (2.0, -1.0), (0.5, 0.0), (2.0, 1.0)];
        let corners = arrow.map(|(x, y)| DVec3::new(x, 3.0, -y));
        for turn in 0..4 {
            let mut turned = corners;
            turned.rotate_left(turn);
            let areas = areas(&turned);
            assert!(areas.iter().all(|&a| a > 0.1), "{areas:?}");
            assert!((areas.iter().sum::<f64>() - 0.5).abs() < 1e-12, "{areas:?}");
        }
    }

    #[test]
    fn corners_on_a_straight_side_give_no_empty_triangle() {
        let square = [(0., 0.), (1., 0.), (2., 0.), (2., 1.), (2., 2.), (1., 2.), (0., 2.), (0., 1.)];
        let corners = square.map(|(x, y)| DVec3::new(x, y, 0.0));
        let areas = areas(&corners);
        assert_eq!(areas.len(), 6);
        assert!(areas.iter().all(|&a| a > 0.4), "{areas:?}");
        assert!((areas.iter().sum::<f64>() - 4.0).abs() < 1e-12);
    }

    #[test]
    fn a_polygon_that_is_not_simple_still_has_its_number_of_triangles() {
        let bow_tie = [(0.0, 0.0), (1.0, 1.0), (1.0, 0.0), (0.0, 1.0)];
        let line = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (0.5, 0.0)];
        let point = [(3.0, 4.0); 5];
        for polygon in [&bow_tie[..], &line, &point] {
            let corners: Vec<_> = polygon.iter().map(|&(x, y)| DVec3::new(x, y, 7.0)).collect();
            assert_eq!(triangulate(&corners).len(), corners.len() - 2);
        }
    }
}
