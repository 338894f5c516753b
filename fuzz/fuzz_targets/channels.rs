//! A log in any format, and what its channels may be.

#![no_main]

use std::path::Path;

use instruments::log::{guess, read};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| match read(Path::new("log"), bytes) {
    Ok(channels) => drop(guess(&channels)),
    Err(error) => assert!(error.to_string().len() <= 2000, "{error}"),
});
