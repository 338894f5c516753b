//! Writes assets in the formats other programs read, and checks them with those programs.
//!
//! - [`glb`] writes binary glTF with [`shading`]'s crease-keeping normals; [`glb_read`] reads it back and checks it.
//! - [`usd`] writes and checks OpenUSD through the scripts in `scripts/`, run by [`python`].
//! - [`rle`] encodes masks as COCO has them.
//! - [`manifold`] asks manifold3d how much volume a bead adds: an opinion from outside on our own figure.

pub mod glb;
pub mod glb_read;
pub mod manifold;
pub mod python;
pub mod rle;
pub mod shading;
pub mod usd;
