//! φ along a ray within one cell is a cubic polynomial (Parker et al. 1998); the surface is at its first root.

use super::lanes::{LANES, Lanes, any};
use shaders::constants::{CUBIC_RESOLUTION, CUBIC_STEPS};

/// First position (0 to 1) at which a cubic is zero or negative; `None` if it stays positive.
///
/// `values`: the cubic at 0, 1/3, 2/3 and 1. The interval is split at the extrema; between them the cubic is monotone,
/// so bracketing misses no root (Marmitt et al. 2004).
pub(crate) fn first_root(values: [f32; 4]) -> Option<f32> {
    if values[0] <= 0.0 {
        return Some(0.0);
    }
    let cubic = coefficients(values);
    let mut low = 0.0;
    for high in extrema(cubic).into_iter().flatten().chain([3.0]) {
        if at(cubic, high) <= 0.0 {
            return Some(root_between(cubic, low, high) / 3.0);
        }
        low = high;
    }
    // Rounding may move the polynomial above its own last value.
    (values[3] <= 0.0).then_some(1.0)
}

/// Power coefficients in u = 3 s, lowest first, from forward differences.
#[inline(always)]
fn coefficients([f0, f1, f2, f3]: [f32; 4]) -> [f32; 4] {
    let (first, second, third) = (f1 - f0, f2 - 2.0 * f1 + f0, f3 - 3.0 * (f2 - f1) - f0);
    [f0, first - second / 2.0 + third / 3.0, (second - third) / 2.0, third / 6.0]
}

#[inline(always)]
fn at([a, b, c, d]: [f32; 4], u: f32) -> f32 {
    a + u * (b + u * (c + u * d))
}

/// Positions of the extrema within (0, 3), in order.
fn extrema(cubic: [f32; 4]) -> [Option<f32>; 2] {
    turns(cubic).map(|(u, is_within)| is_within.then_some(u))
}

/// Positions of the extrema in order, each with a flag that is true if it lies within (0, 3).
#[inline(always)]
fn turns([_, b, c, d]: [f32; 4]) -> [(f32, bool); 2] {
    // Roots of 3 d u² + 2 c u + b in the form that neither divides by a small d nor cancels.
    let root = (c * c - 3.0 * d * b).max(0.0).sqrt();
    let q = -(c + root.copysign(c));
    let (u, v) = (q / (3.0 * d), b / q);
    let (u, v) = if u < v { (u, v) } else { (v, u) };
    [u, v].map(|u| (u, (u > 0.0) & (u < 3.0)))
}

/// Finds the root between a position above zero and one at or below zero: Newton steps from the secant's root, and
/// bisection if a step leaves the bracket.
fn root_between(cubic: [f32; 4], mut above: f32, mut below: f32) -> f32 {
    let (high, low) = (at(cubic, above), at(cubic, below));
    let mut u = above + (below - above) * (high / (high - low));
    for _ in 0..CUBIC_STEPS {
        let value = at(cubic, u);
        if value > 0.0 {
            above = u;
        } else {
            below = u;
        }
        let newton = u - value / slope(cubic, u);
        let next = if newton >= above && newton <= below { newton } else { 0.5 * (above + below) };
        let moved = (next - u).abs();
        u = next;
        if moved < CUBIC_RESOLUTION {
            break;
        }
    }
    u
}

#[inline(always)]
fn slope([_, b, c, d]: [f32; 4], u: f32) -> f32 {
    b + u * (2.0 * c + u * (3.0 * d))
}

