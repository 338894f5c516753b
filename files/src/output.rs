//! Rules for replacing an existing `--out`: a verb may replace its own earlier result, and never an input.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use crate::error::{FileError, wrong_use};

/// Marker files that make a folder a result; all its other files belong to it.
const RESULTS: [&str; 12] = [
    "asset.json",
    "calibration.json",
    "comparison.json",
    "dataset.json",
    "demo.json",
    "diagnosis.json",
    "grind.json",
    "laboratory.json",
    "render.json",
    "simulation.json",
    "study.json",
    "cache.json",
];
/// Marker files of measurements.
const MEASUREMENTS: [&str; 2] = ["table.toml", "trial.toml"];
/// Suffix of the folder beside an output that holds intermediate work until the run ends.
pub const UNFINISHED: &str = ".unfinished";
/// Files that file managers create in every folder.
const SYSTEM_FILES: [&str; 3] = [".DS_Store", "Thumbs.db", "desktop.ini"];

/// Output path of a verb, and what it must not touch.
#[derive(Clone, Copy, Debug)]
pub struct OutputPath<'a> {
    /// The requested path.
    pub place: &'a Path,
    /// True if an earlier result there may be replaced.
    pub force: bool,
    /// Files and folders that the verb reads.
    pub inputs: &'a [&'a Path],
}

/// A folder that a verb writes.
#[derive(Clone, Copy, Debug)]
pub struct FolderKind {
    /// Marker file of the kind: a JSON object.
    pub marker: &'static str,
    /// A key of that object.
    pub key: &'static str,
    /// Names of all other files, with their subfolder; `*` stands for any characters of a name.
    pub names: &'static [(&'static str, &'static [&'static str])],
}

/// A file that a verb writes.
#[derive(Clone, Copy, Debug)]
pub struct FileKind {
    /// Description in a few words.
    pub what: &'static str,
    /// Returns true if a file is of this kind.
    pub is_own: fn(&Path) -> bool,
}

impl FolderKind {
    /// Refuses a folder that holds anything other than the files of an earlier, perhaps unfinished, run of this kind.
    ///
    /// # Errors
    /// Wrong usage.
    pub fn check_continued(&self, place: &Path) -> Result<(), FileError> {
        let marker = place.join(self.marker);
        let refused = |name: &Path| {
            let (place, name) = (place.display(), name.display());
            Err(wrong_use(format!("{place} holds {name}, which this command does not write: choose another --out")))
        };
        if place.symlink_metadata().is_ok() && !place.is_dir() {
            return Err(wrong_use(format!("{} is a file; --out expects the name of a folder", place.display())));
        }
        if marker.symlink_metadata().is_ok() && !has_key(&marker, self.key) {
            return refused(Path::new(self.marker));
        }
        if !place.is_dir() {
            return Ok(());
        }
        foreign(place, self).map_or(Ok(()), |name| refused(&name))
    }
}

impl<'a> OutputPath<'a> {
    /// An output that replaces nothing.
    pub fn fresh(place: &'a Path) -> Self {
        Self { place, force: false, inputs: &[] }
    }

    /// Refuses a path that is occupied, except by an earlier folder of this kind that may be replaced.
    ///
    /// # Errors
    /// Wrong usage.
    pub fn check_folder(&self, kind: &FolderKind) -> Result<(), FileError> {
        if !self.may_replace()? {
            return Ok(());
        }
        let place = self.place;
        if !place.is_dir() {
            return Err(wrong_use(format!("{} is a file; --out expects the name of a folder", place.display())));
        }
        let refused = |why: String| {
            let shown = place.display();
            Err(wrong_use(format!("{shown} {why}: it is not a result of this command, so --force does not replace it")))
        };
        let marker = place.join(kind.marker);
        if !marker.is_file() {
            return refused(format!("holds no {}", kind.marker));
        }
        if !has_key(&marker, kind.key) {
            return refused(format!("holds a {} of another kind", kind.marker));
        }
        match foreign(place, kind) {
            None => Ok(()),
            Some(name) => Err(wrong_use(format!(
                "{} holds {}, which this command does not write, so --force does not replace the folder: move that \
                 away, or choose another --out",
                place.display(),
                name.display()
            ))),
        }
    }

