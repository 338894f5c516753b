//! Light reflected by the samples of a tile to the camera, in lanes.

use glam::Vec3;

use super::environment_map::Surroundings;
use super::gbuffer_lanes::Samples;
use super::lanes::{LANES, Lanes, Points, any};
use super::marks::{Grooves, any_tangent};
use super::microfacet::{FacetLanes, Facets};
use super::scene::Stage;
use super::shade::facing;
use super::tile::TileVisibility;
use super::tile_finish::TileFinish;

/// Light along the rays of a tile, linear RGB, by the dose and with set shares of exposed metal; compiled by `pulp` for
/// each instruction set.
pub(crate) struct ShadeLanes<'a, const N: usize> {
    pub(crate) stage: &'a Stage<'a>,
    pub(crate) samples: &'a Samples,
    pub(crate) shelter: &'a TileVisibility,
    /// Set shares of exposed metal, 0 to 1; `None` if they are not needed, then their light is zero.
    pub(crate) exposed: Option<&'a [f32; N]>,
}

impl<const N: usize> pulp::NullaryFnOnce for ShadeLanes<'_, N> {
    type Output = (Points, [Points; N]);

    #[inline(always)]
    fn call(self) -> Self::Output {
        let Self { stage, samples, exposed, .. } = self;
        let (environment, up) = (&stage.scene.lights.environment, stage.up.as_vec3());
        let mut background = Points::ZERO;
        for i in 0..LANES {
            background.set(i, environment.radiance(samples.directions.get(i).dot(up), 0.0));
        }
        if let Some(around) = stage.scene.surroundings {
            for i in 0..LANES {
                background.set(i, around.radiance(stage.to_scene * samples.directions.get(i), 0.0));
            }
        }
        let mut others = [Points::ZERO; N];
        if !any(&samples.is_solid) && !any(&samples.is_table) {
            return (background, if exposed.is_some() { [background; N] } else { others });
        }
        let finish = &TileFinish::of(stage, samples, exposed.is_some_and(|shares| !shares.is_empty()));
        let mut by_dose = [0.0; LANES];
        for i in 0..LANES {
            by_dose[i] = samples.dose[i].clamp(0.0, 1.0);
        }
        let mut grooves = None;
        let light = self.over(&background, &self.of_surfaces(finish, &by_dose, &mut grooves));
        for (other, share) in others.iter_mut().zip(exposed.into_iter().flatten()) {
            *other = self.over(&background, &self.of_surfaces(finish, &[*share; LANES], &mut grooves));
        }
        (light, others)
    }
}

// Everything below is inlined into that call, so that it is compiled for the same instruction set.

