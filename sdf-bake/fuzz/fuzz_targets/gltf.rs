#![no_main]

use libfuzzer_sys::fuzz_target;
use sdf_bake::read::Format;

fuzz_target!(|bytes: &[u8]| sdf_bake_fuzz::survive(bytes, Format::Gltf));
