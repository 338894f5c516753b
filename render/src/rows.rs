//! The rows of pixels that a row of tiles covers.

use glam::Vec3;
use rayon::prelude::*;

use super::frame::{Frame, VisibleObject};
use super::gbuffer_lanes::Samples;
use super::lanes::Points;
use super::tile::{TILE, tile_row};

/// [`TILE`] rows of a frame, or fewer at its lower edge, with one slice per buffer.
pub(crate) struct Rows<'a, const N: usize> {
    width: usize,
    colour: &'a mut [Vec3],
    depth: &'a mut [f32],
    normal: &'a mut [Vec3],
    position: &'a mut [Vec3],
    weld: &'a mut [u16],
    dose: &'a mut [f32],
    removed: &'a mut [f32],
    seen: &'a mut [VisibleObject],
    /// Colours with set shares of exposed metal.
    colours: &'a mut [[Vec3; N]],
}

impl<'a, const N: usize> Rows<'a, N> {
    /// Splits a frame into rows of tiles from its top, to be filled in parallel.
    pub(crate) fn of(frame: &'a mut Frame, colours: &'a mut [[Vec3; N]]) -> impl IndexedParallelIterator<Item = Self> {
        let (width, size) = (frame.width, TILE * frame.width.max(1));
        let Frame { colour, depth, normal, position, weld, dose, removed, seen, .. } = frame;
        let vectors = (colour.par_chunks_mut(size), normal.par_chunks_mut(size), position.par_chunks_mut(size));
        let floats = (depth.par_chunks_mut(size), dose.par_chunks_mut(size), removed.par_chunks_mut(size));
        let marks = (weld.par_chunks_mut(size), seen.par_chunks_mut(size), colours.par_chunks_mut(size));
        (vectors, floats, marks).into_par_iter().map(
            move |((colour, normal, position), (depth, dose, removed), (weld, seen, colours))| Self {
                width,
                colour,
                depth,
                normal,
                position,
                weld,
                dose,
                removed,
                seen,
                colours,
            },
        )
    }

    /// Writes a tile. `x`: its first column; `light`: by the dose; `others`: on the part, with set shares
    /// of exposed metal.
    pub(crate) fn put(&mut self, x: usize, samples: &Samples, (light, others): (&Points, &[Points; N])) {
        let (rows, columns) = ((self.colour.len() / self.width).min(TILE), (self.width - x).min(TILE));
        for row in 0..rows {
            let (first, lanes) = (row * self.width + x, tile_row(row));
            let all = first..first + columns;
            let put = lanes.into_iter();
            fill(&mut self.colour[all.clone()], put.clone().map(|i| light.get(i)));
            fill(&mut self.depth[all.clone()], put.clone().map(|i| samples.depth[i]));
            fill(&mut self.normal[all.clone()], put.clone().map(|i| samples.normals.get(i)));
            fill(&mut self.position[all.clone()], put.clone().map(|i| samples.positions.get(i)));
            fill(&mut self.weld[all.clone()], put.clone().map(|i| samples.weld[i]));
            fill(&mut self.dose[all.clone()], put.clone().map(|i| samples.dose[i]));
            fill(&mut self.removed[all.clone()], put.clone().map(|i| samples.removed[i]));
            fill(&mut self.seen[all.clone()], put.clone().map(|i| samples.seen(i)));
            let is_part = |i: usize| samples.seen(i) == VisibleObject::Part;
            let on_part = |i: usize, light: &Points| if is_part(i) { light.get(i) } else { Vec3::ZERO };
            fill(&mut self.colours[all], put.map(|i| others.each_ref().map(|light| on_part(i, light))));
        }
    }
}

#[inline(always)]
fn fill<T>(pixels: &mut [T], values: impl Iterator<Item = T>) {
    pixels.iter_mut().zip(values).for_each(|(pixel, value)| *pixel = value);
}
