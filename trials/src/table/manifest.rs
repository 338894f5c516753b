//! Contents of `table.toml`.

use std::ops::Range;
use std::path::{Path, PathBuf};

use effects::{Dimension, Process};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::column_unit::{ColumnUnit, quantity};
use crate::trial::{Source, TrialError, nearest};
use files::input::{quoted_near, without_content};

/// Value of the `format` key.
pub const TABLE_FORMAT: &str = "finishing-table/1";
/// Name of the file that makes a folder a table.
pub const TABLE_FILE: &str = "table.toml";

/// Constants with their unit in SI; they are at the top or in the table of the column that they belong to.
const CONSTANTS: [(&str, f64); 4] =
    [("area_mm2", 1e-6), ("radius_mm", 1e-3), ("density_kg_m3", 1.0), ("coating_mm", 1e-3)];
/// Other keys at the top level.
const ROOT: [&str; 7] = ["format", "name", "process", "csv", "order", "noise", "columns"];
/// Columns with text.
const TEXTS: [&str; 4] = ["group", "role", "tool", "fresh"];
/// Columns with numbers; any other key below `columns` is a state that the column measures.
const NUMBERS: [&str; 6] = ["force", "pressure", "speed", "spindle_rpm", "duration", "removed"];
/// Edit distance up to which an unknown key counts as a typing error.
const SLIPS: usize = 1;
/// A constant by its key [SI].
type Constant = (&'static str, f64);

/// One entry below `columns`.
#[derive(Clone, Debug)]
pub(super) struct Column {
    /// Its quantity, such as `force`; `usage` or a user-defined name for states.
    pub(super) key: String,
    /// Name in the CSV.
    pub(super) name: Spanned<String>,
    /// `None` for columns of text.
    pub(super) unit: Option<Spanned<ColumnUnit>>,
    /// The unit as the file writes it, empty for columns of text.
    pub(super) unit_text: String,
}

impl Column {
    /// Returns true if it measures a state.
    pub(super) fn is_usage(&self) -> bool {
        !TEXTS.contains(&self.key.as_str()) && !NUMBERS.contains(&self.key.as_str())
    }
}

/// The whole file.
pub(super) struct Manifest {
    pub(super) source: Source,
    pub(super) name: String,
    pub(super) process: Process,
    /// True if the process is called polishing.
    pub(super) polishes: bool,
    pub(super) csv: Spanned<PathBuf>,
    pub(super) order: Option<Spanned<String>>,
    pub(super) columns: Vec<Column>,
    pub(super) area: Option<f64>,
    pub(super) radius: Option<f64>,
    pub(super) density: Option<f64>,
    pub(super) coating: Option<f64>,
    /// Relative standard deviation of a row's removal, if stated.
    pub(super) noise: Option<f64>,
    /// Byte range of `[columns]`, for errors about missing entries.
    pub(super) columns_at: Range<usize>,
}

/// A table of the TOML file.
struct Section<'a> {
    source: &'a Source,
    /// Its name, empty for the root.
    name: &'a str,
    at: Range<usize>,
    table: &'a DeTable<'a>,
}

impl Manifest {
    pub(super) fn read(folder: &Path) -> Result<Self, TrialError> {
        let source = Source::read(folder.join(TABLE_FILE))?;
        let text = source.text.clone();
        let document = DeTable::parse(&text).map_err(|error| {
            let at = error.span().map_or(0, |span| span.start);
            source.bad(at..at, without_content(&error.message().trim().replace('\n', ", ")), "TOML is expected")
        })?;
        let root = Section { source: &source, name: "", at: 0..0, table: document.get_ref() };
        root.check_format()?;
        let constants = CONSTANTS.map(|(name, _)| name);
        root.accept(&ROOT.iter().chain(&constants).copied().collect::<Vec<_>>())?;
        let process = root.need("process")?;
        let (polishes, known) = (process.get_ref() == "polishing", Process::from_name(process.get_ref()));
        let process = known.or(polishes.then_some(Process::Sanding)).ok_or_else(|| {
            source.bad(
                process.span(),
                format!("process is {}", quoted_near(process.get_ref(), ["grinding", "sanding", "polishing"])),
                "grinding, sanding or polishing is expected",
            )
        })?;
        let below = root.sections("columns")?;
        let [columns_section] = &below[..] else {
            return Err(source.bad(0..0, "no [columns]", "the columns of force, time and removal are expected"));
        };
        let (columns, constants) = columns_section.columns()?;
        let constant = |name: &str| -> Result<Option<f64>, TrialError> {
            let inner = constants.iter().find(|(key, _)| *key == name).map(|(_, value)| *value);
            Ok(root.constant(name)?.or(inner))
        };
        Ok(Self {
            name: root.need("name")?.into_inner(),
            process,
            polishes,
            csv: root.need("csv").map(|csv| Spanned::new(csv.span(), PathBuf::from(csv.into_inner())))?,
            order: root.text("order")?,
            area: constant("area_mm2")?,
            radius: constant("radius_mm")?,
            density: constant("density_kg_m3")?,
            coating: constant("coating_mm")?,
            noise: root.noise()?,
            columns,
            columns_at: columns_section.at.clone(),
            source,
        })
    }

