//! The rows of pixels that a row of tiles fills.

use glam::Vec3;
use rayon::prelude::*;

use super::frame::{Frame, Seen};
use super::lanes::Points;
use super::sight::Samples;
use super::tile::{TILE, tile_pixels};

/// [`TILE`] rows of a frame, or fewer at its lower edge, each buffer a slice.
pub(crate) struct Rows<'a, const N: usize> {
    width: usize,
    colour: &'a mut [Vec3],
    depth: &'a mut [f32],
    normal: &'a mut [Vec3],
    position: &'a mut [Vec3],
    weld: &'a mut [u16],
    dose: &'a mut [f32],
    removed: &'a mut [f32],
    seen: &'a mut [Seen],
    /// In other appearances.
    colours: &'a mut [[Vec3; N]],
}

impl<'a, const N: usize> Rows<'a, N> {
    /// Those of a frame from its top, to be filled in parallel.
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

    /// Puts a tile where it belongs. `x`: its first column; `light`: in the scene's appearance and, on the part, in others.
    pub(crate) fn put(&mut self, x: usize, samples: &Samples, (light, others): (&Points, &[Points; N])) {
        let rows = self.colour.len() / self.width;
        for (i, (x, y)) in tile_pixels((x, 0)).enumerate().filter(|(_, (x, y))| *x < self.width && *y < rows) {
            let at = y * self.width + x;
            let on_part = |light: &Points| if samples.is_part[i] { light.get(i) } else { Vec3::ZERO };
            (self.colour[at], self.colours[at]) = (light.get(i), others.each_ref().map(on_part));
            (self.depth[at], self.seen[at]) = (samples.depth[i], samples.seen(i));
            (self.normal[at], self.position[at]) = (samples.normals.get(i), samples.positions.get(i));
            (self.weld[at], self.dose[at], self.removed[at]) = (samples.weld[i], samples.dose[i], samples.removed[i]);
        }
    }
}
