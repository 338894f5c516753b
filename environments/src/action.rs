//! Actions: motion of the tool and its force.

use crate::curve::Curve;

/// Number of values in an action, each from -1 to 1: feed along the weld, feed to its left, rates of roll and pitch,
/// and force.
pub const ACTION: usize = 5;

/// Least distance of a step [m]; below it the tool stays in place.
const LEAST_WAY: f64 = 1e-5;

/// Period of a step, and ranges of speed, tilt and force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Duration of a step [s].
    pub period: f64,
    /// Greatest feed along the weld [m/s].
    pub feed: f64,
    /// Greatest feed across the weld [m/s].
    pub across: f64,
    /// Greatest rate of roll and pitch [rad/s].
    pub turning: f64,
    /// Greatest roll and pitch [rad].
    pub tilt: f64,
    /// Greatest force [N].
    pub force: f64,
    /// Force below which the tool is lifted [N].
    pub least_force: f64,
    /// Greatest rate of change of the setpoint [N/s].
    pub slew: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            period: 0.04,
            feed: 30e-3,
            across: 15e-3,
            turning: 0.5,
            tilt: 0.25,
            force: 60.0,
            least_force: 2.0,
            slew: 400.0,
        }
    }
}

/// Position and tilt of the tool in the frame of the curve, and the setpoint.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Stance {
    /// Arc length [m].
    pub(crate) arc: f64,
    /// Offset to the left of the curve [m].
    pub(crate) offset: f64,
    /// Rotation about the curve [rad].
    pub(crate) roll: f64,
    /// Rotation about the vector to the left [rad].
    pub(crate) pitch: f64,
    /// Setpoint [N]; 0 if the tool is lifted.
    pub(crate) setpoint: f64,
}

impl Stance {
    /// Returns the stance after a step under an action. NaN counts as 0; other values are clamped to -1 to 1.
    pub(crate) fn after(&self, action: &[f32; ACTION], limits: &Limits, (curve, half_width): (&Curve, f64)) -> Self {
        let [along, across, roll, pitch, force] = action.map(|value| {
            let value = f64::from(value);
            if value.is_nan() { 0.0 } else { value.clamp(-1.0, 1.0) }
        });
        let Limits { period, feed, across: sideways, turning, tilt, .. } = *limits;
        let wanted = 0.5 * (force + 1.0) * limits.force;
        let change = limits.slew * period;
        let setpoint = match wanted >= limits.least_force {
            true => (wanted.clamp(self.setpoint - change, self.setpoint + change)).max(limits.least_force),
            false => 0.0,
        };
        let arc = (self.arc + along * feed * period).clamp(0.0, curve.length());
        let offset = (self.offset + across * sideways * period).clamp(-half_width, half_width);
        let stands = (arc - self.arc).hypot(offset - self.offset) < LEAST_WAY;
        let (arc, offset) = if stands { (self.arc, self.offset) } else { (arc, offset) };
        Self {
            arc,
            offset,
            roll: (self.roll + roll * turning * period).clamp(-tilt, tilt),
            pitch: (self.pitch + pitch * turning * period).clamp(-tilt, tilt),
            setpoint,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_stance_moves_as_fast_as_the_limits_say_and_stays_within_them() {
        let curve = Curve::new(&[(DVec3::ZERO, DVec3::Z), (DVec3::X * 0.01, DVec3::Z)]).unwrap();
        let limits = Limits::default();
        let once = Stance::default().after(&[0.5, -1.0, 1.0, 0.0, 1.0], &limits, (&curve, 5e-3));
        assert!((once.arc - 0.6e-3).abs() < 1e-12 && (once.offset + 0.6e-3).abs() < 1e-12);
        assert!((once.roll - 0.02).abs() < 1e-12 && once.pitch == 0.0 && once.setpoint == 16.0);
        let mut stance = once;
        for _ in 0..100 {
            stance = stance.after(&[f32::INFINITY, -9.0, 1.0, f32::NAN, 1.0], &limits, (&curve, 5e-3));
        }
        assert_eq!(stance, Stance { arc: curve.length(), offset: -5e-3, roll: 0.25, pitch: 0.0, setpoint: 60.0 });
        let hardly = once.after(&[1e-3, 0.0, 0.0, 0.0, 0.0], &limits, (&curve, 5e-3));
        assert_eq!((hardly.arc, hardly.offset), (once.arc, once.offset), "so slow a tool stands");
        assert_eq!(stance.after(&[0.0, 0.0, 0.0, 0.0, -1.0], &limits, (&curve, 5e-3)).setpoint, 0.0);
    }
}
