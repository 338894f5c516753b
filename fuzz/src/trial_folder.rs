//! Folders with sound measurements, one file of which is replaced by what the fuzzer makes.

use std::fs;
use std::sync::LazyLock;

use trials::table::Table;
use trials::trial::{Trial, write_trial};
use tempfile::TempDir;

#[allow(dead_code, reason = "the tests use the rest")]
#[path = "../../tests/trial/files.rs"]
mod files;

const TABLE: &str = include_str!("../../data/tables/belt-sanding/table.toml");
const ROWS: &str = include_str!("../../data/tables/belt-sanding/trials.csv");

/// A folder of a trial or a table.
pub struct Folder {
    place: TempDir,
    is_table: bool,
}

impl Folder {
    /// A grinding trial with height maps, labels and an admittance controller.
    pub fn grinding() -> &'static Self {
        static FOLDER: LazyLock<Folder> = LazyLock::new(|| Folder::of(&files::grinding()));
        &FOLDER
    }

    /// A sanding trial with an exposure mask.
    pub fn sanding() -> &'static Self {
        static FOLDER: LazyLock<Folder> = LazyLock::new(|| Folder::of(&files::sanding()));
        &FOLDER
    }

    /// A table of removal rates.
    pub fn table() -> &'static Self {
        static FOLDER: LazyLock<Folder> = LazyLock::new(|| {
            let place = tempfile::tempdir().expect("a temporary folder");
            fs::write(place.path().join("table.toml"), TABLE).expect("a manifest");
            fs::write(place.path().join("trials.csv"), ROWS).expect("rows");
            Table::read(place.path()).expect("a sound table");
            Folder { place, is_table: true }
        });
        &FOLDER
    }

    fn of(trial: &Trial) -> Self {
        let place = tempfile::tempdir().expect("a temporary folder");
        write_trial(trial, place.path()).expect("a sound trial");
        Trial::read(place.path()).expect("a sound trial");
        Self { place, is_table: false }
    }

    /// The text of a file as it is.
    pub fn text(&self, name: &str) -> String {
        fs::read_to_string(self.place.path().join(name)).expect("a file of the folder")
    }

    /// Reads the folder with this content in one of its files; an error has a message and no more.
    pub fn survive(&self, name: &str, bytes: &[u8]) {
        fs::write(self.place.path().join(name), bytes).expect("the file is replaced");
        let fault =
            if self.is_table { Table::read(self.place.path()).err() } else { Trial::read(self.place.path()).err() };
        if let Some(error) = fault {
            assert!(error.to_string().chars().count() < LONGEST_MESSAGE, "{error}");
        }
    }
}

/// Characters of a message that a terminal still shows as a whole.
const LONGEST_MESSAGE: usize = 2000;
