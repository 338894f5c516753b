//! Lateral blur of the instrument, applied only where the tool changed the surface: the rest of a simulated surface
//! comes from a scan and is already blurred.

use sdf_bake::HeightMap;

/// Reach of the Gaussian [standard deviations].
const REACH: f64 = 3.0;

/// Returns the simulated surface as seen by an instrument whose point spread function is a Gaussian with standard
/// deviation `blur` [m].
///
/// - `before`: the scan from which the simulation began, on the same pixels
/// - `changed`: least change of a height that counts as the tool's [m]
pub fn blurred(simulated: &HeightMap, (before, changed): (&HeightMap, f64), blur: f64) -> HeightMap {
    let kernel = Kernel::new(blur / simulated.pixels.pitch);
    let mut seen = simulated.clone();
    if kernel.reach == 0 {
        return seen;
    }
    let size = [simulated.pixels.nx, simulated.pixels.ny];
    let change = |(a, b): (&f64, &f64)| f64::from((a - b).abs() > changed);
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
