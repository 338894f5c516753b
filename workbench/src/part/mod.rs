//! The workpiece: drawn from its field, read at a place, cut along a line.

mod camera;
mod paint;
mod picture;
mod probe;
mod section;
mod surfaces;

pub(crate) use picture::{Asked, Looked, drawn};
pub(crate) use probe::probed;
pub(crate) use section::{Line, section};
pub(crate) use surfaces::Surfaces;
