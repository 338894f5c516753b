//! Transcendental functions without branches or calls, for SIMD lanes: every lane gives the same bits at any position,
//! on every machine. Relative errors are below 1e-15; that of [`pow`] is below 1e-15 · (1 + |b ln a|).
//!
//! Range reduction after Cody and Waite 1980: a multiple of ln 2 is subtracted in two parts, and the Taylor series is
//! evaluated at the remainder.

use std::f64::consts::{FRAC_2_PI, LOG2_E, SQRT_2};

/// Adding and subtracting it rounds to the nearest integer, ties to even.
const ROUNDING_OFFSET: f64 = 6_755_399_441_055_744.0;
/// ln 2 in two parts; the first has 21 trailing zero bits, so its multiples by exponents are exact.
const LN2_HIGH: f64 = f64::from_bits(0x3fe6_2e42_fee0_0000);
const LN2_LOW: f64 = 1.908_214_929_270_587_7e-10;
/// Number of fraction bits of a double.
const FRACTION_BITS: u32 = 52;
/// Exponent bits of 1.0.
const ONE_BITS: u64 = 0x3ff0_0000_0000_0000;

/// 1/n! for n = 13 down to 2.
const EXP_SERIES: [f64; 12] = [
    1.0 / 6_227_020_800.0,
    1.0 / 479_001_600.0,
    1.0 / 39_916_800.0,
    1.0 / 3_628_800.0,
    1.0 / 362_880.0,
    1.0 / 40_320.0,
    1.0 / 5_040.0,
    1.0 / 720.0,
    1.0 / 120.0,
    1.0 / 24.0,
    1.0 / 6.0,
    0.5,
];

/// 1/(2n + 1) for n = 12 down to 1, of the series of atanh.
const ATANH_SERIES: [f64; 12] = [
    1.0 / 25.0,
    1.0 / 23.0,
    1.0 / 21.0,
    1.0 / 19.0,
    1.0 / 17.0,
    1.0 / 15.0,
    1.0 / 13.0,
    1.0 / 11.0,
    1.0 / 9.0,
    1.0 / 7.0,
    1.0 / 5.0,
    1.0 / 3.0,
];

/// π/2 in three parts; the first two have 19 trailing zero bits.
const RIGHT_ANGLE: [f64; 3] =
    [f64::from_bits(0x3ff9_21fb_5440_0000), f64::from_bits(0x3dd0_b461_1a60_0000), 2.0222662487959506e-21];

/// (−1)^n/(2n + 1)! for n = 8 down to 1.
const SINE_SERIES: [f64; 8] = [
    1.0 / 355_687_428_096_000.0,
    -1.0 / 1_307_674_368_000.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 39_916_800.0,
    1.0 / 362_880.0,
    -1.0 / 5_040.0,
    1.0 / 120.0,
    -1.0 / 6.0,
];

/// (−1)^n/(2n)! for n = 9 down to 2.
const COSINE_SERIES: [f64; 8] = [
    -1.0 / 6_402_373_705_728_000.0,
    1.0 / 20_922_789_888_000.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 479_001_600.0,
    -1.0 / 3_628_800.0,
    1.0 / 40_320.0,
    -1.0 / 720.0,
    1.0 / 24.0,
];

/// `2^n` for an integer n from -1022 to 1023.
#[inline(always)]
fn power_of_two(n: f64) -> f64 {
    let whole = (n + ROUNDING_OFFSET).to_bits().wrapping_sub(ROUNDING_OFFSET.to_bits());
    f64::from_bits(whole.wrapping_shl(FRACTION_BITS).wrapping_add(ONE_BITS))
}

/// Evaluates a polynomial, highest power first. Odd and even powers are summed separately, so that the two sums run in
/// parallel.
#[inline(always)]
fn polynomial(coefficients: &[f64; 12], x: f64) -> f64 {
    let square = x * x;
    let [mut odd, mut even] = [coefficients[0], coefficients[1]];
    for i in 1..6 {
        odd = odd * square + coefficients[2 * i];
        even = even * square + coefficients[2 * i + 1];
    }
    odd * x + even
}

