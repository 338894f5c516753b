//! The scan before the first pass of a sound trial: a grid of text, an export, X3P or a surface mesh.

#![no_main]

use libfuzzer_sys::fuzz_target;
use robofin_fuzz::Folder;

fuzz_target!(|bytes: &[u8]| {
    Folder::grinding().survive("before.csv", bytes);
});
