//! Effects for tables in addition to the library: a power law of running-in, and for each column that the table
//! declares as a state the possible forms of the rate's dependence on it.

use effects::{Effect, Library};

use super::column_form::{ColumnForm, Written};
use super::evidence::Split;
use super::rows::RowEvidence;
use super::summary::EffectSummary;
use super::table_steps::{KELVIN, ROOM, measuring};
use crate::criteria::SAME_RESPONSE;
use trials::table::{Table, Usage};

/// Running-in: rows of different lengths show it, scans of equal passes do not.
const RUNNING_IN: (&str, &str) = ("running-in.toml", include_str!("table_effects/running-in.toml"));
/// Name of the state of such an effect.
pub(super) const COLUMN_STATE: &str = "value";
/// Longest name of a column in an effect.
const LONGEST_NAME: usize = 60;

/// Name of the effect of a column, given its index in [`Table::usage`].
pub(super) fn column_effect(table: &Table, usage: usize) -> String {
    let name = |usage: &Usage| {
        let letters = usage.name.chars().take(LONGEST_NAME);
        let plain: String =
            letters.map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '-' }).collect();
        let parts: Vec<&str> = plain.split('-').filter(|part| !part.is_empty()).collect();
        format!("column-{}", parts.join("-"))
    };
    let own = name(&table.usage[usage]);
    let is_taken = table.usage[..usage].iter().any(|other| name(other) == own);
    if is_taken || own.ends_with('-') { format!("column-{}-{own}", usage + 1) } else { own }
}

/// Index in [`Table::usage`] of the column of an effect, and its form; `None` for any other effect.
pub(super) fn column_of(table: &Table, effect: &str) -> Option<(usize, ColumnForm)> {
    let is_own = |name: &str, form: &ColumnForm| form.name(name) == effect;
    let of = |usage: usize| {
        let name = column_effect(table, usage);
        Some((usage, ColumnForm::ALL.into_iter().find(|form| is_own(&name, form))?))
    };
    (0..table.usage.len()).find_map(of)
}

impl RowEvidence<'_> {
    /// Returns a library with the effects of this table. A column that a library effect reads in the same way gets none
    /// of its own.
    ///
    /// # Errors
    /// If an effect cannot be evaluated on these rows.
    pub fn library(&self, library: &Library) -> Result<Library, String> {
        let columns = (0..self.table.usage.len()).flat_map(|usage| self.column_files(usage));
        let files: Vec<(String, String)> =
            std::iter::once((RUNNING_IN.0.to_owned(), RUNNING_IN.1.to_owned())).chain(columns).collect();
        let is_new = |(file, _): &(String, String)| library.find(file.trim_end_matches(".toml")).is_none();
        let files: Vec<(String, String)> = files.into_iter().filter(is_new).collect();
        let extended = library.with(&files).map_err(|error| error.to_string())?;
        let mut needless = Vec::new();
        for usage in 0..self.table.usage.len() {
            let name = column_effect(self.table, usage);
            if let Some(own) = extended.find(&name).filter(|_| library.find(&name).is_none())
                && self.is_read_alike(usage, own, &extended)
            {
                needless.extend(ColumnForm::ALL.map(|form| form.name(&name)));
            }
        }
        Ok(extended.without(&needless.iter().map(String::as_str).collect::<Vec<_>>()))
    }

    /// Returns true if another effect reads a column and changes the rows in proportion to the column's own effect.
    fn is_read_alike(&self, usage: usize, own: &Effect, library: &Library) -> bool {
        let reads = |effect: &&Effect| {
            let states = effect.states.iter();
            column_of(self.table, &effect.name).is_none()
                && effect.acts_in(self.table.process)
                && states.into_iter().any(|state| measuring(self.table, &effect.name, state) == Some(usage))
        };
        let Ok(change) = self.response(own, library) else { return false };
        library.effects().iter().filter(reads).any(|effect| {
            let other = self.acts(effect).and_then(|()| self.response(effect, library));
            other.is_ok_and(|other| correlation(&change, &other).abs() > SAME_RESPONSE)
        })
    }

    /// Sentence on a fitted effect of a column; `None` for any other effect.
    pub(super) fn column_words(&self, effect: &EffectSummary) -> Option<String> {
        let (usage, form) = column_of(self.table, &effect.name)?;
        form.words(effect, &self.table.usage[usage].name)
    }

    /// The effect files of a column, one for each form that its values can show.
    fn column_files(&self, usage: usize) -> Vec<(String, String)> {
        let column = &self.table.usage[usage];
        let zero = if column.dimension == KELVIN { ROOM } else { column.scale.1 };
        let value = |&at: &usize| (self.table.rows[at].usage[usage] - zero) / column.scale.0;
        let mut values: Vec<f64> = self.of(Split::Calibration).iter().map(value).collect();
        values.sort_by(f64::total_cmp);
        let is_shown = |c: &char| !c.is_control() && !['"', '\\'].contains(c);
        let shown: String = column.name.chars().filter(is_shown).take(LONGEST_NAME).collect();
        let unit = if column.dimension == KELVIN { "K" } else { &column.unit };
        let written = Written { shown: &shown, unit, dimension: column.dimension, values: &values };
        let name = column_effect(self.table, usage);
        ColumnForm::ALL.into_iter().filter_map(|form| form.file(&form.name(&name), &written)).collect()
    }
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    dot(a, b) / (dot(a, a) * dot(b, b)).sqrt().max(f64::MIN_POSITIVE)
}
