//! Position and unit of each quantity in the CSV.

use effects::Dimension;

use super::Removed;
use super::manifest::{Column, Manifest};
use crate::column_unit::ColumnUnit;
use instruments::text_table::TextRow;

use crate::trial::{TrialError, nearest};
use files::input::{quoted_names, quoted_near};

const LENGTH: Dimension = Dimension::whole([0, 1, 0, 0]);
const VOLUME: Dimension = Dimension::whole([0, 3, 0, 0]);
const MASS: Dimension = Dimension::whole([1, 0, 0, 0]);
const TIME: Dimension = Dimension::whole([0, 0, 1, 0]);
const SPEED: Dimension = Dimension::whole([0, 1, -1, 0]);
const TURNS: Dimension = Dimension::whole([0, 0, -1, 0]);
const FORCE: Dimension = Dimension::whole([1, 1, -2, 0]);
const PRESSURE: Dimension = Dimension::whole([1, -1, -2, 0]);

/// A column of numbers.
#[derive(Clone, Debug)]
pub(super) struct Numbers {
    /// Key of the quantity.
    pub(super) key: String,
    /// Name in the header.
    pub(super) name: String,
    /// Column index.
    pub(super) at: usize,
    /// Its unit.
    pub(super) unit: ColumnUnit,
    /// The unit as the file writes it.
    pub(super) unit_text: String,
}

/// Kind of load that the table gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Load {
    Force,
    Pressure,
}

/// Quantity from which the sliding speed follows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Motion {
    Speed,
    Spindle,
}

/// Statement of the manifest about the order of the file, instead of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ordering {
    /// The order is that of time.
    File,
    /// The order is unrelated to time.
    None,
}

impl Ordering {
    /// The ordering with this name, unless a column has that name.
    fn of(name: &str, columns: &[String]) -> Option<Self> {
        let known = [("file", Self::File), ("none", Self::None)].into_iter().find(|(word, _)| *word == name);
        known.filter(|(word, _)| columns.iter().all(|column| column != word)).map(|(_, ordering)| ordering)
    }
}

/// All columns of a table.
pub(super) struct Columns {
    /// Number of cells of a complete row.
    pub(super) count: usize,
    pub(super) load: (Load, Numbers),
    pub(super) motion: Option<(Motion, Numbers)>,
    pub(super) duration: Option<Numbers>,
    pub(super) removed: Numbers,
    /// Kind of removal, and true if it is given per time.
    pub(super) removal: (Removed, bool),
    /// Factor from the removal in its SI unit to a depth or volume.
    pub(super) per_mass: f64,
    pub(super) usage: Vec<Numbers>,
    pub(super) order: Option<usize>,
    pub(super) ordering: Option<Ordering>,
    pub(super) group: Option<usize>,
    pub(super) role: Option<usize>,
    pub(super) tool: Option<usize>,
    pub(super) fresh: Option<usize>,
    /// Columns that the manifest does not mention.
    pub(super) others: Vec<(usize, String)>,
}

/// Search for the manifest's names in the header.
struct Search<'a> {
    manifest: &'a Manifest,
    names: Vec<String>,
    header: String,
}

impl Columns {
    pub(super) fn find(manifest: &Manifest, header: &TextRow) -> Result<Self, TrialError> {
        let names: Vec<String> = (0..header.len()).map(|k| header.text(k).trim_matches('"').to_owned()).collect();
        let header = quoted_names(&names, []);
        let search = Search { manifest, header, names };
        let order = manifest.order.as_ref().filter(|name| Ordering::of(name.get_ref(), &search.names).is_none());
        let order = order.map(|name| search.place("order", name.get_ref(), name.span().start));
        let ordering = manifest.order.as_ref().and_then(|name| Ordering::of(name.get_ref(), &search.names));
        let text = |key: &str| manifest.column(key).map(|column| search.column(column)).transpose();
        let duration = search.numbers("duration", &[("s", TIME)])?;
        let (removed, removal, per_mass) = search.removed(duration.is_some())?;
        let usage = manifest.columns.iter().filter(|column| column.is_usage());
        let usage = usage.map(|column| {
            let unit = *column.unit.as_ref().expect("a column of numbers has a unit").get_ref();
            let name = column.name.get_ref().clone();
            let (key, unit_text) = (column.key.clone(), column.unit_text.clone());
            Ok(Numbers { key, name, at: search.column(column)?, unit, unit_text })
        });
        let mut columns = Self {
            count: search.names.len(),
            load: search.load()?,
            motion: search.motion()?,
            duration,
            removed,
            removal,
            per_mass,
            usage: usage.collect::<Result<_, TrialError>>()?,
            order: order.transpose()?,
            ordering,
            group: text("group")?,
            role: text("role")?,
            tool: text("tool")?,
            fresh: text("fresh")?,
            others: Vec::new(),
        };
        let named = columns.named();
        let others = search.names.into_iter().enumerate().filter(|(at, _)| !named.contains(at));
        columns.others = others.collect();
        Ok(columns)
    }

