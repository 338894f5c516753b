//! Contact, removal and rendering on live signed distance bricks.
//!
//! A part is a [`sdf_bake::BrickGrid`], negative inside. A rigid [`Wheel`] follows a [`Path`] and is lifted
//! or lowered along its approach axis until its contact force is the setpoint; under the contact pressure
//! the surface recedes. All is in SI units, in the part's right-handed frame with z up.
//!
//! ```
//! use glam::DVec3;
//! use sdf_bake::BrickGrid;
//! use sim::{CurvePoint, GrindSettings, Path, Wheel, grind};
//!
//! let half = DVec3::new(0.03, 0.02, 0.005);
//! let plate = |p: DVec3| p.z;
//! let mut part = BrickGrid::from_distance(-half, half, 0.5e-3, 3.0, plate);
//! let curve = [-5e-3, 5e-3].map(|x| CurvePoint { position: DVec3::X * x, normal: DVec3::Z });
//! let settings = GrindSettings::default();
//! let path = Path::along(&curve, settings.feed).unwrap();
//! let wheel = Wheel { radius: 0.05, width: 0.02 };
//! let pass = grind(&mut part, &path, &wheel, &settings, &mut |_| {}).unwrap();
//! let expected = settings.grind_rate * settings.force_setpoint * path.duration();
//! assert!((pass.removed_volume / expected - 1.0).abs() < 0.01);
//! ```
//!
//! This crate never opens a file, never prints, and holds no state between calls. It computes the same
//! bytes for any number of threads.

pub mod contact;
pub mod control;
pub mod effect;
pub mod grind;
pub mod path;
mod ramp;
pub mod record;
pub mod removal;
pub mod render;
pub mod settings;
pub mod surface;
pub mod tool;

pub use contact::Contact;
pub use grind::{Progress, grind};
pub use path::{CurvePoint, Path, PathError, PathSample};
pub use record::{LogRow, PassRecord};
pub use settings::{GrindError, GrindSettings};
pub use tool::{Pose, Wheel};
