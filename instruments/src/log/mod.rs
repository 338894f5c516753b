//! Logs of robots, sensors and people: named channels of numbers, without interpretation.
//!
//! [`read`] tests the formats in `FORMATS` in turn, by the file's content. A format is a file or a folder here with one
//! type that implements `Format`; adding one takes a module and a line. [`guess`] guesses the quantity of each channel,
//! with a reason.
//!
//! ```
//! use std::path::Path;
//!
//! let text = b"Zeit;X [mm];Kraft (N)\n0,00;1,5;12\n0,01;1,6;13\n";
//! let log = instruments::log::read(Path::new("log.csv"), text)?;
//! assert_eq!(log.names, ["Zeit", "X [mm]", "Kraft (N)"]);
//! assert_eq!(log.units[1].as_deref(), Some("mm"));
//! assert_eq!(log.channel("X [mm]"), Some(&[1.5, 1.6][..]));
//! # Ok::<(), instruments::Misread>(())
//! ```

mod bag;
mod delimited;
mod diadem;
mod foreign;
pub mod guess;
mod rsi;
mod text;
mod unit;

use std::path::Path;

use crate::misread::{Misread, Place};

pub use guess::{Guesses, guess};
pub(crate) use text::{decode, lines};
pub(crate) use unit::split as split_unit;

/// Maximum number of values of a log: 1 GiB of them.
const MOST_VALUES: usize = 1 << 27;
/// Maximum number of channels of a log.
const MOST_CHANNELS: usize = 4096;

/// The formats in the order in which they are tested; delimited text, which any text may be, comes last.
const FORMATS: [&dyn Format; 5] = [&bag::Mcap, &bag::Db3, &diadem::Diadem, &rsi::Rsi, &delimited::Delimited];

/// A file format of logs.
trait Format: Sync {
    /// Name for messages.
    fn name(&self) -> &'static str;

    /// True if a file is of this format.
    fn recognises(&self, bytes: &[u8]) -> bool;

    /// Reads a file of this format.
    fn read(&self, file: &Path, bytes: &[u8]) -> Result<Channels, Misread>;
}

/// A log: channels of the same length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Channels {
    /// Name of the file's format.
    pub format: &'static str,
    /// Names in the file, made unique; `topic/field` in bags.
    pub names: Vec<String>,
    /// Unit of each channel, `None` if the file gives none. Known units have one spelling: `s`, `ms`, `us`, `ns`, `m`,
    /// `mm`, `um`, `N`, `kN`, `Nm`, `rpm`, `rad/s`, `rad`, `deg`, `mm/s`, `m/s`, `°C`, `K`. Others are kept as written.
    pub units: Vec<Option<String>>,
    /// Values in the file's units, one list for each name, each as long as `lines`; NaN for missing values.
    pub values: Vec<Vec<f64>>,
    /// Position of each row: line of a text, or number of a message in a bag, both from 1.
    pub lines: Vec<u64>,
    /// Names of text columns, which are left out.
    pub text: Vec<String>,
    /// Notes on the interpretation of unusual files.
    pub notes: Vec<String>,
}

impl Channels {
    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.lines.len()
    }

    /// The values of the channel with exactly this name.
    pub fn channel(&self, name: &str) -> Option<&[f64]> {
        let at = self.names.iter().position(|other| other == name)?;
        self.values.get(at).map(Vec::as_slice)
    }

    /// Adds a channel. A duplicate name gets a number.
    fn push(&mut self, name: &str, unit: Option<String>, values: Vec<f64>) {
        let mut own = name.to_owned();
        let is_there = self.names.contains(&own);
        // Start above the number of existing copies, because there may be thousands.
        let mut copy = if is_there { self.names.iter().filter(|other| other.starts_with(name)).count() } else { 1 };
        while self.names.contains(&own) {
            copy += 1;
            own = format!("{name} ({copy})");
        }
        if copy > 1 {
            self.notes.push(format!("the name {name:?} occurs {copy} times; the later one becomes {own:?}"));
        }
        self.names.push(own);
        self.units.push(unit);
        self.values.push(values);
    }
}

/// Reads a log. For a DIAdem header, also reads the files of values beside it.
///
/// # Errors
/// [`Misread`] with the place in the file: an unsupported format, or content that does not follow the format.
pub fn read(file: &Path, bytes: &[u8]) -> Result<Channels, Misread> {
    foreign::refuse(file, bytes)?;
    let last: &dyn Format = &delimited::Delimited;
    FORMATS.into_iter().find(|format| format.recognises(bytes)).unwrap_or(last).read(file, bytes)
}

/// Reads decoded delimited text.
pub(crate) fn read_text(file: &Path, text: &str) -> Result<Channels, Misread> {
    delimited::read(file, text, Vec::new())
}

/// Names of the supported formats.
pub fn formats() -> impl Iterator<Item = &'static str> {
    FORMATS.into_iter().map(|format| format.name())
}

/// Checks the number of values of a log.
fn check_size(place: Place, channels: usize, rows: usize) -> Result<(), Misread> {
    if channels > MOST_CHANNELS {
        return Err(place.bad(format!("{channels} channels"), format!("at most {MOST_CHANNELS} are accepted")));
    }
    if channels.saturating_mul(rows) > MOST_VALUES {
        let found = format!("{rows} rows of {channels} channels");
        return Err(place.bad(found, format!("at most {MOST_VALUES} values are accepted")));
    }
    Ok(())
}
