//! Closed solids with their vertices on lattice points, each with a formula for inside.

use glam::DVec3;
use sdf_bake::Mesh;

/// Negative inside; the magnitude is at most the distance to the surface, in the mesh's unit.
type Depth = Box<dyn Fn(DVec3) -> f64 + Sync + Send>;

/// A solid of 12 to 20 units, to be scaled to voxels.
pub(crate) struct Solid {
    pub(crate) name: &'static str,
    pub(crate) mesh: Mesh,
    pub(crate) depth: Depth,
}

/// A vertical prism over a polygon, counter-clockwise from above, whose first corner sees all others.
fn prism(outline: &[(f64, f64)], low: f64, high: f64) -> Mesh {
    let count = outline.len() as u32;
    let ring = |z: f64| outline.iter().map(move |&(x, y)| DVec3::new(x, y, z));
    let mut triangles = Vec::new();
    for i in 0..count {
        let next = (i + 1) % count;
        triangles.extend([[i, next, count + next], [i, count + next, count + i]]);
        if (1..count - 1).contains(&i) {
            triangles.extend([[0, next, i], [count, count + i, count + next]]);
        }
    }
    Mesh { positions: ring(low).chain(ring(high)).collect(), triangles }
}

pub(crate) fn cuboid(low: DVec3, high: DVec3) -> Mesh {
    prism(&[(low.x, low.y), (high.x, low.y), (high.x, high.y), (low.x, high.y)], low.z, high.z)
}

/// A frame: a rectangle with a rectangular hole.
fn frame(outer: [DVec3; 2], inner: [DVec3; 2]) -> Mesh {
    let ring = |[low, high]: [DVec3; 2], z: f64| {
        [(low.x, low.y), (high.x, low.y), (high.x, high.y), (low.x, high.y)].map(|(x, y)| DVec3::new(x, y, z))
    };
    let heights = [outer[0].z, outer[1].z];
    let positions = heights.iter().flat_map(|&z| [ring(outer, z), ring(inner, z)].concat()).collect();
    let mut triangles = Vec::new();
    for i in 0..4 {
        let next = (i + 1) % 4;
        let mut quad = |a: u32, b: u32, c: u32, d: u32| triangles.extend([[a, b, c], [a, c, d]]);
        quad(8 + i, 8 + next, 12 + next, 12 + i);
        quad(4 + i, 4 + next, next, i);
        quad(i, next, 8 + next, 8 + i);
        quad(12 + i, 12 + next, 4 + next, 4 + i);
    }
    Mesh { positions, triangles }
}

