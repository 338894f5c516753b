//! Colours of the oxide film on steel beside a weld. On the CPU only.
//!
//! Light reflected at the top and at the bottom of the film interferes. The film is thickest at the fusion line and
//! thins out away from it, so the colours run from blue over purple and brown to straw.

use glam::{DVec2, Vec3};

use super::texture::noise_at;

/// Refractive index and absorption of iron at 588 nm (Johnson & Christy 1974).
const IRON: DVec2 = DVec2::new(2.93, 3.0);
/// Refractive index and absorption of the film, the same for all colours: typical of iron oxide.
const OXIDE: DVec2 = DVec2::new(2.4, 0.1);
/// Greatest thickness in the table [nm].
const THICKEST: usize = 160;
/// Wavelengths [nm]: first, step, number.
const WAVELENGTHS: (f64, f64, usize) = (400.0, 10.0, 31);
/// Share of the metal that the film covers; the flanks of its roughness are bare.
const COVERED: f32 = 0.85;
/// Period of the variation of the thickness [m].
const PERIOD: f32 = 7e-3;
/// Greatest variation of the logarithm of the thickness.
const VARIATION: f32 = 0.25;

/// Heat tint of the metal around all welds.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatTint {
    /// Thickness of the film at the fusion line and on the weld [m], 160 nm at most.
    pub thickest: f32,
    /// Distance over which the thickness falls to 1/e [m].
    pub decay: f32,
    /// Reflectance relative to bare iron by thickness, in steps of 1 nm; linear RGB.
    colours: Vec<Vec3>,
}

impl HeatTint {
    /// Computes the colours. `thickest`, `decay` [m]: the fields of these names.
    pub fn new(thickest: f32, decay: f32) -> Self {
        let bare = reflectances(0.0);
        let colours =
            (0..=THICKEST).map(|thickness| Vec3::ONE.lerp(reflectances(thickness as f64) / bare, COVERED)).collect();
        Self { thickest, decay, colours }
    }

    /// Thickness of the film [m] at a point [m], `distance` [m] from the fusion line. The exponential stands for the
    /// fall of the peak temperature away from a weld (Adams 1958) and the growth of oxide, which rises with it.
    #[inline(always)]
    pub(crate) fn thickness(&self, point: Vec3, distance: f32) -> f32 {
        let variation = (VARIATION * noise_at(point / PERIOD + Vec3::splat(5.1))).exp();
        self.thickest * variation * (-distance / self.decay).exp()
    }

    /// Reflectance relative to bare metal of a film `thickness` [m] thick, linear RGB. `cosine`: of the angle between
    /// normal and view; refraction shortens the path by the cosine in the film (Born & Wolf 1959, section 7.6).
    #[inline(always)]
    pub(crate) fn colour(&self, thickness: f32, cosine: f32) -> Vec3 {
        let index = OXIDE.x as f32;
        let within = (1.0 - (1.0 - cosine * cosine) / (index * index)).max(0.0).sqrt();
        let at = (1e9 * thickness * within).clamp(0.0, THICKEST as f32);
        let low = (at as usize).min(THICKEST - 1);
        self.colours[low].lerp(self.colours[low + 1], at - low as f32)
    }
}

/// Reflectance of iron under a film `thickness` [nm] thick, linear RGB; 1 for a perfect mirror.
fn reflectances(thickness: f64) -> Vec3 {
    let (first, step, count) = WAVELENGTHS;
    let (mut light, mut white) = ([0.0; 3], [0.0; 3]);
    for wavelength in (0..count).map(|i| first + step * i as f64) {
        let reflected = reflectance(thickness, wavelength);
        for (axis, matched) in colour_matching(wavelength).into_iter().enumerate() {
            light[axis] += reflected * matched;
            white[axis] += matched;
        }
    }
    (linear_rgb(light) / linear_rgb(white)).max(Vec3::ZERO)
}

