//! Surface at each sample of the image: the geometry buffers from which colour is computed.

use glam::{DVec2, IVec3, Vec3};
use rayon::prelude::*;
use sdf_bake::Scalar;
use sdf_bake::grid::{cell_corner, trilinear};
pub(crate) use shaders::constants::LABEL_DEPTH;

use super::camera::{Camera, Ray};
use super::field::{Field, cell_of};
use super::removed::removed_depth;
use super::trace::Hit;

/// The surface at one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Surface {
    /// Distance along the camera's axis [m].
    pub(crate) depth: f32,
    /// Position in the part's frame [m].
    pub(crate) position: Vec3,
    pub(crate) normal: Vec3,
    /// Direction of the viewing ray.
    pub(crate) view: Vec3,
    /// Weld id, 0 for base metal.
    pub(crate) weld: u16,
    /// Share of weld metal around the point, 0 to 1: resolves the border below the voxel size.
    pub(crate) weld_share: f32,
    /// Coating dose D; 0 where the part has none.
    pub(crate) dose: f32,
    /// Removed depth [m]; 0 if it is not recorded.
    pub(crate) removed: f32,
}

/// The samples of an image, row by row from the top left; `None` for background.
pub(crate) struct Surfaces {
    pub(crate) width: usize,
    pub(crate) height: usize,
    pub(crate) samples: Vec<Option<Surface>>,
}

/// Traces one ray through the centre of each of `width` × `height` samples, rows in parallel.
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
    /// Reads the grid's channels at a ray's hit.
    pub(crate) fn new(field: &Field, camera: &Camera, ray: &Ray, hit: &Hit) -> Self {
        let at = field.in_voxels(hit.point);
        let (weld, weld_share) = weld_at(field, at - hit.normal * LABEL_DEPTH);
        let [dose, removed] = scalars_at(field, at);
        Self {
            depth: camera.depth(hit.point) as f32,
            position: hit.point.as_vec3(),
            normal: hit.normal,
            view: ray.direction.as_vec3(),
            weld,
            weld_share,
            dose,
            removed,
        }
    }
}

/// Coating dose D and removed depth [m] at a point [voxels], interpolated trilinearly; 0 outside the bricks.
fn scalars_at(field: &Field, point: Vec3) -> [f32; 2] {
    let (corner, within) = cell_of(point);
    scalars_of(field, corner).map(|values| trilinear(&values, within))
}

/// Dose and removed depth at the corners of a cell.
pub(crate) fn scalars_of(field: &Field, corner: IVec3) -> [[f32; 8]; 2] {
    [Scalar::Dose, Scalar::Removed].map(|channel| match field.grid.scalar(channel) {
        [] => [0.0; 8],
        values => field.cell(corner, values, 0.0, 0.0),
    })
}

/// Weld id of greatest weight among the metal voxels around a point [voxels], and the share of all welds.
fn weld_at(field: &Field, point: Vec3) -> (u16, f32) {
    let (corner, within) = cell_of(point);
    WeldCell::new(field, corner).at(within)
}

/// Labels and φ [m] at the corners of a cell.
pub(crate) struct WeldCell {
    labels: [u16; 8],
    /// Zeros if there is only one label.
    phi: [f32; 8],
}

impl WeldCell {
    /// A cell without labels.
    pub(crate) const NONE: Self = Self { labels: [0; 8], phi: [0.0; 8] };

    pub(crate) fn new(field: &Field, corner: IVec3) -> Self {
        let label = &field.grid.label;
        let labels = if label.is_empty() { [0; 8] } else { field.cell(corner, label, 0, 0) };
        let cell = Self { labels, phi: [0.0; 8] };
        if cell.has_one() { cell } else { Self { phi: field.cell_phi(corner), ..cell } }
    }

    fn has_one(&self) -> bool {
        self.labels == [self.labels[0]; 8]
    }

    /// Weld id of greatest weight among the metal voxels around a position in the cell, 0 to 1, and the share of all
    /// welds.
    pub(crate) fn at(&self, within: Vec3) -> (u16, f32) {
        if self.has_one() {
            return (self.labels[0], f32::from(self.labels[0].min(1)));
        }
        mixed_weld(self, within)
    }
}

/// [`WeldCell::at`] for several labels.
fn mixed_weld(WeldCell { labels, phi }: &WeldCell, f: Vec3) -> (u16, f32) {
    let weights: [f32; 8] = std::array::from_fn(|i| {
        let near = Vec3::select(cell_corner(i).cmpeq(IVec3::ONE), f, 1.0 - f);
        if phi[i] <= 0.0 { near.x * near.y * near.z } else { 0.0 }
    });
    let of = |wanted: &dyn Fn(u16) -> bool| -> f32 { (0..8).filter(|&i| wanted(labels[i])).map(|i| weights[i]).sum() };
    let (all, welds) = (of(&|_| true), of(&|label| label != 0));
    if all <= 0.0 {
        let nearest = labels[(0..3).map(|axis| usize::from(f[axis] >= 0.5) << (2 - axis)).sum::<usize>()];
        return (nearest, f32::from(nearest.min(1)));
    }
    if welds < 0.5 * all {
        return (0, welds / all);
    }
    let (mut most, mut most_weight) = (0, 0.0);
    for i in (0..8).filter(|&i| labels[i] != 0) {
        let weight = of(&|label| label == labels[i]);
        if weight > most_weight {
            (most, most_weight) = (labels[i], weight);
        }
    }
    (most, welds / all)
}