/// A ball of quads, poles on the z axis.
fn ball(centre: DVec3, radius: f64) -> Mesh {
    let (around, bands) = (8u32, 4u32);
    let mut mesh = Mesh { positions: vec![centre - DVec3::Z * radius, centre + DVec3::Z * radius], triangles: vec![] };
    for row in 1..bands {
        let (sine, cosine) = (std::f64::consts::PI * f64::from(row) / f64::from(bands)).sin_cos();
        mesh.positions.extend((0..around).map(|i| {
            let (y, x) = (std::f64::consts::TAU * f64::from(i) / f64::from(around)).sin_cos();
            centre + radius * DVec3::new(sine * x, sine * y, -cosine)
        }));
    }
    let at = |row: u32, i: u32| 2 + (row - 1) * around + i % around;
    for i in 0..around {
        mesh.triangles.extend([[0, at(1, i + 1), at(1, i)], [1, at(bands - 1, i), at(bands - 1, i + 1)]]);
        for row in 1..bands - 1 {
            let [a, b, c, d] = [at(row, i), at(row, i + 1), at(row + 1, i + 1), at(row + 1, i)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

/// Height above the highest plane of a convex mesh.
fn convex(mesh: &Mesh) -> Depth {
    let mut planes: Vec<(DVec3, f64)> = Vec::new();
    for t in 0..mesh.triangles.len() {
        let normal = mesh.normal(t);
        if planes.iter().all(|(other, _)| other.dot(normal) < 1.0 - 1e-12) {
            planes.push((normal, normal.dot(mesh.corners(t)[0])));
        }
    }
    Box::new(move |p| planes.iter().map(|&(normal, at)| normal.dot(p) - at).fold(f64::NEG_INFINITY, f64::max))
}

fn of_convex(name: &'static str, mesh: Mesh) -> Solid {
    Solid { name, depth: convex(&mesh), mesh }
}

fn box_depth(low: DVec3, high: DVec3) -> impl Fn(DVec3) -> f64 + Sync + Send {
    move |p| (low - p).max(p - high).max_element()
}

fn of_parts(mut first: Mesh, second: &Mesh) -> Mesh {
    first.append(second);
    first
}

fn turned_inside_out(mut mesh: Mesh) -> Mesh {
    mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    mesh
}

/// Solids around lattice points: flat and sloped faces, a hole, a cavity, two overlapping bodies.
pub(crate) fn twelve() -> Vec<Solid> {
    let v = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let hexagon: Vec<(f64, f64)> = (0..6)
        .map(|i| (f64::from(i) * std::f64::consts::FRAC_PI_3).sin_cos())
        .map(|(y, x)| (9.0 * x, 9.0 * y))
        .collect();
    let stairs = [(0.0, 0.0), (16.0, 0.0), (16.0, 5.0), (8.0, 5.0), (8.0, 14.0), (0.0, 14.0)];
    let corners = [v(-3.0, -3.0, -3.0), v(17.0, -3.0, -3.0), v(-3.0, 17.0, -3.0), v(-3.0, -3.0, 17.0)];
    let tips =
        [v(9.0, 0.0, 0.0), v(0.0, 9.0, 0.0), v(-9.0, 0.0, 0.0), v(0.0, -9.0, 0.0), v(0.0, 0.0, 9.0), v(0.0, 0.0, -9.0)];
    let eight = (0..4).flat_map(|i| [[i, (i + 1) % 4, 4], [(i + 1) % 4, i, 5]]).collect();
    let (outer, inner) = ([v(-8.0, -8.0, -3.0), v(8.0, 8.0, 4.0)], [v(-4.0, -3.0, -3.0), v(3.0, 4.0, 4.0)]);
    let (hull, cavity) = ([v(-8.0, 0.0, -8.0), v(8.0, 13.0, 8.0)], [v(-4.0, 4.0, -4.0), v(4.0, 8.0, 4.0)]);
    let (left, right) = ([v(0.0, 0.0, 0.0), v(12.0, 10.0, 8.0)], [v(8.0, 3.0, -4.0), v(18.0, 14.0, 4.0)]);
    let of_box = |[low, high]: [DVec3; 2]| cuboid(low, high);
    let depth_of = |[low, high]: [DVec3; 2]| box_depth(low, high);
    let (in_stairs, in_frame) = (
        [box_depth(v(0.0, 0.0, 0.0), v(16.0, 5.0, 8.0)), box_depth(v(0.0, 0.0, 0.0), v(8.0, 14.0, 8.0))],
        [depth_of(outer), box_depth(inner[0].with_z(-99.0), inner[1].with_z(99.0))],
    );
    let (in_hollow, in_pair) = ([depth_of(hull), depth_of(cavity)], [depth_of(left), depth_of(right)]);
    vec![
        of_convex("box at the origin", cuboid(DVec3::ZERO, v(18.0, 18.0, 12.0))),
        of_convex("thin plate", cuboid(v(0.0, 0.0, -0.9), v(20.0, 20.0, 3.0))),
        of_convex("cube of bricks", cuboid(DVec3::splat(-8.0), DVec3::splat(8.0))),
        of_convex(
            "tetrahedron",
            Mesh { positions: corners.to_vec(), triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]] },
        ),
        of_convex("octahedron", Mesh { positions: tips.to_vec(), triangles: eight }),
        of_convex("hexagonal prism", prism(&hexagon, -6.0, 8.0)),
        of_convex("wedge", prism(&[(0.0, 0.0), (16.0, 0.0), (0.0, 8.0)], 0.0, 16.0)),
        of_convex("ball", ball(v(1.0, -2.0, 0.0), 9.0)),
        Solid {
            name: "stairs",
            mesh: prism(&stairs, 0.0, 8.0),
            depth: Box::new(move |p| in_stairs[0](p).min(in_stairs[1](p))),
        },
        Solid {
            name: "frame",
            mesh: frame(outer, inner),
            depth: Box::new(move |p| in_frame[0](p).max(-in_frame[1](p))),
        },
        Solid {
            name: "hollow box",
            mesh: of_parts(of_box(hull), &turned_inside_out(of_box(cavity))),
            depth: Box::new(move |p| in_hollow[0](p).max(-in_hollow[1](p))),
        },
        Solid {
            name: "two boxes that overlap",
            mesh: of_parts(of_box(left), &of_box(right)),
            depth: Box::new(move |p| in_pair[0](p).min(in_pair[1](p))),
        },
    ]
}
