//! State of a program while it is read: its points and notes so far.

use std::path::Path;

use glam::DVec3;

use super::{Point, Program, Source};
use crate::misread::{Misread, Place};

/// Maximum number of points of a path.
const MOST_POINTS: usize = 10_000_000;
/// Largest coordinate of a point [m].
const FARTHEST: f64 = 1e4;
/// Maximum number of line numbers that a note on skipped lines lists.
const LISTED: usize = 5;
/// Maximum number of kinds of skipped lines with a note.
const NOTED: usize = 40;

/// Maximum number of characters of a displayed name.
const NAME: usize = 32;

/// A valid name from a program, shortened for display; of anything else as much as an error may repeat.
pub(super) fn shown_name(name: &str) -> String {
    let is_part = |c: char| c.is_ascii_alphanumeric() || "_$.= ()[]\\".contains(c);
    if name.len() <= NAME && name.chars().all(is_part) { format!("`{name}`") } else { files::input::quoted(name) }
}

/// The points so far.
pub(super) struct Reading<'a> {
    pub(super) file: &'a Path,
    pub(super) program: Program,
    /// Kinds of skipped lines, with their line numbers.
    passed: Vec<(String, Vec<u64>)>,
}

impl<'a> Reading<'a> {
    pub(super) fn new(source: &Source<'a>, format: &'static str) -> Self {
        Self { file: source.file, program: Program { format, ..Program::default() }, passed: Vec::new() }
    }

    /// An error in a line: the content found and the content accepted.
    pub(super) fn bad<T>(&self, line: u64, found: impl Into<String>, accepted: &str) -> Result<T, Misread> {
        Err(Place::line(self.file, line).bad(found, accepted))
    }

    /// Adds a point.
    pub(super) fn push(&mut self, point: Point) -> Result<(), Misread> {
        let DVec3 { x, y, z } = point.position;
        if !point.position.is_finite() || point.position.abs().max_element() > FARTHEST {
            return self.bad(point.line, format!("a point at {x} m, {y} m, {z} m"), "points within 10 km are expected");
        }
        if point.feed.is_some_and(|feed| !(feed > 0.0 && feed.is_finite())) {
            return self.bad(point.line, "a speed that is not positive", "a positive speed is expected");
        }
        if self.program.points.len() >= MOST_POINTS {
            return self.bad(point.line, "too many points", &format!("at most {MOST_POINTS} are accepted"));
        }
        self.program.points.push(point);
        Ok(())
    }

    /// Number of points that may still be added.
    pub(super) fn left(&self) -> usize {
        MOST_POINTS - self.program.points.len()
    }

    /// Records that a line was skipped.
    pub(super) fn pass(&mut self, what: impl Into<String>, line: u64) {
        let what = what.into();
        match self.passed.iter().position(|(other, _)| *other == what) {
            Some(known) => self.passed[known].1.push(line),
            // Lines that are all different do not get a note each.
            None if self.passed.len() >= NOTED => {}
            None => self.passed.push((what, vec![line])),
        }
    }

    /// The program, if it has at least one point.
    pub(super) fn finish(mut self) -> Result<Program, Misread> {
        for (what, lines) in &self.passed {
            let shown: Vec<String> = lines.iter().take(LISTED).map(u64::to_string).collect();
            let more = if lines.len() > LISTED { format!(" and {} more", lines.len() - LISTED) } else { String::new() };
            self.program.notes.push(format!("{what} (line {}{more})", shown.join(", ")));
        }
        if self.program.points.is_empty() {
            let what = self.passed.first().map_or(String::new(), |(what, _)| format!(": {what}"));
            return Err(Place::file(self.file)
                .bad(format!("no point of a path{what}"), "at least one move to a Cartesian point is expected"));
        }
        Ok(self.program)
    }
}
