//! Motion of the tool: the route over the workpiece in time, with the approach from the air.

use glam::{DVec2, DVec3};
use sim::{Path, PathError, PathSample};

use super::noise::correlated_line;
use super::plan::{ProcessDefaults, Setting};
use super::robot::Robot;
use effects::{Process, Signal};
use random::Stream;
use robot::Tool;

/// Distance from a bead's ends to the ends of its passes, so that the wheel is on the bead [m].
const INSET: f64 = 3e-3;
/// Time between two samples of a path [s].
const SAMPLE: f64 = 0.02;
/// Distance between the lines of a pad's raster [pad radii].
const LINE_SPACING: f64 = 0.65;
/// Distance from a panel's border to the pad's edge [m].
const PANEL_BORDER: f64 = 3e-3;

/// Least distance between two rows of a log that counts as motion [m]: far longer than the robot's jitter.
const SAME_PLACE: f64 = 1e-3;

/// A straight segment at one feed.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Stretch {
    from: DVec2,
    to: DVec2,
    feed: f64,
}

/// The commanded route of a pass over the workpiece.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Route(Vec<Stretch>);

impl Route {
    /// The route of a pass.
    ///
    /// - `ends`: least and greatest x of the bead or panel [m]
    pub(super) fn of(process: Process, bench: &ProcessDefaults, ends: [f64; 2], setting: &Setting) -> Self {
        let mut corners = match process.signal() {
            Signal::Height => vec![DVec2::new(ends[0] + INSET, 0.0), DVec2::new(ends[1] - INSET, 0.0)],
            Signal::Dose => lines(bench, ends),
        };
        if setting.backwards {
            corners.reverse();
        }
        let feeds = setting.feeds.map(|feed| (feed * bench.feed * 1e4).round() * 1e-4);
        let total: f64 = corners.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        let mut stretches = Vec::new();
        let mut done = 0.0;
        for pair in corners.windows(2) {
            let length = pair[0].distance(pair[1]);
            let share = ((0.5 * total - done) / length).clamp(0.0, 1.0);
            let middle = pair[0].lerp(pair[1], share);
            let halves = [(pair[0], middle, feeds[0]), (middle, pair[1], feeds[1])];
            let real = halves.into_iter().filter(|(from, to, _)| from != to);
            stretches.extend(real.map(|(from, to, feed)| Stretch { from, to, feed }));
            done += length;
        }
        Self(stretches)
    }

    /// The route of a log.
    ///
    /// - `places`: time [s] and place [m] of each row; rows closer to each other than [`SAME_PLACE`] are merged
    pub(super) fn logged(places: &[(f64, DVec2)]) -> Self {
        let mut stretches = Vec::new();
        let (mut from, end) = (places[0], places[places.len() - 1]);
        let is_far = |from: &(f64, DVec2), to: &(f64, DVec2)| from.1.distance(to.1) >= SAME_PLACE;
        for &to in &places[1..] {
            if is_far(&from, &to) && is_far(&to, &end) || to == end {
                stretches.push(Stretch { from: from.1, to: to.1, feed: from.1.distance(to.1) / (to.0 - from.0) });
                from = to;
            }
        }
        Self(stretches)
    }

    /// Path samples of the route, at height zero of the workpiece frame.
    pub(super) fn samples(&self, tool: &Tool) -> Vec<PathSample> {
        [0.0, self.duration()].map(|time| sample(time, self.at(time).extend(0.0), tool)).to_vec()
    }

    /// Duration of the whole route [s].
    pub(super) fn duration(&self) -> f64 {
        self.0.iter().map(Stretch::duration).sum()
    }

    /// Mean feed: length over time [m/s].
    pub(super) fn mean_feed(&self) -> f64 {
        self.0.iter().map(|stretch| stretch.from.distance(stretch.to)).sum::<f64>() / self.duration()
    }

    /// Unit direction at its start.
    pub(super) fn direction(&self) -> DVec3 {
        (self.0[0].to - self.0[0].from).normalize().extend(0.0)
    }

    /// Place at a time [s], constant before the start and after the end.
    pub(super) fn at(&self, time: f64) -> DVec2 {
        let mut rest = time.max(0.0);
        for stretch in &self.0 {
            let duration = stretch.duration();
            if rest < duration {
                return stretch.from.lerp(stretch.to, rest / duration);
            }
            rest -= duration;
        }
        self.0[self.0.len() - 1].to
    }

    /// Path of the tool that descends above the start of the route and stays there.
    ///
    /// - `levels`: initial and final height of its reference point [m]
    pub(super) fn descent(&self, levels: [f64; 2], speed: f64, tool: &Tool) -> Result<Path, PathError> {
        let time = (levels[0] - levels[1]) / speed;
        let sample = |(time, level): (f64, f64)| sample(time, self.at(0.0).extend(level), tool);
        Path::from_samples([(0.0, levels[0]), (time, levels[1])].map(sample).to_vec())
    }

    /// The true path: descent until `touch` [s], then along the route with the robot's lateral wander.
    ///
    /// - `levels`: height of the reference point at first and at the touch [m]
    pub(super) fn path(
        &self,
        (levels, touch): ([f64; 2], f64),
        robot: &Robot,
        tool: &Tool,
        stream: &mut Stream,
    ) -> Result<Path, PathError> {
        let steps = (self.duration() / SAMPLE).ceil() as usize;
        let length = robot.wander_length / (self.mean_feed() * SAMPLE);
        let mut wander = || correlated_line(steps + 1, length, stream);
        let (along, across) = (wander(), wander());
        let moving = (0..=steps).map(|k| {
            let time = (k as f64 * SAMPLE).min(self.duration());
            let place = self.at(time) + robot.wander * DVec2::new(along[k], across[k]);
            sample(touch + time, place.extend(levels[1]), tool)
        });
        let start = sample(0.0, self.at(0.0).extend(levels[0]), tool);
        Path::from_samples(std::iter::once(start).chain(moving).collect())
    }
}

impl Stretch {
    fn duration(&self) -> f64 {
        self.from.distance(self.to) / self.feed
    }
}

fn sample(time: f64, centre: DVec3, tool: &Tool) -> PathSample {
    PathSample::from_centre(time, centre, (DVec3::Z, DVec3::Y), tool)
}

/// Corners of a raster of lines along x, in alternating direction without lifting.
fn lines(bench: &ProcessDefaults, ends: [f64; 2]) -> Vec<DVec2> {
    let border = PANEL_BORDER + bench.tool_radius;
    let reach = 0.5 * bench.width - border;
    let count = 1 + (2.0 * reach / (LINE_SPACING * bench.tool_radius)).ceil() as usize;
    let line = |k: usize| {
        let y = -reach + 2.0 * reach * k as f64 / (count as f64 - 1.0);
        let [low, high] = [DVec2::new(ends[0] + border, y), DVec2::new(ends[1] - border, y)];
        if k.is_multiple_of(2) { [low, high] } else { [high, low] }
    };
    (0..count).flat_map(line).collect()
}
