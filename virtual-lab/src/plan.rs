//! Plans: forces, feeds, speeds and directions of the passes of a campaign.

use serde::{Deserialize, Serialize};

use effects::{Process, Signal};
use trials::trial::Role;

/// Plan of a campaign.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Plan {
    /// One trial of two equal passes, the second for evaluation.
    Paper,
    /// Force, feed, spindle speed and direction differ from pass to pass.
    #[default]
    Varied,
    /// One force and one feed; the directions differ.
    Reversed,
    /// The feed steps in the middle of every pass, the force changes from pass to pass.
    Steps,
}

/// One pass, relative to the usual settings of the process.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Setting {
    /// Force, as a factor.
    pub(super) force: f64,
    /// Feed on the first and the second half of the route, as factors.
    pub(super) feeds: [f64; 2],
    /// Spindle speed, as a factor.
    pub(super) speed: f64,
    /// True if the route is travelled backwards.
    pub(super) backwards: bool,
}

/// A pass in one row: force, feed, spindle speed, backwards.
type Row = (f64, f64, f64, bool);

/// Two passes of each trial; after the last entry the list repeats.
const VARIED: [[Row; 2]; 4] = [
    [(1.0, 1.0, 1.0, false), (1.0, 1.0, 1.0, true)],
    [(0.667, 0.8, 1.0, false), (1.333, 1.2, 1.0, true)],
    [(1.0, 1.2, 0.7, false), (0.8, 1.0, 0.85, true)],
    [(1.2, 1.4, 0.9, true), (1.0, 0.8, 1.0, false)],
];
const REVERSED: [[Row; 2]; 4] = [
    [(1.0, 1.0, 1.0, false), (1.0, 1.0, 1.0, true)],
    [(1.0, 1.0, 1.0, true), (1.0, 1.0, 1.0, true)],
    [(1.0, 1.0, 1.0, true), (1.0, 1.0, 1.0, false)],
    [(1.0, 1.0, 1.0, false), (1.0, 1.0, 1.0, false)],
];
/// The feed is faster by the factor [`STEP`] on the second half of forward passes and on the first half of backward
/// passes.
const STEPS: [[Row; 2]; 4] = [
    [(0.667, 0.8, 1.0, false), (1.333, 0.8, 1.0, true)],
    [(1.0, 0.8, 0.7, true), (1.0, 0.8, 1.0, false)],
    [(1.333, 1.0, 1.0, true), (0.667, 0.8, 1.0, false)],
    [(1.2, 1.0, 0.85, false), (0.8, 0.8, 1.0, true)],
];
const STEP: f64 = 1.7;

impl Plan {
    /// Default number of trials.
    pub fn usual_trials(self) -> usize {
        if self == Self::Paper { 1 } else { 4 }
    }

    /// Settings of each pass, by trial.
    pub(super) fn settings(self, trials: usize) -> Vec<Vec<Setting>> {
        let equal = [[(1.0, 1.0, 1.0, false); 2]; 4];
        let (rows, step) = match self {
            Self::Paper => (equal, 1.0),
            Self::Varied => (VARIED, 1.0),
            Self::Reversed => (REVERSED, 1.0),
            Self::Steps => (STEPS, STEP),
        };
        let setting = |&(force, feed, speed, backwards): &Row| {
            let feeds = if backwards { [feed * step, feed] } else { [feed, feed * step] };
            Setting { force, feeds, speed, backwards }
        };
        (0..trials).map(|k| rows[k % rows.len()].iter().map(setting).collect()).collect()
    }
}

/// Role of a pass: evaluation in the last trial, or in the last pass if there is only one trial; else calibration.
pub(super) fn role((trial, trials): (usize, usize), (pass, passes): (usize, usize)) -> Role {
    let judges = if trials > 1 { trial + 1 == trials } else { pass + 1 == passes };
    if judges { Role::Evaluation } else { Role::Calibration }
}

/// Size of workpieces and scans.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Size {
    /// Takes seconds to make and to fit: a bead of 30 mm, a panel of 60 by 50 mm.
    Small,
    /// Typical of laboratories: a bead of 100 to 140 mm, a panel of 120 by 90 mm.
    #[default]
    Full,
}

/// Sizes and usual settings of a process.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ProcessDefaults {
    /// Distance between a scan's pixels [m].
    pub(super) pitch: f64,
    /// Length of a bead; extent of a panel along x [m].
    pub(super) length: [f64; 2],
    /// Extent of the scan along y [m].
    pub(super) width: f64,
    /// Radius of the tool [m].
    pub(super) tool_radius: f64,
    /// Usual force [N].
    pub(super) force: f64,
    /// Usual feed [m/s].
    pub(super) feed: f64,
    /// Usual spindle speed [rpm].
    pub(super) rpm: f64,
}

impl ProcessDefaults {
    pub(super) fn of(process: Process, size: Size) -> Self {
        let grinding = Self {
            pitch: 0.25e-3,
            length: [100e-3, 140e-3],
            width: 20e-3,
            tool_radius: 50e-3,
            force: 15.0,
            feed: 10e-3,
            rpm: 6000.0,
        };
        let sanding = Self {
            pitch: 0.5e-3,
            length: [120e-3; 2],
            width: 90e-3,
            tool_radius: 25e-3,
            force: 15.0,
            feed: 40e-3,
            rpm: 3000.0,
        };
        match (process.signal(), size) {
            (Signal::Height, Size::Full) => grinding,
            (Signal::Height, Size::Small) => Self { pitch: 0.3e-3, length: [30e-3; 2], width: 14.4e-3, ..grinding },
            (Signal::Dose, Size::Full) => sanding,
            (Signal::Dose, Size::Small) => {
                Self { length: [60e-3; 2], width: 50e-3, tool_radius: 12e-3, force: 6.0, feed: 20e-3, ..sanding }
            }
        }
    }
}
