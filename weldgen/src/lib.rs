//! Weld curves and beads on triangle meshes, with their ground truth.
//!
//! A weld is a curve on the part's surface and a bead swept along it. The curve has a requested length and geodesic
//! curvature; it is traced exactly over the polyhedron, so it has both. The bead is a closed mesh whose base lies below
//! the surface: the union of part and bead is the welded part.
//!
//! ```
//! use glam::DVec3;
//! use sdf_bake::{Mesh, query::MeshQuery};
//! use weldgen::{WeldRequest, place_weld};
//!
//! // A plate of 200 mm × 100 mm × 8 mm.
//! let corner = |i: u32| DVec3::new((i & 1) as f64 * 0.2, (i >> 1 & 1) as f64 * 0.1, (i >> 2) as f64 * 0.008);
//! let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
//! let plate = Mesh {
//!     positions: (0..8).map(corner).collect(),
//!     triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
//! };
//! let request = WeldRequest::for_part(&plate, plate.diagonal() / 256.0);
//! let weld = place_weld(&plate, &MeshQuery::new(&plate), &request, 7)?;
//! weld.curve.validate(&plate)?;
//! assert!(weld.bead.volume() > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Modules in the order of processing: [`topology`] (neighbours), [`curvature`] (geodesic curvature), [`trace`] (the
//! curve), [`exposure`] (free share of the hemisphere), [`access`] (tool access), [`dials`] (accepted requests),
//! [`WeldSettings`] (what users set), [`request`] (a complete request), [`surface`] (a prepared part), [`strata`]
//! (possible starts), [`seam`] (possible fillets), [`place`] (proposals until one fits), [`curve`] (points with frames),
//! [`bead`] (sections and the swept mesh).
//!
//! Lengths are in metres, angles in radians, curvatures in 1/m. Vertices of the part must be shared between triangles
//! and normals must point outwards. This crate opens no file, prints nothing, and takes its randomness as a seed;
//! results do not depend on the number of threads.

pub mod access;
pub mod bead;
mod butt;
pub mod curvature;
pub mod curve;
mod cut;
mod dial_fault;
pub mod dials;
mod difficulty;
pub mod exposure;
mod fillet;
mod fit;
mod footprint;
mod offers;
pub mod place;
mod place_error;
mod propose;
pub mod rejection;
pub mod request;
pub mod seam;
mod setting_fault;
mod settings;
mod shortfall;
mod stitch;
pub mod strata;
pub mod surface;
pub mod topology;
pub mod trace;

pub use bead::{BeadProfile, sweep};
pub use curve::{CurvePoint, WeldCurve};
pub use dial_fault::DialFault;
pub use difficulty::Difficulty;
pub use place::{PlaceError, Weld, place_weld, place_weld_on, place_welds_on};
pub use request::{Joint, Placement, Stitch, WeldRequest};
pub use setting_fault::SettingFault;
pub use settings::WeldSettings;
pub use surface::Surface;
