//! Things around a workpiece, on it and before the camera: blocks, cylinders, tubes, bolts, clamps, rods, meshes.
//!
//! They are united with the workpiece's field, so they cast shadows, hide it and are hidden by it. The metal that is
//! theirs has labels from [`FIRST_OBSTACLE`] on, that of the tool from [`FIRST_TOOL`] on.

use std::borrow::Cow;
use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec2, DVec3};
use random::Stream;
use render::{FIRST_OBSTACLE, FIRST_TOOL, Field, Material, Placement, Ray};
use sdf_bake::grid::BRICK_VOXELS;
use sdf_bake::{BrickGrid, Combine};
use serde::{Deserialize, Serialize};

use crate::clutter_mesh::ClutterMeshes;
use crate::scene::{CameraDraw, NoSurface, PlacementDraw, Scene, corners};
use crate::shapes::rounded_box;

/// Greatest number of things beside the workpiece.
const MOST_BESIDE: usize = 6;
/// Shares of the placements with a thing on the workpiece, a clamp on its edge, a rod before the camera.
const SHARES: [f64; 3] = [0.3, 0.25, 0.25];

/// Shape of a thing about its own origin.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ObstacleShape {
    /// A box with rounded edges; sizes: half sides.
    Block,
    /// A cylinder about z; sizes: radius, half length, radius of the bore or 0.
    Cylinder,
    /// A screw along z, its hexagonal head at the upper end; sizes: radius of the shank, half length, 0.
    Bolt,
    /// A clamp open towards +x, with jaws one above the other along z; sizes: half the gap, length of the jaws, 0.
    Clamp,
    /// A mesh, see [`ObstacleDraw::mesh`]; sizes: half the diagonal of its box, 0, 0.
    Mesh,
}

/// A thing in the scene.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ObstacleDraw {
    /// Shape.
    pub shape: ObstacleShape,
    /// Sizes as the shape takes them [m].
    pub size_m: DVec3,
    /// Rotation from its own frame to the scene's, as a unit quaternion x, y, z, w.
    pub rotation: DQuat,
    /// Its origin in the scene [m].
    pub position_m: DVec3,
    /// Linear RGB.
    pub colour: DVec3,
    /// Roughness, 0 to 1.
    pub roughness: f64,
    /// Bare metal; otherwise paint, plastic or wood.
    pub is_metal: bool,
    /// Place of the mesh in the list of the set, if the shape is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mesh: Option<usize>,
}

/// Distance to a regular hexagon with an inscribed circle of this radius.
fn hexagon(p: DVec2, inner: f64) -> f64 {
    let side = |turn: f64| p.dot(DVec2::from_angle(turn)).abs();
    side(0.0).max(side(PI / 3.0)).max(side(2.0 * PI / 3.0)) - inner
}

/// Half the thickness of a clamp's bars.
fn bar_half(gap: f64, reach: f64) -> f64 {
    0.25 * gap.max(0.4 * reach)
}

/// Distance to a C clamp: a back and two jaws, and a screw through the upper one.
fn clamp(p: DVec3, gap: f64, reach: f64) -> f64 {
    let thick = bar_half(gap, reach);
    let bar = |centre: DVec3, half: DVec3| rounded_box(p - centre, half, 0.3 * thick);
    let height = gap + 2.0 * thick;
    let back = bar(DVec3::new(-reach - thick, 0.0, 0.0), DVec3::new(thick, thick, height));
    let jaw = |side: f64| {
        bar(DVec3::new(-0.5 * reach, 0.0, side * (gap + thick)), DVec3::new(0.5 * reach + thick, thick, thick))
    };
    let along = p - DVec3::new(-0.2 * reach, 0.0, gap + 2.0 * thick);
    let screw = (along.truncate().length() - 0.5 * thick).max(along.z.abs() - (gap + 2.0 * thick));
    back.min(jaw(1.0)).min(jaw(-1.0)).min(screw)
}

