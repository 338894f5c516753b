//! The tool in the picture: the pad of a sander or a grinding wheel with its drive, above the workpiece or on it.
//!
//! Its bodies are united with the workpiece's field as clutter is, and labelled as `tool`.

use std::f64::consts::{PI, TAU};

use glam::{DQuat, DVec2, DVec3};
use random::Stream;
use sdf_bake::BrickGrid;
use serde::{Deserialize, Serialize};

use crate::clutter::{ObstacleDraw, ObstacleShape, Places, below};
use crate::scene::{CameraDraw, NoSurface, PlacementDraw, Scene};

/// Shares of the placements with a tool, and of the tools that touch the workpiece.
const SHARES: [f64; 2] = [0.4, 0.35];
/// Places that are tried; a vertical line at some meets no workpiece.
const TRIES: usize = 8;
/// Radii of pads and wheels relative to the workpiece's reach.
const RADII: [f64; 2] = [0.12, 0.28];
/// Distances of a tool that does not touch the workpiece [m].
const DISTANCES: [f64; 2] = [1e-3, 40e-3];
/// Points of a rim that are kept clear of the workpiece, and steps in which a tool is raised for that.
const RIM_POINTS: u32 = 90;
const RAISES: usize = 6;
/// Greatest inclination of a pad to the surface in both directions [rad].
const INCLINATION: f64 = 0.12;

/// Type of a tool.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ToolKind {
    /// A disc parallel to the surface, below a housing with a handle.
    Pad,
    /// A disc upright on the surface, on a spindle.
    Wheel,
}

/// A tool over or on the workpiece.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ToolDraw {
    /// Type.
    pub kind: ToolKind,
    /// Distance between pad or wheel and the surface below it [m]; 0 on the workpiece.
    pub distance_m: f64,
    /// Its bodies, the pad or the wheel first.
    pub bodies: Vec<ObstacleDraw>,
}

/// A round body: radius and half length [m], colour, roughness and whether it is bare metal.
struct Round {
    radius: f64,
    half: f64,
    colour: DVec3,
    roughness: f64,
    is_metal: bool,
}

impl Round {
    /// Paper or stone: brown, black, grey, red, green.
    fn abrasive(radius: f64, half: f64, stream: &mut Stream) -> Self {
        let colours =
            [[0.20, 0.09, 0.04], [0.015, 0.015, 0.015], [0.18, 0.18, 0.18], [0.25, 0.04, 0.03], [0.05, 0.12, 0.08]];
        let colour = DVec3::from_array(colours[stream.below(colours.len())]) * stream.between([0.7, 1.3]);
        Self { radius, half, colour, roughness: stream.between([0.75, 0.98]), is_metal: false }
    }

    /// Plastic, paint or metal.
    fn body(radius: f64, half: f64, stream: &mut Stream) -> Self {
        let is_metal = stream.happens(0.35);
        let paint = DVec3::from_array(std::array::from_fn(|_| stream.ratio_between([0.01, 0.6])));
        let colour = if is_metal { DVec3::splat(stream.between([0.3, 0.7])) } else { paint };
        Self { radius, half, colour, roughness: stream.between([0.15, 0.7]), is_metal }
    }

    /// The body with its axis along a unit vector and its middle at a point of the scene [m].
    fn placed(self, axis: DVec3, middle: DVec3) -> ObstacleDraw {
        ObstacleDraw {
            shape: ObstacleShape::Cylinder,
            size_m: DVec3::new(self.radius, self.half, 0.0),
            rotation: DQuat::from_rotation_arc(DVec3::Z, axis),
            position_m: middle,
            colour: self.colour,
            roughness: self.roughness,
            is_metal: self.is_metal,
            mesh: None,
        }
    }
}

