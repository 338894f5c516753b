//! The triangle mesh used by all crates.

use glam::DVec3;

/// An indexed triangle mesh in the part's frame (right-handed, z up), in metres.
///
/// Corners are counter-clockwise seen from outside: normals point out of the solid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions [m], shape `[n, 3]`.
    pub positions: Vec<DVec3>,
    /// Corner indices into `positions`, shape `[m, 3]`.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The three corners of a triangle [m].
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|vertex| self.positions[vertex as usize])
    }

    /// Cross product of two edges: twice the area [m²] along the outward normal.
    pub fn doubled_area_normal(&self, triangle: usize) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(c - a)
    }

    /// Outward unit normal of a triangle; zero for a degenerate one.
    pub fn normal(&self, triangle: usize) -> DVec3 {
        self.doubled_area_normal(triangle).normalize_or_zero()
    }

    /// Smallest and largest corner of the bounding box [m]; `None` without vertices.
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let first = *self.positions.first()?;
        let grow = |(low, high): (DVec3, DVec3), p: &DVec3| (low.min(*p), high.max(*p));
        Some(self.positions.iter().fold((first, first), grow))
    }

    /// Length of the bounding box's diagonal [m].
    pub fn diagonal(&self) -> f64 {
        self.bounds().map_or(0.0, |(low, high)| (high - low).length())
    }

    /// Enclosed volume [m³] by the divergence theorem; meaningful for closed meshes only.
    pub fn volume(&self) -> f64 {
        let Some(&origin) = self.positions.first() else {
            return 0.0;
        };
        let cone = |t: usize| {
            let [a, b, c] = self.corners(t).map(|p| p - origin);
            a.dot(b.cross(c)) / 6.0
        };
        (0..self.triangles.len()).map(cone).sum()
    }

    /// Surface area [m²].
    pub fn area(&self) -> f64 {
        (0..self.triangles.len()).map(|t| 0.5 * self.doubled_area_normal(t).length()).sum()
    }

    /// Adds another mesh's vertices and triangles; shared vertices are not merged.
    pub fn append(&mut self, other: &Mesh) {
        let offset = self.positions.len() as u32;
        self.positions.extend_from_slice(&other.positions);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|v| v + offset)));
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A box [m] with outward triangles, for closed-form checks.
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

    /// A closed sphere [m] around the origin: `around` meridians, `bands` rows from pole to pole.
    pub(crate) fn uv_sphere(radius: f64, around: u32, bands: u32) -> Mesh {
        use std::f64::consts::{PI, TAU};
        let mut mesh = Mesh { positions: vec![DVec3::NEG_Z * radius, DVec3::Z * radius], triangles: Vec::new() };
        for row in 1..bands {
            let (sine, cosine) = (PI * f64::from(row) / f64::from(bands)).sin_cos();
            mesh.positions.extend((0..around).map(|i| {
                let (y, x) = (TAU * f64::from(i) / f64::from(around)).sin_cos();
                radius * DVec3::new(sine * x, sine * y, -cosine)
            }));
        }
        let at = |row: u32, i: u32| 2 + (row - 1) * around + i % around;
        for i in 0..around {
            mesh.triangles.push([0, at(1, i + 1), at(1, i)]);
            mesh.triangles.push([1, at(bands - 1, i), at(bands - 1, i + 1)]);
            for row in 1..bands - 1 {
                mesh.triangles.push([at(row, i), at(row, i + 1), at(row + 1, i + 1)]);
                mesh.triangles.push([at(row, i), at(row + 1, i + 1), at(row + 1, i)]);
            }
        }
        mesh
    }

    #[test]
    fn a_fine_sphere_is_closed_and_outward() {
        let ball = uv_sphere(2.0, 200, 100);
        assert!((ball.volume() / (32.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn a_box_has_its_volume_and_area() {
        let mesh = cuboid(DVec3::new(1.0, 2.0, 3.0), DVec3::new(2.0, 4.0, 6.0));
        assert!((mesh.volume() - 6.0).abs() < 1e-12);
        assert!((mesh.area() - 22.0).abs() < 1e-12);
        assert!((mesh.diagonal() - 14f64.sqrt()).abs() < 1e-12);
    }
}
