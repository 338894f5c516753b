//! An entry of the cache: a field, and the record that verifies it.

use std::fs;
use std::path::PathBuf;

use anyhow::Result;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{Cache, Recipe};
use crate::asset::FileRecord;
use crate::baking::{BakedField, FieldFacts};
use files::folder::write_file;
use files::json_file::read_json;
use files::sha256;

/// Record of a field in the cache.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// The recipe; its compact JSON text, hashed, is the entry's name.
    pub recipe: Value,
    /// Length and hash of the `.nvdb` file.
    pub field: FileRecord,
    /// Properties of the field.
    pub facts: FieldFacts,
}

/// A record as stored in its file, with a hash of itself.
#[derive(Serialize, Deserialize)]
struct Sealed {
    #[serde(flatten)]
    record: Record,
    record_sha256: String,
}

impl Cache {
    /// Returns the path of an entry's field.
    pub fn field_path(&self, key: &str) -> PathBuf {
        self.folder().join(format!("{key}.nvdb"))
    }

    fn record_path(&self, key: &str) -> PathBuf {
        self.folder().join(format!("{key}.json"))
    }

    /// Returns the record of an entry if its field exists, complete and unchanged.
    pub(super) fn find(&self, key: &str) -> Option<Record> {
        let Sealed { record, record_sha256 } = read_json(&self.record_path(key), "a record").ok()?;
        let field = self.field_path(key);
        let unchanged = seal(&record).is_ok_and(|sha256| sha256 == record_sha256)
            // The length is checked first, because it is cheap and detects most damage.
            && fs::metadata(&field).is_ok_and(|file| file.len() == record.field.bytes)
            && FileRecord::of(&field).is_ok_and(|found| found == record.field);
        unchanged.then_some(record)
    }

    /// Stores a field: first the field, then the record that makes it an entry. The caller must hold the claim.
    pub(super) fn keep(&self, recipe: &Recipe, baked: BakedField) -> Result<Record> {
        let key = recipe.key()?;
        let field = FileRecord::of_bytes(&baked.bytes);
        let record = Record { recipe: serde_json::to_value(recipe)?, field, facts: baked.facts };
        let sealed = Sealed { record_sha256: seal(&record)?, record };
        write_file(&self.field_path(&key), &baked.bytes)?;
        let text = serde_json::to_string_pretty(&sealed)? + "\n";
        write_file(&self.record_path(&key), text.as_bytes())?;
        Ok(sealed.record)
    }
}

fn seal(record: &Record) -> serde_json::Result<String> {
    Ok(sha256(serde_json::to_string(record)?.as_bytes()))
}

/// Returns true if the file name belongs to an entry, finished or under construction.
pub(super) fn is_of_an_entry(name: &str) -> bool {
    let key = |name: &str| name.len() == 64 && name.bytes().all(|byte| byte.is_ascii_hexdigit());
    match (name.strip_prefix('.'), name.rsplit_once('.')) {
        (Some(hidden), _) => hidden.split_once('.').is_some_and(|(stem, _)| key(stem)),
        (None, Some((stem, "nvdb" | "json"))) => key(stem),
        _ => false,
    }
}
