//! Files as scanners and robots write them: what stands in them, in SI, before anybody says what it means.
//!
//! 1. [`surface`] reads and writes height maps: exports of instruments, grids, meshes.
//! 2. [`log`] reads what robots and sensors reported row by row, and guesses which channel is what.
//! 3. [`program`] reads and writes the tool paths of machines and robots.
//! 4. [`text_table`] reads rows of cells whatever separates them.
//!
//! A [`Misread`] tells the place in the file, what was found, and what would be accepted.

pub mod log;
mod misread;
pub mod program;
pub mod surface;
pub mod text_table;

pub use misread::{Misread, Place};
