//! Conversion of any file of channels to a [`Log`], with the column names of `[log.columns]` in `trial.toml`.

use robot::LogRow;
use std::ops::Range;
use std::path::Path;

use effects::Dimension;
use files::input::{self, MOST_TABLE_BYTES, quoted_names, quoted_near};
use glam::DVec3;
use instruments::log::Channels;

use super::error::{Place, TrialError};
use super::log::{Covariate, Log};
use super::manifest::{ChannelEntry, LogTable, Source, nearest};
use super::scan::Read;
use crate::column_unit::ColumnUnit;

/// A quantity that a channel gives: its key in `[log.columns]`, its default unit, and its dimension in kilograms,
/// metres, seconds and kelvins.
struct Quantity {
    key: &'static str,
    unit: &'static str,
    dimension: [i32; 4],
    /// True if every log must have it.
    is_needed: bool,
}

const fn quantity(key: &'static str, unit: &'static str, dimension: [i32; 4], is_needed: bool) -> Quantity {
    Quantity { key, unit, dimension, is_needed }
}

/// All quantities; the order is that of [`Resolved`].
const QUANTITIES: [Quantity; 10] = [
    quantity("time", "s", [0, 0, 1, 0], true),
    quantity("x", "mm", [0, 1, 0, 0], true),
    quantity("y", "mm", [0, 1, 0, 0], true),
    quantity("z", "mm", [0, 1, 0, 0], true),
    quantity("force", "N", [1, 1, -2, 0], true),
    quantity("spindle", "rpm", [0, 0, -1, 0], false),
    quantity("nx", "1", [0; 4], false),
    quantity("ny", "1", [0; 4], false),
    quantity("nz", "1", [0; 4], false),
    quantity("temperature", "degC", [0, 0, 0, 1], false),
];
const FORCE: usize = 4;
const SPINDLE: usize = 5;
const AXIS: Range<usize> = 6..9;
const TEMPERATURE: usize = 9;
/// Zero of the Celsius scale [K].
const CELSIUS: f64 = 273.15;

/// Columns of a trial's logs.
pub(super) struct LogColumns<'a> {
    source: &'a Source,
    table: &'a LogTable,
}

/// Log of one pass in progress: its channels in SI, in the order of [`QUANTITIES`].
struct Resolved<'a> {
    channels: &'a Channels,
    values: Vec<Option<Vec<f64>>>,
    used: Vec<usize>,
}

impl<'a> LogColumns<'a> {
    /// Resolves the columns that a table names.
    ///
    /// # Errors
    /// An unknown key, a missing required one, or a unit of the wrong dimension.
    pub(super) fn new(source: &'a Source, table: &'a LogTable) -> Result<Self, TrialError> {
        let keys = || QUANTITIES.iter().map(|quantity| quantity.key);
        for (key, entry) in &table.columns {
            if keys().all(|known| known != key) {
                let hint = nearest(key, keys()).map_or(String::new(), |near| format!("did you mean {near:?}? "));
                let found = format!("unknown key {} in [log.columns]", quoted_near(key, keys()));
                let accepted = format!("{hint}Accepted are {}", keys().collect::<Vec<_>>().join(", "));
                return Err(source.bad(entry.span(), found, accepted));
            }
        }
        let columns = Self { source, table };
        QUANTITIES.iter().try_for_each(|quantity| columns.unit(quantity).map(|_| ()))?;
        Ok(columns)
    }

    /// Reads a log.
    ///
    /// - `spindle_speed`: that of the pass [rad/s], for logs without a spindle speed
    ///
    /// # Errors
    /// [`TrialError`] with the place: a file that is not a log, a missing channel, a clock that runs backwards.
    pub(super) fn read(&self, file: &Path, spindle_speed: Option<f64>) -> Result<Read<Log>, TrialError> {
        let bytes = input::read(file, MOST_TABLE_BYTES)?;
        let channels = instruments::log::read(file, &bytes)?;
        let mut values = Vec::new();
        let mut used = Vec::new();
        for quantity in &QUANTITIES {
            let channel = self.channel(quantity, &channels, file)?;
            used.extend(channel.as_ref().map(|(at, _)| *at));
            values.push(channel.map(|(_, values)| values));
        }
        let mut resolved = Resolved { channels: &channels, values, used };
        if resolved.values[SPINDLE].is_none() {
            let speed = spindle_speed.ok_or_else(|| self.without_spindle(file, &channels))?;
            resolved.values[SPINDLE] = Some(vec![speed; channels.rows()]);
        }
        let mut log = resolved.log(file)?;
        self.place(&mut log.content);
        Ok(log)
    }

