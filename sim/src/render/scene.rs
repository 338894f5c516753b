//! A scene to be photographed: a part of one or several materials on a table, lamps and a room around it.

use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;
use sdf_bake::BrickGrid;

use super::camera::{Camera, Ray};
use super::field::Field;
use super::frame::{Frame, Seen};
use super::lights::Lights;
use super::marks::any_tangent;
use super::material::{Appearance, Material, PRIMER};
use super::microfacet::Facets;
use super::placement::Placement;
use super::shade::{ambient_occlusion, facing, light_share};
use super::surface::Surface;

/// A level table without end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Table {
    /// Of its top in the scene's frame [m].
    pub height: f64,
    /// Its top.
    pub material: Material,
}

/// All that a camera can see. Lights, table and camera are in the scene's frame, whose z axis points up.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    /// The part and where rays can meet it.
    pub field: Field<'a>,
    /// Where it stands.
    pub placement: Placement,
    /// What it is made of.
    pub appearance: Appearance,
    /// What it stands on, if anything.
    pub table: Option<Table>,
    /// What lights it.
    pub lights: Lights,
}

/// Size of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Raster {
    /// Pixels along a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Colour samples along each side of a pixel; 1 sends one ray through each pixel's centre.
    pub samples_per_side: usize,
}

impl Default for Raster {
    fn default() -> Self {
        Self { width: 640, height: 480, samples_per_side: 1 }
    }
}

impl<'a> Scene<'a> {
    /// A part as it lies in its own frame, in the light of a workshop; coated if it has a dose.
    pub fn new(part: &'a BrickGrid) -> Self {
        let coating = (!part.dose.is_empty()).then_some(PRIMER);
        Self {
            field: Field::new(part),
            placement: Placement::IDENTITY,
            appearance: Appearance { coating, ..Appearance::default() },
            table: None,
            lights: Lights::default(),
        }
    }

    /// Photographs the scene; rows in parallel. Colour is linear light before the [`Sensor`](super::Sensor).
    pub fn photograph(&self, camera: &Camera, raster: &Raster) -> Frame {
        let mut frame = Frame::empty(raster.width, raster.height);
        let width = raster.width.max(1);
        let stage = Stage::new(self, camera, raster);
        let Frame { colour, depth, normal, position, weld, dose, removed, seen, .. } = &mut frame;
        let floats = (depth.par_chunks_mut(width), dose.par_chunks_mut(width), removed.par_chunks_mut(width));
        let vectors = (colour.par_chunks_mut(width), normal.par_chunks_mut(width), position.par_chunks_mut(width));
        let marks = (weld.par_chunks_mut(width), seen.par_chunks_mut(width));
        (vectors, floats, marks).into_par_iter().enumerate().for_each(|(y, (vectors, floats, marks))| {
            let ((colour, normal, position), (depth, dose, removed), (weld, seen)) = (vectors, floats, marks);
            (0..width).for_each(|x| {
                let sample = stage.centre(x, y);
                colour[x] = if raster.samples_per_side > 1 { stage.mean(x, y) } else { stage.light(&sample) };
                seen[x] = sample.seen;
                let Some(surface) = sample.surface else { return };
                depth[x] = surface.depth;
                normal[x] = surface.normal;
                position[x] = surface.position;
                weld[x] = surface.weld;
                dose[x] = surface.dose;
                removed[x] = surface.removed;
            });
        });
        frame
    }
}

/// A light in the part's frame.
pub(crate) struct Lamp {
    pub(crate) towards: Vec3,
    pub(crate) irradiance: Vec3,
    pub(crate) spread: f32,
}

/// A scene in the part's frame, ready for the rays of one image.
pub(crate) struct Stage<'a> {
    pub(crate) scene: &'a Scene<'a>,
    pub(crate) raster: &'a Raster,
    pub(crate) aspect: f64,
    pub(crate) camera: Camera,
    pub(crate) lamps: Vec<Lamp>,
    /// Unit direction that is up in the scene.
    pub(crate) up: DVec3,
    /// Height of the table along `up` [m]; none at minus infinity.
    pub(crate) table: f64,
}

/// What a ray meets.
struct Sample {
    direction: Vec3,
    seen: Seen,
    surface: Option<Surface>,
}

