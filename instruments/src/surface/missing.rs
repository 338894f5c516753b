//! Numbers and words that stand for a height that was not measured.

use std::collections::BTreeMap;

/// Numbers that stand for a missing height: of ESRI grids, of 16-bit integers. No scan is metres deep.
const NUMBERS: [f64; 5] = [-9999.0, -99999.0, 9999.0, 99999.0, -32768.0];
/// Size from which a number is none of a height: Surfer writes 1.70141e38, others 1e38.
const TOO_LARGE: f64 = 1e37;

/// True if a word in place of a number says that nothing was measured.
pub(super) fn is_word(word: &[u8]) -> bool {
    let known: [&[u8]; 11] =
        [b"bad", b"nan", b"-nan", b"inf", b"-inf", b"infinity", b"none", b"null", b"n/a", b"na", b"nodata"];
    let marks = word.iter().all(|c| b"*-#".contains(c));
    word.is_empty() || marks || known.iter().any(|one| word.eq_ignore_ascii_case(one))
}

/// Takes the numbers that instruments write where they saw nothing as missing.
///
/// `own` is the code that the file itself states. Returns a sentence for each number that was found.
pub(super) fn clear(heights: &mut [f64], own: Option<f64>) -> Vec<String> {
    let mut found = BTreeMap::new();
    for height in heights.iter_mut().filter(|height| !height.is_nan()) {
        if Some(*height) == own || NUMBERS.contains(height) || height.abs() >= TOO_LARGE {
            *found.entry(height.to_bits()).or_insert(0_usize) += 1;
            *height = f64::NAN;
        }
    }
    found.into_iter().map(|(bits, count)| said(count, &format!("{:?}", f64::from_bits(bits)))).collect()
}

/// The sentence that so many cells hold a word for a missing height.
pub(super) fn said(count: usize, word: &str) -> String {
    format!("{count} cells say {word}: read as missing")
}