    /// The unit of a quantity, if the table gives the quantity.
    fn unit(&self, quantity: &Quantity) -> Result<Option<ColumnUnit>, TrialError> {
        let Some(entry) = self.table.columns.get(quantity.key) else {
            if quantity.is_needed {
                let found = format!("[log.columns] without {}", quantity.key);
                let accepted = format!("{} = \"NAME OF THE COLUMN\" is needed", quantity.key);
                return Err(Place::file(&self.source.file).bad(found, accepted));
            }
            return Ok(None);
        };
        let text = entry.get_ref().unit().unwrap_or(quantity.unit);
        let is_spindle = quantity.key == QUANTITIES[SPINDLE].key;
        let bad = |found: String| {
            let accepted = format!("a unit such as {} is expected for {}", quantity.unit, quantity.key);
            self.source.bad(entry.span(), found, accepted)
        };
        let parsed = if is_spindle { ColumnUnit::parse_spindle(text) } else { ColumnUnit::parse(text) };
        let unit = parsed.map_err(&bad)?;
        if unit.dimension() != Dimension::whole(quantity.dimension) {
            return Err(bad(format!("the unit {}", quoted_near(text, [quantity.unit]))));
        }
        Ok(Some(unit))
    }

    /// Index and SI values of a quantity's channel; `None` if the table does not give it.
    fn channel(
        &self,
        quantity: &Quantity,
        channels: &Channels,
        file: &Path,
    ) -> Result<Option<(usize, Vec<f64>)>, TrialError> {
        let Some((unit, entry)) = self.unit(quantity)?.zip(self.table.columns.get(quantity.key)) else {
            return Ok(None);
        };
        let ChannelEntry { column, sign, gain, zero, lag_s, .. } = entry.get_ref().clone();
        let names = || channels.names.iter().map(String::as_str);
        let Some(at) = names().position(|name| name == column) else {
            let near = nearest(&column, names()).map_or(String::new(), |near| format!("did you mean {near:?}? "));
            let accepted = format!("{near}The log has {}", quoted_names(&channels.names, [column.as_str()]));
            let found = format!("no column {} for {}", quoted_near(&column, names()), quantity.key);
            return Err(Place::file(file).bad(found, accepted));
        };
        let scale = sign.unwrap_or(1.0) * gain.unwrap_or(1.0);
        let of = |value: &f64| unit.to_si(scale * (value - zero.unwrap_or(0.0)));
        let values: Vec<f64> = channels.values[at].iter().map(of).collect();
        match lag_s {
            Some(lag) if lag != 0.0 => {
                let (_, times) = self.channel(&QUANTITIES[0], channels, file)?.expect("time is needed");
                Ok(Some((at, earlier(&times, &values, lag))))
            }
            _ => Ok(Some((at, values))),
        }
    }

    fn without_spindle(&self, file: &Path, channels: &Channels) -> TrialError {
        let found = "no spindle speed: neither spindle in [log.columns] nor spindle_rpm in its [[pass]]";
        let names = quoted_names(&channels.names, []);
        Place::file(file).bad(found, format!("one of both is needed; the log has the columns {names}"))
    }

    /// Transforms the tool's positions from the frame of the log to that of the scans.
    fn place(&self, log: &mut Log) {
        let offset = DVec3::from_array(self.table.offset_mm.unwrap_or_default()) * 1e-3;
        let turn = glam::DQuat::from_rotation_z(self.table.yaw_deg.unwrap_or_default().to_radians());
        if offset == DVec3::ZERO && turn == glam::DQuat::IDENTITY {
            return;
        }
        for row in &mut log.rows {
            row.position = turn * row.position + offset;
            row.approach = turn * row.approach;
        }
    }
}

/// Values of a channel with a delay of `lag` [s], moved to their true times; NaN beyond the ends.
fn earlier(times: &[f64], values: &[f64], lag: f64) -> Vec<f64> {
    let at = |time: f64| {
        let after = times.partition_point(|own| *own < time);
        match (after.checked_sub(1), times.get(after)) {
            (_, Some(own)) if *own == time => values[after],
            (Some(before), Some(own)) => {
                let share = (time - times[before]) / (own - times[before]);
                values[before] + share * (values[after] - values[before])
            }
            _ => f64::NAN,
        }
    };
    times.iter().map(|time| at(time + lag)).collect()
}

