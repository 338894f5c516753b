//! Converts a CAD mesh to a signed distance field.
//!
//! All values are in SI units, in the part's right-handed frame with z up; inside is negative.
//!
//! ```
//! use glam::DVec3;
//! use sdf_bake::clean::clean;
//! use sdf_bake::read::{Format, UnitChoice, parse_mesh};
//! use sdf_bake::{BakeOptions, bake};
//!
//! let corner = b"v 0 0 0\nv 20 0 0\nv 0 20 0\nv 0 0 20\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
//! let file = parse_mesh(corner, Format::Obj, UnitChoice::Millimetre, "corner.obj").unwrap();
//! let (mesh, report) = clean(file.mesh).unwrap();
//! assert!(report.is_watertight());
//! let (field, _) = bake(&mesh, &BakeOptions::with_voxel(0.5e-3)).unwrap();
//! assert!((field.sample(DVec3::new(0.004, 0.004, 0.001)) + 0.001).abs() < 1e-6);
//! assert!((field.volume() / mesh.volume() - 1.0).abs() < 0.01);
//! ```
//!
//! The modules in the order of processing: [`read`] and [`clean`] make a [`Mesh`], [`query`] finds closest points and
//! ray hits on it, [`mod@bake`] makes a [`BrickGrid`] ([`grid`]) with its [`channels`], [`BrickGrid::combined_with`]
//! unites and cuts such fields, [`redistance`] restores the distance property of a changing field,
//! [`BrickGrid::surface_mesh`] extracts its surface, [`nvdb`] stores it.
//!
//! This crate shows no progress and prints nothing; it opens no file except the mesh given to [`read`], by [`input`].

pub mod bake;
mod bounds;
pub mod channels;
pub mod clean;
mod combine;
mod crossing;
pub mod grid;
mod grow;
pub mod halo;
pub mod heights;
mod implicit;
pub mod index;
mod measures;
pub mod memory_budget;
mod merged;
pub mod mesh;
pub mod nvdb;
mod project;
pub mod query;
pub mod read;
pub mod redistance;
mod seam;
mod share;
pub mod simd;
mod surface;
mod tangent;
mod union;
mod volume;
mod within;

pub use bake::{BakeError, BakeOptions, BakeReport, SignChoice, SignMethod, bake};
pub use channels::Scalar;
pub use combine::{BLEND_REACH, Combine, CombineError, LatticeError};
pub use grid::BrickGrid;
pub use heights::{HeightMap, PixelGrid};
pub use measures::Measures;
pub use merged::Merged;
pub use mesh::Mesh;
