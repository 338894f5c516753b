//! Messages of MCAP files. Chunks are decompressed here, by LZ4 and Zstandard decoders written in Rust.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;

use mcap::McapError;
use mcap::read::{LinearReader, Options};
use mcap::records::{ChunkHeader, MessageHeader, Record};

use super::super::{Channels, Format};
use super::{Bag, Message};
use crate::misread::{Misread, Place};

/// Maximum number of bytes of a decompressed chunk; writers make chunks of about 1 MiB.
const MOST_IN_A_CHUNK: u64 = 1 << 28;
/// Maximum number of bytes of all decompressed chunks.
const MOST_UNPACKED: u64 = 1 << 33;

/// Bags in MCAP files.
pub(in super::super) struct Mcap;

impl Format for Mcap {
    fn name(&self) -> &'static str {
        "bag of ROS 2 (MCAP)"
    }

    fn recognises(&self, bytes: &[u8]) -> bool {
        bytes.starts_with(mcap::MAGIC)
    }

    fn read(&self, file: &Path, bytes: &[u8]) -> Result<Channels, Misread> {
        let mut reading =
            Reading { bag: Bag::new(file), schemas: BTreeMap::new(), topics: BTreeMap::new(), unpacked: 0 };
        let records = LinearReader::new_with_options(bytes, Options::IgnoreEndMagic.into());
        for record in records.map_err(|error| reading.bag.bad(error.to_string()))? {
            match record {
                Ok(Record::DataEnd(_) | Record::Footer(_)) => break,
                Ok(Record::Chunk { header, data }) => reading.chunk(&header, &data)?,
                Ok(record) => reading.record(record)?,
                // An unfinished recording is read as far as possible.
                Err(McapError::UnexpectedEof) => {
                    reading.bag.notes.push("the file ends within a record: the complete records are read".to_owned());
                    break;
                }
                Err(error) => return Err(reading.bag.bad(error.to_string())),
            }
        }
        reading.bag.finish(self.name())
    }
}

/// State of a file while its records are read.
struct Reading<'a> {
    bag: Bag<'a>,
    /// Names of message types.
    schemas: BTreeMap<u16, String>,
    /// Topic, schema and encoding.
    topics: BTreeMap<u16, (String, u16, String)>,
    unpacked: u64,
}

impl Reading<'_> {
    fn record(&mut self, record: Record) -> Result<(), Misread> {
        match record {
            Record::Schema { header, .. } => {
                self.bag.check_names(&[&header.name])?;
                self.schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                self.bag.check_names(&[&channel.topic, &channel.message_encoding])?;
                let known = (channel.topic, channel.schema_id, channel.message_encoding);
                self.topics.insert(channel.id, known);
            }
            Record::Message { header, data } => return self.message(&header, &data),
            _ => {}
        }
        Ok(())
    }

    fn message(&mut self, header: &MessageHeader, data: &[u8]) -> Result<(), Misread> {
        let Some((topic, schema, encoding)) = self.topics.get(&header.channel_id) else {
            return Err(self.bag.bad(format!("a message of the unknown channel {}", header.channel_id)));
        };
        let kind = self.schemas.get(schema).map_or("", String::as_str);
        if encoding != "cdr" {
            return self.bag.pass_over(topic, &format!("{kind} in {encoding}"));
        }
        let logged = i64::try_from(header.log_time).unwrap_or(i64::MAX);
        self.bag.push(&Message { topic, kind, logged, data })
    }

    fn chunk(&mut self, header: &ChunkHeader, data: &[u8]) -> Result<(), Misread> {
        let size = header.uncompressed_size;
        self.unpacked = self.unpacked.saturating_add(size);
        if size > MOST_IN_A_CHUNK || self.unpacked > MOST_UNPACKED {
            let found = format!("a chunk of {size} bytes, {} bytes in all", self.unpacked);
            let accepted =
                format!("at most {MOST_IN_A_CHUNK} bytes in a chunk and {MOST_UNPACKED} in all are accepted");
            return Err(Place::file(self.bag.file).bad(found, accepted));
        }
        let unpacked = match header.compression.as_str() {
            "" => data.to_vec(),
            "lz4" => self.unpack("LZ4", lz4_flex::frame::FrameDecoder::new(data), size)?,
            "zstd" => {
                let decoder = ruzstd::decoding::StreamingDecoder::new(data);
                self.unpack("Zstandard", decoder.map_err(|error| self.bag.bad(error.to_string()))?, size)?
            }
            other => {
                let found = format!("a chunk packed with {}", files::input::quoted(other));
                return Err(Place::file(self.bag.file).bad(found, "lz4, zstd or no packing is accepted"));
            }
        };
        if header.uncompressed_crc != 0 && crc32fast::hash(&unpacked) != header.uncompressed_crc {
            return Err(self.bag.bad("a chunk whose checksum differs"));
        }
        for record in LinearReader::sans_magic(&unpacked) {
            self.record(record.map_err(|error| self.bag.bad(error.to_string()))?)?;
        }
        Ok(())
    }

    /// Decompresses a chunk to its stated number of bytes.
    fn unpack(&self, method: &str, packed: impl Read, size: u64) -> Result<Vec<u8>, Misread> {
        let mut unpacked = Vec::new();
        let done = packed.take(size + 1).read_to_end(&mut unpacked);
        done.map_err(|error| self.bag.bad(format!("a chunk that is not valid {method}: {error}")))?;
        match unpacked.len() as u64 == size {
            true => Ok(unpacked),
            false => Err(self.bag.bad(format!("a chunk whose length differs from its stated {size} bytes"))),
        }
    }
}
