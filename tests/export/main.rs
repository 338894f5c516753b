//! Exports checked with other programs: the gltf crate, Khronos' validator, usd-core, manifold3d, OpenEXR, OpenCV,
//! MuJoCo, yourdfpy.
//!
//! If node or Python is not available, the tests that need it report so on standard error and are skipped; with
//! `ROBOFIN_REQUIRE_OUTSIDE=1` they fail.

mod exr;
mod glb;
mod manifold;
mod outside;
mod packages;
mod python;
mod robots;
mod solids;
mod table;
mod usd;
