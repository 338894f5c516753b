//! From a CAD mesh to a signed distance field.
//!
//! Everything is in SI units, in the part's right-handed frame with z up; inside is negative.
//! This crate shows no progress and never prints.

pub mod bake;
mod bounds;
pub mod clean;
pub mod grid;
mod grow;
pub mod halo;
mod implicit;
pub mod mesh;
pub mod nvdb;
pub mod query;
pub mod read;
pub mod redistance;
mod share;
mod union;
mod volume;

pub use bake::{BakeError, BakeOptions, BakeReport, SignChoice, SignMethod, bake};
pub use grid::BrickGrid;
pub use mesh::Mesh;
pub use union::LatticeError;
