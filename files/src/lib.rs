//! Files that are read with limits and written completely or not at all. This crate does not know their content.
//!
//! 1. [`input`] opens only regular files, of a limited size; [`json_file`] reads JSON, and [`named_file`] finds the
//!    files that a manifest names, within its folder.
//! 2. [`output`] decides what a command may replace, and [`folder`] writes beside the final path and renames
//!    (`staging`).
//! 3. [`file_lock`], [`job_queue`] and [`room`] share work among threads and processes; [`journal`] stores finished
//!    work for a run that continues after an interruption; [`program`] gives the command that starts another process.
//!
//! This crate never prints and never chooses a path by itself.

pub mod budget;
mod error;
pub mod file_lock;
pub mod folder;
pub mod input;
pub mod job_queue;
pub mod journal;
pub mod json_file;
pub mod named_file;
pub mod output;
pub mod program;
mod staging;

pub use error::{FileError, WrongUse};
pub use staging::remove_all;

use sha2::{Digest, Sha256};

/// The SHA-256 of bytes, in hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
