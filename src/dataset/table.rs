//! The catalogue as a table: one column for each figure of any row.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Context, Result};
use serde_json::Value;

use super::row::Row;

/// Columns that come first; the others follow in alphabetical order.
const FIRST: [&str; 6] = ["id", "split", "difficulty", "source", "index", "folder"];

/// Table of text, as in `manifest.csv`.
pub(super) struct Table {
    pub(super) columns: Vec<String>,
    lines: Vec<BTreeMap<String, String>>,
}

impl Table {
    /// Makes the table; nested figures become columns such as `measured.welds.0.length_mm`.
    ///
    /// # Errors
    /// Never: rows are plain data.
    pub(super) fn of<'a>(rows: impl Iterator<Item = &'a Row>) -> Result<Self> {
        let mut lines = Vec::new();
        for row in rows {
            let mut line = BTreeMap::new();
            spread(String::new(), &serde_json::to_value(row)?, &mut line);
            lines.push(line);
        }
        let names: BTreeSet<String> = lines.iter().flat_map(|line| line.keys().cloned()).collect();
        let first = FIRST.iter().map(|&name| name.to_owned());
        let others = names.into_iter().filter(|name| !FIRST.contains(&name.as_str()));
        Ok(Self { columns: first.chain(others).collect(), lines })
    }

    /// Returns the text of the file (RFC 4180, with line feeds).
    ///
    /// # Errors
    /// Never: it is written to memory.
    pub(super) fn csv(&self) -> Result<Vec<u8>> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(&self.columns)?;
        for line in &self.lines {
            writer.write_record(self.columns.iter().map(|column| line.get(column).map_or("", String::as_str)))?;
        }
        writer.into_inner().ok().context("the table cannot be written")
    }

    /// Returns true if a column has values and all of them are numbers.
    pub(super) fn is_numeric(&self, column: &str) -> bool {
        let mut cells =
            self.lines.iter().filter_map(|line| line.get(column)).filter(|cell| !cell.is_empty()).peekable();
        cells.peek().is_some() && cells.all(|cell| cell.parse::<f64>().is_ok())
    }
}

fn spread(name: String, value: &Value, line: &mut BTreeMap<String, String>) {
    let below = |part: &str| if name.is_empty() { part.to_owned() } else { format!("{name}.{part}") };
    match value {
        Value::Object(fields) => fields.iter().for_each(|(part, value)| spread(below(part), value, line)),
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(place, value)| spread(below(&place.to_string()), value, line));
        }
        Value::Null => {
            line.insert(name, String::new());
        }
        Value::String(text) => {
            line.insert(name, text.clone());
        }
        Value::Bool(_) | Value::Number(_) => {
            line.insert(name, value.to_string());
        }
    }
}
