//! Means of `max(d, 0)` over a rectangle for a linear depth d: the integrals of a cell that the patch's rim clips.

/// Spans below this share of the depth scale count as zero, to avoid a division by almost zero.
const FLAT: f64 = 1e-14;

/// Mean of `max(depth + x + y, 0)` over |x| ≤ spans.0, |y| ≤ spans.1, all in metres.
pub(crate) fn ramp_mean(depth: f64, spans: (f64, f64)) -> f64 {
    let (wide, narrow) = (spans.0.max(spans.1), spans.0.min(spans.1));
    if is_flat(narrow, wide) {
        return ramp(depth, wide);
    }
    (ramp_integral(depth + narrow, wide) - ramp_integral(depth - narrow, wide)) / (2.0 * narrow)
}

/// Share of the same rectangle on which `depth + x + y` is positive.
#[inline(always)]
pub(crate) fn wet_share(depth: f64, (a, b): (f64, f64)) -> f64 {
    let (wide, narrow) = (if a > b { a } else { b }, if a > b { b } else { a });
    // Both branches are computed, because SIMD lanes cannot branch.
    let sharp = step(depth, wide);
    let blurred = (ramp(depth + narrow, wide) - ramp(depth - narrow, wide)) / (2.0 * narrow);
    if is_flat(narrow, wide) { sharp } else { blurred }
}

/// True if the narrow span is negligible, so that the rectangle counts as a line along its wide span.
#[inline(always)]
fn is_flat(narrow: f64, wide: f64) -> bool {
    narrow <= FLAT + 1e-6 * wide
}

/// Share of |x| ≤ span on which z + x > 0.
#[inline(always)]
fn step(z: f64, span: f64) -> f64 {
    let crossed = (z + span) / (2.0 * span);
    let most = if z >= span { 1.0 } else { crossed };
    if z <= -span { 0.0 } else { most }
}

/// Mean of max(z + x, 0) over |x| ≤ span.
#[inline(always)]
fn ramp(z: f64, span: f64) -> f64 {
    let crossed = (z + span) * (z + span) / (4.0 * span);
    let least = if z <= -span { 0.0 } else { crossed };
    if z >= span { z } else { least }
}

/// ∫ ramp dz from -∞ to z.
fn ramp_integral(z: f64, span: f64) -> f64 {
    if z >= span {
        0.5 * z * z + span * span / 6.0
    } else if z <= -span {
        0.0
    } else {
        (z + span).powi(3) / (12.0 * span)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_agree_with_a_sum_over_many_points() {
        for depth in [-1.3, -0.7, -0.1, 0.0, 0.4, 0.9, 1.6] {
            for spans in [(1.0, 0.5), (0.3, 0.9), (0.0, 0.8), (0.6, 0.6), (0.0, 0.0)] {
                let (mut mean, mut wet) = (0.0, 0.0);
                let n = 400;
                for i in 0..n * n {
                    let at = |j: usize, span: f64| ((j as f64 + 0.5) / n as f64 * 2.0 - 1.0) * span;
                    let value: f64 = depth + at(i / n, spans.0) + at(i % n, spans.1);
                    mean += value.max(0.0) / (n * n) as f64;
                    wet += if value > 0.0 { 1.0 / (n * n) as f64 } else { 0.0 };
                }
                assert!((ramp_mean(depth, spans) - mean).abs() < 1e-5, "{depth} {spans:?}");
                assert!((wet_share(depth, spans) - wet).abs() < 6e-3, "{depth} {spans:?}");
            }
        }
    }
}
