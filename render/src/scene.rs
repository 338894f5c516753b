//! A scene to be photographed: a part of one or several materials on a table, with lamps and ambient light.

use glam::{DVec2, DVec3, Quat, Vec3};
use rayon::prelude::*;
use sdf_bake::BrickGrid;

use super::camera::Camera;
use super::deposit::Deposit;
use super::environment_map::Surroundings;
use super::field::Field;
use super::frame::Frame;
use super::gbuffer_lanes::{Clear, PrimaryRays, Samples};
use super::lanes::{LANES, Points, any};
use super::light_visibility::LampRays;
use super::lights::{LightPanel, Lights, Panel};
use super::material::{Appearance, Material, PRIMER};
use super::placement::Placement;
use super::rays::{ImagePositions, Rays};
use super::rolling_shutter::RollingShutter;
use super::rows::Rows;
use super::shade_lanes::ShadeLanes;
use super::table_pattern::TablePattern;
use super::texture::Texture;
use super::tile::{TILE, TileVisibility, tile_pixels};

/// Adjacent tiles for which one ray determines the clear length.
const TILES: usize = 4;

/// Label of the first thing in a field that is no part, such as a clamp; the next ones follow. Welds have lower ids.
pub const FIRST_OBSTACLE: u16 = 0xff00;
/// Label of the first body of the tool in a field; the next ones follow.
pub const FIRST_TOOL: u16 = 0xfff0;

/// An infinite level table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Table {
    /// Height of its top in the scene's frame [m].
    pub height: f64,
    /// Material of its top.
    pub material: Material,
    /// Variation of the material. On the CPU only.
    pub texture: Option<Texture>,
    /// Pattern over the material. On the CPU only.
    pub pattern: Option<TablePattern>,
}

/// Everything that a camera can see. Lights, table and camera are in the scene's frame, whose z axis points up.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    /// The part, prepared for ray tracing.
    pub field: Field<'a>,
    /// Pose of the part.
    pub placement: Placement,
    /// Materials of the part.
    pub appearance: Appearance,
    /// Materials of the things in the field that are no part, by label from [`FIRST_OBSTACLE`] on. On the CPU only.
    pub obstacles: Vec<Material>,
    /// Materials of the tool's bodies in the field, by label from [`FIRST_TOOL`] on. On the CPU only.
    pub tool: Vec<Material>,
    /// Table below the part, if any.
    pub table: Option<Table>,
    /// Dust on everything. On the CPU only.
    pub dust: Option<Deposit>,
    /// Lights.
    pub lights: Lights,
    /// Picture of the surroundings, in place of the ambient light. On the CPU only.
    pub surroundings: Option<Surroundings<'a>>,
    /// Motion of the camera while its rows are exposed. On the CPU only.
    pub shutter: Option<RollingShutter>,
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
    /// Returns the first thing in the scene that only the CPU can photograph.
    pub(crate) fn only_on_the_cpu(&self) -> Option<&'static str> {
        let Appearance { marks, primer, texture, oxides, .. } = &self.appearance;
        let found = [
            ("marks of an orbital pad", marks.orbit.is_some()),
            ("a primer", primer.is_some()),
            ("a texture", texture.is_some() || self.table.is_some_and(|table| table.texture.is_some())),
            ("oxides", !oxides.is_none()),
            ("a luminous panel", !self.lights.panels.is_empty()),
            ("a thing that is no part", !self.obstacles.is_empty() || !self.tool.is_empty()),
            ("a pattern of the table", self.table.is_some_and(|table| table.pattern.is_some())),
            ("dust", self.dust.is_some()),
            ("light from a picture", self.surroundings.is_some()),
            ("a rolling shutter", self.shutter.is_some()),
        ];
        found.into_iter().find(|(_, is_there)| *is_there).map(|(name, _)| name)
    }

    /// Material of a body that is no part, by its label.
    pub(crate) fn material_of(&self, label: u16) -> Option<Material> {
        let (bodies, first) =
            if label >= FIRST_TOOL { (&self.tool, FIRST_TOOL) } else { (&self.obstacles, FIRST_OBSTACLE) };
        bodies.get(usize::from(label.checked_sub(first)?)).copied()
    }

    /// A part in the pose of its own frame, with the default lights; coated if it has a dose.
    pub fn new(part: &'a BrickGrid) -> Self {
        let coating = (!part.dose.is_empty()).then_some(PRIMER);
        Self {
            field: Field::new(part),
            placement: Placement::IDENTITY,
            appearance: Appearance { coating, ..Appearance::default() },
            obstacles: Vec::new(),
            tool: Vec::new(),
            table: None,
            dust: None,
            lights: Lights::default(),
            surroundings: None,
            shutter: None,
        }
    }

    /// Photographs the scene, tiles of pixels in parallel. Colour is linear light before the [`Sensor`](super::Sensor).
    pub fn photograph(&self, camera: &Camera, raster: &Raster) -> Frame {
        self.photograph_exposed(&[], camera, raster).0
    }

    /// [`Scene::photograph`] into an earlier frame, so that a series of pictures reuses its memory.
    pub fn photograph_over(&self, frame: &mut Frame, camera: &Camera, raster: &Raster) {
        self.expose(&[], camera, raster, (frame, &mut vec![[]; raster.width * raster.height]));
    }

    /// [`Scene::photograph`], and the colour of each pixel on the part with `N` set shares of exposed metal, 0 to 1, in
    /// place of min(D, 1); black elsewhere. All that does not depend on the share is computed once.
    pub fn photograph_exposed<const N: usize>(
        &self,
        exposed: &[f32; N],
        camera: &Camera,
        raster: &Raster,
    ) -> (Frame, Vec<[Vec3; N]>) {
        let mut frame = Frame::empty(0, 0);
        let mut colours = vec![[Vec3::ZERO; N]; raster.width * raster.height];
        self.expose(exposed, camera, raster, (&mut frame, &mut colours));
        (frame, colours)
    }

    /// Fills the whole frame, and the colours with set shares of exposed metal.
    fn expose<const N: usize>(
        &self,
        exposed: &[f32; N],
        camera: &Camera,
        raster: &Raster,
        (frame, colours): (&mut Frame, &mut [[Vec3; N]]),
    ) {
        frame.be_of_size(raster.width, raster.height);
        let stage = Stage::new(self, camera, raster);
        let beam = |lamp: &Lamp| LampRays::new(&self.field, lamp.towards, lamp.spread);
        let lamps: Vec<LampRays> = stage.lamps.par_iter().map(beam).collect();
        Rows::of(frame, colours).enumerate().for_each(|(y, mut rows)| {
            for first in (0..raster.width).step_by(TILES * TILE) {
                let clear = stage.clear_length((first, TILE * y));
                for x in (first..raster.width.min(first + TILES * TILE)).step_by(TILE) {
                    let (samples, light, others) = stage.tile(&lamps, ((x, TILE * y), clear), exposed);
                    rows.put(x, &samples, (&light, &others));
                }
            }
        });
    }
}

