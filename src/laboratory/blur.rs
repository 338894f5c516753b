//! The instrument's lateral blur, on what the tool has changed: the rest of a simulated surface comes from a scan and is
//! blurred already.

use sdf_bake::HeightMap;

/// Change of height [m] from which a pixel counts as changed.
const CHANGED: f64 = 2e-6;
/// Reach of the Gaussian [standard deviations].
const REACH: f64 = 3.0;

/// The simulated surface as an instrument sees it whose point spread is a Gaussian with standard deviation `blur` [m].
///
/// - `before`: the scan from which the simulation began, on the same pixels
pub fn blurred(simulated: &HeightMap, before: &HeightMap, blur: f64) -> HeightMap {
    let kernel = Kernel::new(blur / simulated.pixels.pitch);
    let mut seen = simulated.clone();
    if kernel.reach < 1 {
        return seen;
    }
    let (nx, ny) = (simulated.pixels.nx as i64, simulated.pixels.ny as i64);
    let near = |i: i64, n: i64| (i - kernel.reach).max(0)..=(i + kernel.reach).min(n - 1);
    let changed = |at: usize| (simulated.heights[at] - before.heights[at]).abs() > CHANGED;
    let mut touched = vec![false; simulated.heights.len()];
    for at in (0..touched.len()).filter(|&at| changed(at)) {
        let (i, j) = (at as i64 % nx, at as i64 / nx);
        for row in near(j, ny) {
            near(i, nx).for_each(|column| touched[(row * nx + column) as usize] = true);
        }
    }
    for at in (0..touched.len()).filter(|&at| touched[at] && simulated.heights[at].is_finite()) {
        let (i, j) = (at as i64 % nx, at as i64 / nx);
        let (mut sum, mut weight) = (0.0, 0.0);
        for row in near(j, ny) {
            for column in near(i, nx) {
                let height = simulated.heights[(row * nx + column) as usize];
                let w = if height.is_finite() { kernel.at(column - i) * kernel.at(row - j) } else { 0.0 };
                (sum, weight) = (sum + if w > 0.0 { w * height } else { 0.0 }, weight + w);
            }
        }
        seen.heights[at] = sum / weight;
    }
    seen
}

/// A Gaussian along one axis of the pixels.
struct Kernel {
    reach: i64,
    weights: Vec<f64>,
}

impl Kernel {
    /// - `sigma`: standard deviation [pixels]
    ///
    /// The reach is that of the whole pixels within three standard deviations and one more, which fades in: what is seen
    /// changes evenly with the blur.
    fn new(sigma: f64) -> Self {
        let span = REACH * sigma;
        let reach = span.ceil() as i64;
        let fade = |d: i64| (span + 1.0 - d as f64).clamp(0.0, 1.0);
        let weight = |d: i64| fade(d) * (-0.5 * (d as f64 / sigma).powi(2)).exp();
        Self { reach: if sigma > 0.0 { reach } else { 0 }, weights: (0..=reach).map(weight).collect() }
    }

    fn at(&self, offset: i64) -> f64 {
        self.weights[offset.unsigned_abs() as usize]
    }
}

/// Where a smooth cost of one number is least: the best of evenly spaced values, then the vertices of parabolas through
/// the three best beside it.
///
/// - `steps`: values tried at first, both ends included
/// - `settled`: step that counts as none
///
/// # Errors
/// The first that the cost returns.
pub fn least_of<E>(
    cost: impl Fn(f64) -> Result<f64, E>,
    ([least, greatest], steps): ([f64; 2], usize),
    settled: f64,
) -> Result<f64, E> {
    let place = |k: usize| least + (greatest - least) * k as f64 / (steps - 1) as f64;
    let mut known = (0..steps).map(|k| Ok((place(k), cost(place(k))?))).collect::<Result<Vec<(f64, f64)>, E>>()?;
    for _ in 0..MOST_VERTICES {
        let best = (0..known.len()).min_by(|&a, &b| known[a].1.total_cmp(&known[b].1)).unwrap_or(0);
        if best == 0 || best + 1 == known.len() {
            return Ok(known[best].0);
        }
        let (before, at, after) = (known[best - 1], known[best], known[best + 1]);
        let next = vertex(before, at, after).unwrap_or(at.0);
        let gap = (next - at.0).abs();
        if gap <= settled {
            return Ok(next);
        }
        let wider = if at.0 - before.0 > after.0 - at.0 { before.0 } else { after.0 };
        let next = if gap < SHORTEST * (wider - at.0).abs() { at.0 + SHORTEST * (wider - at.0) } else { next };
        known.insert(if next < at.0 { best } else { best + 1 }, (next, cost(next)?));
    }
    Ok(known.iter().min_by(|a, b| a.1.total_cmp(&b.1)).map_or(least, |best| best.0))
}

/// Parabolas at most, and the least share of the wider side that a step takes, so that both sides close in.
const MOST_VERTICES: usize = 12;
const SHORTEST: f64 = 0.02;

/// Lowest point of the parabola through three points with rising places; `None` where they lie on a line.
fn vertex((x0, y0): (f64, f64), (x1, y1): (f64, f64), (x2, y2): (f64, f64)) -> Option<f64> {
    let (left, right) = ((x1 - x0) * (y1 - y2), (x1 - x2) * (y1 - y0));
    let bend = left - right;
    (bend.abs() > f64::MIN_POSITIVE).then(|| x1 - 0.5 * ((x1 - x0) * left - (x1 - x2) * right) / bend)
}
