//! Drawings of a grid in the style of a technical drawing: geometry, light from beside the camera, drawn edges, and the
//! mean over each pixel. A [`Scene`](super::Scene) is photographed instead.

use glam::Vec3;
use rayon::prelude::*;
use sdf_bake::BrickGrid;

use super::camera::Camera;
use super::colour_map::colour_map;
use super::edges::edge_factor;
use super::field::Field;
use super::frame::{Frame, VisibleObject};
use super::material::WELD_BORDER;
use super::removed::round_full_scale;
use super::shade::{BASE_STEEL, Studio, SurfaceReflectance, UNTOUCHED, WELD_METAL, smooth_step};
use super::surface::{Surface, Surfaces, see};

/// Background at the top and at the bottom of the image, linear RGB.
const BACKGROUND: (Vec3, Vec3) = (Vec3::new(0.98, 0.98, 0.985), Vec3::new(0.80, 0.82, 0.84));

/// Size and appearance of a rendering.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    /// Pixels along a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Colour samples along each side of a pixel; 2 gives four samples per pixel.
    pub samples_per_side: usize,
    /// Draws removed depth instead of finishes.
    pub removed: Option<RemovedView<'a>>,
}

/// Reference and scale of a picture of removed depth.
#[derive(Clone, Copy, Debug)]
pub struct RemovedView<'a> {
    /// The part before removal, in the same frame.
    pub before: &'a BrickGrid,
    /// Removed depth of the last colour [m]; `None` for the next round number above the greatest visible depth.
    pub full_scale: Option<f64>,
}

impl Default for View<'_> {
    fn default() -> Self {
        Self { width: 640, height: 480, samples_per_side: 2, removed: None }
    }
}

/// Draws a grid; rows in parallel.
pub fn render(grid: &BrickGrid, camera: &Camera, view: &View) -> Frame {
    let field = Field::new(grid);
    let before = view.removed.map(|removed| Field::new(removed.before));
    let before = before.as_ref();
    let centres = see(&field, before, camera, (view.width, view.height));
    let deepest = centres.samples.iter().flatten().fold(0f32, |most, s| most.max(s.removed));
    let full_scale = view.removed.map(|r| r.full_scale.unwrap_or_else(|| round_full_scale(f64::from(deepest))));
    let side = view.samples_per_side.max(1);
    let light = Light { field: &field, camera, studio: Studio::new(camera), full_scale };
    let colour = if side == 1 {
        light.samples(&centres)
    } else {
        let fine = see(&field, before, camera, (side * view.width, side * view.height));
        mean_of_squares(&light.samples(&fine), fine.width, side)
    };
    let mut frame = Frame { colour, removed_full_scale: full_scale, ..Frame::empty(view.width, view.height) };
    for (pixel, surface) in centres.samples.iter().enumerate() {
        let Some(surface) = surface else { continue };
        frame.depth[pixel] = surface.depth;
        frame.normal[pixel] = surface.normal;
        frame.position[pixel] = surface.position;
        frame.weld[pixel] = surface.weld;
        frame.dose[pixel] = surface.dose;
        frame.removed[pixel] = surface.removed;
        frame.seen[pixel] = VisibleObject::Part;
    }
    frame
}

struct Light<'a> {
    field: &'a Field<'a>,
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
            Some(full) if surface.removed > 0.0 => {
                let colour = colour_map((f64::from(surface.removed) / full) as f32);
                self.studio.shade_mapped(self.field, surface, colour)
            }
            Some(_) => self.studio.shade(self.field, surface, &UNTOUCHED),
            None => {
                let weld = smooth_step(WELD_BORDER.0, WELD_BORDER.1, surface.weld_share);
                let finish = SurfaceReflectance {
                    diffuse: BASE_STEEL.diffuse.lerp(WELD_METAL.diffuse, weld),
                    mirror: BASE_STEEL.mirror.lerp(WELD_METAL.mirror, weld),
                };
                self.studio.shade(self.field, surface, &finish)
            }
        }
    }
}

