//! The plan of the next trial, beside a study or a diagnosis, as one file to download.

use std::fs;
use std::io::{Cursor, Write};
use std::path::Path;

use files::input::{self, MOST_TEXT_BYTES};
use study::{NEXT_TRIAL, NEXT_TRIAL_NAMES};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use crate::error::Refusal;

/// Returns true if a folder holds a plan.
pub(crate) fn has_plan(folder: &Path) -> bool {
    folder.join(NEXT_TRIAL).is_dir()
}

/// Packs the files of a plan as ZIP; what was measured since is left out.
///
/// # Errors
/// If there is no plan, or a file cannot be read.
pub(crate) fn archive(folder: &Path) -> Result<Vec<u8>, Refusal> {
    let failed = |words: String| Refusal::missing(format!("{}: {words}", folder.join(NEXT_TRIAL).display()));
    let mut packed = ZipWriter::new(Cursor::new(Vec::new()));
    let mut count = 0;
    for (below, patterns) in NEXT_TRIAL_NAMES {
        for name in names(&folder.join(below)).iter().filter(|name| patterns.iter().any(|own| fits(own, name))) {
            let member = format!("{below}{name}");
            let bytes =
                input::read(&folder.join(&member), MOST_TEXT_BYTES).map_err(|error| failed(error.to_string()))?;
            let written = packed
                .start_file(member, SimpleFileOptions::default())
                .map_err(|error| error.to_string())
                .and_then(|()| packed.write_all(&bytes).map_err(|error| error.to_string()));
            written.map_err(failed)?;
            count += 1;
        }
    }
    if count == 0 {
        return Err(failed("there is no plan of a next trial".to_owned()));
    }
    Ok(packed.finish().map_err(|error| failed(error.to_string()))?.into_inner())
}

/// Returns true if a name fits a pattern, in which `*` stands for digits.
fn fits(pattern: &str, name: &str) -> bool {
    match pattern.split_once('*') {
        None => name == pattern,
        Some((begin, end)) => {
            let middle = name.strip_prefix(begin).and_then(|rest| rest.strip_suffix(end));
            middle.is_some_and(|middle| !middle.is_empty() && middle.bytes().all(|b| b.is_ascii_digit()))
        }
    }
}

/// Names of the files in a folder, sorted; links are left out.
fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let own = entries.filter(|entry| entry.file_type().is_ok_and(|kind| kind.is_file()));
    let mut names: Vec<String> = own.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;

    #[test]
    fn the_plan_is_packed_and_measurements_are_not() {
        let folder = tempfile::tempdir().unwrap();
        let plan = folder.path().join(NEXT_TRIAL);
        assert!(archive(folder.path()).unwrap_err().1.contains("no plan"));
        fs::create_dir_all(plan.join("part-2")).unwrap();
        for name in ["trial.toml", "pass1_path.csv", "pass12_log_template.csv", "before.csv", "part-2/trial.toml"] {
            fs::write(plan.join(name), name).unwrap();
        }
        let mut packed = zip::ZipArchive::new(Cursor::new(archive(folder.path()).unwrap())).unwrap();
        let mut found: Vec<String> = packed.file_names().map(|name| name.unwrap().into_owned()).collect();
        found.sort();
        let expected = ["part-2/trial.toml", "pass12_log_template.csv", "pass1_path.csv", "trial.toml"];
        assert_eq!(found, expected.map(|name| format!("{NEXT_TRIAL}/{name}")));
        let mut text = String::new();
        packed.by_name(&found[2]).unwrap().read_to_string(&mut text).unwrap();
        assert_eq!(text, "pass1_path.csv");
    }
}
