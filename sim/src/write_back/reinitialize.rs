//! Reinitialisation of φ beside a surface that moved. Voxels farther than [`KEPT_VOXELS`] from the surface carry no
//! zero set. They take their distance from one voxel nearer to the surface along the normal, layer by layer.

use glam::DVec2;
use sdf_bake::BrickGrid;
use sdf_bake::redistance::KEPT_VOXELS;

use super::{BilinearStencil, Column, floor, reach};
use crate::height_field::{HeightField, NO_SURFACE};
use crate::region::Region;
use sdf_bake::simd::in_wide_lanes;

/// Voxel index for a column without a surface: far from every index in use.
const NOWHERE: i32 = i32::MAX / 2;

/// Reinitialises the far voxels of columns, which all lie in a part of the window.
pub(super) fn reinitialize(grid: &mut BrickGrid, height_field: &HeightField, (columns, part): (&[Column], &Region)) {
    let steepest = columns.iter().map(|column| height_field.area_ratio(column.line)).fold(0.0, f64::max);
    let layers = if columns.is_empty() { 0 } else { reach(grid, steepest) };
    let mut near = Near::read(grid, height_field, (part, layers));
    let sources = [1, -1].map(|side| near.sources(height_field, columns, side));
    let mut renewed = Vec::new();
    for layer in 1..=layers {
        // All distances are found before any is written, so that the order of the columns does not matter.
        renewed.clear();
        for (side, sources) in [1, -1].into_iter().zip(&sources) {
            in_wide_lanes(
                #[inline(always)]
                || near.find((grid, height_field), sources, (layer, side), &mut renewed),
            );
        }
        renewed.drain(..).for_each(|far| near.write((grid, height_field), &far));
    }
}

/// Cached φ near the surface of each column; beyond the cache the field is read.
struct Near {
    /// Voxel index just below the surface.
    below: Vec<i32>,
    /// Cached voxels of each column, as many below the surface as above it; shape `[lines, count]`.
    phi: Vec<f32>,
    count: usize,
}

/// The columns from which the far voxels of a column on one side take their distance, with their bilinear weights.
struct Source {
    line: u32,
    lines: [u32; 4],
    /// Position among each one's cached voxels of the voxel that is level with the one below the column's own surface.
    level: [i32; 4],
    weights: [f64; 4],
}

/// A voxel that carries no zero set, and its new distance.
struct Far {
    line: usize,
    k: i32,
    at: usize,
    /// Index in the cache.
    cached: usize,
    phi: f32,
}

impl Near {
    /// Reads `layers` voxels on either side of the surface from the field, in a part of the window and next to it.
    fn read(grid: &BrickGrid, height_field: &HeightField, (part, layers): (&Region, i32)) -> Self {
        let voxel_below =
            |height: &f64| if *height > NO_SURFACE { floor(height / height_field.pitch) } else { NOWHERE };
        let [rows, across] = height_field.window.size;
        let mut below = vec![NOWHERE; height_field.window.lines()];
        let count = 2 * layers as usize;
        let mut phi = vec![0.0; below.len() * count];
        for line in part.grown_within([rows, across]).lines(across) {
            below[line] = voxel_below(&height_field.height[line]);
            if below[line] != NOWHERE {
                let phi = &mut phi[line * count..(line + 1) * count];
                height_field.lattice.read(grid, height_field.on[line], below[line] + 1 - layers, phi);
            }
        }
        Self { below, phi, count }
    }

    /// The sources of columns on one side of the surface. A column whose source lies beyond the window has none.
    fn sources(&self, height_field: &HeightField, columns: &[Column], side: i32) -> Vec<Source> {
        let source = |column: &Column| {
            let off = DVec2::from(height_field.slope[column.line]) * f64::from(side);
            let around = BilinearStencil::of(height_field, column, off)?;
            let lines = around.lines(height_field.window.size[1]);
            let level = lines.map(|line| self.below[column.line] - self.below[line] - 1 + self.count as i32 / 2);
            let weights = around.weights;
            Some(Source { line: column.line as u32, lines: lines.map(|line| line as u32), level, weights })
        };
        let mut sources = Vec::with_capacity(columns.len());
        sources.extend(columns.iter().filter_map(source));
        sources
    }

    /// Finds the new distances of the voxels in one layer on one side of the surface that carry no zero set. Voxels
    /// whose neighbour towards the surface is unknown are skipped.
    #[inline(always)]
    fn find(
        &self,
        (grid, height_field): (&BrickGrid, &HeightField),
        sources: &[Source],
        (layer, side): (i32, i32),
        out: &mut Vec<Far>,
    ) {
        let (kept, sign) = ((KEPT_VOXELS * height_field.pitch) as f32, side as f32);
        let above_below = if side > 0 { layer } else { 1 - layer };
        for source in sources {
            let line = source.line as usize;
            let cached = line * self.count + (above_below - 1 + self.count as i32 / 2) as usize;
            if self.phi[cached] * sign <= kept {
                continue;
            }
            let k = self.below[line] + above_below;
            let Some(nearer) = self.mean((grid, height_field), source, (k, side)) else { continue };
            let Some(at) = height_field.lattice.place(height_field.on[line], k) else { continue };
            let distance = (nearer * f64::from(side)).max(0.0) + height_field.pitch * height_field.area_ratio(line);
            out.push(Far { line, k, at, cached, phi: (distance as f32).clamp(kept, grid.band) * sign });
        }
    }

    /// Mean of φ [m] over a source, one voxel nearer to the surface than voxel `k`; `None` if one of the columns is
    /// beyond the band there.
    #[inline(always)]
    fn mean(
        &self,
        (grid, height_field): (&BrickGrid, &HeightField),
        source: &Source,
        (k, side): (i32, i32),
    ) -> Option<f64> {
        let above = k - self.below[source.line as usize] - side;
        let mut values = [0.0f32; 4];
        for (i, phi) in values.iter_mut().enumerate() {
            let (line, place) = (source.lines[i] as usize, (source.level[i] + above) as usize);
            *phi = if place < self.count {
                self.phi[line * self.count + place]
            } else {
                height_field.lattice.phi(grid, height_field.on[line], k - side)
            };
        }
        let is_known = |phi: &f32| phi.abs() < grid.band;
        let weighted = || values.iter().zip(source.weights);
        // A column without weight need not be known.
        let known = values.iter().all(is_known) || weighted().all(|(phi, weight)| is_known(phi) || weight == 0.0);
        known.then(|| weighted().map(|(phi, weight)| weight * f64::from(*phi)).fold(0.0, |sum, part| sum + part))
    }

    /// Writes a distance. A voxel that was inside, beyond the band, takes the label of the voxel above it.
    fn write(&mut self, (grid, height_field): (&mut BrickGrid, &HeightField), far: &Far) {
        if grid.phi[far.at] == -grid.band && !grid.label.is_empty() {
            let above = height_field.lattice.place(height_field.on[far.line], far.k + 1);
            grid.label[far.at] = above.map_or(0, |above| grid.label[above]);
        }
        grid.phi[far.at] = far.phi;
        self.phi[far.cached] = far.phi;
    }
}
