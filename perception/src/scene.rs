//! Scene of an image, drawn at random: placement, camera, light, materials, sensor.

use glam::{DQuat, DVec2, DVec3};
use random::Stream;
use render::{Camera, Distortion, Placement, Projection, RollingShutter, outward};
use sdf_bake::BrickGrid;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::clutter::ObstacleDraw;
use crate::environment::EnvironmentDraw;
use crate::look::Look;
use crate::looks::LookDraws;
use crate::shutter::ShutterDraw;
use crate::spatter::DropletDraw;
use crate::tool::ToolDraw;

/// The field is entirely inside or entirely outside.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
#[error("the field holds no surface")]
pub struct NoSurface;

/// Seeds of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seeds {
    /// Of placement and camera, shared by all images of a placement.
    pub placement: u64,
    /// Of everything else.
    pub image: u64,
}

/// Scene of an image, apart from the state of the coating. Its frame has z up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// Transform from the part's frame to the scene's.
    pub placement: PlacementDraw,
    /// Camera, the same for all images of a placement.
    pub camera: CameraDraw,
    /// Things around the workpiece, the same for all images of a placement.
    pub obstacles: Vec<ObstacleDraw>,
    /// Droplets of weld metal on the workpiece, the same for all images of a placement.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub spatter: Vec<DropletDraw>,
    /// Tool over or on the workpiece, the same for all images of a placement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tool: Option<ToolDraw>,
    /// Lamps, the brightest first.
    pub lamps: Vec<LampDraw>,
    /// Ambient light from sky, horizon and floor, relative to a bright workshop. Bare metal mirrors it, so metal is
    /// darker than paint under a bright lamp in dark surroundings.
    pub environment: DVec3,
    /// Picture of the surroundings in place of ambient light and panels, if the set has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surroundings: Option<EnvironmentDraw>,
    /// Materials of the coating, the metal below, and the table.
    pub material: MaterialDraw,
    /// Exposure, blur and noise of the sensor.
    pub sensor: SensorDraw,
    /// Looks.
    pub looks: LookDraws,
}

/// Placement of a workpiece.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlacementDraw {
    /// Rotation about the origin of the part's frame, as a unit quaternion x, y, z, w.
    pub rotation: DQuat,
    /// Translation after the rotation [m].
    pub translation_m: DVec3,
    /// Height of the table's top, which the workpiece touches [m].
    pub table_m: f64,
}

/// Pinhole camera with lens distortion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CameraDraw {
    /// Centre of projection [m].
    pub eye_m: DVec3,
    /// Unit vectors to the right of the image, to its top, and into the scene.
    pub axes: [DVec3; 3],
    /// Angle between the lower and the upper edge of the image [rad].
    pub vertical_field_of_view: f64,
    /// Coefficients k₁ and k₂ of r² and r⁴ on the image plane at unit distance (Brown 1966).
    pub distortion: [f64; 2],
    /// Motion while the rows are exposed, part of the look `optics`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rolling_shutter: Option<ShutterDraw>,
}

/// A distant lamp.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LampDraw {
    /// Unit vector from the scene to the lamp.
    pub towards: DVec3,
    /// Irradiance on a surface that faces it, linear RGB; π lights a white surface to 1.
    pub irradiance: DVec3,
    /// Tangent of its angular radius.
    pub spread: f64,
}

/// Materials, linear RGB.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MaterialDraw {
    /// Albedo of the coating.
    pub coating: DVec3,
    /// Roughness of the coating, 0 to 1.
    pub coating_roughness: f64,
    /// Reflectance of the sanded metal.
    pub metal: DVec3,
    /// Roughness of the sanded metal, 0 to 1.
    pub metal_roughness: f64,
    /// Albedo of the table.
    pub table: DVec3,
    /// Roughness of the table, 0 to 1.
    pub table_roughness: f64,
}

