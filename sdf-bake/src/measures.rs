//! Volume and area of a field in one pass, from the triangles of its surface, in memory independent of the part's size.
//!
//! The triangles keep sharp edges, which sums over voxels and cells cut off, and a wrong sign changes both integrals.
//! They are those of the surface mesh before any vertex is moved home, because sums need no manifold. A large field is
//! processed one slab of bricks at a time, with two bricks on either side; only triangles with their centre in the slab
//! count. Vertices depend on voxels less than one brick away, so they equal those of the whole field.

use std::ops::Range;

use glam::IVec3;

use crate::grid::{BRICK_SIDE, BRICK_VOXELS, BrickGrid, INSIDE, OUTSIDE};

/// Bricks of a slab, if it has more than one layer: about 40 vertices per brick, or 150 MB.
const SLAB_BRICKS: usize = 1 << 15;

/// Bricks beside a slab on which its own triangles may depend.
const BESIDE: i32 = 2;

/// Integrals over a field.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Measures {
    /// Volume of {φ < 0} [m³].
    pub volume: f64,
    /// Area of {φ = 0} [m²].
    pub area: f64,
}

impl BrickGrid {
    /// Volume inside and area of the zero set, over the triangles of [`BrickGrid::surface_mesh`]: exact for flat faces
    /// along the lattice's axes, otherwise of second order in the voxel (`docs/fields.md` has figures).
    pub fn measures(&self) -> Measures {
        self.measures_by_slabs(SLAB_BRICKS)
    }

    fn measures_by_slabs(&self, most_bricks: usize) -> Measures {
        if self.bricks.len() <= most_bricks {
            return self.measures_between(f64::NEG_INFINITY..f64::INFINITY);
        }
        let mut sum = Measures::default();
        for layers in self.slabs(most_bricks) {
            let slab = self.layers(layers.start - BESIDE..layers.end + BESIDE);
            let side = BRICK_SIDE as f64;
            let Measures { volume, area } =
                slab.measures_between(f64::from(layers.start) * side..f64::from(layers.end) * side);
            sum = Measures { volume: sum.volume + volume, area: sum.area + area };
        }
        sum
    }

    /// Volumes of cones from the centre of the grid, and areas, of the triangles whose centre has an x within a range
    /// [voxels].
    fn measures_between(&self, range: Range<f64>) -> Measures {
        let middle = (self.origin.as_dvec3() + 0.5 * self.dims.as_dvec3()) * BRICK_SIDE as f64;
        let [volume, area] = self.surface_sums(|corners| {
            if !range.contains(&(corners.iter().map(|p| p.x).sum::<f64>() / 3.0)) {
                return [0.0; 2];
            }
            let [a, b, c] = corners.map(|p| p - middle);
            [a.dot(b.cross(c)) / 6.0, 0.5 * (b - a).cross(c - a).length()]
        });
        Measures { volume: volume * self.voxel.powi(3), area: area * self.voxel.powi(2) }
    }

    /// Runs of layers of bricks along x, with at most `most` bricks unless a single layer has more. They extend one
    /// layer beyond the index on both sides, where cells start that reach into it.
    fn slabs(&self, most: usize) -> Vec<Range<i32>> {
        let mut in_layer = vec![0usize; self.dims.x as usize];
        self.bricks.iter().for_each(|brick| in_layer[(brick.x - self.origin.x) as usize] += 1);
        let (mut slabs, mut first, mut count) = (Vec::new(), -1, 0);
        for (layer, &bricks) in in_layer.iter().enumerate() {
            if count > 0 && count + bricks > most {
                slabs.push(first..layer as i32);
                (first, count) = (layer as i32, 0);
            }
            count += bricks;
        }
        slabs.push(first..self.dims.x + 1);
        slabs.into_iter().map(|slab| slab.start + self.origin.x..slab.end + self.origin.x).collect()
    }

