//! Reinitialisation of φ beside a surface that moved. Voxels farther than [`KEPT_VOXELS`] from the surface carry no
//! zero set. They take their distance from one voxel nearer to the surface along the normal, layer by layer.

use glam::DVec2;
use sdf_bake::BrickGrid;
use sdf_bake::redistance::KEPT_VOXELS;

use super::{BilinearStencil, Column, floor, reach};
use crate::height_field::{HeightField, NO_SURFACE};
use sdf_bake::simd::in_wide_lanes;

/// Voxel index for a column without a surface: far from every index in use.
const NOWHERE: i32 = i32::MAX / 2;

/// Reinitialises the far voxels of columns.
pub(super) fn reinitialize(grid: &mut BrickGrid, height_field: &HeightField, columns: &[Column]) {
    let layers = columns.iter().map(|column| reach(grid, height_field.area_ratio(column.line))).max().unwrap_or(0);
    let mut near = Near::read(grid, height_field, (columns, layers));
    let nearer = [1.0, -1.0].map(|side| -> Vec<Option<BilinearStencil>> {
        let around = |column: &Column| {
            BilinearStencil::of(height_field, column, DVec2::from(height_field.slope[column.line]) * side)
        };
        columns.iter().map(around).collect()
    });
    let mut renewed = Vec::new();
    for layer in 1..=layers {
        // All distances are found before any is written, so that the order of the columns does not matter.
        renewed.clear();
        for (side, nearer) in [1, -1].into_iter().zip(&nearer) {
            in_wide_lanes(
                #[inline(always)]
                || near.find((grid, height_field), (columns, nearer), (layer, side), &mut renewed),
            );
        }
        renewed.drain(..).for_each(|far| near.write((grid, height_field), &far));
    }
}

/// Lines of the smallest rectangle with all columns and their neighbours, in a window of a size.
fn lines_around(columns: &[Column], [rows, across]: [usize; 2]) -> impl Iterator<Item = usize> {
    let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
    for &Column { row, across: place, .. } in columns {
        (low, high) = ([low[0].min(row), low[1].min(place)], [high[0].max(row), high[1].max(place)]);
    }
    let range = |d: usize, size: usize| low[d].saturating_sub(1)..(high[d] + 2).min(size);
    let places = range(1, across);
    range(0, rows).flat_map(move |row| places.clone().map(move |place| row * across + place))
}

/// Cached φ near the surface of each column; beyond the cache the field is read.
struct Near {
    /// Voxel index just below the surface.
    below: Vec<i32>,
    /// Cached voxels of each column, as many below the surface as above it; shape `[lines, count]`.
    phi: Vec<f32>,
    count: usize,
}

/// A voxel that carries no zero set, and its new distance.
struct Far {
    line: usize,
    k: i32,
    at: usize,
    phi: f32,
}

impl Near {
    /// Reads `layers` voxels on either side of the surface from the field, at the columns and next to them.
    fn read(grid: &BrickGrid, height_field: &HeightField, (columns, layers): (&[Column], i32)) -> Self {
        let voxel_below =
            |height: &f64| if *height > NO_SURFACE { floor(height / height_field.pitch) } else { NOWHERE };
        let mut below = vec![NOWHERE; height_field.window.lines()];
        let count = 2 * layers as usize;
        let mut phi = vec![0.0; below.len() * count];
        for line in lines_around(columns, height_field.window.size) {
            below[line] = voxel_below(&height_field.height[line]);
            if below[line] != NOWHERE {
                let phi = &mut phi[line * count..(line + 1) * count];
                height_field.lattice.read(grid, height_field.on[line], below[line] + 1 - layers, phi);
            }
        }
        Self { below, phi, count }
    }

    /// Index of voxel `k` of a column in the cache; `None` outside it.
    #[inline(always)]
    fn place(&self, line: usize, k: i32) -> Option<usize> {
        let at = (k - self.below[line] - 1 + self.count as i32 / 2) as usize;
        (at < self.count).then(|| line * self.count + at)
    }

    /// φ [m] of voxel `k` of a column.
    #[inline(always)]
    fn phi(&self, (grid, height_field): (&BrickGrid, &HeightField), line: usize, k: i32) -> f32 {
        self.place(line, k).map_or_else(|| height_field.lattice.phi(grid, height_field.on[line], k), |at| self.phi[at])
    }

    /// Finds the new distances of the voxels in one layer on one side of the surface that carry no zero set. Voxels
    /// whose neighbour towards the surface is unknown are skipped.
    #[inline(always)]
    fn find(
        &self,
        (grid, height_field): (&BrickGrid, &HeightField),
        (columns, nearer): (&[Column], &[Option<BilinearStencil>]),
        (layer, side): (i32, i32),
        out: &mut Vec<Far>,
    ) {
        let (kept, sign) = ((KEPT_VOXELS * height_field.pitch) as f32, side as f32);
        for (&Column { line, .. }, nearer) in columns.iter().zip(nearer) {
            let k = self.below[line] + if side > 0 { layer } else { 1 - layer };
            if self.phi((grid, height_field), line, k) * sign <= kept {
                continue;
            }
            let Some(at) = height_field.lattice.place(height_field.on[line], k) else { continue };
            let Some(nearer) = nearer.as_ref().and_then(|nearer| self.mean((grid, height_field), nearer, k - side))
            else {
                continue;
            };
            let distance = (nearer * f64::from(side)).max(0.0) + height_field.pitch * height_field.area_ratio(line);
            out.push(Far { line, k, at, phi: (distance as f32).clamp(kept, grid.band) * sign });
        }
    }

    /// Mean of φ [m] at voxel `k` over the columns around a point; `None` if one of them is beyond the band.
    #[inline(always)]
    fn mean(&self, field: (&BrickGrid, &HeightField), around: &BilinearStencil, k: i32) -> Option<f64> {
        let (mut sum, mut known) = (0.0, true);
        for (line, weight) in around.lines.iter().zip(around.weights) {
            let phi = self.phi(field, *line, k);
            known &= (phi.abs() < field.0.band) | (weight == 0.0);
            sum += weight * f64::from(phi);
        }
        known.then_some(sum)
    }

    /// Writes a distance. A voxel that was inside, beyond the band, takes the label of the voxel above it.
    fn write(&mut self, (grid, height_field): (&mut BrickGrid, &HeightField), far: &Far) {
        if grid.phi[far.at] == -grid.band && !grid.label.is_empty() {
            let above = height_field.lattice.place(height_field.on[far.line], far.k + 1);
            grid.label[far.at] = above.map_or(0, |above| grid.label[above]);
        }
        grid.phi[far.at] = far.phi;
        if let Some(at) = self.place(far.line, far.k) {
            self.phi[at] = far.phi;
        }
    }
}