/// `x = n ln 2 + r`, |r| ≤ ln 2 / 2: n, and e^r − 1.
#[inline(always)]
fn reduced_exp(x: f64) -> (f64, f64) {
    let n = (x * LOG2_E + ROUNDING_OFFSET) - ROUNDING_OFFSET;
    let r = (x - n * LN2_HIGH) - n * LN2_LOW;
    (n, r + r * r * polynomial(&EXP_SERIES, r))
}

/// e to the power x.
#[inline(always)]
pub fn exp(x: f64) -> f64 {
    let x = if x > 710.0 { 710.0 } else { x };
    let x = if x < -746.0 { -746.0 } else { x };
    let (n, above_one) = reduced_exp(x);
    // Two factors, because 2^n alone may overflow or underflow where the product does not.
    let half = (n * 0.5 + ROUNDING_OFFSET) - ROUNDING_OFFSET;
    (1.0 + above_one) * power_of_two(half) * power_of_two(n - half)
}

/// Hyperbolic tangent.
#[inline(always)]
pub fn tanh(x: f64) -> f64 {
    let twice = 2.0 * x.abs();
    let twice = if twice > 40.0 { 40.0 } else { twice };
    let (n, above_one) = reduced_exp(twice);
    let scale = power_of_two(n);
    // e^2|x| − 1 without cancellation
    let grown = scale * above_one + (scale - 1.0);
    let size = grown / (grown + 2.0);
    if x < 0.0 { -size } else { size }
}

/// Natural logarithm; NaN below zero, −∞ at zero.
#[inline(always)]
pub fn log(x: f64) -> f64 {
    const SUBNORMAL_SHIFT: f64 = 18_014_398_509_481_984.0; // 2^54
    let tiny = x < f64::MIN_POSITIVE;
    let scaled = if tiny { x * SUBNORMAL_SHIFT } else { x };
    let shift = if tiny { 54.0 } else { 0.0 };

    // x = 2^n m, m between sqrt(1/2) and sqrt(2)
    let lowest = (0.5 * SQRT_2).to_bits();
    let bits = scaled.to_bits();
    let biased = bits.wrapping_add(ONE_BITS.wrapping_sub(lowest)) >> FRACTION_BITS;
    let m = f64::from_bits(bits.wrapping_sub((biased << FRACTION_BITS).wrapping_sub(ONE_BITS)));
    let n = (f64::from_bits(biased | 0x4330_0000_0000_0000) - 4_503_599_627_370_496.0) - (1023.0 + shift);

    // ln m = 2 atanh((m − 1)/(m + 1)) = s (2 + 2 s²/3 + …); 2 s = f − s f, which rounds less
    let f = m - 1.0;
    let s = f / (2.0 + f);
    let square = s * s;
    let log_m = f - s * (f - 2.0 * square * polynomial(&ATANH_SERIES, square));
    let result = n * LN2_HIGH + (log_m + n * LN2_LOW);

    let result = if x == f64::INFINITY { x } else { result };
    let result = if x == 0.0 { f64::NEG_INFINITY } else { result };
    if (x < 0.0) | x.is_nan() { f64::NAN } else { result }
}

/// a to the power b for a ≥ 0, NaN for a < 0; exactly 1 for b = 0 and exactly a for b = 1.
#[inline(always)]
pub fn pow(a: f64, b: f64) -> f64 {
    let result = exp(b * log(a));
    let result = if b == 1.0 { a } else { result };
    let result = if b == 0.0 { 1.0 } else { result };
    if (a < 0.0) | a.is_nan() | b.is_nan() { f64::NAN } else { result }
}

/// `x = n π/2 + r`, |r| ≤ π/4: n modulo 4, and r.
#[inline(always)]
fn reduced_angle(x: f64) -> (f64, f64) {
    let n = (x * FRAC_2_PI + ROUNDING_OFFSET) - ROUNDING_OFFSET;
    let r = ((x - n * RIGHT_ANGLE[0]) - n * RIGHT_ANGLE[1]) - n * RIGHT_ANGLE[2];
    // floor(n/4): n/4 − 3/8 is at most 3/8 from it, so that it rounds to it.
    let fours = (n * 0.25 - 0.375 + ROUNDING_OFFSET) - ROUNDING_OFFSET;
    (n - 4.0 * fours, r)
}

