//! Messages of SQLite files, as rosbag2 writes them: the tables `topics` and `messages`.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use rusqlite::{Connection, Error};

use super::super::{Channels, Format};
use super::{Bag, Message};
use crate::misread::Misread;

const MAGIC: &[u8] = b"SQLite format 3\0";
/// Bytes 18 and 19 are 2 if there is a write-ahead log beside the file: SQLite's file format, 1.3.
const JOURNAL: std::ops::Range<usize> = 18..20;
/// Minimum number of bytes of a message in a file: a row and its stamp.
const LEAST_MESSAGE: usize = 8;

/// Bags in SQLite files.
pub(in super::super) struct Db3;

impl Format for Db3 {
    fn name(&self) -> &'static str {
        "bag of ROS 2 (SQLite)"
    }

    fn recognises(&self, bytes: &[u8]) -> bool {
        bytes.starts_with(MAGIC)
    }

    fn read(&self, file: &Path, bytes: &[u8]) -> Result<Channels, Misread> {
        let mut bag = Bag::new(file);
        let refused = |error: Error| Bag::new(file).bad(error.to_string());
        let base = open(bytes).map_err(refused)?;
        check_tables(&bag, &base)?;
        if bytes.get(JOURNAL).is_some_and(|journal| journal.contains(&2)) {
            bag.notes.push("what lies in a -wal file beside it is not read".to_owned());
        }
        let topics = topics(&base).map_err(refused)?;
        topics.values().try_for_each(|(topic, kind, format)| bag.check_names(&[topic, kind, format]))?;
        let mut statement = base.prepare("SELECT topic_id, timestamp, data FROM messages").map_err(refused)?;
        let mut rows = statement.query([]).map_err(refused)?;
        let mut left = bytes.len() / LEAST_MESSAGE;
        while let Some(row) = rows.next().map_err(refused)? {
            left = left.checked_sub(1).ok_or_else(|| bag.bad("more messages than the file has bytes"))?;
            let (id, logged): (i64, i64) = (row.get(0).map_err(refused)?, row.get(1).map_err(refused)?);
            let data = row.get_ref(2).map_err(refused)?;
            let data = data.as_blob().map_err(|error| bag.bad(error.to_string()))?;
            let Some((topic, kind, format)) = topics.get(&id) else {
                return Err(bag.bad(format!("a message of the unknown topic {id}")));
            };
            match format.as_str() {
                "cdr" => bag.push(&Message { topic, kind, logged, data })?,
                other => bag.pass_over(topic, &format!("{kind} in {other}"))?,
            }
        }
        bag.finish(self.name())
    }
}

/// Opens the database in memory, read-only.
fn open(bytes: &[u8]) -> Result<Connection, Error> {
    let mut base = Connection::open_in_memory()?;
    let (head, rest) = bytes.split_at(JOURNAL.start.min(bytes.len()));
    let (_, rest) = rest.split_at((JOURNAL.end - JOURNAL.start).min(rest.len()));
    // A database in memory has no log beside it.
    let patched = head.chain(&[1, 1][..]).chain(rest);
    base.deserialize_read_exact("main", patched, bytes.len(), true)?;
    base.execute_batch("PRAGMA trusted_schema = OFF; PRAGMA cell_size_check = ON;")?;
    Ok(base)
}

/// Checks that the tables are plain tables: a view or a computed column could execute arbitrary SQL.
fn check_tables(bag: &Bag, base: &Connection) -> Result<(), Misread> {
    let refused = |error: Error| bag.bad(error.to_string());
    let sql = "SELECT count(*) FROM sqlite_schema WHERE name IN ('topics', 'messages') AND type = 'table' \
               AND rootpage > 0 AND instr(upper(sql), ' AS') = 0";
    let tables: i64 = base.query_row(sql, [], |row| row.get(0)).map_err(refused)?;
    match tables {
        2 => Ok(()),
        _ => Err(bag.bad("no tables topics and messages")),
    }
}

/// Name, type and encoding of each topic.
fn topics(base: &Connection) -> Result<BTreeMap<i64, (String, String, String)>, Error> {
    let mut statement = base.prepare("SELECT id, name, type, serialization_format FROM topics LIMIT 65536")?;
    let rows = statement.query_map([], |row| Ok((row.get(0)?, (row.get(1)?, row.get(2)?, row.get(3)?))))?;
    rows.collect()
}
