//! Root of φ on a lattice line where it crosses the surface; shared by contact, channels and profilometer.

use sdf_bake::simd::in_wide_lanes;
use shaders::constants::WITHIN_BAND;

/// Crossings of several lines; their roots are found together, in the processor's widest SIMD lanes.
#[derive(Debug, Default)]
pub(crate) struct Crossings {
    /// Values at -1, 0, 1 and 2 voxels of each crossing [m].
    values: [Vec<f64>; 4],
    roots: Vec<f64>,
}

impl Crossings {
    /// Removes all.
    pub(crate) fn clear(&mut self) {
        self.values.iter_mut().for_each(Vec::clear);
    }

    /// Adds a crossing.
    pub(crate) fn push(&mut self, values: [f64; 4]) {
        self.values.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
    }

    /// Returns [`way_to_zero`] of each crossing.
    pub(crate) fn ways(&mut self, band: f64) -> &[f64] {
        let Self { values: [before, a, b, after], roots } = self;
        let count = before.len();
        roots.resize(count, 0.0);
        in_wide_lanes(
            #[inline(always)]
            || {
                let (before, a, b, after) = (&before[..count], &a[..count], &b[..count], &after[..count]);
                for (i, root) in roots.iter_mut().enumerate() {
                    *root = way_to_zero([before[i], a[i], b[i], after[i]], band);
                }
            },
        );
        &self.roots
    }
}

/// Position of the zero of φ on a lattice line [voxels, 0 to 1], from `values` [m] at -1, 0, 1 and 2 voxels; the middle
/// two differ in sign. It is the root of the cubic through all four, fourth order where φ is smooth. Where one of them
/// is beyond the `band` [m] it is the root of the chord.
#[inline(always)]
pub(crate) fn way_to_zero(values: [f64; 4], band: f64) -> f64 {
    let most = WITHIN_BAND * band;
    let is_known = values.map(|value| value.abs() < most);
    let (cubic, linear) = (cubic_root(values), linear_root(values));
    if is_known[0] & is_known[1] & is_known[2] & is_known[3] { cubic } else { linear }
}

#[inline(always)]
fn linear_root([_, a, b, _]: [f64; 4]) -> f64 {
    a / (a - b)
}

/// Root in 0 to 1 of the cubic through values at -1, 0, 1 and 2; the middle two differ in sign.
#[inline(always)]
fn cubic_root(values: [f64; 4]) -> f64 {
    let [before, a, b, after] = values;
    // Newton's divided differences about 0 and 1.
    let (second, last) = (0.5 * (before - 2.0 * a + b), 0.5 * (a - 2.0 * b + after));
    let third = (last - second) / 3.0;
    let mut t = linear_root(values);
    for _ in 0..3 {
        // a + (b-a) t + (second + third (t + 1)) t (t-1)
        let bend = second + third * (t + 1.0);
        let value = a + (b - a) * t + bend * t * (t - 1.0);
        let slope = (b - a) + bend * (2.0 * t - 1.0) + third * t * (t - 1.0);
        t = (t - value / slope).clamp(0.0, 1.0);
    }
    if t.is_finite() { t } else { linear_root(values) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_met_exactly_and_the_bands_end_by_its_chord() {
        for root in [0.02, 0.37, 0.5, 0.81, 0.99] {
            let cubic = |t: f64| (t - root) * (1.0 + 0.2 * t + 0.1 * t * t);
            let values = [-1.0, 0.0, 1.0, 2.0].map(cubic);
            assert!((way_to_zero(values, 10.0) - root).abs() < 1e-9, "{}", way_to_zero(values, 10.0) - root);
            let chord = values[1] / (values[1] - values[2]);
            assert_eq!(way_to_zero(values, values[3]), chord);
        }
    }
}