/// Reflectance at normal incidence: r = (r₁ + r₂ e^{2iβ}) / (1 + r₁ r₂ e^{2iβ}), β = 2π n h / λ (Born & Wolf 1959,
/// Eq. 7.6 (9)), with the complex index of the film. `thickness`, `wavelength` [nm].
fn reflectance(thickness: f64, wavelength: f64) -> f64 {
    let phase = OXIDE * (4.0 * std::f64::consts::PI * thickness / wavelength);
    let turn = DVec2::from_angle(phase.x) * (-phase.y).exp();
    let (outer, inner) = (amplitude(DVec2::X, OXIDE), amplitude(OXIDE, IRON).rotate(turn));
    quotient(outer + inner, DVec2::X + outer.rotate(inner)).length_squared()
}

/// Amplitude reflected between two media at normal incidence, (n₁ − n₂) / (n₁ + n₂) (Fresnel 1823).
fn amplitude(from: DVec2, to: DVec2) -> DVec2 {
    quotient(from - to, from + to)
}

/// Quotient of two complex numbers.
fn quotient(a: DVec2, b: DVec2) -> DVec2 {
    DVec2::new(b.x, -b.y).rotate(a) / b.length_squared()
}

/// CIE 1931 colour matching functions, in the approximation by single lobes (Wyman, Sloan & Shirley 2013, Eq. 2, 3).
fn colour_matching(wavelength: f64) -> [f64; 3] {
    let bell = |at: f64| (-0.5 * at * at).exp();
    let log = |middle: f64, width: f64| bell((wavelength.ln() - middle.ln()) / width);
    [
        1.065 * bell((wavelength - 595.8) / 33.33) + 0.366 * bell((wavelength - 446.8) / 19.44),
        1.014 * log(556.3, 0.075),
        1.839 * log(449.8, 0.051),
    ]
}

/// Linear sRGB of tristimulus values (IEC 61966-2-1).
fn linear_rgb([x, y, z]: [f64; 3]) -> Vec3 {
    Vec3::new(
        (3.2406 * x - 1.5372 * y - 0.4986 * z) as f32,
        (-0.9689 * x + 1.8758 * y + 0.0415 * z) as f32,
        (0.0557 * x - 0.2040 * y + 1.0570 * z) as f32,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tint() -> HeatTint {
        HeatTint::new(60e-9, 5e-3)
    }

    #[test]
    fn without_a_film_the_reflectance_is_fresnel_s() {
        let square = (IRON - DVec2::X).length_squared() / (IRON + DVec2::X).length_squared();
        assert!((reflectance(0.0, 550.0) - square).abs() < 1e-12);
        // A very thick absorbing film hides the iron.
        let film = (OXIDE - DVec2::X).length_squared() / (OXIDE + DVec2::X).length_squared();
        assert!((reflectance(1e5, 550.0) - film).abs() < 1e-9);
        assert!((tint().colour(0.0, 1.0) - Vec3::ONE).length() < 1e-5);
    }

    #[test]
    fn the_colours_run_from_straw_over_purple_to_blue() {
        let at = |thickness: f32| tint().colour(thickness * 1e-9, 1.0);
        let (straw, purple, blue) = (at(24.0), at(40.0), at(54.0));
        assert!(straw.x > straw.y && straw.y > 1.3 * straw.z, "{straw}");
        assert!(purple.x > 1.2 * purple.y && purple.z > 1.4 * purple.y, "{purple}");
        assert!(blue.z > 1.8 * blue.y && blue.y > 1.5 * blue.x, "{blue}");
    }

    #[test]
    fn the_film_thins_out_and_looks_thinner_from_the_side() {
        let tint = tint();
        let thickness = |distance: f32| tint.thickness(Vec3::new(0.01, 0.02, 0.0), distance);
        assert!((thickness(5e-3) / thickness(0.0) - (-1.0f32).exp()).abs() < 1e-5);
        assert_eq!(thickness(f32::INFINITY), 0.0);
        // At grazing view the path in the film is shorter by √(1 − 1/n²).
        let shorter = (1.0 - 1.0 / 2.4f32.powi(2)).sqrt();
        assert!((tint.colour(50e-9, 0.0) - tint.colour(50e-9 * shorter, 1.0)).length() < 1e-4);
    }
}
