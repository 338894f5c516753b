//! Makes one item of a set, a workpiece, a simulation, a view or an image; runs in a process of its own.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Result, anyhow, bail};
use perception::shoot;

use super::plan::{Planned, PlannedSanding, PlannedView, Treatment};
use super::workpiece::Coated;
use super::{ImageRecipe, ImageSet};
use crate::store::limits::Limits;
use crate::store::process::Ending;
use crate::store::run::SetItem;
use crate::store::{Failure, Stage, command_line};
use files::file_lock::LockWait;

/// Verb of the process that does one task.
pub const TASK_VERB: &str = "dataset-image";

/// Number of steps in which a set is made.
pub const STEPS: usize = 4;

/// An item to make.
#[derive(Clone, Debug, PartialEq)]
pub enum Task {
    /// Field of a workpiece.
    Workpiece(Coated),
    /// Doses of a sanding path.
    Sanding(PlannedSanding),
    /// View: camera, pose and buffers common to the images of a placement.
    View(PlannedView),
    /// Image with its labels.
    Image(Planned),
}

impl Task {
    /// Returns all tasks of a set in steps, each of which needs the ones before: workpieces, simulations, views,
    /// images.
    pub fn all(recipe: &ImageRecipe) -> [Vec<Self>; STEPS] {
        [
            recipe.workpieces.iter().cloned().map(Self::Workpiece).collect(),
            recipe.sandings().into_iter().map(Self::Sanding).collect(),
            recipe.views().into_iter().map(Self::View).collect(),
            recipe.images().into_iter().map(Self::Image).collect(),
        ]
    }

    /// Returns the tasks of these names, and their prerequisites.
    pub fn chosen(recipe: &ImageRecipe, ids: &BTreeSet<String>) -> [Vec<Self>; STEPS] {
        let mut steps = Self::all(recipe);
        let mut wanted = ids.clone();
        for tasks in steps.iter_mut().rev() {
            tasks.retain(|task| wanted.contains(task.id()));
            wanted.extend(tasks.iter().flat_map(|task| task.needs(recipe)));
        }
        steps
    }

    /// Returns the task of this name.
    pub fn named(recipe: &ImageRecipe, id: &str) -> Option<Self> {
        Self::all(recipe).into_iter().flatten().find(|task| task.id() == id)
    }

    /// Returns the name of its workpiece.
    pub fn workpiece<'a>(&'a self, recipe: &'a ImageRecipe) -> &'a str {
        match self {
            Self::Workpiece(coated) => &coated.name,
            Self::Sanding(sanding) => &recipe.workpieces[sanding.workpiece].name,
            Self::View(view) => &recipe.workpieces[view.workpiece].name,
            Self::Image(image) => &recipe.workpieces[image.workpiece].name,
        }
    }

    /// Returns the names of its prerequisites.
    pub fn needs(&self, recipe: &ImageRecipe) -> Vec<String> {
        let workpiece = (!matches!(self, Self::Workpiece(_))).then(|| self.workpiece(recipe).to_owned());
        let of_image = if let Self::Image(image) = self {
            [recipe.sanding_of(image), Some(recipe.view_of(image))]
        } else {
            [None, None]
        };
        workpiece.into_iter().chain(of_image.into_iter().flatten()).collect()
    }

    /// Returns the stage at which this task fails, if it does.
    pub fn stage(&self) -> Stage {
        match self {
            Self::Workpiece(_) => Stage::Part,
            Self::Sanding(_) => Stage::Sand,
            Self::View(_) | Self::Image(_) => Stage::Render,
        }
    }
}

impl SetItem<ImageRecipe> for Task {
    fn id(&self) -> &str {
        match self {
            Self::Workpiece(coated) => &coated.name,
            Self::Sanding(sanding) => &sanding.id,
            Self::View(view) => &view.id,
            Self::Image(image) => &image.id,
        }
    }

    fn source(&self, set: &ImageSet) -> PathBuf {
        self.workpiece(&set.recipe).into()
    }

    fn is_there(&self, set: &ImageSet) -> bool {
        match self {
            Self::Workpiece(coated) => set.holds_workpiece(&coated.name),
            Self::Sanding(sanding) => set.holds_sanding(&sanding.id),
            Self::View(view) => set.holds_view(&view.id),
            Self::Image(image) => set.holds_image(image),
        }
    }

    fn obstacle(&self, set: &ImageSet) -> Option<Ending> {
        let is_there = |id: &String| Self::named(&set.recipe, id).is_some_and(|task| task.is_there(set));
        let missing = self.needs(&set.recipe).into_iter().find(|id| !is_there(id))?;
        Some(Ending::Failed { stage: self.stage(), reason: format!("it needs {missing}, which failed") })
    }

    fn words<'c>(&self, command: &'c mut Command, set: &ImageSet, limits: Limits) -> &'c mut Command {
        let Limits { time, memory } = limits;
        command.arg(TASK_VERB).arg("--id").arg(self.id()).arg("--out").arg(set.folder());
        command.arg("--time-limit").arg(time.to_string());
        command.arg("--memory-limit").arg((memory as f64 * 1e-9).to_string())
    }

    fn failure(&self, set: &ImageSet, stage: Stage, reason: String) -> Failure {
        let words = ["robofin", "dataset", "images"].map(str::to_owned);
        let more = ["--only", self.id(), "--out", "again"].map(str::to_owned);
        Failure {
            id: self.id().to_owned(),
            source: self.workpiece(&set.recipe).to_owned(),
            index: match self {
                Self::View(PlannedView { placement, .. }) | Self::Image(Planned { placement, .. }) => *placement,
                Self::Workpiece(_) | Self::Sanding(_) => 0,
            },
            stage,
            reason,
            command: command_line(words.iter().chain(&set.recipe.flags()).chain(&more)),
        }
    }
}

/// Does a task, or returns the reason of its failure; its result is complete or does not exist.
pub fn make(set: &ImageSet, id: &str) -> Ending {
    let Some(task) = Task::named(&set.recipe, id) else {
        return Ending::of(id, Err(Stage::Part.fault(anyhow!("{id}: not part of this set"))));
    };
    let make = || match &task {
        Task::Workpiece(coated) => set.make_workpiece(coated),
        Task::Sanding(sanding) => set.make_sanding(sanding),
        Task::View(view) => set.make_view(view),
        Task::Image(image) => make_image(set, image),
    };
    let there = || task.is_there(set).then_some(());
    Ending::of(id, set.fill(id, LockWait::None, there, || make().map_err(|error| task.stage().fault(error))))
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
    let (mut scene, files) = set.scene(&part, &recipe.seeds(planned))?;
    let shot = shoot(&part, &scene, recipe.size, &files)?;
    scene.sensor.exposure = shot.exposure;
    set.write_image(planned, &shot, scene, sources)
}