    /// The column of a quantity.
    pub(super) fn column(&self, key: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.key == key)
    }
}

impl<'a> Section<'a> {
    fn get(&self, key: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        self.table.iter().find(|(name, _)| name.get_ref() == key).map(|(_, value)| value)
    }

    fn text(&self, key: &str) -> Result<Option<Spanned<String>>, TrialError> {
        let Some(value) = self.get(key) else { return Ok(None) };
        match value.get_ref() {
            DeValue::String(text) => Ok(Some(Spanned::new(value.span(), text.to_string()))),
            _ => Err(self.source.bad(value.span(), format!("{key} is not a text"), "text in quotes is expected")),
        }
    }

    fn need(&self, key: &str) -> Result<Spanned<String>, TrialError> {
        let place = if self.name.is_empty() { String::new() } else { format!(" in {}", self.name) };
        self.text(key)?.ok_or_else(|| {
            self.source.bad(self.at.clone(), format!("no {key}{place}"), format!("{key} = \"...\" is expected"))
        })
    }

    /// One of [`CONSTANTS`] [SI].
    fn constant(&self, key: &str) -> Result<Option<f64>, TrialError> {
        let Some(value) = self.get(key) else { return Ok(None) };
        let number = match value.get_ref() {
            DeValue::Integer(number) => number.as_str().parse().ok(),
            DeValue::Float(number) => number.as_str().parse().ok(),
            _ => None,
        };
        let size = CONSTANTS.iter().find(|(name, _)| *name == key).map_or(1.0, |(_, size)| *size);
        match number {
            Some(number) if number > 0.0 && f64::is_finite(number) => Ok(Some(number * size)),
            _ => Err(self.source.bad(
                value.span(),
                format!("{key} is not above zero"),
                "a number above zero is expected",
            )),
        }
    }

    /// The stated relative noise of a row, as `"5 %"` or a plain number below one.
    fn noise(&self) -> Result<Option<f64>, TrialError> {
        let Some(value) = self.get("noise") else { return Ok(None) };
        let stated = match value.get_ref() {
            DeValue::Integer(number) => number.as_str().parse().ok(),
            DeValue::Float(number) => number.as_str().parse().ok(),
            DeValue::String(text) => {
                quantity(text).filter(|(_, unit)| unit.dimension().is_none()).map(|(v, u)| u.to_si(v))
            }
            _ => None,
        };
        match stated {
            Some(noise) if noise > 0.0 && noise < 1.0 => Ok(Some(noise)),
            _ => Err(self.source.bad(
                value.span(),
                "noise is not a share of the removal between 0 and 100 %",
                "the standard deviation of a row over its removal is expected, such as noise = \"5 %\" or noise = 0.05",
            )),
        }
    }

