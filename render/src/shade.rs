//! Shading of drawings: a key and a fill light, a studio sky reflected by brushed metal, shadow and occlusion.
//!
//! The lights are fixed to the camera, so that every view of a part is lit the same way. All functions are pure.

use glam::Vec3;
use sdf_bake::grid::trilinear;
pub(crate) use shaders::constants::SHADOW_START;

use super::camera::Camera;
use super::field::{Field, cell_of};
use super::lanes::{LANES, Lanes, Points};
use super::padded::Cells;
use super::shadow::ShadowRays;
use super::surface::Surface;

/// Albedo and reflectance at normal incidence, linear RGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceReflectance {
    /// Diffuse albedo.
    pub diffuse: Vec3,
    /// Reflectance at normal incidence (Schlick 1994, F₀).
    pub mirror: Vec3,
}

/// Steel of the part.
pub const BASE_STEEL: SurfaceReflectance =
    SurfaceReflectance { diffuse: Vec3::new(0.19, 0.213, 0.24), mirror: Vec3::new(0.15, 0.16, 0.17) };
/// Weld metal, in a warm tint that no steel has.
pub const WELD_METAL: SurfaceReflectance =
    SurfaceReflectance { diffuse: Vec3::new(0.55, 0.165, 0.022), mirror: Vec3::new(0.15, 0.095, 0.05) };
/// Paper-like light grey for surfaces without a mapped colour.
pub const UNTOUCHED: SurfaceReflectance = SurfaceReflectance { diffuse: Vec3::splat(0.36), mirror: Vec3::splat(0.05) };

/// The lights of a view, as unit vectors from the surface towards the light in the part's frame.
pub(crate) struct Studio {
    key: Vec3,
    fill: Vec3,
    up: Vec3,
}

const KEY: f32 = 1.75;
const FILL: f32 = 0.38;
const SKY: f32 = 0.62;
const FLOOR: f32 = 0.26;
/// Tangent of the key light's half angle: a large soft box.
const KEY_SPREAD: f32 = 0.16;
/// Blinn-Phong exponent (Blinn 1977) of the key light's highlight: brushed, not polished.
const HIGHLIGHT: f32 = 38.0;
const HIGHLIGHT_STRENGTH: f32 = 1.4;

impl Studio {
    /// Key light over the camera's left shoulder, fill light from the right.
    pub(crate) fn new(camera: &Camera) -> Self {
        let toward = |right: f64, up: f64| {
            (camera.right * right + camera.up * up - camera.forward).normalize_or(-camera.forward).as_vec3()
        };
        // The sky leans towards the camera: from above it is close to the part's vertical, and in a view from below
        // visible surfaces are not left dark.
        let up = (camera.up - 0.6 * camera.forward).normalize_or(camera.up).as_vec3();
        Self { key: toward(-0.55, 0.3), fill: toward(1.3, 0.15), up }
    }

    /// Light reflected by a finish to the camera, linear RGB.
    pub(crate) fn shade(&self, field: &Field, surface: &Surface, finish: &SurfaceReflectance) -> Vec3 {
        let n = facing(surface.normal, surface.view);
        let open = ambient_occlusion(field, surface);
        let lit = self.key_share(field, surface);
        let sky = self.sky(n) * open;
        let diffuse = (KEY * lit * n.dot(self.key).max(0.0) + FILL * n.dot(self.fill).max(0.0) * open + sky) * 0.62;
        let reflected = reflect(surface.view, n);
        let half = (self.key - surface.view).normalize_or(n);
        let highlight = lit * n.dot(half).max(0.0).powf(HIGHLIGHT) * open * HIGHLIGHT_STRENGTH;
        let fresnel = schlick(finish.mirror, -n.dot(surface.view));
        finish.diffuse * diffuse + fresnel * (self.softbox(reflected) * open + highlight)
    }

    /// Mild shading for a colour that encodes a value: the form stays visible and the value readable.
    pub(crate) fn shade_mapped(&self, field: &Field, surface: &Surface, colour: Vec3) -> Vec3 {
        let n = facing(surface.normal, surface.view);
        let light = 0.5 + 0.5 * n.dot(self.key).max(0.0);
        colour * light.mul_add(0.35, 0.68) * (0.75 + 0.25 * ambient_occlusion(field, surface))
    }

    fn key_share(&self, field: &Field, surface: &Surface) -> f32 {
        light_share(field, surface, self.key, KEY_SPREAD)
    }

