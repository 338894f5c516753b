//! A weld to be finished: the part around it, the target, and the curve that the tool follows.

use effects::Process;
use glam::DVec3;
use sdf_bake::BrickGrid;
use sdf_bake::channels::Scalar;

use crate::curve::Curve;
use crate::error::EnvironmentError;
use crate::strip::Strip;

/// Margin of the part kept around the weld [m]; the tool never reads the surface beyond it.
const MARGIN: f64 = 25e-3;
/// Half width of the strip [weld widths].
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
    /// Process: grinding removes the bead; sanding removes the coating from a strip in place of the bead.
    pub process: Process,
    /// Workpiece around the weld, before finishing.
    pub part: BrickGrid,
    /// Sizes of the weld.
    pub weld: WeldFacts,
    /// Centreline of the weld.
    pub curve: Curve,
    /// Strip along the weld, before finishing.
    pub strip: Strip,
    /// Volume above the target in the strip [m³].
    pub volume: f64,
}

impl Task {
    /// Makes the task to grind a weld off a part, down to the `target`, the part before welding.
    ///
    /// - `points`: positions [m] and normals of the centreline, in order
    ///
    /// # Errors
    /// If the curve cannot be followed, or the weld adds nothing to the target.
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

    /// Makes the task to sand the coating off a strip of a part, along a weld that was ground flush.
    ///
    /// # Errors
    /// Those of [`Task::grinding`].
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

/// Returns the bricks of a field near a curve.
fn around(grid: &BrickGrid, curve: &Curve) -> BrickGrid {
    let positions = || curve.stations().iter().map(|station| station.position);
    let low = positions().fold(DVec3::INFINITY, DVec3::min) - MARGIN;
    let high = positions().fold(DVec3::NEG_INFINITY, DVec3::max) + MARGIN;
    grid.within(low, high)
}