impl ObstacleDraw {
    /// Signed distance at a point of its own frame [m], or a bound of it; negative inside. A mesh that is not in the
    /// files is its ball.
    fn distance(&self, p: DVec3, meshes: &ClutterMeshes) -> f64 {
        let DVec3 { x: a, y: b, z: c } = self.size_m;
        let across = p.truncate().length();
        match self.shape {
            ObstacleShape::Block => rounded_box(p, self.size_m, 0.1 * self.size_m.min_element()),
            ObstacleShape::Cylinder => (across - a).max(p.z.abs() - b).max(c - across),
            ObstacleShape::Bolt => {
                let head = hexagon(p.truncate(), 2.0 * a).max((p.z - b + a).abs() - a);
                (across - a).max(p.z.abs() - b).min(head)
            }
            ObstacleShape::Clamp => clamp(p, a, b),
            ObstacleShape::Mesh => {
                let mesh = self.mesh.and_then(|mesh| meshes.get(&mesh));
                mesh.map_or(p.length() - a, |mesh| a * mesh.distance(p / a))
            }
        }
    }

    /// Radius of a ball about the origin that contains it [m].
    fn radius(&self) -> f64 {
        let DVec3 { x: a, y: b, .. } = self.size_m;
        match self.shape {
            ObstacleShape::Block => self.size_m.length(),
            ObstacleShape::Cylinder => a.hypot(b),
            ObstacleShape::Bolt => (2.5 * a).hypot(b),
            ObstacleShape::Clamp => 2.0 * (2.0 * a + b),
            ObstacleShape::Mesh => a,
        }
    }

    /// Draws the things of a placement.
    pub(crate) fn draw(
        part: &BrickGrid,
        (placement, camera): (&PlacementDraw, &CameraDraw),
        stream: &mut Stream,
    ) -> Result<Vec<Self>, NoSurface> {
        let places = Places::of(part, placement)?;
        let beside = stream.below(MOST_BESIDE + 1);
        let mut things: Vec<Self> = (0..beside).map(|_| places.beside(stream)).collect();
        let [on_it, gripping, before] = SHARES.map(|share| stream.happens(share));
        if on_it {
            things.extend(places.on_top(part, &placement.pose(), stream));
        }
        if gripping {
            things.push(places.clamped(stream));
        }
        if before {
            things.push(places.before(camera, stream));
        }
        Ok(things)
    }

    /// A thing of drawn colour: bare metal, or paint, plastic, wood.
    pub(crate) fn of(
        (shape, size_m): (ObstacleShape, DVec3),
        rotation: DQuat,
        position_m: DVec3,
        stream: &mut Stream,
    ) -> Self {
        let is_metal = stream.happens(0.5);
        let grey = stream.between([0.3, 0.7]);
        let paint = DVec3::from_array(std::array::from_fn(|_| stream.ratio_between([0.02, 0.6])));
        let colour = if is_metal { DVec3::splat(grey) } else { paint };
        let roughness = stream.between([0.2, 0.8]);
        Self { shape, size_m, rotation, position_m, colour, roughness, is_metal, mesh: None }
    }

    pub(crate) fn material(&self) -> Material {
        let metallic = f32::from(u8::from(self.is_metal));
        Material { colour: self.colour.as_vec3(), roughness: self.roughness as f32, metallic }
    }

    /// Its field on the lattice of a part, in the part's frame.
    fn field(&self, pose: &Placement, part: &BrickGrid, meshes: &ClutterMeshes) -> BrickGrid {
        let to_own = |point: DVec3| self.rotation.inverse() * (pose.to_scene(point) - self.position_m);
        let centre = pose.to_part(self.position_m);
        let (low, high) = (centre - self.radius(), centre + self.radius());
        let band = f64::from(part.band) / part.voxel;
        BrickGrid::from_distance(low, high, part.voxel, band, |point| self.distance(to_own(point), meshes))
    }
}

/// Where things can be: about the box of the workpiece in the scene.
pub(crate) struct Places {
    low: DVec3,
    high: DVec3,
    pub(crate) table: f64,
}

