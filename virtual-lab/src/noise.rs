//! Correlated noise: white noise convolved with a Gaussian.

use random::Stream;

/// Reach of the Gaussian [standard deviations].
const REACH: f64 = 4.0;

/// Normal noise of variance 1 on `nx` by `ny` points with the correlation `exp(-(d / length)²)` at the distance d
/// [points]; white for a length of zero.
pub(super) fn correlated(points: (usize, usize), length: f64, stream: &mut Stream) -> Vec<f64> {
    streaked(points, [length; 2], stream)
}

/// The same with separate lengths along x and y.
pub(super) fn streaked((nx, ny): (usize, usize), lengths: [f64; 2], stream: &mut Stream) -> Vec<f64> {
    // The autocorrelation of a Gaussian of half this length is the wanted one.
    let [along, across] = lengths.map(|length| kernel(0.5 * length));
    let (wide, high) = (nx + along.len() - 1, ny + across.len() - 1);
    let white: Vec<f64> = (0..wide * high).map(|_| stream.normal()).collect();
    let row = |k: usize| filtered(&white[k / nx * wide + k % nx..], 1, &along);
    let rows: Vec<f64> = (0..nx * high).map(row).collect();
    (0..nx * ny).map(|k| filtered(&rows[k..], nx, &across)).collect()
}

/// The same along a line of `count` points.
pub(super) fn correlated_line(count: usize, length: f64, stream: &mut Stream) -> Vec<f64> {
    let kernel = kernel(0.5 * length);
    let white: Vec<f64> = (0..count + kernel.len() - 1).map(|_| stream.normal()).collect();
    (0..count).map(|k| filtered(&white[k..], 1, &kernel)).collect()
}

fn filtered(values: &[f64], stride: usize, kernel: &[f64]) -> f64 {
    kernel.iter().enumerate().map(|(k, weight)| weight * values[k * stride]).sum()
}

/// A sampled Gaussian whose squared weights sum to one.
fn kernel(sigma: f64) -> Vec<f64> {
    let reach = (REACH * sigma).ceil() as i32;
    let weight = |k: i32| if reach == 0 { 1.0 } else { (-0.5 * (f64::from(k) / sigma).powi(2)).exp() };
    let weights: Vec<f64> = (-reach..=reach).map(weight).collect();
    let size = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
    weights.into_iter().map(|w| w / size).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_its_variance_and_its_correlation() {
        let (nx, ny, length) = (400, 300, 8.0);
        let noise = correlated((nx, ny), length, &mut Stream::of(1, "test"));
        let mean = |lag: usize| {
            let pairs = (0..ny).flat_map(|j| (0..nx - lag).map(move |i| j * nx + i));
            pairs.map(|k| noise[k] * noise[k + lag]).sum::<f64>() / (ny * (nx - lag)) as f64
        };
        println!("variance {:.3}, correlation at {length} points {:.3}", mean(0), mean(8) / mean(0));
        // About 900 independent patches.
        assert!((mean(0) - 1.0).abs() < 0.15);
        assert!((mean(8) / mean(0) - (-1f64).exp()).abs() < 0.08);
        let streaks = streaked((nx, ny), [length, 0.0], &mut Stream::of(1, "streaks"));
        let beside = |lag: usize| (0..nx * (ny - 1)).map(|k| streaks[k] * streaks[k + lag]).sum::<f64>();
        assert!(beside(nx).abs() < 0.05 * beside(0), "rows do not know of each other");
        let white = correlated((nx, ny), 0.0, &mut Stream::of(1, "white"));
        assert!((white.iter().map(|v| v * v).sum::<f64>() / white.len() as f64 - 1.0).abs() < 0.02);
    }
}
