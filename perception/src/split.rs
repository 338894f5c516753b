//! States of the coating in a set, splits into training, validation and test, and orders in which every prefix is
//! representative.

use paths::Pattern;
use serde::{Deserialize, Serialize};

/// State of the coating in an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", tag = "kind")]
pub enum Treatment {
    /// Unsanded: the dose is 0 everywhere.
    Unsanded,
    /// Sanded along a pattern, up to a stage.
    Stage {
        /// Path of the pad.
        pattern: Pattern,
        /// Number of completed parts of the path, from 1.
        stage: u32,
    },
    /// Bare: the dose is 1 everywhere.
    Bare,
}

/// Split of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Split {
    /// Training.
    Train,
    /// Validation.
    Validation,
    /// Test.
    Test,
}

/// Unit by which the images are split: all images of one unit are in one split.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SplitBy {
    /// Workpieces: a test shows shapes that training never saw.
    Workpiece,
    /// Placements, as in the paper: a test shows known workpieces in other poses.
    Placement,
}

impl Treatment {
    /// Returns the name in files.
    pub fn name(self) -> String {
        match self {
            Self::Unsanded => "unsanded".to_owned(),
            Self::Stage { pattern, stage } => format!("{}-s{stage}", pattern.name()),
            Self::Bare => "bare".to_owned(),
        }
    }
}

impl Split {
    /// All splits.
    pub const ALL: [Self; 3] = [Self::Train, Self::Validation, Self::Test];

    /// Returns the name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Train => "train",
            Self::Validation => "validation",
            Self::Test => "test",
        }
    }
}

impl SplitBy {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Workpiece, Self::Placement];

    /// Returns the name in flags and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Workpiece => "workpiece",
            Self::Placement => "placement",
        }
    }

    /// Returns a short description for the help.
    pub fn about(self) -> &'static str {
        match self {
            Self::Workpiece => "tests show workpieces that training never saw",
            Self::Placement => "tests show the same workpieces in other poses",
        }
    }
}

/// Yields every pair of one of `first` and one of `second` once; in any prefix the counts of either side differ by at
/// most one.
///
/// Pair k is (k mod `first`, (k + ⌊k / m⌋) mod `second`) with m the least common multiple of both. A run of m pairs has
/// one difference modulo the greatest common divisor, and the next run begins with the next difference.
pub fn balanced_pairs(first: usize, second: usize) -> impl Iterator<Item = (usize, usize)> {
    let run = first / greatest_common_divisor(first, second) * second;
    (0..first * second).map(move |k| (k % first, (k + k / run) % second))
}

fn greatest_common_divisor(a: usize, b: usize) -> usize {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

/// Orders placements or workpieces such that the splits alternate: the i-th of n in a split has the relative position
/// (i + ½) / n.
pub fn interleaved(splits: &[Split]) -> Vec<usize> {
    let count = |split: Split| splits.iter().filter(|&&other| other == split).count();
    let mut taken = [0; Split::ALL.len()];
    let mut order: Vec<(usize, usize, Split, usize)> = Vec::new();
    for (placement, &split) in splits.iter().enumerate() {
        let rank = &mut taken[split as usize];
        order.push((2 * *rank + 1, 2 * count(split), split, placement));
        *rank += 1;
    }
    // Fractions are compared by their cross products, so that equal fractions compare equal.
    order.sort_by(|a, b| (a.0 * b.1).cmp(&(b.0 * a.1)).then((a.2, a.3).cmp(&(b.2, b.3))));
    order.into_iter().map(|(.., placement)| placement).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_prefix_of_the_pairs_is_even_on_both_sides() {
        let all: Vec<(usize, usize)> = balanced_pairs(6, 4).collect();
        let distinct: std::collections::BTreeSet<_> = all.iter().collect();
        assert_eq!((all.len(), distinct.len()), (24, 24));
        for limit in 1..=24 {
            let count = |side: &dyn Fn(&(usize, usize)) -> usize, at: usize| {
                all[..limit].iter().filter(|pair| side(pair) == at).count()
            };
            let first: Vec<usize> = (0..6).map(|at| count(&|pair| pair.0, at)).collect();
            let second: Vec<usize> = (0..4).map(|at| count(&|pair| pair.1, at)).collect();
            for counts in [first, second] {
                assert!(counts.iter().max().unwrap() - counts.iter().min().unwrap() <= 1, "{counts:?} of {limit}");
            }
        }
    }

    #[test]
    fn splits_alternate() {
        use Split::{Test, Train, Validation};
        let order = interleaved(&[Train, Train, Train, Train, Validation, Test]);
        assert_eq!(order, [0, 1, 4, 5, 2, 3]);
    }
}
