//! Statistics that are robust against outliers.

/// Ratio of a normal distribution's standard deviation to its median absolute deviation.
pub const MAD_TO_SIGMA: f64 = 1.4826;

/// Median (the upper one of an even number); `None` for no values.
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Median, and 1.4826 times the median absolute deviation; `None` for no values.
pub fn centre_and_sigma(values: &[f64]) -> Option<(f64, f64)> {
    let centre = median(values.to_vec())?;
    let sigma = median(values.iter().map(|value| (value - centre).abs()).collect())?;
    Some((centre, MAD_TO_SIGMA * sigma))
}
