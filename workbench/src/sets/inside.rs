//! Files of a set, found among the folder's own entries.

use std::fs;
use std::path::{Component, Path, PathBuf};

use crate::error::Refusal;

/// Greatest size of a picture [bytes].
pub(super) const MOST_PICTURE_BYTES: u64 = 64 << 20;

/// Finds the file of a relative path that a catalogue names, going from entry to entry of the folder.
///
/// # Errors
/// If the path leaves the folder, goes through a link, or does not exist.
pub(super) fn inside(folder: &Path, relative: &str) -> Result<PathBuf, Refusal> {
    let mut place = folder.to_owned();
    for part in Path::new(relative).components() {
        let Component::Normal(name) = part else {
            return Err(Refusal::wrong(format!("{relative:?} leads out of the data set; paths below it are accepted")));
        };
        let own = fs::read_dir(&place).into_iter().flatten().flatten().find(|entry| entry.file_name() == name);
        let own = own.filter(|entry| entry.file_type().is_ok_and(|kind| !kind.is_symlink()));
        place =
            own.ok_or_else(|| Refusal::missing(format!("{relative}: the data set does not hold this file")))?.path();
    }
    Ok(place)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_own_files_are_found() {
        let root = tempfile::tempdir().unwrap();
        let set = root.path().join("set");
        fs::create_dir_all(set.join("a ü'<b>")).unwrap();
        fs::write(set.join("a ü'<b>").join("x.png"), "x").unwrap();
        fs::write(root.path().join("secret"), "x").unwrap();
        assert!(inside(&set, "a ü'<b>/x.png").unwrap().is_file());
        for wrong in ["../secret", "a ü'<b>/../../secret", "/etc/passwd", "a/x.png", "gone"] {
            assert!(inside(&set, wrong).is_err(), "{wrong}");
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(root.path().join("secret"), set.join("link")).unwrap();
            assert!(inside(&set, "link").is_err());
        }
    }
}
