//! Neighbouring samples of an image that are looked at together, since what shelters one mostly shelters all.

use glam::Vec3;

use super::frame::Seen;
use super::lanes::LANES;
use super::scene::Stage;
use super::shade::{ambient_occlusion_of_four, shadow_start};
use super::shadow::Towards;
use super::surface::Surface;

/// Pixels along each side of a tile, which fills the lanes.
pub(crate) const TILE: usize = 4;
/// What a ray meets.
#[derive(Clone, Copy)]
pub(crate) struct Sample {
    pub(crate) direction: Vec3,
    pub(crate) seen: Seen,
    pub(crate) surface: Option<Surface>,
}

impl Sample {
    /// Of no ray.
    pub(crate) const NOTHING: Self = Self { direction: Vec3::ZERO, seen: Seen::Background, surface: None };
}

/// What stands between samples and the light.
pub(crate) struct Shelter {
    /// Share of open space above each sample, 0 to 1.
    open: [f32; LANES],
    /// Share of each lamp that reaches each sample, 0 to 1.
    shares: Vec<[f32; LANES]>,
}

/// What stands between one sample and the light.
pub(crate) struct Sheltered<'a> {
    pub(crate) open: f32,
    shelter: &'a Shelter,
    sample: usize,
}

impl Sheltered<'_> {
    /// Share of each lamp.
    pub(crate) fn shares(&self) -> impl Iterator<Item = f32> {
        self.shelter.shares.iter().map(|shares| shares[self.sample])
    }
}

/// Pixels (x, y) of the tile whose first one is given, every four a square.
pub(crate) fn tile_pixels((x, y): (usize, usize)) -> impl Iterator<Item = (usize, usize)> {
    (0..LANES).map(move |i| (x + (i & 1 | i >> 1 & 2), y + (i >> 1 & 1 | i >> 2 & 2)))
}

impl Shelter {
    /// Of at most [`LANES`] samples. `lamps`: rays towards those of the stage.
    pub(crate) fn of(stage: &Stage, lamps: &[Towards], samples: &[Sample]) -> Self {
        let field = &stage.scene.field;
        let surfaces = || samples.iter().enumerate().filter_map(|(i, sample)| Some((i, sample.surface.as_ref()?)));
        let (mut open, on_surface) = ([1.0; LANES], surfaces().collect::<Vec<_>>());
        for four in on_surface.chunks(4) {
            let found = ambient_occlusion_of_four(field, std::array::from_fn(|i| four[i.min(four.len() - 1)].1));
            four.iter().zip(found.to_array()).for_each(|((place, _), share)| open[*place] = share);
        }
        let of_lamp = |towards: &Towards| {
            let (mut shares, mut found) = ([0.0; LANES], [0.0; LANES]);
            let (mut starts, mut places, mut count) = ([Vec3::ZERO; LANES], [0; LANES], 0);
            for (i, surface) in surfaces().filter(|(_, surface)| surface.normal.dot(towards.direction()) > 0.0) {
                (starts[count], places[count]) = (shadow_start(field, surface), i);
                count += 1;
            }
            towards.shares(&starts[..count], &mut found[..count]);
            places.iter().zip(found).take(count).for_each(|(&place, share)| shares[place] = share);
            shares
        };
        Self { open, shares: lamps.iter().map(of_lamp).collect() }
    }

    /// Of one of the samples.
    pub(crate) fn of_sample(&self, sample: usize) -> Sheltered<'_> {
        Sheltered { open: self.open[sample], shelter: self, sample }
    }
}
