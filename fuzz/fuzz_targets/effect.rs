//! An effect's file: what passes the check compiles in a model of each process in which it acts, and is written as WGSL.

#![no_main]

use libfuzzer_sys::fuzz_target;
use robofin_fuzz::{on_one_thread, within_memory};
use effects::{CompiledModel, Kind, Library, Model, Process, RowCounts, check_file};

/// Bytes for each byte of a file: the library is copied, and a formula becomes a graph and a program.
const FACTOR: usize = 20_000;

fuzz_target!(init: { on_one_thread(); Library::builtin(); }, |bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    within_memory(bytes, FACTOR, || survive(text));
});

fn survive(text: &str) {
    let Ok(effect) = check_file("mine.toml", text) else { return };
    if effect.kind == Kind::Law {
        return;
    }
    // A name that the library has is refused here, and nowhere else.
    let Ok(library) = Library::builtin().with(&[("mine.toml".to_owned(), text.to_owned())]) else { return };
    for process in [Process::Grinding, Process::Sanding].into_iter().filter(|process| effect.acts_in(*process)) {
        let _ = CompiledModel::new(&Model::new(process).with(&effect.name), &library, RowCounts::default());
    }
}
