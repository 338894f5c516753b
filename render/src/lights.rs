//! Light that falls on a scene: key lights with soft shadows, and an environment all around. Twin of `lights.wgsl`.

use glam::{DVec3, Vec3};

use super::shade::smooth_step;

/// A lamp far away.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyLight {
    /// Unit vector from the scene to the light.
    pub towards: DVec3,
    /// Irradiance on a surface that faces it, linear RGB; π lights a white surface to 1.
    pub irradiance: Vec3,
    /// Tangent of its half angle: the softness of its shadows and the width of its highlights.
    pub spread: f32,
}

/// Light from all around: a sky above, a floor below and a brighter horizon between, linear RGB radiances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Environment {
    /// From straight above.
    pub sky: Vec3,
    /// Added at the horizon.
    pub horizon: Vec3,
    /// From straight below.
    pub floor: Vec3,
}

/// All lights of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Lights {
    /// Lamps.
    pub keys: Vec<KeyLight>,
    /// The rest of the room.
    pub environment: Environment,
}

impl Default for Lights {
    /// A workshop: a large lamp from one side, a small one from the other, a bright ceiling.
    fn default() -> Self {
        let lamp = |towards: DVec3, irradiance: Vec3, spread: f32| KeyLight {
            towards: towards.normalize(),
            irradiance,
            spread,
        };
        Self {
            keys: vec![
                lamp(DVec3::new(-0.75, -0.55, 1.1), Vec3::new(2.5, 2.42, 2.3), 0.20),
                lamp(DVec3::new(0.9, -0.35, 0.75), Vec3::new(0.75, 0.82, 0.95), 0.12),
            ],
            environment: Environment {
                sky: Vec3::new(0.78, 0.80, 0.84),
                horizon: Vec3::new(0.34, 0.34, 0.33),
                floor: Vec3::new(0.15, 0.145, 0.14),
            },
        }
    }
}

impl Environment {
    /// Radiance from around a direction whose sine above the horizon is given.
    ///
    /// `roughness`: 0 for a mirror; rough surfaces see it blurred.
    #[inline(always)]
    pub(crate) fn radiance(&self, height: f32, roughness: f32) -> Vec3 {
        let blur = 0.12 + 0.88 * roughness;
        let above = smooth_step(-blur, blur, height);
        let away = (height.abs() / (0.35 + 0.65 * roughness)).min(1.0);
        let band = (1.0 - away) * (1.0 - away) * (1.0 - 0.5 * roughness);
        self.floor.lerp(self.sky, above) + self.horizon * band
    }
}
