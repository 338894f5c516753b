//! Properties of a tile's surfaces that do not depend on the share of exposed metal.

use super::gbuffer_lanes::Samples;
use super::lanes::{LANES, Lanes, Points, any};
use super::material::{Blend, MaterialLanes};
use super::oxides::OxidePlace;
use super::scene::Stage;
use super::shade::facing;
use super::table_pattern::TablePattern;

/// Finish of a tile's samples, found once for all shares of exposed metal.
pub(crate) struct TileFinish {
    /// Unit normals that face the camera.
    pub(crate) normals: Points,
    /// Metal below the coating, with its oxides.
    bare: MaterialLanes,
    /// Noise of the part's texture, −1 to 1.
    texture: Lanes,
    /// Materials of table, obstacles and tool.
    others: MaterialLanes,
    is_other: [bool; LANES],
    /// Share of dust.
    dust: Lanes,
}

// All functions are inlined into the call of `ShadeLanes`, so that they are compiled for its instruction set.

impl TileFinish {
    /// `all_bare`: the metal is needed at every sample, not only where the dose exposes some.
    #[inline(always)]
    pub(crate) fn of(stage: &Stage, samples: &Samples, all_bare: bool) -> Self {
        let appearance = &stage.scene.appearance;
        let mut normals = Points::ZERO;
        for i in 0..LANES {
            normals.set(i, facing(samples.normals.get(i), samples.directions.get(i)));
        }
        let mut texture = [0.0; LANES];
        if let Some(of_part) = &appearance.texture {
            for i in 0..LANES {
                texture[i] = of_part.value(samples.positions.get(i));
            }
        }
        let mut dust = [0.0; LANES];
        if let Some(layer) = &stage.scene.dust {
            let up = stage.up.as_vec3();
            for i in 0..LANES {
                dust[i] = layer.share_on(samples.positions.get(i), samples.normals.get(i).dot(up));
            }
        }
        let (others, is_other) = others(stage, samples);
        Self { normals, bare: bare(stage, samples, all_bare), texture, others, is_other, dust }
    }

    /// Materials with these shares of exposed metal, 0 to 1.
    #[inline(always)]
    pub(crate) fn materials(&self, stage: &Stage, samples: &Samples, exposed: &Lanes) -> MaterialLanes {
        let appearance = &stage.scene.appearance;
        let mut materials = appearance.blends(&self.bare, exposed, &samples.removed);
        if let Some(texture) = &appearance.texture {
            for i in 0..LANES {
                let Blend { material, ground } = materials.blend(i);
                materials.set(i, Blend { material: texture.applied(material, self.texture[i]), ground });
            }
        }
        if any(&self.is_other) {
            for i in 0..LANES {
                materials.set(i, if self.is_other[i] { self.others.blend(i) } else { materials.blend(i) });
            }
        }
        if let Some(layer) = &stage.scene.dust {
            for i in 0..LANES {
                materials.set(i, layer.laid(materials.blend(i), self.dust[i]));
            }
        }
        materials
    }
}

/// Metal below the coating; where it can be seen, with its oxides.
#[inline(always)]
fn bare(stage: &Stage, samples: &Samples, all: bool) -> MaterialLanes {
    let appearance = &stage.scene.appearance;
    let mut bare = appearance.bare(&samples.weld_share, &samples.removed);
    if appearance.oxides.is_none() {
        return bare;
    }
    for i in (0..LANES).filter(|&i| samples.is_solid[i] && (all || appearance.shows_metal(samples.dose[i]))) {
        bare.set(i, appearance.oxides.over(bare.blend(i), &oxide_place(stage, samples, i)));
    }
    bare
}

#[inline(always)]
fn oxide_place(stage: &Stage, samples: &Samples, lane: usize) -> OxidePlace {
    let point = samples.positions.get(lane);
    let is_weld = samples.weld[lane] > 0;
    OxidePlace {
        point,
        distance: if is_weld { 0.0 } else { stage.scene.field.fusion_line().distance(point) },
        cosine: samples.normals.get(lane).dot(samples.directions.get(lane)).abs(),
        dose: samples.dose[lane],
    }
}

/// Materials of table, obstacles and tool, and the samples on them.
#[inline(always)]
fn others(stage: &Stage, samples: &Samples) -> (MaterialLanes, [bool; LANES]) {
    let (mut others, mut is_other) = (MaterialLanes::NONE, samples.is_table);
    if let Some(table) = stage.scene.table.filter(|_| any(&samples.is_table)) {
        let plain = |material| Blend { material, ground: 0.0 };
        for i in 0..LANES {
            others.set(i, plain(table.material));
        }
        if let Some(texture) = &table.texture {
            for i in 0..LANES {
                let value = texture.value(samples.positions.get(i));
                others.set(i, plain(texture.applied(table.material, value)));
            }
        }
        if let Some(pattern) = &table.pattern {
            for i in (0..LANES).filter(|&i| samples.is_table[i]) {
                others.set(i, patterned(stage, samples, (i, pattern)));
            }
        }
    }
    if !stage.scene.obstacles.is_empty() || !stage.scene.tool.is_empty() {
        for i in 0..LANES {
            if let Some(material) = stage.scene.material_of(samples.obstacle[i]) {
                others.set(i, Blend { material, ground: 0.0 });
                is_other[i] = true;
            }
        }
    }
    (others, is_other)
}

/// Material of a lane on a table with a pattern.
#[inline(always)]
fn patterned(stage: &Stage, samples: &Samples, (lane, pattern): (usize, &TablePattern)) -> Blend {
    let point = (stage.to_scene * samples.positions.get(lane)).truncate();
    Blend { material: pattern.material(point, stage.footprint(samples.depth[lane])), ground: 0.0 }
}
