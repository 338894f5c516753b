//! Bags of ROS 2: recorded messages of several topics, resampled at the times of one of them.
//!
//! [`mcap`] and [`db3`] find messages in the two kinds of file, [`messages`] decodes those of known types, [`tracks`]
//! collects them and resamples.

mod cdr;
mod db3;
mod mcap;
mod messages;
mod tracks;

pub(super) use db3::Db3;
pub(super) use mcap::Mcap;

use std::collections::BTreeMap;
use std::path::Path;

use self::messages::Kind;
use self::tracks::Tracks;
use super::Channels;
use crate::misread::{Misread, Place};

/// Maximum number of topics of a bag.
const MOST_TOPICS: usize = 4096;

/// Maximum number of bytes of the name of a topic or a type.
const LONGEST_NAME: usize = 1024;

/// One recorded message.
struct Message<'a> {
    topic: &'a str,
    /// Type, as `geometry_msgs/msg/WrenchStamped`.
    kind: &'a str,
    /// Time of recording [ns].
    logged: i64,
    data: &'a [u8],
}

/// State of a bag while it is read.
struct Bag<'a> {
    file: &'a Path,
    tracks: Tracks,
    /// Number of messages of each topic.
    counts: BTreeMap<String, u64>,
    /// Topics that are not read, with their type.
    others: BTreeMap<String, String>,
    notes: Vec<String>,
}

impl<'a> Bag<'a> {
    fn new(file: &'a Path) -> Self {
        let (tracks, counts, others) = (Tracks::default(), BTreeMap::new(), BTreeMap::new());
        Self { file, tracks, counts, others, notes: Vec::new() }
    }

    /// An error for content that no bag has.
    fn bad(&self, found: impl Into<String>) -> Misread {
        Place::file(self.file).bad(found, "a bag of ROS 2 is expected")
    }

    /// Checks the length of names that are stored.
    fn check_names(&self, names: &[&str]) -> Result<(), Misread> {
        match names.iter().any(|name| name.len() > LONGEST_NAME) {
            true => Err(self.bad(format!("a name of more than {LONGEST_NAME} bytes"))),
            false => Ok(()),
        }
    }

    /// Records that a topic is not read.
    fn pass_over(&mut self, topic: &str, held: &str) -> Result<(), Misread> {
        if !self.others.contains_key(topic) {
            if self.others.len() >= MOST_TOPICS {
                return Err(self.bad(format!("more than {MOST_TOPICS} topics")));
            }
            self.others.insert(topic.to_owned(), held.to_owned());
        }
        Ok(())
    }

    fn push(&mut self, message: &Message) -> Result<(), Misread> {
        let Some(kind) = Kind::of(message.kind) else { return self.pass_over(message.topic, message.kind) };
        if self.counts.len() >= MOST_TOPICS && !self.counts.contains_key(message.topic) {
            return Err(self.bad(format!("more than {MOST_TOPICS} topics")));
        }
        // A name is copied only for the first message.
        let number = match self.counts.get_mut(message.topic) {
            Some(count) => {
                *count += 1;
                *count
            }
            None => *self.counts.entry(message.topic.to_owned()).or_insert(1),
        };
        let pushed = kind.decode(message.data).and_then(|samples| {
            samples.into_iter().try_for_each(|sample| self.tracks.push(message.topic, message.logged, sample))
        });
        pushed.map_err(|found| {
            let accepted = format!("a {} in CDR is expected", message.kind);
            Place::file(self.file).bad(format!("message {number} of {}: {found}", message.topic), accepted)
        })
    }

    fn finish(mut self, format: &'static str) -> Result<Channels, Misread> {
        if !self.others.is_empty() {
            let others: Vec<String> =
                self.others.iter().take(20).map(|(topic, kind)| format!("{topic} ({kind})")).collect();
            self.notes.push(format!("{} topics are not read: {}", self.others.len(), others.join(", ")));
        }
        let accepted =
            format!("at least two messages of one of the types {} are expected", messages::names().join(", "));
        let base =
            self.tracks.base().ok_or_else(|| Place::file(self.file).bad::<Misread>("no topic to read", accepted))?;
        let mut channels = Channels { format, notes: self.notes, ..Channels::default() };
        self.tracks.resample(self.file, base, &mut channels)?;
        Ok(channels)
    }
}