impl<const N: usize> ShadeLanes<'_, N> {
    /// Light of surfaces in front of the background.
    #[inline(always)]
    fn over(&self, background: &Points, on_surface: &Points) -> Points {
        let mut light = *background;
        for i in 0..LANES {
            let is_surface = self.samples.is_solid[i] | self.samples.is_table[i];
            light.set(i, if is_surface { on_surface.get(i) } else { light.get(i) });
        }
        light
    }

    /// Light of surfaces with these shares of exposed metal. `grooves`: marks of the tile, found when first needed.
    #[inline(always)]
    fn of_surfaces(&self, finish: &TileFinish, exposed: &Lanes, grooves: &mut Option<Grooves>) -> Points {
        let Self { stage, samples, shelter, .. } = self;
        let (environment, up) = (&stage.scene.lights.environment, stage.up.as_vec3());
        let facets = self.facets(finish, exposed, grooves);
        let mut light = Points::ZERO;
        for i in 0..LANES {
            let (facets, viewer) = (facets.get(i), -samples.directions.get(i));
            let mirrored = environment.radiance(facets.mirrored(viewer).dot(up), facets.roughness());
            let around = environment.radiance(facets.normal.dot(up), 1.0);
            light.set(i, open_light(&facets, viewer, (around, mirrored)) * shelter.open[i]);
        }
        if let Some(around) = stage.scene.surroundings {
            self.pictured(around, &facets, &mut light);
        }
        // In a loop of their own: without panels the loop above stays free of branches, and runs in lanes.
        for panel in &stage.panels {
            for i in 0..LANES {
                let (facets, viewer) = (facets.get(i), -samples.directions.get(i));
                let mirrored = panel.radiance(facets.mirrored(viewer), facets.roughness());
                let around = panel.radiosity(facets.normal);
                light.set(i, light.get(i) + open_light(&facets, viewer, (around, mirrored)) * shelter.open[i]);
            }
        }
        for (lamp, shares) in stage.lamps.iter().zip(&shelter.shares) {
            if shares.iter().all(|share| *share <= 0.0) {
                continue;
            }
            for i in 0..LANES {
                let reflected = facets.get(i).reflected(-samples.directions.get(i), lamp.towards, lamp.spread);
                let added = light.get(i) + reflected * lamp.irradiance * shares[i];
                light.set(i, if shares[i] > 0.0 { added } else { light.get(i) });
            }
        }
        light
    }

    /// Replaces the ambient light of surfaces by that of a picture.
    fn pictured(&self, around: Surroundings, facets: &FacetLanes, light: &mut Points) {
        let Self { stage, samples, shelter, .. } = self;
        for i in (0..LANES).filter(|&i| samples.is_solid[i] | samples.is_table[i]) {
            let (facets, viewer) = (facets.get(i), -samples.directions.get(i));
            let from = |direction: Vec3, roughness: f32| around.radiance(stage.to_scene * direction, roughness);
            let lit = (from(facets.normal, 1.0), from(facets.mirrored(viewer), facets.roughness()));
            light.set(i, open_light(&facets, viewer, lit) * shelter.open[i]);
        }
    }

    #[inline(always)]
    fn facets(&self, finish: &TileFinish, exposed: &Lanes, grooves: &mut Option<Grooves>) -> FacetLanes {
        let Self { stage, samples, .. } = self;
        let mut facets = FacetLanes::NONE;
        let materials = finish.materials(stage, samples, exposed);
        for i in 0..LANES {
            let normal = finish.normals.get(i);
            facets.set(i, &Facets::new(&materials.get(i), normal, any_tangent(normal), 0.0));
        }
        let ground = &materials.ground;
        let is_ground = ground.iter().fold(false, |any, ground| any | (*ground > 0.0));
        if is_ground && !stage.scene.appearance.marks.is_empty() {
            if grooves.is_none() {
                *grooves = Some(self.grooves(&finish.normals));
            }
            if let Some(grooves) = grooves {
                for i in 0..LANES {
                    facets.set(i, &self.marked(i, &facets.get(i), ground[i], grooves));
                }
            }
        }
        facets
    }

    #[inline(always)]
    fn grooves(&self, normals: &Points) -> Grooves {
        let Self { stage, samples, .. } = self;
        let mut footprints = [0.0; LANES];
        for i in 0..LANES {
            footprints[i] = stage.footprint(samples.depth[i]);
        }
        stage.scene.appearance.marks.grooves(&samples.positions, normals, &footprints)
    }

    /// Facets of a lane with its grinding marks.
    #[inline(always)]
    fn marked(&self, i: usize, plain: &Facets, ground: f32, grooves: &Grooves) -> Facets {
        let Self { stage, samples, .. } = self;
        let (normal, along) = (plain.normal, grooves.along.get(i));
        let across = normal.cross(along);
        let tilted = (normal + across * (grooves.tilt[i] * ground)).normalize_or(normal);
        let tilted = facing(tilted, samples.directions.get(i));
        let anisotropy = stage.scene.appearance.marks.anisotropy * ground * grooves.share[i];
        let marked = plain.turned(tilted, along, anisotropy);
        if ground > 0.0 { marked } else { *plain }
    }
}

/// Light of the surroundings reflected to the viewer where nothing hides them.
///
/// - `around`, `mirrored`: radiance from around the normal, and from the mirrored direction
#[inline(always)]
fn open_light(facets: &Facets, viewer: Vec3, (around, mirrored): (Vec3, Vec3)) -> Vec3 {
    facets.diffuse_share() * around + facets.environment_share(viewer) * mirrored
}