/// Exposure, blur and noise of the sensor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SensorDraw {
    /// Target of the exposure: mean signal of the workpiece, 0 to 1.
    pub aim: f64,
    /// Signal of linear light 1 at this exposure.
    pub exposure: f64,
    /// Standard deviation of the blur [pixels].
    pub blur: f64,
    /// Electrons of a saturated pixel.
    pub full_well: f64,
    /// Standard deviation of the read-out [electrons].
    pub read_noise: f64,
    /// Seed of the noise.
    pub seed: u64,
}

impl Scene {
    /// Draws a scene with some looks for an image of `size` pixels: placement and camera from the seed of the placement,
    /// the rest from that of the image.
    ///
    /// # Errors
    /// If the field has no surface.
    pub fn draw(part: &BrickGrid, seeds: &Seeds, size: (usize, usize), looks: &[Look]) -> Result<Self, NoSurface> {
        let corners = corners(part)?;
        let placement = PlacementDraw::draw(&corners, &mut Stream::of(seeds.placement, "placement"));
        let corners = corners.map(|corner| placement.to_scene(corner));
        let aspect = size.0 as f64 / size.1 as f64;
        let mut camera = CameraDraw::draw(&corners, aspect, &mut Stream::of(seeds.placement, "camera"));
        if looks.contains(&Look::Optics) {
            let depth = camera.depth(corners.iter().sum::<DVec3>() / corners.len() as f64);
            let slope = (0.5 * camera.vertical_field_of_view).tan();
            camera.rolling_shutter =
                ShutterDraw::draw(slope, depth, &mut Stream::of(seeds.placement, "rolling shutter"));
        }
        let mut light = Stream::of(seeds.image, "light");
        let of_placement = |look: Look| looks.contains(&look).then(|| Stream::of(seeds.placement, look.name()));
        let obstacles = of_placement(Look::Clutter)
            .map(|mut stream| ObstacleDraw::draw(part, (&placement, &camera), &mut stream))
            .transpose()?;
        let spatter = of_placement(Look::Spatter).map(|mut stream| DropletDraw::draw(part, &mut stream));
        let tool = of_placement(Look::Tool)
            .map(|mut stream| ToolDraw::draw(part, (&placement, &camera), &mut stream))
            .transpose()?;
        Ok(Self {
            placement,
            camera,
            obstacles: obstacles.unwrap_or_default(),
            spatter: spatter.unwrap_or_default(),
            tool: tool.flatten(),
            lamps: lamps(&mut light),
            environment: DVec3::from_array(std::array::from_fn(|_| light.ratio_between([0.06, 1.3]))),
            surroundings: None,
            material: MaterialDraw::draw(&mut Stream::of(seeds.image, "material")),
            sensor: SensorDraw::draw(&mut Stream::of(seeds.image, "sensor"), seeds.image),
            looks: LookDraws::draw(looks, seeds.image),
        })
    }

    /// The same scene in the light of a picture, turned and as bright as drawn from the seed of the image.
    #[must_use]
    pub fn surrounded(mut self, seeds: &Seeds) -> Self {
        self.surroundings = Some(EnvironmentDraw::draw(self.environment, seeds.image));
        self.looks.panels.clear();
        self
    }
}

/// Corners of the box of a part's surface [m].
pub(crate) fn corners(part: &BrickGrid) -> Result<[DVec3; 8], NoSurface> {
    let (low, high) = part.surface_bounds().ok_or(NoSurface)?;
    Ok(std::array::from_fn(|i| {
        let pick = |axis: usize| if i >> axis & 1 == 1 { high[axis] } else { low[axis] };
        DVec3::new(pick(0), pick(1), pick(2))
    }))
}

