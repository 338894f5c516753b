//! Images of a set: names, seeds, splits.

use paths::Pattern;
use perception::Seeds;
pub use perception::{Split, SplitBy, Treatment};

use super::recipe::ImageRecipe;
use super::workpiece::Coated;
use crate::store::number_from;

/// A placement of a workpiece, seen by one camera.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedView {
    /// Name, for example `bracket-p03`.
    pub id: String,
    /// Index of the workpiece in the recipe.
    pub workpiece: usize,
    /// Index of the placement, from 0.
    pub placement: u32,
}

/// An image to make.
#[derive(Clone, Debug, PartialEq)]
pub struct Planned {
    /// Name, for example `bracket-p03-spiral-s2`.
    pub id: String,
    /// Number in the whole set, from 1, even if only some images are made.
    pub number: u64,
    /// Index of the workpiece in the recipe.
    pub workpiece: usize,
    /// Index of the placement, from 0.
    pub placement: u32,
    /// State of the coating.
    pub treatment: Treatment,
    /// Split, which follows from the workpiece or from the placement.
    pub split: Split,
}

/// A path of the pad on a workpiece, simulated with all its stages.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedSanding {
    /// Name, for example `bracket-spiral`.
    pub id: String,
    /// Index of the workpiece in the recipe.
    pub workpiece: usize,
    /// Path of the pad.
    pub pattern: Pattern,
}

impl ImageRecipe {
    /// Returns all images of the set: by workpiece, then by placement, each from unsanded to bare.
    pub fn images(&self) -> Vec<Planned> {
        let treatments = self.treatments();
        let mut images = Vec::new();
        for (workpiece, coated) in self.workpieces.iter().enumerate() {
            for placement in 0..self.placements {
                for &treatment in &treatments {
                    images.push(Planned {
                        id: format!("{}-{}", view_id(&coated.name, placement), treatment.name()),
                        number: images.len() as u64 + 1,
                        workpiece,
                        placement,
                        treatment,
                        split: self.split(workpiece, placement as usize),
                    });
                }
            }
        }
        images
    }

    /// Returns all views: by workpiece, then by placement.
    pub fn views(&self) -> Vec<PlannedView> {
        let of = |(workpiece, coated): (usize, &Coated)| {
            let name = coated.name.clone();
            (0..self.placements).map(move |placement| PlannedView {
                id: view_id(&name, placement),
                workpiece,
                placement,
            })
        };
        self.workpieces.iter().enumerate().flat_map(of).collect()
    }

    /// Returns the name of the view of an image.
    pub fn view_of(&self, planned: &Planned) -> String {
        view_id(&self.workpieces[planned.workpiece].name, planned.placement)
    }

    /// Returns all simulations that the images need.
    pub fn sandings(&self) -> Vec<PlannedSanding> {
        let of = |(workpiece, pattern): (usize, Pattern)| PlannedSanding {
            id: format!("{}-{}", self.workpieces[workpiece].name, pattern.name()),
            workpiece,
            pattern,
        };
        let pairs = (0..self.workpieces.len()).flat_map(|w| self.patterns.iter().map(move |&pattern| (w, pattern)));
        pairs.map(of).collect()
    }

    /// Returns the name of the simulation that an image needs.
    pub fn sanding_of(&self, planned: &Planned) -> Option<String> {
        match planned.treatment {
            Treatment::Stage { pattern, .. } => {
                Some(format!("{}-{}", self.workpieces[planned.workpiece].name, pattern.name()))
            }
            Treatment::Unsanded | Treatment::Bare => None,
        }
    }

    fn treatments(&self) -> Vec<Treatment> {
        let stages = self.patterns.iter().flat_map(|&pattern| (1..=self.stages).map(move |stage| (pattern, stage)));
        let stages = stages.map(|(pattern, stage)| Treatment::Stage { pattern, stage });
        std::iter::once(Treatment::Unsanded).chain(stages).chain([Treatment::Bare]).collect()
    }

    /// Returns the split of a placement of a workpiece.
    fn split(&self, workpiece: usize, placement: usize) -> Split {
        self.splits()[match self.split_by {
            SplitBy::Workpiece => workpiece,
            SplitBy::Placement => placement,
        }]
    }

