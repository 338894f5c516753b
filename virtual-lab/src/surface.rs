//! The true workpieces: beads on plates and domed panels, each a formula with random sizes.

use std::f64::consts::TAU;

use glam::DVec2;

use random::Stream;

/// Length of plate before the bead begins [m].
const RUN_IN: f64 = 6e-3;
/// Half width of a bead [m].
const BEAD_HALF_WIDTH: [f64; 2] = [3.6e-3, 5.2e-3];
/// Height of a bead's crest [m].
const BEAD_HEIGHT: [f64; 2] = [1.6e-3, 2.3e-3];
/// Relative variation of crest and width along a bead.
const BEAD_SWING: [f64; 2] = [0.02, 0.06];
/// Wavelength of this variation [m].
const SWING_LENGTH: [f64; 2] = [12e-3, 45e-3];
/// Amplitude of a bead's ripples [m].
const RIPPLE: [f64; 2] = [15e-6, 45e-6];
/// Wavelength of the ripples [m].
const RIPPLE_LENGTH: [f64; 2] = [2.8e-3, 4.5e-3];
/// Lag of a ripple at the toe behind its crest [half widths].
const RIPPLE_LAG: f64 = 0.35;
/// Rounding radius of a bead's toes [m].
const TOE: f64 = 0.1e-3;
/// Tilt of a plate or panel [1].
const TILT: [f64; 2] = [-2e-3, 2e-3];
/// Amplitude of a plate's waves [m], and their wavelength [m].
const PLATE_WAVE: ([f64; 2], [f64; 2]) = ([2e-6, 8e-6], [15e-3, 60e-3]);
/// Start of the second filler, which grinds like the base metal, as a share of a bead's length.
const SECOND_FILLER: [f64; 2] = [0.55, 0.75];
/// Radii of curvature of a panel along x and y [m].
const PANEL_RADIUS: ([f64; 2], [f64; 2]) = ([2.0, 4.0], [0.8, 1.5]);
/// Amplitude of a panel's waves [m], and their wavelength [m].
const PANEL_WAVE: ([f64; 2], [f64; 2]) = ([4e-6, 15e-6], [20e-3, 60e-3]);

/// A wave in the plane.
pub(super) struct Wave {
    amplitude: f64,
    /// Wave vector [rad/m].
    number: DVec2,
    phase: f64,
}

impl Wave {
    /// Draws a wave along `direction`, a unit vector.
    fn draw(amplitude: [f64; 2], length: [f64; 2], direction: DVec2, stream: &mut Stream) -> Self {
        let number = direction * TAU / stream.ratio_between(length);
        Self { amplitude: stream.between(amplitude), number, phase: stream.between([0.0, TAU]) }
    }

    fn at(&self, place: DVec2) -> f64 {
        self.amplitude * (self.number.dot(place) + self.phase).sin()
    }
}

fn sum(waves: &[Wave], place: DVec2) -> f64 {
    waves.iter().map(|wave| wave.at(place)).sum()
}

/// Draws waves of random direction.
fn waves(count: usize, (amplitude, length): ([f64; 2], [f64; 2]), stream: &mut Stream) -> Vec<Wave> {
    let wave = |_| {
        let direction = DVec2::from_angle(stream.between([0.0, TAU]));
        Wave::draw(amplitude, length, direction, stream)
    };
    (0..count).map(wave).collect()
}

/// A weld bead along x on a plate.
pub(super) struct Bead {
    start: f64,
    end: f64,
    half_width: f64,
    height: f64,
    /// Relative variation of height and of width along x.
    swings: [Vec<Wave>; 2],
    ripple: Wave,
    tilt: DVec2,
    plate: Vec<Wave>,
    second_filler: f64,
}

/// A true workpiece.
pub(super) enum Workpiece {
    /// A bead, for grinding.
    Bead(Bead),
    /// A dome, for sanding, with its centre at the second value.
    Panel([f64; 2], DVec2, DVec2, Vec<Wave>),
}

impl Workpiece {
    /// Draws a bead of a length [m] that begins 6 mm from x = 0, along y = 0.
    pub(super) fn bead(length: f64, stream: &mut Stream) -> Self {
        let mut swing = || (0..3).map(|_| Wave::draw(BEAD_SWING, SWING_LENGTH, DVec2::X, stream)).collect();
        let swings = [swing(), swing()];
        Self::Bead(Bead {
            start: RUN_IN,
            end: RUN_IN + length,
            half_width: stream.between(BEAD_HALF_WIDTH),
            height: stream.between(BEAD_HEIGHT),
            swings,
            ripple: Wave::draw(RIPPLE, RIPPLE_LENGTH, DVec2::X, stream),
            tilt: DVec2::new(stream.between(TILT), stream.between(TILT)),
            plate: waves(3, PLATE_WAVE, stream),
            second_filler: RUN_IN + length * stream.between(SECOND_FILLER),
        })
    }

    /// Length of plate for a bead of this length [m].
    pub(super) fn plate_length(bead: f64) -> f64 {
        bead + 2.0 * RUN_IN
    }

    /// Draws a dome around `middle` [m].
    pub(super) fn panel(middle: DVec2, stream: &mut Stream) -> Self {
        let radii = [stream.between(PANEL_RADIUS.0), stream.between(PANEL_RADIUS.1)];
        let tilt = DVec2::new(stream.between(TILT), stream.between(TILT));
        Self::Panel(radii, middle, tilt, waves(4, PANEL_WAVE, stream))
    }

    /// Height [m] at a place [m].
    pub(super) fn height(&self, place: DVec2) -> f64 {
        match self {
            Self::Bead(bead) => bead.height(place),
            Self::Panel([along, across], middle, tilt, waves) => {
                let from = place - middle;
                sum(waves, place) + tilt.dot(from) - 0.5 * (from.x * from.x / along + from.y * from.y / across)
            }
        }
    }

    /// Material at a place [m]: 1 weld metal, 0 base metal.
    pub(super) fn label(&self, place: DVec2) -> u16 {
        match self {
            Self::Bead(bead) => u16::from(bead.share(place) > 0.0 && place.x < bead.second_filler),
            Self::Panel(..) => 0,
        }
    }
}

impl Bead {
    /// 1 on the crest, 0 at the toes, negative beyond; the ends are round.
    fn share(&self, place: DVec2) -> f64 {
        let width = self.half_width * (1.0 + sum(&self.swings[1], place));
        let beyond = (self.start + width - place.x).max(place.x - self.end + width).max(0.0);
        1.0 - (place.y * place.y + beyond * beyond) / (width * width)
    }

    fn height(&self, place: DVec2) -> f64 {
        let share = self.share(place);
        let crest = self.height * (1.0 + sum(&self.swings[0], place));
        let lag = RIPPLE_LAG * place.y * place.y / self.half_width;
        let ripple = share.clamp(0.0, 1.0) * self.ripple.at(place + DVec2::X * lag);
        let over = crest * share + ripple;
        // A smooth maximum of bead and plate.
        0.5 * (over + (over * over + TOE * TOE).sqrt()) + self.tilt.dot(place) + sum(&self.plate, place)
    }
}
