//! Drawn edges: silhouettes and creases are darkened, so that a grey part reads like a technical drawing.

use super::camera::Camera;
use super::shade::smooth_step;
use super::surface::{Surface, Surfaces};

/// Darkening at full edge strength, 0 to 1.
const STRENGTH: f32 = 0.6;
/// Cosine of the angle between neighbouring normals at which a crease starts, and at which it has full strength.
const CREASE: (f32, f32) = (0.93, 0.6);
/// Step in depth relative to the tangent plane at which an edge starts, and at which it has full strength [samples].
const STEP: (f32, f32) = (3.0, 8.0);

/// Colour factor at a sample; 1 away from edges.
pub(crate) fn edge_factor(surfaces: &Surfaces, camera: &Camera, x: usize, y: usize) -> f32 {
    let Some(here) = &surfaces.samples[y * surfaces.width + x] else {
        return 1.0;
    };
    let size = camera.pixel_size(f64::from(here.depth), surfaces.height) as f32;
    let mut edge = 0f32;
    for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1)] {
        let (Some(nx), Some(ny)) = (x.checked_add_signed(dx), y.checked_add_signed(dy)) else {
            continue;
        };
        if nx < surfaces.width && ny < surfaces.height {
            let there = surfaces.samples[ny * surfaces.width + nx].as_ref();
            edge = edge.max(there.map_or(1.0, |there| between(here, there, size)));
        }
    }
    1.0 - STRENGTH * edge
}

/// Edge strength between two neighbouring samples, 0 to 1; only the nearer side of a step is darkened.
fn between(here: &Surface, there: &Surface, size: f32) -> f32 {
    let crease = 1.0 - smooth_step(CREASE.1, CREASE.0, here.normal.dot(there.normal));
    let off_plane = (there.position - here.position).dot(here.normal).abs() / size.max(f32::MIN_POSITIVE);
    let nearer = there.depth > here.depth;
    let step = if nearer { smooth_step(STEP.0, STEP.1, off_plane) } else { 0.0 };
    (0.75 * crease).max(step)
}
