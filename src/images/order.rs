//! Order of the images in limited sets, such that any number of images is representative of the whole set.
//!
//! Images are pairs of a treatment and a view; a view is a pair of a placement and a workpiece; a treatment other than
//! the two references is a pair of a stage and a pattern. Each pairing uses [`pairs`], which keeps both sides even. So
//! the count of each treatment, stage, workpiece, placement and split in the first N images is within one of N times
//! its share in the whole set, and N images are among the first N + 1.

use perception::{balanced_pairs as pairs, interleaved};

use super::plan::{Planned, SplitBy};
use super::recipe::ImageRecipe;

impl ImageRecipe {
    /// Returns the first `limit` images in the order of this module; a greater limit adds to those of a smaller one.
    pub fn images_within(&self, limit: usize) -> Vec<Planned> {
        let all = self.images();
        let (treatments, views) = (self.treatment_order(), self.view_order());
        let placements = self.placements as usize;
        let position = |(view, treatment): (usize, usize)| {
            let (workpiece, placement) = views[view];
            (workpiece * placements + placement) * treatments.len() + treatments[treatment]
        };
        let positions = pairs(views.len(), treatments.len()).map(position);
        positions.take(limit).map(|position| all[position].clone()).collect()
    }

    /// Positions in the list of treatments: the unsanded reference first, the bare one halfway, stages in turn between.
    fn treatment_order(&self) -> Vec<usize> {
        let (patterns, stages) = (self.patterns.len(), self.stages as usize);
        let bare = patterns * stages + 1;
        let mut order: Vec<usize> =
            pairs(stages, patterns).map(|(stage, pattern)| 1 + pattern * stages + stage).collect();
        order.insert(0, 0);
        order.insert(bare.div_ceil(2), bare);
        order
    }

    /// Returns workpiece and placement of every view.
    fn view_order(&self) -> Vec<(usize, usize)> {
        let spread = interleaved(&self.splits());
        match self.split_by {
            SplitBy::Placement => {
                let views = pairs(spread.len(), self.workpieces.len());
                views.map(|(rank, workpiece)| (workpiece, spread[rank])).collect()
            }
            SplitBy::Workpiece => {
                let views = pairs(spread.len(), self.placements as usize);
                views.map(|(rank, placement)| (spread[rank], placement)).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};

    use super::*;
    use crate::images::plan::Treatment;
    use crate::images::plan::fixture::recipe_of;
    use paths::Pattern;

    /// The strata that a limit must not miss, as names.
    fn strata(image: &Planned) -> [String; 6] {
        let kind = match image.treatment {
            Treatment::Unsanded => "unsanded",
            Treatment::Stage { .. } => "partly sanded",
            Treatment::Bare => "bare",
        };
        let stage = if let Treatment::Stage { stage, .. } = image.treatment { stage } else { 0 };
        [
            kind.to_owned(),
            format!("{kind}, stage {stage}"),
            format!("{:?}", image.treatment),
            format!("workpiece {}", image.workpiece),
            format!("placement {}", image.placement),
            format!("split {:?}", image.split),
        ]
    }

    /// The greatest distance of a stratum's count from its share, over all limits, with the stratum [images].
    fn worst(recipe: &ImageRecipe) -> (f64, String) {
        let all = recipe.images_within(usize::MAX);
        let mut totals = BTreeMap::<String, usize>::new();
        all.iter().flat_map(strata).for_each(|stratum| *totals.entry(stratum).or_default() += 1);
        let mut counts: BTreeMap<&str, usize> = totals.keys().map(|stratum| (stratum.as_str(), 0)).collect();
        let mut worst = (0.0, String::new());
        for (taken, image) in all.iter().enumerate() {
            for stratum in strata(image) {
                *counts.get_mut(stratum.as_str()).unwrap() += 1;
            }
            for (stratum, &count) in &counts {
                let share = (taken + 1) as f64 * totals[*stratum] as f64 / all.len() as f64;
                let distance = (count as f64 - share).abs();
                if distance > worst.0 {
                    worst = (distance, format!("{stratum}: {count} of {} at {share:.2}", taken + 1));
                }
            }
        }
        worst
    }

    #[test]
    fn a_limit_of_24_has_the_references_both_workpieces_every_placement_and_every_stage() {
        let images = recipe_of(2, 12, (6, 5)).images_within(24);
        let count = |stratum: &str| images.iter().filter(|image| strata(image).iter().any(|s| s == stratum)).count();
        assert_eq!(["unsanded", "partly sanded", "bare"].map(count), [1, 22, 1]);
        assert!((0..2).all(|workpiece| count(&format!("workpiece {workpiece}")) == 12));
        assert!((0..12).all(|placement| count(&format!("placement {placement}")) == 2));
        assert_eq!(["Train", "Validation", "Test"].map(|split| count(&format!("split {split}"))), [16, 4, 4]);
        assert!((1..=5).all(|stage| [4, 5].contains(&count(&format!("partly sanded, stage {stage}")))));
    }

    #[test]
    fn any_limit_has_each_state_workpiece_placement_and_split_within_one_of_its_share() {
        for (workpieces, placements) in [(1, 1), (1, 2), (2, 1), (2, 3), (2, 4), (1, 7), (3, 2), (2, 12), (4, 6)] {
            for (patterns, stages) in [(1, 1), (1, 6), (2, 2), (3, 4), (4, 2), (5, 3), (6, 1), (6, 5), (6, 9)] {
                let recipe = recipe_of(workpieces, placements, (patterns, stages));
                let (distance, found) = worst(&recipe);
                // Counts and shares are rounded once each; the bound itself is 1 image.
                assert!(distance < 1.0 + 1e-9, "{workpieces} {placements} {patterns} {stages}: {found}");
            }
        }
    }

    #[test]
    fn the_splits_of_any_number_of_placements_stay_within_one_of_their_share() {
        for placements in 1..=99 {
            let (distance, found) = worst(&recipe_of(1, placements, (1, 1)));
            assert!(distance < 1.0 + 1e-9, "{placements}: {found}");
        }
    }

    #[test]
    fn the_whole_order_is_the_whole_set_and_a_greater_limit_only_adds() {
        let recipe = recipe_of(2, 12, (Pattern::ALL.len(), 5));
        let ids = |images: Vec<Planned>| images.into_iter().map(|image| image.id).collect::<Vec<_>>();
        let all = ids(recipe.images_within(usize::MAX));
        let planned: BTreeSet<String> = ids(recipe.images()).into_iter().collect();
        assert_eq!(all.len(), planned.len());
        assert_eq!(all.iter().cloned().collect::<BTreeSet<_>>(), planned);
        assert!([1, 2, 23, 24, 100, 767].iter().all(|&limit| ids(recipe.images_within(limit)) == all[..limit]));
    }
}
