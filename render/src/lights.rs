//! Lights of a scene: key lights with soft shadows, and an environment all around. Twin of `lights.wgsl`.

use glam::{DVec3, Vec3};

use super::shade::smooth_step;

/// A distant lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyLight {
    /// Unit vector from the scene towards the light.
    pub towards: DVec3,
    /// Irradiance on a surface that faces it, linear RGB; with π a white surface has radiance 1.
    pub irradiance: Vec3,
    /// Tangent of its half angle; sets the softness of shadows and the width of highlights.
    pub spread: f32,
}

/// Ambient light: a sky above, a floor below and a brighter horizon between, linear RGB radiances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Environment {
    /// Radiance from straight above.
    pub sky: Vec3,
    /// Radiance added at the horizon.
    pub horizon: Vec3,
    /// Radiance from straight below.
    pub floor: Vec3,
}

/// All lights of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Lights {
    /// Lamps.
    pub keys: Vec<KeyLight>,
    /// Ambient light.
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
    /// Radiance from a direction, given by its sine above the horizon.
    ///
    /// `roughness`: 0 for a mirror; on rough surfaces the environment is blurred.
    #[inline(always)]
    pub(crate) fn radiance(&self, height: f32, roughness: f32) -> Vec3 {
        let blur = 0.12 + 0.88 * roughness;
        let above = smooth_step(-blur, blur, height);
        let away = (height.abs() / (0.35 + 0.65 * roughness)).min(1.0);
        let band = (1.0 - away) * (1.0 - away) * (1.0 - 0.5 * roughness);
        self.floor.lerp(self.sky, above) + self.horizon * band
    }
}
