//! A model file: what is read can be compiled, or is refused.

#![no_main]

use libfuzzer_sys::fuzz_target;
use robofin_fuzz::{on_one_thread, within_memory};
use effects::{CompiledModel, Library, Model, RowCounts};

/// Bytes for each byte of a file: an effect named in twenty bytes compiles to a program of kilobytes.
const FACTOR: usize = 4000;

fuzz_target!(init: { on_one_thread(); Library::builtin(); }, |bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    within_memory(bytes, FACTOR, || {
        let Ok(model) = Model::parse("model.toml", text, Library::builtin()) else { return };
        let _ = CompiledModel::new(&model, Library::builtin(), RowCounts { passes: 3, scans: 3 });
    });
});
