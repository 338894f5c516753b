//! Photographs of a part in a scene, and the labels from comparing them.

use glam::{DVec3, Vec3};
use image::ImageError;
use render::label::{Colour, labels, seen_share};
use render::{
    Appearance, Environment, EnvironmentMap, Field, Frame, KeyLight, Lights, Marks, Material, Picture, Raster,
    Scene as Stage, Sensor, Surroundings, Table, VisibleObject,
};
use sdf_bake::BrickGrid;

use crate::clutter::{ObstacleDraw, cluttered};
use crate::clutter_mesh::ClutterMeshes;
use crate::jpeg::through_jpeg;
use crate::looks::{DustDraw, LookDraws, PanelDraw, TextureDraw};
use crate::oxide_draws::oxides;
use crate::scene::{MaterialDraw, Scene};
use crate::spatter::spattered;
use crate::table_draw::TableDraw;

/// Exponent for perceptually even steps of light, an approximation of sRGB.
const GAMMA: f32 = 2.2;
/// Weights of red, green and blue in luminance (ITU-R BT.709).
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

/// Contents of the files that scenes may use; none by default.
#[derive(Clone, Debug, Default)]
pub struct SceneFiles {
    /// Picture of the surroundings.
    pub environment: Option<EnvironmentMap>,
    /// Meshes among the clutter.
    pub meshes: ClutterMeshes,
}

/// An image with its labels.
pub struct Shot {
    /// Eight-bit sRGB.
    pub image: Picture,
    /// Labels from appearance.
    pub appearance: Vec<u8>,
    /// Labels from dose.
    pub dose: Vec<u8>,
    /// Share of the workpiece's pixels with a dose of 1 or more.
    pub exposed_share: f64,
    /// Signal of linear light 1 at the camera's exposure.
    pub exposure: f64,
}

/// Photographs a part with its dose; labels it by comparison with the same part unsanded and bare in the same scene.
/// `files`: the picture of a [`Scene::surrounded`] scene, and the meshes of [`Scene::with_meshes`].
///
/// # Errors
/// If the picture goes through JPEG and a side is longer than 65,535 pixels.
pub fn shoot(
    part: &BrickGrid,
    scene: &Scene,
    (width, height): (usize, usize),
    files: &SceneFiles,
) -> Result<Shot, ImageError> {
    let camera = scene.camera.camera();
    let whole = spattered(part, scene);
    let all = cluttered(&whole, scene, &files.meshes);
    let stage = stage(&all, scene, files.environment.as_ref());
    let raster = Raster { width, height, samples_per_side: 1 };
    // Also unsanded and bare.
    let (frame, in_others) = stage.photograph_exposed(&[0.0, 1.0], &camera, &raster);
    let exposure = exposure(&frame, scene.sensor.aim);
    let on_part = |pixel: usize| frame.seen[pixel] == VisibleObject::Part;
    let code = |colour: Vec3| -> Colour {
        let signal = (colour * exposure as f32).clamp(Vec3::ZERO, Vec3::ONE);
        signal.powf(1.0 / GAMMA).to_array()
    };
    let seen = |pixel: usize| {
        let [unsanded, bare] = in_others[pixel].map(code);
        seen_share(code(frame.colour[pixel]), unsanded, bare)
    };
    let gone = |pixel: usize| frame.dose[pixel].min(1.0);
    let pixels = (0..width * height).filter(|&pixel| on_part(pixel));
    let exposed = pixels.clone().filter(|&pixel| frame.dose[pixel] >= 1.0).count();
    Ok(Shot {
        image: picture(&frame, (scene, middle_depth(part, scene)), exposure)?,
        appearance: labels(width, height, |pixel| on_part(pixel).then(|| seen(pixel))),
        dose: labels(width, height, |pixel| on_part(pixel).then(|| Some(gone(pixel)))),
        exposed_share: exposed as f64 / pixels.count().max(1) as f64,
        exposure,
    })
}

/// Depth of the middle of a part's box from the camera [m].
fn middle_depth(part: &BrickGrid, scene: &Scene) -> f64 {
    let middle = part.surface_bounds().map_or(DVec3::ZERO, |(low, high)| low.midpoint(high));
    scene.camera.depth(scene.placement.to_scene(middle))
}

