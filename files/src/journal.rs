//! Journal of finished simulations on disk: an interrupted search continues without repeating them.
//!
//! A search is a function of its data, its model and its seed, and almost all of its time goes into simulations. So it
//! is started again, and each simulation that the journal holds is read instead of run. The results have the bytes of
//! an uninterrupted run. An entry consists of its key, its length, the first bytes of its hash, and its content; a
//! truncated entry ends the journal.

use std::collections::HashMap;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use crate::input::{self, InputError};
use sha2::{Digest, Sha256};

/// Bytes of a key.
const KEY: usize = 32;
/// Bytes of the stored length, and of the stored hash of the content.
const WORD: usize = 8;
/// Maximum number of bytes of a journal: a hundred thousand simulations of the eight thousand tiles that eight scans
/// have at most.
const MOST_BYTES: u64 = 8 << 30;

/// Key of an entry.
pub type Key = [u8; KEY];

/// Finished simulations by the hash of their inputs.
pub struct Journal {
    place: PathBuf,
    context: Key,
    kept: Mutex<Kept>,
}

struct Kept {
    entries: HashMap<Key, Vec<u8>>,
    /// `None` until there is something to store.
    file: Option<File>,
}

impl Journal {
    /// Opens or starts a journal; its file and folder are created for the first entry.
    ///
    /// - `context`: everything that determines the simulations besides their keys, such as the measurements and the
    ///   program
    ///
    /// # Errors
    /// If an existing file cannot be read or written.
    pub fn open(file: &Path, context: &str) -> Result<Self, InputError> {
        let failed = |source| InputError::Io { path: file.to_owned(), source };
        let mut kept = Kept { entries: HashMap::new(), file: None };
        if file.exists() {
            let (entries, whole) = entries(&input::read(file, MOST_BYTES)?);
            let opened = appended(file).map_err(failed)?;
            opened.set_len(whole as u64).map_err(failed)?;
            kept = Kept { entries, file: Some(opened) };
        }
        Ok(Self { place: file.to_owned(), context: Sha256::digest(context).into(), kept: Mutex::new(kept) })
    }

    /// Number of stored simulations.
    pub fn len(&self) -> usize {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).entries.len()
    }

    /// True if it holds no entry.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The key of a result that is determined by these texts.
    pub fn key(&self, texts: &[&str]) -> Key {
        let mut hash = Sha256::new_with_prefix(self.context);
        for text in texts {
            hash.update((text.len() as u64).to_le_bytes());
            hash.update(text);
        }
        hash.finalize().into()
    }

    /// The bytes stored under a key.
    pub fn find(&self, key: &Key) -> Option<Vec<u8>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner).entries.get(key).cloned()
    }

    /// Stores an entry. If the disk is full, nothing is stored from then on, and the search continues.
    pub fn keep(&self, key: Key, content: &[u8]) {
        let length = (content.len() as u64).to_le_bytes();
        let entry = [&key[..], &length, &Sha256::digest(content)[..WORD], content].concat();
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.entries.contains_key(&key) {
            return;
        }
        if kept.file.is_none() {
            kept.file = begun(&self.place).ok();
        }
        // A failed write leaves a truncated entry, which the next run drops with everything after it.
        let _: Option<io::Result<()>> = kept.file.as_mut().map(|file| file.write_all(&entry));
        kept.entries.insert(key, content.to_owned());
    }
}

/// Creates a file to append to, and the folder around it.
fn begun(file: &Path) -> io::Result<File> {
    file.parent().map_or(Ok(()), fs::create_dir_all)?;
    appended(file)
}

fn appended(file: &Path) -> io::Result<File> {
    File::options().create(true).append(true).open(file)
}

/// The entries of a journal, and their total length in bytes.
fn entries(bytes: &[u8]) -> (HashMap<Key, Vec<u8>>, usize) {
    let mut entries = HashMap::new();
    let mut at = 0;
    while let Some((key, content)) = entry(&bytes[at..]) {
        at += KEY + 2 * WORD + content.len();
        entries.insert(key, content.to_owned());
    }
    (entries, at)
}

fn entry(bytes: &[u8]) -> Option<(Key, &[u8])> {
    let (key, rest) = bytes.split_first_chunk::<KEY>()?;
    let (length, rest) = rest.split_first_chunk::<WORD>()?;
    let (hash, rest) = rest.split_first_chunk::<WORD>()?;
    let content = rest.get(..usize::try_from(u64::from_le_bytes(*length)).ok()?)?;
    (Sha256::digest(content)[..WORD] == hash[..]).then_some((*key, content))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn what_was_kept_is_found_again_up_to_where_it_was_cut() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("simulations.bin");
        let journal = Journal::open(&file, "campaign").unwrap();
        let keys: Vec<Key> = ["a", "b", "c"].iter().map(|text| journal.key(&[text])).collect();
        assert_ne!(journal.key(&["ab", "c"]), journal.key(&["a", "bc"]));
        keys.iter().zip([b"one", b"two", b"six"]).for_each(|(key, content)| journal.keep(*key, content));
        drop(journal);
        let bytes = fs::read(&file).unwrap();
        for (left, found) in [(bytes.len(), 3), (bytes.len() - 1, 2), (bytes.len() - 60, 1), (10, 0)] {
            fs::write(&file, &bytes[..left]).unwrap();
            let journal = Journal::open(&file, "campaign").unwrap();
            assert_eq!(journal.len(), found, "{left} bytes");
            assert_eq!(journal.find(&keys[0]).as_deref(), (found > 0).then_some(&b"one"[..]));
            journal.keep(keys[2], b"six");
            drop(journal);
            assert_eq!(Journal::open(&file, "campaign").unwrap().find(&keys[2]).as_deref(), Some(&b"six"[..]));
        }
        let mut damaged = bytes.clone();
        *damaged.last_mut().unwrap() ^= 1;
        fs::write(&file, damaged).unwrap();
        assert_eq!(Journal::open(&file, "campaign").unwrap().len(), 2);
        let other = Journal::open(&file, "another campaign").unwrap();
        assert_ne!(other.key(&["a"]), keys[0], "nothing of one campaign serves another");
    }
}
