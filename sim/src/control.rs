//! Ideal force control: the travel along the approach axis at which the contact force is the setpoint.

use sdf_bake::BrickGrid;

use crate::contact::{Contact, LONGEST, Patch, PatchExtent};
use crate::tool::{Pose, Wheel};

/// Relative difference between force and setpoint that is good enough.
pub const FORCE_TOLERANCE: f64 = 1e-6;

/// Evaluations of the force before the best travel so far is taken.
const EVALUATIONS: usize = 60;

/// Patches sampled before the search gives up; from a voxel, growing and sinking need about 30.
const ROUNDS: usize = 100;

/// Where to start, and how far to go.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// Travel near which the balance is expected [m]; coming from the air, [`Search::reach`].
    pub travel: f64,
    /// Surface to sample, and how far below `travel` to look at first; grown until the setpoint is met.
    pub extent: PatchExtent,
    /// The wheel is sought between this far above the nominal pose and this far below it [m].
    pub reach: f64,
}

impl Search {
    /// A search that comes down from the air.
    pub fn from_air(wheel: &Wheel, reach: f64) -> Self {
        let length = 0.1 * wheel.radius;
        Self { travel: reach, extent: PatchExtent { front: length, back: length, sink: 0.1 * reach }, reach }
    }
}

/// The wheel in balance.
pub struct Balance {
    /// Travel from the nominal pose [m].
    pub travel: f64,
    /// The patch, sampled at the nominal pose lifted by `sampled_at`.
    pub patch: Patch,
    /// Travel at which the patch was sampled [m].
    pub sampled_at: f64,
    /// Force, moment, area and pressure.
    pub contact: Contact,
}

impl Balance {
    /// Travel from the pose at which the patch was sampled [m]: what [`Patch`]'s functions take.
    pub fn patch_travel(&self) -> f64 {
        self.travel - self.sampled_at
    }
}

/// Finds the travel at which the wheel meets `setpoint` [N] with stiffness K [Pa/m]; `None` where there is
/// nothing to press against within reach.
pub fn balance_force(
    grid: &BrickGrid,
    wheel: &Wheel,
    nominal: &Pose,
    (stiffness, setpoint): (f64, f64),
    search: Search,
) -> Option<Balance> {
    let mut at = search.travel.clamp(-search.reach, search.reach);
    let mut extent = search.extent;
    let longest = |extent: PatchExtent| extent.front.min(extent.back) >= LONGEST * wheel.radius;
    for _ in 0..ROUNDS {
        let patch = Patch::find(grid, wheel, &nominal.lifted(at), extent);
        if patch.contact(-extent.sink, stiffness).force >= setpoint {
            let travel = solve(&patch, stiffness, setpoint, (-extent.sink, 0.1 * grid.voxel));
            if patch.is_whole(travel) || longest(extent) {
                let contact = patch.contact(travel, stiffness);
                return Some(Balance { travel: at + travel, patch, sampled_at: at, contact });
            }
            extent = extent.grown();
        } else if !patch.is_whole(-extent.sink) && !longest(extent) {
            extent = extent.grown();
        } else if at > -search.reach {
            at -= extent.sink;
            extent.sink *= 2.0;
        } else {
            return None;
        }
    }
    None
}

/// Travel at which the patch meets the setpoint: Newton's steps, kept between the travels known to be too
/// low and too high. `low` is one at which the force is at least the setpoint.
fn solve(patch: &Patch, stiffness: f64, setpoint: f64, (mut low, stride): (f64, f64)) -> f64 {
    let mut high = f64::INFINITY;
    let mut travel = f64::max(low, 0.0);
    for _ in 0..EVALUATIONS {
        let contact = patch.contact(travel, stiffness);
        let excess = contact.force - setpoint;
        if excess.abs() <= FORCE_TOLERANCE * setpoint {
            return travel;
        }
        if excess > 0.0 {
            low = low.max(travel)
        } else {
            high = high.min(travel)
        }
        // dF/dz = -K A: the depth grows over the whole patch at once.
        let newton = travel + excess / (stiffness * contact.area.max(f64::MIN_POSITIVE));
        let step = if contact.area > 0.0 { newton } else { travel + patch.depth_max(travel) - 1e-3 * stride };
        travel = if step > low && step < high {
            step
        } else if high.is_finite() {
            0.5 * (low + high)
        } else {
            travel + stride
        };
    }
    low
}
