//! Meshes whose geodesics are known in closed form.

#![allow(dead_code)] // each test file uses its own few

use std::collections::HashMap;
use std::f64::consts::TAU;

use glam::DVec3;
use sdf_bake::Mesh;

/// Numbers in [0, 1) from a fixed recurrence (splitmix64), so that failures are reproducible.
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / 2f64.powi(64)
    }
}

/// A grid of `nu × nv` cells, each split into two triangles; `wrap` closes it along u.
pub(crate) fn sheet(nu: u32, nv: u32, wrap: bool, place: impl Fn(f64, f64) -> DVec3) -> Mesh {
    let columns = if wrap { nu } else { nu + 1 };
    let index = |i: u32, j: u32| (i % columns) * (nv + 1) + j;
    let vertex = |i: u32, j: u32| place(f64::from(i) / f64::from(nu), f64::from(j) / f64::from(nv));
    let cells = (0..nu).flat_map(|i| (0..nv).map(move |j| (i, j)));
    Mesh {
        positions: (0..columns).flat_map(|i| (0..=nv).map(move |j| (i, j))).map(|(i, j)| vertex(i, j)).collect(),
        triangles: cells
            .flat_map(|(i, j)| {
                let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
            .collect(),
    }
}

/// The square `[-size/2, size/2]²` in the plane z = 0, divided into the given numbers of cells and distorted unevenly.
pub(crate) fn plane(size: f64, nu: u32, nv: u32) -> Mesh {
    let mut numbers = Numbers(11);
    let mut mesh = sheet(nu, nv, false, |u, v| DVec3::new(u - 0.5, v - 0.5, 0.0) * size);
    let half = 0.5 * size * (1.0 - 1e-9);
    for p in &mut mesh.positions {
        if p.x.abs() < half && p.y.abs() < half {
            *p += DVec3::new(numbers.next() - 0.5, numbers.next() - 0.5, 0.0) * 0.5 * size / f64::from(nu.max(nv));
        }
    }
    mesh
}

/// A tube of the given number of flat sides around z, from z = 0 to `height`, normals outwards, open at the ends.
pub(crate) fn tube(radius: f64, height: f64, sides: u32, rings: u32) -> Mesh {
    sheet(sides, rings, true, |u, v| DVec3::new(radius * (TAU * u).cos(), radius * (TAU * u).sin(), height * v))
}

/// A sphere around the origin: an icosahedron whose faces are split into four `levels` times.
pub(crate) fn icosphere(radius: f64, levels: u32) -> Mesh {
    let t = (1.0 + 5f64.sqrt()) / 2.0;
    let corners = [
        (-1.0, t, 0.0),
        (1.0, t, 0.0),
        (-1.0, -t, 0.0),
        (1.0, -t, 0.0),
        (0.0, -1.0, t),
        (0.0, 1.0, t),
        (0.0, -1.0, -t),
        (0.0, 1.0, -t),
        (t, 0.0, -1.0),
        (t, 0.0, 1.0),
        (-t, 0.0, -1.0),
        (-t, 0.0, 1.0),
    ];
    let mut positions: Vec<DVec3> = corners.iter().map(|&(x, y, z)| DVec3::new(x, y, z).normalize()).collect();
    let mut triangles: Vec<[u32; 3]> = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]).normalize());
                positions.len() as u32 - 1
            })
        };
        triangles = triangles
            .iter()
            .flat_map(|&[a, b, c]| {
                let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    Mesh { positions: positions.iter().map(|p| radius * p).collect(), triangles }
}

/// A closed box with outward normals.
pub(crate) fn cuboid(low: DVec3, high: DVec3) -> Mesh {
    let corner = |i: u32| {
        let pick = |axis: usize| if i >> axis & 1 == 1 { high[axis] } else { low[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    };
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh {
        positions: (0..8).map(corner).collect(),
        triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
    }
}

/// An L of 200 × 100 × 100 mm with walls of 20 mm: one concave edge, 200 mm long, along x at y = z = 20 mm.
pub(crate) fn angle() -> Mesh {
    let outline = [(0.0, 0.0), (0.1, 0.0), (0.1, 0.02), (0.02, 0.02), (0.02, 0.1), (0.0, 0.1)];
    let count = outline.len() as u32;
    let at = |x: f64| outline.iter().map(move |&(y, z)| DVec3::new(x, y, z));
    let positions = at(0.0).chain(at(0.2)).collect();
    let sides = (0..count).flat_map(|i| {
        let next = (i + 1) % count;
        [[i, next, count + next], [i, count + next, count + i]]
    });
    // Both ends are triangle fans around the inner corner, from which all others are visible.
    let ends = [4, 5, 0, 1].map(|i| [3, i, (i + 1) % count]);
    let front = ends.map(|t| t.map(|i| count + i));
    let back = ends.map(|[a, b, c]| [a, c, b]);
    Mesh { positions, triangles: sides.chain(back).chain(front).collect() }
}

/// A solid round bar of 24 flat sides.
pub(crate) fn closed_tube() -> Mesh {
    let mut mesh = tube(0.05, 0.3, 24, 4);
    for (ring, z, up) in [(0u32, 0.0, false), (4, 0.3, true)] {
        let centre = mesh.positions.len() as u32;
        mesh.positions.push(DVec3::Z * z);
        for i in 0..24u32 {
            let (a, b) = (i * 5 + ring, (i + 1) % 24 * 5 + ring);
            mesh.triangles.push(if up { [centre, a, b] } else { [centre, b, a] });
        }
    }
    mesh
}
