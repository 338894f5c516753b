//! Statistics of a residual map.

/// Statistics of a set of residuals.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Statistics {
    /// Number of finite residuals.
    pub(super) count: usize,
    /// Share within the tolerance band [1].
    pub(super) within: f64,
    /// Mean [m].
    pub(super) mean: f64,
    /// Standard deviation about the mean [m].
    pub(super) deviation: f64,
    /// Root mean square [m].
    pub(super) rms: f64,
    /// 5 % and 95 % quantile [m].
    pub(super) quantiles: [f64; 2],
}

impl Statistics {
    /// Computes the statistics of the finite residuals [m]; `None` without one.
    pub(super) fn new(residuals: impl Iterator<Item = f64>, band: f64) -> Option<Self> {
        let mut sorted: Vec<f64> = residuals.filter(|r| r.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let count = sorted.len();
        let within = sorted.iter().filter(|r| r.abs() <= band).count();
        let n = count as f64;
        let mean = sorted.iter().sum::<f64>() / n;
        let square = sorted.iter().map(|r| r * r).sum::<f64>() / n;
        (count > 0).then(|| Self {
            count,
            within: within as f64 / n,
            mean,
            deviation: (square - mean * mean).max(0.0).sqrt(),
            rms: square.sqrt(),
            quantiles: [0.05, 0.95].map(|share| quantile(&sorted, share)),
        })
    }
}

/// Returns a quantile, interpolated between the order statistics (Hyndman & Fan 1996, type 7).
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let at = share * (sorted.len() - 1) as f64;
    let (low, part) = (at as usize, at.fract());
    let high = (low + 1).min(sorted.len() - 1);
    sorted[low] + part * (sorted[high] - sorted[low])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_of_a_ramp_are_those_of_the_formula() {
        let ramp = (0..=100).map(|k| f64::from(k) * 1e-6 - 40e-6).chain([f64::NAN]);
        let found = Statistics::new(ramp, 20.5e-6).unwrap();
        assert_eq!(found.count, 101);
        assert!((found.mean - 10e-6).abs() < 1e-12);
        // Discrete uniform: variance (n² - 1) / 12.
        assert!((found.deviation - (10200.0 / 12.0f64).sqrt() * 1e-6).abs() < 1e-12);
        assert!((found.rms.powi(2) - found.deviation.powi(2) - 100e-12).abs() < 1e-18);
        assert!((found.quantiles[0] + 35e-6).abs() < 1e-12 && (found.quantiles[1] - 55e-6).abs() < 1e-12);
        assert!((found.within - 41.0 / 101.0).abs() < 1e-12);
        assert_eq!(Statistics::new([f64::NAN].into_iter(), 1.0), None);
    }
}