impl<'a> Stage<'a> {
    pub(crate) fn new(scene: &'a Scene<'a>, camera: &Camera, raster: &'a Raster) -> Self {
        let placement = &scene.placement;
        let lamp = |key: &super::lights::KeyLight| Lamp {
            towards: placement.direction_to_part(key.towards).as_vec3(),
            irradiance: key.irradiance,
            spread: key.spread,
        };
        Self {
            scene,
            raster,
            aspect: raster.width as f64 / raster.height.max(1) as f64,
            camera: placement.camera_to_part(camera),
            lamps: scene.lights.keys.iter().map(lamp).collect(),
            up: placement.direction_to_part(DVec3::Z),
            table: scene.table.map_or(f64::NEG_INFINITY, |table| table.height - placement.translation.z),
        }
    }

    /// What the ray through a pixel's centre meets.
    fn centre(&self, x: usize, y: usize) -> Sample {
        self.sample(x as f64 + 0.5, y as f64 + 0.5)
    }

    /// Mean light of a pixel.
    fn mean(&self, x: usize, y: usize) -> Vec3 {
        let side = self.raster.samples_per_side;
        let along = |i: usize| (i as f64 + 0.5) / side as f64;
        let light = |i: usize| self.light(&self.sample(x as f64 + along(i % side), y as f64 + along(i / side)));
        (0..side * side).map(light).sum::<Vec3>() / (side * side) as f32
    }

    fn sample(&self, x: f64, y: f64) -> Sample {
        let at = DVec2::new(x / self.raster.width as f64, y / self.raster.height as f64);
        let ray = self.camera.ray(at, self.aspect);
        let direction = ray.direction.as_vec3();
        let table = self.table_distance(&ray);
        match self.scene.field.trace(&ray).filter(|hit| hit.distance <= table) {
            Some(hit) => {
                let surface = Surface::new(&self.scene.field, &self.camera, &ray, &hit);
                Sample { direction, seen: Seen::Part, surface: Some(surface) }
            }
            None if table < f64::INFINITY => {
                let point = ray.origin + ray.direction * table;
                let surface = Surface::bare(self.camera.depth(point), point, self.up.as_vec3(), direction);
                Sample { direction, seen: Seen::Table, surface: Some(surface) }
            }
            None => Sample { direction, seen: Seen::Background, surface: None },
        }
    }

    /// Distance along a ray to the table's top [m]; infinite for one that misses it or starts below.
    fn table_distance(&self, ray: &Ray) -> f64 {
        let (height, fall) = (ray.origin.dot(self.up) - self.table, -ray.direction.dot(self.up));
        if height > 0.0 && height < f64::INFINITY && fall > 1e-9 { height / fall } else { f64::INFINITY }
    }

    /// Light that comes along a ray, linear RGB.
    fn light(&self, sample: &Sample) -> Vec3 {
        let Some(surface) = &sample.surface else {
            return self.scene.lights.environment.radiance(sample.direction.dot(self.up.as_vec3()), 0.0);
        };
        let facets = self.facets(surface, sample.seen);
        let (viewer, field) = (-surface.view, &self.scene.field);
        let environment = &self.scene.lights.environment;
        let up = self.up.as_vec3();
        let mirrored = environment.radiance(facets.mirrored(viewer).dot(up), facets.roughness());
        let around = environment.radiance(facets.normal.dot(up), 1.0);
        let open = ambient_occlusion(field, surface);
        let mut light = (facets.diffuse_share() * around + facets.environment_share(viewer) * mirrored) * open;
        for lamp in &self.lamps {
            let reflected = facets.reflected(viewer, lamp.towards, lamp.spread);
            if reflected != Vec3::ZERO {
                light += reflected * lamp.irradiance * light_share(field, surface, lamp.towards, lamp.spread);
            }
        }
        light
    }

    fn facets(&self, surface: &Surface, seen: Seen) -> Facets {
        let appearance = &self.scene.appearance;
        let normal = facing(surface.normal, surface.view);
        if let (Seen::Table, Some(table)) = (seen, &self.scene.table) {
            return Facets::new(&table.material, normal, any_tangent(normal), 0.0);
        }
        let blend = appearance.blend(surface);
        if blend.ground <= 0.0 || appearance.marks.path.is_empty() {
            return Facets::new(&blend.material, normal, any_tangent(normal), 0.0);
        }
        let footprint = self.camera.pixel_size(f64::from(surface.depth), self.raster.height) as f32;
        let groove = appearance.marks.at(surface.position, normal, footprint);
        let across = normal.cross(groove.along);
        let tilted = (normal + across * (groove.tilt * blend.ground)).normalize_or(normal);
        let anisotropy = appearance.marks.anisotropy * blend.ground * groove.share;
        Facets::new(&blend.material, facing(tilted, surface.view), groove.along, anisotropy)
    }
}
