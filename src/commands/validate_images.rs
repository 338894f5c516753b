//! `robofin validate` of a set of images, and its repair.

use std::path::Path;

use anyhow::Result;

use super::dataset_images::{LimitFlags, make};
use super::validate_set::{conclude, report_items};
use crate::console::Console;
use crate::images::ImageSet;
use crate::images::check::{check, expected, remove_broken};
use crate::store::catalogue::Catalogue;
use crate::store::check::SetValidation;
use crate::store::run::Run;

pub(super) fn run(folder: &Path, repair: bool, jobs: usize, console: &Console) -> Result<()> {
    let set = ImageSet::open(folder)?;
    let mut found = look(&set, jobs, console)?;
    if repair && !found.holds() {
        let steps = expected(&set)?;
        remove_broken(&set, &found.broken)?;
        make(&Run { set: &set, limits: LimitFlags::usual().limits(), jobs }, &steps, console)?;
        Catalogue::update(&set)?;
        found = look(&set, jobs, console)?;
    }
    conclude(folder, repair, &found, console)
}

fn look(set: &ImageSet, jobs: usize, console: &Console) -> Result<SetValidation> {
    let things = expected(set)?.iter().map(Vec::len).sum();
    report_items(things, console, |done| check(set, jobs, done))
}
