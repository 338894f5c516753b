//! Planned tool paths: along a weld, in parallel lines over a patch of a part's top, or as patterns for a flat pad.
//!
//! A plan is a list of [`Leg`]s on the surface ([`along_weld`], [`raster`]). [`Plan::timed`] adds approach and retract,
//! gives every leg a trapezoidal speed profile ([`speed`]) and samples tool poses at a fixed period. The result is a
//! log in the trial format, whose force column holds the setpoint, and 0 in the air. A [`Pattern`] is the path of a pad
//! over the [`PadPatch`] on which it lies flat, divided into stages of equal length. [`program`] converts plans to
//! robot programs and back.

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

/// A point on the surface that the tool touches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint {
    /// Position on the surface [m].
    pub contact: DVec3,
    /// Approach axis, unit vector, out of the part.
    pub approach: DVec3,
}

/// A stretch that the tool travels from standstill to standstill.
#[derive(Clone, Debug, PartialEq)]
pub struct Leg {
    /// At least two distinct points.
    pub points: Vec<Waypoint>,
    /// True if the tool presses on the surface.
    pub pressed: bool,
}

/// Legs in order, each starting where the previous one ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Legs from the first to the last contact.
    pub legs: Vec<Leg>,
}

/// Tool, speeds and setpoints with which a plan is executed.
#[derive(Clone, Debug, PartialEq)]
pub struct Travel {
    /// The tool; its approach side touches the waypoints.
    pub tool: Tool,
    /// Speed along a leg [m/s].
    pub feed: f64,
    /// Distance over which a leg's speed rises from zero, and over which it falls to zero [m].
    pub ramp: f64,
    /// Height above the surface where the path starts and ends [m].
    pub clearance: f64,
    /// Sampling period of the log [s].
    pub period: f64,
    /// Force while pressed on [N].
    pub force: f64,
    /// Spindle speed [rad/s].
    pub spindle_speed: f64,
}

/// Reason why no path can be planned.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PlanError {
    /// A curve of zero length, or a normal that is not finite or lies along the curve.
    #[error("point {point} of the weld's curve has no direction: {found}")]
    BadCurve {
        /// Index of the point.
        point: usize,
        /// Description of the fault.
        found: String,
    },
    /// The patch extends beyond the part.
    #[error(
        "the part has no surface below x {:.3} mm, y {:.3} mm: give a --raster within its top, x {:.3} to {:.3} mm and \
         y {:.3} to {:.3} mm",
        at[0] * 1e3, at[1] * 1e3, low[0] * 1e3, high[0] * 1e3, low[1] * 1e3, high[1] * 1e3
    )]
    OffThePart {
        /// Position without a surface below it [m].
        at: [f64; 2],
        /// Least x, y of the part [m].
        low: [f64; 2],
        /// Greatest x, y of the part [m].
        high: [f64; 2],
    },
    /// Too many surface points.
    #[error(
        "a --spacing-mm of {:?} needs {points:.1e} places on the surface, and {accepted:.0e} are accepted: use a wider one or a \
         smaller --raster",
        1e3 * spacing
    )]
    TooFine {
        /// Surface points that the lines need.
        points: f64,
        /// Greatest accepted number of surface points.
        accepted: f64,
        /// Requested distance between lines [m].
        spacing: f64,
    },
    /// Too many log rows.
    #[error("{rows:.1e} rows: at most {accepted:.0e} are accepted; use a faster feed or a longer period")]
    TooLong {
        /// Rows that the path would have.
        rows: f64,
        /// Greatest accepted number of rows.
        accepted: f64,
    },
}

impl Leg {
    /// Length of the leg [m].
    pub fn length(&self) -> f64 {
        self.points.windows(2).map(|pair| pair[0].contact.distance(pair[1].contact)).sum()
    }
}

impl Plan {
    /// Length of the path on which the tool presses on the surface [m].
    pub fn pressed_length(&self) -> f64 {
        self.legs.iter().filter(|leg| leg.pressed).map(Leg::length).sum()
    }
}
