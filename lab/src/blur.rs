//! Lateral blur of the instrument, applied only where the tool changed the surface: the rest of a simulated surface
//! comes from a scan and is already blurred.

use sdf_bake::HeightMap;

use crate::criteria::CHANGED_HEIGHT;

/// Reach of the Gaussian [standard deviations].
const REACH: f64 = 3.0;

/// Returns the simulated surface as seen by an instrument whose point spread function is a Gaussian with standard
/// deviation `blur` [m].
///
/// - `before`: the scan from which the simulation began, on the same pixels
pub fn blurred(simulated: &HeightMap, before: &HeightMap, blur: f64) -> HeightMap {
    let kernel = Kernel::new(blur / simulated.pixels.pitch);
    let mut seen = simulated.clone();
    if kernel.reach == 0 {
        return seen;
    }
    let size = [simulated.pixels.nx, simulated.pixels.ny];
    let change = |(a, b): (&f64, &f64)| f64::from((a - b).abs() > CHANGED_HEIGHT);
    let changed: Vec<f64> = simulated.heights.iter().zip(&before.heights).map(change).collect();
    let touched = spread(&changed, size, &vec![1.0; kernel.reach + 1]);
    let known = |height: &f64| f64::from(height.is_finite());
    let weights = spread(&simulated.heights.iter().map(known).collect::<Vec<_>>(), size, &kernel.weights);
    let height = |height: &f64| if height.is_finite() { *height } else { 0.0 };
    let sums = spread(&simulated.heights.iter().map(height).collect::<Vec<_>>(), size, &kernel.weights);
    for (at, seen) in seen.heights.iter_mut().enumerate().filter(|(_, seen)| seen.is_finite()) {
        if touched[at] > 0.0 {
            *seen = sums[at] / weights[at];
        }
    }
    seen
}

/// Convolves values along rows, then along columns; the border contributes nothing from outside.
///
/// - `size`: columns and rows
/// - `weights`: by distance [pixels]
fn spread(values: &[f64], [nx, ny]: [usize; 2], weights: &[f64]) -> Vec<f64> {
    let add = |to: &mut [f64], from: &[f64], weight: f64| {
        to.iter_mut().zip(from).for_each(|(to, from)| *to += weight * from);
    };
    let mut along = vec![0.0; values.len()];
    for (to, from) in along.chunks_exact_mut(nx).zip(values.chunks_exact(nx)) {
        add(to, from, weights[0]);
        for (d, &weight) in weights.iter().enumerate().take(nx).skip(1) {
            add(&mut to[d..], from, weight);
            add(to, &from[d..], weight);
        }
    }
    let mut both = vec![0.0; values.len()];
    for (j, to) in both.chunks_exact_mut(nx).enumerate() {
        for row in (j + 1).saturating_sub(weights.len())..(j + weights.len()).min(ny) {
            add(to, &along[row * nx..][..nx], weights[row.abs_diff(j)]);
        }
    }
    both
}

/// A Gaussian kernel along one axis of the pixels.
struct Kernel {
    reach: usize,
    weights: Vec<f64>,
}

impl Kernel {
    /// - `sigma`: standard deviation [pixels]
    ///
    /// The kernel reaches the whole pixels within three standard deviations and one more, which fades in. So the result
    /// is continuous in the blur.
    fn new(sigma: f64) -> Self {
        let span = REACH * sigma;
        let reach = span.ceil() as usize;
        let fade = |d: usize| (span + 1.0 - d as f64).clamp(0.0, 1.0);
        let weight = |d: usize| fade(d) * (-0.5 * (d as f64 / sigma).powi(2)).exp();
        Self { reach: if sigma > 0.0 { reach } else { 0 }, weights: (0..=reach).map(weight).collect() }
    }
}

/// Minimises a smooth cost of one number: takes the best of evenly spaced values, then vertices of parabolas through
/// the best three points.
///
/// - `steps`: number of values tried at first, both ends included
/// - `settled`: step below which the search ends
///
/// # Errors
/// The first error of the cost function.
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

/// Most parabolas, and least step as a share of the wider side, so that both sides shrink.
const MOST_VERTICES: usize = 12;
const SHORTEST: f64 = 0.02;

/// Vertex of the parabola through three points of increasing abscissa; `None` if they are collinear.
fn vertex((x0, y0): (f64, f64), (x1, y1): (f64, f64), (x2, y2): (f64, f64)) -> Option<f64> {
    let (left, right) = ((x1 - x0) * (y1 - y2), (x1 - x2) * (y1 - y0));
    let bend = left - right;
    (bend.abs() > f64::MIN_POSITIVE).then(|| x1 - 0.5 * ((x1 - x0) * left - (x1 - x2) * right) / bend)
}
