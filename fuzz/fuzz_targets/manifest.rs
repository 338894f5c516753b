//! `trial.toml` of a grinding or a sanding trial, or `table.toml`, by the first byte; the files that it names are sound.

#![no_main]

use libfuzzer_sys::fuzz_target;
use robofin_fuzz::Folder;

fuzz_target!(|input: &[u8]| {
    let Some((way, rest)) = input.split_first() else { return };
    match way % 3 {
        0 => Folder::grinding().survive("trial.toml", rest),
        1 => Folder::sanding().survive("trial.toml", rest),
        _ => Folder::table().survive("table.toml", rest),
    }
});
