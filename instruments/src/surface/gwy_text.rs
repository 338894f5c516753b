//! Text exports of Gwyddion: lines beginning with `#`, then one line for each row of the image, from the top.
//!
//! The keys are localised, so sizes and units are recognised by their form, as in exports of Keyence: the first two
//! lengths are width and height of the image, a unit alone is that of the values.

use files::input::quoted;

use super::numbers::{Numbers, Words, has_decimal_commas};
use super::{Format, Source, Surface, missing, shape, unit};
use crate::misread::{Misread, Place};

const ACCEPTED: &str = "an export of Gwyddion with its width, its height and one number for each pixel is expected";
/// Maximum number of key lines.
const MOST_KEYS: usize = 20;

/// Text exports of Gwyddion.
pub(super) struct GwyddionText;

impl Format for GwyddionText {
    fn name(&self) -> &'static str {
        "Gwyddion text"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["txt"]
    }

    fn recognises(&self, source: &Source) -> bool {
        let keys = Keys::read(&mut Words::new(source.bytes, 0, 1));
        keys.sizes.len() == 2
    }

    fn read(&self, source: &Source) -> Result<Surface, Misread> {
        let mut words = Words::new(source.bytes, 0, 1);
        read(&mut words, source.bytes).map_err(|found| Place::line(source.file, words.line).bad(found, ACCEPTED))
    }
}

/// Contents of the `#` lines.
#[derive(Default)]
struct Keys {
    /// Width and height [m].
    sizes: Vec<f64>,
    unit: Option<f64>,
    /// A unit of values that is not a unit of length.
    strange: Option<String>,
}

impl Keys {
    fn read(words: &mut Words) -> Self {
        let mut keys = Self::default();
        for _ in 0..MOST_KEYS {
            let mut ahead = words.peeked();
            let line = String::from_utf8_lossy(ahead.rest_of_line()).into_owned();
            let Some(line) = line.strip_prefix('#') else { break };
            *words = ahead;
            keys.set(line);
        }
        keys
    }

    fn set(&mut self, line: &str) {
        let Some((key, value)) = line.split_once(':') else { return };
        let value = value.trim();
        let (number, rest) = value.split_once(char::is_whitespace).unwrap_or((value, ""));
        let number = number.replace(',', ".").parse::<f64>().ok();
        match (number, unit::metres(rest), unit::metres(value)) {
            (Some(number), Some(unit), _) if self.sizes.len() < 2 => self.sizes.push(number * unit),
            (None, _, Some(unit)) => self.unit = Some(unit),
            _ if key.to_lowercase().contains("unit") => self.strange = Some(value.to_owned()),
            _ => {}
        }
    }
}

fn read(words: &mut Words, text: &[u8]) -> Result<Surface, String> {
    let keys = Keys::read(words);
    let [width, height] = keys.sizes[..] else { return Err("no width and height in the lines of #".to_owned()) };
    let unit = keys.unit.ok_or_else(|| match &keys.strange {
        Some(unit) => format!("values in {}, which is not a unit of length", quoted(unit)),
        None => "no unit of the values in the lines of #".to_owned(),
    })?;
    let mut heights = Vec::new();
    let mut ahead = words.peeked();
    let first_row = ahead.rest_of_line();
    let mut numbers = Numbers::new(has_decimal_commas(first_row));
    let nx = Words::new(first_row, 0, 1).count();
    heights.reserve(text.len() / 16);
    for word in words.by_ref() {
        let number = numbers.number(word);
        heights.push(number.ok_or_else(|| format!("{} is not a number", quoted(&String::from_utf8_lossy(word))))?);
    }
    let ny = heights.len().checked_div(nx).unwrap_or(0);
    if nx * ny != heights.len() {
        return Err(format!("{} numbers where the first row has {nx}", heights.len()));
    }
    shape::checked(nx as u64, ny as u64)?;
    let pitch = shape::pitch(width / nx as f64, height / ny as f64)?;
    let mut notes = vec![format!("Gwyddion export: {nx} x {ny} pixels, heights in {}", unit::name(unit))];
    notes.extend(numbers.notes());
    notes.extend(missing::clear(&mut heights, None));
    heights.iter_mut().for_each(|height| *height *= unit);
    let heights = shape::turned(heights, nx);
    Ok(Surface { format: GwyddionText.name(), nx, ny, pitch: Some(pitch), origin: None, heights, notes })
}
