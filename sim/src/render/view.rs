//! One view of a grid: geometry, light and the mean over each pixel.

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use sdf_bake::BrickGrid;
use sdf_bake::grid::{BRICK_VOXELS, voxel_at};

use super::camera::Camera;
use super::colour_map::colour_map;
use super::edges::edge_factor;
use super::frame::Frame;
use super::removed::round_full_scale;
use super::shade::{BASE_STEEL, Finish, Studio, UNTOUCHED, WELD_METAL, smooth_step};
use super::surface::{Surface, Surfaces, see};

/// Background at the top and at the bottom of the image, linear RGB.
const BACKGROUND: (Vec3, Vec3) = (Vec3::new(0.98, 0.98, 0.985), Vec3::new(0.80, 0.82, 0.84));
/// Share of weld metal over which its tint sets in.
const WELD_BORDER: (f32, f32) = (0.35, 0.65);

/// Size and appearance of a rendering.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Pixels along a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Colour samples along each side of a pixel; 2 gives four a pixel.
    pub samples_per_side: usize,
    /// Draws removed depth instead of finishes.
    pub removed: Option<RemovedView<'a>>,
}

/// What a picture of removed depth is compared with and how it is scaled.
#[derive(Clone, Copy, Debug)]
pub struct RemovedView<'a> {
    /// The part before removal, in the same frame.
    pub before: &'a BrickGrid,
    /// Removed depth that has the last colour [m]; `None` takes the next round number above the deepest visible.
    pub full_scale: Option<f64>,
}

impl Default for View<'_> {
    fn default() -> Self {
        Self { width: 640, height: 480, samples_per_side: 2, removed: None }
    }
}

/// Renders a grid; rows in parallel.
pub fn render(grid: &BrickGrid, camera: &Camera, view: &View) -> Frame {
    let before = view.removed.map(|removed| removed.before);
    let centres = see(grid, before, camera, (view.width, view.height));
    let deepest = centres.samples.iter().flatten().fold(0f32, |most, s| most.max(s.removed));
    let full_scale = view.removed.map(|r| r.full_scale.unwrap_or_else(|| round_full_scale(f64::from(deepest))));
    let side = view.samples_per_side.max(1);
    let light = Light { grid, camera, studio: Studio::new(camera), full_scale };
    let colour = if side == 1 {
        light.samples(&centres)
    } else {
        let fine = see(grid, before, camera, (side * view.width, side * view.height));
        mean_of_squares(&light.samples(&fine), fine.width, side)
    };
    let buffer = |of: fn(&Surface) -> Vec3| centres.samples.iter().map(|s| s.as_ref().map_or(Vec3::ZERO, of)).collect();
    Frame {
        width: view.width,
        height: view.height,
        colour,
        depth: centres.samples.iter().map(|s| s.map_or(f32::INFINITY, |s| s.depth)).collect(),
        normal: buffer(|s| s.normal),
        position: buffer(|s| s.position),
        weld: centres.samples.iter().map(|s| s.map_or(0, |s| s.weld)).collect(),
        removed: centres.samples.iter().map(|s| s.map_or(0.0, |s| s.removed)).collect(),
        removed_full_scale: full_scale,
    }
}

/// Lowest and highest corner [m] of the voxels in the metal, one voxel wider; `None` for a grid without metal.
pub fn surface_bounds(grid: &BrickGrid) -> Option<(DVec3, DVec3)> {
    let mut bounds: Option<(glam::IVec3, glam::IVec3)> = None;
    for (at, _) in grid.phi.iter().enumerate().filter(|(_, phi)| **phi <= 0.0) {
        let voxel = voxel_at(grid.bricks[at / BRICK_VOXELS], at % BRICK_VOXELS);
        bounds = Some(bounds.map_or((voxel, voxel), |(low, high)| (low.min(voxel), high.max(voxel))));
    }
    bounds.map(|(low, high)| (grid.position(low - 1), grid.position(high + 1)))
}

struct Light<'a> {
    grid: &'a BrickGrid,
    camera: &'a Camera,
    studio: Studio,
    full_scale: Option<f64>,
}

impl Light<'_> {
    /// Colour of all samples, linear RGB.
    fn samples(&self, surfaces: &Surfaces) -> Vec<Vec3> {
        let mut colours = vec![Vec3::ZERO; surfaces.samples.len()];
        colours.par_chunks_mut(surfaces.width.max(1)).enumerate().for_each(|(y, row)| {
            let background = BACKGROUND.0.lerp(BACKGROUND.1, (y as f32 + 0.5) / surfaces.height as f32);
            for (x, colour) in row.iter_mut().enumerate() {
                *colour = match &surfaces.samples[y * surfaces.width + x] {
                    Some(surface) => self.surface(surface) * edge_factor(surfaces, self.camera, x, y),
                    None => background,
                };
            }
        });
        colours
    }

    fn surface(&self, surface: &Surface) -> Vec3 {
        match self.full_scale {
            Some(_) if !(surface.removed > 0.0) => self.studio.shade(self.grid, surface, &UNTOUCHED),
            Some(full) => {
                let colour = colour_map((f64::from(surface.removed) / full) as f32);
                self.studio.shade_mapped(self.grid, surface, colour)
            }
            None => {
                let weld = smooth_step(WELD_BORDER.0, WELD_BORDER.1, surface.weld_share);
                let finish = Finish {
                    diffuse: BASE_STEEL.diffuse.lerp(WELD_METAL.diffuse, weld),
                    mirror: BASE_STEEL.mirror.lerp(WELD_METAL.mirror, weld),
                };
                self.studio.shade(self.grid, surface, &finish)
            }
        }
    }
}

/// Mean over squares of `side` × `side` samples in rows of `width`.
fn mean_of_squares(samples: &[Vec3], width: usize, side: usize) -> Vec<Vec3> {
    let columns = width / side;
    let rows = samples.len().checked_div(width * side).unwrap_or(0);
    let mean = |pixel: usize| {
        let (x, y) = (pixel % columns * side, pixel / columns * side);
        let sum: Vec3 = (0..side * side).map(|i| samples[(y + i / side) * width + x + i % side]).sum();
        sum / (side * side) as f32
    };
    (0..columns * rows).map(mean).collect()
}
