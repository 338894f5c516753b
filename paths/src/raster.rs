//! Parallel lines over a rectangular patch of a part's top.

use glam::{DVec2, DVec3};
use sdf_bake::{BrickGrid, PixelGrid};
use sim::Profilometer;

use super::{Leg, Plan, PlanError, Waypoint};

/// Greatest number of surface points of a raster: about a minute of computing.
const MOST_POINTS: f64 = 1e7;

/// Direction of the lines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineDirection {
    /// Along x.
    X,
    /// Along y.
    Y,
}

/// A patch and the lines that cover it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Raster {
    /// Least x, y [m].
    pub low: DVec2,
    /// Greatest x, y [m].
    pub high: DVec2,
    /// Greatest distance between lines [m]; they are spread evenly from border to border.
    pub spacing: f64,
    /// Direction of the lines.
    pub direction: LineDirection,
    /// True for alternating directions without lifting; otherwise all lines run the same way and the tool returns in
    /// the air.
    pub zigzag: bool,
    /// Height of the return in the air [m].
    pub clearance: f64,
}

/// Plans lines over the top of a part, with approach axis +z.
///
/// # Errors
/// [`PlanError::OffThePart`] if the part has no surface below a line.
pub fn raster(part: &BrickGrid, raster: &Raster) -> Result<Plan, PlanError> {
    let lines = raster.lines(part)?;
    let mut legs: Vec<Leg> = Vec::new();
    for (k, mut line) in lines.into_iter().enumerate() {
        if raster.zigzag && k % 2 == 1 {
            line.reverse();
        }
        if let Some(end) = legs.last().and_then(|leg| leg.points.last()).copied() {
            let start = line[0];
            if raster.zigzag {
                legs.push(Leg { points: vec![end, start], pressed: true });
            } else {
                legs.extend(raster.way_back(end, start));
            }
        }
        legs.push(Leg { points: line, pressed: true });
    }
    Ok(Plan { legs })
}

impl Raster {
    /// Number of lines.
    pub fn count(&self) -> usize {
        let across = self.high - self.low;
        let width = if self.direction == LineDirection::X { across.y } else { across.x };
        // A width of a whole number of spacings stays whole in floating point.
        1 + (width / self.spacing - 1e-9).ceil().max(0.0) as usize
    }

    /// Returns the lines on the surface, all in the direction of rising coordinates.
    fn lines(&self, part: &BrickGrid) -> Result<Vec<Vec<Waypoint>>, PlanError> {
        let across = self.high - self.low;
        let count = self.count();
        let length = if self.direction == LineDirection::X { across.x } else { across.y };
        let points = count as f64 * (length / part.voxel + 2.0);
        if points > MOST_POINTS {
            return Err(PlanError::TooFine { points, accepted: MOST_POINTS, spacing: self.spacing });
        }
        let step = 1.0 / (count as f64 - 1.0).max(1.0);
        (0..count)
            .map(|k| {
                let t = k as f64 * step;
                let (from, to) = match self.direction {
                    LineDirection::X => (DVec2::new(0.0, t), DVec2::new(1.0, t)),
                    LineDirection::Y => (DVec2::new(t, 0.0), DVec2::new(t, 1.0)),
                };
                self.line(part, self.low + across * from, self.low + across * to)
            })
            .collect()
    }

    /// Returns points on the surface from `from` to `to` [m], about one voxel apart.
    fn line(&self, part: &BrickGrid, from: DVec2, to: DVec2) -> Result<Vec<Waypoint>, PlanError> {
        let steps = (from.distance(to) / part.voxel).ceil().max(1.0) as usize;
        (0..=steps)
            .map(|k| {
                let place = from.lerp(to, k as f64 / steps as f64);
                let pixel = PixelGrid { origin: place, pitch: part.voxel, nx: 1, ny: 1 };
                let height = Profilometer::sharp(pixel).heights(part).heights[0];
                let contact = place.extend(height);
                if contact.is_finite() { Ok(Waypoint { contact, approach: DVec3::Z }) } else { Err(off(part, place)) }
            })
            .collect()
    }

    /// Returns the legs in the air: up, across and down again.
    fn way_back(&self, end: Waypoint, start: Waypoint) -> Vec<Leg> {
        let height = end.contact.z.max(start.contact.z) + self.clearance;
        let lifted = |point: Waypoint| Waypoint { contact: point.contact.with_z(height), ..point };
        let ways = [[end, lifted(end)], [lifted(end), lifted(start)], [lifted(start), start]];
        ways.into_iter().map(|points| Leg { points: points.to_vec(), pressed: false }).collect()
    }
}

fn off(part: &BrickGrid, place: DVec2) -> PlanError {
    let side = sdf_bake::grid::BRICK_SIDE as f64 * part.voxel;
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for brick in &part.bricks {
        let corner = brick.truncate().as_dvec2() * side;
        (low, high) = (low.min(corner + f64::from(part.band)), high.max(corner + side - f64::from(part.band)));
    }
    PlanError::OffThePart { at: place.to_array(), low: low.to_array(), high: high.to_array() }
}
