//! The planned path of a pass: nominal positions of the tool's lowest point over time.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::pose::{Frame, Pose};
use robot::Tool;

/// One point of a curve on the workpiece.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurvePoint {
    /// Position on the surface [m].
    pub position: DVec3,
    /// Outward unit normal: the tool approaches against it.
    pub normal: DVec3,
}

/// One sample of a path.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PathSample {
    /// Since the start of the pass [s].
    pub time: f64,
    /// Nominal contact point [m]; force control moves the tool along `approach` from there.
    pub position: DVec3,
    /// Approach axis, unit, out of the part.
    pub approach: DVec3,
    /// Across the feed, unit: the axis of a wheel.
    pub axis: DVec3,
}

impl PathSample {
    /// Pose of a tool whose lowest point is the nominal contact point.
    pub fn pose(&self, tool: &Tool) -> Pose {
        let frame = match tool {
            Tool::Wheel(_) => Frame::about(self.axis, self.approach),
            _ => Frame::facing(self.approach, self.axis.cross(self.approach)),
        };
        Pose { centre: self.position + frame.z * tool.drop(), approach: self.approach, frame }
    }

    /// A sample of a tool with its reference point at `centre` [m].
    pub fn from_centre(time: f64, centre: DVec3, (approach, axis): (DVec3, DVec3), tool: &Tool) -> Self {
        let sample = Self { time, position: centre, approach, axis };
        let frame = sample.pose(tool).frame;
        Self { position: centre - frame.z * tool.drop(), ..sample }
    }
}

/// Error of a curve that cannot be followed.
#[derive(Debug, thiserror::Error, PartialEq)]
pub enum PathError {
    /// Too few points.
    #[error("the path has {found} distinct points, at least 2 are needed")]
    TooFewPoints {
        /// Number of distinct points.
        found: usize,
    },
    /// A feed that is not positive and finite.
    #[error("the feed is {found} m/s, it must be positive and finite")]
    BadFeed {
        /// Feed given [m/s].
        found: f64,
    },
    /// The wheel's axis is undefined.
    #[error("at point {point} the normal is along the curve or not finite: give normals across the curve")]
    NormalAlongCurve {
        /// Index of the point.
        point: usize,
    },
    /// Samples of a log out of order.
    #[error("sample {sample} is not later than the one before it")]
    TimeNotIncreasing {
        /// Index of the sample.
        sample: usize,
    },
}

/// Samples in order of time, starting at 0; the path is linear between them.
#[derive(Clone, Debug, PartialEq)]
pub struct Path {
    samples: Vec<PathSample>,
}

impl Path {
    /// A path from samples, for instance of a log.
    ///
    /// # Errors
    /// Fewer than two samples, or times that do not increase.
    pub fn from_samples(samples: Vec<PathSample>) -> Result<Self, PathError> {
        if samples.len() < 2 {
            return Err(PathError::TooFewPoints { found: samples.len() });
        }
        let follows = |pair: &[PathSample]| pair[1].time > pair[0].time;
        match samples.windows(2).position(|pair| !follows(pair)) {
            Some(before) => Err(PathError::TimeNotIncreasing { sample: before + 1 }),
            None => Ok(Self { samples }),
        }
    }

    /// Follows a curve at constant `feed` [m/s] with the tool's axis across the curve and its normal.
    ///
    /// # Errors
    /// A feed that is not positive and finite, fewer than two distinct points, or a normal along the curve.
    pub fn along(curve: &[CurvePoint], feed: f64) -> Result<Self, PathError> {
        if !(feed > 0.0 && feed.is_finite()) {
            return Err(PathError::BadFeed { found: feed });
        }
        let mut time = 0.0;
        let mut samples = Vec::with_capacity(curve.len());
        for (i, point) in curve.iter().enumerate() {
            let (before, after) = (curve[i.saturating_sub(1)].position, curve[(i + 1).min(curve.len() - 1)].position);
            let axis = point.normal.cross(after - before).normalize_or_zero();
            let approach = (after - before).cross(axis).normalize_or_zero();
            if !(axis.is_normalized() && approach.is_normalized()) {
                return Err(PathError::NormalAlongCurve { point: i });
            }
            time += (point.position - before).length() / feed;
            samples.push(PathSample { time, position: point.position, approach, axis });
        }
        samples.dedup_by(|later, earlier| later.time <= earlier.time);
        Self::from_samples(samples)
    }

    /// The same path in reverse at the same speeds; the tool is not turned round.
    pub fn reversed(&self) -> Self {
        let end = self.duration();
        let turn = |sample: &PathSample| PathSample { time: end - sample.time, ..*sample };
        Self { samples: self.samples.iter().rev().map(turn).collect() }
    }

    /// The samples, in order of time.
    pub fn samples(&self) -> &[PathSample] {
        &self.samples
    }

    /// Time of the last sample [s].
    pub fn duration(&self) -> f64 {
        self.samples.last().map_or(0.0, |sample| sample.time)
    }

