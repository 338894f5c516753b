//! Shared by the fuzz targets: a bound on memory, sound folders to damage, and the invariants of a mesh that was read.
//!
//! `docs/fuzzing.md` says how to run them.

mod trial_folder;

use std::alloc::System;

use cap::Cap;
use sdf_bake::Mesh;
use sdf_bake::read::{Format, UnitChoice, parse_mesh};

pub use trial_folder::Folder;

#[global_allocator]
static ALLOCATOR: Cap<System> = Cap::new(System, usize::MAX);

/// Memory that any input may use [bytes].
const FLOOR: usize = 4 << 20;

/// Makes this thread the only one, so that what is covered does not depend on which thread was faster.
pub fn on_one_thread() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread();
    pool.build_global().expect("the first thread pool");
}

/// Runs `work` with no more memory than [`FLOOR`] and `factor` bytes for each byte of the input.
///
/// An allocation beyond that ends the process, which libFuzzer reports with the input.
pub fn within_memory<T>(input: &[u8], factor: usize, work: impl FnOnce() -> T) -> T {
    let limit = ALLOCATOR.allocated() + FLOOR + factor * input.len();
    ALLOCATOR.set_limit(limit).expect("above what is allocated");
    let result = work();
    ALLOCATOR.set_limit(usize::MAX).expect("no limit");
    result
}

/// Reads a mesh; what comes out has indices in range and finite positions.
pub fn read(bytes: &[u8], format: Format) -> Option<Mesh> {
    let mesh = parse_mesh(bytes, format, UnitChoice::Auto, "part").ok()?.mesh;
    let vertices = mesh.positions.len();
    assert!(mesh.triangles.iter().flatten().all(|&vertex| (vertex as usize) < vertices));
    assert!(mesh.positions.iter().all(|position| position.is_finite()));
    Some(mesh)
}

/// The whole of a reader's target.
pub fn survive(bytes: &[u8], format: Format) {
    within_memory(bytes, 400, || read(bytes, format));
}
