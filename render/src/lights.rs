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

/// A distant luminous rectangle without shadow, such as a softbox or a window: a part of the surroundings that glossy
/// surfaces mirror. On the CPU only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightPanel {
    /// Unit vector from the scene to its middle.
    pub towards: DVec3,
    /// Unit vector along its first side, perpendicular to `towards`.
    pub across: DVec3,
    /// Tangents of its half angles along and across the first side.
    pub half: [f32; 2],
    /// Radiance, linear RGB.
    pub radiance: Vec3,
}

/// All lights of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Lights {
    /// Lamps.
    pub keys: Vec<KeyLight>,
    /// Ambient light.
    pub environment: Environment,
    /// Luminous rectangles.
    pub panels: Vec<LightPanel>,
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
            panels: Vec::new(),
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

/// A [`LightPanel`] in the part's frame.
pub(crate) struct Panel {
    pub(crate) towards: Vec3,
    pub(crate) across: Vec3,
    pub(crate) half: [f32; 2],
    pub(crate) radiance: Vec3,
}

impl Panel {
    /// Radiance from a unit direction, blurred by the roughness of the mirror.
    #[inline(always)]
    pub(crate) fn radiance(&self, direction: Vec3, roughness: f32) -> Vec3 {
        let ahead = direction.dot(self.towards).max(1e-3);
        let at = [direction.dot(self.across), direction.dot(self.towards.cross(self.across))].map(|side| side / ahead);
        let blur = 0.03 + 1.2 * roughness * roughness;
        let covered = |i: usize| {
            let edge = |place: f32| smooth_step(-blur, blur, place);
            edge(at[i] + self.half[i]) - edge(at[i] - self.half[i])
        };
        let ahead = smooth_step(0.0, 0.2, direction.dot(self.towards));
        self.radiance * (covered(0) * covered(1) * ahead)
    }

    /// Irradiance over π on a surface with this unit normal, as if the panel were a small disc in its middle.
    #[inline(always)]
    pub(crate) fn radiosity(&self, normal: Vec3) -> Vec3 {
        let [a, b] = self.half;
        // Solid angle of a rectangle seen from its axis.
        let solid_angle = 4.0 * (a * b / ((1.0 + a * a) * (1.0 + b * b)).sqrt()).asin();
        self.radiance * (solid_angle * normal.dot(self.towards).max(0.0) / std::f32::consts::PI)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn panel(half: [f32; 2]) -> Panel {
        Panel { towards: Vec3::Z, across: Vec3::X, half, radiance: Vec3::ONE }
    }

    #[test]
    fn a_mirror_shows_a_panel_within_its_sides_and_a_rough_surface_spreads_its_light() {
        let at = |x: f32, y: f32| Vec3::new(x, y, 1.0).normalize();
        let seen = |direction: Vec3, roughness: f32| panel([0.5, 0.2]).radiance(direction, roughness).x;
        assert_eq!([seen(at(0.0, 0.0), 0.0), seen(at(0.4, 0.1), 0.0)], [1.0, 1.0]);
        assert_eq!([seen(at(0.6, 0.0), 0.0), seen(at(0.0, 0.3), 0.0), seen(Vec3::NEG_Z, 0.0)], [0.0; 3]);
        assert!(seen(at(0.0, 0.0), 0.7) < 0.9 && seen(at(0.6, 0.0), 0.7) > 0.1);
    }

    #[test]
    fn the_radiosity_is_that_of_the_radiance_over_the_hemisphere() {
        // Midpoint rule over the rectangle at unit distance: cos θ / r² dA cos θ' with both cosines 1 / r.
        let half = [0.2f32, 0.3];
        let count = 200;
        let at = |i: usize, half: f32| (2.0 * (i as f32 + 0.5) / count as f32 - 1.0) * half;
        let sum: f32 = (0..count * count)
            .map(|i| 1.0 / (1.0 + at(i % count, half[0]).powi(2) + at(i / count, half[1]).powi(2)).powi(2))
            .sum();
        let exact = sum * 4.0 * half[0] * half[1] / (count * count) as f32 / std::f32::consts::PI;
        let found = panel(half).radiosity(Vec3::Z).x;
        assert!((found / exact - 1.0).abs() < 0.04, "{found} and {exact}");
        assert_eq!(panel(half).radiosity(Vec3::NEG_Z), Vec3::ZERO);
    }
}
