//! What is seen at each sample of the image: the geometry buffers from which colour is made.

use glam::{DVec2, DVec3, IVec3, Vec3};
use rayon::prelude::*;
use sdf_bake::grid::cell_corner;
use sdf_bake::{BrickGrid, Scalar};

use super::camera::{Camera, Ray};
use super::field::Field;
use super::removed::removed_depth;
use super::trace::Hit;

/// Labels are read this far below the surface [voxels], where the metal that carries them is.
const LABEL_DEPTH: f64 = 0.75;

/// The surface at one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Surface {
    /// Along the camera's axis [m].
    pub(crate) depth: f32,
    /// In the part's frame [m].
    pub(crate) position: Vec3,
    pub(crate) normal: Vec3,
    /// Direction of the ray that found it.
    pub(crate) view: Vec3,
    /// Weld id, 0 for base metal.
    pub(crate) weld: u16,
    /// Share of weld metal around the point, 0 to 1: a border finer than the voxels.
    pub(crate) weld_share: f32,
    /// Coating dose D; 0 where the part has none.
    pub(crate) dose: f32,
    /// Depth removed here [m]; 0 where nobody keeps it.
    pub(crate) removed: f32,
}

/// The samples of an image, row by row from the top left; `None` where the background shows.
pub(crate) struct Surfaces {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) samples: Vec<Option<Surface>>,
}

/// One ray through the middle of each of `width` × `height` samples, rows in parallel.
pub(crate) fn see(field: &Field, before: Option<&Field>, camera: &Camera, (width, height): (usize, usize)) -> Surfaces {
    let aspect = width as f64 / height.max(1) as f64;
    let mut samples = vec![None; width * height];
    samples.par_chunks_mut(width.max(1)).enumerate().for_each(|(y, row)| {
        for (x, sample) in row.iter_mut().enumerate() {
            let at = DVec2::new((x as f64 + 0.5) / width as f64, (y as f64 + 0.5) / height as f64);
            let ray = camera.ray(at, aspect);
            *sample = field.trace(&ray).map(|hit| {
                let surface = Surface::new(field, camera, &ray, &hit);
                let removed = before.map(|before| removed_depth(before, hit.point, hit.normal) as f32);
                Surface { removed: removed.unwrap_or(surface.removed), ..surface }
            });
        }
    });
    Surfaces { width, height, samples }
}

impl Surface {
    /// What the channels of the grid tell of a point that a ray has met.
    pub(crate) fn new(field: &Field, camera: &Camera, ray: &Ray, hit: &Hit) -> Self {
        let grid = field.grid;
        let (weld, weld_share) = weld_at(grid, hit.point - hit.normal.as_dvec3() * (LABEL_DEPTH * grid.voxel));
        let scalar = |channel| match grid.scalar(channel) {
            [] => 0.0,
            _ => grid.sample_scalar(channel, hit.point),
        };
        Self {
            depth: camera.depth(hit.point) as f32,
            position: hit.point.as_vec3(),
            normal: hit.normal,
            view: ray.direction.as_vec3(),
            weld,
            weld_share,
            dose: scalar(Scalar::Dose),
            removed: scalar(Scalar::Removed),
        }
    }

    /// A place on a table.
    pub(crate) fn bare(depth: f64, point: DVec3, normal: Vec3, view: Vec3) -> Self {
        let position = point.as_vec3();
        Self { depth: depth as f32, position, normal, view, weld: 0, weld_share: 0.0, dose: 0.0, removed: 0.0 }
    }
}

/// Weld id with the most weight among the metal voxels around a point [m], and the share of all welds.
fn weld_at(grid: &BrickGrid, point: DVec3) -> (u16, f32) {
    if grid.label.is_empty() {
        return (0, 0.0);
    }
    let (corner, at) = grid.cell(point);
    let phi = grid.cell_phi(corner);
    let weight = |i: usize| {
        let c: IVec3 = cell_corner(i);
        let near = |c: i32, f: f32| if c == 1 { f } else { 1.0 - f };
        if phi[i] <= 0.0 { near(c.x, at.x) * near(c.y, at.y) * near(c.z, at.z) } else { 0.0 }
    };
    let labels: [u16; 8] = std::array::from_fn(|i| grid.label_at(corner + cell_corner(i)));
    let weights: [f32; 8] = std::array::from_fn(weight);
    let of = |wanted: &dyn Fn(u16) -> bool| -> f32 { (0..8).filter(|&i| wanted(labels[i])).map(|i| weights[i]).sum() };
    let (all, welds) = (of(&|_| true), of(&|label| label != 0));
    if all <= 0.0 {
        let nearest = grid.label(point);
        return (nearest, if nearest == 0 { 0.0 } else { 1.0 });
    }
    if welds < 0.5 * all {
        return (0, welds / all);
    }
    let mut most = 0usize;
    let mut most_weight = 0.0;
    for i in (0..8).filter(|&i| labels[i] != 0) {
        let weight = of(&|label| label == labels[i]);
        if weight > most_weight {
            (most, most_weight) = (i, weight);
        }
    }
    (labels[most], welds / all)
}
