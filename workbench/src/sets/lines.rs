//! Files with one line of JSON for each item.

use std::path::Path;

use files::input::{self, MOST_TEXT_BYTES};
use serde::de::DeserializeOwned;

/// Greatest number of faults that are listed.
const MOST_FAULTS: usize = 20;

/// Items of a file, and what cannot be read in it.
pub(super) struct Lines<T> {
    /// Items in the order of the file.
    pub(super) items: Vec<T>,
    /// Faults, each with the file's name and the line's number.
    pub(super) faults: Vec<String>,
}

/// Reads a file of a set; one that does not exist is a fault.
pub(super) fn read<T: DeserializeOwned>(folder: &Path, name: &str) -> Lines<T> {
    match input::read_text(&folder.join(name), MOST_TEXT_BYTES) {
        Ok(text) => parsed(&text, name),
        Err(error) => Lines { items: Vec::new(), faults: vec![error.to_string()] },
    }
}

fn parsed<T: DeserializeOwned>(text: &str, name: &str) -> Lines<T> {
    let (mut items, mut faults, mut more) = (Vec::new(), Vec::new(), 0);
    for (number, line) in (1..).zip(text.lines()).filter(|(_, line)| !line.trim().is_empty()) {
        match serde_json::from_str(line) {
            Ok(item) => items.push(item),
            Err(error) if faults.len() < MOST_FAULTS => {
                faults.push(format!("{name}, line {number}: {}", input::without_content(&error.to_string())));
            }
            Err(_) => more += 1,
        }
    }
    if more > 0 {
        faults.push(format!("{name}: {more} more lines cannot be read"));
    }
    Lines { items, faults }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_broken_line_is_named_and_the_others_are_read() {
        let broken = "[1\n".repeat(MOST_FAULTS + 2);
        let lines: Lines<[u8; 1]> = parsed(&format!("[1]\n\n{broken}[2]\n"), "a.jsonl");
        assert_eq!(lines.items, [[1], [2]]);
        assert!(lines.faults[0].starts_with("a.jsonl, line 3:"), "{:?}", lines.faults);
        assert_eq!(lines.faults.last().unwrap(), "a.jsonl: 2 more lines cannot be read");
    }
}
