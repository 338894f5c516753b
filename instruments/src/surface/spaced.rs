//! Tables with cells separated by spaces, and comments above a table, as NumPy writes them.

use std::borrow::Cow;

use super::Source;
use super::numbers::Numbers;
use crate::misread::Misread;
use crate::text_table::TextTable;

/// Number of lines for detection.
const SAMPLE: usize = 50;

/// Parses a table after replacing runs of spaces between numbers by one tab and removing comments above.
///
/// # Errors
/// [`Misread`] if it is not a text.
pub(super) fn table<'a>(source: &Source<'a>) -> Result<TextTable<'a>, Misread> {
    let comments = comments(source.bytes);
    let is_spaced = is_spaced(source.bytes);
    let text: Cow<[u8]> = match (is_spaced, comments) {
        (false, 0) => source.bytes.into(),
        (false, _) => without_comments(source.bytes, comments).into(),
        (true, _) => with_tabs(&without_comments(source.bytes, comments)).into(),
    };
    let mut table = TextTable::parse(source.file, text)?;
    if is_spaced {
        table.notes.retain(|note| !note.contains("tabs"));
        table.notes.push("cells are separated by blanks; mm are assumed".to_owned());
    }
    Ok(table)
}

/// Length of the comments above a table [bytes].
fn comments(text: &[u8]) -> usize {
    let lines = text.split_inclusive(|&c| c == b'\n');
    lines.take_while(|line| line.starts_with(b"#") || line.starts_with(b"%")).map(<[u8]>::len).sum()
}

/// The same lines, with the comments emptied.
fn without_comments(text: &[u8], comments: usize) -> Vec<u8> {
    let lines = text[..comments].iter().filter(|&&c| c == b'\n').count();
    let mut kept = vec![b'\n'; lines];
    kept.extend(&text[comments..]);
    kept
}

/// True if the first lines below comments consist only of numbers separated by spaces.
pub(super) fn is_spaced(text: &[u8]) -> bool {
    let text = &text[comments(text)..];
    let lines = || text.split(|&c| c == b'\n').map(<[u8]>::trim_ascii).filter(|line| !line.is_empty()).take(SAMPLE);
    let is_row = |line: &[u8]| {
        let mut numbers = Numbers::new(line.contains(&b','));
        let words = || line.split(|&c| c == b' ').filter(|word| !word.is_empty());
        words().count() > 1 && words().all(|word| numbers.number(word).is_some())
    };
    lines().next().is_some()
        && !lines().any(|line| line.contains(&b';') || line.contains(&b'\t'))
        && lines().all(is_row)
}

/// Replaces runs of spaces by one tab.
fn with_tabs(text: &[u8]) -> Vec<u8> {
    let mut tabbed = Vec::with_capacity(text.len());
    for line in text.split_inclusive(|&c| c == b'\n') {
        let end = line.trim_ascii_end().len();
        let words = line[..end].split(|&c| c == b' ').filter(|word| !word.is_empty());
        for (at, word) in words.enumerate() {
            tabbed.extend_from_slice(if at > 0 { b"\t" } else { b"" });
            tabbed.extend_from_slice(word);
        }
        tabbed.extend_from_slice(&line[end..]);
    }
    tabbed
}
