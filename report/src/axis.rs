//! Axes of drawings: ranges, round ticks, and their labels.

use study::superscript;

/// Linear map of a data range to a range of drawing units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    pub(crate) low: f64,
    pub(crate) high: f64,
    pub(crate) start: f64,
    pub(crate) end: f64,
}

impl Axis {
    pub(crate) fn at(&self, value: f64) -> f64 {
        self.start + (value - self.low) / (self.high - self.low) * (self.end - self.start)
    }

    /// Returns about `count` round values at distances of 1, 2 or 5 times a power of ten.
    pub(crate) fn ticks(&self, count: usize) -> Vec<f64> {
        self.ticks_apart(count, 0.0)
    }

    /// Returns [`Axis::ticks`] at whole numbers, for counts.
    pub(crate) fn whole_ticks(&self, count: usize) -> Vec<f64> {
        self.ticks_apart(count, 1.0)
    }

    fn ticks_apart(&self, count: usize, least: f64) -> Vec<f64> {
        let rough = (self.high - self.low) / count as f64;
        let power = 10f64.powf(rough.log10().floor());
        let step =
            [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|&s| s >= rough).unwrap_or(rough).max(least);
        // The tolerance keeps a tick at the end of the range despite rounding.
        let first = (self.low / step - 1e-9).ceil() as i64;
        let last = (self.high / step + 1e-9).floor() as i64;
        (first..=last).map(|i| i as f64 * step).collect()
    }
}

/// Least and greatest finite value; `None` without one.
pub(crate) fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.filter(|value| value.is_finite()).fold(None, |range, value| {
        let (low, high) = range.unwrap_or((value, value));
        Some((value.min(low), value.max(high)))
    })
}

/// Formats a tick's number without needless digits.
pub(crate) fn short(value: f64) -> String {
    let text = if value != 0.0 && !(1e-4..1e6).contains(&value.abs()) {
        let text = format!("{value:.1e}").replace(".0e", "e");
        let (mantissa, power) = text.split_once('e').unwrap_or((&text, "0"));
        return format!("{mantissa} × 10{}", superscript(power.parse().unwrap_or(0))).replace('-', "−");
    } else {
        let text = format!("{value:.4}");
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    };
    if text == "-0" { "0".to_owned() } else { text.replace('-', "−") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_within_the_range() {
        let axis = Axis { low: 0.0, high: 16.2, start: 0.0, end: 1.0 };
        assert_eq!(axis.ticks(6), [0.0, 5.0, 10.0, 15.0]);
        let passes = Axis { low: 1.0, high: 2.0, start: 0.0, end: 1.0 };
        assert_eq!(passes.ticks(3), [1.0, 1.5, 2.0]);
        assert_eq!(passes.whole_ticks(3), [1.0, 2.0]);
        assert_eq!(short(0.5), "0.5");
        assert_eq!(short(-0.0), "0");
        assert_eq!(short(-2e-7), "−2 × 10⁻⁷");
    }

    #[test]
    fn a_range_leaves_out_what_is_missing() {
        assert_eq!(range([f64::NAN, 2.0, -1.0].into_iter()), Some((-1.0, 2.0)));
        assert_eq!(range([f64::NAN].into_iter()), None);
    }
}