/// The picture as the camera stores it; `middle`: depth of the workpiece's middle [m].
fn picture(frame: &Frame, (scene, middle): (&Scene, f64), exposure: f64) -> Result<Picture, ImageError> {
    let mut frame = frame.clone();
    if let Some(optics) = &scene.looks.optics {
        optics.optics(frame.height, middle).apply(&mut frame);
    }
    sensor(scene, exposure).expose(&mut frame);
    let picture = frame.to_srgb8();
    match scene.looks.jpeg_quality {
        Some(quality) => through_jpeg(&picture, quality),
        None => Ok(picture),
    }
}

fn stage<'a>(part: &'a BrickGrid, scene: &Scene, map: Option<&'a EnvironmentMap>) -> Stage<'a> {
    let room = Lights::default().environment;
    let [sky, horizon, floor] = scene.environment.as_vec3().to_array();
    let environment = Environment { sky: room.sky * sky, horizon: room.horizon * horizon, floor: room.floor * floor };
    let keys = scene.lamps.iter().map(|lamp| KeyLight {
        towards: lamp.towards,
        irradiance: lamp.irradiance.as_vec3(),
        spread: lamp.spread as f32,
    });
    let panels = scene.looks.panels.iter().map(PanelDraw::panel);
    Stage {
        field: Field::new(part),
        placement: scene.placement.pose(),
        appearance: appearance(&scene.material, &scene.looks),
        obstacles: scene.obstacles.iter().map(ObstacleDraw::material).collect(),
        tool: scene.tool_bodies().iter().map(ObstacleDraw::material).collect(),
        dust: scene.looks.dust.as_ref().map(DustDraw::deposit),
        table: Some(table(scene)),
        lights: Lights { keys: keys.collect(), environment, panels: panels.collect() },
        surroundings: map.zip(scene.surroundings).map(|(map, draw)| Surroundings {
            map,
            turn: draw.turn,
            gain: draw.gain as f32,
        }),
        shutter: scene.camera.shutter(),
    }
}

fn table(scene: &Scene) -> Table {
    let material = Material {
        colour: scene.material.table.as_vec3(),
        roughness: scene.material.table_roughness as f32,
        metallic: 0.0,
    };
    let texture = scene.looks.table.map(TextureDraw::texture);
    let pattern = scene.looks.table_pattern.map(TableDraw::pattern);
    Table { height: scene.placement.table_m, material, texture, pattern }
}

fn appearance(material: &MaterialDraw, looks: &LookDraws) -> Appearance {
    let roughness = looks.clear_coat.unwrap_or(material.coating_roughness) as f32;
    let paint = |colour: DVec3| Material { colour: colour.as_vec3(), roughness, metallic: 0.0 };
    let ground =
        Material { colour: material.metal.as_vec3(), roughness: material.metal_roughness as f32, metallic: 1.0 };
    let marks = looks.swirl.map_or(Marks::default(), |swirl| Marks {
        width: swirl.width_m as f32,
        slope: swirl.slope as f32,
        anisotropy: swirl.anisotropy as f32,
        orbit: Some(swirl.orbit_m as f32),
        ..Marks::default()
    });
    Appearance {
        coating: Some(paint(material.coating)),
        ground,
        marks,
        primer: looks.primer.map(paint),
        texture: looks.part.map(TextureDraw::texture),
        oxides: oxides(looks.heat_tint.as_ref(), looks.rust.as_ref()),
        ..Appearance::default()
    }
}

/// Returns the exposure at which the mean luminance of the part is `aim`.
fn exposure(frame: &Frame, aim: f64) -> f64 {
    let lit = frame.colour.iter().zip(&frame.seen).filter(|(_, seen)| **seen == VisibleObject::Part);
    let (sum, count) =
        lit.fold((0.0, 0), |(sum, count), (colour, _)| (sum + f64::from(colour.dot(LUMINANCE)), count + 1));
    if sum > 0.0 { aim * f64::from(count) / sum } else { 1.0 }
}

