//! Contact and removal on signed distance fields stored in bricks.
//!
//! A part is a [`sdf_bake::BrickGrid`], negative inside. A rigid [`robot::Tool`] follows a [`Path`]. A controller moves
//! it along its approach axis until the contact force equals the setpoint; under the contact pressure the surface
//! recedes. All is in SI units, in the part's right-handed frame with z up.
//!
//! ```
//! use glam::DVec3;
//! use sdf_bake::BrickGrid;
//! use effects::{CompiledModel, Library, Model, RowCounts, States};
//! use robot::{Tool, Wheel};
//! use sim::{CurvePoint, Pass, PassSettings, Path, TOOL_CELLS, run_pass};
//!
//! let half = DVec3::new(0.03, 0.02, 0.005);
//! let plate = |p: DVec3| p.z;
//! let mut part = BrickGrid::from_distance(-half, half, 0.5e-3, 3.0, plate);
//! let curve = [-5e-3, 5e-3].map(|x| CurvePoint { position: DVec3::X * x, normal: DVec3::Z });
//! let path = Path::along(&curve, 5e-3).unwrap();
//! let tool = Tool::from(Wheel::cylinder(0.05, 0.02));
//! let library = Library::builtin();
//! let model = Model::parse("model.toml", "process = \"grinding\"", library).unwrap();
//! let model = CompiledModel::new(&model, library, RowCounts::default()).unwrap();
//! let mut wheel = States::new(&model, TOOL_CELLS);
//! let settings = PassSettings::default();
//! let record = run_pass(&mut part, Pass::first(&tool, &path, &settings, &model), &mut wheel, &mut |_| {}).unwrap();
//! let grind_rate = model.law_value("grind_rate").unwrap();
//! let expected = grind_rate * settings.force_setpoint * path.duration();
//! assert!((record.removed_volume / expected - 1.0).abs() < 0.01);
//! ```
//!
//! This crate opens no file, prints nothing and keeps no state between calls. Its results do not depend on the number
//! of threads, to the last byte.

mod clipped_cell;
pub mod clock;
pub mod contact;
pub mod control;
pub mod covariates;
mod crossing;
mod executor;
mod extent;
mod force_profile;
pub mod gpu;
pub mod height_field;
mod lattice_line;
pub mod lines;
mod measured;
pub mod pass;
pub mod path;
mod phi_functions;
pub mod physics;
pub mod pose;
pub mod press;
pub mod profilometer;
pub mod record;
pub mod region;
mod scheme;
pub mod settings;
mod step;
mod step_values;
pub mod surface;
mod tool_cells;
pub mod topography;
mod wrench;
mod write_back;

pub use clock::{Clock, Phase};
pub use contact::Contact;
pub use covariates::Covariates;
pub use executor::{ExecutionError, Executor};
pub use force_profile::ForceProfile;
pub use measured::Measured;
pub use pass::{Progress, Underway, rest, run_pass, run_stretch};
pub use path::{CurvePoint, Path, PathError, PathSample};
pub use pose::{Frame, Placement, Pose};
pub use profilometer::Profilometer;
pub use record::PassRecord;
pub use settings::{LONGEST_STEP, Pass, PassError, PassSettings};
pub use tool_cells::COUNT as TOOL_CELLS;
pub use topography::Topography;
pub use wrench::{Wrench, WrenchGauge};
