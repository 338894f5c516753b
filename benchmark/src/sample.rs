//! Representative part of the list of cases.

use std::collections::BTreeMap;

use random::Stream;

use super::cases::{Case, Family};

/// Stratified sample of at most `most` cases: each family keeps its share, and one case is drawn from each stretch of a
/// family, so that effects and rungs are sampled evenly. Returns all cases if there are no more.
pub fn sample(cases: Vec<Case>, most: usize, seed: u64) -> Vec<Case> {
    let all = cases.len();
    if all <= most {
        return cases;
    }
    let mut families: BTreeMap<Family, Vec<Case>> = BTreeMap::new();
    cases.into_iter().for_each(|case| families.entry(case.family).or_default().push(case));
    // Rounded cumulative shares of the families, so that the sum is `most`.
    let mut before = 0;
    let mut kept = Vec::new();
    for (family, cases) in families {
        let end = |count: usize| (count * most + all / 2) / all;
        let share = end(before + cases.len()) - end(before);
        before += cases.len();
        let mut stream = Stream::of(seed, &format!("sample of {family:?}"));
        let edge = |k: usize| k * cases.len() / share;
        kept.extend((0..share).map(|k| cases[edge(k) + stream.below(edge(k + 1) - edge(k))].clone()));
    }
    kept
}

#[cfg(test)]
mod tests {
    use effects::Library;

    use super::super::cases::cases;
    use super::*;

    #[test]
    fn a_sample_keeps_each_familys_share_and_takes_no_case_twice() {
        let all = cases(&[Family::N, Family::S, Family::U], 40, 3, Library::builtin());
        let some = sample(all.clone(), 31, 3);
        assert_eq!(some.len(), 31);
        for family in [Family::N, Family::S, Family::U] {
            let own: Vec<usize> = some.iter().filter(|c| c.family == family).map(|c| c.number).collect();
            assert!((10..=11).contains(&own.len()) && own.windows(2).all(|pair| pair[0] < pair[1]), "{own:?}");
        }
        assert_eq!(sample(all.clone(), 31, 3), some, "the same seed draws the same");
        assert_ne!(sample(all.clone(), 31, 4), some);
        assert_eq!(sample(all.clone(), 1000, 3).len(), all.len());
    }
}
