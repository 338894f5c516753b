//! Writes assets in formats of other programs, and checks them with those programs.
//!
//! - [`glb`] writes binary glTF with [`shading`]'s crease-keeping normals; [`glb_read`] reads it back and checks it.
//! - [`usd`] writes and checks OpenUSD through the scripts in `scripts/`, run by [`python`].
//! - [`rle`] encodes masks in COCO's format.
//! - [`manifold`] computes the volume that a bead adds with manifold3d, as an independent check of the field's volume.

pub mod glb;
pub mod glb_read;
pub mod manifold;
pub mod python;
pub mod rle;
pub mod shading;
pub mod usd;
