//! Numbers in text, and the words that stand in their place.

use files::input::quoted;

use super::missing;

/// Words and lines of a text.
pub(super) struct Words<'a> {
    text: &'a [u8],
    at: usize,
    /// Line of the word that was given last, from 1.
    pub(super) line: u64,
}

impl<'a> Words<'a> {
    /// The words of a text from a byte on, which lies on a line from 1.
    pub(super) fn new(text: &'a [u8], at: usize, line: u64) -> Self {
        Self { text, at, line }
    }

    /// Reading on from the same place without moving on here.
    pub(super) fn peeked(&self) -> Self {
        Self { ..*self }
    }

    /// The rest of the line, and moves to the next.
    pub(super) fn rest_of_line(&mut self) -> &'a [u8] {
        let rest = &self.text[self.at..];
        let end = rest.iter().position(|&c| c == b'\n').unwrap_or(rest.len());
        self.at = (self.at + end + 1).min(self.text.len());
        self.line += 1;
        rest[..end].trim_ascii()
    }

    /// True if the last word is ended, as it is not where writing was cut short.
    pub(super) fn ends_with_a_line(&self) -> bool {
        self.text.last().is_some_and(u8::is_ascii_whitespace)
    }

    /// True if nothing but blanks is left.
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

/// Makes numbers of words and counts those that say that nothing was measured.
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

    /// The number that a word writes, NaN for a word that says that nothing was measured, `None` for any other.
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

    /// A sentence for each word in place of a number.
    pub(super) fn notes(&self) -> impl Iterator<Item = String> {
        self.missing.notes()
    }
}

/// True if commas stand between digits of words that are separated otherwise, as in "1,5 2,5".
pub(super) fn has_decimal_commas(text: &[u8]) -> bool {
    let between_digits = |w: &[u8]| w[0].is_ascii_digit() && w[1] == b',' && w[2].is_ascii_digit();
    text.windows(3).any(between_digits) && !text.contains(&b'.')
}
