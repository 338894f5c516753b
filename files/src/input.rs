//! Opening of all files that a user or a file names: only regular files up to a stated size.
//!
//! A device, a pipe or a file of `/proc` may be endless, and an error message may reveal content that its reader must
//! not see. So nothing is read beyond the length reported by the file system, and [`quoted`] decides how much content
//! an error repeats.

use std::fs::{File, Metadata};
use std::io::Read;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// Maximum number of bytes of a mesh or a field: 43 million triangles of a binary STL, more than the memory of the
/// intended machines holds as a `Mesh`.
pub const MOST_MESH_BYTES: u64 = 2 << 30;
/// Maximum number of bytes of a table or map: a map of 2²⁸ / 4 pixels of 16 characters.
pub const MOST_TABLE_BYTES: u64 = 1 << 30;
/// Maximum number of bytes of a text written by people or listing files: thousands of times the largest in use.
pub const MOST_TEXT_BYTES: u64 = 256 << 20;

/// Maximum number of characters of a quoted number: `f64` needs no more.
const NUMBER: usize = 24;
/// Maximum number of letters of a quoted word, such as `nan` or `missing`.
const WORD: usize = 8;
/// A word may have one typing error for each of this many letters.
const SLIPS: usize = 4;
/// Maximum number of characters of a quoted line.
const LINE: usize = 60;

/// Error of a file that cannot be read.
#[derive(Debug, Error)]
pub enum InputError {
    /// An operation of the file system failed.
    #[error("{}: cannot be read: {source}", path.display())]
    Io {
        /// The requested file.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// A folder, device, pipe or socket.
    #[error("{}: is {found}, and a regular file is accepted", path.display())]
    NotRegular {
        /// The requested path.
        path: PathBuf,
        /// Kind of the object in words.
        found: &'static str,
    },
    /// Too many bytes for such a file.
    #[error("{}: has {bytes} bytes, and at most {most} are accepted", path.display())]
    TooLarge {
        /// The requested file.
        path: PathBuf,
        /// Its length.
        bytes: u64,
        /// Maximum length.
        most: u64,
    },
    /// More bytes than the file system reports, as in files of `/proc`.
    #[error("{}: has more than the {bytes} bytes that the file system says; a file of fixed length is accepted", path.display())]
    Endless {
        /// The requested file.
        path: PathBuf,
        /// Length reported by the file system.
        bytes: u64,
    },
    /// Not a text.
    #[error("{}: byte {byte} is not UTF-8; a text is accepted", path.display())]
    NotText {
        /// The requested file.
        path: PathBuf,
        /// First byte that is not valid UTF-8, from 0.
        byte: usize,
    },
}

/// Reads the bytes of a regular file of at most `most` bytes.
///
/// # Errors
/// [`InputError`]
pub fn read(path: &Path, most: u64) -> Result<Vec<u8>, InputError> {
    let (mut file, bytes) = open(path, most)?;
    rest_of(&mut file, path, bytes)
}

/// As [`read`], but `refused` checks the length and the first bytes, at most `head` of them, before the rest is read.
///
/// # Errors
/// The error that `refused` returns, or [`InputError`].
pub fn read_checked<E: From<InputError>>(
    path: &Path,
    (most, head): (u64, usize),
    refused: impl Fn(&[u8], u64) -> Result<(), E>,
) -> Result<Vec<u8>, E> {
    let (mut file, bytes) = open(path, most)?;
    let mut first = Vec::new();
    let start = Read::by_ref(&mut file).take((head as u64).min(bytes)).read_to_end(&mut first);
    start.map_err(|source| InputError::Io { path: path.to_owned(), source })?;
    refused(&first, bytes)?;
    let rest = rest_of(&mut file, path, bytes - first.len() as u64)?;
    first.extend(rest);
    Ok(first)
}

/// Reads the text of a regular file of at most `most` bytes.
///
/// # Errors
/// [`InputError`]
pub fn read_text(path: &Path, most: u64) -> Result<String, InputError> {
    let text = String::from_utf8(read(path, most)?);
    text.map_err(|error| InputError::NotText { path: path.to_owned(), byte: error.utf8_error().valid_up_to() })
}

fn open(path: &Path, most: u64) -> Result<(File, u64), InputError> {
    let io = |source| InputError::Io { path: path.to_owned(), source };
    let check = |data: &Metadata| match not_regular(data) {
        Some(found) => Err(InputError::NotRegular { path: path.to_owned(), found }),
        None if data.len() > most => Err(InputError::TooLarge { path: path.to_owned(), bytes: data.len(), most }),
        None => Ok(data.len()),
    };
    // Checked before opening, because opening a pipe waits for its other end; and again afterwards, because the file
    // may have been replaced in between.
    check(&path.metadata().map_err(io)?)?;
    let file = File::open(path).map_err(io)?;
    let bytes = check(&file.metadata().map_err(io)?)?;
    Ok((file, bytes))
}

fn rest_of(file: &mut File, path: &Path, bytes: u64) -> Result<Vec<u8>, InputError> {
    let mut read = Vec::new();
    let done = file.take(bytes + 1).read_to_end(&mut read);
    done.map_err(|source| InputError::Io { path: path.to_owned(), source })?;
    if read.len() as u64 > bytes {
        return Err(InputError::Endless { path: path.to_owned(), bytes });
    }
    Ok(read)
}

fn not_regular(data: &Metadata) -> Option<&'static str> {
    if data.is_file() {
        return None;
    }
    if data.is_dir() {
        return Some("a folder");
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        let kind = data.file_type();
        if kind.is_fifo() {
            return Some("a pipe");
        }
        if kind.is_socket() {
            return Some("a socket");
        }
        if kind.is_char_device() || kind.is_block_device() {
            return Some("a device");
        }
    }
    Some("no file")
}