/// [`first_root`] for the cubic of each lane that is `wanted`; infinite if a cubic stays positive.
#[inline(always)]
pub(crate) fn first_roots(values: &[Lanes; 4], wanted: &[bool; LANES]) -> Lanes {
    let (mut cubics, mut above, mut below) = ([[0.0; LANES]; 4], [0.0; LANES], [0.0; LANES]);
    let (mut u, mut is_bracketed, mut moves) = ([0.0; LANES], [false; LANES], [false; LANES]);
    for i in 0..LANES {
        let cubic = coefficients([values[0][i], values[1][i], values[2][i], values[3][i]]);
        for power in 0..4 {
            cubics[power][i] = cubic[power];
        }
        let [(first, is_first), (second, is_second)] = turns(cubic);
        let after_first = if is_first { first } else { 0.0 };
        let after_second = if is_second { second } else { after_first };
        let (in_first, in_second) = (is_first & (at(cubic, first) <= 0.0), is_second & (at(cubic, second) <= 0.0));
        let (low, high) = if in_second { (after_first, second) } else { (after_second, 3.0) };
        (above[i], below[i]) = if in_first { (0.0, first) } else { (low, high) };
        is_bracketed[i] = in_first | in_second | (at(cubic, 3.0) <= 0.0);
        moves[i] = wanted[i] & is_bracketed[i] & (values[0][i] > 0.0);
        let (high, low) = (at(cubic, above[i]), at(cubic, below[i]));
        u[i] = above[i] + (below[i] - above[i]) * (high / (high - low));
    }
    for _ in 0..CUBIC_STEPS {
        if !any(&moves) {
            break;
        }
        for i in 0..LANES {
            let cubic = [cubics[0][i], cubics[1][i], cubics[2][i], cubics[3][i]];
            let value = at(cubic, u[i]);
            let is_above = value > 0.0;
            above[i] = if is_above { u[i] } else { above[i] };
            below[i] = if is_above { below[i] } else { u[i] };
            let newton = u[i] - value / slope(cubic, u[i]);
            let is_within = (newton >= above[i]) & (newton <= below[i]);
            let next = if is_within { newton } else { 0.5 * (above[i] + below[i]) };
            let moved = (next - u[i]).abs();
            u[i] = if moves[i] { next } else { u[i] };
            moves[i] &= moved >= CUBIC_RESOLUTION;
        }
    }
    let mut roots = [0.0; LANES];
    for i in 0..LANES {
        let last = if values[3][i] <= 0.0 { 1.0 } else { f32::INFINITY };
        let root = if is_bracketed[i] { u[i] / 3.0 } else { last };
        roots[i] = if values[0][i] <= 0.0 { 0.0 } else { root };
    }
    roots
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_find_the_roots_that_each_has_alone() {
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / 8_388_608.0 - 1.0
        };
        let mut found = 0;
        for _ in 0..500 {
            let lift = random();
            let values: [Lanes; 4] = std::array::from_fn(|_| std::array::from_fn(|_| random() + lift));
            let roots = first_roots(&values, &[true; LANES]);
            for i in 0..LANES {
                let alone = first_root(values.map(|lanes| lanes[i]));
                assert_eq!(Some(roots[i]).filter(|root| root.is_finite()), alone);
                found += usize::from(alone.is_some_and(|root| root > 0.0));
            }
        }
        assert!(found > 1000, "{found}");
    }

    fn sampled(f: impl Fn(f32) -> f32) -> [f32; 4] {
        [f(0.0), f(1.0 / 3.0), f(2.0 / 3.0), f(1.0)]
    }

    #[test]
    fn the_first_of_three_roots_is_found() {
        let root = first_root(sampled(|s| (0.2 - s) * (s - 0.5) * (s - 0.9))).unwrap();
        assert!((root - 0.2).abs() < 1e-5, "{root}");
    }

    #[test]
    fn a_dip_between_positive_ends_is_found() {
        let root = first_root(sampled(|s| (s - 0.4) * (s - 0.45))).unwrap();
        assert!((root - 0.4).abs() < 1e-4, "{root}");
        assert_eq!(first_root(sampled(|s| (s - 0.4) * (s - 0.4) + 0.001)), None);
    }

    #[test]
    fn lines_and_constants_are_cubics_too() {
        let root = first_root(sampled(|s| 0.3 - s)).unwrap();
        assert!((root - 0.3).abs() < 1e-5, "{root}");
        assert_eq!(first_root([1.0; 4]), None);
        assert_eq!(first_root([-1.0; 4]), Some(0.0));
        assert_eq!(first_root([f32::NAN; 4]), None);
    }
}