impl PlacementDraw {
    /// Draws a rotation by any angle about z, a small tilt, and a translation; the table lies below all corners [m].
    fn draw(corners: &[DVec3; 8], stream: &mut Stream) -> Self {
        let turn = DQuat::from_rotation_z(stream.between([0.0, std::f64::consts::TAU]));
        let about = stream.between([0.0, std::f64::consts::TAU]);
        let axis = DVec3::new(about.cos(), about.sin(), 0.0);
        let tilt = DQuat::from_axis_angle(axis, stream.between([0.0, 0.12]));
        let translation_m = DVec3::new(stream.between([-0.05, 0.05]), stream.between([-0.05, 0.05]), 0.0);
        let placed = Self { rotation: tilt * turn, translation_m, table_m: 0.0 };
        let lowest = corners.iter().map(|&corner| placed.to_scene(corner).z).fold(f64::INFINITY, f64::min);
        Self { table_m: lowest, ..placed }
    }

    /// The pose for the renderer.
    pub(crate) fn pose(&self) -> Placement {
        Placement { rotation: self.rotation, translation: self.translation_m }
    }

    pub(crate) fn to_scene(self, point: DVec3) -> DVec3 {
        self.pose().to_scene(point)
    }
}

impl CameraDraw {
    /// Returns the camera.
    pub fn camera(&self) -> Camera {
        let [right, up, forward] = self.axes;
        let [k1, k2] = self.distortion;
        Camera {
            eye: self.eye_m,
            right,
            up,
            forward,
            projection: Projection::Perspective { vertical_field_of_view: self.vertical_field_of_view },
            distortion: Distortion { radial: [k1, k2, 0.0], tangential: [0.0; 2] },
        }
    }

    /// Its rolling shutter for the renderer.
    pub(crate) fn shutter(&self) -> Option<RollingShutter> {
        self.rolling_shutter.map(|draw| draw.shutter(self.axes))
    }

    /// Distance of a point [m] along the camera's axis [m].
    pub(crate) fn depth(&self, point: DVec3) -> f64 {
        (point - self.eye_m).dot(self.axes[2])
    }

    /// Draws a camera that looks down on the corners of a box [m] and shows all of them, at a random distance.
    fn draw(corners: &[DVec3; 8], aspect: f64, stream: &mut Stream) -> Self {
        let vertical_field_of_view = stream.between([0.3, 0.75]);
        let direction = outward(stream.between([0.0, std::f64::consts::TAU]), stream.between([0.66, 1.31]));
        let fill = stream.between([0.72, 0.98]);
        let centre = corners.iter().sum::<DVec3>() / corners.len() as f64;
        let level = Camera::look_at(centre + direction, centre, Projection::Orthographic { height: 1.0 });
        let (sine, cosine) = stream.between([-0.09, 0.09]).sin_cos();
        let right = level.right * cosine + level.up * sine;
        let up = level.up * cosine - level.right * sine;
        let slope = (0.5 * vertical_field_of_view).tan() * DVec2::new(aspect, 1.0);
        // A corner (u, v) at height w above the centre is visible from a distance d if |u| ≤ slope (d − w), and
        // likewise for v.
        let least = |corner: &DVec3| {
            let away = *corner - centre;
            let across = DVec2::new(away.dot(right), away.dot(up)).abs() / (slope * fill);
            across.max_element() + away.dot(direction)
        };
        let distance = corners.iter().map(least).fold(0.0, f64::max);
        // The remaining margin is distributed at random.
        let room = (1.0 - fill) * distance * slope;
        let shift = right * stream.between([-0.5, 0.5]) * room.x + up * stream.between([-0.5, 0.5]) * room.y;
        let eye_m = centre + shift + direction * distance;
        let distortion = [stream.between([-0.35, 0.05]), stream.between([0.0, 0.1])];
        Self { eye_m, axes: [right, up, -direction], vertical_field_of_view, distortion, rolling_shutter: None }
    }
}

/// Draws one or two lamps from above, the second weaker than the first.
fn lamps(stream: &mut Stream) -> Vec<LampDraw> {
    let count = 1 + stream.below(2);
    let mut power = std::f64::consts::PI * stream.between([0.5, 1.1]);
    let lamp = |_| {
        let towards = outward(stream.between([0.0, std::f64::consts::TAU]), stream.between([0.45, 1.4]));
        // From the yellow of a light bulb to the blue of a clear sky.
        let warmth = stream.between([-0.2, 0.25]);
        let irradiance = power * DVec3::new(1.0 + warmth, 1.0, 1.0 - warmth);
        power *= stream.between([0.15, 0.6]);
        LampDraw { towards, irradiance, spread: stream.between([0.05, 0.3]) }
    };
    (0..count).map(lamp).collect()
}

