//! Parts made by formula with any resolution: a gear of even triangles and a plate of long slivers.
#![allow(dead_code, reason = "each test program uses some of them")]

use std::f64::consts::TAU;

use glam::DVec3;
use sdf_bake::Mesh;

/// A closed gear [m] with 24 rounded teeth and a bore, 80 mm across and 20 mm thick.
///
/// `around` points on the circumference, `rows` rows of quads on each of its four faces: 8 · around · rows triangles.
pub(crate) fn gear(around: u32, rows: u32) -> Mesh {
    let outer = |angle: f64| 0.036 + 0.004 * (3.0 * (24.0 * angle).sin()).tanh();
    // Around the cross section: bore upwards, top outwards, flanks downwards, bottom inwards.
    let section = |step: u32, angle: f64| {
        let along = f64::from(step % rows) / f64::from(rows);
        let (inner, outer) = (0.012, outer(angle));
        match step / rows {
            0 => (inner, -0.01 + 0.02 * along),
            1 => (inner + (outer - inner) * along, 0.01),
            2 => (outer, 0.01 - 0.02 * along),
            _ => (outer + (inner - outer) * along, -0.01),
        }
    };
    let steps = 4 * rows;
    let mut mesh = Mesh::default();
    for i in 0..around {
        let angle = TAU * f64::from(i) / f64::from(around);
        for step in 0..steps {
            let (radius, z) = section(step, angle);
            mesh.positions.push(DVec3::new(radius * angle.cos(), radius * angle.sin(), z));
        }
    }
    let at = |i: u32, step: u32| (i % around) * steps + step % steps;
    for i in 0..around {
        for step in 0..steps {
            let [a, b, c, d] = [at(i, step), at(i + 1, step), at(i + 1, step + 1), at(i, step + 1)];
            mesh.triangles.extend([[a, d, c], [a, c, b]]);
        }
    }
    mesh
}

/// A closed plate [m], 200 × 120 × 12 mm, with one round hole of `around` segments (a multiple of 4), each joined to
/// a corner of the plate as CAD kernels do: 4 · `around` + 16 triangles, most of them long slivers.
pub(crate) fn sliver_plate(around: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let corners = [(0.1, 0.06), (-0.1, 0.06), (-0.1, -0.06), (0.1, -0.06)];
    let mut layer = |z: f64| {
        mesh.positions.extend(corners.map(|(x, y)| DVec3::new(x, y, z)));
        mesh.positions.extend((0..around).map(|i| {
            let (y, x) = (TAU * f64::from(i) / f64::from(around)).sin_cos();
            DVec3::new(0.03 * x, 0.03 * y, z)
        }));
    };
    layer(-0.006);
    layer(0.006);
    let top = 4 + around;
    let hole = |i: u32| 4 + i % around;
    for i in 0..around {
        let (corner, a, b) = (4 * i / around, hole(i), hole(i + 1));
        mesh.triangles.extend([[corner, a, b], [top + corner, top + b, top + a]]);
        mesh.triangles.extend([[a, top + b, b], [a, top + a, top + b]]);
    }
    for corner in 0..4 {
        let (next, between) = ((corner + 1) % 4, hole((corner + 1) * around / 4));
        mesh.triangles.extend([[corner, between, next], [top + corner, top + next, top + between]]);
        mesh.triangles.extend([[corner, next, top + next], [corner, top + next, top + corner]]);
    }
    mesh
}

/// A closed box [m] with outward triangles.
pub(crate) fn plate(low: DVec3, high: DVec3) -> Mesh {
    let corner = |i: usize| DVec3::from_array(std::array::from_fn(|a| if i >> a & 1 == 1 { high[a] } else { low[a] }));
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh {
        positions: (0..8).map(corner).collect(),
        triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
    }
}

/// A straight bead of parabolic section with flat ends.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bead {
    /// Distance between the ends, distance between the toes, height above z = 0, depth below it [m].
    pub(crate) length: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
    pub(crate) root: f64,
    /// Number of chords of the outline between the toes.
    pub(crate) chords: u32,
    /// Angle of its axis to x [rad].
    pub(crate) turn: f64,
}

impl Bead {
    /// Volume above z = 0 [m³]: the parabola's 2/3 w h l, minus the part that its chords cut off.
    pub(crate) fn volume_above(&self) -> f64 {
        let chords = f64::from(self.chords);
        2.0 / 3.0 * self.width * self.height * self.length * (1.0 - 1.0 / (chords * chords))
    }

    /// The closed bead around the origin [m].
    pub(crate) fn mesh(&self) -> Mesh {
        let base = 0.5 * self.width * (1.0 + self.root / self.height).sqrt();
        let toes = (0..=self.chords).map(|i| self.width * (f64::from(i) / f64::from(self.chords) - 0.5));
        let above = toes.map(|y| (y, self.height * (1.0 - (2.0 * y / self.width).powi(2))));
        let outline: Vec<(f64, f64)> =
            [(-base, -self.root)].into_iter().chain(above).chain([(base, -self.root)]).collect();
        let (sine, cosine) = self.turn.sin_cos();
        let section = |x: f64| {
            let middle = (0.0, -self.root);
            let place = move |&(y, z): &(f64, f64)| DVec3::new(cosine * x - sine * y, sine * x + cosine * y, z);
            outline.iter().chain([&middle]).map(place).collect::<Vec<_>>()
        };
        let positions = [section(-0.5 * self.length), section(0.5 * self.length)].concat();
        let count = outline.len() as u32 + 1;
        let (middle, mut triangles) = (count - 1, Vec::new());
        for i in 0..count {
            let next = (i + 1) % count;
            triangles.extend([[i, count + next, next], [i, count + i, count + next]]);
            if i + 2 < count {
                triangles.extend([[middle, i, next], [count + middle, count + next, count + i]]);
            }
        }
        Mesh { positions, triangles }
    }
}
