//! A robot log in a sound trial.

#![no_main]

use libfuzzer_sys::fuzz_target;
use robofin_fuzz::Folder;

fuzz_target!(|bytes: &[u8]| {
    Folder::grinding().survive("pass1_log.csv", bytes);
});