impl ToolDraw {
    /// Draws the tool of a placement; some have none.
    pub(crate) fn draw(
        part: &BrickGrid,
        (placement, camera): (&PlacementDraw, &CameraDraw),
        stream: &mut Stream,
    ) -> Result<Option<Self>, NoSurface> {
        if !stream.happens(SHARES[0]) {
            return Ok(None);
        }
        let (places, pose) = (Places::of(part, placement)?, placement.pose());
        let mut at = || {
            let share = DVec2::new(stream.between([0.1, 0.9]), stream.between([0.1, 0.9]));
            below(part, &pose, places.above(share))
        };
        let Some(foot) = (0..TRIES).find_map(|_| at()) else { return Ok(None) };
        let normal = placement.rotation * part.normal(pose.to_part(foot)).as_dvec3();
        let kind = if stream.happens(0.6) { ToolKind::Pad } else { ToolKind::Wheel };
        let radius = places.reach() * stream.ratio_between(RADII);
        let distance_m = if stream.happens(SHARES[1]) { 0.0 } else { stream.ratio_between(DISTANCES) };
        let away = camera.axes[2].truncate().normalize_or(DVec2::X);
        let bodies = match kind {
            ToolKind::Pad => pad(radius, (foot + normal * distance_m, normal), away, stream),
            ToolKind::Wheel => wheel(radius, foot + normal * (distance_m + radius), normal, stream),
        };
        let field = |point: DVec3| f64::from(part.sample(pose.to_part(point)));
        Ok(Some(Self { kind, distance_m, bodies: raised(bodies, (field, f64::from(part.band)), (normal, distance_m)) }))
    }
}

/// Bodies raised along a normal until the rim of the first one is at a distance from the surface [m]; an edge or a groove
/// beside the foot may be nearer. `field`: signed distance from the workpiece [m], cut off at its band.
fn raised(
    mut bodies: Vec<ObstacleDraw>,
    (field, band): (impl Fn(DVec3) -> f64, f64),
    (normal, distance): (DVec3, f64),
) -> Vec<ObstacleDraw> {
    for _ in 0..RAISES {
        let nearest = rim(&bodies[0]).map(&field).fold(f64::INFINITY, f64::min);
        let missing = (distance.min(band) - nearest).max(0.0);
        bodies.iter_mut().for_each(|body| body.position_m += normal * missing);
    }
    bodies
}

/// Points of both rims of a round body [m].
fn rim(body: &ObstacleDraw) -> impl Iterator<Item = DVec3> {
    let DVec3 { x: radius, y: half, .. } = body.size_m;
    let (rotation, middle) = (body.rotation, body.position_m);
    let around = (0..RIM_POINTS).map(|point| TAU * f64::from(point) / f64::from(RIM_POINTS));
    around.flat_map(move |angle| {
        let out = DVec2::from_angle(angle) * radius;
        [-half, half].map(|end| middle + rotation * out.extend(end))
    })
}

/// A disc on `foot` with a plate and a housing on it, and a handle that points away from the camera within a half circle.
fn pad(radius: f64, (foot, normal): (DVec3, DVec3), away: DVec2, stream: &mut Stream) -> Vec<ObstacleDraw> {
    let (side, along) = normal.any_orthonormal_pair();
    let [a, b] = [(); 2].map(|()| stream.between([-INCLINATION, INCLINATION]));
    let axis = (normal + side * a + along * b).normalize();
    // The rim of the inclined disc touches first.
    let lift = radius * (1.0 - axis.dot(normal).powi(2)).max(0.0).sqrt();
    let mut top = foot + normal * lift;
    let mut stacked = |round: Round| {
        let middle = top + axis * round.half;
        top += axis * (2.0 * round.half);
        round.placed(axis, middle)
    };
    let [disc, plate, housing] = [[0.06, 0.16], [0.04, 0.1], [0.4, 0.9]].map(|range| radius * stream.between(range));
    let [plate_radius, housing_radius] = [[0.75, 0.98], [0.4, 0.75]].map(|range| radius * stream.between(range));
    let mut bodies = vec![
        stacked(Round::abrasive(radius, disc, stream)),
        stacked(Round::body(plate_radius, plate, stream)),
        stacked(Round::body(housing_radius, housing, stream)),
    ];
    let reach = radius * stream.between([1.2, 2.6]);
    let level = away.rotate(DVec2::from_angle(stream.between([-0.5 * PI, 0.5 * PI])));
    let handle = level.extend(stream.between([0.0, 0.7])).normalize();
    let grip = Round::body(radius * stream.between([0.2, 0.35]), reach, stream);
    bodies.push(grip.placed(handle, top - axis * (0.5 * housing) + handle * reach));
    bodies
}