impl Places {
    pub(crate) fn of(part: &BrickGrid, placement: &PlacementDraw) -> Result<Self, NoSurface> {
        let corners = corners(part)?.map(|corner| placement.to_scene(corner));
        let fold = |pick: fn(DVec3, DVec3) -> DVec3| corners.into_iter().reduce(pick).unwrap_or_default();
        Ok(Self { low: fold(DVec3::min), high: fold(DVec3::max), table: placement.table_m })
    }

    fn middle(&self) -> DVec3 {
        self.low.midpoint(self.high)
    }

    /// Half the diagonal of the workpiece on the table.
    pub(crate) fn reach(&self) -> f64 {
        0.5 * (self.high - self.low).truncate().length()
    }

    /// A place on the table for a thing of this radius [m], outside a circle about the workpiece.
    pub(crate) fn outside(&self, radius: f64, stream: &mut Stream) -> DVec2 {
        let away = self.reach() * stream.between([1.0, 1.7]) + radius;
        self.middle().truncate() + away * DVec2::from_angle(stream.between([0.0, TAU]))
    }

    /// Where a vertical line from above leads to a place on the workpiece, given by its shares of the box.
    pub(crate) fn above(&self, share: DVec2) -> DVec3 {
        (self.low + (self.high - self.low) * share.extend(1.0)).truncate().extend(self.high.z + 0.1)
    }

    /// A thing on the table, outside a circle about the workpiece.
    fn beside(&self, stream: &mut Stream) -> ObstacleDraw {
        let size = self.reach() * stream.ratio_between([0.08, 0.4]);
        let slender = stream.between([0.3, 1.0]);
        let turn = DQuat::from_rotation_z(stream.between([0.0, TAU]));
        let lying = DQuat::from_rotation_y(0.5 * PI);
        let upright = stream.happens(0.5);
        let (body, low) = match stream.below(4) {
            0 => {
                let half = DVec3::new(size, size * slender, 0.5 * size * stream.between([0.3, 1.0]));
                ((ObstacleShape::Block, half), half.z)
            }
            1 => {
                let radius = 0.5 * size * slender;
                let bore = if stream.happens(0.5) { radius * stream.between([0.4, 0.85]) } else { 0.0 };
                let sizes = DVec3::new(radius, size, bore);
                ((ObstacleShape::Cylinder, sizes), if upright { size } else { radius })
            }
            2 => {
                let sizes = DVec3::new(0.15 * size, 0.7 * size, 0.0);
                ((ObstacleShape::Bolt, sizes), if upright { sizes.y } else { 2.0 * sizes.x })
            }
            _ => {
                let sizes = DVec3::new(0.6 * size * slender, size, 0.0);
                ((ObstacleShape::Clamp, sizes), bar_half(sizes.x, sizes.y))
            }
        };
        let tipped = match body.0 {
            ObstacleShape::Clamp => DQuat::from_rotation_x(0.5 * PI),
            ObstacleShape::Cylinder | ObstacleShape::Bolt if !upright => lying,
            _ => DQuat::IDENTITY,
        };
        let place = self.outside(size, stream);
        ObstacleDraw::of(body, turn * tipped, place.extend(self.table + low), stream)
    }

    /// A small thing on the workpiece, if a vertical line at the drawn place meets it.
    fn on_top(&self, part: &BrickGrid, pose: &Placement, stream: &mut Stream) -> Option<ObstacleDraw> {
        let size = self.reach() * stream.ratio_between([0.06, 0.2]);
        let share = DVec2::new(stream.between([0.15, 0.85]), stream.between([0.15, 0.85]));
        let turn = DQuat::from_rotation_z(stream.between([0.0, TAU]));
        let ((shape, sizes), low) = match stream.below(3) {
            0 => ((ObstacleShape::Block, DVec3::new(1.0, 0.6, 0.4)), 0.4),
            1 => ((ObstacleShape::Cylinder, DVec3::new(1.0, 0.2, 0.4)), 0.2),
            _ => ((ObstacleShape::Bolt, DVec3::new(0.25, 1.0, 0.0)), 1.0),
        };
        let surface = below(part, pose, self.above(share))?;
        Some(ObstacleDraw::of((shape, size * sizes), turn, surface + DVec3::Z * (size * low), stream))
    }

