//! WGSL kernels for graphics processors, the structs that they share with the program, and the device.
//!
//! A host file ([`sample`], [`simulate`], [`render`]) runs one or several kernels. The functions that a kernel calls
//! are WGSL files without bindings. Each has a CPU twin with the same order of operations, here ([`brick_grid`]) or in
//! the crate that runs the same step on the CPU; the WGSL file names it. The twin is the reference.
//!
//! Inside is negative, as everywhere; lengths are metres, coordinates in the grid are voxels.
//!
//! ```
//! use shaders::device::{self, BackendChoice};
//!
//! let opened = device::open(BackendChoice::Auto)?;
//! println!("{}", opened.decision.reason);
//! if let Some(device) = &opened.device {
//!     assert!(shaders::self_check(device).unwrap() < shaders::SELF_CHECK_LIMIT);
//! }
//! # Ok::<(), device::OpenError>(())
//! ```
//!
//! Modules in the order of the data: [`constants`] and [`layout`] are shared with WGSL, [`wgsl`] assembles the sources,
//! [`adapters`] lists the machine's adapters, [`choice`] picks one, [`device`] opens it, [`sample`] and [`simulate`]
//! run.
//!
//! This crate opens no file, looks for device nodes only by name, prints nothing outside [`testing`], and depends on no
//! other crate of the workspace: grids are passed as slices.

pub mod adapters;
pub mod brick_grid;
mod buffers;
pub mod choice;
pub mod constants;
pub mod device;
mod fault;
mod hardware;
pub mod layout;
pub mod render;
pub mod sample;
mod self_check;
pub mod simulate;
pub mod stage;
pub mod testing;
pub mod wgsl;

pub use brick_grid::{GridBuffers, GridError};
pub use device::Device;
pub use layout::GridHeader;
pub use render::{PartBuffers, PartChannels, RenderError, Renderer};
pub use sample::{SampleError, Sampler};
pub use self_check::{SELF_CHECK_LIMIT, self_check};
pub use stage::RenderStage;