    /// Refuses a path that is occupied, except by an earlier file of this kind that may be replaced.
    ///
    /// # Errors
    /// Wrong usage.
    pub fn check_file(&self, kind: &FileKind) -> Result<(), FileError> {
        if !self.may_replace()? {
            return Ok(());
        }
        let place = self.place;
        if place.is_dir() {
            return Err(wrong_use(format!("{} is a folder; --out expects the name of a file", place.display())));
        }
        let refused = |why: &str| Err(wrong_use(format!("{} {why}, so --force does not replace it", place.display())));
        if !place.is_file() || !(kind.is_own)(place) {
            return refused(&format!("is not {} written by this command", kind.what));
        }
        let beside = |marker: &&&str| place.parent().is_some_and(|folder| folder.join(marker).is_file());
        match RESULTS.iter().chain(&MEASUREMENTS).find(beside) {
            None => Ok(()),
            Some(marker) => refused(&format!("belongs to the {marker} beside it")),
        }
    }

    /// Returns true if there is something to replace, and inputs and `--force` allow it.
    fn may_replace(&self) -> Result<bool, FileError> {
        self.refuse_inputs()?;
        if !is_occupied(self.place) {
            return Ok(false);
        }
        if self.force {
            return Ok(true);
        }
        Err(wrong_use(format!(
            "{} already exists and is not overwritten: choose another --out, or give --force",
            self.place.display()
        )))
    }

    /// Refuses an input, a folder that contains one, and a file inside one, however their paths are written.
    fn refuse_inputs(&self) -> Result<(), FileError> {
        let Ok(place) = fs::canonicalize(self.place) else { return Ok(()) };
        for input in self.inputs {
            let Ok(real) = fs::canonicalize(input) else { continue };
            let is_input = real == place || same_file::is_same_file(&place, &real).unwrap_or(false);
            let relation = match (is_input, real.starts_with(&place), place.is_file() && place.starts_with(&real)) {
                (true, ..) => "is the input",
                (_, true, _) => "holds the input",
                (_, _, true) => "lies in the input",
                _ => continue,
            };
            let (place, input) = (self.place.display(), input.display());
            return Err(wrong_use(format!(
                "--out {place} {relation} {input}; it already exists, and no input is replaced: choose another --out"
            )));
        }
        Ok(())
    }
}

/// True for a folder that holds results of a verb that has ended, is running, or was interrupted.
pub fn holds_results(folder: &Path) -> bool {
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    let has = |markers: &[&str]| markers.iter().any(|marker| folder.join(marker).is_file());
    is_staged(&name) || name.ends_with(UNFINISHED) || (has(&RESULTS) && !has(&MEASUREMENTS))
}

/// True for the temporary name of an output in progress.
fn is_staged(name: &str) -> bool {
    name.starts_with('.') && name.contains(".part-")
}

/// Returns true if a file, folder or link is at a path.
pub fn is_occupied(target: &Path) -> bool {
    match fs::read_dir(target) {
        Ok(mut entries) => entries.next().is_some(),
        Err(_) => target.symlink_metadata().is_ok(),
    }
}

/// Returns true if the first JSON value of a file is an object with this key.
fn has_key(file: &Path, key: &str) -> bool {
    let Ok(file) = fs::File::open(file) else { return false };
    let mut values = serde_json::Deserializer::from_reader(std::io::BufReader::new(file)).into_iter::<Value>();
    matches!(values.next(), Some(Ok(value)) if value.get(key).is_some())
}

/// The first file below a folder that does not belong to its kind.
fn foreign(folder: &Path, kind: &FolderKind) -> Option<PathBuf> {
    let entries = walkdir::WalkDir::new(folder).min_depth(1).sort_by_file_name();
    let is_foreign = |path: &Path| {
        let name = path.to_string_lossy().replace('\\', "/");
        let own = name.rsplit('/').next().unwrap_or_default();
        let is_in = |(below, names): &(&str, &[&str])| {
            name.strip_prefix(below).is_some_and(|name| names.iter().any(|pattern| fits(pattern, name)))
        };
        name != kind.marker && !is_staged(own) && !SYSTEM_FILES.contains(&own) && !kind.names.iter().any(is_in)
    };
    entries.into_iter().find_map(|entry| match entry {
        Ok(entry) if entry.file_type().is_dir() => None,
        Ok(entry) => entry.path().strip_prefix(folder).ok().filter(|path| is_foreign(path)).map(Path::to_owned),
        Err(error) => Some(error.path().unwrap_or(folder).to_owned()),
    })
}