/// A disc about a point, its axis along the surface, with a flange on both sides and a spindle on one.
fn wheel(radius: f64, middle: DVec3, normal: DVec3, stream: &mut Stream) -> Vec<ObstacleDraw> {
    let (side, along) = normal.any_orthonormal_pair();
    let (sine, cosine) = stream.between([0.0, TAU]).sin_cos();
    let axis = side * cosine + along * sine;
    let half = radius * stream.between([0.05, 0.2]);
    let flange = radius * stream.between([0.25, 0.45]);
    let spindle = radius * stream.between([1.0, 2.2]);
    let disc = Round::abrasive(radius, half, stream);
    let flanges = Round::body(flange, half + 0.08 * radius, stream);
    let drive = Round::body(flange * stream.between([0.5, 0.95]), spindle, stream);
    vec![disc.placed(axis, middle), flanges.placed(axis, middle), drive.placed(axis, middle + axis * spindle)]
}

impl Scene {
    /// Bodies of the tool; none without one.
    pub(crate) fn tool_bodies(&self) -> &[ObstacleDraw] {
        self.tool.as_ref().map_or(&[], |tool| &tool.bodies)
    }
}

#[cfg(test)]
mod tests {
    use render::VisibleObject;
    use render::label::{BACKGROUND, IGNORE};

    use super::*;
    use crate::{Look, SceneFiles, Seeds, Shape, TOOL_INSTANCE, View, instances, shoot};

    const SIZE: (usize, usize) = (96, 72);

    fn scenes(part: &BrickGrid) -> Vec<Scene> {
        let draw = |placement| Scene::draw(part, &Seeds { placement, image: 3 }, SIZE, &[Look::Tool]).unwrap();
        (0..40).map(draw).collect()
    }

    #[test]
    fn a_share_of_the_placements_has_a_tool_at_its_distance_from_the_workpiece() {
        let part = Shape::Panel.field(2e-3);
        let scenes = scenes(&part);
        let tools: Vec<(&Scene, &ToolDraw)> =
            scenes.iter().filter_map(|scene| Some((scene, scene.tool.as_ref()?))).collect();
        assert!((8..24).contains(&tools.len()), "{}", tools.len());
        assert!(
            tools.iter().any(|(_, tool)| tool.distance_m == 0.0)
                && tools.iter().any(|(_, tool)| tool.distance_m > 0.01)
        );
        for kind in [ToolKind::Pad, ToolKind::Wheel] {
            assert!(tools.iter().any(|(_, tool)| tool.kind == kind), "{kind:?}");
        }
        for (scene, tool) in tools {
            let pose = scene.placement.pose();
            let nearest = rim(&tool.bodies[0])
                .map(|point| f64::from(part.sample(pose.to_part(point))))
                .fold(f64::INFINITY, f64::min);
            // The panel is domed, so the rim of a level disc may be farther than its middle.
            let distance = tool.distance_m.min(f64::from(part.band));
            assert!(nearest > distance - 0.2e-3 && nearest < distance + 4e-3, "{nearest} of {distance}");
        }
    }

    #[test]
    fn the_tool_hides_the_workpiece_and_has_its_own_label() {
        let mut part = Shape::Tee.field(2e-3);
        part.dose = vec![0.0; part.phi.len()];
        let files = SceneFiles::default();
        let mut hidden = 0;
        for scene in scenes(&part).into_iter().filter(|scene| scene.tool.is_some()) {
            let (view, frame) = View::of(&part, &scene, SIZE, &files).unwrap();
            let (plain, without) = View::of(&part, &Scene { tool: None, ..scene.clone() }, SIZE, &files).unwrap();
            let labels = instances(&frame.buffers);
            let shown = (0..labels.len()).filter(|&pixel| labels[pixel] == TOOL_INSTANCE);
            assert_eq!(view.tool.map_or(0, |tool| tool.pixels), shown.clone().count() as u64);
            assert!(shown.clone().all(|pixel| frame.buffers.depth[pixel] <= without.buffers.depth[pixel] + 1e-4));
            assert_eq!((plain.tool, plain.amodal_bounds), (None, view.amodal_bounds));
            // The whole workpiece is that of the scene without the tool.
            assert_eq!(frame.amodal, without.amodal);
            let shot = shoot(&part, &scene, SIZE, &files).unwrap();
            // The border beside the workpiece is ignored.
            let is_background = |label: u8| matches!(label, BACKGROUND | IGNORE);
            assert!(
                shown.clone().all(|pixel| [shot.dose[pixel], shot.appearance[pixel]].into_iter().all(is_background))
            );
            hidden += shown.filter(|&pixel| without.buffers.seen[pixel] == VisibleObject::Part).count();
        }
        assert!(hidden > 1000, "{hidden}");
    }
}
