//! Numbers and words that mean a missing height.

use std::collections::BTreeMap;

/// Numbers that mean a missing height: of ESRI grids, of 16-bit integers. No scan is metres deep.
const NUMBERS: [f64; 5] = [-9999.0, -99999.0, 9999.0, 99999.0, -32768.0];
/// Magnitude from which a number is not a height: Surfer writes 1.70141e38, others 1e38.
const TOO_LARGE: f64 = 1e37;

/// Maximum number of words that are counted separately.
const MOST_WORDS: usize = 8;

/// True if a word in place of a number means a missing value.
pub(super) fn is_word(word: &[u8]) -> bool {
    let known: [&[u8]; 11] =
        [b"bad", b"nan", b"-nan", b"inf", b"-inf", b"infinity", b"none", b"null", b"n/a", b"na", b"nodata"];
    let marks = word.iter().all(|c| b"*-#".contains(c));
    word.is_empty() || marks || known.iter().any(|one| word.eq_ignore_ascii_case(one))
}

/// Number of cells with each word for a missing height.
#[derive(Default)]
pub(super) struct Counts(BTreeMap<String, usize>);

impl Counts {
    /// Counts a cell; after the first few words all others are counted together.
    pub(super) fn add(&mut self, word: String) {
        let is_kept = self.0.contains_key(&word) || self.0.len() < MOST_WORDS;
        *self.0.entry(if is_kept { word } else { "another word".to_owned() }).or_default() += 1;
    }

    /// A sentence for each word.
    pub(super) fn notes(&self) -> impl Iterator<Item = String> {
        self.0.iter().map(|(word, count)| said(*count, word))
    }
}

/// Replaces the numbers that instruments write for missing heights by NaN.
///
/// `own` is the code stated in the file. Returns a sentence for each number found.
pub(super) fn clear(heights: &mut [f64], own: Option<f64>) -> Vec<String> {
    let mut found = Counts::default();
    for height in heights.iter_mut().filter(|height| !height.is_nan()) {
        if Some(*height) == own || NUMBERS.contains(height) || height.abs() >= TOO_LARGE {
            found.add(format!("{height:?}"));
            *height = f64::NAN;
        }
    }
    found.notes().collect()
}

/// A sentence with the number of cells that hold a word for a missing height.
pub(super) fn said(count: usize, word: &str) -> String {
    format!("{count} cells say {word}: read as missing")
}
