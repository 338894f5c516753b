//! Spatter: droplets of weld metal that froze on the base metal beside a weld. They are part of the workpiece, coated
//! and sanded with it, and labelled as its base metal.

use std::borrow::Cow;
use std::f64::consts::TAU;

use glam::{DVec3, IVec3};
use random::Stream;
use render::{Field, FusionLine, Ray};
use sdf_bake::{BrickGrid, Combine};
use serde::{Deserialize, Serialize};

use crate::scene::Scene;

/// Share of the placements with spatter.
const SHARE: f64 = 0.6;
/// Least and greatest number of droplets that are tried.
const COUNTS: [f64; 2] = [8.0, 80.0];
/// Least radius of a droplet [voxels]; a smaller one would vanish between voxels.
const LEAST_RADIUS: f64 = 0.9;
/// Radii of droplets [m].
const RADII: [f64; 2] = [0.35e-3, 1.3e-3];
/// Heights above the fusion line from which droplets fly [m].
const HEIGHTS: [f64; 2] = [2e-3, 12e-3];
/// Angles of their flight below the tangent of the surface [rad].
const DIPS: [f64; 2] = [0.1, 1.2];
/// Greatest distance from the fusion line at which they stick [m].
const FARTHEST: f64 = 30e-3;
/// Share of a droplet's radius by which its centre lies above the surface.
const LIFT: f64 = 0.25;

/// A droplet.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DropletDraw {
    /// Centre of its ball in the part's frame [m].
    pub centre_m: DVec3,
    /// Radius [m].
    pub radius_m: f64,
}

impl DropletDraw {
    /// Draws the droplets of a placement; none without a weld.
    pub(crate) fn draw(part: &BrickGrid, stream: &mut Stream) -> Vec<Self> {
        let line = FusionLine::of(part);
        if line.points().is_empty() || !stream.happens(SHARE) {
            return Vec::new();
        }
        let count = stream.ratio_between(COUNTS) as usize;
        let field = Field::new(part);
        (0..count).filter_map(|_| Self::beside(&field, &line, stream)).collect()
    }

    /// A droplet where one that flies straight from above a weld lands, if that is on base metal near the weld.
    fn beside(field: &Field, line: &FusionLine, stream: &mut Stream) -> Option<Self> {
        let part = field.grid;
        let from = line.points()[stream.below(line.points().len())].as_dvec3();
        let normal = part.normal(from).as_dvec3();
        let origin = from + normal * stream.ratio_between(HEIGHTS);
        if part.sample(origin) <= 0.0 {
            return None;
        }
        let (side, along) = normal.any_orthonormal_pair();
        let turn = stream.between([0.0, TAU]);
        let (down, across) = stream.between(DIPS).sin_cos();
        let direction = (side * turn.cos() + along * turn.sin()) * across - normal * down;
        let radius_m = stream.ratio_between(RADII).max(LEAST_RADIUS * part.voxel);
        let foot = field.trace(&Ray { origin, direction })?.point;
        let away = f64::from(line.distance(foot.as_vec3()));
        let is_free = part.label(foot) == 0 && away > radius_m && away < FARTHEST;
        let up = part.normal(foot).as_dvec3();
        is_free.then(|| Self { centre_m: foot + up * (LIFT * radius_m), radius_m })
    }

    fn distance(&self, point: DVec3) -> f64 {
        point.distance(self.centre_m) - self.radius_m
    }
}

