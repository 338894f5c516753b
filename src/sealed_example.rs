//! The bundled sealed example: a small synthetic campaign with a sealed answer.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

/// Name of the bundled campaign.
pub const EXAMPLE_NAME: &str = "first-look";

macro_rules! bundled {
    ($folder:literal: $($file:literal),* $(,)?) => {
        &[$(($file, include_bytes!(concat!("../data/campaigns/", $folder, "/", $file)))),*]
    };
}

/// Files of the campaign.
const FILES: &[(&str, &[u8])] = bundled!("first-look":
    "laboratory.json", "sealed.json",
    "trial-1/trial.toml", "trial-1/before.csv", "trial-1/before_repeat.csv", "trial-1/material.csv",
    "trial-1/pass1_log.csv", "trial-1/pass1_after.csv", "trial-1/pass2_log.csv", "trial-1/pass2_after.csv",
    "trial-2/trial.toml", "trial-2/before.csv", "trial-2/before_repeat.csv", "trial-2/material.csv",
    "trial-2/pass1_log.csv", "trial-2/pass1_after.csv", "trial-2/pass2_log.csv", "trial-2/pass2_after.csv",
    "trial-3/trial.toml", "trial-3/before.csv", "trial-3/before_repeat.csv", "trial-3/material.csv",
    "trial-3/pass1_log.csv", "trial-3/pass1_after.csv", "trial-3/pass2_log.csv", "trial-3/pass2_after.csv",
);
/// The key of its seal.
const KEY: &[u8] = include_bytes!("../data/campaigns/first-look.key");

/// Writes the bundled campaign into a folder, and its key beside it.
///
/// # Errors
/// If a file cannot be written.
pub fn unpack(folder: &Path, key: &Path) -> Result<()> {
    for (name, bytes) in FILES {
        let file = folder.join(name);
        let context = || format!("{}: cannot write this file", file.display());
        fs::create_dir_all(file.parent().unwrap_or(folder)).with_context(context)?;
        fs::write(&file, bytes).with_context(context)?;
    }
    fs::write(key, KEY).with_context(|| format!("{}: cannot write this file", key.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_of_the_campaign_is_bundled() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/campaigns").join(EXAMPLE_NAME);
        let files = walkdir::WalkDir::new(&folder).into_iter().map(Result::unwrap).filter(|e| e.file_type().is_file());
        let mut there: Vec<String> =
            files.map(|e| e.path().strip_prefix(&folder).unwrap().to_str().unwrap().replace('\\', "/")).collect();
        let mut bundled: Vec<&str> = FILES.iter().map(|(name, _)| *name).collect();
        there.sort();
        bundled.sort_unstable();
        assert_eq!(bundled, there);
    }
}
