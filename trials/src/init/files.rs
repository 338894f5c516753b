//! Recognition of a folder's files by their content.

use std::path::{Path, PathBuf};

use files::input::{self, MOST_MESH_BYTES};
use instruments::log::guess::Role;
use instruments::log::{Channels, Guesses};
use instruments::surface::{self, Source, Surface, Window};
use instruments::{Misread, Place, log};

use crate::trial::{TRIAL_FILE, TrialError};

/// Pixel values of a mask: coated and exposed.
const MASK_VALUES: [f64; 2] = [0.0, 1.0];
/// Name of the format of meshes.
const MESH: &str = "mesh";
/// Maximum number of files that are read.
const MOST_FILES: usize = 500;

/// A file with its kind.
pub(super) struct Entry {
    /// Its name in the folder.
    pub(super) name: String,
    pub(super) kind: Kind,
}

/// Kind of a file.
pub(super) enum Kind {
    /// A height map.
    Map(Surface),
    /// A map with the values 0 and 1 only.
    Mask(Surface),
    /// A log, with guesses for its channels.
    Log(Channels, Guesses),
    /// A file that no trial uses, and the reason.
    Other(String),
}

/// All files of a folder in natural order.
pub(super) struct Found {
    pub(super) entries: Vec<Entry>,
}

impl Found {
    /// Reads all files of a folder, without its subfolders.
    pub(super) fn look(folder: &Path) -> Result<Self, TrialError> {
        let unreadable = |source| TrialError::Unreadable { file: folder.to_owned(), source };
        let mut places: Vec<PathBuf> = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(unreadable)? {
            let place = entry.map_err(unreadable)?.path();
            let is_own = place.file_name().is_none_or(|name| name == TRIAL_FILE || name.as_encoded_bytes()[0] == b'.');
            if place.is_file() && !is_own {
                places.push(place);
            }
        }
        if places.len() > MOST_FILES {
            let found = format!("{} files", places.len());
            return Err(
                Place::file(folder).bad(found, format!("at most {MOST_FILES}, those of one trial, are expected"))
            );
        }
        places.sort_by_cached_key(|place| natural(&name_of(place)));
        Ok(Self { entries: places.iter().map(|place| Entry { name: name_of(place), kind: Kind::of(place) }).collect() })
    }

    /// Refuses a folder that lacks a scan or a log.
    pub(super) fn check(&self, folder: &Path) -> Result<(), TrialError> {
        let missing = match (self.maps().next(), self.logs().next()) {
            (None, _) => "scan",
            (_, None) => "log",
            _ => return Ok(()),
        };
        let seen = self.seen();
        let seen = if seen.is_empty() { "no file".to_owned() } else { seen.join("; ") };
        let formats: Vec<&str> = surface::formats().chain(log::formats()).collect();
        let accepted = format!("the scans and the logs of one trial are expected; read are {}", formats.join(", "));
        Err(Place::file(folder).bad(format!("no {missing} in {seen}"), accepted))
    }

    pub(super) fn maps(&self) -> impl Iterator<Item = (&str, &Surface)> {
        self.entries.iter().filter_map(|entry| match &entry.kind {
            Kind::Map(surface) => Some((entry.name.as_str(), surface)),
            _ => None,
        })
    }

    pub(super) fn masks(&self) -> impl Iterator<Item = (&str, &Surface)> {
        self.entries.iter().filter_map(|entry| match &entry.kind {
            Kind::Mask(surface) => Some((entry.name.as_str(), surface)),
            _ => None,
        })
    }

    pub(super) fn logs(&self) -> impl Iterator<Item = (&str, &Channels, &Guesses)> {
        self.entries.iter().filter_map(|entry| match &entry.kind {
            Kind::Log(channels, guesses) => Some((entry.name.as_str(), channels, guesses)),
            _ => None,
        })
    }

