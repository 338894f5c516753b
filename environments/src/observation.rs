//! Observations of a policy.

use effects::Signal;
use sim::surface::way_to_surface;

use crate::environment::Environment;
use crate::picture::{RGB, photograph};
use crate::strip::PITCH;

/// Number of zones along the weld in the state: behind the tool, below it, ahead of it.
const ZONES: usize = 3;
/// Number of bins across the weld in each zone.
const BINS: usize = 5;
/// Length of a zone, and width of a bin [m].
const ZONE: f64 = 4e-3;
const BIN: f64 = 2e-3;
/// Number of values for the tool and the task.
const FIGURES: usize = 11;

/// Size of the state.
pub const STATE: usize = FIGURES + ZONES * BINS;
/// Shape of the height map: stations along the weld, points across it.
pub const HEIGHTS: [usize; 2] = [32, 16];
/// Shape of the depth image [pixels].
pub const DEPTH: [usize; 2] = [32, 32];
/// Side length of the area in the depth image and the photograph [m].
pub(crate) const SHOWN: f64 = 30e-3;
/// Height of their camera above the surface below the weld [m].
pub(crate) const CAMERA: f64 = 40e-3;

/// Type of observation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Observation {
    /// Tool, force, progress, and mean remaining heights around the tool: [`STATE`] values of order 1.
    State,
    /// Remaining height above the target [mm], or remaining coating [1], at the stations around the tool: shape
    /// [`HEIGHTS`].
    Heights,
    /// Distance [m] from an orthographic camera above the tool: shape [`DEPTH`].
    Depth,
    /// Photograph by that camera, eight-bit sRGB colours: shape [`RGB`].
    Rgb,
}

impl Observation {
    /// Returns the shape of the observation.
    pub fn shape(self) -> Vec<usize> {
        match self {
            Self::State => vec![STATE],
            Self::Heights => HEIGHTS.to_vec(),
            Self::Depth => DEPTH.to_vec(),
            Self::Rgb => RGB.to_vec(),
        }
    }

    /// Returns the number of values.
    pub fn size(self) -> usize {
        self.shape().iter().product()
    }

    /// Writes the observation of an environment.
    pub(crate) fn look(self, environment: &Environment, out: &mut [f32]) {
        match self {
            Self::State => state(environment, out),
            Self::Heights => heights(environment, out),
            Self::Depth => depth(environment, out),
            Self::Rgb => photograph(environment, out),
        }
    }
}

/// Returns the remaining height at a point of the strip, relative to the weld's height, or one minus the dose [1]; 0
/// outside the strip.
fn left_at(environment: &Environment, station: isize, place: isize) -> f64 {
    let [stations, across] = environment.strip.shape();
    if !(0..stations as isize).contains(&station) || !(0..across as isize).contains(&place) {
        return 0.0;
    }
    let at = station as usize * across + place as usize;
    match environment.task.process.signal() {
        Signal::Height => f64::from(environment.strip.heights[at]) / environment.task.weld.height,
        Signal::Dose => 1.0 - f64::from(environment.strip.doses[at]),
    }
}

/// Returns the station and the point across the weld nearest to the tool.
fn nearest(environment: &Environment) -> (isize, isize) {
    let stance = environment.stance;
    let station = (stance.arc / environment.task.curve.pitch()).round() as isize;
    let place = (stance.offset / PITCH).round() as isize + environment.strip.shape()[1] as isize / 2;
    (station, place)
}

fn state(environment: &Environment, out: &mut [f32]) {
    let Environment { task, stance, metrics, setup, force, .. } = environment;
    let limits = &setup.limits;
    let figures: [f64; FIGURES] = [
        2.0 * stance.arc / task.curve.length() - 1.0,
        stance.offset / task.weld.width,
        stance.roll / limits.tilt,
        stance.pitch / limits.tilt,
        force / limits.force,
        stance.setpoint / limits.force,
        environment.underway.motion().travel / task.weld.height,
        metrics.time / environment.time_limit,
        metrics.left,
        metrics.gouge_depth / 1e-3,
        metrics.oversanded,
    ];
    let (station, place) = nearest(environment);
    let pitch = task.curve.pitch();
    let (zone, bin) = ((ZONE / pitch).round().max(1.0) as isize, (BIN / PITCH) as isize);
    let mean = |number: usize| {
        let (z, b) = ((number / BINS) as isize - ZONES as isize / 2, (number % BINS) as isize - BINS as isize / 2);
        let (first, left) = (station + z * zone - zone / 2, place + b * bin - bin / 2);
        let all = (0..zone * bin).map(|k| left_at(environment, first + k / bin, left + k % bin));
        all.sum::<f64>() / (zone * bin) as f64
    };
    let all = figures.into_iter().chain((0..ZONES * BINS).map(mean));
    out.iter_mut().zip(all).for_each(|(out, value)| *out = value as f32);
}

fn heights(environment: &Environment, out: &mut [f32]) {
    let (station, place) = nearest(environment);
    let [along, across] = HEIGHTS;
    let (first, left) = (station - along as isize / 2, place - across as isize / 2);
    let scale =
        if environment.task.process.signal() == Signal::Height { environment.task.weld.height * 1e3 } else { 1.0 };
    for (at, out) in out.iter_mut().enumerate() {
        let value = left_at(environment, first + (at / across) as isize, left + (at % across) as isize);
        *out = (value * scale) as f32;
    }
}

fn depth(environment: &Environment, out: &mut [f32]) {
    let station = environment.task.curve.at(environment.stance.arc);
    let [rows, columns] = DEPTH;
    let eye = station.position + station.side() * environment.stance.offset + station.normal * CAMERA;
    let place = |at: usize, count: usize| SHOWN * ((at as f64 + 0.5) / count as f64 - 0.5);
    for (at, out) in out.iter_mut().enumerate() {
        let (ahead, left) = (-place(at / columns, rows), -place(at % columns, columns));
        let from = eye + station.tangent * ahead + station.side() * left;
        let way = way_to_surface(&environment.part, from, station.normal, 2.0 * CAMERA);
        *out = way.map_or(2.0 * CAMERA, |way| -way) as f32;
    }
}