    /// Diffuse light from the sky and from the floor.
    fn sky(&self, n: Vec3) -> f32 {
        let above = 0.5 + 0.5 * n.dot(self.up);
        FLOOR + (SKY - FLOOR) * above
    }

    /// Environment reflected by brushed metal: a floor, a bright horizon and a ceiling with a soft edge.
    fn softbox(&self, direction: Vec3) -> f32 {
        let height = direction.dot(self.up);
        let ceiling = smooth_step(-0.15, 0.75, height);
        0.35 + 0.85 * ceiling + 0.25 * (1.0 - height.abs()).powi(3)
    }
}

/// Share of a light in a unit direction that reaches a surface, 0 to 1; `spread`: tangent of its half angle.
pub(crate) fn light_share(field: &Field, surface: &Surface, towards: Vec3, spread: f32) -> f32 {
    if surface.normal.dot(towards) <= 0.0 {
        return 0.0;
    }
    let start = field.in_voxels(surface.position.as_dvec3()) + surface.normal * SHADOW_START;
    ShadowRays::new(field, towards, spread).share(start)
}

/// Share of open space just above a point, 0 to 1: φ along the normal relative to the distance (Evans 2006). It is
/// evaluated within the band, because φ is truncated beyond.
pub(crate) fn ambient_occlusion(field: &Field, surface: &Surface) -> f32 {
    let (point, per_metre) = (field.in_voxels(surface.position.as_dvec3()), field.per_metre as f32);
    let missing = |part: f32| {
        let reach = part * field.grid.band;
        let (corner, within) = cell_of(point + surface.normal * (reach * per_metre));
        occlusion(trilinear(&field.cell_phi(corner), within), reach)
    };
    openness(OCCLUSION_STEPS.into_iter().map(missing).sum())
}

/// [`ambient_occlusion`] of the `wanted` samples; compiled by `pulp` for each instruction set.
pub(crate) struct OcclusionLanes<'a> {
    pub(crate) field: &'a Field<'a>,
    /// Surface points [voxels].
    pub(crate) points: &'a Points,
    pub(crate) normals: &'a Points,
    pub(crate) wanted: &'a [bool; LANES],
}

impl pulp::NullaryFnOnce for OcclusionLanes<'_> {
    type Output = Lanes;

    #[inline(always)]
    fn call(self) -> Lanes {
        let Self { field, points, normals, wanted } = self;
        let (mut missing, mut cells) = ([0.0; LANES], Cells::new(field.grid.band));
        for part in OCCLUSION_STEPS {
            let reach = part * field.grid.band;
            let at = points.moved(normals, &[reach * field.per_metre as f32; LANES]);
            cells.low = at.corners(&Points::ZERO);
            field.padded().read(wanted, &mut cells);
            for i in 0..LANES {
                missing[i] += occlusion(cells.phi(i, at.get(i) - cells.low.get(i)), reach);
            }
        }
        missing.map(openness)
    }
}

/// Distances at which occlusion is evaluated [bands].
const OCCLUSION_STEPS: [f32; 3] = [0.3, 0.6, 0.95];

/// Occluded share of space at a distance `reach` from the surface, 0 to 1.
#[inline(always)]
fn occlusion(phi: f32, reach: f32) -> f32 {
    1.0 - (phi / reach).clamp(0.0, 1.0)
}

/// Share of open space, from the sum of occluded shares.
#[inline(always)]
fn openness(missing: f32) -> f32 {
    (1.0 - 1.5 * (missing / OCCLUSION_STEPS.len() as f32)).max(0.15)
}

/// Rotates the normal just enough to face the camera: interpolated normals may point away at silhouettes.
#[inline(always)]
pub(crate) fn facing(normal: Vec3, view: Vec3) -> Vec3 {
    let away = normal.dot(view);
    let across = (normal - view * away).normalize_or(-view);
    if away > 0.0 { across } else { normal }
}

fn reflect(view: Vec3, normal: Vec3) -> Vec3 {
    view - normal * (2.0 * view.dot(normal))
}

/// Fresnel reflectance at an angle given by its cosine (Schlick 1994).
fn schlick(straight: Vec3, cosine: f32) -> Vec3 {
    let grazing = (1.0 - cosine.clamp(0.0, 1.0)).powi(5);
    // Brushed metal is too rough to become a mirror at grazing angles.
    straight + (Vec3::splat(0.55) - straight).max(Vec3::ZERO) * grazing
}

/// Cubic step from 0 at `low` to 1 at `high`.
#[inline(always)]
pub(crate) fn smooth_step(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
