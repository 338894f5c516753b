//! Size from which an effect is named, estimated by simulation of the actual rule.

use serde::Serialize;

/// Shares of the cases at which the size is reported.
const POWERS: [f64; 2] = [0.5, 0.9];
/// Least number of cases for which a size is reported.
const LEAST_CASES: usize = 4;

/// Size from which an effect is named.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Power {
    /// The effect and the process.
    pub effect: String,
    /// Number of cases.
    pub cases: usize,
    /// Least and greatest rung that was tried, relative to the visible size.
    pub tried: [f64; 2],
    /// Rung from which half of the cases are named; `None` if no rung is large enough.
    pub half: Option<f64>,
    /// The same for nine of ten.
    pub nine_of_ten: Option<f64>,
}

impl Power {
    /// Computes the sizes from rungs, each with true if the effect was named. `None` if there are too few cases or
    /// rungs.
    pub fn new(effect: String, tried: &[(f64, bool)]) -> Option<Self> {
        let curve = isotonic(tried);
        let (first, last) = (curve.first()?.0, curve.last()?.0);
        let [half, nine_of_ten] = POWERS.map(|power| reaching(&curve, power));
        let is_enough = tried.len() >= LEAST_CASES && first < last;
        is_enough.then_some(Self { effect, cases: tried.len(), tried: [first, last], half, nine_of_ten })
    }
}

/// Isotonic regression: share of successes at each size, the non-decreasing least-squares fit (Ayer et al. 1955).
fn isotonic(tried: &[(f64, bool)]) -> Vec<(f64, f64)> {
    let mut sorted = tried.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Pools of sizes with their cases and successes.
    let mut pools: Vec<(Vec<f64>, f64, f64)> = Vec::new();
    for (size, is_named) in sorted {
        let hit = f64::from(u8::from(is_named));
        match pools.last_mut().filter(|pool| pool.0 == [size]) {
            Some(pool) => (pool.1, pool.2) = (pool.1 + 1.0, pool.2 + hit),
            None => pools.push((vec![size], 1.0, hit)),
        }
    }
    let mut rising: Vec<(Vec<f64>, f64, f64)> = Vec::new();
    for pool in pools {
        rising.push(pool);
        while let [.., before, last] = rising.as_slice() {
            if before.2 / before.1 <= last.2 / last.1 {
                break;
            }
            let (sizes, cases, hits) = rising.pop().expect("there are two");
            let before = rising.last_mut().expect("there are two");
            before.0.extend(sizes);
            (before.1, before.2) = (before.1 + cases, before.2 + hits);
        }
    }
    rising.iter().flat_map(|(sizes, cases, hits)| sizes.iter().map(move |size| (*size, hits / cases))).collect()
}

/// Size at which a rising curve reaches a share, interpolated in the logarithm of the size; the least size if the curve
/// starts above.
fn reaching(curve: &[(f64, f64)], share: f64) -> Option<f64> {
    let at = curve.iter().position(|(_, reached)| *reached >= share)?;
    let (size, reached) = curve[at];
    let Some(&(before, below)) = at.checked_sub(1).and_then(|k| curve.get(k)) else { return Some(size) };
    Some(before * (size / before).powf((share - below) / (reached - below)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_that_fall_are_pooled() {
        let tried = [(0.25, false), (0.25, true), (0.5, false), (0.5, false), (1.0, true), (2.0, true)];
        // A half and then none: a quarter of four.
        assert_eq!(isotonic(&tried), [(0.25, 0.25), (0.5, 0.25), (1.0, 1.0), (2.0, 1.0)]);
    }

    #[test]
    fn a_size_lies_between_the_rungs_on_both_sides_of_the_share() {
        let tried = [(0.25, false), (0.25, false), (1.0, false), (1.0, true), (4.0, true), (4.0, true)];
        let power = Power::new("tilt".to_owned(), &tried).expect("enough cases");
        assert_eq!((power.cases, power.tried, power.half), (6, [0.25, 4.0], Some(1.0)));
        // From 0.5 at 1 to 1 at 4: 0.9 is reached at four fifths of the distance.
        assert!((power.nine_of_ten.expect("reached") - 4f64.powf(0.8)).abs() < 1e-12);
        let never = [(0.25, false), (1.0, false), (2.0, false), (4.0, true), (4.0, false)];
        let power = Power::new("tilt".to_owned(), &never).expect("enough cases");
        assert_eq!((power.half, power.nine_of_ten), (Some(4.0), None));
        assert_eq!(Power::new("tilt".to_owned(), &[(1.0, true); 5]), None, "one rung says nothing");
    }
}
