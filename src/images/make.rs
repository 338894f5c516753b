//! Making one thing of a set, a workpiece, a simulation or an image; runs in a process of its own.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Result, bail};

use super::plan::{Planned, PlannedSanding, Treatment};
use super::scene::Scene;
use super::shot::shoot;
use super::workpiece::Coated;
use super::{ImageRecipe, ImageSet};
use crate::dataset::item::Ending;
use crate::dataset::{Marker, Stage, remove_stale};
use crate::in_full;
use files::file_lock::Patience;

/// A thing to make.
#[derive(Clone, Debug, PartialEq)]
pub enum Task {
    /// The field of a workpiece.
    Workpiece(Coated),
    /// The doses of a way.
    Sanding(PlannedSanding),
    /// An image with its labels.
    Image(Planned),
}

impl Task {
    /// All tasks of a set in three steps, each of which needs the ones before: workpieces, simulations, images.
    pub fn all(recipe: &ImageRecipe) -> [Vec<Self>; 3] {
        [
            recipe.workpieces.iter().cloned().map(Self::Workpiece).collect(),
            recipe.sandings().into_iter().map(Self::Sanding).collect(),
            recipe.images().into_iter().map(Self::Image).collect(),
        ]
    }

    /// The tasks of these names, and what they need.
    pub fn chosen(recipe: &ImageRecipe, ids: &BTreeSet<String>) -> [Vec<Self>; 3] {
        let mut steps = Self::all(recipe);
        let mut wanted = ids.clone();
        for tasks in steps.iter_mut().rev() {
            tasks.retain(|task| wanted.contains(task.id()));
            wanted.extend(tasks.iter().flat_map(|task| task.needs(recipe)));
        }
        steps
    }

    /// The task of this name.
    pub fn named(recipe: &ImageRecipe, id: &str) -> Option<Self> {
        Self::all(recipe).into_iter().flatten().find(|task| task.id() == id)
    }

    /// Its name.
    pub fn id(&self) -> &str {
        match self {
            Self::Workpiece(coated) => &coated.name,
            Self::Sanding(sanding) => &sanding.id,
            Self::Image(image) => &image.id,
        }
    }

    /// Name of its workpiece.
    pub fn workpiece<'a>(&'a self, recipe: &'a ImageRecipe) -> &'a str {
        match self {
            Self::Workpiece(coated) => &coated.name,
            Self::Sanding(sanding) => &recipe.workpieces[sanding.workpiece].name,
            Self::Image(image) => &recipe.workpieces[image.workpiece].name,
        }
    }

    /// Names of the tasks that must be done before.
    pub fn needs(&self, recipe: &ImageRecipe) -> Vec<String> {
        let sanding = if let Self::Image(image) = self { recipe.sanding_of(image) } else { None };
        let workpiece = (!matches!(self, Self::Workpiece(_))).then(|| self.workpiece(recipe).to_owned());
        workpiece.into_iter().chain(sanding).collect()
    }

    /// Where on the road it fails, if it does.
    pub fn stage(&self) -> Stage {
        match self {
            Self::Workpiece(_) => Stage::Part,
            Self::Sanding(_) => Stage::Sand,
            Self::Image(_) => Stage::Render,
        }
    }

    /// Whether it is done.
    pub fn is_done(&self, set: &ImageSet) -> bool {
        match self {
            Self::Workpiece(coated) => set.holds_workpiece(&coated.name),
            Self::Sanding(sanding) => set.holds_sanding(&sanding.id),
            Self::Image(image) => set.holds_image(image),
        }
    }
}

/// Does a task, or says why it cannot be done; what it makes is complete or not there.
pub fn make(set: &ImageSet, id: &str) -> Ending {
    let failed = |stage, error: anyhow::Error| {
        // Staged names hold the number of this process, and reasons are the same in every run.
        let reason = in_full(&error).replace(&format!(".part-{}", std::process::id()), "");
        Ending::Failed { stage, reason }
    };
    let Some(task) = Task::named(&set.recipe, id) else {
        return failed(Stage::Part, anyhow::anyhow!("{id}: no part of this set"));
    };
    let _claim = match set.claim(id, Patience::None) {
        Ok(Some(claim)) => claim,
        Ok(None) => return Ending::Busy,
        Err(error) => return failed(Stage::Write, error),
    };
    if task.is_done(set) {
        return Ending::There;
    }
    let made = sweep(set, id).and_then(|()| match &task {
        Task::Workpiece(coated) => set.make_workpiece(coated),
        Task::Sanding(sanding) => set.make_sanding(sanding),
        Task::Image(image) => make_image(set, image),
    });
    match made {
        Ok(()) => Ending::Made,
        Err(error) => failed(task.stage(), error),
    }
}

/// Removes what killed runs left of a task that we hold.
fn sweep(set: &ImageSet, id: &str) -> Result<()> {
    ImageRecipe::FOLDERS.iter().try_for_each(|folder| remove_stale(&set.folder().join(folder), id))
}

fn make_image(set: &ImageSet, planned: &Planned) -> Result<()> {
    let recipe = &set.recipe;
    let (mut part, workpiece_sha256) = set.read_workpiece(&recipe.workpieces[planned.workpiece].name)?;
    let mut sources = BTreeMap::from([("workpiece".to_owned(), workpiece_sha256)]);
    match planned.treatment {
        Treatment::Unsanded => part.dose = vec![0.0; part.phi.len()],
        Treatment::Bare => part.dose = vec![1.0; part.phi.len()],
        Treatment::Stage { stage, .. } => {
            let Some(sanding) = recipe.sanding_of(planned) else {
                bail!("{}: no simulation belongs to it", planned.id)
            };
            sources.insert("dose".to_owned(), set.attach_dose(&mut part, &sanding, stage)?);
        }
    }
    let mut scene = Scene::draw(&part, recipe, planned)?;
    let shot = shoot(&part, &scene, recipe.size);
    scene.sensor.exposure = shot.exposure;
    set.write_image(planned, &shot, scene, sources)
}
