#![no_main]

use libfuzzer_sys::fuzz_target;
use sdf_bake::read::Format;

fuzz_target!(|bytes: &[u8]| robofin_fuzz::survive(bytes, Format::Ply));
