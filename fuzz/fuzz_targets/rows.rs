//! The rows of a sound `table.toml`.

#![no_main]

use libfuzzer_sys::fuzz_target;
use robofin_fuzz::Folder;

fuzz_target!(|bytes: &[u8]| {
    Folder::table().survive("trials.csv", bytes);
});