impl MaterialDraw {
    /// Draws a coating of any hue, saturation and brightness, and the sanded steel below.
    fn draw(stream: &mut Stream) -> Self {
        let hue = stream.between([0.0, 6.0]);
        let strength = stream.between([0.0, 0.9]);
        let value = stream.ratio_between([0.06, 0.7]);
        let grey = stream.between([0.35, 0.68]);
        let tint = stream.between([-0.03, 0.03]);
        let table = stream.ratio_between([0.03, 0.6]);
        let wooden = stream.between([0.0, 0.5]);
        Self {
            coating: paint(hue, strength, value),
            coating_roughness: stream.between([0.25, 0.75]),
            metal: DVec3::new(grey + tint, grey, grey - tint),
            metal_roughness: stream.between([0.2, 0.5]),
            table: table * DVec3::new(1.0, 1.0 - 0.3 * wooden, 1.0 - 0.6 * wooden),
            table_roughness: stream.between([0.4, 0.9]),
        }
    }
}

/// Returns a colour of hue 0 to 6 on the circle of red, yellow, green, cyan, blue and magenta (Smith 1978).
fn paint(hue: f64, strength: f64, value: f64) -> DVec3 {
    let channel = |offset: f64| {
        let place = (hue + offset).rem_euclid(6.0);
        value * (1.0 - strength * place.min(4.0 - place).clamp(0.0, 1.0))
    };
    DVec3::new(channel(5.0), channel(3.0), channel(1.0))
}

impl SensorDraw {
    fn draw(stream: &mut Stream, seed: u64) -> Self {
        Self {
            aim: stream.between([0.14, 0.34]),
            exposure: 1.0,
            blur: stream.between([0.4, 0.9]),
            full_well: stream.ratio_between([3e3, 4e4]),
            read_noise: stream.between([2.0, 12.0]),
            seed,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drawn_camera_shows_the_whole_box() {
        let corners: [DVec3; 8] =
            std::array::from_fn(|i| DVec3::new([-0.08, 0.08][i & 1], [-0.045, 0.045][i >> 1 & 1], [0.0, 0.06][i >> 2]));
        for seed in 0..200 {
            let placement = PlacementDraw::draw(&corners, &mut Stream::of(seed, "placement"));
            let placed = corners.map(|corner| placement.to_scene(corner));
            assert!(placed.iter().all(|corner| corner.z >= placement.table_m));
            let camera = CameraDraw::draw(&placed, 4.0 / 3.0, &mut Stream::of(seed, "camera"));
            let slope = (0.5 * camera.vertical_field_of_view).tan();
            let [right, up, forward] = camera.axes;
            assert!((right.cross(up) + forward).length() < 1e-12 && camera.eye_m.z > placement.table_m);
            let mut widest = 0f64;
            for corner in placed.map(|corner| corner - camera.eye_m) {
                let across =
                    DVec2::new(corner.dot(right) / (4.0 / 3.0), corner.dot(up)) / (corner.dot(forward) * slope);
                widest = widest.max(across.abs().max_element());
            }
            assert!(widest < 1.0 && widest > 0.55, "{widest} for seed {seed}");
        }
    }

    #[test]
    fn paints_have_their_hues() {
        assert_eq!(paint(0.0, 1.0, 0.5), DVec3::new(0.5, 0.0, 0.0));
        assert_eq!(paint(2.0, 1.0, 0.5), DVec3::new(0.0, 0.5, 0.0));
        assert_eq!(paint(4.0, 1.0, 0.5), DVec3::new(0.0, 0.0, 0.5));
        assert_eq!(paint(1.0, 0.5, 0.4), DVec3::new(0.4, 0.4, 0.2));
    }
}
