//! Writes assets in formats of other programs, and checks them with those programs.
//!
//! - [`glb`] writes binary glTF with [`shading`]'s crease-keeping normals; [`glb_read`] reads it back and checks it.
//! - [`usd`] writes and checks OpenUSD through the scripts in `scripts/`, run by [`python`].
//! - [`models`] lists the files that follow from a [`surface`] alone: [`mass`], light glTF, [`stl`], [`robot_model`].
//! - [`vdb`] writes NanoVDB grids as OpenVDB.
//! - [`manifold`] computes the volume that a bead adds with manifold3d, as an independent check of the field's volume.

pub mod glb;
pub mod glb_read;
pub mod manifold;
pub mod mass;
pub mod models;
pub mod python;
pub mod rle;
pub mod robot_model;
pub mod shading;
pub mod stl;
pub mod surface;
pub mod usd;
pub mod vdb;
