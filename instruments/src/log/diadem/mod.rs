//! DIAdem data sets: a text header that names channels, and files of numbers beside it. KUKA's Trace writes its
//! recordings in this form, as `.dat` and `.r64`.
//!
//! Source: National Instruments, "DIAdem Help", "DAT data file format", whose keys [`header`] lists.

mod header;

use std::collections::BTreeMap;
use std::path::Path;

use files::input::{self, MOST_TABLE_BYTES};
use files::named_file;

use self::header::{Channel, Header, Storage};
use super::text::decode;
use super::{Channels, Format, check_size};
use crate::misread::{Misread, Place};

const MAGIC: &[u8] = b"DIAEXTENDED";

/// A DIAdem data set.
pub(super) struct Diadem;

impl Format for Diadem {
    fn name(&self) -> &'static str {
        "DIAdem data set, as of KUKA Trace"
    }

    fn recognises(&self, bytes: &[u8]) -> bool {
        bytes.starts_with(MAGIC)
    }

    fn read(&self, file: &Path, bytes: &[u8]) -> Result<Channels, Misread> {
        let (text, notes) = decode(file, bytes)?;
        let header = Header::read(file, &text)?;
        let mut channels = Channels { format: self.name(), notes, ..Channels::default() };
        let Some(first) = header.channels.first() else {
            return Err(Place::file(file).bad("no channel", "at least one channel is expected"));
        };
        check_size(Place::file(file), header.channels.len(), first.count)?;
        channels.lines = (1..=first.count as u64).collect();
        let mut data = BTreeMap::new();
        for channel in &header.channels {
            if channel.count != first.count {
                let found = format!("a channel of {} values where the first has {}", channel.count, first.count);
                return Err(Place::line(file, channel.line).bad(found, "channels of one length are expected"));
            }
            let values = values(file, &header, channel, &mut data)?;
            channels.push(&channel.name, channel.unit.clone(), values);
        }
        if !data.is_empty() {
            let names: Vec<&str> = data.keys().map(String::as_str).collect();
            channels.notes.push(format!("values are in {} beside it", names.join(", ")));
        }
        Ok(channels)
    }
}

/// Reads the values of a channel; files already read are cached in `data`.
fn values(
    file: &Path,
    header: &Header,
    channel: &Channel,
    data: &mut BTreeMap<String, Vec<u8>>,
) -> Result<Vec<f64>, Misread> {
    let place = || Place::line(file, channel.line);
    let scaled = |value: f64| channel.offset + channel.factor * value;
    let Storage::File { name, number, first, is_block } = &channel.storage else {
        return Ok((0..channel.count).map(|k| scaled(k as f64)).collect());
    };
    if !data.contains_key(name) {
        let folder = file.parent().unwrap_or(Path::new("."));
        let beside = named_file::place(folder, Path::new(name));
        let path = beside.map_err(|_| {
            place().bad::<Misread>("a file of values outside this folder", "a file beside the header is expected")
        })?;
        data.insert(name.clone(), input::read(&path, MOST_TABLE_BYTES)?);
    }
    let bytes = &data[name];
    let all = bytes.len() / number.size();
    // In a block the channels of a file are interleaved.
    let step = if *is_block { header.channels_in(name) } else { 1 };
    let start = first.checked_sub(1);
    let last = start.and_then(|start| channel.count.checked_sub(1)?.checked_mul(step)?.checked_add(start));
    match (start, last) {
        (Some(start), Some(last)) if last < all => {
            let at = |k: usize| number.read(&bytes[(start + k * step) * number.size()..], header.is_big);
            Ok((0..channel.count).map(|k| scaled(at(k))).collect())
        }
        _ => {
            let found = format!("{} values from the {first}. on in a file of {all}", channel.count);
            Err(place().bad(found, "values within the file are expected"))
        }
    }
}
