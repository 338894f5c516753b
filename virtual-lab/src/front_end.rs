//! Front ends: errors of scanner, robot and tool in addition to the hidden effects.

use serde::{Deserialize, Serialize};

use super::{Experiment, Instrument, Robot};
use trials::trial::ForceInput;

/// Errors of scanner, robot and tool in addition to the hidden effects.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FrontEnd {
    /// Small errors, as in a careful laboratory.
    #[default]
    Clean,
    /// Larger errors of scanner and robot.
    Hard,
    /// The robot's frame is shifted by 0.5 mm and turned by 2 mrad against that of the scans.
    Frame,
    /// The logged places are 80 ms older than the forces in the same row.
    Clock,
    /// The force oscillates by 10 % about its mean.
    Ripple,
    /// Surfaces have a texture that differs from scan to scan: grinding marks of 4 µm, coatings like orange peel.
    Texture,
    /// The tool made two passes on another workpiece before each trial, and counts as fresh.
    Worn,
    /// No surface is scanned twice.
    Once,
    /// The part is clamped again for each scan, shifted by 20 µm and turned by 2 mrad.
    Clamped,
    /// The force oscillates by 10 % about its mean, and the trials state that the logged force is followed.
    Logged,
    /// A workshop: errors of frame and clock, ripple and worn tool together.
    Shop,
}

impl FrontEnd {
    /// All front ends.
    pub const ALL: [Self; 11] = [
        Self::Clean,
        Self::Hard,
        Self::Frame,
        Self::Clock,
        Self::Ripple,
        Self::Texture,
        Self::Worn,
        Self::Once,
        Self::Clamped,
        Self::Logged,
        Self::Shop,
    ];

    /// Word in files and tables.
    pub fn word(self) -> &'static str {
        match self {
            Self::Clean => "clean",
            Self::Hard => "hard",
            Self::Frame => "frame",
            Self::Clock => "clock",
            Self::Ripple => "ripple",
            Self::Texture => "texture",
            Self::Worn => "worn",
            Self::Once => "once",
            Self::Clamped => "clamped",
            Self::Logged => "logged",
            Self::Shop => "shop",
        }
    }

    /// Description in a few words, as help texts print it.
    pub fn about(self) -> &'static str {
        match self {
            Self::Clean => "A careful laboratory",
            Self::Hard => "More of every error: drop-outs, spikes, shifts, noise",
            Self::Frame => "The robot's frame is off by 0.5 mm and 2 mrad",
            Self::Clock => "Logged places are 80 ms older than forces",
            Self::Ripple => "The force swings by 10 %",
            Self::Texture => "Grinding marks, coatings like orange peel",
            Self::Worn => "The tool worked before each trial",
            Self::Once => "No surface is scanned twice",
            Self::Clamped => "The part is turned by 2 mrad from scan to scan",
            Self::Logged => "The force swings, and the logged one leads",
            Self::Shop => "Frame, clock, ripple and worn tool at once",
        }
    }

    /// Errors of the scanner.
    pub fn instrument(self) -> Instrument {
        match self {
            Self::Hard => Instrument::hard(),
            Self::Texture => Instrument::textured(),
            Self::Clamped => Instrument::clamped(),
            _ => Instrument::clean(),
        }
    }

    /// Errors of the robot.
    pub fn robot(self) -> Robot {
        let clean = Robot::clean();
        match self {
            Self::Hard => Robot::hard(),
            Self::Frame => Robot { frame_shift: 0.5e-3, frame_turn: 2e-3, ..clean },
            Self::Clock => Robot { pose_delay: 0.08, ..clean },
            Self::Ripple | Self::Logged => Robot { force_ripple: 0.1, ..clean },
            Self::Shop => Robot { frame_shift: 0.5e-3, frame_turn: 2e-3, pose_delay: 0.08, force_ripple: 0.1, ..clean },
            _ => clean,
        }
    }

    /// Number of passes of the tool before each trial.
    pub fn earlier_passes(self) -> usize {
        if matches!(self, Self::Worn | Self::Shop) { 2 } else { 0 }
    }
}

impl Experiment {
    /// The same experiment with another front end.
    #[must_use]
    pub fn behind(self, front: FrontEnd) -> Self {
        let (instrument, robot, earlier_passes) = (front.instrument(), front.robot(), front.earlier_passes());
        let repeats = if front == FrontEnd::Once { 0 } else { 1 };
        let force_input = if front == FrontEnd::Logged { ForceInput::Log } else { ForceInput::Setpoint };
        Self { instrument, robot, earlier_passes, repeats, force_input, ..self }
    }
}