fn sensor(scene: &Scene, exposure: f64) -> Sensor {
    Sensor {
        exposure: exposure as f32,
        blur: scene.sensor.blur as f32,
        full_well: scene.sensor.full_well as f32,
        read_noise: scene.sensor.read_noise as f32,
        seed: scene.sensor.seed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::corners;
    use crate::{Look, Seeds, Shape};
    use glam::IVec3;
    use render::label::{IGNORE, SANDED, UNSANDED, counts};

    #[test]
    fn half_a_panel_without_coating_is_labelled_as_half() {
        let mut part = Shape::Panel.field(1.5e-3);
        let bare_from = 0.01;
        let x = |place: usize, part: &BrickGrid| part.position(part.voxel_of(place)).x;
        part.dose = (0..part.phi.len()).map(|place| if x(place, &part) > bare_from { 1.5 } else { 0.0 }).collect();
        let draw = |placement: u64, looks: &[Look]| {
            Scene::draw(&part, &Seeds { placement, image: 4 }, (120, 90), looks).unwrap()
        };
        let from_above = (0..).find(|&placement| draw(placement, &[]).camera.axes[2].z < -0.93).unwrap();
        for looks in [&[][..], &Look::ALL] {
            let scene = draw(from_above, looks);
            let shot = shoot(&part, &scene, (120, 90), &SceneFiles::default()).unwrap();
            // Seen from above, the visible share equals the share of the upper side.
            let share = (0.075 - bare_from) / 0.15;
            assert!((shot.exposed_share - share).abs() < 0.08, "{}", shot.exposed_share);
            let [background, sanded, unsanded, ignored] = counts(&shot.dose);
            assert_eq!(background + sanded + unsanded + ignored, 120 * 90);
            assert!(sanded > 500 && unsanded > 500 && ignored < sanded, "{:?}", counts(&shot.dose));
            let opposite = |(a, b): (&u8, &u8)| (*a == SANDED && *b == UNSANDED) || (*a == UNSANDED && *b == SANDED);
            let pairs = || shot.appearance.iter().zip(&shot.dose);
            assert_eq!(pairs().filter(|pair| opposite(*pair)).count(), 0);
            assert!(pairs().all(|(a, b)| (*a == 0) == (*b == 0) || *a == IGNORE || *b == IGNORE));
        }
    }

    #[test]
    fn a_part_far_from_its_origin_is_in_focus() {
        let mut part = Shape::Lap.field(2e-3);
        let shift = IVec3::new(40, -25, 60);
        part.origin += shift;
        part.bricks.iter_mut().for_each(|brick| *brick += shift);
        let scene = Scene::draw(&part, &Seeds { placement: 1, image: 1 }, (64, 48), &[]).unwrap();
        let depths = corners(&part).unwrap().map(|corner| scene.camera.depth(scene.placement.to_scene(corner)));
        let (least, greatest) = depths.iter().fold((f64::INFINITY, 0f64), |(l, g), &d| (l.min(d), g.max(d)));
        let middle = middle_depth(&part, &scene);
        assert!(least < middle && middle < greatest, "{middle} of {least} to {greatest}");
        // The origin, on which the camera focused before, lies far outside.
        let origin = scene.camera.depth(scene.placement.translation_m);
        assert!(!(least..greatest).contains(&origin), "{origin}");
    }

    #[test]
    fn every_look_changes_the_picture_and_none_the_labels_by_dose() {
        let mut part = Shape::Hood.field(1.5e-3);
        let y = |place: usize, part: &BrickGrid| part.position(part.voxel_of(place)).y;
        part.dose = (0..part.phi.len()).map(|place| (0.5 + 40.0 * y(place, &part) as f32).max(0.0)).collect();
        let draw = |seed: u64, looks: &[Look]| {
            Scene::draw(&part, &Seeds { placement: seed, image: seed }, (96, 72), looks).unwrap()
        };
        // Some looks are drawn in a share of the images only.
        let has_all = |seed: &u64| {
            let Scene { obstacles, spatter, looks, camera, tool, .. } = draw(*seed, &Look::ALL);
            let bodies = tool.is_some() && looks.table_pattern.is_some() && obstacles.len() > 2 && spatter.len() > 5;
            let oxides = looks.heat_tint.is_some() && looks.rust.is_some();
            let layers = looks.primer.is_some() && looks.clear_coat.is_some() && looks.dust.is_some();
            bodies && layers && oxides && camera.rolling_shutter.is_some()
        };
        let seed = (0..).find(has_all).unwrap();
        let taken = |looks: &[Look]| shoot(&part, &draw(seed, looks), (96, 72), &SceneFiles::default()).unwrap();
        let plain = taken(&[]);
        let reshapes = |look: Look| matches!(look, Look::Clutter | Look::Spatter | Look::Optics | Look::Tool);
        for look in Look::ALL {
            let shot = taken(&[look]);
            assert_ne!(shot.image, plain.image, "{}", look.name());
            // Only what hides the workpiece may change its labels.
            let kept = shot.dose.iter().zip(&plain.dose).filter(|(now, then)| now == then).count();
            assert!(kept == plain.dose.len() || reshapes(look) && kept > plain.dose.len() / 2, "{}", look.name());
        }
    }
}
