//! From a CAD mesh to a signed distance field.
//!
//! Everything is in SI units, in the part's right-handed frame with z up; inside is negative.
//! This crate shows no progress and never prints.

pub mod clean;
pub mod grid;
mod implicit;
pub mod mesh;
pub mod read;

pub use grid::BrickGrid;
pub use mesh::Mesh;
