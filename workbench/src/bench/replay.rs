//! Command lines that repeat the work of the page.

use std::path::Path;

use crate::shell;

/// Folder that the commands write to.
const FOLDER: &str = "replay";

/// Change from the previous model to a model.
#[derive(Clone, Copy, Debug)]
pub(super) enum Change<'a> {
    /// The first model.
    Base,
    /// One effect is added.
    Add(&'a str),
    /// One effect is removed.
    Remove(&'a str),
    /// The model file is written by the workbench, because no other command produces it.
    Written,
}

/// Paths that the command lines contain.
pub(super) struct Places<'a> {
    /// Folder of the campaign.
    pub(super) campaign: &'a Path,
    /// Folder in which the bench is saved.
    pub(super) out: &'a Path,
    /// Folder of effects made from typed formulas, if there are any.
    pub(super) effects: Option<&'a Path>,
}

/// Returns the command lines that make model `number` from model `before`.
pub(super) fn commands(places: &Places, (before, number): (usize, usize), change: Change) -> Vec<String> {
    let effects = places.effects.map_or(String::new(), |folder| format!(" --effects {}", quoted(folder)));
    let campaign = quoted(places.campaign);
    let model = format!("{FOLDER}/{number}.toml");
    let copy = |from: String| format!("cp {from} {model}");
    let fit = format!("robofin calibrate {campaign} --model {model} --out {FOLDER}/{number}{effects}");
    let edit = |how: &str, name: &str| {
        let edit = format!("robofin effects {how} {model} {name}{effects}");
        vec![copy(format!("{FOLDER}/{before}/model.toml")), edit, fit.clone()]
    };
    match change {
        Change::Base => vec![format!("robofin calibrate {campaign} --out {FOLDER}/{number}")],
        Change::Add(name) => edit("add", name),
        Change::Remove(name) => edit("remove", name),
        Change::Written => {
            let start = places.out.join(number.to_string()).join(super::journal::START_FILE);
            vec![copy(quoted(&start)), fit.clone()]
        }
    }
}

/// Quotes a path for a POSIX shell.
fn quoted(path: &Path) -> String {
    shell::quoted(&path.display().to_string())
}
