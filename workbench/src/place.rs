//! Folders that can be shown: campaigns, tables, studies, assets, data sets.

use std::fs;
use std::path::{Path, PathBuf};

use files::sha256;
use trials::table::TABLE_FILE;
use trials::trial::Campaign;

/// Greatest depth below the served folder, and greatest number of folders searched; they bound the search.
pub(crate) const DEEPEST: usize = 4;
pub(crate) const MOST_FOLDERS: usize = 4000;
/// Number of hexadecimal digits of a place's id.
pub(crate) const ID_DIGITS: usize = 12;

/// Kind of a folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    /// Trials with scans.
    Campaign,
    /// A table of rows.
    Table,
    /// A study's folder.
    Study,
    /// A report page: calibration, comparison or diagnosis.
    Result,
    /// A welded workpiece.
    Asset,
    /// A data set of assets, or labelled images.
    DataSet,
}

impl Kind {
    /// All kinds in the order of the home page, with their headings.
    pub(crate) const ALL: [(Self, &str); 6] = [
        (Self::Campaign, "Campaigns: trials with scans"),
        (Self::Table, "Tables of rows"),
        (Self::Study, "Studies"),
        (Self::Result, "Calibrations, comparisons and diagnoses"),
        (Self::Asset, "Assets"),
        (Self::DataSet, "Data sets"),
    ];

    /// Finds the kind of a folder by the marker file in it.
    pub(crate) fn of(folder: &Path) -> Option<Self> {
        let marks = [
            ("study.json", Self::Study),
            ("calibration.json", Self::Result),
            ("comparison.json", Self::Result),
            ("diagnosis.json", Self::Result),
            ("asset.json", Self::Asset),
            ("dataset.json", Self::DataSet),
            (TABLE_FILE, Self::Table),
        ];
        let marked = marks.into_iter().find(|(name, _)| folder.join(name).is_file());
        marked.map(|(_, kind)| kind)
    }

    /// Returns true if effects can be tried on it.
    pub(crate) fn has_bench(self) -> bool {
        matches!(self, Self::Campaign | Self::Table)
    }
}

/// A folder that can be opened.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Place {
    /// Id in addresses.
    pub(crate) id: String,
    /// Kind of the folder.
    pub(crate) kind: Kind,
    /// Path relative to the served folder; empty for that folder itself.
    pub(crate) name: String,
    /// Path of the folder.
    pub(crate) path: PathBuf,
    /// Number of trials of a campaign.
    pub(crate) trials: usize,
}

impl Place {
    fn new(root: &Path, path: &Path, (kind, trials): (Kind, usize)) -> Self {
        let name = path.strip_prefix(root).unwrap_or(path).display().to_string();
        let id = sha256(path.as_os_str().as_encoded_bytes())[..ID_DIGITS].to_owned();
        Self { id, kind, name, path: path.to_owned(), trials }
    }

    /// Returns the name for people.
    pub(crate) fn title(&self) -> String {
        let own = || self.path.file_name().map_or_else(|| "this folder".into(), |name| name.to_string_lossy());
        if self.name.is_empty() { own().into_owned() } else { self.name.clone() }
    }

    /// Returns a name for its folder of results: letters, digits and hyphens of its name, and the start of its id.
    pub(crate) fn slug(&self) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '-' };
        let own: String = self.title().chars().map(plain).take(40).collect();
        format!("{own}-{}", &self.id[..6])
    }
}

/// Lists all places below a folder, including itself, ordered by kind and name; links are not followed. The second
/// value is true if the search ended at the greatest number of folders.
pub(crate) fn places(root: &Path) -> (Vec<Place>, bool) {
    let (mut found, mut left) = (Vec::new(), vec![(root.to_owned(), 0)]);
    let mut seen = 0;
    while let Some((folder, depth)) = left.pop() {
        seen += 1;
        if seen > MOST_FOLDERS {
            break;
        }
        if let Some(kind) = Kind::of(&folder) {
            found.push(Place::new(root, &folder, (kind, 0)));
            // A study may contain its campaign.
            if kind != Kind::Study {
                continue;
            }
        } else if let Ok(trials) = Campaign::places(&folder) {
            found.push(Place::new(root, &folder, (Kind::Campaign, trials.len())));
            continue;
        }
        if depth < DEEPEST {
            left.extend(folders(&folder).into_iter().map(|below| (below, depth + 1)));
        }
    }
    found.sort_by(|a, b| (a.kind, &a.name).cmp(&(b.kind, &b.name)));
    (found, seen > MOST_FOLDERS)
}

/// Lists the visible subfolders, without links; empty if the folder cannot be read.
pub(crate) fn folders(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let is_shown = |name: &str| !name.starts_with('.') && name != "target" && name != "node_modules";
    let own = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_dir()));
    own.filter(|entry| is_shown(&entry.file_name().to_string_lossy())).map(|entry| entry.path()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_folder_is_shows_in_its_marker_and_hostile_names_stay_names() {
        let root = tempfile::tempdir().unwrap();
        let hostile = "<script>alert(1)</script>";
        for (folder, marker) in [("a b'c", "study.json"), ("x/y", "asset.json"), ("set", "dataset.json")] {
            fs::create_dir_all(root.path().join(folder)).unwrap();
            fs::write(root.path().join(folder).join(marker), "{}").unwrap();
        }
        let trial = root.path().join("campaign").join("one").join("trial.toml");
        let names: Vec<&str> = hostile.split('/').collect();
        fs::create_dir_all(root.path().join(names[0]).join(names[1])).unwrap();
        fs::create_dir_all(trial.parent().unwrap()).unwrap();
        fs::write(&trial, "").unwrap();
        let (found, is_cut) = places(root.path());
        let kinds: Vec<(Kind, &str)> = found.iter().map(|place| (place.kind, place.name.as_str())).collect();
        let expected =
            [(Kind::Campaign, "campaign"), (Kind::Study, "a b'c"), (Kind::Asset, "x/y"), (Kind::DataSet, "set")];
        assert!(!is_cut);
        assert_eq!(kinds, expected);
        assert!(found.iter().all(|place| place.slug().chars().all(|c| c.is_ascii_alphanumeric() || "-_".contains(c))));
    }
}