    /// φ of some layers of bricks along x; outside elsewhere.
    fn layers(&self, layers: Range<i32>) -> Self {
        let mut part = Self::empty(self.voxel, self.band, self.origin, self.dims);
        let within = layers.start.max(self.origin.x)..layers.end.min(self.origin.x + self.dims.x);
        for x in within {
            for y in self.origin.y..self.origin.y + self.dims.y {
                for (z, slot) in self.index.row(x - self.origin.x, y - self.origin.y).enumerate() {
                    let brick = IVec3::new(x, y, self.origin.z + z as i32);
                    match slot {
                        OUTSIDE => {}
                        INSIDE => part.set_slot(brick, INSIDE),
                        slot => {
                            part.set_slot(brick, part.bricks.len() as u32);
                            part.bricks.push(brick);
                            part.phi.extend_from_slice(&self.phi[slot as usize * BRICK_VOXELS..][..BRICK_VOXELS]);
                        }
                    }
                }
            }
        }
        part.index.tidy();
        part
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use glam::{DMat3, DVec3};

    use super::*;

    fn block(low: DVec3, high: DVec3, voxel: f64) -> BrickGrid {
        BrickGrid::from_distance(low, high, voxel, 3.0, |p| {
            let q = (low - p).max(p - high);
            q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
        })
    }

    #[test]
    fn a_block_has_the_volume_and_area_of_the_closed_form() {
        let size = DVec3::new(0.03, 0.03, 0.02);
        for shift in [0.0, 0.37, 0.5, 0.93] {
            let low = DVec3::new(1.0, -0.7, 0.3) * shift * 5e-4;
            let Measures { volume, area } = block(low, low + size, 5e-4).measures();
            let off = [volume / 1.8e-5 - 1.0, area / 4.2e-3 - 1.0];
            assert!(off.iter().all(|off| off.abs() < 5e-4), "shifted by {shift}: {off:?}");
        }
    }

    #[test]
    fn a_ball_has_the_volume_and_area_of_the_closed_form() {
        let grid =
            BrickGrid::from_distance(DVec3::splat(-0.01), DVec3::splat(0.01), 0.02 / 64.0, 3.0, |p| p.length() - 0.01);
        let Measures { volume, area } = grid.measures();
        let off = [volume / (4.0 / 3.0 * PI * 1e-6) - 1.0, area / (4.0 * PI * 1e-4) - 1.0];
        assert!(off.iter().all(|off| off.abs() < 5e-4), "{off:?}");
    }

    #[test]
    fn a_turned_box_and_a_torus_have_theirs_as_the_mesh_has() {
        let half = DVec3::new(0.010, 0.0071, 0.0052);
        let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.7).normalize(), 0.6);
        let reach = DVec3::splat(half.length());
        let turned = BrickGrid::from_distance(-reach, reach, 0.02 / 64.0, 3.0, |p| {
            let q = (turn.transpose() * p).abs() - half;
            q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
        });
        let faces = 8.0 * (half.x * half.y + half.y * half.z + half.z * half.x);
        let reach = DVec3::new(0.0101, 0.0101, 0.0031);
        let torus =
            BrickGrid::from_distance(-reach, reach, 0.02 / 64.0, 3.0, |p| (p.x.hypot(p.y) - 0.007).hypot(p.z) - 0.003);
        let of_torus = [2.0 * PI * PI * 0.007 * 9e-6, 4.0 * PI * PI * 0.007 * 0.003];
        for (name, grid, expected) in
            [("box", turned, [8.0 * half.element_product(), faces]), ("torus", torus, of_torus)]
        {
            let (Measures { volume, area }, mesh) = (grid.measures(), grid.surface_mesh());
            let off = |[v, a]: [f64; 2]| [v / expected[0] - 1.0, a / expected[1] - 1.0];
            let (off, of_mesh) = (off([volume, area]), off([mesh.volume(), mesh.area()]));
            println!("{name}: {off:?}, the mesh {of_mesh:?}");
            assert!(off[0].abs() < 2e-4 && off[1].abs() < 6e-4, "{name}: {off:?}");
            assert!(off[1].abs() < of_mesh[1].abs() + 1e-5, "{name}: {off:?}, the mesh {of_mesh:?}");
        }
    }

    #[test]
    fn slabs_add_up_to_the_whole() {
        let low = DVec3::new(-0.0171, 0.003, -0.0042);
        let grid = block(low, low + DVec3::new(0.03, 0.011, 0.02), 5e-4);
        let whole = grid.measures();
        for most in [1, 40, grid.brick_count() - 1] {
            assert!(grid.slabs(most).len() > 1);
            let slabs = grid.measures_by_slabs(most);
            let off = [slabs.volume / whole.volume - 1.0, slabs.area / whole.area - 1.0];
            assert!(off.iter().all(|off| off.abs() < 1e-12), "slabs of {most} bricks: {off:?}");
        }
    }

    #[test]
    fn a_lost_column_shows_in_both() {
        let mut grid = block(DVec3::ZERO, DVec3::new(0.03, 0.03, 0.02), 5e-4);
        let whole = grid.measures();
        for z in 1..40 {
            let place = grid.place(IVec3::new(2, 2, z)).expect("in the band");
            grid.phi[place] = grid.phi[place].abs();
        }
        let lost = grid.measures();
        assert!(lost.volume < whole.volume && lost.area > whole.area, "{lost:?}, {whole:?}");
    }
}
