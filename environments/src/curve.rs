//! The curve that a tool follows: a weld's centreline, sampled evenly in arc length.

use glam::DVec3;

use crate::error::EnvironmentError;

/// Distance between stations [m].
const PITCH: f64 = 1e-3;

/// A point on the curve with its frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Station {
    /// Position on the part's surface below the weld [m].
    pub position: DVec3,
    /// Unit normal out of the part.
    pub normal: DVec3,
    /// Unit direction of travel, perpendicular to the normal.
    pub tangent: DVec3,
}

impl Station {
    /// Returns the unit vector to the left of travel.
    pub fn side(&self) -> DVec3 {
        self.normal.cross(self.tangent)
    }
}

/// A weld's centreline with stations every millimetre.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    stations: Vec<Station>,
    pitch: f64,
}

impl Curve {
    /// Makes a curve through points [m] with normals, in order of travel.
    ///
    /// # Errors
    /// [`EnvironmentError::Curve`] for fewer than two points or a length below a millimetre.
    pub fn new(points: &[(DVec3, DVec3)]) -> Result<Self, EnvironmentError> {
        let mut arc = vec![0.0];
        for pair in points.windows(2) {
            arc.push(arc.last().unwrap_or(&0.0) + (pair[1].0 - pair[0].0).length());
        }
        let length = *arc.last().unwrap_or(&0.0);
        if points.len() < 2 || length.is_nan() || length < PITCH {
            return Err(EnvironmentError::Curve { points: points.len(), length: length * 1e3 });
        }
        let pieces = (length / PITCH).round().max(1.0);
        let pitch = length / pieces;
        let place = |k: usize| {
            let at = (k as f64 * pitch).min(length);
            let piece = arc.partition_point(|&end| end <= at).clamp(1, points.len() - 1) - 1;
            let (a, b) = (points[piece], points[piece + 1]);
            let share = ((at - arc[piece]) / (arc[piece + 1] - arc[piece])).clamp(0.0, 1.0);
            Station {
                position: a.0.lerp(b.0, share),
                normal: a.1.lerp(b.1, share).normalize_or(DVec3::Z),
                tangent: (b.0 - a.0).normalize_or(DVec3::X),
            }
        };
        let mut stations: Vec<Station> = (0..=pieces as usize).map(place).collect();
        for station in &mut stations {
            station.tangent = station.tangent.reject_from_normalized(station.normal).normalize_or(DVec3::X);
        }
        Ok(Self { stations, pitch })
    }

    /// Returns the stations in order of travel.
    pub fn stations(&self) -> &[Station] {
        &self.stations
    }

    /// Returns the distance between stations [m].
    pub fn pitch(&self) -> f64 {
        self.pitch
    }

    /// Returns the length [m].
    pub fn length(&self) -> f64 {
        self.pitch * (self.stations.len() - 1) as f64
    }

    /// Returns the station at an arc length [m], clamped to the ends.
    pub fn at(&self, arc: f64) -> Station {
        let at = (arc / self.pitch).clamp(0.0, (self.stations.len() - 1) as f64);
        let before = (at as usize).min(self.stations.len() - 2);
        let (a, b, share) = (&self.stations[before], &self.stations[before + 1], at - before as f64);
        let normal = a.normal.lerp(b.normal, share).normalize();
        let tangent = a.tangent.lerp(b.tangent, share).reject_from_normalized(normal).normalize();
        Station { position: a.position.lerp(b.position, share), normal, tangent }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stations_lie_evenly_on_an_arc_with_orthonormal_frames() {
        let point = |k: i32| {
            let turn = f64::from(k) * 0.05;
            (DVec3::new(turn.sin(), 1.0 - turn.cos(), 0.0) * 0.1, DVec3::Z)
        };
        let curve = Curve::new(&(0..=20).map(point).collect::<Vec<_>>()).unwrap();
        assert!((curve.length() - 0.1).abs() < 1e-4 && (curve.pitch() - 1e-3).abs() < 1e-5);
        for k in 0..=100 {
            let station = curve.at(f64::from(k) * 1e-3);
            assert!((station.side().length() - 1.0).abs() < 1e-12 && station.side().dot(station.tangent).abs() < 1e-12);
            let from_centre = (station.position - DVec3::Y * 0.1).length();
            assert!((from_centre - 0.1).abs() < 5e-5, "{from_centre}");
        }
    }

    #[test]
    fn a_curve_without_length_is_refused() {
        assert!(Curve::new(&[]).is_err());
        assert!(Curve::new(&[(DVec3::ZERO, DVec3::Z); 5]).unwrap_err().to_string().contains("5 points over 0 mm"));
    }
}
