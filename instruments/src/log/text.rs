//! Decoding of a log's text in any encoding, and its lines with any line ends.

use std::borrow::Cow;
use std::path::Path;

use crate::misread::{Misread, Place};

/// Maximum number of bytes of a line.
const LONGEST_LINE: usize = 1 << 20;

/// Text of a file, and notes on its encoding.
pub(crate) fn decode<'a>(file: &Path, bytes: &'a [u8]) -> Result<(Cow<'a, str>, Vec<String>), Misread> {
    const ACCEPTED: &str = "a log in text is expected";
    let mut notes = Vec::new();
    let text = match bytes {
        [0xff, 0xfe, rest @ ..] => utf16(rest, u16::from_le_bytes, &mut notes),
        [0xfe, 0xff, rest @ ..] => utf16(rest, u16::from_be_bytes, &mut notes),
        [0xef, 0xbb, 0xbf, rest @ ..] => eight_bits(rest, &mut notes),
        _ => eight_bits(bytes, &mut notes),
    };
    if text.trim().is_empty() {
        return Err(Place::file(file).bad("the file is empty", ACCEPTED));
    }
    // The end-of-file character of DOS is the only other control character in texts.
    let odd = |c: char| c.is_ascii_control() && !"\t\r\n\u{c}\u{1a}".contains(c);
    if let Some(at) = text.find(odd) {
        let found = format!("the control character {:?}", text[at..].chars().next().unwrap_or_default());
        return Err(Place::of_byte(file, &text, at).bad(found, ACCEPTED));
    }
    Ok((text, notes))
}

fn utf16<'a>(bytes: &[u8], unit: fn([u8; 2]) -> u16, notes: &mut Vec<String>) -> Cow<'a, str> {
    notes.push("the text is UTF-16".to_owned());
    let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    Cow::Owned(char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect())
}

fn eight_bits<'a>(bytes: &'a [u8], notes: &mut Vec<String>) -> Cow<'a, str> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => {
            notes.push("the text is not UTF-8 and is read as Latin-1".to_owned());
            Cow::Owned(bytes.iter().map(|&byte| char::from(byte)).collect())
        }
    }
}

/// Lines without their ends, numbered from 1.
pub(crate) fn lines(text: &str) -> impl Iterator<Item = (u64, &str)> {
    let end = if text.contains('\n') { '\n' } else { '\r' };
    let trim = |line| str::trim_end_matches(line, ['\r', '\u{1a}', '\u{c}']);
    text.split(end).enumerate().map(move |(k, line)| (k as u64 + 1, trim(line)))
}

/// Refuses lines longer than in any log.
pub(super) fn check_lines(file: &Path, text: &str) -> Result<(), Misread> {
    match lines(text).find(|(_, line)| line.len() > LONGEST_LINE) {
        Some((number, line)) => {
            let found = format!("a line of {} bytes", line.len());
            Err(Place::line(file, number).bad(found, format!("lines of at most {LONGEST_LINE} bytes are expected")))
        }
        None => Ok(()),
    }
}
