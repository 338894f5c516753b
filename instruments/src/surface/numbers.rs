//! Numbers in text, and words in their place.

use files::input::quoted;

use super::missing;

/// Words and lines of a text.
pub(super) struct Words<'a> {
    text: &'a [u8],
    at: usize,
    /// Line of the last word returned, from 1.
    pub(super) line: u64,
}

impl<'a> Words<'a> {
    /// The words of a text from byte `at` on, which is on a line numbered from 1.
    pub(super) fn new(text: &'a [u8], at: usize, line: u64) -> Self {
        Self { text, at, line }
    }

    /// A copy that reads on from the same position without advancing this one.
    pub(super) fn peeked(&self) -> Self {
        Self { ..*self }
    }

    /// The rest of the line; advances to the next.
    pub(super) fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = &self.text[self.at..];
        let end = rest.iter().position(|&c| c == b'\n').unwrap_or(rest.len());
        self.at = (self.at + end + 1).min(self.text.len());
        self.line += 1;
        rest[..end].trim_ascii()
    }

    /// True if the last word is terminated; it is not if writing was interrupted.
    pub(super) fn ends_with_a_line(&self) -> bool {
        self.text.last().is_some_and(u8::is_ascii_whitespace)
    }

    /// True if only white space is left.
    pub(super) fn is_done(&self) -> bool {
        self.text[self.at..].iter().all(u8::is_ascii_whitespace)
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = &self.text[self.at..];
        let start = rest.iter().position(|c| !c.is_ascii_whitespace())?;
        self.line += rest[..start].iter().filter(|&&c| c == b'\n').count() as u64;
        let word = &rest[start..];
        let end = word.iter().position(u8::is_ascii_whitespace).unwrap_or(word.len());
        self.at += start + end;
        Some(&word[..end])
    }
}

/// Converts words to numbers, and counts those that mean a missing value.
#[derive(Default)]
pub(super) struct Numbers {
    /// True if decimals are written with commas.
    pub(super) decimal_comma: bool,
    missing: missing::Counts,
}

impl Numbers {
    /// Numbers whose decimals are written with commas, or with points.
    pub(super) fn new(decimal_comma: bool) -> Self {
        Self { decimal_comma, ..Self::default() }
    }

    /// The number of a word, NaN for a word that means a missing value, `None` for any other.
    pub(super) fn number(&mut self, word: &[u8]) -> Option<f64> {
        let word = word.trim_ascii();
        let parsed = match std::str::from_utf8(word) {
            Ok(text) if self.decimal_comma => text.replace(',', ".").parse().ok(),
            Ok(text) => text.parse().ok(),
            Err(_) => None,
        };
        match parsed {
            Some(number) if f64::is_finite(number) => Some(number),
            None if !missing::is_word(word) => None,
            _ => {
                let name = if word.is_empty() { "nothing".to_owned() } else { quoted(&String::from_utf8_lossy(word)) };
                self.missing.add(name);
                Some(f64::NAN)
            }
        }
    }

    /// A sentence for each word found in place of a number.
    pub(super) fn notes(&self) -> impl Iterator<Item = String> {
        self.missing.notes()
    }
}

/// True if commas occur between digits of words with another separator, as in "1,5 2,5".
pub(super) fn has_decimal_commas(text: &[u8]) -> bool {
    let between_digits = |w: &[u8]| w[0].is_ascii_digit() && w[1] == b',' && w[2].is_ascii_digit();
    text.windows(3).any(between_digits) && !text.contains(&b'.')
}