/// A light in the part's frame.
pub(crate) struct Lamp {
    pub(crate) towards: Vec3,
    pub(crate) irradiance: Vec3,
    pub(crate) spread: f32,
}

/// A scene in the part's frame, prepared for the rays of one image.
pub(crate) struct Stage<'a> {
    pub(crate) scene: &'a Scene<'a>,
    pub(crate) raster: &'a Raster,
    pub(crate) aspect: f64,
    /// [`Camera::half_image`] of the camera.
    pub(crate) half_image: f64,
    pub(crate) camera: Camera,
    shutter: Option<RollingShutter>,
    pub(crate) lamps: Vec<Lamp>,
    pub(crate) panels: Vec<Panel>,
    /// Unit vector that points up in the scene.
    pub(crate) up: DVec3,
    /// Rotation from the part's frame to the scene's.
    pub(crate) to_scene: Quat,
    /// Height of the table along `up` [m]; −∞ without a table.
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
        let panel = |panel: &LightPanel| Panel {
            towards: placement.direction_to_part(panel.towards).as_vec3(),
            across: placement.direction_to_part(panel.across).as_vec3(),
            half: panel.half,
            radiance: panel.radiance,
        };
        Self {
            scene,
            raster,
            aspect: raster.width as f64 / raster.height.max(1) as f64,
            half_image: camera.half_image(),
            camera: placement.camera_to_part(camera),
            shutter: scene.shutter.map(|shutter| shutter.to_part(placement)),
            lamps: scene.lights.keys.iter().map(lamp).collect(),
            panels: scene.lights.panels.iter().map(panel).collect(),
            up: placement.direction_to_part(DVec3::Z),
            to_scene: placement.rotation.as_quat(),
            table: scene.table.map_or(f64::NEG_INFINITY, |table| table.height - placement.translation.z),
        }
    }

    /// Rays through image positions.
    #[inline(always)]
    pub(crate) fn rays(&self, at: &ImagePositions) -> Rays {
        let mut rays = Rays::through(at, &self.camera, (self.aspect, self.half_image));
        if let Some(shutter) = &self.shutter {
            shutter.displace(&mut rays, at, &self.camera);
        }
        rays
    }

    /// Distance of a point [m] from the camera along its axis [m] at the exposure of a row. `down`: the row's position
    /// from the top, 0 to 1.
    #[inline(always)]
    pub(crate) fn depth(&self, point: DVec3, down: f64) -> f64 {
        match &self.shutter {
            None => self.camera.depth(point),
            Some(shutter) => shutter.camera(&self.camera, down).depth(point),
        }
    }

    /// Size of a pixel on a surface at this depth [m].
    #[inline(always)]
    pub(crate) fn footprint(&self, depth: f32) -> f32 {
        self.camera.pixel_size_within(f64::from(depth), self.raster.height, self.half_image) as f32
    }

    /// Samples at the centres of a tile's pixels, and their light: by the dose and, where a centre shows the part, with
    /// set shares of exposed metal. `corner`: the tile's first pixel; `clear`: as [`Stage::clear_length`].
    fn tile<const N: usize>(
        &self,
        lamps: &[LampRays],
        (corner, clear): ((usize, usize), f64),
        exposed: &[f32; N],
    ) -> (Samples, Points, [Points; N]) {
        let centres = tile_pixels(corner).map(|(x, y)| DVec2::new(x as f64 + 0.5, y as f64 + 0.5));
        let centres = self.samples(centres, clear);
        if self.raster.samples_per_side <= 1 {
            let (light, others) = self.lights(lamps, &centres, any(&centres.is_solid).then_some(exposed));
            return (centres, light, others);
        }
        let (mut light, mut others) = (Points::ZERO, [Points::ZERO; N]);
        for (i, (x, y)) in tile_pixels(corner).enumerate() {
            if x < self.raster.width && y < self.raster.height {
                let mean = self.mean(lamps, ((x, y), clear), centres.is_solid[i].then_some(exposed));
                light.set(i, mean.0);
                others.iter_mut().zip(mean.1).for_each(|(light, mean)| light.set(i, mean));
            }
        }
        (centres, light, others)
    }

    /// Mean light of a pixel, also with set shares of exposed metal.
    fn mean<const N: usize>(
        &self,
        lamps: &[LampRays],
        ((x, y), clear): ((usize, usize), f64),
        exposed: Option<&[f32; N]>,
    ) -> (Vec3, [Vec3; N]) {
        let side = self.raster.samples_per_side;
        let along = |i: usize| (i as f64 + 0.5) / side as f64;
        let at = |i: usize| DVec2::new(x as f64 + along(i % side), y as f64 + along(i / side));
        let mut sum = (Vec3::ZERO, [Vec3::ZERO; N]);
        for first in (0..side * side).step_by(LANES) {
            let count = LANES.min(side * side - first);
            let samples = self.samples((first..first + count).map(at), clear);
            let lit = self.lights(lamps, &samples, exposed);
            for i in 0..count {
                sum.0 += lit.0.get(i);
                sum.1.iter_mut().zip(&lit.1).for_each(|(sum, light)| *sum += light.get(i));
            }
        }
        let count = (side * side) as f32;
        (sum.0 / count, sum.1.map(|sum| sum / count))
    }

    /// Light of samples by the dose and with set shares of exposed metal.
    fn lights<const N: usize>(
        &self,
        lamps: &[LampRays],
        samples: &Samples,
        exposed: Option<&[f32; N]>,
    ) -> (Points, [Points; N]) {
        let shelter = &TileVisibility::of(self, lamps, samples);
        pulp::Arch::new().dispatch(ShadeLanes { stage: self, samples, shelter, exposed })
    }

    /// Length from the start of each ray through a row of adjacent tiles that is free of metal [m]. `corner`: the first
    /// pixel of the first of [`TILES`].
    fn clear_length(&self, corner: (usize, usize)) -> f64 {
        let corner = DVec2::new(corner.0 as f64, corner.1 as f64);
        let size = DVec2::new((TILES * TILE) as f64, TILE as f64);
        let border = |i: usize| corner + size * DVec2::new((i / 2) as f64 / (LANES / 2 - 1) as f64, (i % 2) as f64);
        let at = &self.places((0..LANES).map(border), |_| true);
        pulp::Arch::new().dispatch(Clear { stage: self, at })
    }

    /// Samples along rays through at most [`LANES`] neighbouring image points [pixels from the top left]; points beyond
    /// the image are skipped.
    fn samples(&self, points: impl Iterator<Item = DVec2>, clear: f64) -> Samples {
        let size = DVec2::new(self.raster.width as f64, self.raster.height as f64);
        let at = &self.places(points, |at| at.cmplt(size).all());
        pulp::Arch::new().dispatch(PrimaryRays { stage: self, at, clear })
    }

    /// At most [`LANES`] image points [pixels from the top left], each marked as `wanted` or not.
    #[inline(always)]
    fn places(&self, points: impl Iterator<Item = DVec2>, wanted: impl Fn(DVec2) -> bool) -> ImagePositions {
        let size = DVec2::new(self.raster.width as f64, self.raster.height as f64);
        let mut places = ImagePositions { across: [0.0; LANES], down: [0.0; LANES], wanted: [false; LANES] };
        for (i, at) in points.enumerate() {
            (places.across[i], places.down[i]) = (at / size).into();
            places.wanted[i] = wanted(at);
        }
        places
    }
}
