//! Lists of points: x, y and z on a line, with any separator, with or without a header that may state units.

use files::input::quoted;
use glam::DVec3;

use super::numbers::Numbers;
use super::xyz_layout::Layout;
use super::{Format, Source, Surface, cloud, missing, unit};
use crate::misread::{Misread, Place};

/// Lists of points.
pub(super) struct PointList;

impl Format for PointList {
    fn name(&self) -> &'static str {
        "list of x, y, z"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["xyz", "csv", "txt", "dat", "asc", "pts"]
    }

    fn recognises(&self, source: &Source) -> bool {
        Layout::of(source).is_some()
    }

    fn read(&self, source: &Source) -> Result<Surface, Misread> {
        let layout = Layout::of(source).ok_or_else(|| {
            Place::file(source.file).bad::<Misread>("no lines of x, y and z", "one point on each line is expected")
        })?;
        let mut points = List { points: Vec::new(), numbers: Numbers::new(layout.decimal_comma), nowhere: 0 };
        points.read(source, &layout)?;
        let mut heights: Vec<f64> = points.points.iter().map(|point| point.z).collect();
        let mut notes = points.notes(&layout);
        notes.extend(missing::clear(&mut heights, None));
        let [x, y, z] = layout.units.map(|unit| unit.unwrap_or(1e-3));
        for (point, height) in points.points.iter_mut().zip(heights) {
            *point = DVec3::new(point.x * x, point.y * y, height * z);
        }
        cloud::mapped(self.name(), &points.points, source, notes)
    }
}

/// Points as stored in the file.
struct List {
    points: Vec<DVec3>,
    numbers: Numbers,
    /// Number of points without a position.
    nowhere: usize,
}

impl List {
    /// Reads every line below the header.
    fn read(&mut self, source: &Source, layout: &Layout) -> Result<(), Misread> {
        let text = &source.bytes[layout.start..];
        for (line, row) in (layout.lines_before + 1..).zip(text.split(|&c| c == b'\n')) {
            let row = row.trim_ascii();
            if row.is_empty() || Layout::is_comment(row) {
                continue;
            }
            let point = self.point(row, layout).map_err(|(column, found)| {
                Place::cell(source.file, line, column + 1)
                    .bad::<Misread>(found, "x, y and z are expected, or a word for a missing z")
            })?;
            if point.truncate().is_finite() {
                self.points.push(point);
            } else {
                self.nowhere += 1;
            }
        }
        Ok(())
    }

    /// The point on a line, or the column without a number, from 0.
    fn point(&mut self, row: &[u8], layout: &Layout) -> Result<DVec3, (usize, String)> {
        let mut point = [f64::NAN; 3];
        let (mut found, mut columns) = (0, 0);
        for (column, cell) in layout.cells(row).enumerate() {
            columns = column + 1;
            let Some(axis) = layout.columns.iter().position(|&wanted| wanted == column) else { continue };
            let number = self.numbers.number(cell);
            point[axis] = number
                .ok_or_else(|| (column, format!("{} is not a number", quoted(&String::from_utf8_lossy(cell)))))?;
            found += 1;
        }
        if found < 3 {
            return Err((columns, format!("{columns} cells")));
        }
        Ok(DVec3::from_array(point))
    }

    fn notes(&self, layout: &Layout) -> Vec<String> {
        let mut notes = vec![layout.said()];
        if layout.decimal_comma {
            notes.push("decimals are written with commas".to_owned());
        }
        notes.extend(self.numbers.notes());
        if self.nowhere > 0 {
            notes.push(format!("{} points without x or y are left out", self.nowhere));
        }
        notes
    }
}

impl Layout {
    /// A sentence on the columns and their units.
    fn said(&self) -> String {
        match self.units {
            [None, None, None] => "a list of x, y, z; no unit is stated: mm are assumed".to_owned(),
            units => {
                let [x, y, z] = units.map(|unit| unit.map_or("mm (assumed)", unit::name));
                format!("a list of x in {x}, y in {y}, z in {z}")
            }
        }
    }
}
