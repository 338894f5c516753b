//! Neighbouring samples of an image that are looked at together, since what shelters one mostly shelters all.

use glam::Vec3;

use super::beam::Beam;
use super::frame::Seen;
use super::lanes::{LANES, Lanes, Points, any};
use super::scene::Stage;
use super::shade::{Openness, SHADOW_START};
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
    pub(crate) open: Lanes,
    /// Share of each lamp that reaches each sample, 0 to 1.
    pub(crate) shares: Vec<Lanes>,
}

/// Pixels (x, y) of the tile whose first one is given, every four a square.
pub(crate) fn tile_pixels((x, y): (usize, usize)) -> impl Iterator<Item = (usize, usize)> {
    (0..LANES).map(move |i| (x + (i & 1 | i >> 1 & 2), y + (i >> 1 & 1 | i >> 2 & 2)))
}

impl Shelter {
    /// Of a tile's samples. `lamps`: rays towards those of the stage.
    pub(crate) fn of(stage: &Stage, lamps: &[Beam], samples: &[Sample; LANES]) -> Self {
        let field = &stage.scene.field;
        let (mut points, mut normals, mut wanted) = (Points::ZERO, Points::ZERO, [false; LANES]);
        for (i, surface) in samples.iter().enumerate().filter_map(|(i, sample)| Some((i, sample.surface.as_ref()?))) {
            points.set(i, field.in_voxels(surface.position.as_dvec3()));
            normals.set(i, surface.normal);
            wanted[i] = true;
        }
        if !any(&wanted) {
            return Self { open: [1.0; LANES], shares: vec![[0.0; LANES]; lamps.len()] };
        }
        let open = pulp::Arch::new().dispatch(Openness { field, points: &points, normals: &normals, wanted: &wanted });
        let starts = points.moved(&normals, &[SHADOW_START; LANES]);
        let of_lamp = |beam: &Beam| {
            let faces = std::array::from_fn(|i| wanted[i] && normals.get(i).dot(beam.direction()) > 0.0);
            if any(&faces) { beam.shares(&starts, &faces) } else { [0.0; LANES] }
        };
        Self { open, shares: lamps.iter().map(of_lamp).collect() }
    }
}
