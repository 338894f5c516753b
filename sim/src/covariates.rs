//! Covariates of each point of the surface in a pass: contact time, pressure, sliding distance.
//!
//! They are sums at the lattice lines along z of a rectangle, accumulated step by step from the cells in contact.
//! Height fields that face another way are not counted.

use std::collections::HashMap;

use glam::{DVec2, DVec3};
use sdf_bake::PixelGrid;

use crate::height_field::{Facing, HeightField};

/// A cell of the surface in one step.
#[derive(Clone, Copy, Debug)]
pub struct ContactCell {
    /// Column index in the height field.
    pub line: usize,
    /// Mean share of the cell that was in contact.
    pub share: f64,
    /// Mean pressure over the cell [Pa].
    pub load: f64,
    /// Recession along the surface's normal [m].
    pub recession: f64,
    /// Dose gained [1].
    pub dose: f64,
}

/// Sums over one or several passes at the lattice lines of a rectangle; row-major, x fastest, as in [`PixelGrid`].
#[derive(Clone, Debug, PartialEq)]
pub struct Covariates {
    /// Points at which the lines meet the plane z = 0.
    pub pixels: PixelGrid,
    /// Lattice index of the first line [voxels].
    first: [i32; 2],
    /// `∫ p dt` [Pa s].
    pub pressure_time: Vec<f64>,
    /// Highest mean pressure of a step over the cell while in contact [Pa].
    pub peak_pressure: Vec<f64>,
    /// Time in contact [s].
    pub contact_time: Vec<f64>,
    /// Sliding distance of the tool's surface while in contact [m].
    pub slip_way: Vec<f64>,
    /// Depth removed along the surface's normal [m].
    pub removed: Vec<f64>,
    /// Dose gained [1].
    pub dose: Vec<f64>,
    /// Time of first contact since the trial began [s]; NaN without contact.
    pub first_contact: Vec<f64>,
    /// Each state of the workpiece's cells at the end of the pass [SI], in the order of the model; NaN without contact.
    pub states: Vec<Vec<f64>>,
}

impl Covariates {
    /// Zeros at all lattice lines of a field with this `voxel` [m] that cover a map.
    pub fn over(map: &PixelGrid, voxel: f64) -> Self {
        let last = map.position(map.nx.max(1) - 1, map.ny.max(1) - 1);
        // A line that misses a border pixel by rounding belongs to that pixel.
        let low = (map.origin / voxel + 1e-6).floor();
        let high = (last / voxel - 1e-6).ceil();
        let first = [low.x as i32, low.y as i32];
        let (nx, ny) = ((high.x - low.x) as usize + 1, (high.y - low.y) as usize + 1);
        let zeros = vec![0.0; nx * ny];
        Self {
            pixels: PixelGrid { origin: low * voxel, pitch: voxel, nx, ny },
            first,
            pressure_time: zeros.clone(),
            peak_pressure: zeros.clone(),
            contact_time: zeros.clone(),
            slip_way: zeros.clone(),
            removed: zeros.clone(),
            dose: zeros.clone(),
            first_contact: vec![f64::NAN; nx * ny],
            states: Vec::new(),
        }
    }

    /// Stores the states of the workpiece's cells, `count` of them at each lattice line that the tool touched.
    pub(crate) fn keep_states(&mut self, cells: &HashMap<(i32, i32), Vec<f64>>, count: usize) {
        self.states = vec![vec![f64::NAN; self.pixels.len()]; count];
        for (&place, values) in cells {
            let Some(at) = self.line(place) else { continue };
            self.states.iter_mut().zip(values).for_each(|(state, value)| state[at] = *value);
        }
    }

    /// Index of the line at lattice indices (i, j) [voxels]; `None` outside the rectangle.
    fn line(&self, (i, j): (i32, i32)) -> Option<usize> {
        let (column, row) = (i64::from(i) - i64::from(self.first[0]), i64::from(j) - i64::from(self.first[1]));
        let (nx, ny) = (self.pixels.nx as i64, self.pixels.ny as i64);
        (column >= 0 && row >= 0 && column < nx && row < ny).then_some((row * nx + column) as usize)
    }

