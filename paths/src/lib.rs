//! Planned tool paths: along a weld, in lines over a patch of a part's top, or in patterns where a pad lies flat.
//!
//! A plan is a list of [`Leg`]s on the surface ([`along_weld`], [`raster`]). [`Plan::timed`] adds approach and
//! retract, gives every leg a trapezoidal speed ([`speed`]) and samples tool poses at a fixed period, as a log in
//! the trial format: the force column then holds the setpoint, and 0 in the air. A [`Pattern`] is the way of a pad over
//! the [`PadPatch`] in which it lies flat, in stages of one length. [`program`] turns plans into programs of robots and
//! back.

mod pad_patch;
mod pattern;
pub mod program;
mod raster;
pub mod speed;
mod timing;
mod weld;

use glam::DVec3;
use thiserror::Error;

use robot::Tool;

pub use pad_patch::{PadPatch, PadRest, PatchError};
pub use pattern::{Pattern, Stroke};
pub use raster::{LineDirection, Raster, raster};
pub use weld::along_weld;

/// A point that the tool should touch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// Place on the surface [m].
    pub contact: DVec3,
    /// Approach axis, unit, out of the part.
    pub approach: DVec3,
}

/// A stretch that the tool travels from standstill to standstill.
#[derive(Clone, Debug, PartialEq)]
pub struct Leg {
    /// At least two points that differ.
    pub points: Vec<Waypoint>,
    /// Whether the tool is pressed on.
    pub pressed: bool,
}

/// Legs in their order, each starting where the one before ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// From the first to the last contact.
    pub legs: Vec<Leg>,
}

/// How a plan is travelled.
#[derive(Clone, Debug, PartialEq)]
pub struct Travel {
    /// The tool; its approach side touches the waypoints.
    pub tool: Tool,
    /// Speed along a leg [m/s].
    pub feed: f64,
    /// Way over which a leg's speed rises from and falls to zero [m].
    pub ramp: f64,
    /// Height above the surface where the path starts and ends [m].
    pub clearance: f64,
    /// Time between two rows [s].
    pub period: f64,
    /// Force while pressed on [N].
    pub force: f64,
    /// Spindle speed [rad/s].
    pub spindle_speed: f64,
}

/// Why no path can be planned.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PlanError {
    /// A curve without a length, or with a normal that is none.
    #[error("point {point} of the weld's curve has no direction: {found}")]
    BadCurve {
        /// Index of the point.
        point: usize,
        /// What was found.
        found: String,
    },
    /// The patch leaves the part.
    #[error(
        "the part has no surface below x {:.3} mm, y {:.3} mm: give a --raster within its top, x {:.3} to {:.3} mm and \
         y {:.3} to {:.3} mm",
        at[0] * 1e3, at[1] * 1e3, low[0] * 1e3, high[0] * 1e3, low[1] * 1e3, high[1] * 1e3
    )]
    OffThePart {
        /// Place without a surface [m].
        at: [f64; 2],
        /// Least x, y of the part [m].
        low: [f64; 2],
        /// Greatest x, y of the part [m].
        high: [f64; 2],
    },
    /// Too many places on the surface.
    #[error(
        "a --spacing-mm of {:?} needs {points:.1e} places on the surface, and {accepted:.0e} are accepted: use a wider one or a \
         smaller --raster",
        1e3 * spacing
    )]
    TooFine {
        /// Places that the lines would touch.
        points: f64,
        /// Places that are accepted.
        accepted: f64,
        /// Distance between lines asked for [m].
        spacing: f64,
    },
    /// Too many rows.
    #[error("{rows:.1e} rows: at most {accepted:.0e} are accepted; use a faster feed or a longer period")]
    TooLong {
        /// Rows that the path would have.
        rows: f64,
        /// Rows that are accepted.
        accepted: f64,
    },
}

impl Leg {
    /// Length of the way [m].
    pub fn length(&self) -> f64 {
        self.points.windows(2).map(|pair| pair[0].contact.distance(pair[1].contact)).sum()
    }
}

impl Plan {
    /// Length of the way on which the tool is pressed on [m].
    pub fn pressed_length(&self) -> f64 {
        self.legs.iter().filter(|leg| leg.pressed).map(Leg::length).sum()
    }
}
