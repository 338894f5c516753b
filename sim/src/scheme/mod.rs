//! Integration of the contact over a step: a scheme for work that recedes, and one for work that only loses coating.
//!
//! Both measure the tool over the columns, take the pressure from the model, and vary the tool's travel until the force
//! meets the controller's law. They differ in where in the step they measure, and in what they take from the work.

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
use crate::path::Path;
use crate::physics::Physics;
use crate::pose::{Placement, Pose};
use crate::record::Removal;
use crate::region::Region;
use crate::settings::Pass;
use crate::sheet::{Sheet, Window};
use effects::RunError;
use robot::Tool;

/// A way to integrate the contact over steps. What follows is in the order in which a step asks for it.
pub(crate) trait Scheme: Send {
    /// True if the surface recedes: then what was read of it is written back, and read again.
    fn recedes(&self) -> bool;

    /// Longest ways and steps of a pass's tool over voxels of a size [m].
    fn pace(&self, pass: &Pass, voxel: f64) -> Pace;

    /// The part of the surface to be read next, and its lowest corner [m up].
    fn next_window(&self, ahead: &Ahead) -> (Window, f64);

    /// Distance below the tool down to which the surface is sought [m] while the tool is at work.
    fn below(&self, search_reach: f64, voxel: f64) -> f64;

    /// Looks at a region of the sheet from now on.
    fn look_at(&mut self, region: Region);

    /// Forgets the step before: its sheet is put aside.
    fn leave_sheet(&mut self);

    /// True if the step continues from the state that the one before left, so that its start is in balance.
    fn goes_on(&self) -> bool;

    /// Where in a step over some times [s] the tool is measured.
    fn measured<'a>(&self, tool: &'a Tool, times: Range<f64>, pose_at: &dyn Fn(f64) -> Pose) -> Placement<'a>;

    /// Starts a step: measures the tool over the surface as it is now, where that is needed.
    ///
    /// # Errors
    /// A formula of the model that gives no finite number; so for all that runs the model.
    fn begin(&mut self, start: &Placement, sheet: &Sheet, physics: &mut Physics) -> Result<(), RunError>;

    /// Tries a step of `dt` [s]: the tool's force where it is measured.
    fn force_at(
        &mut self,
        place: &Placement,
        sheet: &Sheet,
        physics: &mut Physics,
        dt: f64,
    ) -> Result<EndForce, RunError>;

    /// True if that force is the mean over the step, false if it is the one at its end.
    fn is_mean(&self) -> bool;

    /// Largest depth under the working surface there [m], negative: the gap.
    fn gap(&self, place: &Placement, sheet: &Sheet) -> f64;

    /// True if the patch may extend beyond the region.
    fn reaches_border(&self, sheet: &Sheet) -> bool;

    /// Completes the step of `dt` [s] with the tool at `middle` on its way, once its force is the one that is sought.
    fn complete(&mut self, middle: &Placement, sheet: &Sheet, physics: &mut Physics, dt: f64) -> Result<(), RunError>;

    /// Result of the step for the cells in contact.
    fn step(&self) -> ContactStep<'_>;

    /// Applies the step to a sheet and its `coating` [m].
    fn apply(&mut self, sheet: &mut Sheet, coating: f64) -> Applied;
}

/// The scheme of a model.
pub(crate) fn scheme_of(physics: &Physics) -> Box<dyn Scheme> {
    if physics.grinds() { Box::<Grinding>::default() } else { Box::<Sanding>::default() }
}

/// Longest ways of a tool, and longest steps.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Pace {
    /// In one step [m].
    pub(crate) step_way: f64,
    /// On one sheet [m].
    pub(crate) sheet_way: f64,
    /// Longest step that may begin on each piece of the path [s].
    pub(crate) longest_steps: Vec<f64>,
}

impl Pace {
    /// Longest step on a piece of a path in which a tool goes no farther than `way` [m]: `longest` [s] where it stands.
    fn longest_step(path: &Path, piece: usize, (way, longest): (f64, f64)) -> f64 {
        let speed = path.piece_velocity(piece).length();
        if speed > 0.0 { longest.min(way / speed) } else { longest }
    }
}

/// Tool, contact and times from which the next part of the surface to be read is chosen.
pub(crate) struct Ahead<'a> {
    /// The tool.
    pub(crate) tool: &'a Tool,
    /// Extent of the contact.
    pub(crate) extent: Extent,
    /// Voxel of the field [m].
    pub(crate) voxel: f64,
    /// Longest ways of the tool.
    pub(crate) pace: &'a Pace,
    /// Time until the next sheet is written back [s].
    pub(crate) until_written: f64,
    /// Time until the end of the pass [s].
    pub(crate) until_end: f64,
    /// The window for an extent of the contact, so long ahead [s] at so many poses.
    pub(crate) window: &'a dyn Fn(&Extent, f64, f64) -> (Window, f64),
}

/// Force at the end of a step, and how it depends on the travel.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct EndForce {
    /// At the end [N].
    pub(crate) force: f64,
    /// -dF/dz [N/m].
    pub(crate) stiffness: f64,
}

/// Removal by a step that was applied to a sheet.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Applied {
    /// Volumes removed from the part and from its coating.
    pub(crate) removal: Removal,
    /// Largest recession of any column since the sheet was read [m].
    pub(crate) receded: f64,
}
