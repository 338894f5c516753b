//! A weld to be finished: the part around it, what it should become, and the curve that the tool follows.

use effects::Process;
use glam::DVec3;
use sdf_bake::BrickGrid;
use sdf_bake::channels::Scalar;

use crate::curve::Curve;
use crate::error::EnvironmentError;
use crate::strip::Strip;

/// Room around the weld that is kept of the part [m]: the tool never reads the surface beyond.
const ROOM: f64 = 25e-3;
/// Half width of the strip that is looked at, in widths of the weld.
const HALF_WIDTHS: f64 = 0.75;
/// Least volume of a bead [m³].
const LEAST_VOLUME: f64 = 1e-9;

/// Sizes of a weld.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeldFacts {
    /// Width between the toes [m].
    pub width: f64,
    /// Height of the crown above the surface [m].
    pub height: f64,
}

/// A weld to be finished.
#[derive(Clone, Debug)]
pub struct Task {
    /// Grinding takes the bead off; sanding takes the coating off a strip where the bead was.
    pub process: Process,
    /// The workpiece around the weld, before.
    pub part: BrickGrid,
    /// The weld's sizes.
    pub weld: WeldFacts,
    /// Centreline of the weld.
    pub curve: Curve,
    /// The strip along it, before.
    pub strip: Strip,
    /// Volume above the target in it [m³].
    pub volume: f64,
}

impl Task {
    /// The task to grind a weld off a part, down to the `target` that the part was.
    ///
    /// - `points`: positions [m] and normals of the centreline, in order
    ///
    /// # Errors
    /// A curve that cannot be followed, or a weld that adds nothing to the target.
    pub fn grinding(
        welded: &BrickGrid,
        target: &BrickGrid,
        weld: WeldFacts,
        points: &[(DVec3, DVec3)],
    ) -> Result<Self, EnvironmentError> {
        let curve = Curve::new(points)?;
        let part = around(welded, &curve);
        let strip = Strip::new(&curve, (target, &part), HALF_WIDTHS * weld.width, 2.0 * weld.height);
        let [volume, _] = strip.volumes();
        if volume.is_nan() || volume < LEAST_VOLUME {
            return Err(EnvironmentError::Nothing { why: "the bead stands nowhere above the target" });
        }
        Ok(Self { process: Process::Grinding, part, weld, curve, strip, volume })
    }

    /// The task to sand the coating off a strip of a part along a weld that was ground flush.
    ///
    /// # Errors
    /// As [`Task::grinding`].
    pub fn sanding(target: &BrickGrid, weld: WeldFacts, points: &[(DVec3, DVec3)]) -> Result<Self, EnvironmentError> {
        let curve = Curve::new(points)?;
        let mut part = around(target, &curve);
        part.scalar_or_zero(Scalar::Dose);
        let strip = Strip::new(&curve, (target, &part), HALF_WIDTHS * weld.width, 2.0 * weld.height);
        if strip.count() == 0 {
            return Err(EnvironmentError::Nothing { why: "the strip lies nowhere on the part" });
        }
        Ok(Self { process: Process::Sanding, part, weld, curve, strip, volume: 0.0 })
    }
}

/// The bricks of a field near a curve.
fn around(grid: &BrickGrid, curve: &Curve) -> BrickGrid {
    let positions = || curve.stations().iter().map(|station| station.position);
    let low = positions().fold(DVec3::INFINITY, DVec3::min) - ROOM;
    let high = positions().fold(DVec3::NEG_INFINITY, DVec3::max) + ROOM;
    grid.within(low, high)
}