impl Resolved<'_> {
    fn log(&self, file: &Path) -> Result<Read<Log>, TrialError> {
        let value = |k: usize, row: usize| self.values[k].as_ref().map_or(f64::NAN, |values| values[row]);
        let has_approach = AXIS.into_iter().all(|k| self.values[k].is_some());
        let mut log = Log { has_approach, ..Log::default() };
        let (mut kept, mut holes, mut repeated) = (Vec::new(), 0, 0);
        for row in 0..self.channels.rows() {
            let found = LogRow {
                time: value(0, row),
                position: DVec3::new(value(1, row), value(2, row), value(3, row)),
                force: value(FORCE, row),
                spindle_speed: value(SPINDLE, row),
                approach: if has_approach { DVec3::from_array([6, 7, 8].map(|k| value(k, row))) } else { DVec3::Z },
            };
            let is_whole = [found.time, found.force, found.spindle_speed].iter().all(|value| value.is_finite());
            if !(is_whole && found.position.is_finite() && found.approach.length_squared() > 0.0) {
                holes += 1;
                continue;
            }
            match log.rows.last().map(|last: &LogRow| found.time - last.time) {
                Some(0.0) => repeated += 1,
                Some(step) if step < 0.0 => {
                    let bad = format!("the clock runs backwards, by {} s", -step);
                    let place = Place::line(file, self.channels.lines[row]);
                    return Err(place.bad(bad, "times that increase are expected"));
                }
                _ => {
                    log.rows.push(LogRow { approach: found.approach.normalize(), ..found });
                    kept.push(row);
                }
            }
        }
        if log.rows.len() < 2 {
            let found = format!("{} rows with a number in every needed column", log.rows.len());
            return Err(Place::file(file).bad(found, "at least 2 rows are expected"));
        }
        if let Some(kelvins) = &self.values[TEMPERATURE] {
            log.temperature = kept.iter().map(|&row| kelvins[row] - CELSIUS).collect();
        }
        log.covariates = self.others(&kept);
        Ok(Read { content: log, notes: self.notes((holes, repeated)) })
    }

    /// Channels that are not quantities of a pass.
    fn others(&self, kept: &[usize]) -> Vec<Covariate> {
        let channels = self.channels;
        let other = |at: usize| {
            let values: Vec<f64> = kept.iter().map(|&row| channels.values[at][row]).collect();
            let hole = values.iter().position(|value| !value.is_finite()).map(|k| channels.lines[kept[k]]);
            Covariate { name: channels.names[at].clone(), values, hole }
        };
        (0..channels.names.len()).filter(|at| !self.used.contains(at)).map(other).collect()
    }

    fn notes(&self, (holes, repeated): (usize, usize)) -> Vec<String> {
        let mut notes = vec![format!("{}: {} rows", self.channels.format, self.channels.rows())];
        notes.extend(self.channels.notes.iter().cloned());
        if holes > 0 {
            notes.push(format!("{holes} rows lack a number of time, place, force or spindle speed and are left out"));
        }
        if repeated > 0 {
            notes.push(format!("{repeated} rows repeat the time of the row before and are left out"));
        }
        if !self.channels.text.is_empty() {
            notes.push(format!("columns of text are left out: {}", self.channels.text.join(", ")));
        }
        notes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_unit_that_a_header_may_have_is_one_of_its_quantity() {
        for (quantity, units) in [
            (0, &["s", "ms", "us", "ns", "min", "h"][..]),
            (1, &["m", "mm", "um"]),
            (FORCE, &["N", "kN"]),
            (SPINDLE, &["rpm", "rad/s"]),
            (6, &["1"]),
            (TEMPERATURE, &["°C", "degC", "K"]),
        ] {
            for text in units {
                let unit = ColumnUnit::parse(text).unwrap_or_else(|error| panic!("{text}: {error}"));
                assert_eq!(unit.dimension(), Dimension::whole(QUANTITIES[quantity].dimension), "{text}");
            }
        }
    }

    #[test]
    fn a_late_channel_is_moved_to_the_times_that_it_belongs_to() {
        let moved = earlier(&[0.0, 1.0, 2.0, 4.0], &[10.0, 20.0, 40.0, 0.0], 1.5);
        assert_eq!(moved[..2], [30.0, 30.0]);
        assert_eq!(moved[2], 10.0);
        assert!(moved[3].is_nan());
    }
}
