//! Photographs of a part in a scene, and the labels from comparing them.

use glam::Vec3;
use render::{
    Appearance, Camera, Distortion, Environment, Field, Frame, KeyLight, Lights, Material, Picture, Placement,
    Projection, Raster, Scene as Stage, Sensor, Table, VisibleObject,
};
use sdf_bake::BrickGrid;

use super::scene::{MaterialDraw, Scene};
use render::label::{Colour, labels, seen_share};

/// Exponent for perceptually even steps of light, an approximation of sRGB.
const GAMMA: f32 = 2.2;
/// Weights of red, green and blue in luminance (ITU-R BT.709).
const LUMINANCE: Vec3 = Vec3::new(0.2126, 0.7152, 0.0722);

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

/// Coating on a photographed part.
#[derive(Clone, Copy)]
enum CoatingState {
    /// Coating left by the dose.
    AsDosed,
    /// Full coating.
    Whole,
    /// No coating.
    Gone,
}

/// Photographs a part with its dose; labels it by comparison with the same part unsanded and bare in the same scene.
pub fn shoot(part: &BrickGrid, scene: &Scene, (width, height): (usize, usize)) -> Shot {
    let camera = camera(scene);
    let stage = stage(part, scene);
    let others = [CoatingState::Whole, CoatingState::Gone].map(|coat| appearance(&scene.material, coat));
    let raster = Raster { width, height, samples_per_side: 1 };
    let (frame, in_others) = stage.photograph_as(&others, &camera, &raster);
    let exposure = exposure(&frame, scene.sensor.aim);
    let mut image = frame.clone();
    sensor(scene, exposure).expose(&mut image);
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
    Shot {
        image: image.to_srgb8(),
        appearance: labels(width, height, |pixel| on_part(pixel).then(|| seen(pixel))),
        dose: labels(width, height, |pixel| on_part(pixel).then(|| Some(gone(pixel)))),
        exposed_share: exposed as f64 / pixels.count().max(1) as f64,
        exposure,
    }
}

/// Returns the camera of the scene.
fn camera(scene: &Scene) -> Camera {
    let [right, up, forward] = scene.camera.axes;
    let [k1, k2] = scene.camera.distortion;
    Camera {
        eye: scene.camera.eye_m,
        right,
        up,
        forward,
        projection: Projection::Perspective { vertical_field_of_view: scene.camera.vertical_field_of_view },
        distortion: Distortion { radial: [k1, k2, 0.0], tangential: [0.0; 2] },
    }
}

fn stage<'a>(part: &'a BrickGrid, scene: &Scene) -> Stage<'a> {
    let room = Lights::default().environment;
    let dimmed = |light: Vec3| light * scene.environment as f32;
    let environment = Environment { sky: dimmed(room.sky), horizon: dimmed(room.horizon), floor: dimmed(room.floor) };
    let keys = scene.lamps.iter().map(|lamp| KeyLight {
        towards: lamp.towards,
        irradiance: lamp.irradiance.as_vec3(),
        spread: lamp.spread as f32,
    });
    Stage {
        field: Field::new(part),
        placement: Placement { rotation: scene.placement.rotation, translation: scene.placement.translation_m },
        appearance: appearance(&scene.material, CoatingState::AsDosed),
        table: Some(table(scene)),
        lights: Lights { keys: keys.collect(), environment },
    }
}

fn table(scene: &Scene) -> Table {
    let material = Material {
        colour: scene.material.table.as_vec3(),
        roughness: scene.material.table_roughness as f32,
        metallic: 0.0,
    };
    Table { height: scene.placement.table_m, material }
}

fn appearance(material: &MaterialDraw, coat: CoatingState) -> Appearance {
    let paint =
        Material { colour: material.coating.as_vec3(), roughness: material.coating_roughness as f32, metallic: 0.0 };
    let metal =
        Material { colour: material.metal.as_vec3(), roughness: material.metal_roughness as f32, metallic: 1.0 };
    let (coating, ground) = match coat {
        CoatingState::AsDosed => (paint, metal),
        CoatingState::Whole => (paint, paint),
        CoatingState::Gone => (metal, metal),
    };
    Appearance { coating: Some(coating), ground, ..Appearance::default() }
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
    use crate::images::plan::Treatment;
    use crate::images::workpiece::Coated;
    use crate::images::{IMAGES_FORMAT, ImageRecipe};
    use paths::Pattern;
    use render::label::{IGNORE, SANDED, UNSANDED, counts};

    #[test]
    fn half_a_panel_without_coating_is_labelled_as_half() {
        let panel = Coated::named("panel", 1.5).unwrap();
        let mut part = panel.field(1).unwrap();
        let bare_from = 0.01;
        let x = |place: usize, part: &BrickGrid| part.position(part.voxel_of(place)).x;
        part.dose = (0..part.phi.len()).map(|place| if x(place, &part) > bare_from { 1.5 } else { 0.0 }).collect();
        let recipe = ImageRecipe {
            format: IMAGES_FORMAT.to_owned(),
            version: String::new(),
            seed: 3,
            workpieces: vec![panel],
            placements: 1,
            patterns: vec![Pattern::Spiral],
            stages: 1,
            size: (120, 90),
            voxel_mm: 1.5,
        };
        let planned = &recipe.images()[1];
        assert!(matches!(planned.treatment, Treatment::Stage { .. }));
        let scene = Scene::draw(&part, &recipe, planned).unwrap();
        let shot = shoot(&part, &scene, recipe.size);
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
