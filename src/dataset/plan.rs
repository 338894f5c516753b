//! Items of a list of parts: names, seeds, order, shards.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use anyhow::Result;
use sdf_bake::read::{MeshBytes, UnitChoice};

use crate::cache::Sources;
use crate::in_full;
use crate::store::number_from;
use files::sha256;

/// Hexadecimal digits of the source's key in an item's name: 64 bits, so that millions of parts have different names.
const KEY_DIGITS: usize = 16;

/// One welded workpiece to make.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Item {
    /// The mesh file.
    pub source: PathBuf,
    /// Name: key of the source's content, and index.
    pub id: String,
    /// Index among the items of the part, from 0.
    pub index: u32,
}

/// A source that cannot be read and thus has no items.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unreadable {
    /// The mesh file.
    pub source: PathBuf,
    /// Reason.
    pub reason: String,
}

/// Items to make, and the sources without items.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Plan {
    /// Items, the first of every part before the second of any part.
    pub items: Vec<Item>,
    /// Readable files, copies included.
    pub readable: Vec<PathBuf>,
    /// Sources that cannot be read.
    pub unreadable: Vec<Unreadable>,
    /// Number of different parts.
    pub parts: usize,
    /// Number of files with the same content as another one; they have no items of their own.
    pub copies: usize,
}

/// A shard of a data set, for several machines.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Number of the shard, from 1.
    pub number: u32,
    /// Number of shards.
    pub of: u32,
}

impl Shard {
    /// The whole data set as one shard.
    pub const WHOLE: Self = Self { number: 1, of: 1 };

    /// Parses `i/n`.
    pub fn parse(text: &str) -> Option<Self> {
        let (number, of) = text.split_once('/')?;
        let shard = Self { number: number.parse().ok()?, of: of.parse().ok()? };
        (1..=shard.of).contains(&shard.number).then_some(shard)
    }

    /// Returns true if an item or source of this name belongs to the shard; it depends on the name, not on the order.
    fn has(self, name: &str) -> bool {
        number_from(&format!("shard {name}")) % u64::from(self.of) == u64::from(self.number - 1)
    }
}

/// Returns the key of a source: a hash of its bytes and, where they have an influence, its format and the unit in its
/// name.
///
/// # Errors
/// If the file cannot be read, or is not a mesh.
pub fn source_key(source: &Path, unit: UnitChoice) -> Result<String> {
    let mesh = MeshBytes::load(source)?;
    let buffers: Vec<String> = mesh.buffers().map(sha256).collect();
    let unit_in_name = mesh.unit_in_name().filter(|_| unit == UnitChoice::Auto);
    let content = (sha256(mesh.bytes()), buffers, mesh.format(), unit_in_name);
    Ok(sha256(serde_json::to_string(&content)?.as_bytes())[..KEY_DIGITS].to_owned())
}

/// Returns the name of an item of a source.
pub fn item_id(key: &str, index: u32) -> String {
    format!("{key}-{index:04}")
}

/// Returns the source's key in an item's name.
pub(super) fn key_of(id: &str) -> &str {
    id.split_once('-').map_or(id, |(key, _)| key)
}

/// Returns the index in an item's name.
pub(super) fn index_of(id: &str) -> Option<u32> {
    id.split_once('-')?.1.parse().ok()
}

