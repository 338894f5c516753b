//! Sums over lanes, in the processor's widest SIMD lanes.
//!
//! A sum is the total of eight partial sums that take the lanes in turn, on any processor, so its bits are the same
//! everywhere.

/// Number of partial sums.
pub(super) const PARTS: usize = 8;

/// Sum of lanes.
#[inline(always)]
pub(super) fn sum(values: &[f64]) -> f64 {
    let (whole, rest) = values.as_chunks::<PARTS>();
    let mut parts = [0.0; PARTS];
    for values in whole {
        parts.iter_mut().zip(values).for_each(|(part, value)| *part += value);
    }
    parts.iter_mut().zip(rest).for_each(|(part, value)| *part += value);
    parts.iter().sum()
}

/// Sum of the products of lanes.
#[inline(always)]
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let ((a, rest_a), (b, rest_b)) = (a.as_chunks::<PARTS>(), b.as_chunks::<PARTS>());
    let mut parts = [0.0; PARTS];
    for (a, b) in a.iter().zip(b) {
        parts.iter_mut().zip(a).zip(b).for_each(|((part, a), b)| *part += a * b);
    }
    parts.iter_mut().zip(rest_a).zip(rest_b).for_each(|((part, a), b)| *part += a * b);
    parts.iter().sum()
}

/// Minimum and maximum of the values taken.
pub(super) struct Bounds {
    low: [f64; PARTS],
    high: [f64; PARTS],
}

impl Bounds {
    /// Bounds of no values.
    pub(super) const NONE: Self = Self { low: [f64::INFINITY; PARTS], high: [f64::NEG_INFINITY; PARTS] };

    /// Takes a value into one of the parts.
    #[inline(always)]
    pub(super) fn take(&mut self, part: usize, value: f64) {
        self.low[part] = if value < self.low[part] { value } else { self.low[part] };
        self.high[part] = if value > self.high[part] { value } else { self.high[part] };
    }

    pub(super) fn range(&self) -> (f64, f64) {
        let low = self.low.iter().copied().fold(f64::INFINITY, f64::min);
        (low, self.high.iter().copied().fold(f64::NEG_INFINITY, f64::max))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_and_bounds_take_up_every_lane_once() {
        for count in [0, 1, 7, 8, 9, 31] {
            let values: Vec<f64> = (1..=count).map(f64::from).collect();
            let count = f64::from(count);
            assert_eq!(sum(&values), 0.5 * count * (count + 1.0));
            assert_eq!(dot(&values, &values), count * (count + 1.0) * (2.0 * count + 1.0) / 6.0);
        }
        let mut bounds = Bounds::NONE;
        [3.0, -2.0, 5.0].into_iter().enumerate().for_each(|(part, value)| bounds.take(part, value));
        assert_eq!(bounds.range(), (-2.0, 5.0));
    }
}
