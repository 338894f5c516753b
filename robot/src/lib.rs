//! Shapes of a finishing robot's tools, the controllers that press them on the workpiece, and the rows of its log.
//!
//! Every tool is defined by two functions of a point in its own frame (y across the feed, z away from the part, x = y ×
//! z): the depth of the point below the working surface, and its distance inside the working surface's border. Side
//! faces do not cut. All is in SI units.
//!
//! ```
//! use glam::DVec3;
//! use robot::{Tool, Wheel};
//!
//! let wheel = Tool::from(Wheel::cylinder(0.05, 0.02));
//! // A point 1 mm above the lowest point of the rim, in the middle of its width.
//! let point = DVec3::new(0.0, 0.0, -0.049);
//! assert!((wheel.depth(point) - 1e-3).abs() < 1e-12);
//! assert_eq!(wheel.within(point), 0.01);
//! ```
//!
//! This crate has no paths, no contact and no file formats.

mod controller;
mod field;
mod log_row;
mod mesh;
mod pad;
mod sphere;
mod tool;
mod tool_text;
mod wheel;

pub use controller::Controller;
pub use field::FieldTool;
pub use log_row::LogRow;
pub use mesh::MeshDepth;
pub use pad::Pad;
pub use sphere::Sphere;
pub use tool::{Shape, Tool};
pub use tool_text::{ToolText, tool_notations};
pub use wheel::Wheel;
