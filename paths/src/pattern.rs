//! Paths of a pad over a patch, and their division into stages.

use glam::{DVec2, Vec2Swizzles};
use serde::{Deserialize, Serialize};

use super::pad_patch::PadPatch;

/// Greatest distance between neighbouring lines [pad radii]; adjacent tracks overlap.
const SPACING: f64 = 1.5;
/// Least distance between neighbouring spots [pad radii]; the coating between them stays.
const SPOT_SPACING: f64 = 2.6;
/// Radius of the circle that the pad's centre describes on a spot [pad radii].
const SPOT: f64 = 0.25;
/// Distance between points of a path [pad radii].
const STEP: f64 = 0.1;

/// Shape of the pad's path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Pattern {
    /// Lines along x, in alternating directions.
    AlongX,
    /// Lines along y, in alternating directions.
    AlongY,
    /// Lines at 45°, in alternating directions.
    Diagonal,
    /// Shrinking ellipses, from the border to the centre.
    Spiral,
    /// Once along the border.
    Frame,
    /// Small circles on separate spots.
    Spots,
}

/// A stretch that the pad travels without being lifted: positions of its centre [m].
pub type Stroke = Vec<DVec2>;

impl Pattern {
    /// All patterns, in the order in which a set uses them.
    pub const ALL: [Self; 6] = [Self::AlongX, Self::AlongY, Self::Diagonal, Self::Spiral, Self::Frame, Self::Spots];

    /// Name in files and flags.
    pub fn name(self) -> &'static str {
        match self {
            Self::AlongX => "along-x",
            Self::AlongY => "along-y",
            Self::Diagonal => "diagonal",
            Self::Spiral => "spiral",
            Self::Frame => "frame",
            Self::Spots => "spots",
        }
    }

    /// Description in a few words, as help texts print it.
    pub fn about(self) -> &'static str {
        match self {
            Self::AlongX => "Lines along x, back and forth",
            Self::AlongY => "Lines along y, back and forth",
            Self::Diagonal => "Lines at 45°, back and forth",
            Self::Spiral => "A spiral from the border to the middle",
            Self::Frame => "Once along the border",
            Self::Spots => "Small circles on spots apart from each other",
        }
    }

    /// Returns the path over a patch [m].
    pub fn strokes(self, patch: &PadPatch) -> Vec<Stroke> {
        let (low, size, radius) = (patch.low, patch.high - patch.low, patch.radius);
        let placed = |points: Vec<DVec2>| points.into_iter().map(|at| low + at).collect::<Stroke>();
        let strokes = match self {
            Self::AlongX => vec![meander(size.yx(), radius).into_iter().map(|at| at.yx()).collect()],
            Self::AlongY => vec![meander(size, radius)],
            Self::Diagonal => vec![diagonal(size, radius)],
            Self::Spiral => vec![spiral(size, radius)],
            Self::Frame => vec![frame(size)],
            Self::Spots => spots(size, radius),
        };
        strokes.into_iter().map(|points| refined(&placed(points), STEP * radius)).collect()
    }

    /// Divides the path into `stages` parts of equal length.
    pub fn stages(self, patch: &PadPatch, stages: u32) -> Vec<Vec<Stroke>> {
        let strokes = self.strokes(patch);
        let whole: f64 = strokes.iter().map(|stroke| length(stroke)).sum();
        let cut = |stage: u32| whole * f64::from(stage) / f64::from(stages);
        (0..stages).map(|stage| between(&strokes, cut(stage), cut(stage + 1))).collect()
    }
}

/// Lines along y in alternating directions, from the left to the right of a rectangle.
fn meander(size: DVec2, radius: f64) -> Vec<DVec2> {
    let lines = 1 + (size.x / (SPACING * radius)).ceil() as usize;
    let place = |line: usize| size.x * line as f64 / (lines - 1).max(1) as f64;
    let ends = |line: usize| if line.is_multiple_of(2) { [0.0, size.y] } else { [size.y, 0.0] };
    (0..lines).flat_map(|line| ends(line).map(|y| DVec2::new(place(line), y))).collect()
}

/// Lines at 45° in alternating directions, clipped at the rectangle's border.
fn diagonal(size: DVec2, radius: f64) -> Vec<DVec2> {
    let whole = size.x + size.y;
    let lines = 1 + (whole / (SPACING * radius * std::f64::consts::SQRT_2)).ceil() as usize;
    let line = |k: usize| {
        // All points with x + y = sum.
        let sum = whole * (k as f64 + 0.5) / lines as f64;
        let lowest = DVec2::new(sum.min(size.x), (sum - size.x).max(0.0));
        let highest = DVec2::new((sum - size.y).max(0.0), sum.min(size.y));
        if k.is_multiple_of(2) { [lowest, highest] } else { [highest, lowest] }
    };
    (0..lines).flat_map(line).collect()
}

/// An ellipse that shrinks by the line spacing with every turn.
fn spiral(size: DVec2, radius: f64) -> Vec<DVec2> {
    let half = 0.5 * size;
    let turns = (half.min_element() / (SPACING * radius)).ceil().max(1.0);
    let points = (turns * 120.0) as usize;
    let at = |k: usize| {
        let done = k as f64 / points as f64;
        half + half * (1.0 - done) * DVec2::from_angle(done * turns * std::f64::consts::TAU)
    };
    (0..=points).map(at).collect()
}

