//! Recipe of a set of images.

use paths::Pattern;
use perception::Look;
use serde::{Deserialize, Serialize};

use super::FOLDERS;
use super::plan::SplitBy;
use super::scene_files::{ClutterFolder, EnvironmentFile};
use super::workpiece::Coated;
use crate::dataset::MARKER_FILE;
use crate::store::Marker;

/// Value of the `format` key.
pub const IMAGES_FORMAT: &str = "robofin-images/3";

/// Marker of a set of images: all inputs that define its images.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImageRecipe {
    /// [`IMAGES_FORMAT`].
    pub format: String,
    /// Version of the program.
    pub version: String,
    /// Seed of the set.
    pub seed: u64,
    /// Workpieces, in their order.
    pub workpieces: Vec<Coated>,
    /// Number of placements of each workpiece.
    pub placements: u32,
    /// Paths of the pad, in their order.
    pub patterns: Vec<Pattern>,
    /// Number of parts of each path.
    pub stages: u32,
    /// Width and height of the images [pixels].
    pub size: (usize, usize),
    /// Distance between voxels of the workpieces other than assets [mm].
    pub voxel_mm: f64,
    /// Unit by which the images are split.
    pub split_by: SplitBy,
    /// Looks of the photographs, in their order.
    pub looks: Vec<Look>,
    /// Picture of the surroundings, in place of drawn ambient light.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub environment: Option<EnvironmentFile>,
    /// Meshes among the clutter.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clutter: Option<ClutterFolder>,
}

impl ImageRecipe {
    /// Returns the flags that give this recipe.
    pub fn flags(&self) -> Vec<String> {
        let listed = |words: Vec<String>| words.join(",");
        let mut flags = vec![
            format!("--seed={}", self.seed),
            format!("--workpieces={}", listed(self.workpieces.iter().map(Coated::word).collect())),
            format!("--placements={}", self.placements),
            format!("--patterns={}", listed(self.patterns.iter().map(|pattern| pattern.name().to_owned()).collect())),
            format!("--stages={}", self.stages),
            format!("--size={}x{}", self.size.0, self.size.1),
            format!("--voxel-mm={}", self.voxel_mm),
            format!("--split-by={}", self.split_by.name()),
            format!("--looks={}", Look::listed(&self.looks)),
        ];
        flags.extend(self.environment.iter().map(|picture| format!("--environment={}", picture.file)));
        flags.extend(self.clutter.iter().map(|clutter| format!("--clutter={}", clutter.folder)));
        flags
    }
}

impl Marker for ImageRecipe {
    const WHAT: &'static str = "a data set";
    const FILE: &'static str = MARKER_FILE;
    const FORMAT: &'static str = IMAGES_FORMAT;
    const FOLDERS: &'static [&'static str] = &FOLDERS;

    fn format(&self) -> &str {
        &self.format
    }

    fn difference(&self, asked: &Self) -> Option<String> {
        let keys = |items: &[Coated]| items.iter().map(|item| item.key.as_str()).collect::<Vec<_>>().join(" ");
        let word = |file: &str, sha256: &str| format!("{file} ({sha256:.8})");
        let picture = |of: &Self| of.environment.iter().map(|of| word(&of.file, &of.sha256)).collect::<String>();
        let meshes = |of: &Self| {
            let all = of.clutter.iter().flat_map(|clutter| &clutter.meshes);
            all.map(|mesh| word(&mesh.file, &mesh.sha256)).collect::<Vec<_>>().join(" ")
        };
        let or_none = |words: String| if words.is_empty() { "none".to_owned() } else { words };
        let compared = [
            ("version", self.version.clone(), asked.version.clone()),
            ("seed", self.seed.to_string(), asked.seed.to_string()),
            ("the workpieces", keys(&self.workpieces), keys(&asked.workpieces)),
            ("placements", self.placements.to_string(), asked.placements.to_string()),
            ("the patterns", format!("{:?}", self.patterns), format!("{:?}", asked.patterns)),
            ("stages", self.stages.to_string(), asked.stages.to_string()),
            ("the size", format!("{:?}", self.size), format!("{:?}", asked.size)),
            ("the split", self.split_by.name().to_owned(), asked.split_by.name().to_owned()),
            ("the environment", or_none(picture(self)), or_none(picture(asked))),
            ("the clutter", or_none(meshes(self)), or_none(meshes(asked))),
            ("the looks", Look::listed(&self.looks), Look::listed(&asked.looks)),
        ];
        let (name, now, then) = compared.into_iter().find(|(_, now, then)| now != then)?;
        Some(format!("{name}: {now} there, and {then} now"))
    }
}
