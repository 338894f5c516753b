//! A height map in any format; the first byte says what its file is called.

#![no_main]

use std::path::Path;

use instruments::surface::{Source, Window, extensions, read};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Some((first, bytes)) = bytes.split_first() else { return };
    let all: Vec<&str> = extensions().flat_map(|(_, extensions)| extensions.iter().copied()).collect();
    let name = format!("scan.{}", all[usize::from(*first) % all.len()]);
    if let Err(error) = read(&Source { file: Path::new(&name), bytes, window: Window::default() }) {
        assert!(error.to_string().len() <= 2000, "{error}");
    }
});