    /// The tables under a key: one, or a list.
    fn sections(&self, key: &'a str) -> Result<Vec<Section<'a>>, TrialError> {
        let Some(value) = self.get(key) else { return Ok(Vec::new()) };
        let section = |value: &'a Spanned<DeValue<'a>>| match value.get_ref() {
            DeValue::Table(table) => Ok(Section { source: self.source, name: key, at: value.span(), table }),
            _ => Err(self.source.bad(
                value.span(),
                format!("{key} is not a table"),
                format!("{key} = {{ column = \"...\" }} is expected"),
            )),
        };
        match value.get_ref() {
            DeValue::Array(list) => list.iter().map(section).collect(),
            _ => Ok(vec![section(value)?]),
        }
    }

    /// Reports a file of another format before anything else.
    fn check_format(&self) -> Result<(), TrialError> {
        let format = self.need("format")?;
        if format.get_ref() == TABLE_FORMAT {
            return Ok(());
        }
        let found = format!("format is {}", quoted_near(format.get_ref(), [TABLE_FORMAT]));
        Err(self.source.bad(format.span(), found, format!("{TABLE_FORMAT:?} is expected")))
    }

    /// Refuses unknown keys.
    fn accept(&self, known: &[&str]) -> Result<(), TrialError> {
        match self.table.iter().find(|(key, _)| !known.contains(&key.get_ref().as_ref())) {
            None => Ok(()),
            Some((key, _)) => Err(self.unknown(key.get_ref(), key.span(), known)),
        }
    }

    fn unknown(&self, key: &str, at: Range<usize>, known: &[&str]) -> TrialError {
        let place = if self.name.is_empty() { String::new() } else { format!(" in {}", self.name) };
        let hint = nearest(key, known.iter().copied()).map_or(String::new(), |near| format!("did you mean {near:?}? "));
        let shown = quoted_near(key, known.iter().copied());
        self.source.bad(at, format!("unknown key {shown}{place}"), format!("{hint}Accepted are {}", known.join(", ")))
    }

    /// The entries below `columns`, in the order of their keys, and the constants among them.
    fn columns(&self) -> Result<(Vec<Column>, Vec<Constant>), TrialError> {
        let known: Vec<&str> = NUMBERS.iter().chain(&TEXTS).chain(&["usage"]).copied().collect();
        let (mut columns, mut constants) = (Vec::new(), Vec::new());
        for (key, _) in self.table {
            let name = key.get_ref().as_ref();
            // A state may have any name, except one that is a typing error of a known key.
            let slips = |known: &&str| strsim::osa_distance(known, name) <= SLIPS;
            if !known.contains(&name) && known.iter().any(slips) {
                return Err(self.unknown(name, key.span(), &known));
            }
            for section in self.sections(name)? {
                columns.push(section.column(name)?);
                for (constant, _) in CONSTANTS {
                    constants.extend(section.constant(constant)?.map(|value| (constant, value)));
                }
            }
        }
        Ok((columns, constants))
    }

    fn column(&self, key: &str) -> Result<Column, TrialError> {
        let name = self.need("column")?;
        if TEXTS.contains(&key) {
            self.accept(&["column"])?;
            return Ok(Column { key: key.to_owned(), name, unit: None, unit_text: String::new() });
        }
        let constants = CONSTANTS.map(|(name, _)| name);
        self.accept(&["column", "unit"].iter().chain(&constants).copied().collect::<Vec<_>>())?;
        let unit = match self.text("unit")? {
            None if key == "spindle_rpm" => Spanned::new(self.at.clone(), "rpm".to_owned()),
            None => {
                return Err(self.source.bad(
                    self.at.clone(),
                    format!("no unit in {key}"),
                    "unit = \"...\" is expected",
                ));
            }
            Some(unit) => unit,
        };
        let parsed = ColumnUnit::parse(unit.get_ref())
            .map_err(|error| self.source.bad(unit.span(), format!("unit of {key}: {error}"), "a unit is expected"))?;
        let unit_text = unit.get_ref().clone();
        Ok(Column { key: key.to_owned(), name, unit: Some(Spanned::new(unit.span(), parsed)), unit_text })
    }
}

impl Column {
    /// Checks that the column's unit is one of `wanted`, each an example with its dimension.
    pub(super) fn expect(&self, source: &Source, wanted: &[(&str, Dimension)]) -> Result<ColumnUnit, TrialError> {
        let unit = self.unit.as_ref().expect("a column of numbers has a unit");
        if wanted.iter().any(|(_, dimension)| *dimension == unit.get_ref().dimension()) {
            return Ok(*unit.get_ref());
        }
        let examples: Vec<&str> = wanted.iter().map(|(example, _)| *example).collect();
        let found = format!("the unit of {} is one of [{}]", self.key, unit.get_ref().dimension());
        Err(source.bad(unit.span(), found, format!("a unit such as {} is expected", examples.join(", "))))
    }
}
