//! Triangulates polygons: flat or concave ones by constrained Delaunay triangulation, a nonplanar quad around its
//! centre.
//!
//! A fan is wrong for a concave face, because it folds over itself. A diagonal is wrong for a nonplanar quad: the two
//! diagonals deviate from the bilinear patch by half their gap on opposite sides, and the file does not say which is
//! meant. The triangles of a face do not depend on its first corner or its direction.

use std::cmp::Ordering;

use glam::{DVec2, DVec3};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use super::{Format, ReadError, Surface};

/// Greatest number of corners of a face; the cost of a crooked face grows with the square of its corners.
const MAX_CORNERS: usize = 10_000;

/// Gap between the diagonals of a quad, as a share of its largest coordinate, up to which it counts as flat: text files
/// contain six digits or more.
const FLAT: f64 = 1e-6;

type Triangulated = ConstrainedDelaunayTriangulation<Point2<f64>>;

/// Adds a face's triangles to a surface; `face` holds valid indices into its positions.
pub(super) fn append_face(
    surface: &mut Surface,
    format: Format,
    face: impl ExactSizeIterator<Item = u32>,
) -> Result<(), ReadError> {
    if face.len() > MAX_CORNERS {
        let reason = format!("a face has {} corners; up to {MAX_CORNERS} are accepted", face.len());
        return Err(ReadError::malformed(format, reason));
    }
    let mut face: Vec<u32> = face.collect();
    let mesh = &mut surface.mesh;
    if let [a, b, c] = face[..] {
        mesh.triangles.push([a, b, c]);
        return Ok(());
    }
    let is_turned = turn_to_first(&mut face, &mesh.positions);
    let corners: Vec<_> = face.iter().map(|&vertex| mesh.positions[vertex as usize]).collect();
    let mut triangles = triangulate(&corners);
    if let Some(middle) = middle_of_bent_quad(&corners) {
        face.push(mesh.positions.len() as u32);
        mesh.positions.push(middle);
        surface.bent_quads += 1;
        triangles = (0..4).map(|i| [i, (i + 1) % 4, 4]).collect();
    }
    let of_face = |[a, b, c]: [usize; 3]| if is_turned { [a, c, b] } else { [a, b, c] }.map(|corner| face[corner]);
    mesh.triangles.extend(triangles.into_iter().map(of_face));
    Ok(())
}

/// Rotates a face to start at its first corner in the order of x, y and z, followed by the first of its neighbours.
/// Returns true if this reverses its direction.
fn turn_to_first(face: &mut [u32], positions: &[DVec3]) -> bool {
    let order = |a: u32, b: u32| {
        let [a, b] = [a, b].map(|vertex| positions[vertex as usize]);
        a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z))
    };
    let first = (0..face.len()).min_by(|&i, &j| order(face[i], face[j])).unwrap_or(0);
    face.rotate_left(first);
    let goes_back = face.len() > 2 && order(face[face.len() - 1], face[1]) == Ordering::Less;
    if goes_back {
        face[1..].reverse();
    }
    goes_back
}

/// Centre of the bilinear patch of four corners that are not in a plane. `None` if they are, or if the quad seen along
/// its normal is not strictly convex.
fn middle_of_bent_quad(corners: &[DVec3]) -> Option<DVec3> {
    let &[a, b, c, d] = corners else { return None };
    let normal = (c - a).cross(d - b).try_normalize()?;
    let gap = normal.dot(b - a).abs();
    let largest = corners.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let stands_out = |i: usize| {
        let [last, here, next] = [i + 3, i, i + 1].map(|i| corners[i % 4]);
        (here - last).cross(next - here).dot(normal) > 0.0
    };
    // Opposite corners are added first, so that the sum is the same in either direction.
    (gap > FLAT * largest && (0..4).all(stands_out)).then(|| 0.25 * ((a + c) + (b + d)))
}

/// Splits a polygon into triangles of the same orientation.
///
/// `corners`: positions in order. Returns indices into them; empty for fewer than three corners. A polygon that crosses
/// or touches itself, or is degenerate to a line, becomes a fan.
fn triangulate(corners: &[DVec3]) -> Vec<[usize; 3]> {
    match corners.len() {
        0..3 => Vec::new(),
        3 => vec![[0, 1, 2]],
        n => delaunay(corners).unwrap_or_else(|| (2..n).map(|i| [0, i - 1, i]).collect()),
    }
}