    /// Adds a step of `dt` [s] that began at `time` [s]. `slip_speed` maps a point in the field's frame to the slip
    /// speed [m/s].
    pub(crate) fn add(
        &mut self,
        height_field: &HeightField,
        contact_cells: impl Iterator<Item = ContactCell>,
        slip_speed: impl Fn(DVec3) -> f64,
        (time, dt): (f64, f64),
    ) {
        if height_field.facing != Facing::of(DVec3::Z) {
            return;
        }
        for cell in contact_cells {
            let Some(at) = self.line(height_field.window.place(cell.line)) else { continue };
            let contact = cell.share * dt;
            self.pressure_time[at] += cell.load * dt;
            self.peak_pressure[at] = self.peak_pressure[at].max(cell.load);
            self.contact_time[at] += contact;
            self.slip_way[at] += contact * slip_speed(height_field.facing.world(height_field.point(cell.line)));
            self.removed[at] += cell.recession;
            self.dose[at] += cell.dose;
            if self.first_contact[at].is_nan() && cell.share > 0.0 {
                self.first_contact[at] = time;
            }
        }
    }

    /// Mean pressure while in contact [Pa], weighted with the contact time; NaN without contact.
    pub fn mean_pressure(&self) -> Vec<f64> {
        self.per_contact_time(&self.pressure_time)
    }

    /// Mean slip speed while in contact [m/s]; NaN without contact.
    pub fn mean_slip_speed(&self) -> Vec<f64> {
        self.per_contact_time(&self.slip_way)
    }

    fn per_contact_time(&self, sums: &[f64]) -> Vec<f64> {
        let mean = |(sum, time): (&f64, &f64)| if *time > 0.0 { sum / time } else { f64::NAN };
        sums.iter().zip(&self.contact_time).map(mean).collect()
    }

    /// Resamples values at the lines, such as a sum or a mean of this map, at the pixels of another map. Bilinear
    /// between lines, the value itself where a pixel is on a line, NaN beyond the lines.
    pub fn at(&self, map: &PixelGrid, values: &[f64]) -> Vec<f64> {
        let value = |n: usize| self.interpolate(values, map.position(n % map.nx, n / map.nx));
        (0..map.nx * map.ny).map(value).collect()
    }

    fn interpolate(&self, values: &[f64], place: DVec2) -> f64 {
        let at = (place - self.pixels.origin) / self.pixels.pitch;
        // Pixels meant to be on a line are so only within rounding.
        let on_line = at.round();
        let at = DVec2::select((at - on_line).abs().cmplt(DVec2::splat(1e-6)), on_line, at);
        let (corner, fraction) = (at.floor(), at - at.floor());
        let mut sum = 0.0;
        for (dx, wx) in [(0.0, 1.0 - fraction.x), (1.0, fraction.x)] {
            for (dy, wy) in [(0.0, 1.0 - fraction.y), (1.0, fraction.y)] {
                if wx * wy == 0.0 {
                    continue;
                }
                let (x, y) = (corner.x + dx, corner.y + dy);
                if x < 0.0 || y < 0.0 || x >= self.pixels.nx as f64 || y >= self.pixels.ny as f64 {
                    return f64::NAN;
                }
                sum += wx * wy * values[y as usize * self.pixels.nx + x as usize];
            }
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_cover_a_map_and_are_read_back_at_its_pixels() {
        let map = PixelGrid { origin: DVec2::new(0.6e-3, -1.1e-3), pitch: 0.25e-3, nx: 9, ny: 5 };
        let mut covariates = Covariates::over(&map, 0.2e-3);
        assert_eq!(covariates.first, [3, -6]);
        let plane = |p: DVec2| 3.0 * p.x - 2.0 * p.y + 1.0;
        let pixels = covariates.pixels;
        covariates.removed =
            (0..pixels.nx * pixels.ny).map(|n| plane(pixels.position(n % pixels.nx, n / pixels.nx))).collect();
        for (n, value) in covariates.at(&map, &covariates.removed).into_iter().enumerate() {
            assert!((value - plane(map.position(n % map.nx, n / map.nx))).abs() < 1e-12, "{n}: {value}");
        }
        let aligned = Covariates::over(&PixelGrid { pitch: 0.1e-3, ..map }, 0.1e-3);
        assert_eq!((aligned.pixels.nx, aligned.pixels.ny), (map.nx, map.ny));
    }
}
