//! Light reflected by the samples of a tile to the camera, in lanes.

use glam::Vec3;

use super::environment_map::Surroundings;
use super::gbuffer_lanes::Samples;
use super::lanes::{LANES, Points, any};
use super::marks::{Grooves, any_tangent};
use super::material::{Appearance, Blend, MaterialLanes};
use super::microfacet::{FacetLanes, Facets};
use super::oxides::OxidePlace;
use super::scene::{Scene, Stage};
use super::shade::facing;
use super::table_pattern::TablePattern;
use super::texture::Texture;
use super::tile::TileVisibility;

/// Light along the rays of a tile, linear RGB; compiled by `pulp` for each instruction set.
pub(crate) struct ShadeLanes<'a> {
    pub(crate) stage: &'a Stage<'a>,
    pub(crate) appearance: &'a Appearance,
    pub(crate) samples: &'a Samples,
    pub(crate) shelter: &'a TileVisibility,
}

impl pulp::NullaryFnOnce for ShadeLanes<'_> {
    type Output = Points;

    #[inline(always)]
    fn call(self) -> Points {
        let Self { stage, samples, .. } = self;
        let (environment, up) = (&stage.scene.lights.environment, stage.up.as_vec3());
        let mut light = Points::ZERO;
        for i in 0..LANES {
            light.set(i, environment.radiance(samples.directions.get(i).dot(up), 0.0));
        }
        if let Some(around) = stage.scene.surroundings {
            (0..LANES).for_each(|i| light.set(i, around.radiance(stage.to_scene * samples.directions.get(i), 0.0)));
        }
        if any(&samples.is_solid) || any(&samples.is_table) {
            let on_surface = self.of_surfaces();
            for i in 0..LANES {
                let is_surface = samples.is_solid[i] | samples.is_table[i];
                light.set(i, if is_surface { on_surface.get(i) } else { light.get(i) });
            }
        }
        light
    }
}

// Everything below is inlined into that call, so that it is compiled for the same instruction set.

