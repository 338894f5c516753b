//! A trial from dropped files: they are kept aside until a `trial.toml` reads them, and are then moved into the folder.

use std::fs;
use std::path::{Path, PathBuf};

use files::folder::write_file;
use serde::{Deserialize, Serialize};
use trials::init::guess;
use trials::trial::{Finding, TRIAL_FILE, Trial};

use crate::error::Refusal;

/// Folder in the served one that keeps files aside; lists of places leave it out.
const ASIDE: &str = ".robofin-dropped";
/// Greatest length of a name [characters].
const LONGEST_NAME: usize = 80;

/// Place of a new trial.
#[derive(Clone, Debug, Deserialize)]
pub(crate) struct TrialPlace {
    /// Name of the campaign's folder; empty for the served folder itself.
    campaign: String,
    /// Name of the trial's folder.
    trial: String,
}

/// A draft of `trial.toml` for the page.
#[derive(Debug, Serialize)]
pub(crate) struct Draft {
    text: String,
    seen: Vec<String>,
    open: Vec<String>,
}

impl TrialPlace {
    /// Empties the place where this trial's files are kept aside.
    ///
    /// # Errors
    /// If a name is unfit, or the trial exists already.
    pub(crate) fn begin(&self, root: &Path) -> Result<(), Refusal> {
        let (aside, last) = (self.aside(root)?, self.last(root)?);
        if last.exists() {
            return Err(Refusal::wrong(format!("{}: this folder exists; another name is accepted", last.display())));
        }
        let _nothing_there = fs::remove_dir_all(&aside);
        fs::create_dir_all(&aside).map_err(|error| unwritable(&aside, &error))
    }

    /// Keeps one file aside.
    ///
    /// # Errors
    /// If a name is unfit, or the file cannot be written.
    pub(crate) fn keep(&self, root: &Path, file: &str, bytes: &[u8]) -> Result<(), Refusal> {
        let aside = self.aside(root)?;
        if !aside.is_dir() {
            return Err(Refusal::early("no trial was begun under this name"));
        }
        write_file(&aside.join(fit(file)?), bytes).map_err(|error| Refusal::wrong(error.to_string()))
    }

    /// Drafts the `trial.toml` of the files kept aside; one that was dropped with them is kept as it is.
    ///
    /// # Errors
    /// If the files hold no scan or no log.
    pub(crate) fn draft(&self, root: &Path) -> Result<Draft, Refusal> {
        let aside = self.aside(root)?;
        if let Ok(text) = fs::read_to_string(aside.join(TRIAL_FILE)) {
            let seen = vec![format!("{TRIAL_FILE}: it was among the files")];
            return Ok(Draft { text, seen, open: Vec::new() });
        }
        let guess = guess(&aside).map_err(|error| Refusal::wrong(self.without_aside(root, &error.to_string())))?;
        Ok(Draft { text: guess.text, seen: guess.seen, open: guess.open })
    }

    /// Writes the `trial.toml`, and moves the trial into the folder if it can be read. Returns its path and the
    /// findings of its checks.
    ///
    /// # Errors
    /// If the trial cannot be read with this text, or was made by someone else meanwhile.
    pub(crate) fn save(&self, root: &Path, text: &str) -> Result<(PathBuf, Vec<String>), Refusal> {
        let (aside, last) = (self.aside(root)?, self.last(root)?);
        write_file(&aside.join(TRIAL_FILE), text.as_bytes()).map_err(|error| Refusal::wrong(error.to_string()))?;
        let read = Trial::checked(&aside);
        let (_, checks) = read.map_err(|error| Refusal::wrong(self.without_aside(root, &error.to_string())))?;
        let above = last.parent().unwrap_or(root);
        fs::create_dir_all(above).map_err(|error| unwritable(above, &error))?;
        if last.exists() {
            return Err(Refusal::wrong(format!("{}: this folder exists; another name is accepted", last.display())));
        }
        fs::rename(&aside, &last).map_err(|error| unwritable(&last, &error))?;
        for folder in aside.ancestors().skip(1).take_while(|folder| *folder != root) {
            // A folder that holds other trials stays, and those above it.
            if fs::remove_dir(folder).is_err() {
                break;
            }
        }
        let findings = checks.iter().flat_map(|check| &check.findings);
        let words = findings.map(|finding| self.without_aside(root, &in_words(finding))).collect();
        Ok((last, words))
    }

    /// Folder of this trial in the served one.
    fn last(&self, root: &Path) -> Result<PathBuf, Refusal> {
        let above = if self.campaign.is_empty() { root.to_owned() } else { root.join(fit(&self.campaign)?) };
        Ok(above.join(fit(&self.trial)?))
    }

    fn aside(&self, root: &Path) -> Result<PathBuf, Refusal> {
        self.last(&root.join(ASIDE))
    }

    /// Words of an error without the path of the place aside, which the page does not show.
    fn without_aside(&self, root: &Path, words: &str) -> String {
        let aside = self.aside(root).unwrap_or_default();
        words.replace(&format!("{}/", aside.display()), "").replace(&aside.display().to_string(), &self.trial)
    }
}

fn in_words(finding: &Finding) -> String {
    let Finding { check, found, expected, guess, .. } = finding;
    let parts = [Some(found), expected.as_ref(), guess.as_ref()].into_iter().flatten();
    format!("{check}: {}", parts.map(String::as_str).collect::<Vec<_>>().join("; "))
}

fn unwritable(path: &Path, error: &std::io::Error) -> Refusal {
    Refusal::wrong(format!("{}: {error}; a folder that can be written is accepted", path.display()))
}

/// Returns a name that is one visible entry of a folder.
///
/// # Errors
/// The name, and which names are accepted.
pub(crate) fn fit(name: &str) -> Result<&str, Refusal> {
    let is_letter = |c: char| !(c.is_control() || "/\\:*?\"<>|".contains(c));
    let is_fit = !name.is_empty()
        && name.chars().count() <= LONGEST_NAME
        && name.chars().all(is_letter)
        && !name.starts_with(['.', ' '])
        && !name.ends_with(['.', ' ']);
    let shown: String = name.chars().take(LONGEST_NAME).collect();
    is_fit.then_some(name).ok_or_else(|| {
        Refusal::wrong(format!(
            "{shown:?} is no name of a file or folder; up to {LONGEST_NAME} letters, digits, spaces, hyphens and dots \
             are accepted, no dot or space at either end"
        ))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_leave_the_folder_are_refused() {
        for name in ["plate 7", "pass1_after.csv", "Prüfung-2"] {
            assert_eq!(fit(name).unwrap(), name);
        }
        for name in ["", ".", "..", "../x", "a/b", "a\\b", ".hidden", "x ", "a\nb", "c:", &"x".repeat(81)] {
            assert!(fit(name).unwrap_err().1.contains("accepted"), "{name}");
        }
    }
}