/// Constrained Delaunay triangulation of a simple polygon in its own plane; `None` if the polygon is not simple.
fn delaunay(corners: &[DVec3]) -> Option<Vec<[usize; 3]>> {
    let points = flatten(corners)?;
    let mut mesh = Triangulated::new();
    let mut handles = Vec::with_capacity(points.len());
    for (corner, p) in points.iter().enumerate() {
        let handle = mesh.insert(Point2::new(p.x, p.y)).ok()?;
        // Two corners at equal positions share a vertex: the polygon is not simple.
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

/// Corners in the polygon's plane, scaled to about one; `None` if they have no extent.
fn flatten(corners: &[DVec3]) -> Option<Vec<DVec2>> {
    let size = corners.iter().map(|p| (p - corners[0]).abs().max_element()).fold(0.0, f64::max);
    if size.is_nan() || size <= 0.0 {
        return None;
    }
    let (u, v) = newell_normal(corners).any_orthonormal_pair();
    // Below this, spade accepts no coordinate except zero.
    let tidy = |x: f64| if x.abs() < 1e-15 { 0.0 } else { x };
    let flat = |p: &DVec3| {
        let p = (p - corners[0]) / size;
        DVec2::new(tidy(p.dot(u)), tidy(p.dot(v)))
    };
    Some(corners.iter().map(flat).collect())
}

/// Marks the faces within the polygon: starting at the outer face, each side of the polygon changes between outside and
/// inside.
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

/// Normal of a polygon, including slightly nonplanar ones (Newell's method, Sutherland et al. 1974).
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

    /// Triangles of a face, as corners in order, for each start corner and both directions.
    fn all_starts(corners: &[DVec3]) -> Vec<Vec<[[u64; 3]; 3]>> {
        let starts = (0..2 * corners.len()).map(|start| {
            let mut face: Vec<u32> = (0..corners.len() as u32).collect();
            face.rotate_left(start % corners.len());
            let goes_back = start >= corners.len();
            if goes_back {
                face.reverse();
            }
            let mut surface = Surface::default();
            surface.mesh.positions = corners.to_vec();
            append_face(&mut surface, Format::Obj, face.into_iter()).unwrap();
            let bits = |t: usize| {
                let mut corners = surface.mesh.corners(t).map(|p| p.to_array().map(f64::to_bits));
                if goes_back {
                    corners.swap(1, 2);
                }
                corners
            };
            (0..surface.mesh.triangles.len()).map(bits).collect()
        });
        starts.collect()
    }

    #[test]
    fn a_bent_face_is_the_same_whatever_corner_it_starts_at() {
        let bent = |i: u32, of: u32| {
            let (y, x) = (std::f64::consts::TAU * f64::from(i) / f64::from(of)).sin_cos();
            DVec3::new(7.0 + x, y / 3.0, 0.1 * f64::from(i % 2) + 0.013 * x)
        };
        for count in [4, 5, 6, 9] {
            let corners: Vec<DVec3> = (0..count).map(|i| bent(i, count)).collect();
            let starts = all_starts(&corners);
            assert!(starts.iter().all(|triangles| *triangles == starts[0]), "{count} corners");
        }
    }

    #[test]
    fn a_bent_quad_follows_the_bilinear_patch_four_times_as_closely_as_a_diagonal() {
        let corners = [(0.0, 0.0, 0.0), (10.0, 0.0, 0.4), (10.0, 8.0, 0.0), (0.0, 8.0, 0.4)].map(DVec3::from);
        let mut surface = Surface::default();
        surface.mesh.positions = corners.to_vec();
        append_face(&mut surface, Format::Obj, 0..4).unwrap();
        assert_eq!((surface.bent_quads, surface.mesh.triangles.len()), (1, 4));
        let off = |triangles: &[[u32; 3]]| {
            let mesh = crate::Mesh { positions: surface.mesh.positions.clone(), triangles: triangles.to_vec() };
            let query = crate::query::MeshQuery::new(&mesh);
            let patch = |k: u32| {
                let (u, v) = (f64::from(k % 21) / 20.0, f64::from(k / 21) / 20.0);
                corners[0].lerp(corners[1], u).lerp(corners[3].lerp(corners[2], u), v)
            };
            (0..21 * 21).map(|k| query.closest(patch(k)).distance).fold(0.0, f64::max)
        };
        // The diagonals are 0.4 apart.
        for diagonal in [[[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]]] {
            assert!((off(&diagonal) - 0.2).abs() < 1e-3);
        }
        assert!(off(&surface.mesh.triangles) <= 0.05);
    }

    #[test]
    fn six_digits_do_not_bend_a_quad() {
        let quad = |lift: f64| {
            let corners = [(30.0, 0.0, 0.0), (40.0, 0.0, lift), (40.0, 8.0, 0.0), (30.0, 8.0, 0.0)];
            middle_of_bent_quad(&corners.map(DVec3::from))
        };
        assert_eq!((quad(0.0), quad(2e-5)), (None, None));
        assert_eq!(quad(1e-3), Some(DVec3::new(35.0, 4.0, 2.5e-4)));
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
