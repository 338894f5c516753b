//! The robot's frame: converts places in the scans' frame to logged places.

use std::f64::consts::TAU;

use glam::DVec2;

use super::robot::Robot;
use random::Stream;

/// Shift and rotation of the robot's frame relative to that of the scans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    shift: DVec2,
    /// Cosine and sine of the rotation.
    turn: DVec2,
    centre: DVec2,
}

impl Frame {
    /// The frame of a campaign's robot.
    ///
    /// - `centre`: centre of the rotation [m]
    pub(super) fn of(robot: &Robot, seed: u64, centre: DVec2) -> Self {
        let mut stream = Stream::of(seed, "frame");
        let shift = robot.frame_shift * DVec2::from_angle(stream.between([0.0, TAU]));
        let sense = if stream.happens(0.5) { 1.0 } else { -1.0 };
        Self { shift, turn: DVec2::from_angle(sense * robot.frame_turn), centre }
    }

    /// Logged position of a place [m].
    pub(super) fn logged(&self, place: DVec2) -> DVec2 {
        let arm = place - self.centre;
        // A frame without offset leaves every bit unchanged.
        place + (self.turn.rotate(arm) - arm) + self.shift
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_off_by_its_shift_and_its_turn_and_a_good_one_by_nothing() {
        let centre = DVec2::new(20e-3, 1e-3);
        let robot = Robot { frame_shift: 0.5e-3, frame_turn: 2e-3, ..Robot::clean() };
        let [one, other] = [3, 4].map(|seed| Frame::of(&robot, seed, centre));
        assert_ne!(one, other, "each campaign has its own");
        for frame in [one, other] {
            assert!((frame.logged(centre).distance(centre) - 0.5e-3).abs() < 1e-12);
            let arm = frame.logged(centre + 10e-3 * DVec2::X) - frame.logged(centre);
            assert!((arm.length() - 10e-3).abs() < 1e-12 && (arm.y.abs() - 20e-6).abs() < 1e-10, "{arm}");
        }
        let place = DVec2::new(3e-3, -2e-3);
        assert_eq!(Frame::of(&Robot::clean(), 3, centre).logged(place), place);
    }
}
