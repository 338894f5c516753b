//! Reads tables of a TOML text so that every error names file, line and key.

use std::ops::Range;

use toml_edit::{Document, Item, TableLike, Value};

use files::input::{measured, quoted_near, without_content};

use super::definition::{Formula, line_column};
use super::error::{EffectError, Problem};
use super::parse::parse;
use super::unit::Unit;

/// Greatest number of characters of a quantity that a message quotes.
const MOST_QUANTITY: usize = 24;

/// A text and its name, for messages.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    /// Name of the file.
    pub file: &'a str,
    /// Text of the file.
    pub text: &'a str,
}

impl<'a> Source<'a> {
    /// Parses the text as TOML.
    pub fn document(self) -> Result<Document<&'a str>, EffectError> {
        Document::parse(self.text).map_err(|error| {
            let reason = without_content(&error.message().replace('\n', ", "));
            self.error(error.span().map_or(0, |span| span.start), "", Problem::Toml(reason))
        })
    }

    /// Makes an error at a byte offset of the text.
    pub fn error(self, byte: usize, key: &str, problem: Problem) -> EffectError {
        let (line, column) = line_column(self.text, byte);
        let key = if key.is_empty() { "the file".to_owned() } else { key.to_owned() };
        EffectError { file: self.file.to_owned(), line, column, key, problem: Box::new(problem) }
    }
}

/// A table of the file, with its key.
pub struct Section<'a> {
    source: Source<'a>,
    table: &'a dyn TableLike,
    key: String,
    start: usize,
}

/// An entry of a table.
pub struct Entry<'a> {
    /// The file.
    pub source: Source<'a>,
    /// Dotted key from the top of the file.
    pub key: String,
    /// Byte range of the value.
    pub span: Range<usize>,
    item: &'a Item,
}

impl<'a> Section<'a> {
    /// The whole file as a table.
    pub fn root(source: Source<'a>, document: &'a Document<&'a str>) -> Self {
        Self { source, table: document.as_table(), key: String::new(), start: 0 }
    }

    fn dotted(&self, name: &str) -> String {
        if self.key.is_empty() { name.to_owned() } else { format!("{}.{name}", self.key) }
    }

    /// Rejects keys other than these.
    pub fn accept(&self, accepted: &[&str]) -> Result<(), EffectError> {
        match self.entries().find(|(name, _)| !accepted.contains(name)) {
            None => Ok(()),
            Some((name, entry)) => {
                Err(entry.error(Problem::UnknownKey { found: named(name, accepted), accepted: accepted.join(", ") }))
            }
        }
    }

    /// The entries in the order of the file.
    pub fn entries(&self) -> impl Iterator<Item = (&'a str, Entry<'a>)> + use<'a> {
        let (source, start, prefix) = (self.source, self.start, self.key.clone());
        self.table.iter().map(move |(name, item)| {
            let key = if prefix.is_empty() { name.to_owned() } else { format!("{prefix}.{name}") };
            let span = item.span().unwrap_or(start..start);
            (name, Entry { source, key, span, item })
        })
    }

    /// Returns the entry of this name, if there is one.
    pub fn get(&self, name: &str) -> Option<Entry<'a>> {
        self.entries().find(|(key, _)| *key == name).map(|(_, entry)| entry)
    }

    /// Returns the entry of this name, or an error if it is missing.
    pub fn need(&self, name: &str) -> Result<Entry<'a>, EffectError> {
        self.get(name)
            .ok_or_else(|| self.source.error(self.start, &self.dotted(name), Problem::Missing(name.to_owned())))
    }

    /// Reads a text; `None` if the entry is missing.
    pub fn optional_text(&self, name: &str) -> Result<Option<String>, EffectError> {
        self.get(name).map(|entry| entry.text().map(str::to_owned)).transpose()
    }

    /// Tables within the table `name`, in the order of the file.
    pub fn tables(&self, name: &str) -> Result<Vec<(&'a str, Section<'a>)>, EffectError> {
        let Some(entry) = self.get(name) else { return Ok(Vec::new()) };
        entry.section()?.entries().map(|(key, entry)| Ok((key, entry.section()?))).collect()
    }

    /// Reads one of a list of words; the first is the default.
    pub fn choice<T: Copy>(&self, name: &str, words: &[(&str, T)]) -> Result<T, EffectError> {
        let Some(entry) = self.get(name) else { return Ok(words[0].1) };
        let found = entry.text()?;
        words.iter().find(|(word, _)| *word == found).map(|(_, value)| *value).ok_or_else(|| {
            let accepted: Vec<&str> = words.iter().map(|(word, _)| *word).collect();
            entry.unfit(named(found, &accepted), format!("one of {}", accepted.join(", ")))
        })
    }

    /// Makes an error about the table as a whole.
    pub fn error(&self, problem: Problem) -> EffectError {
        self.source.error(self.start, &self.key, problem)
    }

    /// Line of the table in the file, from 1.
    pub fn line(&self) -> usize {
        line_column(self.source.text, self.start).0
    }
}

impl<'a> Entry<'a> {
    /// Makes an error about this entry.
    pub fn error(&self, problem: Problem) -> EffectError {
        self.source.error(self.span.start, &self.key, problem)
    }

    /// Makes an error about a value that is not accepted.
    pub fn unfit(&self, found: impl Into<String>, expected: impl Into<String>) -> EffectError {
        self.error(Problem::Value { found: found.into(), expected: expected.into() })
    }