fn frame(size: DVec2) -> Vec<DVec2> {
    vec![DVec2::ZERO, DVec2::new(size.x, 0.0), size, DVec2::new(0.0, size.y), DVec2::ZERO]
}

/// A circle at each point of a square lattice.
fn spots(size: DVec2, radius: f64) -> Vec<Stroke> {
    let within = size - 2.0 * SPOT * radius;
    let count = (within / (SPOT_SPACING * radius)).floor().max(DVec2::ZERO).as_uvec2() + 1;
    let middle = |i: u32, j: u32| {
        let share = |at: u32, count: u32| if count > 1 { f64::from(at) / f64::from(count - 1) } else { 0.5 };
        0.5 * size + (DVec2::new(share(i, count.x), share(j, count.y)) - 0.5) * within
    };
    let circle = |middle: DVec2| {
        let at = |k: u32| middle + SPOT * radius * DVec2::from_angle(f64::from(k) * std::f64::consts::TAU / 24.0);
        (0..=24).map(at).collect()
    };
    (0..count.y).flat_map(|j| (0..count.x).map(move |i| (i, j))).map(|(i, j)| circle(middle(i, j))).collect()
}

fn length(stroke: &[DVec2]) -> f64 {
    stroke.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
}

/// Refines a path so that neighbouring points are at most `step` [m] apart.
fn refined(points: &[DVec2], step: f64) -> Stroke {
    let mut stroke: Stroke = points.first().copied().into_iter().collect();
    for pair in points.windows(2) {
        let parts = (pair[0].distance(pair[1]) / step).ceil().max(1.0) as usize;
        stroke.extend((1..=parts).map(|k| pair[0].lerp(pair[1], k as f64 / parts as f64)));
    }
    stroke.dedup_by(|later, earlier| later.distance(*earlier) < 1e-9);
    stroke
}

/// Returns the part of a path between two arc lengths from its start [m].
fn between(strokes: &[Stroke], from: f64, to: f64) -> Vec<Stroke> {
    let mut start = 0.0;
    let mut parts = Vec::new();
    for stroke in strokes {
        let mut part: Stroke = Vec::new();
        for pair in stroke.windows(2) {
            let way = pair[0].distance(pair[1]);
            let (enter, leave) = ((from - start) / way, (to - start) / way);
            if enter < 1.0 && leave > 0.0 {
                let ends = [enter.max(0.0), leave.min(1.0)].map(|share| pair[0].lerp(pair[1], share));
                part.extend(ends);
            }
            start += way;
        }
        part.dedup_by(|later, earlier| later.distance(*earlier) < 1e-9);
        if part.len() > 1 {
            parts.push(part);
        }
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patch() -> PadPatch {
        PadPatch::rectangle(DVec2::new(0.01, -0.02), DVec2::new(0.07, 0.02), 0.01)
    }

    #[test]
    fn every_way_stays_in_the_patch_and_its_stages_are_equally_long_parts_of_it() {
        let patch = patch();
        for pattern in Pattern::ALL {
            let whole = pattern.strokes(&patch);
            let all = || whole.iter().flatten();
            assert!(
                all().all(|at| at.cmpge(patch.low - 1e-9).all() && at.cmple(patch.high + 1e-9).all()),
                "{pattern:?}"
            );
            let stages = pattern.stages(&patch, 5);
            let lengths: Vec<f64> =
                stages.iter().map(|stage| stage.iter().map(|stroke| length(stroke)).sum()).collect();
            let total: f64 = whole.iter().map(|stroke| length(stroke)).sum();
            assert!(lengths.iter().all(|part| (part - 0.2 * total).abs() < 1e-6 * total), "{pattern:?}: {lengths:?}");
            assert_eq!(stages[0][0][0], whole[0][0]);
            let end = stages[4].last().and_then(|stroke| stroke.last()).unwrap();
            assert!(end.distance(*whole.last().unwrap().last().unwrap()) < 1e-9, "{pattern:?}");
        }
    }

    #[test]
    fn lines_leave_no_gap_and_spots_do() {
        let patch = patch();
        let far = |pattern: Pattern| {
            let strokes = pattern.strokes(&patch);
            let nearest = |at: DVec2| strokes.iter().flatten().map(|p| p.distance(at)).fold(f64::INFINITY, f64::min);
            let places = (0..=60).flat_map(|i| (0..=40).map(move |j| DVec2::new(f64::from(i), f64::from(j)) * 1e-3));
            places.map(|at| nearest(patch.low + at)).fold(0.0, f64::max) / patch.radius
        };
        for pattern in [Pattern::AlongX, Pattern::AlongY, Pattern::Diagonal] {
            assert!(far(pattern) < 1.0, "{pattern:?}: {}", far(pattern));
        }
        assert!(far(Pattern::Frame) > 1.5 && far(Pattern::Spots) > 1.1);
    }
}