/// The part with the droplets of a scene; the part itself if there are none. A droplet has the dose of its foot.
pub(crate) fn spattered<'a>(part: &'a BrickGrid, scene: &Scene) -> Cow<'a, BrickGrid> {
    let droplets = &scene.spatter;
    if droplets.is_empty() {
        return Cow::Borrowed(part);
    }
    let (low, high) = droplets.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), droplet| {
        (low.min(droplet.centre_m - droplet.radius_m), high.max(droplet.centre_m + droplet.radius_m))
    });
    let band = f64::from(part.band) / part.voxel;
    let nearest = |point: DVec3| droplets.iter().map(|droplet| droplet.distance(point)).fold(f64::INFINITY, f64::min);
    let drops = BrickGrid::from_distance(low, high, part.voxel, band, nearest);
    let mut all = part.combined_with(&drops, Combine::Union).expect("one lattice");
    if !all.dose.is_empty() {
        droplets.iter().for_each(|droplet| dose(&mut all, part, droplet));
    }
    Cow::Owned(all)
}

/// Gives the voxels of a droplet the dose at its foot.
fn dose(all: &mut BrickGrid, part: &BrickGrid, droplet: &DropletDraw) {
    let foot = part.closest_surface_point(droplet.centre_m).unwrap_or(droplet.centre_m);
    let value = part.sample_dose(foot);
    let reach = droplet.radius_m + f64::from(part.band);
    let [low, high] = [-reach, reach].map(|step| ((droplet.centre_m + step) / part.voxel).round().as_ivec3());
    for (x, y) in (low.x..=high.x).flat_map(|x| (low.y..=high.y).map(move |y| (x, y))) {
        for z in low.z..=high.z {
            let Some(place) = all.place(IVec3::new(x, y, z)) else { continue };
            let position = all.position(all.voxel_of(place));
            let is_its_own = droplet.distance(position) < f64::from(part.sample(position));
            if is_its_own {
                all.dose[place] = value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Look, SceneFiles, Seeds, Shape, View};
    use render::VisibleObject;

    /// A tee with a dose, and a scene with droplets on it.
    fn tee() -> (BrickGrid, Scene) {
        let mut part = Shape::Tee.field(1e-3);
        part.dose = vec![0.7; part.phi.len()];
        let draw = |placement| Scene::draw(&part, &Seeds { placement, image: 1 }, (96, 72), &[Look::Spatter]).unwrap();
        let scene = (0..).map(draw).find(|scene| scene.spatter.len() > 10).unwrap();
        (part, scene)
    }

    #[test]
    fn droplets_stand_on_base_metal_beside_the_weld_with_the_dose_of_their_foot() {
        let (part, scene) = tee();
        let all = spattered(&part, &scene);
        assert_eq!(all.sanity_check(), Ok(()));
        assert!(all.volume() > part.volume());
        let mut proud = 0;
        for droplet in &scene.spatter {
            let top = droplet.centre_m + part.normal(droplet.centre_m).as_dvec3() * droplet.radius_m;
            // A droplet in a corner may end within the other face.
            proud += usize::from(part.sample(top) > 0.0);
            assert!(all.sample(top) < 0.5e-3, "{top}");
            assert_eq!(all.label(droplet.centre_m), 0);
            assert!((all.sample_dose(droplet.centre_m) - 0.7).abs() < 1e-6);
            assert!(FusionLine::of(&part).distance(droplet.centre_m.as_vec3()) < 0.032);
        }
        assert!(5 * proud > 4 * scene.spatter.len(), "{proud} of {}", scene.spatter.len());
    }

    #[test]
    fn a_part_without_a_weld_has_none_and_droplets_count_as_workpiece() {
        let panel = Shape::Panel.field(2e-3);
        for seed in 0..20 {
            assert!(DropletDraw::draw(&panel, &mut Stream::of(seed, "spatter")).is_empty());
        }
        let (part, scene) = tee();
        let (_, frame) = View::of(&part, &scene, (96, 72), &SceneFiles::default()).unwrap();
        let hidden = frame.buffers.seen.iter().filter(|seen| **seen == VisibleObject::Obstacle).count();
        assert_eq!(hidden, 0);
        let plain = Scene { spatter: Vec::new(), ..scene };
        let (_, without) = View::of(&part, &plain, (96, 72), &SceneFiles::default()).unwrap();
        assert_ne!(frame.buffers.depth, without.buffers.depth);
    }
}
