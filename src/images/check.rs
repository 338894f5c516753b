//! Check of a set of images: every file is hashed again, every label read again, the catalogue made again and compared.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Context, Result};

use super::catalogue::SPLIT_FILES;
use super::make::{STEPS, Task};
use super::plan::{Planned, Treatment};
use super::record::{ImageRecord, label_path};
use super::sanding::stage_file;
use super::{APPEARANCE_FOLDER, DOSE_FOLDER, FIELDS_FOLDER, ImageSet, RECORDS_FOLDER};
use crate::asset::FileRecord;
use crate::in_full;
use crate::store::check::{Broken, SetValidation};
use crate::store::run::SetItem;
use crate::store::{self, names, remove};
use files::input::{self, MOST_MESH_BYTES, MOST_TEXT_BYTES};
use render::label::{IGNORE, SANDED, UNSANDED, agreement, counts};

/// Checks all items of a set with `jobs` threads, then the catalogue; calls `done` with each item's faults.
///
/// # Errors
/// If a folder cannot be read, or `done` fails.
pub fn check(set: &ImageSet, jobs: usize, done: impl FnMut(&str, &[String]) -> Result<()>) -> Result<SetValidation> {
    let tasks: Vec<(String, Task)> =
        expected(set)?.into_iter().flatten().map(|task| (task.id().to_owned(), task)).collect();
    store::check::check(set, jobs, &tasks, |_, task| check_task(set, task), done)
}

/// Finds records that belong to no image of the set, and contradictions between complete images, one sentence each.
pub(super) fn contradictions(set: &ImageSet) -> Result<Vec<String>> {
    Ok([strange_records(set)?, courses(set)?].concat())
}

/// Returns the items that the set needs: images listed in its metadata or with a record, and their prerequisites.
pub fn expected(set: &ImageSet) -> Result<[Vec<Task>; STEPS]> {
    let lines_of =
        |[metadata, ..]: [&str; 3]| input::read(&set.folder().join(metadata), MOST_TEXT_BYTES).unwrap_or_default();
    let text = SPLIT_FILES.map(lines_of).concat();
    let listed = text.split(|&byte| byte == b'\n').filter_map(|line| {
        let value: serde_json::Value = serde_json::from_slice(line).ok()?;
        Some(value.get("id")?.as_str()?.to_owned())
    });
    let there = names(&set.folder().join(RECORDS_FOLDER))?;
    let there = there.iter().filter_map(|name| name.strip_suffix(".json").map(str::to_owned));
    let known: BTreeSet<String> = listed.chain(there).collect();
    Ok(Task::chosen(&set.recipe, &known))
}

/// Checks an item; returns the number of checks, and the faults found.
fn check_task(set: &ImageSet, task: &Task) -> (usize, Vec<String>) {
    let mut checks = Checks::default();
    let checked = match task {
        Task::Workpiece(coated) => checks.workpiece(set, &coated.name),
        Task::Sanding(sanding) => checks.sanding(set, &sanding.id, &set.recipe.workpieces[sanding.workpiece].name),
        Task::View(view) => checks.view(set, &view.id),
        Task::Image(image) => checks.image(set, image),
    };
    if let Err(error) = checked {
        checks.faults.push(in_full(&error));
    }
    (checks.made, checks.faults)
}

#[derive(Default)]
struct Checks {
    made: usize,
    faults: Vec<String>,
}

impl Checks {
    fn that(&mut self, holds: bool, fault: impl FnOnce() -> String) {
        self.made += 1;
        if !holds {
            self.faults.push(fault());
        }
    }

    fn workpiece(&mut self, set: &ImageSet, name: &str) -> Result<()> {
        let (field, _) = set.read_workpiece(name)?;
        let sane = field.sanity_check();
        self.that(sane.is_ok(), || sane.unwrap_err());
        Ok(())
    }

    fn sanding(&mut self, set: &ImageSet, id: &str, workpiece: &str) -> Result<()> {
        let record = set.read_sanding(id)?;
        let source = input::read(&set.workpiece_path(workpiece), MOST_MESH_BYTES).map(|bytes| files::sha256(&bytes));
        self.that(source.is_ok_and(|hash| hash == record.workpiece_sha256), || format!("not of {workpiece} as it is"));
        self.that(record.stages.len() == set.recipe.stages as usize, || format!("{} stages", record.stages.len()));
        for (stage, expected) in record.stages.iter().enumerate() {
            let name = format!("{FIELDS_FOLDER}/{id}/{}", stage_file(stage + 1));
            self.file(set, &name, &expected.file)?;
        }
        Ok(())
    }

    fn view(&mut self, set: &ImageSet, id: &str) -> Result<()> {
        let faults = set.check_view(id)?;
        self.that(faults.is_empty(), || faults.join("; "));
        Ok(())
    }