    /// A clamp whose jaws hold the edge of the workpiece's box.
    fn clamped(&self, stream: &mut Stream) -> ObstacleDraw {
        let gap = 0.5 * (self.high.z - self.low.z) + 2e-3;
        let reach = self.reach() * stream.between([0.2, 0.45]);
        let angle = stream.between([0.0, TAU]);
        let (half, outward) = (0.5 * (self.high - self.low).truncate(), DVec2::from_angle(angle));
        // Where the direction leaves the box.
        let edge = (half / outward.abs()).min_element();
        let place = self.middle().truncate() + outward * edge;
        let rotation = DQuat::from_rotation_z(angle + PI);
        let body = (ObstacleShape::Clamp, DVec3::new(gap, reach, 0.0));
        ObstacleDraw::of(body, rotation, place.extend(self.middle().z), stream)
    }

    /// A rod across the view, between the camera and the workpiece.
    fn before(&self, camera: &CameraDraw, stream: &mut Stream) -> ObstacleDraw {
        let [right, up, _] = camera.axes;
        let share = stream.between([0.45, 0.85]);
        let offset = DVec2::new(stream.between([-0.5, 0.5]), stream.between([-0.5, 0.5])) * self.reach() * share;
        let middle = camera.eye_m.lerp(self.middle(), share) + right * offset.x + up * offset.y;
        let turn = stream.between([0.0, PI]);
        let along = (right * turn.cos() + up * turn.sin()).normalize();
        let radius = self.reach() * share * stream.ratio_between([0.02, 0.08]);
        let body = (ObstacleShape::Cylinder, DVec3::new(radius, 1.6 * self.reach(), 0.0));
        ObstacleDraw::of(body, DQuat::from_rotation_arc(DVec3::Z, along), middle, stream)
    }
}

/// The surface of a part vertically below a point of the scene [m], if there is any.
pub(crate) fn below(part: &BrickGrid, pose: &Placement, point: DVec3) -> Option<DVec3> {
    let ray = Ray { origin: pose.to_part(point), direction: pose.direction_to_part(DVec3::NEG_Z) };
    Some(pose.to_scene(Field::new(part).trace(&ray)?.point))
}

/// The part with the things of a scene around it, and its tool; the part itself if there are none.
pub(crate) fn cluttered<'a>(part: &'a BrickGrid, scene: &Scene, meshes: &ClutterMeshes) -> Cow<'a, BrickGrid> {
    let pose = scene.placement.pose();
    let united = |a: &BrickGrid, b: &BrickGrid| a.combined_with(b, Combine::Union).expect("one lattice");
    let labelled = |(label, thing): (u16, &ObstacleDraw)| {
        let field = thing.field(&pose, part, meshes);
        BrickGrid { label: vec![label; field.phi.len()], ..field }
    };
    let bodies = (FIRST_OBSTACLE..).zip(&scene.obstacles).chain((FIRST_TOOL..).zip(scene.tool_bodies()));
    let things = bodies.map(labelled).reduce(|all, thing| united(&all, &thing));
    let Some(things) = things else { return Cow::Borrowed(part) };
    let mut all = united(part, &things);
    // A thing has no dose; where it touches the workpiece, its voxels must not thin the workpiece's.
    for (dose, &brick) in all.dose.chunks_exact_mut(BRICK_VOXELS).zip(&all.bricks) {
        let first = part.slot(brick) as usize * BRICK_VOXELS;
        if let Some(own) = part.dose.get(first..first + BRICK_VOXELS) {
            dose.copy_from_slice(own);
        }
    }
    Cow::Owned(all)
}

#[cfg(test)]
mod tests {
    use render::VisibleObject;

    use super::*;
    use crate::{Look, SceneFiles, Seeds, Shape, View};

    /// A scene of a placement with the given number of things at least.
    fn busy(part: &BrickGrid, least: usize) -> Scene {
        let draw = |placement: u64| Scene::draw(part, &Seeds { placement, image: 3 }, (96, 72), &Look::ALL).unwrap();
        (0..).map(draw).find(|scene| scene.obstacles.len() >= least).unwrap()
    }

