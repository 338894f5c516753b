//! Labelled photographs of coated workpieces. No file is read or written.
//!
//! In the order of use:
//! 1. [`Shape`]: bundled workpieces as distance functions;
//! 2. [`sand`]: the dose of a pad along a pattern, stage by stage;
//! 3. [`Scene`]: placement, camera, light, materials and [`Look`]s, drawn at random from seeds; [`SceneFiles`] hold
//!    pictures and meshes that it may use;
//! 4. [`shoot`]: a photograph and its labels ([`Shot`]), from comparison with the unsanded and the bare workpiece;
//! 5. [`View`]: camera matrices, boxes, depth, normals and welds, which all photographs of a placement share;
//! 6. [`coco`], [`yolo`]: annotations in the formats of other programs;
//! 7. [`Split`], [`Treatment`]: splits and states of the coating of a whole set.
//!
//! ```
//! use perception::{Look, Scene, SceneFiles, Seeds, Shape, shoot};
//!
//! let mut part = Shape::Tee.field(2e-3);
//! part.dose = vec![0.0; part.phi.len()];
//! let scene = Scene::draw(&part, &Seeds { placement: 1, image: 2 }, (64, 48), &Look::ALL).unwrap();
//! let shot = shoot(&part, &scene, (64, 48), &SceneFiles::default()).unwrap();
//! assert_eq!(shot.exposed_share, 0.0);
//! ```

// Units are in brackets: `[m]` is not a link.

mod clutter;
mod clutter_mesh;
pub mod coco;
mod environment;
mod jpeg;
mod look;
mod looks;
mod oxide_draws;
mod png;
mod sanding;
mod scene;
mod shapes;
mod shot;
mod shutter;
mod spatter;
mod split;
mod table_draw;
mod tool;
mod view;
pub mod yolo;

pub use clutter::{ObstacleDraw, ObstacleShape};
pub use clutter_mesh::{ClutterMesh, ClutterMeshes, NoClutterMesh, standing_height};
pub use environment::{ENVIRONMENT_ROWS, EnvironmentDraw, EnvironmentError, environment_map};
pub use look::{Look, NO_LOOKS, UnknownLook};
pub use looks::{DustDraw, LookDraws, OpticsDraw, PanelDraw, SwirlDraw, TextureDraw};
pub use oxide_draws::{CrustDraw, HeatTintDraw, RustDraw};
pub use png::{png8, png16};
pub use sanding::{SPINDLE, SandingError, Setting, StageFigures, sand};
pub use scene::{CameraDraw, LampDraw, MaterialDraw, NoSurface, PlacementDraw, Scene, Seeds, SensorDraw};
pub use shapes::Shape;
pub use shot::{SceneFiles, Shot, shoot};
pub use shutter::ShutterDraw;
pub use spatter::DropletDraw;
pub use split::{Split, SplitBy, Treatment, balanced_pairs, interleaved};
pub use table_draw::TableDraw;
pub use tool::{ToolDraw, ToolKind};
pub use view::{Intrinsics, TOOL_INSTANCE, View, ViewFrame, VisibleTool, VisibleWeld, depth_steps, instances};
