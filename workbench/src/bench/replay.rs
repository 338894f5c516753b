//! Command lines that do without the page what was done on it.

use std::path::Path;

/// Folder in which they write.
const FOLDER: &str = "replay";

/// How a model came from the one before.
#[derive(Clone, Copy, Debug)]
pub(super) enum Change<'a> {
    /// It is the first.
    Base,
    /// An effect was added.
    Add(&'a str),
    /// An effect was taken out.
    Remove(&'a str),
    /// Its file was written here, for no other command line makes it.
    Written,
}

/// What a command line needs to know.
pub(super) struct Places<'a> {
    /// The campaign.
    pub(super) campaign: &'a Path,
    /// Where the bench keeps what was tried.
    pub(super) out: &'a Path,
    /// Folder of formulas, if one was tried.
    pub(super) effects: Option<&'a Path>,
}

/// Command lines that make model `number` from model `before`.
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

/// A path as a POSIX shell reads it back.
fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-+=:@,".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) { text } else { format!("'{}'", text.replace('\'', "'\\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hostile_names_are_one_word_of_the_shell() {
        for name in ["a b", "$(touch x)", "it's", "a;b", "-"] {
            let answer = std::process::Command::new("sh")
                .args(["-c", &format!("printf %s {}", quoted(Path::new(name)))])
                .output()
                .unwrap();
            assert_eq!(String::from_utf8(answer.stdout).unwrap(), name);
        }
    }
}
