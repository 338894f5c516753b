//! Readers of the files of scanners and robots: contents in SI, without interpretation.
//!
//! 1. [`surface`] reads and writes height maps: exports of instruments, grids, meshes.
//! 2. [`log`] reads the rows that robots and sensors report, and guesses the quantity of each channel.
//! 3. [`program`] reads and writes the tool paths of machines and robots.
//! 4. [`text_table`] reads rows of cells with any separator.
//!
//! A [`Misread`] gives the place in the file, the content found, and the content accepted.

pub mod log;
mod misread;
pub mod program;
pub mod surface;
pub mod text_table;

pub use misread::{Misread, Place};