/// The part of a file's text that an error may repeat: a number or a short word in quotation marks. For anything else,
/// a statement that it is text, and its length.
pub fn quoted(text: &str) -> String {
    if is_quotable(text) { format!("{text:?}") } else { measured(text) }
}

/// As [`quoted`], for a word with a possible typing error: a word close to an expected one is quoted, too.
pub fn quoted_near<'a>(text: &str, expected: impl IntoIterator<Item = &'a str>) -> String {
    let is_near = |word: &str| {
        let slips = (word.len() / SLIPS).max(1);
        text.len() <= word.len() + slips && strsim::osa_distance(text, word) <= slips
    };
    if is_quotable(text) || expected.into_iter().any(is_near) { format!("{text:?}") } else { measured(text) }
}

/// Maximum number of names that [`quoted_names`] shows.
const MOST_NAMES: usize = 20;

/// As [`quoted_near`], for the names of a header; only the first ones if there are many, and the number of the others.
pub fn quoted_names<'a>(names: &[String], expected: impl IntoIterator<Item = &'a str> + Clone) -> String {
    let shown = names.iter().take(MOST_NAMES).map(|name| quoted_near(name, expected.clone()));
    let shown = shown.collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(MOST_NAMES) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// As [`quoted`], for a line: a keyword and numbers, one of which may be invalid.
pub fn quoted_line(line: &str) -> String {
    let line = line.trim();
    let words = || line.split_whitespace();
    let is_number = |word: &&str| word.parse::<f64>().is_ok();
    let names = words().skip(1).filter(|word| !is_number(word)).count();
    let is_short = line.len() <= LINE && words().all(is_quotable) && names <= 1;
    if is_short { format!("`{line}`") } else { measured(line) }
}

/// A statement that it is text, and its length.
pub fn measured(text: &str) -> String {
    format!("text of {} characters", text.chars().count())
}

fn is_quotable(text: &str) -> bool {
    let is_number = |c: char| c.is_ascii_digit() || "+-.,eE".contains(c);
    let is_word = |c: char| c.is_ascii_alphabetic() || c == '/';
    (text.len() <= NUMBER && text.chars().all(is_number)) || (text.len() <= WORD && text.chars().all(is_word))
}

/// Removes from the message of a TOML or JSON reader the parts that repeat content.
///
/// Those readers put the text found into quotation marks or between backticks: `invalid type: string "...", expected`.
/// The expected type comes after that and is kept.
pub fn without_content(message: &str) -> String {
    // It names a field that is not in the file.
    if message.starts_with("missing field") {
        return message.to_owned();
    }
    let (found, expected) = match message.find(", expected") {
        Some(at) => message.split_at(at),
        None => (message, ""),
    };
    let mut shown = String::new();
    let mut rest = found;
    while let Some(start) = rest.find(['"', '`']) {
        let mark = &rest[start..=start];
        let end = rest.rfind(mark).filter(|&end| end > start).unwrap_or(rest.len());
        shown += &rest[..start];
        shown += &quoted(&rest[start + 1..end]);
        rest = rest.get(end + 1..).unwrap_or_default();
    }
    shown + rest + expected
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_short_words_are_quoted_and_nothing_else() {
        for text in ["", "-1.5e-3", "1,5", "nan", "n/a", "maybe"] {
            assert_eq!(quoted(text), format!("{text:?}"));
        }
        for text in ["root:x:0:0", "hunter2", "correct horse", "0123456789abcdef", "passphrase", "é", &"1".repeat(300)]
        {
            assert_eq!(quoted(text), format!("text of {} characters", text.chars().count()));
        }
        assert_eq!(quoted_near("force_setpoint", ["force_setpoint_n"]), "\"force_setpoint\"");
        assert_eq!(quoted_near("admin_password", ["force_setpoint_n"]), "text of 14 characters");
        let names: Vec<String> = (0..1000).map(|k| format!("column_{k}")).collect();
        let header = ["admin_password".to_owned(), "column_1".to_owned()];
        assert_eq!(quoted_names(&header, ["column_1"]), "text of 14 characters, \"column_1\"");
        let many = quoted_names(&names, []);
        assert!(many.ends_with(" and 980 more") && many.len() < 1000, "{many}");
        assert_eq!(quoted_line(" v 1 zero 0 "), "`v 1 zero 0`");
        assert_eq!(quoted_line("f correct horse battery"), "text of 23 characters");
        assert_eq!(quoted_line("v 1 root:x 0"), "text of 12 characters");
    }

    #[test]
    fn messages_of_readers_keep_what_they_expect() {
        for (message, shown) in [
            (
                "invalid type: string \"top secret\", expected f64",
                "invalid type: string text of 10 characters, expected f64",
            ),
            ("unknown variant `griding`, expected `grinding`", "unknown variant \"griding\", expected `grinding`"),
            (
                "invalid type: string \"a \\\" b: c\", expected u8",
                "invalid type: string text of 9 characters, expected u8",
            ),
            ("duplicate key `pass word`", "duplicate key text of 9 characters"),
            ("expected value at line 1 column 1", "expected value at line 1 column 1"),
        ] {
            assert_eq!(without_content(message), shown);
        }
    }

    #[cfg(unix)]
    #[test]
    fn only_regular_files_are_read_and_none_beyond_its_length() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("text"), "text").unwrap();
        std::os::unix::fs::symlink(at("round"), at("round")).unwrap();
        std::os::unix::fs::symlink("/dev/zero", at("zero.stl")).unwrap();
        let _socket = std::os::unix::net::UnixListener::bind(at("socket")).unwrap();
        assert!(std::process::Command::new("mkfifo").arg(at("pipe")).status().unwrap().success());
        let said = |path: &Path| read(path, 10).map(|_| ()).unwrap_err().to_string();
        assert_eq!(read(&at("text"), 4).unwrap(), b"text");
        assert!(read(&at("text"), 3).unwrap_err().to_string().contains("has 4 bytes, and at most 3"));
        for (path, words) in [
            (at("round"), "cannot be read"),
            (at("zero.stl"), "is a device"),
            (at("socket"), "is a socket"),
            (at("pipe"), "is a pipe"),
            (folder.path().to_owned(), "is a folder"),
        ] {
            assert!(said(&path).contains(words), "{} for {}", said(&path), path.display());
        }
        #[cfg(target_os = "linux")]
        assert!(said(Path::new("/proc/self/status")).contains("more than the 0 bytes"));
    }
}
