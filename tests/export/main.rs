//! Exports against the programs that read them: the gltf crate, Khronos' validator, usd-core, manifold3d, OpenEXR, OpenCV.
//!
//! Where node or Python cannot be had, the tests that need them say so on standard error; with
//! `ROBOFIN_REQUIRE_OUTSIDE=1` they fail instead.

mod exr;
mod glb;
mod manifold;
mod outside;
mod python;
mod solids;
mod table;
mod usd;