/// Sine from the quadrant and the reduced angle.
#[inline(always)]
fn sine_in_quadrant(quadrant: f64, r: f64) -> f64 {
    let square = r * r;
    let (mut odd, mut even) = (SINE_SERIES[0], COSINE_SERIES[0]);
    for (sine, cosine) in SINE_SERIES[1..].iter().zip(&COSINE_SERIES[1..]) {
        odd = odd * square + sine;
        even = even * square + cosine;
    }
    let sine = r + r * square * odd;
    let cosine = 1.0 - square * (0.5 - square * even);
    let size = if (quadrant == 1.0) | (quadrant == 3.0) { cosine } else { sine };
    if quadrant >= 2.0 { -size } else { size }
}

/// Sine, to 1e-15 for |x| up to 1e5.
#[inline(always)]
pub fn sin(x: f64) -> f64 {
    let (quadrant, r) = reduced_angle(x);
    sine_in_quadrant(quadrant, r)
}

/// Cosine, to 1e-15 for |x| up to 1e5.
#[inline(always)]
pub fn cos(x: f64) -> f64 {
    let (quadrant, r) = reduced_angle(x);
    let next = quadrant + 1.0;
    sine_in_quadrant(if next == 4.0 { 0.0 } else { next }, r)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sweep(low: f64, high: f64) -> impl Iterator<Item = f64> {
        (0..=40_000).map(move |i| low + (high - low) * f64::from(i) / 40_000.0)
    }

    #[track_caller]
    fn close(x: f64, found: f64, expected: f64, tolerance: f64) {
        let error = if expected == 0.0 { found.abs() } else { ((found - expected) / expected).abs() };
        assert!(error <= tolerance, "at {x:?}: {found:?}, expected {expected:?}, off by {error:e}");
    }

    #[test]
    fn functions_agree_with_the_standard_library_to_1e_15() {
        for x in sweep(-700.0, 700.0).chain(sweep(-1.0, 1.0)).chain(sweep(-1e-6, 1e-6)) {
            close(x, exp(x), x.exp(), 1e-15);
            close(x, tanh(x), x.tanh(), 1e-15);
        }
        for x in sweep(-700.0, 700.0).map(f64::exp).chain(sweep(0.5, 2.0)).chain(sweep(1.0 - 1e-8, 1.0 + 1e-8)) {
            close(x, log(x), x.ln(), 1e-15);
        }
        for x in sweep(0.01, 20.0) {
            for b in [-1.5, -0.37, 0.1, 0.9, 1.3, 4.2] {
                close(x, pow(x, b), x.powf(b), 2e-15 * (1.0 + (b * x.ln()).abs()));
            }
        }
    }

    #[test]
    fn sine_and_cosine_agree_with_the_standard_library() {
        for x in sweep(-8.0, 8.0).chain(sweep(-1e5, 1e5)) {
            assert!((sin(x) - x.sin()).abs() < 1e-15 && (cos(x) - x.cos()).abs() < 1e-15, "at {x:?}");
        }
        assert_eq!([sin(0.0), cos(0.0)], [0.0, 1.0]);
    }

    #[test]
    fn ends_of_the_range_are_as_the_standard_library_has_them() {
        for x in [-1e300, -800.0, -745.2, -740.0, -0.0, 0.0, 709.7, 709.8, 1e300, f64::INFINITY, f64::NEG_INFINITY] {
            close(x, exp(x).min(f64::MAX), x.exp().min(f64::MAX), if x < -708.0 { 1e-2 } else { 1e-15 });
            close(x, tanh(x), x.tanh(), 1e-15);
        }
        for x in [5e-324, 1e-310, 2.2e-308, 1.0, 1e308] {
            close(x, log(x), x.ln(), 1e-15);
        }
        assert_eq!(
            [exp(0.0), log(1.0), tanh(0.0), pow(0.0, 0.0), pow(7.3, 1.0), pow(0.0, 2.5)],
            [1.0, 0.0, 0.0, 1.0, 7.3, 0.0]
        );
        assert_eq!([log(0.0), log(f64::INFINITY), pow(0.0, -1.0)], [f64::NEG_INFINITY, f64::INFINITY, f64::INFINITY]);
        assert!([log(-1.0), pow(-1.0, 0.5), exp(f64::NAN), tanh(f64::NAN), log(f64::NAN)].iter().all(|v| v.is_nan()));
    }
}
