//! How the contact is integrated over a step: a scheme for work that recedes, and one for work that only loses coating.
//!
//! Both measure the tool over the columns, let the model say what the pressure is, and try how far the tool is lifted until the
//! controller has the force that it wants. They differ in where in the step they measure, and in what they take from the work.

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
pub(crate) trait Scheme {
    /// Whether the surface recedes: then what was read of it is written back, and read anew.
    fn recedes(&self) -> bool;

    /// How far a tool may go, over voxels of a size [m].
    fn pace(&self, pass: &Pass, voxel: f64) -> Pace;

    /// The part of the surface to be read next, and its lowest corner [m up].
    fn next_window(&self, ahead: &Ahead) -> (Window, f64);

    /// How far below the tool the surface is sought [m] while the tool is at work.
    fn below(&self, search_reach: f64, voxel: f64) -> f64;

    /// Looks at a region of the sheet from now on.
    fn look_at(&mut self, region: Region);

    /// Forgets the step before: its sheet is put aside.
    fn leave_sheet(&mut self);

    /// Whether the step goes on with what the one before left, so that its start is in balance.
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

    /// Whether that force is the mean over the step, not the one at its end.
    fn is_mean(&self) -> bool;

    /// Largest depth under the working surface there [m], negative: the gap.
    fn gap(&self, place: &Placement, sheet: &Sheet) -> f64;

    /// Whether the patch may go on beyond the region.
    fn reaches_border(&self, sheet: &Sheet) -> bool;

    /// Completes the step of `dt` [s] with the tool at `middle` on its way, once its force is the one that is sought.
    fn complete(&mut self, middle: &Placement, sheet: &Sheet, physics: &mut Physics, dt: f64) -> Result<(), RunError>;

    /// What the step does to the cells in contact.
    fn step(&self) -> ContactStep<'_>;

    /// Applies the step to a sheet and its `coating` [m].
    fn apply(&mut self, sheet: &mut Sheet, coating: f64) -> Applied;
}

/// The scheme of a model.
pub(crate) fn scheme_of(physics: &Physics) -> Box<dyn Scheme> {
    if physics.grinds() { Box::<Grinding>::default() } else { Box::<Sanding>::default() }
}

/// How far a tool may go.
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

/// What a tool may meet on its way on.
pub(crate) struct Ahead<'a> {
    /// The tool.
    pub(crate) tool: &'a Tool,
    /// Extent of the contact.
    pub(crate) extent: Extent,
    /// Voxel of the field [m].
    pub(crate) voxel: f64,
    /// How far the tool may go.
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

/// What a step took off.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Applied {
    /// Volumes removed from the part and from its coating.
    pub(crate) removal: Removal,
    /// How far at most a column has receded since the sheet was read [m].
    pub(crate) receded: f64,
}