    fn found(&self) -> String {
        let end = self.span.end.min(self.span.start + 40);
        self.source.text.get(self.span.start..end).filter(|text| !text.is_empty()).unwrap_or("a table").to_owned()
    }

    /// Reads the entry as text.
    pub fn text(&self) -> Result<&'a str, EffectError> {
        self.item.as_str().ok_or_else(|| self.unfit(self.found(), "a text in quotes"))
    }

    /// Reads the entry as a list of texts.
    pub fn texts(&self) -> Result<Vec<String>, EffectError> {
        let refuse = || self.unfit(self.found(), "a list of texts in quotes");
        let array = self.item.as_array().ok_or_else(refuse)?;
        array.iter().map(|value| value.as_str().map(str::to_owned).ok_or_else(refuse)).collect()
    }

    /// Reads the entry as true or false.
    pub fn truth(&self) -> Result<bool, EffectError> {
        self.item.as_bool().ok_or_else(|| self.unfit(self.found(), "true or false"))
    }

    /// Reads the entry as a whole number from 0.
    pub fn whole(&self) -> Result<u32, EffectError> {
        let number = self.item.as_integer().and_then(|number| u32::try_from(number).ok());
        number.ok_or_else(|| self.unfit(self.found(), "a whole number from 0"))
    }

    /// Reads the entry as a table.
    pub fn section(&self) -> Result<Section<'a>, EffectError> {
        let table = self.item.as_table_like().ok_or_else(|| self.unfit(self.found(), "a table"))?;
        Ok(Section { source: self.source, table, key: self.key.clone(), start: self.span.start })
    }

    /// True if it is a table.
    pub fn is_table(&self) -> bool {
        self.item.is_table_like()
    }

    /// Reads the entry as one quantity [SI] or a list of them. `unit` is that of plain numbers.
    pub fn quantities(&self, unit: Unit, bare: BareNumber) -> Result<Vec<f64>, EffectError> {
        match self.item.as_value() {
            Some(Value::Array(array)) => array.iter().map(|value| self.quantity_of(value, unit, bare)).collect(),
            Some(value) => Ok(vec![self.quantity_of(value, unit, bare)?]),
            None => Err(self.unfit(self.found(), "a number")),
        }
    }

    /// Reads the entry as one quantity [SI].
    pub fn quantity(&self, unit: Unit, bare: BareNumber) -> Result<f64, EffectError> {
        match self.item.as_value() {
            Some(value) => self.quantity_of(value, unit, bare),
            None => Err(self.unfit(self.found(), "a number")),
        }
    }

    fn quantity_of(&self, value: &Value, unit: Unit, bare: BareNumber) -> Result<f64, EffectError> {
        let number = value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
        if let Some(number) = number {
            // Zero and infinity are the same in every unit.
            let plain = number == 0.0 || number.is_infinite() || unit == Unit::ONE || bare == BareNumber::InUnit;
            if number.is_nan() || !plain {
                return Err(self.unfit(format!("{number}"), "a text with number and unit, such as \"350 mm^3\""));
            }
            return Ok(unit.to_si(number));
        }
        let text =
            value.as_str().ok_or_else(|| self.unfit(self.found(), "a number, or a text with number and unit"))?;
        parse_quantity(text, unit).map_err(|problem| self.error(problem))
    }

    /// Reads the entry as a formula.
    pub fn formula(&self) -> Result<Formula, EffectError> {
        let text = self.text()?;
        let raw = self.source.text.get(self.span.clone()).unwrap_or_default();
        // Escape sequences would shift positions; formulas need none.
        let start = self.span.start + raw.find(text).unwrap_or(0);
        let tree = parse(text)
            .map_err(|error| self.source.error(start + error.span.start, &self.key, Problem::Syntax(error)))?;
        Ok(Formula { key: self.key.clone(), text: text.to_owned(), tree, start })
    }
}

/// Quotes a word of the file, shortened for a message.
pub(super) fn named(found: &str, accepted: &[&str]) -> String {
    quoted_near(found, accepted.iter().copied()).replace('"', "`")
}

/// Interpretation of a number without a unit.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum BareNumber {
    /// The number is in the unit of the parameter.
    InUnit,
    /// The number is rejected, unless the unit is 1.
    Refused,
}

/// Parses text such as `350 mm^3` to an SI value of the dimension of `unit`.
pub fn parse_quantity(text: &str, unit: Unit) -> Result<f64, Problem> {
    let text = text.trim();
    let shown = if text.len() <= MOST_QUANTITY { format!("`{text}`") } else { measured(text) };
    let unfit =
        || Problem::Value { found: shown.clone(), expected: "a number and its unit, such as `350 mm^3`".to_owned() };
    let end = text.find(char::is_whitespace).unwrap_or(text.len());
    let number: f64 = text[..end].parse().map_err(|_| unfit())?;
    if number.is_nan() {
        return Err(unfit());
    }
    let rest = text[end..].trim();
    if rest.is_empty() {
        let plain = number == 0.0 || number.is_infinite() || unit.dimension.is_none();
        return if plain { Ok(number) } else { Err(unfit()) };
    }
    let own = Unit::parse(rest)?;
    if own.dimension != unit.dimension {
        let expected = format!("{}", unit.dimension);
        return Err(Problem::Dimension { what: shown, found: own.dimension, expected });
    }
    Ok(own.to_si(number))
}