    /// Numerical columns that every usable row needs.
    pub(super) fn settings(&self) -> impl Iterator<Item = &Numbers> {
        let motion = self.motion.as_ref().map(|(_, numbers)| numbers);
        std::iter::once(&self.load.1).chain(motion).chain(&self.duration).chain(&self.usage)
    }

    fn named(&self) -> Vec<usize> {
        let texts = [self.order, self.group, self.role, self.tool, self.fresh].into_iter().flatten();
        self.settings().map(|numbers| numbers.at).chain([self.removed.at]).chain(texts).collect()
    }
}

impl Search<'_> {
    fn column(&self, column: &Column) -> Result<usize, TrialError> {
        self.place(&column.key, column.name.get_ref(), column.name.span().start)
    }

    /// Index of a column by its name.
    fn place(&self, key: &str, name: &str, at: usize) -> Result<usize, TrialError> {
        let exact: Vec<usize> = (0..self.names.len()).filter(|&k| self.names[k] == name.trim()).collect();
        let alike = || (0..self.names.len()).filter(|&k| self.names[k].eq_ignore_ascii_case(name.trim())).collect();
        let places: Vec<usize> = if exact.is_empty() { alike() } else { exact };
        let shown = quoted_near(name, self.names.iter().map(String::as_str));
        let found = match places[..] {
            [place] => return Ok(place),
            [] => format!("no column {shown} for {key} in the CSV"),
            _ => format!("{} columns {shown} for {key} in the CSV", places.len()),
        };
        let near = nearest(name, self.names.iter().map(String::as_str));
        let hint = near.map_or(String::new(), |near| format!("did you mean {near:?}? "));
        Err(self.manifest.source.bad(at..at, found, format!("{hint}Its header is {}", self.header)))
    }

    fn numbers(&self, key: &str, wanted: &[(&str, Dimension)]) -> Result<Option<Numbers>, TrialError> {
        let Some(column) = self.manifest.column(key) else { return Ok(None) };
        let unit = column.expect(&self.manifest.source, wanted)?;
        let name = column.name.get_ref().clone();
        let unit_text = column.unit_text.clone();
        Ok(Some(Numbers { key: key.to_owned(), name, at: self.column(column)?, unit, unit_text }))
    }

    fn missing(&self, found: &str, accepted: &str) -> TrialError {
        self.manifest.source.bad(self.manifest.columns_at.clone(), format!("no {found} in [columns]"), accepted)
    }

    fn load(&self) -> Result<(Load, Numbers), TrialError> {
        let force = self.numbers("force", &[("N", FORCE)])?;
        let pressure = self.numbers("pressure", &[("kPa", PRESSURE)])?;
        match (force, pressure) {
            (Some(force), None) => Ok((Load::Force, force)),
            (None, Some(pressure)) => Ok((Load::Pressure, pressure)),
            (None, None) => Err(self.missing("force and no pressure", "one of them is expected")),
            (Some(_), Some(_)) => Err(self.missing("choice between force and pressure", "one of them is expected")),
        }
    }

    fn motion(&self) -> Result<Option<(Motion, Numbers)>, TrialError> {
        if let Some(speed) = self.numbers("speed", &[("m/s", SPEED)])? {
            return Ok(Some((Motion::Speed, speed)));
        }
        let Some(spindle) = self.numbers("spindle_rpm", &[("rpm", TURNS)])? else { return Ok(None) };
        if self.manifest.radius.is_none() {
            return Err(self.missing("radius for spindle_rpm", "radius_mm = ... is expected beside it"));
        }
        Ok(Some((Motion::Spindle, spindle)))
    }

    /// Column of the removal, its kind, and the factor from a mass to a volume.
    fn removed(&self, has_duration: bool) -> Result<(Numbers, (Removed, bool), f64), TrialError> {
        let wanted = [
            ("mm", LENGTH),
            ("mm^3", VOLUME),
            ("g", MASS),
            ("um/s", LENGTH / TIME),
            ("mm^3/s", VOLUME / TIME),
            ("g/min", MASS / TIME),
        ];
        let numbers = self
            .numbers("removed", &wanted)?
            .ok_or_else(|| self.missing("removed", "the column of removed depth, volume or mass is expected"))?;
        let dimension = numbers.unit.dimension();
        let per_time = [LENGTH / TIME, VOLUME / TIME, MASS / TIME].contains(&dimension);
        if !per_time && !has_duration {
            return Err(self.missing("duration", "it is needed unless removed is a rate"));
        }
        let what = if per_time { dimension * TIME } else { dimension };
        if what != MASS {
            return Ok((numbers, (if what == LENGTH { Removed::Depth } else { Removed::Volume }, per_time), 1.0));
        }
        let density = self.manifest.density.ok_or_else(|| {
            self.missing("density for a removed mass", "density_kg_m3 = ... is expected beside the column of removed")
        })?;
        Ok((numbers, (Removed::Volume, per_time), 1.0 / density))
    }
}
