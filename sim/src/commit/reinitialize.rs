//! Distances anew beside a surface that has moved: voxels farther than [`KEPT_VOXELS`], which carry no zero set, take theirs from
//! one voxel nearer to the surface along the normal, layer by layer.

use glam::DVec2;
use sdf_bake::BrickGrid;
use sdf_bake::redistance::KEPT_VOXELS;

use super::{Around, Column, floor, reach};
use crate::sheet::{NO_SURFACE, Sheet};
use sdf_bake::simd::in_wide_lanes;

/// Voxel below the surface of a line that has none: far from all that is asked for.
const NOWHERE: i32 = i32::MAX / 2;

/// Renews the far voxels of columns.
pub(super) fn renew(grid: &mut BrickGrid, sheet: &Sheet, columns: &[Column]) {
    let layers = columns.iter().map(|column| reach(grid, sheet.area_ratio(column.line))).max().unwrap_or(0);
    let mut near = Near::read(grid, sheet, layers);
    let nearer = [1.0, -1.0].map(|side| -> Vec<Option<Around>> {
        let around = |column: &Column| Around::of(sheet, column, DVec2::from(sheet.slope[column.line]) * side);
        columns.iter().map(around).collect()
    });
    let mut renewed = Vec::new();
    for layer in 1..=layers {
        // All are found before any is written, so that the order of the columns does not matter.
        renewed.clear();
        for (side, nearer) in [1, -1].into_iter().zip(&nearer) {
            in_wide_lanes(
                #[inline(always)]
                || near.find((grid, sheet), (columns, nearer), (layer, side), &mut renewed),
            );
        }
        renewed.drain(..).for_each(|far| near.write((grid, sheet), &far));
    }
}

/// φ near the surface of each line, at hand; beyond, the field is asked.
struct Near {
    /// The voxel below the surface.
    below: Vec<i32>,
    /// Voxels known of each line, as many below the surface as above it; shape `[lines, count]`.
    phi: Vec<f32>,
    count: usize,
}

/// A voxel that carries no zero set, with its new distance.
struct Far {
    line: usize,
    k: i32,
    at: usize,
    phi: f32,
}

impl Near {
    /// Takes so many `layers` of voxels on either side of the surface from the field.
    fn read(grid: &BrickGrid, sheet: &Sheet, layers: i32) -> Self {
        let voxel_below = |height: &f64| if *height > NO_SURFACE { floor(height / sheet.pitch) } else { NOWHERE };
        let below: Vec<i32> = sheet.height.iter().map(voxel_below).collect();
        let count = 2 * layers as usize;
        let mut phi = vec![0.0; below.len() * count];
        for ((below, on), phi) in below.iter().zip(&sheet.on).zip(phi.chunks_exact_mut(count)) {
            if *below != NOWHERE {
                let first = below + 1 - layers;
                (first..).zip(phi).for_each(|(k, phi)| *phi = sheet.lattice.phi(grid, *on, k));
            }
        }
        Self { below, phi, count }
    }

    /// Place of voxel `k` of a line among the values at hand.
    #[inline(always)]
    fn place(&self, line: usize, k: i32) -> Option<usize> {
        let at = (k - self.below[line] - 1 + self.count as i32 / 2) as usize;
        (at < self.count).then(|| line * self.count + at)
    }

    /// φ [m] of voxel `k` of a line.
    #[inline(always)]
    fn phi(&self, (grid, sheet): (&BrickGrid, &Sheet), line: usize, k: i32) -> f32 {
        self.place(line, k).map_or_else(|| sheet.lattice.phi(grid, sheet.on[line], k), |at| self.phi[at])
    }

    /// Finds the voxels of a layer on a side of the surface that carry no zero set, with new distances; what has no `nearer`
    /// place is left.
    #[inline(always)]
    fn find(
        &self,
        (grid, sheet): (&BrickGrid, &Sheet),
        (columns, nearer): (&[Column], &[Option<Around>]),
        (layer, side): (i32, i32),
        out: &mut Vec<Far>,
    ) {
        let (kept, sign) = ((KEPT_VOXELS * sheet.pitch) as f32, side as f32);
        for (&Column { line, .. }, nearer) in columns.iter().zip(nearer) {
            let k = self.below[line] + if side > 0 { layer } else { 1 - layer };
            if self.phi((grid, sheet), line, k) * sign <= kept {
                continue;
            }
            let Some(at) = sheet.lattice.place(sheet.on[line], k) else { continue };
            let Some(nearer) = nearer.as_ref().and_then(|nearer| self.mean((grid, sheet), nearer, k - side)) else {
                continue;
            };
            let distance = (nearer * f64::from(side)).max(0.0) + sheet.pitch * sheet.area_ratio(line);
            out.push(Far { line, k, at, phi: (distance as f32).clamp(kept, grid.band) * sign });
        }
    }

    /// Mean of φ [m] at voxel `k` of the lines around a place; `None` where one of them is beyond the band.
    #[inline(always)]
    fn mean(&self, field: (&BrickGrid, &Sheet), around: &Around, k: i32) -> Option<f64> {
        let (mut sum, mut known) = (0.0, true);
        for (line, weight) in around.lines.iter().zip(around.weights) {
            let phi = self.phi(field, *line, k);
            known &= (phi.abs() < field.0.band) | (weight == 0.0);
            sum += weight * f64::from(phi);
        }
        known.then_some(sum)
    }

    /// Writes a distance; a voxel that was beyond the band takes the label of the one above it.
    fn write(&mut self, (grid, sheet): (&mut BrickGrid, &Sheet), far: &Far) {
        if grid.phi[far.at] == -grid.band && !grid.label.is_empty() {
            let above = sheet.lattice.place(sheet.on[far.line], far.k + 1);
            grid.label[far.at] = above.map_or(0, |above| grid.label[above]);
        }
        grid.phi[far.at] = far.phi;
        if let Some(at) = self.place(far.line, far.k) {
            self.phi[at] = far.phi;
        }
    }
}
