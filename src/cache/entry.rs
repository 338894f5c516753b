//! An entry: a field and the record that vouches for it.

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

/// What the cache knows of a field.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// The recipe; its compact JSON text, hashed, is the entry's name.
    pub recipe: Value,
    /// Length and hash of the `.nvdb` file.
    pub field: FileRecord,
    /// Measures of the field.
    pub facts: FieldFacts,
}

/// A record as it lies in its file, with a hash of itself.
#[derive(Serialize, Deserialize)]
struct Sealed {
    #[serde(flatten)]
    record: Record,
    record_sha256: String,
}

impl Cache {
    /// Path of an entry's field.
    pub fn field_path(&self, key: &str) -> PathBuf {
        self.folder().join(format!("{key}.nvdb"))
    }

    fn record_path(&self, key: &str) -> PathBuf {
        self.folder().join(format!("{key}.json"))
    }

    /// The record of an entry whose field is there, whole and unchanged.
    pub(super) fn find(&self, key: &str) -> Option<Record> {
        let Sealed { record, record_sha256 } = read_json(&self.record_path(key), "a record").ok()?;
        let field = self.field_path(key);
        let unchanged = seal(&record).is_ok_and(|sha256| sha256 == record_sha256)
            // The length costs nothing, and tells most damage before the whole file is read.
            && fs::metadata(&field).is_ok_and(|file| file.len() == record.field.bytes)
            && FileRecord::of(&field).is_ok_and(|found| found == record.field);
        unchanged.then_some(record)
    }

    /// Keeps a field: first the field, then the record that makes it an entry. For who holds the claim on it.
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

/// Whether a file name is one that an entry uses, finished or in the making.
pub(super) fn is_of_an_entry(name: &str) -> bool {
    let key = |name: &str| name.len() == 64 && name.bytes().all(|byte| byte.is_ascii_hexdigit());
    match (name.strip_prefix('.'), name.rsplit_once('.')) {
        (Some(hidden), _) => hidden.split_once('.').is_some_and(|(stem, _)| key(stem)),
        (None, Some((stem, "nvdb" | "json"))) => key(stem),
        _ => false,
    }
}