    #[test]
    fn distances_are_those_of_the_solids() {
        let at = |shape, size: [f64; 3], point: [f64; 3]| {
            let (rotation, zero) = (DQuat::IDENTITY, DVec3::ZERO);
            let thing = ObstacleDraw {
                shape,
                size_m: size.into(),
                rotation,
                position_m: zero,
                colour: zero,
                roughness: 0.5,
                is_metal: true,
                mesh: None,
            };
            thing.distance(point.into(), &ClutterMeshes::new())
        };
        let tube = |point| at(ObstacleShape::Cylinder, [0.01, 0.03, 0.006], point);
        for (point, distance) in [([0.015, 0.0, 0.0], 0.005), ([0.008, 0.0, 0.0], -0.002), ([0.0, 0.0, 0.0], 0.006)] {
            assert!((tube(point) - distance).abs() < 1e-15, "{point:?}");
        }
        let bolt = |point| at(ObstacleShape::Bolt, [0.004, 0.02, 0.0], point);
        assert!(bolt([0.007, 0.0, 0.018]) < 0.0 && bolt([0.007, 0.0, 0.0]) > 0.0);
        let clamp = |point| at(ObstacleShape::Clamp, [0.01, 0.04, 0.0], point);
        assert!(clamp([-0.02, 0.0, 0.0]) > 0.0, "the jaws leave a gap");
        assert!(
            clamp([-0.02, 0.0, 0.012]) < 0.0 && clamp([-0.02, 0.0, -0.012]) < 0.0 && clamp([-0.045, 0.0, 0.0]) < 0.0
        );
    }

    #[test]
    fn every_thing_keeps_its_label_and_the_part_its_own() {
        let mut part = Shape::Tee.field(2e-3);
        part.dose = vec![0.5; part.phi.len()];
        let scene = busy(&part, 5);
        let all = cluttered(&part, &scene, &ClutterMeshes::new());
        assert_eq!(all.sanity_check(), Ok(()));
        for thing in 0..scene.obstacles.len() as u16 {
            assert!(all.label.contains(&(FIRST_OBSTACLE + thing)), "{thing} of {}", scene.obstacles.len());
        }
        // The dose of the workpiece is that of before, also where a thing touches it.
        let kept = |place: usize| part.place(all.voxel_of(place)).is_none_or(|own| all.dose[place] == part.dose[own]);
        assert!((0..all.dose.len()).all(kept));
        for id in [1, 2] {
            let count = |grid: &BrickGrid| grid.label.iter().filter(|&&label| label == id).count();
            assert!(count(&all) > count(&part) / 2, "weld {id}");
        }
    }

    #[test]
    fn what_hides_the_workpiece_is_counted() {
        let part = Shape::Panel.field(2e-3);
        let (mut hidden, mut with_things) = (0, 0);
        for placement in 0..40 {
            let looks = [Look::Clutter];
            let scene = Scene::draw(&part, &Seeds { placement, image: 3 }, (96, 72), &looks).unwrap();
            let (view, frame) = View::of(&part, &scene, (96, 72), &SceneFiles::default()).unwrap();
            let of = |wanted: VisibleObject| frame.buffers.seen.iter().filter(|seen| **seen == wanted).count();
            let whole = frame.amodal.iter().filter(|there| **there == 1).count();
            assert!(of(VisibleObject::Part) <= whole);
            assert!((view.visible_share - of(VisibleObject::Part) as f64 / whole as f64).abs() < 1e-12);
            let [left, top, across, down] = view.bounds;
            let [x, y, width, height] = view.amodal_bounds;
            assert!(left >= x && top >= y && left + across <= x + width && top + down <= y + height);
            hidden += usize::from(view.visible_share < 0.98);
            with_things += usize::from(of(VisibleObject::Obstacle) > 20);
        }
        assert!((5..36).contains(&hidden) && with_things > 20, "{hidden} hidden, {with_things} with things");
    }
}