    /// Length of the path [m].
    pub fn length(&self) -> f64 {
        self.samples.windows(2).map(|pair| (pair[1].position - pair[0].position).length()).sum()
    }

    /// Velocity along the path at a time [m/s].
    pub fn velocity(&self, time: f64) -> DVec3 {
        self.piece_velocity(self.piece(time))
    }

    /// Number of straight segments, each between two samples.
    pub(crate) fn pieces(&self) -> usize {
        self.samples.len() - 1
    }

    /// Index of the segment at a time; a sample's own time belongs to the segment after it.
    pub(crate) fn piece(&self, time: f64) -> usize {
        self.samples.partition_point(|sample| sample.time <= time).clamp(1, self.pieces()) - 1
    }

    /// Velocity on a segment [m/s].
    pub(crate) fn piece_velocity(&self, piece: usize) -> DVec3 {
        let (a, b) = (&self.samples[piece], &self.samples[piece + 1]);
        (b.position - a.position) / (b.time - a.time)
    }

    /// Returns true if the velocity stays within a `share` of that on a segment, up to a `span` [s] after it.
    pub(crate) fn is_steady(&self, piece: usize, share: f64, span: f64) -> bool {
        let (velocity, end) = (self.piece_velocity(piece), self.samples[piece + 1].time + span);
        (piece + 1..self.pieces())
            .take_while(|&next| self.samples[next].time < end)
            .all(|next| (self.piece_velocity(next) - velocity).length() <= share * velocity.length())
    }

    /// The path at a time [s], constant beyond its ends.
    pub fn at(&self, time: f64) -> PathSample {
        let piece = self.piece(time);
        let (a, b) = (&self.samples[piece], &self.samples[piece + 1]);
        let t = ((time - a.time) / (b.time - a.time)).clamp(0.0, 1.0);
        let approach = a.approach.lerp(b.approach, t).normalize();
        let axis = a.axis.lerp(b.axis, t).normalize();
        PathSample { time, position: a.position.lerp(b.position, t), approach, axis }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use robot::Wheel;

    fn straight() -> Vec<CurvePoint> {
        (0..5).map(|i| CurvePoint { position: DVec3::X * 0.01 * f64::from(i), normal: DVec3::Z }).collect()
    }

    #[test]
    fn a_straight_curve_is_followed_at_the_feed_with_the_axis_across() {
        let path = Path::along(&straight(), 0.005).unwrap();
        assert!((path.duration() - 8.0).abs() < 1e-12);
        let sample = path.at(3.0);
        assert!((sample.position - DVec3::X * 0.015).length() < 1e-12);
        assert_eq!((sample.approach, sample.axis), (DVec3::Z, DVec3::Y));
        let wheel = Tool::from(Wheel::cylinder(0.05, 0.02));
        assert!((sample.pose(&wheel).centre - sample.position - DVec3::Z * 0.05).length() < 1e-15);
        assert!((path.velocity(3.0) - DVec3::X * 0.005).length() < 1e-15);
        let back = path.reversed();
        assert!((back.at(3.0).position - DVec3::X * 0.025).length() < 1e-12);
        assert_eq!(back.at(3.0).pose(&wheel).frame.x, DVec3::X);
        assert!((back.velocity(3.0) + DVec3::X * 0.005).length() < 1e-15);
    }

    #[test]
    fn a_feed_is_steady_until_it_changes_within_the_span() {
        let place = |time: f64| DVec3::new(time.min(1.0), (time - 1.0).max(0.0), 0.0) * 0.01;
        let sample = |time: f64| PathSample { time, position: place(time), approach: DVec3::Z, axis: DVec3::Y };
        let path = Path::from_samples((0..=20).map(|k| sample(0.1 * f64::from(k))).collect()).unwrap();
        let steady: Vec<bool> = (0..path.pieces()).map(|piece| path.is_steady(piece, 0.05, 0.25)).collect();
        // The corner is at the end of segment 9, 0.2 s after that of segment 7.
        let expected: Vec<bool> = (0..20).map(|piece| !(7..=9).contains(&piece)).collect();
        assert_eq!(steady, expected);
    }

    #[test]
    fn curves_that_cannot_be_followed_are_refused_with_the_reason() {
        assert_eq!(Path::along(&straight()[..1], 0.005), Err(PathError::NormalAlongCurve { point: 0 }));
        assert_eq!(Path::along(&[], 0.005), Err(PathError::TooFewPoints { found: 0 }));
        assert!(matches!(Path::along(&straight(), f64::NAN), Err(PathError::BadFeed { .. })));
        let mut bad = straight();
        bad[2].normal = DVec3::X;
        assert_eq!(Path::along(&bad, 0.005), Err(PathError::NormalAlongCurve { point: 2 }));
        bad[2].normal = DVec3::NAN;
        assert_eq!(Path::along(&bad, 0.005), Err(PathError::NormalAlongCurve { point: 2 }));
    }
}