    /// Names of files that are no scans, but may be surfaces as drawn: meshes without the pixels of a scan.
    pub(super) fn meshes(&self) -> impl Iterator<Item = &str> {
        let extensions = surface::extensions().find(|(format, _)| *format == MESH).map_or(&[][..], |(_, own)| own);
        let is_mesh = move |entry: &&Entry| {
            let name = Path::new(&entry.name);
            let has = |extension: &&str| name.extension().is_some_and(|own| own.eq_ignore_ascii_case(extension));
            matches!(entry.kind, Kind::Other(_)) && extensions.iter().any(has)
        };
        self.entries.iter().filter(is_mesh).map(|entry| entry.name.as_str())
    }

    /// A description of each file.
    pub(super) fn seen(&self) -> Vec<String> {
        self.entries.iter().map(|entry| format!("{}: {}", entry.name, entry.kind.words())).collect()
    }
}

impl Kind {
    fn of(place: &Path) -> Self {
        let bytes = match input::read(place, MOST_MESH_BYTES) {
            Ok(bytes) => bytes,
            Err(error) => return Self::Other(error.to_string()),
        };
        if let Some(log) = as_log(place, &bytes) {
            return log;
        }
        match surface::read(&Source { file: place, bytes: &bytes, window: Window::default() }) {
            Ok(surface) if is_mask(&surface) => Self::Mask(surface),
            Ok(surface) => Self::Map(surface),
            Err(Misread::Bad { found, .. }) => Self::Other(format!("neither scan nor log: {found}")),
            Err(error) => Self::Other(error.to_string()),
        }
    }

    /// Description for messages.
    fn words(&self) -> String {
        match self {
            Self::Map(surface) => format!("height map ({}), {}", surface.format, surface.summary()),
            Self::Mask(surface) => format!("mask of 0 and 1, {} x {} pixels", surface.nx, surface.ny),
            Self::Log(channels, _) => {
                format!("log ({}), {} rows of {} channels", channels.format, channels.rows(), channels.names.len())
            }
            Self::Other(why) => why.clone(),
        }
    }
}

/// Reads a file as a log if it has a time, a position and a force.
fn as_log(place: &Path, bytes: &[u8]) -> Option<Kind> {
    let channels = log::read(place, bytes).ok()?;
    let guesses = log::guess(&channels);
    let has = |role: Role| guesses.best(role).is_some();
    let is_log = has(Role::Time) && has(Role::Force) && [Role::X, Role::Y, Role::Z].into_iter().any(has);
    is_log.then_some(Kind::Log(channels, guesses))
}

/// True for a map with the values 0 and 1 only, both present. Numbers without a unit were read as millimetres.
fn is_mask(surface: &Surface) -> bool {
    let known = || surface.heights.iter().filter(|height| height.is_finite()).map(|height| (height * 1e3).round());
    let exact = surface.heights.iter().all(|height| height.is_nan() || MASK_VALUES.contains(&(height * 1e3)));
    exact && MASK_VALUES.iter().all(|value| known().any(|own| own == *value))
}

fn name_of(place: &Path) -> String {
    place.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// Key for natural sorting: a name split into words and numbers, so that 10 comes after 9.
fn natural(name: &str) -> Vec<(u64, String)> {
    let mut parts = Vec::new();
    let mut rest = name;
    while !rest.is_empty() {
        let word = rest.find(|c: char| c.is_ascii_digit()).unwrap_or(rest.len());
        let number = rest[word..].find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len() - word);
        let value = rest[word..word + number].parse().unwrap_or(u64::MAX);
        parts.push((value, rest[..word].to_lowercase()));
        rest = &rest[word + number..];
    }
    // The word is compared before the number that follows it.
    parts.into_iter().flat_map(|(value, word)| [(0, word), (value, String::new())]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ten_comes_after_nine() {
        let mut names = ["pass10.csv", "pass9.csv", "Pass1.csv", "after.csv"];
        names.sort_by_cached_key(|name| natural(name));
        assert_eq!(names, ["after.csv", "Pass1.csv", "pass9.csv", "pass10.csv"]);
    }
}
