//! Labelled photographs of coated workpieces. No file is read or written.
//!
//! In the order of use:
//! 1. [`Shape`]: bundled workpieces as distance functions;
//! 2. [`sand`]: the dose of a pad along a pattern, stage by stage;
//! 3. [`Scene`]: placement, camera, light, materials and [`Look`]s, drawn at random from seeds;
//! 4. [`shoot`]: a photograph and its labels ([`Shot`]), from comparison with the unsanded and the bare workpiece;
//! 5. [`View`]: camera matrices, boxes, depth, normals and welds, which all photographs of a placement share;
//! 6. [`coco`], [`yolo`]: annotations in the formats of other programs.
//!
//! ```
//! use perception::{Look, Scene, Seeds, Shape, shoot};
//!
//! let mut part = Shape::Tee.field(2e-3);
//! part.dose = vec![0.0; part.phi.len()];
//! let scene = Scene::draw(&part, &Seeds { placement: 1, image: 2 }, (64, 48), &Look::ALL).unwrap();
//! let shot = shoot(&part, &scene, (64, 48)).unwrap();
//! assert_eq!(shot.exposed_share, 0.0);
//! ```

// Units are in brackets: `[m]` is not a link.

mod clutter;
pub mod coco;
mod jpeg;
mod looks;
mod png;
mod sanding;
mod scene;
mod shapes;
mod shot;
mod view;
pub mod yolo;

pub use clutter::{ObstacleDraw, ObstacleShape};
pub use looks::{DustDraw, Look, LookDraws, OpticsDraw, PanelDraw, SwirlDraw, TextureDraw};
pub use png::{png8, png16};
pub use sanding::{SPINDLE, SandingError, Setting, StageFigures, sand};
pub use scene::{CameraDraw, LampDraw, MaterialDraw, NoSurface, PlacementDraw, Scene, Seeds, SensorDraw};
pub use shapes::Shape;
pub use shot::{Shot, shoot};
pub use view::{Intrinsics, View, ViewFrame, VisibleWeld, depth_steps, instances};