    /// Returns the split of each workpiece, or of each placement of all workpieces: a sixth is for validation and a
    /// sixth for tests, with at least one each if there are three; the seed selects them.
    pub fn splits(&self) -> Vec<Split> {
        let count = match self.split_by {
            SplitBy::Workpiece => self.workpieces.len(),
            SplitBy::Placement => self.placements as usize,
        };
        let held_out = if count < 3 { 0 } else { (count / 6).max(1) };
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by_key(|item| number_from(&format!("split {} {item}", self.seed)));
        let mut splits = vec![Split::Train; count];
        for (rank, item) in order.into_iter().take(2 * held_out).enumerate() {
            splits[item] = if rank < held_out { Split::Validation } else { Split::Test };
        }
        splits
    }

    /// Returns the seeds of one image.
    pub fn seeds(&self, planned: &Planned) -> Seeds {
        let image = number_from(&format!("image {} {}", self.seed, planned.id));
        Seeds { placement: self.placement_seed(planned.workpiece, planned.placement), image }
    }

    /// Returns the seeds of a view, whose light matters for its float buffers alone.
    pub fn view_seeds(&self, planned: &PlannedView) -> Seeds {
        let placement = self.placement_seed(planned.workpiece, planned.placement);
        Seeds { placement, image: placement }
    }

    fn placement_seed(&self, workpiece: usize, placement: u32) -> u64 {
        let name = &self.workpieces[workpiece].name;
        number_from(&format!("placement {} {name} {placement}", self.seed))
    }
}

/// Returns the name of a view.
fn view_id(workpiece: &str, placement: u32) -> String {
    format!("{workpiece}-p{placement:02}")
}

#[cfg(test)]
pub(crate) mod fixture {
    use perception::Shape;

    use super::{ImageRecipe, Pattern, SplitBy};
    use crate::images::workpiece::{Coated, Origin};

    /// Makes a recipe with these numbers of workpieces, placements, patterns and stages.
    pub(crate) fn recipe_of(workpieces: usize, placements: u32, (patterns, stages): (usize, u32)) -> ImageRecipe {
        let coated = |number: usize| {
            let name = format!("workpiece{number}");
            Coated { key: name.clone(), name, origin: Origin::Shape { shape: Shape::Panel }, voxel_mm: 0.5 }
        };
        ImageRecipe {
            format: String::new(),
            version: String::new(),
            seed: 1,
            workpieces: (0..workpieces).map(coated).collect(),
            placements,
            patterns: Pattern::ALL[..patterns].to_vec(),
            stages,
            size: (640, 480),
            voxel_mm: 0.5,
            split_by: SplitBy::Placement,
            looks: Vec::new(),
            environment: None,
            clutter: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    fn recipe(placements: u32) -> ImageRecipe {
        fixture::recipe_of(2, placements, (6, 5))
    }

    #[test]
    fn the_whole_set_has_768_images_split_512_128_128_by_placement() {
        let recipe = recipe(12);
        let images = recipe.images();
        let count = |split: Split| images.iter().filter(|image| image.split == split).count();
        assert_eq!(images.len(), 768);
        assert_eq!(Split::ALL.map(count), [512, 128, 128]);
        assert_eq!(images.iter().map(|image| &image.id).collect::<BTreeSet<_>>().len(), 768);
        assert!(images.iter().enumerate().all(|(at, image)| image.number == at as u64 + 1));
        let splits = |placement: u32| {
            let of = images.iter().filter(move |image| image.placement == placement);
            of.map(|image| image.split).collect::<BTreeSet<_>>()
        };
        assert!((0..12).all(|placement| splits(placement).len() == 1));
        assert_eq!(recipe.sandings().len(), 12);
    }

    #[test]
    fn the_default_set_of_six_workpieces_is_split_4_1_1_and_no_workpiece_is_in_two_splits() {
        let recipe = ImageRecipe { split_by: SplitBy::Workpiece, ..fixture::recipe_of(6, 4, (6, 5)) };
        let images = recipe.images();
        let count = |split: Split| images.iter().filter(|image| image.split == split).count();
        assert_eq!(Split::ALL.map(count), [512, 128, 128]);
        let pairs: BTreeSet<(usize, Split)> = images.iter().map(|image| (image.workpiece, image.split)).collect();
        assert_eq!(pairs.len(), 6);
        assert_eq!(recipe.views().len(), 24);
        assert!(images.iter().all(|image| image.id.starts_with(&recipe.view_of(image))));
    }

    #[test]
    fn every_split_has_a_placement_where_three_can_be_had() {
        let held_out = |placements: u32| {
            let splits = recipe(placements).splits();
            [Split::Validation, Split::Test].map(|split| splits.iter().filter(|&&s| s == split).count())
        };
        assert_eq!([1, 2, 3, 6, 11, 24].map(held_out), [[0, 0], [0, 0], [1, 1], [1, 1], [1, 1], [4, 4]]);
    }
}
