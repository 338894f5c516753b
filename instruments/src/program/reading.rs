//! A program while it is read: its points so far and what is noted.

use std::path::Path;

use glam::DVec3;

use super::{Point, Program, Source};
use crate::misread::{Misread, Place};

/// Points that a path may have.
const MOST_POINTS: usize = 10_000_000;
/// Farthest place of a point [m].
const FARTHEST: f64 = 1e4;
/// Passed-over lines of one kind whose numbers are listed.
const LISTED: usize = 5;
/// Kinds of passed-over lines that are noted.
const NOTED: usize = 40;

/// Characters of a name that is shown.
const NAME: usize = 32;

/// A name of a program that is known to be one; of anything else as much as an error may repeat.
pub(super) fn shown_name(name: &str) -> String {
    let is_part = |c: char| c.is_ascii_alphanumeric() || "_$.= ()[]\\".contains(c);
    if name.len() <= NAME && name.chars().all(is_part) { format!("`{name}`") } else { files::input::quoted(name) }
}

/// The points so far.
pub(super) struct Reading<'a> {
    pub(super) file: &'a Path,
    pub(super) program: Program,
    /// Things that were passed over, and in which lines.
    passed: Vec<(String, Vec<u64>)>,
}

impl<'a> Reading<'a> {
    pub(super) fn new(source: &Source<'a>, format: &'static str) -> Self {
        Self { file: source.file, program: Program { format, ..Program::default() }, passed: Vec::new() }
    }

    /// The error that something else was expected in a line.
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

    /// Number of points that may still come.
    pub(super) fn left(&self) -> usize {
        MOST_POINTS - self.program.points.len()
    }

    /// Notes that something was passed over in a line.
    pub(super) fn pass(&mut self, what: impl Into<String>, line: u64) {
        let what = what.into();
        match self.passed.iter().position(|(other, _)| *other == what) {
            Some(known) => self.passed[known].1.push(line),
            // Lines that all differ are not worth a note each.
            None if self.passed.len() >= NOTED => {}
            None => self.passed.push((what, vec![line])),
        }
    }

    /// The program, if it has a point.
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
