//! Light that the samples of a tile send to the camera, in lanes.

use glam::Vec3;

use super::frame::Seen;
use super::lanes::{LANES, Lanes, Points, any};
use super::marks::{Grooves, any_tangent};
use super::material::{Appearance, Blend, Material};
use super::microfacet::{FacetLanes, Facets};
use super::scene::Stage;
use super::shade::facing;
use super::tile::{Sample, Shelter};

/// What the samples of a tile show, by lanes; zeros where they show the background.
pub(crate) struct Shown {
    directions: Points,
    normals: Points,
    positions: Points,
    depth: Lanes,
    weld_share: Lanes,
    dose: Lanes,
    removed: Lanes,
    is_part: [bool; LANES],
    is_table: [bool; LANES],
}

impl Shown {
    pub(crate) fn new(samples: &[Sample; LANES]) -> Self {
        let none = [0.0; LANES];
        let mut shown = Self {
            directions: Points::ZERO,
            normals: Points::ZERO,
            positions: Points::ZERO,
            depth: none,
            weld_share: none,
            dose: none,
            removed: none,
            is_part: samples.each_ref().map(|sample| sample.seen == Seen::Part),
            is_table: samples.each_ref().map(|sample| sample.seen == Seen::Table),
        };
        for (i, sample) in samples.iter().enumerate() {
            shown.directions.set(i, sample.direction);
            let Some(surface) = &sample.surface else { continue };
            shown.normals.set(i, facing(surface.normal, surface.view));
            shown.positions.set(i, surface.position);
            (shown.depth[i], shown.weld_share[i]) = (surface.depth, surface.weld_share);
            (shown.dose[i], shown.removed[i]) = (surface.dose, surface.removed);
        }
        shown
    }
}

/// Light that comes along the rays of a tile, linear RGB: a call that is compiled for each kind of lanes.
pub(crate) struct Lit<'a> {
    pub(crate) stage: &'a Stage<'a>,
    pub(crate) appearance: &'a Appearance,
    pub(crate) shown: &'a Shown,
    pub(crate) shelter: &'a Shelter,
}

impl pulp::NullaryFnOnce for Lit<'_> {
    type Output = Points;

    #[inline(always)]
    fn call(self) -> Points {
        let Self { stage, shown, .. } = self;
        let (environment, up) = (&stage.scene.lights.environment, stage.up.as_vec3());
        let mut light = Points::ZERO;
        for i in 0..LANES {
            light.set(i, environment.radiance(shown.directions.get(i).dot(up), 0.0));
        }
        if any(&shown.is_part) || any(&shown.is_table) {
            let on_surface = self.of_surfaces();
            for i in 0..LANES {
                let is_surface = shown.is_part[i] | shown.is_table[i];
                light.set(i, if is_surface { on_surface.get(i) } else { light.get(i) });
            }
        }
        light
    }
}

// All below is inlined into that call, or it would not be compiled for its lanes.

impl Lit<'_> {
    #[inline(always)]
    fn of_surfaces(&self) -> Points {
        let Self { stage, shown, shelter, .. } = self;
        let (environment, up) = (&stage.scene.lights.environment, stage.up.as_vec3());
        let facets = self.facets();
        let mut light = Points::ZERO;
        for i in 0..LANES {
            let (facets, viewer) = (facets.get(i), -shown.directions.get(i));
            let mirrored = environment.radiance(facets.mirrored(viewer).dot(up), facets.roughness());
            let around = environment.radiance(facets.normal.dot(up), 1.0);
            let open = facets.diffuse_share() * around + facets.environment_share(viewer) * mirrored;
            light.set(i, open * shelter.open[i]);
        }
        for (lamp, shares) in stage.lamps.iter().zip(&shelter.shares) {
            if shares.iter().all(|share| *share <= 0.0) {
                continue;
            }
            for i in 0..LANES {
                let reflected = facets.get(i).reflected(-shown.directions.get(i), lamp.towards, lamp.spread);
                let added = light.get(i) + reflected * lamp.irradiance * shares[i];
                light.set(i, if shares[i] > 0.0 { added } else { light.get(i) });
            }
        }
        light
    }

    #[inline(always)]
    fn facets(&self) -> FacetLanes {
        let Self { appearance, shown, .. } = self;
        let (mut facets, mut ground) = (FacetLanes::NONE, [0.0; LANES]);
        for i in 0..LANES {
            let (material, share) = self.material(i);
            let normal = shown.normals.get(i);
            facets.set(i, &Facets::new(&material, normal, any_tangent(normal), 0.0));
            ground[i] = share;
        }
        let is_ground = ground.iter().fold(false, |any, ground| any | (*ground > 0.0));
        if is_ground && !appearance.marks.path.is_empty() {
            let grooves = self.grooves();
            for i in 0..LANES {
                facets.set(i, &self.marked(i, &facets.get(i), ground[i], &grooves));
            }
        }
        facets
    }

    /// Material of a lane and how much of it is ground metal.
    #[inline(always)]
    fn material(&self, i: usize) -> (Material, f32) {
        let Self { stage, appearance, shown, .. } = self;
        let table = stage.scene.table.map_or(appearance.metal, |table| table.material);
        let Blend { material, ground } = appearance.blend(shown.weld_share[i], shown.dose[i], shown.removed[i]);
        let of_table = if shown.is_table[i] { 1.0 } else { 0.0 };
        let select = |on_table: f32, on_part: f32| if of_table > 0.0 { on_table } else { on_part };
        let colour = Vec3::new(
            select(table.colour.x, material.colour.x),
            select(table.colour.y, material.colour.y),
            select(table.colour.z, material.colour.z),
        );
        let (roughness, metallic) =
            (select(table.roughness, material.roughness), select(table.metallic, material.metallic));
        (Material { colour, roughness, metallic }, select(0.0, ground))
    }

    #[inline(always)]
    fn grooves(&self) -> Grooves {
        let Self { stage, appearance, shown, .. } = self;
        let mut footprints = [0.0; LANES];
        for i in 0..LANES {
            let depth = f64::from(shown.depth[i]);
            footprints[i] = stage.camera.pixel_size_within(depth, stage.raster.height, stage.half_image) as f32;
        }
        appearance.marks.grooves(&shown.positions, &shown.normals, &footprints)
    }

    /// Facets of a lane with the marks on it.
    #[inline(always)]
    fn marked(&self, i: usize, plain: &Facets, ground: f32, grooves: &Grooves) -> Facets {
        let Self { appearance, shown, .. } = self;
        let (normal, along) = (shown.normals.get(i), grooves.along.get(i));
        let across = normal.cross(along);
        let tilted = (normal + across * (grooves.tilt[i] * ground)).normalize_or(normal);
        let tilted = facing(tilted, shown.directions.get(i));
        let anisotropy = appearance.marks.anisotropy * ground * grooves.share[i];
        let marked = plain.turned(tilted, along, anisotropy);
        if ground > 0.0 { marked } else { *plain }
    }
}
