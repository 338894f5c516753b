//! Recordings of each topic, and their resampling at the times of one.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use super::super::{Channels, MOST_CHANNELS, MOST_VALUES, check_size};
use super::messages::{Field, Sample};
use crate::misread::{Misread, Place};

/// Difference between stamps and the bag's clock above which a note is added [ns].
const CLOCKS_DIFFER: i64 = 1_000_000_000;

/// Tracks by name: a topic, or a topic and the child frame of a transform.
#[derive(Default)]
pub(super) struct Tracks {
    tracks: BTreeMap<String, Track>,
    fields: usize,
    values: usize,
}

/// Samples of one track.
#[derive(Default)]
struct Track {
    is_pose: bool,
    names: Vec<String>,
    /// Index of each name.
    index: HashMap<String, usize>,
    units: Vec<Option<&'static str>>,
    /// Time of each sample [ns].
    times: Vec<i64>,
    /// One list for each name, each as long as `times`.
    values: Vec<Vec<f64>>,
    /// Difference between the first stamp and the bag's clock [ns], if the messages have stamps.
    stamped: Option<i64>,
}

impl Tracks {
    /// Adds a sample; the error describes its fault.
    pub(super) fn push(&mut self, topic: &str, logged: i64, sample: Sample) -> Result<(), String> {
        let name = format!("{topic}{}", sample.suffix);
        self.values += sample.fields.len().max(1);
        if self.values > MOST_VALUES {
            return Err(format!("more than {MOST_VALUES} values"));
        }
        let track = self.tracks.entry(name).or_default();
        self.fields -= track.names.len();
        track.push(logged, sample)?;
        self.fields += track.names.len();
        match self.fields > MOST_CHANNELS || self.tracks.len() > MOST_CHANNELS {
            true => Err(format!("more than {MOST_CHANNELS} channels")),
            false => Ok(()),
        }
    }

    /// The track at whose times the others are resampled: the pose with the most samples, otherwise the track with the
    /// most.
    pub(super) fn base(&self) -> Option<String> {
        let rank = |track: &Track| (track.is_pose, track.times.len());
        let usable = self.tracks.iter().filter(|(_, track)| track.times.len() >= 2 && !track.names.is_empty());
        // Of equally long ones, the first by name.
        let best = usable.reduce(|best, next| if rank(next.1) > rank(best.1) { next } else { best });
        best.map(|(name, _)| name.clone())
    }

    /// Resamples all tracks at the times of the track `base`.
    pub(super) fn resample(mut self, file: &Path, base: String, channels: &mut Channels) -> Result<(), Misread> {
        let Some(track) = self.tracks.remove(&base) else { return Ok(()) };
        let order = track.order();
        let times: Vec<i64> = order.iter().map(|&k| track.times[k]).collect();
        check_size(Place::file(file), self.fields + 1, times.len())?;
        let start = times.first().copied().unwrap_or_default();
        channels.lines = order.iter().map(|&k| k as u64 + 1).collect();
        channels.push("time", Some("s".to_owned()), times.iter().map(|&time| seconds(time, start)).collect());
        let seconds_since_1970 = start as f64 * 1e-9;
        channels
            .notes
            .push(format!("time counts from the first row, {seconds_since_1970:.3} s of the recording's clock"));
        channels.notes.push(match track.is_pose {
            true => format!("all topics are resampled linearly on the times of {base}, the densest pose"),
            false => format!("no topic is a pose: all are resampled linearly on the times of {base}, the densest"),
        });
        if order.len() < track.times.len() {
            let repeated = track.times.len() - order.len();
            channels.notes.push(format!("{repeated} messages of {base} repeat a time and are left out"));
        }
        track.note_clock(&base, channels);
        track.add_to(channels, &base, &times);
        for (name, track) in &self.tracks {
            if track.times.len() < 2 {
                channels.notes.push(format!("{name} has a single message and is left out"));
                continue;
            }
            track.note_clock(name, channels);
            track.add_to(channels, name, &times);
        }
        Ok(())
    }
}

/// Time since a start [s], exact for short durations.
fn seconds(time: i64, start: i64) -> f64 {
    (i128::from(time) - i128::from(start)) as f64 / 1e9
}

impl Track {
    fn push(&mut self, logged: i64, sample: Sample) -> Result<(), String> {
        let is_first = self.times.is_empty();
        if is_first {
            self.stamped = sample.stamp.map(|stamp| stamp.saturating_sub(logged));
            self.is_pose = sample.is_pose;
        }
        let row = self.times.len();
        self.times.push(if self.stamped.is_some() { sample.stamp.unwrap_or(logged) } else { logged });
        for (k, field) in sample.fields.into_iter().enumerate() {
            let column = self.column(k, &field, row)?;
            self.values[column].resize(row, f64::NAN);
            self.values[column].push(field.value);
        }
        Ok(())
    }

    /// Index of a field's column, usually `k`.
    fn column(&mut self, k: usize, field: &Field, row: usize) -> Result<usize, String> {
        let is_free = |column: usize, values: &[Vec<f64>]| values[column].len() <= row;
        let is_usual = self.names.get(k).is_some_and(|name| *name == field.name);
        let found = if is_usual { Some(k) } else { self.index.get(&*field.name).copied() };
        match found {
            Some(column) if is_free(column, &self.values) => Ok(column),
            Some(_) => Err(format!("{} twice", files::input::quoted(&field.name))),
            None if self.names.len() >= MOST_CHANNELS => Err(format!("more than {MOST_CHANNELS} fields")),
            None => {
                self.index.insert(field.name.to_string(), self.names.len());
                self.names.push(field.name.to_string());
                self.units.push(field.unit);
                self.values.push(Vec::new());
                Ok(self.names.len() - 1)
            }
        }
    }

    /// Indices of the samples in the order of time; of samples with equal times only the first.
    fn order(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.times.len()).collect();
        order.sort_by_key(|&k| self.times[k]);
        order.dedup_by_key(|k| self.times[*k]);
        order
    }

    fn note_clock(&self, name: &str, channels: &mut Channels) {
        match self.stamped {
            Some(offset) if offset.saturating_abs() > CLOCKS_DIFFER => channels.notes.push(format!(
                "the stamps of {name} are {:.3} s off the clock of the recording; they are used",
                offset as f64 / 1e9
            )),
            Some(_) => {}
            None => channels.notes.push(format!("{name} has no stamps: the times of the recording are used")),
        }
    }

    /// Adds its fields, resampled at the given times.
    fn add_to(&self, channels: &mut Channels, name: &str, times: &[i64]) {
        let order = self.order();
        let own: Vec<i64> = order.iter().map(|&k| self.times[k]).collect();
        for ((field, unit), values) in self.names.iter().zip(&self.units).zip(&self.values) {
            let at = |k: usize| order.get(k).and_then(|&k| values.get(k)).copied().unwrap_or(f64::NAN);
            let mut next = 0;
            let values = times.iter().map(|&time| {
                while own.get(next).is_some_and(|own| *own < time) {
                    next += 1;
                }
                match own.get(next) {
                    Some(own) if *own == time => at(next),
                    Some(_) if next > 0 => between((own[next - 1], at(next - 1)), (own[next], at(next)), time),
                    _ => f64::NAN,
                }
            });
            channels.push(&format!("{name}/{field}"), unit.map(str::to_owned), values.collect());
        }
    }
}

/// The interpolated value at a time between two samples.
fn between(before: (i64, f64), after: (i64, f64), time: i64) -> f64 {
    let share = seconds(time, before.0) / seconds(after.0, before.0);
    before.1 + share * (after.1 - before.1)
}