impl Plan {
    /// Plans the items with the given indices of each source: at most `limit` of them, and of those the shard's.
    pub fn new(sources: Sources, unit: UnitChoice, indices: std::ops::Range<u32>, limit: usize, shard: Shard) -> Self {
        let mut plan = Self::default();
        let (mut keys, mut known) = (Vec::new(), BTreeSet::new());
        for (source, fault) in sources {
            let key = match fault {
                Some(reason) => Err(reason),
                None => source_key(&source, unit).map_err(|error| in_full(&error)),
            };
            if key.is_ok() {
                plan.readable.push(source.clone());
            }
            match key {
                Ok(key) if known.insert(key.clone()) => keys.push((source, key)),
                Ok(_) => plan.copies += 1,
                Err(reason) => plan.unreadable.push(Unreadable { source, reason }),
            }
        }
        plan.parts = keys.len();
        let item = |index: u32| {
            let item = move |(source, key): &(PathBuf, String)| Item {
                source: source.clone(),
                id: item_id(key, index),
                index,
            };
            keys.iter().map(item)
        };
        plan.items = indices.flat_map(item).take(limit).filter(|item| shard.has(&item.id)).collect();
        plan.unreadable.retain(|unreadable| shard.has(&unreadable.source.to_string_lossy()));
        plan
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::find_meshes;

    fn parts(folder: &Path, names: &[&str]) -> Sources {
        for (number, name) in names.iter().enumerate() {
            let text = format!("v 0 0 0\nv {} 0 0\nv 0 1 0\nf 1 2 3\n", number + 1);
            std::fs::write(folder.join(name), text).unwrap();
        }
        find_meshes(&[folder.to_owned()]).unwrap()
    }

    #[test]
    fn names_follow_from_content_and_index_alone() {
        let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let plan = |sources: Sources, indices| Plan::new(sources, UnitChoice::Auto, indices, usize::MAX, Shard::WHOLE);
        let ids = |plan: &Plan| plan.items.iter().map(|item| item.id.clone()).collect::<BTreeSet<_>>();
        let first = plan(parts(one.path(), &["a.obj", "b.obj", "c.obj"]), 0..4);
        // The same contents under other names, in another order.
        let other = plan(parts(two.path(), &["z.obj", "y.obj", "x.obj"]), 0..4);
        assert_eq!(ids(&first).len(), 12);
        assert_eq!(ids(&first), ids(&other));
        let third = plan(parts(one.path(), &["a.obj", "b.obj", "c.obj"]), 2..3);
        assert_eq!(third.items.len(), 3);
        assert!(ids(&third).is_subset(&ids(&first)));
        std::fs::copy(one.path().join("a.obj"), one.path().join("copy.obj")).unwrap();
        let copied = plan(find_meshes(&[one.path().to_owned()]).unwrap(), 0..4);
        assert_eq!((copied.parts, copied.copies, ids(&copied)), (3, 1, ids(&first)));
    }

    #[test]
    fn the_limit_takes_every_part_before_any_twice_and_shards_share_what_is_left() {
        let place = tempfile::tempdir().unwrap();
        let sources = parts(place.path(), &["a.obj", "b.obj", "c.obj"]);
        let plan = |limit, shard| Plan::new(sources.clone(), UnitChoice::Auto, 0..40, limit, shard).items;
        let limited = plan(7, Shard::WHOLE);
        assert_eq!(limited.iter().map(|item| item.index).collect::<Vec<_>>(), [0, 0, 0, 1, 1, 1, 2]);
        let whole = plan(100, Shard::WHOLE);
        let shards: Vec<Vec<Item>> = (1..=3).map(|number| plan(100, Shard { number, of: 3 })).collect();
        let mut together: Vec<Item> = shards.concat();
        together.sort_by(|a, b| (a.index, &a.source).cmp(&(b.index, &b.source)));
        assert_eq!(together, whole);
        assert!(shards.iter().all(|shard| shard.len() > 15), "{:?}", shards.iter().map(Vec::len).collect::<Vec<_>>());
    }

    #[test]
    fn a_shard_is_two_numbers_in_order() {
        assert_eq!(Shard::parse("2/3"), Some(Shard { number: 2, of: 3 }));
        for nonsense in ["", "1", "0/3", "4/3", "1/0", "a/b", "1/2/3", "-1/2", "1.5/2", " 1/2"] {
            assert_eq!(Shard::parse(nonsense), None, "{nonsense}");
        }
    }
}