/// Mean over blocks of `side` × `side` samples in rows of `width`.
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

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use sdf_bake::grid::{BRICK_VOXELS, voxel_at};

    use super::*;
    use crate::{Projection, REMOVED_RESOLUTION};

    const VOXEL: f64 = 0.0005;
    const RADIUS: f64 = 0.01;

    fn ball(radius: f64) -> BrickGrid {
        let low = DVec3::splat(-RADIUS);
        BrickGrid::from_distance(low, -low, VOXEL, 3.0, move |p| p.length() - radius)
    }

    fn view(samples_per_side: usize) -> View<'static> {
        View { width: 200, height: 150, samples_per_side, removed: None }
    }

    #[test]
    fn a_ball_s_silhouette_and_depth_agree_with_the_closed_form() {
        let eye = DVec3::new(0.12, -0.07, 0.09);
        let pinhole = Projection::Perspective { vertical_field_of_view: 0.17 };
        let view = View { width: 640, height: 480, samples_per_side: 1, removed: None };
        let frame = render(&ball(RADIUS), &Camera::look_at(eye, DVec3::ZERO, pinhole), &view);
        // The outline of a centred ball is a circle of slope R / √(d² − R²).
        let distance = eye.length();
        let slope = RADIUS / (distance * distance - RADIUS * RADIUS).sqrt();
        let pixels = slope / 0.085f64.tan() * 240.0;
        let seen = frame.depth.iter().filter(|depth| depth.is_finite()).count() as f64;
        let area = std::f64::consts::PI * pixels * pixels;
        assert!((seen / area - 1.0).abs() < 0.005, "{seen} pixels, the closed form says {area}");
        for y in (0..480).step_by(7) {
            for x in (0..640).step_by(7) {
                let (u, v) = (f64::from(x) + 0.5 - 320.0, f64::from(y) + 0.5 - 240.0);
                let (u, v) = (u / 240.0 * 0.085f64.tan(), v / 240.0 * 0.085f64.tan());
                let square = 1.0 + u * u + v * v;
                let root = distance * distance - square * (distance * distance - RADIUS * RADIUS);
                // Near the outline the depth error for a given distance from the surface grows without bound.
                if root > 0.1 * RADIUS * RADIUS {
                    let exact = (distance - root.sqrt()) / square;
                    let depth = f64::from(frame.depth[(y * 640 + x) as usize]);
                    assert!((depth - exact).abs() < 0.05 * VOXEL, "{depth} for {exact} at ({x}, {y})");
                }
            }
        }
    }

    #[test]
    fn the_picture_is_the_same_for_any_number_of_threads() {
        let grid = ball(RADIUS);
        let camera = Camera::framing(DVec3::splat(-RADIUS), DVec3::splat(RADIUS), 0.4, 0.6, 4.0 / 3.0);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| render(&grid, &camera, &view(2)))
        };
        let one = on(1);
        assert_eq!(one, on(2));
        assert_eq!(one, on(5));
    }

    #[test]
    fn buffers_are_free_of_nan_from_every_side_and_from_within() {
        let mut grid = ball(RADIUS);
        grid.label = (0..grid.phi.len()).map(|i| u16::from(i % 3 == 0)).collect();
        let pinhole = Projection::Perspective { vertical_field_of_view: 0.9 };
        let eyes = [DVec3::Z * 0.05, DVec3::Z * -0.05, DVec3::X * 0.011, DVec3::ZERO, DVec3::splat(0.02)];
        for eye in eyes {
            for before in [None, Some(RemovedView { before: &ball(0.0101), full_scale: None })] {
                let camera = Camera::look_at(eye, DVec3::ZERO, pinhole);
                let frame = render(&grid, &camera, &View { removed: before, ..view(1) });
                assert!(frame.colour.iter().all(|c| c.is_finite() && c.min_element() >= 0.0), "from {eye}");
                assert!(frame.depth.iter().all(|depth| !depth.is_nan()));
                assert!(frame.normal.iter().chain(&frame.position).all(|v| v.is_finite()));
                assert!(frame.removed.iter().all(|depth| depth.is_finite() && *depth >= 0.0));
            }
        }
        assert_eq!(
            render(&grid, &Camera::look_at(DVec3::Z, DVec3::ZERO, pinhole), &View { width: 0, ..view(2) }).colour,
            []
        );
    }

    #[test]
    fn welds_are_named_where_their_metal_is() {
        let mut grid = ball(RADIUS);
        let metal = |i: usize| (grid.position(voxel_at(grid.bricks[i / BRICK_VOXELS], i % BRICK_VOXELS)), grid.phi[i]);
        grid.label = (0..grid.phi.len())
            .map(|i| match metal(i) {
                (p, phi) if phi <= 0.0 && p.x > 0.004 => 7,
                (p, phi) if phi <= 0.0 && p.x < -0.004 => 2,
                _ => 0,
            })
            .collect();
        let camera = Camera::look_at(DVec3::Y * -0.2, DVec3::ZERO, Projection::Orthographic { height: 0.024 });
        let frame = render(&grid, &camera, &view(1));
        for (i, &weld) in frame.weld.iter().enumerate() {
            let x = f64::from(frame.position[i].x);
            if (x.abs() - 0.004).abs() > VOXEL && frame.depth[i].is_finite() {
                let expected = if x > 0.004 {
                    7
                } else if x < -0.004 {
                    2
                } else {
                    0
                };
                assert_eq!(weld, expected, "at x = {x}");
            }
        }
        assert!(frame.weld.contains(&7) && frame.weld.contains(&2));
    }

    #[test]
    fn removed_depth_of_a_shrunk_ball_is_drawn_and_scaled() {
        let (before, after) = (ball(RADIUS), ball(RADIUS - 0.0012));
        let camera = Camera::framing(DVec3::splat(-RADIUS), DVec3::splat(RADIUS), 0.4, 0.6, 4.0 / 3.0);
        let compare = |after: &BrickGrid| {
            let removed = Some(RemovedView { before: &before, full_scale: None });
            render(after, &camera, &View { removed, ..view(1) })
        };
        let frame = compare(&after);
        let visible = || frame.depth.iter().zip(&frame.removed).filter(|(depth, _)| depth.is_finite());
        assert!(visible().count() > 1000);
        assert!(visible().all(|(_, removed)| (f64::from(*removed) - 0.0012).abs() < 0.05 * VOXEL));
        assert_eq!(frame.removed_full_scale, Some(0.002));
        let untouched = compare(&before);
        assert!(untouched.removed.iter().all(|&removed| removed == 0.0), "below {REMOVED_RESOLUTION} voxel");
    }
}
