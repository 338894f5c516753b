use glam::DVec3;

use super::{MeshQuery, closest_on_triangle};
use crate::Mesh;

/// Numbers in [0, 1) from a fixed recurrence (splitmix64), so that failures are reproducible.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / 2f64.powi(64)
    }

    fn point(&mut self) -> DVec3 {
        2.0 * DVec3::new(self.next(), self.next(), self.next()) - 1.0
    }
}

/// A closed torus around z, far from the origin of coordinates, shape `[2·rings·sides, 3]`.
fn torus(rings: u32, sides: u32, offset: DVec3) -> Mesh {
    let vertex = |i: u32, j: u32| {
        let (turn, roll) = (f64::from(i) / f64::from(rings), f64::from(j) / f64::from(sides));
        let (turn, roll) = (turn * std::f64::consts::TAU, roll * std::f64::consts::TAU);
        let radius = 1.0 + 0.3 * roll.cos();
        offset + DVec3::new(radius * turn.cos(), radius * turn.sin(), 0.3 * roll.sin())
    };
    let index = |i: u32, j: u32| (i % rings) * sides + j % sides;
    let cells = (0..rings).flat_map(|i| (0..sides).map(move |j| (i, j)));
    let quad = |(i, j): (u32, u32)| [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
    Mesh {
        positions: cells.clone().map(|(i, j)| vertex(i, j)).collect(),
        triangles: cells
            .flat_map(|cell| {
                let [a, b, c, d] = quad(cell);
                [[a, b, c], [a, c, d]]
            })
            .collect(),
    }
}

/// Triangles a million times longer than wide, in all directions.
fn slivers(count: u32) -> Mesh {
    let mut numbers = Numbers(5);
    let mut mesh = Mesh::default();
    for i in 0..count {
        let (start, end) = (numbers.point(), numbers.point());
        let third = start.lerp(end, numbers.next()) + 1e-6 * numbers.point();
        mesh.positions.extend([start, end, third]);
        mesh.triangles.push([3 * i, 3 * i + 1, 3 * i + 2]);
    }
    mesh
}

fn check_closest(mesh: &Mesh, points: impl Iterator<Item = DVec3>) {
    let query = MeshQuery::new(mesh);
    for point in points {
        let found = query.closest(point);
        let brute = (0..mesh.triangles.len())
            .map(|t| closest_on_triangle(mesh.corners(t), point).1.sqrt())
            .fold(f64::INFINITY, f64::min);
        assert!((found.distance - brute).abs() < 1e-13, "{point}: {} is not {brute}", found.distance);
        assert!((found.point.distance(point) - brute).abs() < 1e-13);
        let [a, b, c] = mesh.corners(found.triangle as usize);
        let [u, v, w] = found.barycentric;
        assert!((u * a + v * b + w * c).distance(found.point) < 1e-13);
        assert!(u >= 0.0 && v >= 0.0 && w >= 0.0 && (u + v + w - 1.0).abs() < 1e-14);
    }
}

#[test]
fn the_closest_point_is_the_one_an_exhaustive_search_finds() {
    let offset = DVec3::new(40.0, -3.0, 7.0);
    let mut numbers = Numbers(1);
    check_closest(&torus(40, 20, offset), (0..300).map(|_| offset + 1.5 * numbers.point()));
}

#[test]
fn slivers_lose_no_digits() {
    let mut numbers = Numbers(2);
    check_closest(&slivers(400), (0..300).map(|_| numbers.point()));
}

#[test]
fn a_point_near_a_sliver_is_as_far_as_its_longest_edge_says() {
    // The triangle is 1e-9 wide: its distance differs from that of the segment by no more.
    let corners = [DVec3::ZERO, DVec3::X, DVec3::new(0.4, 1e-9, 0.0)];
    let mut numbers = Numbers(3);
    for _ in 0..1000 {
        let point = numbers.point();
        let segment = point.distance(DVec3::X * point.x.clamp(0.0, 1.0));
        let (_, squared) = closest_on_triangle(corners, point);
        assert!((squared.sqrt() - segment).abs() <= 1.0001e-9, "{point}");
    }
}

#[test]
fn no_point_of_a_triangle_is_nearer_than_the_answer_and_the_best_sample_is_close_to_it() {
    let mut numbers = Numbers(6);
    for _ in 0..200 {
        let corners @ [a, b, c] = [numbers.point(), numbers.point(), numbers.point()];
        let point = 1.5 * numbers.point();
        let distance = closest_on_triangle(corners, point).1.sqrt();
        let steps = 100;
        let samples = (0..=steps).flat_map(|i| (0..=steps - i).map(move |j| (f64::from(i), f64::from(j))));
        let sampled = samples
            .map(|(i, j)| (a + (b - a) * (i / 100.0) + (c - a) * (j / 100.0)).distance(point))
            .fold(f64::INFINITY, f64::min);
        assert!(distance <= sampled + 1e-14 && sampled - distance < 0.05, "{distance} against {sampled}");
    }
}

#[test]
fn the_first_hit_is_the_one_an_exhaustive_search_finds() {
    for mesh in [torus(40, 20, DVec3::new(40.0, -3.0, 7.0)), slivers(400)] {
        let centre = mesh.bounds().map_or(DVec3::ZERO, |(low, high)| low.midpoint(high));
        let query = MeshQuery::new(&mesh);
        let mut numbers = Numbers(4);
        for _ in 0..300 {
            let (origin, direction) = (centre + 1.5 * numbers.point(), numbers.point());
            let brute = (0..mesh.triangles.len())
                .filter_map(|t| plane_hit(mesh.corners(t), origin, direction.normalize()))
                .fold(f64::INFINITY, f64::min);
            let found = query.ray(origin, direction, f64::INFINITY).map_or(f64::INFINITY, |hit| hit.distance);
            assert!(found == brute || (found - brute).abs() < 1e-9, "{origin} {direction}: {found} is not {brute}");
            assert_eq!(query.occluded(origin, direction, 1.0), found <= 1.0);
            assert!(query.ray(origin, direction, 0.999 * found.min(10.0)).is_none());
        }
    }
}

/// Intersection of ray and triangle by its plane and the signs of the foot's barycentric coordinates: a different
/// method from the library's.
fn plane_hit([a, b, c]: [DVec3; 3], origin: DVec3, direction: DVec3) -> Option<f64> {
    let normal = (b - a).cross(c - a);
    let distance = (a - origin).dot(normal) / direction.dot(normal);
    let point = origin + distance * direction;
    let side = |p: DVec3, q: DVec3| (q - p).cross(point - p).dot(normal) >= 0.0;
    (distance >= 0.0 && side(a, b) && side(b, c) && side(c, a)).then_some(distance)
}

#[test]
fn a_ray_from_inside_a_closed_surface_never_slips_through_an_edge() {
    let mesh = torus(24, 12, DVec3::ZERO);
    let query = MeshQuery::new(&mesh);
    let origin = DVec3::new(1.02, 0.01, 0.03);
    for [a, b, _] in &mesh.triangles {
        let (a, b) = (mesh.positions[*a as usize], mesh.positions[*b as usize]);
        for target in [a, b, a.midpoint(b), a.lerp(b, 0.3)] {
            assert!(query.ray(origin, target - origin, f64::INFINITY).is_some(), "through {target}");
        }
    }
}

#[test]
fn without_triangles_or_with_a_nan_nothing_is_near() {
    let empty = MeshQuery::new(&Mesh::default());
    assert_eq!(empty.closest(DVec3::ZERO).distance, f64::INFINITY);
    assert!(empty.ray(DVec3::ZERO, DVec3::X, 1.0).is_none() && !empty.occluded(DVec3::ZERO, DVec3::X, 1.0));

    let mut mesh = torus(8, 6, DVec3::ZERO);
    mesh.positions[3].x = f64::NAN;
    let query = MeshQuery::new(&mesh);
    assert!(query.closest(DVec3::ZERO).distance.is_finite());
    assert_eq!(query.closest(DVec3::NAN).distance, f64::INFINITY);
    assert!(query.ray(DVec3::ZERO, DVec3::ZERO, 1.0).is_none());
}

#[test]
fn a_flat_square_and_a_single_triangle_are_meshes_too() {
    let mesh = Mesh { positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y], triangles: vec![[0, 1, 2]] };
    let query = MeshQuery::new(&mesh);
    assert_eq!(query.closest(DVec3::new(2.0, 0.0, 0.0)).point, DVec3::X);
    assert_eq!(query.closest_within(DVec3::new(2.0, 0.0, 0.0), 0.5), None);
    let hit = query.ray(DVec3::new(0.2, 0.2, -1.0), DVec3::Z, 2.0);
    assert_eq!(hit.map(|hit| hit.triangle), Some(0));
}
