//! Numbers formatted for people.

use study::superscript;

use crate::Cell;

/// Formats a number with `digits` significant digits, a true minus sign, and a power of ten if it is very small or
/// large.
pub(super) fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let scientific = format!("{value:.*e}", digits.saturating_sub(1));
    let (mantissa, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let power: i32 = exponent.parse().unwrap_or(0);
    let text = if value == 0.0 {
        "0".to_owned()
    } else if (-3..6).contains(&power) {
        format!("{value:.*}", (digits as i32 - 1 - power).max(0) as usize)
    } else {
        format!("{mantissa} × 10{}", superscript(power))
    };
    text.replace('-', "−")
}

/// Formats a share as a percentage with one decimal.
pub(super) fn percent(share: f64) -> String {
    if share.is_finite() { format!("{} %", fixed(100.0 * share, 1)) } else { "–".to_owned() }
}

/// Formats a p-value, never as zero.
pub(super) fn p_value(p: f64) -> String {
    if p < 0.001 { "< 0.001".to_owned() } else { format!("{p:.3}") }
}

/// Makes a cell of an SI value, shown in another unit with `digits` significant digits.
pub(super) fn cell(si: Option<f64>, si_per_unit: f64, digits: usize) -> Cell {
    match si.filter(|value| value.is_finite()) {
        Some(value) => Cell::number(significant(value / si_per_unit, digits), value),
        None => Cell::absent(),
    }
}

/// Makes a cell of an SI value, shown in another unit with `decimals` decimals.
pub(super) fn fixed_cell(si: Option<f64>, si_per_unit: f64, decimals: usize) -> Cell {
    match si.filter(|value| value.is_finite()) {
        Some(value) => Cell::number(fixed(value / si_per_unit, decimals), value),
        None => Cell::absent(),
    }
}

/// Formats a number with `decimals` decimals and a true minus sign, never "−0".
pub(super) fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    if text.trim_start_matches('-').chars().all(|c| matches!(c, '0' | '.')) {
        text.trim_start_matches('-').to_owned()
    } else {
        text.replace('-', "−")
    }
}

/// Makes a cell of a share as a percentage.
pub(super) fn share_cell(share: Option<f64>) -> Cell {
    match share.filter(|share| share.is_finite()) {
        Some(share) => Cell::number(percent(share), share),
        None => Cell::absent(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_their_digits_at_any_size() {
        assert_eq!(significant(1.2345e-13, 3), "1.23 × 10⁻¹³");
        assert_eq!(significant(-0.012345, 3), "−0.0123");
        assert_eq!(significant(123.45, 3), "123");
        assert_eq!(significant(9.999, 2), "10");
        assert_eq!(significant(0.0, 3), "0");
        assert_eq!(significant(f64::NAN, 3), "–");
        assert_eq!(fixed(-0.001, 1), "0.0");
        assert_eq!(fixed(-0.26, 1), "−0.3");
        assert_eq!(p_value(0.0), "< 0.001");
    }

    #[test]
    fn a_share_that_rounds_to_zero_has_no_sign() {
        assert_eq!(percent(-4e-4), "0.0 %");
        assert_eq!(percent(-6e-4), "−0.1 %");
        assert_eq!(percent(f64::NAN), "–");
    }
}