/// Returns true if a path matches a pattern, in which `*` stands for any characters of a name.
fn fits(pattern: &str, path: &str) -> bool {
    match pattern.split_once('*') {
        None => pattern == path,
        Some((start, rest)) => path.strip_prefix(start).is_some_and(|left| {
            let name = left.find('/').unwrap_or(left.len());
            (0..=name).filter(|&at| left.is_char_boundary(at)).any(|at| fits(rest, &left[at..]))
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KIND: FolderKind = FolderKind {
        marker: "result.json",
        key: "agrees",
        names: &[("", &["report.html", "pass-*.csv"]), ("maps/", &["*_um.csv"])],
    };

    fn write(folder: &Path, name: &str, text: &str) {
        let place = folder.join(name);
        fs::create_dir_all(place.parent().unwrap()).unwrap();
        fs::write(place, text).unwrap();
    }

    #[track_caller]
    fn assert_refused(folder: &Path, words: &[&str]) {
        let out = OutputPath { place: folder, force: true, inputs: &[] };
        let said = out.check_folder(&KIND).unwrap_err().to_string();
        assert!(words.iter().all(|word| said.contains(word)), "{said}");
    }

    #[test]
    fn force_replaces_a_folder_only_if_every_file_in_it_is_ours() {
        let place = tempfile::tempdir().unwrap();
        let folder = &place.path().join("result");
        write(folder, "report.html", "");
        assert_refused(folder, &["no result.json"]);
        write(folder, "result.json", "{\"mine\": 1}");
        assert_refused(folder, &["result.json of another kind"]);
        write(folder, "result.json", "{\"agrees\": true}");
        write(folder, "pass-1.csv", "");
        write(folder, "maps/pass1_um.csv", "");
        write(folder, ".DS_Store", "");
        let out = OutputPath { place: folder, force: true, inputs: &[] };
        out.check_folder(&KIND).unwrap();
        assert!(OutputPath { force: false, ..out }.check_folder(&KIND).unwrap_err().to_string().contains("--force"));
        for name in ["notes.txt", "maps/deep/pass1_um.csv", "pass-1.csv.bak", "maps/report.html"] {
            write(folder, name, "years of work");
            assert_refused(folder, &[name, "does not write"]);
            fs::remove_file(folder.join(name)).unwrap();
        }
    }

    #[test]
    fn no_input_is_replaced_by_whatever_way_it_is_named() {
        let place = tempfile::tempdir().unwrap();
        let at = |name: &str| place.path().join(name);
        write(place.path(), "parts/part.obj", "v 0 0 0");
        fs::hard_link(at("parts/part.obj"), at("hard.obj")).unwrap();
        let kind = FileKind { what: "a test", is_own: |_| true };
        let refused = |out: PathBuf, input: PathBuf| {
            let out = OutputPath { place: &out, force: true, inputs: &[&input] };
            let said = out.check_file(&kind).err().map(|error| error.to_string()).unwrap_or_default();
            assert!(said.contains("the input"), "{said:?} for {out:?}");
        };
        refused(at("parts/part.obj"), at("parts/part.obj"));
        refused(at("parts/../parts/part.obj"), at("parts/part.obj"));
        refused(at("hard.obj"), at("parts/part.obj"));
        refused(at("parts"), at("parts/part.obj"));
        refused(at("parts/part.obj"), at("parts"));
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(at("parts/part.obj"), at("soft.obj")).unwrap();
            std::os::unix::fs::symlink(at("parts"), at("linked")).unwrap();
            refused(at("soft.obj"), at("parts/part.obj"));
            refused(at("parts/part.obj"), at("soft.obj"));
            refused(at("linked/part.obj"), at("parts/part.obj"));
        }
    }

    #[test]
    fn a_file_is_replaced_only_if_it_is_ours_and_belongs_to_nothing_else() {
        let place = tempfile::tempdir().unwrap();
        let file = place.path().join("plan.csv");
        let check = |is_own| {
            let out = OutputPath { place: &file, force: true, inputs: &[] };
            out.check_file(&FileKind { what: "a plan", is_own }).map_err(|error| error.to_string())
        };
        check(|_| true).unwrap();
        fs::write(&file, "mine").unwrap();
        assert!(check(|_| false).unwrap_err().contains("is not a plan"));
        check(|_| true).unwrap();
        fs::write(place.path().join("trial.toml"), "").unwrap();
        assert!(check(|_| true).unwrap_err().contains("trial.toml"));
    }
}
