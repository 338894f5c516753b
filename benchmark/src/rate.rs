//! Share of cases with its interval.

use serde::Serialize;

/// Normal quantile of a 95 % interval.
const QUANTILE: f64 = 1.959_964;

/// A share with its interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rate {
    /// Number of cases that satisfy the condition.
    pub hits: usize,
    /// Number of all cases.
    pub of: usize,
    /// 95 % interval (Wilson 1927).
    pub interval: [f64; 2],
}

impl Rate {
    /// Counts the true values.
    pub fn new(holds: impl Iterator<Item = bool>) -> Self {
        let (mut hits, mut of) = (0, 0);
        for holds in holds {
            hits += usize::from(holds);
            of += 1;
        }
        let (n, z2) = (of.max(1) as f64, QUANTILE * QUANTILE);
        let share = hits as f64 / n;
        let middle = (share + z2 / (2.0 * n)) / (1.0 + z2 / n);
        let half = QUANTILE * (share * (1.0 - share) / n + z2 / (4.0 * n * n)).sqrt() / (1.0 + z2 / n);
        let interval = if of == 0 { [0.0, 1.0] } else { [(middle - half).max(0.0), (middle + half).min(1.0)] };
        Self { hits, of, interval }
    }

    /// Share of cases that satisfy the condition; zero without a case.
    pub fn share(&self) -> f64 {
        self.hits as f64 / self.of.max(1) as f64
    }
}

impl std::fmt::Display for Rate {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let [low, high] = self.interval.map(|share| 100.0 * share);
        write!(f, "{}/{} ({low:.0} to {high:.0} %)", self.hits, self.of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_is_wilsons() {
        // By hand: share 0.7, z² = 3.8415, middle (0.7 + 0.19207) / 1.38415, half 1.96 √(0.021 + 0.0096036) / 1.38415.
        let rate = Rate::new((0..10).map(|k| k < 7));
        assert_eq!((rate.hits, rate.of), (7, 10));
        let [low, high] = rate.interval;
        assert!((low - 0.3968).abs() < 2e-4 && (high - 0.8922).abs() < 2e-4, "{rate:?}");
        assert_eq!(Rate::new(std::iter::empty()).interval, [0.0, 1.0]);
        assert_eq!(rate.to_string(), "7/10 (40 to 89 %)");
    }
}
