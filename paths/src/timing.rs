//! Converts legs on the surface to timed tool poses.

use glam::DVec3;

use super::speed::Trapezoid;
use super::{Leg, Plan, PlanError, Travel, Waypoint};
use robot::{LogRow, Tool};
use trials::trial::Log;

/// Greatest number of rows of a path.
const MOST_ROWS: f64 = 1e6;

/// A leg with its motion.
struct Motion<'a> {
    leg: &'a Leg,
    /// Distance of each point from the leg's first point, along the leg [m].
    ways: Vec<f64>,
    speed: Trapezoid,
    start: f64,
}

impl Plan {
    /// Samples the plan as a log: approach from the clearance, all legs, retract; one row per period and one at the
    /// end.
    ///
    /// # Errors
    /// [`PlanError::TooLong`] if there would be too many rows.
    pub fn timed(&self, travel: &Travel) -> Result<Log, PlanError> {
        let legs = self.with_approach(travel.clearance);
        let mut start = 0.0;
        let motions: Vec<Motion> = legs
            .iter()
            .map(|leg| {
                let motion = Motion::of(leg, start, travel);
                start += motion.speed.duration();
                motion
            })
            .collect();
        let rows = start / travel.period;
        if rows.is_nan() || rows > MOST_ROWS {
            return Err(PlanError::TooLong { rows, accepted: MOST_ROWS });
        }
        let steps = (rows - 1e-9).floor() as usize;
        let times = (0..=steps).map(|k| k as f64 * travel.period).chain([start]);
        let rows: Vec<LogRow> = times.map(|time| row(&motions, time, travel)).collect();
        let has_approach = rows.iter().any(|row| row.approach.distance(DVec3::Z) > 1e-9);
        Ok(Log { rows, has_approach, ..Log::default() })
    }

    /// Adds a leg from the air to the surface before the legs, and one back to the air after them.
    fn with_approach(&self, clearance: f64) -> Vec<Leg> {
        let above = |point: Waypoint| Waypoint { contact: point.contact + point.approach * clearance, ..point };
        let first = self.legs.first().and_then(|leg| leg.points.first()).copied();
        let last = self.legs.last().and_then(|leg| leg.points.last()).copied();
        let (Some(first), Some(last)) = (first, last) else { return Vec::new() };
        let in_air = |points: [Waypoint; 2]| Leg { points: points.to_vec(), pressed: false };
        let mut legs = vec![in_air([above(first), first])];
        legs.extend(self.legs.iter().cloned());
        legs.push(in_air([last, above(last)]));
        legs
    }
}

impl<'a> Motion<'a> {
    fn of(leg: &'a Leg, start: f64, travel: &Travel) -> Self {
        let mut ways = vec![0.0];
        for pair in leg.points.windows(2) {
            ways.push(ways[ways.len() - 1] + pair[0].contact.distance(pair[1].contact));
        }
        let speed = Trapezoid::new(ways[ways.len() - 1], travel.feed, travel.ramp);
        Self { leg, ways, speed, start }
    }

    /// Returns the waypoint at a time [s] since the start of the path.
    fn at(&self, time: f64) -> Waypoint {
        let way = self.speed.way(time - self.start);
        let points = &self.leg.points;
        let after = self.ways.partition_point(|&w| w < way).clamp(1, points.len() - 1);
        let (a, b) = (&points[after - 1], &points[after]);
        let t = ((way - self.ways[after - 1]) / (self.ways[after] - self.ways[after - 1]).max(1e-15)).clamp(0.0, 1.0);
        Waypoint { contact: a.contact.lerp(b.contact, t), approach: a.approach.lerp(b.approach, t).normalize() }
    }
}

fn row(motions: &[Motion], time: f64, travel: &Travel) -> LogRow {
    let current = motions.partition_point(|motion| motion.start <= time).saturating_sub(1);
    let motion = &motions[current];
    let Waypoint { contact, approach } = motion.at(time);
    let position = match &travel.tool {
        Tool::Pad(_) => contact,
        tool => contact + approach * tool.drop(),
    };
    let force = if motion.leg.pressed { travel.force } else { 0.0 };
    LogRow { time, position, force, spindle_speed: travel.spindle_speed, approach }
}
