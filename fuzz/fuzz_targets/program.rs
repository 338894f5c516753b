//! A robot's program in any language.

#![no_main]

use std::path::Path;

use instruments::program::{ReadOptions, read};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Err(error) = read(Path::new("program"), bytes, &ReadOptions::default()) {
        assert!(error.to_string().len() <= 2000, "{error}");
    }
});
