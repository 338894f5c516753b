//! A scene to be photographed: a part of one or several materials on a table, lamps and a room around it.

use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;
use sdf_bake::BrickGrid;

use super::beam::Beam;
use super::bundle::common_clear_length;
use super::camera::{Camera, Ray};
use super::field::Field;
use super::frame::{Frame, Seen};
use super::lanes::{LANES, Points};
use super::lights::Lights;
use super::lit::{Lit, Shown};
use super::lockstep::Crossings;
use super::material::{Appearance, Material, PRIMER};
use super::placement::Placement;
use super::surface::Surface;
use super::tile::{Sample, Shelter, TILE, tile_pixels};

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

    /// Photographs the scene; tiles of pixels in parallel. Colour is linear light before the [`Sensor`](super::Sensor).
    pub fn photograph(&self, camera: &Camera, raster: &Raster) -> Frame {
        self.photograph_as(&[], camera, raster).0
    }

    /// As [`Scene::photograph`], with the colour of each pixel on the part in `N` other appearances, black elsewhere:
    /// what is seen and what shelters it are found once.
    pub fn photograph_as<const N: usize>(
        &self,
        others: &[Appearance; N],
        camera: &Camera,
        raster: &Raster,
    ) -> (Frame, Vec<[Vec3; N]>) {
        let mut frame = Frame::empty(raster.width, raster.height);
        let mut colours = vec![[Vec3::ZERO; N]; frame.colour.len()];
        let stage = Stage::new(self, camera, raster);
        let beam = |lamp: &Lamp| Beam::new(&self.field, lamp.towards, lamp.spread);
        let lamps: Vec<Beam> = stage.lamps.par_iter().map(beam).collect();
        let rows = TILE * raster.width.max(1);
        let Frame { colour, depth, normal, position, weld, dose, removed, seen, .. } = &mut frame;
        let floats = (depth.par_chunks_mut(rows), dose.par_chunks_mut(rows), removed.par_chunks_mut(rows));
        let vectors = (colour.par_chunks_mut(rows), normal.par_chunks_mut(rows), position.par_chunks_mut(rows));
        let marks = (weld.par_chunks_mut(rows), seen.par_chunks_mut(rows), colours.par_chunks_mut(rows));
        (vectors, floats, marks).into_par_iter().enumerate().for_each(|(y, (vectors, floats, marks))| {
            let ((colour, normal, position), (depth, dose, removed), (weld, seen, colours)) = (vectors, floats, marks);
            for x in (0..raster.width).step_by(TILE) {
                stage.tile(&lamps, (x, TILE * y), others, |(x, y), sample, light| {
                    let at = y % TILE * raster.width + x;
                    (colour[at], colours[at], seen[at]) = (light.0, light.1, sample.seen);
                    let Some(surface) = sample.surface else { return };
                    (depth[at], normal[at], position[at]) = (surface.depth, surface.normal, surface.position);
                    (weld[at], dose[at], removed[at]) = (surface.weld, surface.dose, surface.removed);
                });
            }
        });
        (frame, colours)
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
    /// Of the camera.
    pub(crate) half_image: f64,
    pub(crate) camera: Camera,
    pub(crate) lamps: Vec<Lamp>,
    /// Unit direction that is up in the scene.
    pub(crate) up: DVec3,
    /// Height of the table along `up` [m]; none at minus infinity.
    pub(crate) table: f64,
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
            half_image: camera.half_image(),
            camera: placement.camera_to_part(camera),
            lamps: scene.lights.keys.iter().map(lamp).collect(),
            up: placement.direction_to_part(DVec3::Z),
            table: scene.table.map_or(f64::NEG_INFINITY, |table| table.height - placement.translation.z),
        }
    }

    /// Gives for each pixel of a tile what its centre shows, and its light: in the scene's appearance and, where the
    /// centre shows the part, in others. `corner`: the tile's first pixel.
    fn tile<const N: usize>(
        &self,
        lamps: &[Beam],
        corner: (usize, usize),
        others: &[Appearance; N],
        mut each: impl FnMut((usize, usize), &Sample, (Vec3, [Vec3; N])),
    ) {
        let within = |&(x, y): &(usize, usize)| x < self.raster.width && y < self.raster.height;
        let pixels = || tile_pixels(corner).filter(within);
        let centres = self.samples(pixels().map(|(x, y)| DVec2::new(x as f64 + 0.5, y as f64 + 0.5)));
        if self.raster.samples_per_side > 1 {
            for (pixel, centre) in pixels().zip(&centres) {
                each(pixel, centre, self.mean(lamps, pixel, centre.seen == Seen::Part, others));
            }
            return;
        }
        let lit = self.lights(lamps, &centres, others, centres.iter().any(|centre| centre.seen == Seen::Part));
        for (i, (pixel, centre)) in pixels().zip(&centres).enumerate() {
            let is_part = centre.seen == Seen::Part;
            let in_others = lit.1.each_ref().map(|light| if is_part { light.get(i) } else { Vec3::ZERO });
            each(pixel, centre, (lit.0.get(i), in_others));
        }
    }

    /// Mean light of a pixel; in other appearances, too, if it is `on_part`.
    fn mean<const N: usize>(
        &self,
        lamps: &[Beam],
        (x, y): (usize, usize),
        on_part: bool,
        others: &[Appearance; N],
    ) -> (Vec3, [Vec3; N]) {
        let side = self.raster.samples_per_side;
        let along = |i: usize| (i as f64 + 0.5) / side as f64;
        let at = |i: usize| DVec2::new(x as f64 + along(i % side), y as f64 + along(i / side));
        let mut sum = (Vec3::ZERO, [Vec3::ZERO; N]);
        for first in (0..side * side).step_by(LANES) {
            let count = LANES.min(side * side - first);
            let samples = self.samples((first..first + count).map(at));
            let lit = self.lights(lamps, &samples, others, on_part);
            for i in 0..count {
                sum.0 += lit.0.get(i);
                sum.1.iter_mut().zip(&lit.1).for_each(|(sum, light)| *sum += light.get(i));
            }
        }
        let count = (side * side) as f32;
        (sum.0 / count, sum.1.map(|sum| sum / count))
    }

    /// Light of samples in the scene's appearance and, if `wanted`, in others.
    fn lights<const N: usize>(
        &self,
        lamps: &[Beam],
        samples: &[Sample; LANES],
        others: &[Appearance; N],
        wanted: bool,
    ) -> (Points, [Points; N]) {
        let (shown, shelter) = (&Shown::new(samples), &Shelter::of(self, lamps, samples));
        let light = |appearance| pulp::Arch::new().dispatch(Lit { stage: self, appearance, shown, shelter });
        let in_others = if wanted { others.each_ref().map(light) } else { [Points::ZERO; N] };
        (light(&self.scene.appearance), in_others)
    }

    /// What rays through at most [`LANES`] neighbouring points of the image meet; from the top left [pixels].
    fn samples(&self, points: impl Iterator<Item = DVec2>) -> [Sample; LANES] {
        let size = DVec2::new(self.raster.width as f64, self.raster.height as f64);
        let field = &self.scene.field;
        let (mut rays, mut count) = ([Ray { origin: DVec3::ZERO, direction: DVec3::ZERO }; LANES], 0);
        for at in points {
            rays[count] = self.camera.ray_within(at / size, self.aspect, self.half_image);
            count += 1;
        }
        let rays = &rays[..count];
        let clear = common_clear_length(field, rays);
        let distances = if clear < f64::INFINITY {
            pulp::Arch::new().dispatch(Crossings { field, padded: field.padded(), rays, clear })
        } else {
            [f64::INFINITY; LANES]
        };
        let mut samples = [Sample::NOTHING; LANES];
        for ((sample, ray), distance) in samples.iter_mut().zip(rays).zip(distances) {
            *sample = self.sample(ray, distance);
        }
        samples
    }

    /// What a ray meets; `distance`: from its start to the part [m].
    fn sample(&self, ray: &Ray, distance: f64) -> Sample {
        let direction = ray.direction.as_vec3();
        let table = self.table_distance(ray);
        if distance <= table && distance < f64::INFINITY {
            let surface =
                Surface::by_padded(&self.scene.field, &self.camera, ray, &self.scene.field.hit(ray, distance));
            Sample { direction, seen: Seen::Part, surface: Some(surface) }
        } else if table < f64::INFINITY {
            let point = ray.origin + ray.direction * table;
            let surface = Surface::bare(self.camera.depth(point), point, self.up.as_vec3(), direction);
            Sample { direction, seen: Seen::Table, surface: Some(surface) }
        } else {
            Sample { direction, ..Sample::NOTHING }
        }
    }

    /// Distance along a ray to the table's top [m]; infinite for one that misses it or starts below.
    fn table_distance(&self, ray: &Ray) -> f64 {
        let (height, fall) = (ray.origin.dot(self.up) - self.table, -ray.direction.dot(self.up));
        if height > 0.0 && height < f64::INFINITY && fall > 1e-9 { height / fall } else { f64::INFINITY }
    }
}