impl ShadeLanes<'_> {
    #[inline(always)]
    fn of_surfaces(&self) -> Points {
        let Self { stage, samples, shelter, .. } = self;
        let (environment, up) = (&stage.scene.lights.environment, stage.up.as_vec3());
        let facets = self.facets();
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
    fn facets(&self) -> FacetLanes {
        let Self { appearance, samples, .. } = self;
        let mut normals = Points::ZERO;
        for i in 0..LANES {
            normals.set(i, facing(samples.normals.get(i), samples.directions.get(i)));
        }
        let mut facets = FacetLanes::NONE;
        let materials = self.materials();
        for i in 0..LANES {
            let normal = normals.get(i);
            facets.set(i, &Facets::new(&materials.get(i), normal, any_tangent(normal), 0.0));
        }
        let ground = &materials.ground;
        let is_ground = ground.iter().fold(false, |any, ground| any | (*ground > 0.0));
        if is_ground && !appearance.marks.is_empty() {
            let grooves = self.grooves(&normals);
            for i in 0..LANES {
                facets.set(i, &self.marked(i, &facets.get(i), ground[i], &grooves));
            }
        }
        facets
    }

    /// Materials of part and table.
    #[inline(always)]
    fn materials(&self) -> MaterialLanes {
        let Self { stage, appearance, samples, .. } = self;
        let Samples { is_table, weld_share, dose, removed, .. } = samples;
        let mut materials = appearance.blends(weld_share, dose, removed);
        if !appearance.oxides.is_none() {
            (0..LANES).filter(|&i| samples.is_solid[i]).for_each(|i| materials.set(i, self.oxidised(i)));
        }
        if let Some(texture) = &appearance.texture {
            for i in 0..LANES {
                materials.set(i, self.textured(i, materials.blend(i), texture));
            }
        }
        if let Some(table) = stage.scene.table.filter(|_| any(is_table)) {
            for i in 0..LANES {
                let plain = Blend { material: table.material, ground: 0.0 };
                let blend = table.texture.map_or(plain, |texture| self.textured(i, plain, &texture));
                materials.set(i, if is_table[i] { blend } else { materials.blend(i) });
            }
            if let Some(pattern) = &table.pattern {
                (0..LANES).filter(|&i| is_table[i]).for_each(|i| materials.set(i, self.patterned(i, pattern)));
            }
        }
        let Scene { obstacles, tool, dust, .. } = stage.scene;
        if !obstacles.is_empty() || !tool.is_empty() || dust.is_some() {
            self.cover(&mut materials);
        }
        materials
    }

    /// Material of a lane with oxides on its bare metal.
    fn oxidised(&self, lane: usize) -> Blend {
        let Self { stage, appearance, samples, .. } = self;
        let (point, dose) = (samples.positions.get(lane), samples.dose[lane]);
        let cover = |bare: Blend| {
            let distance = stage.scene.field.fusion_line().distance(point);
            let is_weld = samples.weld[lane] > 0;
            let place = OxidePlace {
                point,
                distance: if is_weld { 0.0 } else { distance },
                cosine: samples.normals.get(lane).dot(samples.directions.get(lane)).abs(),
                dose,
            };
            appearance.oxides.over(bare, &place)
        };
        appearance.covered((samples.weld_share[lane], dose, samples.removed[lane]), cover)
    }

    /// Gives obstacles and the tool their materials, and lays dust over everything.
    #[inline(always)]
    fn cover(&self, materials: &mut MaterialLanes) {
        let Self { stage, samples, .. } = self;
        for i in 0..LANES {
            if let Some(material) = stage.scene.material_of(samples.obstacle[i]) {
                materials.set(i, Blend { material, ground: 0.0 });
            }
            if let Some(dust) = &stage.scene.dust {
                let facing_up = samples.normals.get(i).dot(stage.up.as_vec3());
                materials.set(i, dust.over(materials.blend(i), samples.positions.get(i), facing_up));
            }
        }
    }

    /// Material of a lane on a table with a pattern.
    fn patterned(&self, lane: usize, pattern: &TablePattern) -> Blend {
        let Self { stage, samples, .. } = self;
        let point = (stage.to_scene * samples.positions.get(lane)).truncate();
        Blend { material: pattern.material(point, self.footprint(lane)), ground: 0.0 }
    }

    /// Size of a lane's pixel on the surface [m].
    #[inline(always)]
    fn footprint(&self, lane: usize) -> f32 {
        let Self { stage, samples, .. } = self;
        let depth = f64::from(samples.depth[lane]);
        stage.camera.pixel_size_within(depth, stage.raster.height, stage.half_image) as f32
    }

    #[inline(always)]
    fn textured(&self, lane: usize, blend: Blend, texture: &Texture) -> Blend {
        Blend { material: texture.applied(blend.material, self.samples.positions.get(lane)), ..blend }
    }

    #[inline(always)]
    fn grooves(&self, normals: &Points) -> Grooves {
        let Self { appearance, samples, .. } = self;
        let mut footprints = [0.0; LANES];
        for i in 0..LANES {
            footprints[i] = self.footprint(i);
        }
        appearance.marks.grooves(&samples.positions, normals, &footprints)
    }

    /// Facets of a lane with its grinding marks.
    #[inline(always)]
    fn marked(&self, i: usize, plain: &Facets, ground: f32, grooves: &Grooves) -> Facets {
        let Self { appearance, samples, .. } = self;
        let (normal, along) = (plain.normal, grooves.along.get(i));
        let across = normal.cross(along);
        let tilted = (normal + across * (grooves.tilt[i] * ground)).normalize_or(normal);
        let tilted = facing(tilted, samples.directions.get(i));
        let anisotropy = appearance.marks.anisotropy * ground * grooves.share[i];
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
