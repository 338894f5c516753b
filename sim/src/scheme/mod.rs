//! Integration of the contact over a step: a scheme for grinding, whose surface recedes, and one for sanding, whose
//! coating wears.
//!
//! Both measure the tool over the columns, evaluate the model's pressure, and vary the tool's travel until the force
//! meets the controller's law. They differ in the time within the step at which they measure, and in the quantity that
//! they remove.

mod contact_integrals;
mod contact_state;
mod dose;
mod exponential_integrator;
mod grinding;
mod lanes;
mod nonlinear_correction;
mod sanding;
mod threshold;

use std::ops::Range;

pub(crate) use self::contact_integrals::ContactStep;
pub(crate) use self::grinding::Grinding;
use self::sanding::Sanding;
use crate::extent::Extent;
use crate::height_field::{HeightField, Window};
use crate::path::Path;
use crate::physics::Physics;
use crate::pose::{Placement, Pose};
use crate::record::Removal;
use crate::region::Region;
use crate::settings::Pass;
use effects::RunError;
use robot::Tool;

/// A method to integrate the contact over steps. A step calls the methods in this order.
pub(crate) trait Scheme: Send {
    /// True if the surface recedes: then the height field is written back and read again.
    fn recedes(&self) -> bool;

    /// Longest distances and steps of a pass's tool on voxels of a size [m].
    fn step_limits(&self, pass: &Pass, voxel: f64) -> StepLimits;

    /// The window of the surface to be read next, and its lowest corner [m up].
    fn next_window(&self, ahead: &WindowRequest) -> (Window, f64);

    /// Distance below the tool down to which the surface is searched for [m] while the tool is at work.
    fn below(&self, search_reach: f64, voxel: f64) -> f64;

    /// Evaluates a region of the height field from now on.
    fn look_at(&mut self, region: Region);

    /// Forgets the previous step, because its height field is discarded.
    fn leave_height_field(&mut self);

    /// True if the step continues from the state that the previous one left, so that its start is in balance.
    fn goes_on(&self) -> bool;

    /// Placement of the tool within a step over `times` [s] at which it is measured.
    fn measured<'a>(&self, tool: &'a Tool, times: Range<f64>, pose_at: &dyn Fn(f64) -> Pose) -> Placement<'a>;

    /// Starts a step: measures the tool over the current surface, if needed.
    ///
    /// # Errors
    /// A formula of the model that gives no finite number; the same for all methods that evaluate the model.
    fn begin(&mut self, start: &Placement, height_field: &HeightField, physics: &mut Physics) -> Result<(), RunError>;

    /// Force of a trial step of `dt` [s] with the tool at the given placement.
    fn force_at(
        &mut self,
        place: &Placement,
        height_field: &HeightField,
        physics: &mut Physics,
        dt: f64,
    ) -> Result<EndForce, RunError>;

    /// True if that force is the mean over the step, false if it is the force at its end.
    fn is_mean(&self) -> bool;

    /// Largest depth under the working surface at a placement [m]; negative when the tool is above the surface (the
    /// gap).
    fn gap(&self, place: &Placement, height_field: &HeightField) -> f64;

    /// True if the patch may extend beyond the region.
    fn reaches_border(&self, height_field: &HeightField) -> bool;

    /// Completes the step of `dt` [s] once its force is balanced; `middle` is the tool in the middle of the step.
    fn complete(
        &mut self,
        middle: &Placement,
        height_field: &HeightField,
        physics: &mut Physics,
        dt: f64,
    ) -> Result<(), RunError>;

    /// Result of the step for the cells in contact.
    fn step(&self) -> ContactStep<'_>;

    /// Applies the step to a height field and its `coating` [m].
    fn apply(&mut self, height_field: &mut HeightField, coating: f64) -> AppliedRemoval;
}

/// The scheme of a model.
pub(crate) fn scheme_of(physics: &Physics) -> Box<dyn Scheme> {
    if physics.grinds() { Box::<Grinding>::default() } else { Box::<Sanding>::default() }
}

/// Longest distances of a tool, and longest steps.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct StepLimits {
    /// Longest distance in one step [m].
    pub(crate) step_way: f64,
    /// Longest distance on one height field [m].
    pub(crate) height_field_way: f64,
    /// Longest step that may begin on each segment of the path [s].
    pub(crate) longest_steps: Vec<f64>,
}

impl StepLimits {
    /// Longest step on a segment of a path in which a tool moves no farther than `way` [m]; `longest` [s] if it is at
    /// rest.
    fn longest_step(path: &Path, piece: usize, (way, longest): (f64, f64)) -> f64 {
        let speed = path.piece_velocity(piece).length();
        if speed > 0.0 { longest.min(way / speed) } else { longest }
    }
}

/// Tool, contact and times from which the next window of the surface is chosen.
pub(crate) struct WindowRequest<'a> {
    /// The tool.
    pub(crate) tool: &'a Tool,
    /// Extent of the contact.
    pub(crate) extent: Extent,
    /// Voxel of the field [m].
    pub(crate) voxel: f64,
    /// Longest distances of the tool.
    pub(crate) step_limits: &'a StepLimits,
    /// Time until the next height field is written back [s].
    pub(crate) until_written: f64,
    /// Time until the end of the pass [s].
    pub(crate) until_end: f64,
    /// The window for an extent of the contact, over a time ahead [s] sampled at a number of poses.
    pub(crate) window: &'a dyn Fn(&Extent, f64, f64) -> (Window, f64),
}

/// Force at the end of a step, and its dependence on the travel.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct EndForce {
    /// At the end [N].
    pub(crate) force: f64,
    /// -dF/dz [N/m].
    pub(crate) stiffness: f64,
}

/// Removal by a step that was applied to a height field.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct AppliedRemoval {
    /// Volumes removed from the part and from its coating.
    pub(crate) removal: Removal,
    /// Largest recession of any column since the height field was read [m].
    pub(crate) receded: f64,
}