    fn file(&mut self, set: &ImageSet, name: &str, expected: &FileRecord) -> Result<()> {
        let found = FileRecord::of(&set.folder().join(name))?;
        self.that(found == *expected, || format!("{name}: its content is not the one recorded"));
        Ok(())
    }

    fn image(&mut self, set: &ImageSet, planned: &Planned) -> Result<()> {
        let record = set.read_record(&planned.id)?;
        record.fits(planned, &set.recipe.workpieces[planned.workpiece].name)?;
        for (name, expected) in &record.files {
            self.file(set, name, expected)?;
        }
        let labels = [APPEARANCE_FOLDER, DOSE_FOLDER].map(|folder| set.read_labels(&label_path(folder, &planned.id)));
        let [appearance, dose] = labels;
        self.labels(&record, &appearance?, &dose?);
        let dose_file = set.recipe.sanding_of(planned).zip(match planned.treatment {
            Treatment::Stage { stage, .. } => Some(stage),
            _ => None,
        });
        if let Some((sanding, stage)) = dose_file {
            let sanding = set.read_sanding(&sanding)?;
            let stage = sanding.stages.get(stage as usize - 1).context("its stage was not simulated")?;
            self.that(record.sources.get("dose") == Some(&stage.file.sha256), || "not of its stage's dose".to_owned());
        }
        Ok(())
    }

    fn labels(&mut self, record: &ImageRecord, appearance: &[u8], dose: &[u8]) {
        for (kind, labels, expected) in
            [("appearance", appearance, record.appearance_pixels), ("dose", dose, record.dose_pixels)]
        {
            let found = counts(labels);
            self.that(found.iter().sum::<u64>() == labels.len() as u64, || {
                format!("{kind}: labels other than 0, {SANDED}, {UNSANDED} and {IGNORE}")
            });
            self.that(found == expected, || format!("{kind}: {found:?} pixels of each class, {expected:?} recorded"));
            let must_be_empty = match record.treatment {
                Treatment::Unsanded => Some(1),
                Treatment::Bare => Some(2),
                Treatment::Stage { .. } => None,
            };
            self.that(must_be_empty.is_none_or(|class| found[class] == 0), || {
                format!("{kind}: a reference shows both sanded and unsanded coating")
            });
        }
        self.that(record.agreement == agreement(appearance, dose), || {
            "its agreement is not that of its labels".to_owned()
        });
    }
}

/// Finds records of images that do not belong to the set.
fn strange_records(set: &ImageSet) -> Result<Vec<String>> {
    let known: BTreeSet<String> = set.recipe.images().into_iter().map(|image| format!("{}.json", image.id)).collect();
    let found = names(&set.folder().join(RECORDS_FOLDER))?.into_iter();
    let strange = found.filter(|name| !name.starts_with('.') && !known.contains(name));
    Ok(strange.map(|name| format!("{RECORDS_FOLDER}/{name}: not part of this set")).collect())
}

/// Stages of a pattern, with the exposed share after each.
type StudyState = Vec<(u32, f64)>;

/// Checks that in one view the exposed share of a pattern never falls from stage to stage: sanding only removes.
fn courses(set: &ImageSet) -> Result<Vec<String>> {
    let mut courses: BTreeMap<(String, u32, &str), StudyState> = BTreeMap::new();
    for planned in set.recipe.images().iter().filter(|image| set.holds_image(image)) {
        if let Treatment::Stage { pattern, stage } = planned.treatment {
            let record = set.read_record(&planned.id)?;
            let course = courses.entry((record.workpiece, record.placement, pattern.name())).or_default();
            course.push((stage, record.exposed_share));
        }
    }
    let falls = |course: &StudyState| course.windows(2).any(|pair| pair[1].1 < pair[0].1);
    let fallen = courses.into_iter().filter(|(_, course)| falls(course));
    Ok(fallen
        .map(|((workpiece, placement, pattern), _)| {
            format!("{workpiece}, placement {placement}, {pattern}: the exposed share falls from stage to stage")
        })
        .collect())
}

/// Removes broken items, so that another run makes them again.
///
/// # Errors
/// If the file system refuses.
pub fn remove_broken(set: &ImageSet, broken: &[Broken]) -> Result<()> {
    for Broken { id, .. } in broken {
        match Task::named(&set.recipe, id) {
            Some(Task::Image(image)) => set.remove_image(&image)?,
            Some(Task::View(_)) => set.remove_view(id)?,
            Some(Task::Sanding(_)) => remove(&set.sanding_folder(id))?,
            Some(Task::Workpiece(_)) => remove(&set.workpiece_path(id))?,
            None => {}
        }
    }
    Ok(())
}
