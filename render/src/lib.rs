//! Pictures of a part, rendered from its signed distance field. No mesh is extracted and no file is written: a view
//! gives float buffers ([`Frame`]), which become an eight-bit [`Picture`] or the bytes of an EXR file ([`to_exr`]).
//!
//! The stages, in the order of processing:
//! 1. [`Camera`]: a ray for every sample of the image, with lens distortion ([`Distortion`]);
//! 2. [`Field`]: large steps through empty bricks and blocks, exact root in the trilinear cell;
//! 3. geometry buffers: depth, normal, position, weld id, dose, [`removed_depth`], visibility;
//! 4. light: a [`Scene`] is photographed ([`Material`], [`Marks`], [`Lights`]); a [`View`] is drawn with edges or in
//!    the [`colour_map`] of removed depth;
//! 5. [`Optics`] and [`Sensor`]: defocus, motion, vignetting, blur, exposure and noise; [`label`]: pixels with sanded coating; [`contact_sheet`]: panels and legend
//!    in one picture.
//!
//! Every sample is a pure function of its arguments, so a picture is the same for any number of threads.
//!
//! ```
//! use glam::DVec3;
//! use sdf_bake::BrickGrid;
//! use render::{Camera, Raster, Scene, Sensor};
//!
//! let half = DVec3::splat(0.01);
//! let ball = BrickGrid::from_distance(-half, half, 0.5e-3, 3.0, |p| p.length() - 0.01);
//! let scene = Scene::new(&ball);
//! let camera = Camera::framing(-half, half, -0.9, 0.6, 4.0 / 3.0);
//! let mut frame = scene.photograph(&camera, &Raster { width: 64, height: 48, samples_per_side: 2 });
//! Sensor { full_well: 20e3, seed: 7, ..Sensor::default() }.expose(&mut frame);
//! assert!(frame.depth[24 * 64 + 32].is_finite());
//! assert_eq!(frame.to_srgb8().rgb.len(), 3 * 64 * 48);
//! ```

// Units are in brackets: `[m]` is not a link.

// Loops over lanes index several arrays at once.
#![allow(clippy::needless_range_loop)]

mod camera;
mod clear_view;
mod colour;
mod colour_map;
mod contact_sheet;
mod cubic;
mod deposit;
mod edges;
mod environment_map;
mod exr_file;
mod field;
mod frame;
mod fusion_line;
mod gbuffer_lanes;
mod heat_tint;
mod index;
pub mod label;
mod lanes;
mod legend;
mod lens;
mod light_visibility;
mod lights;
mod lockstep;
mod marks;
mod material;
mod microfacet;
mod occupancy;
mod optics;
mod oxides;
mod padded;
mod photographer;
mod placement;
mod ray_packet;
mod rays;
mod removed;
mod rolling_shutter;
mod rows;
mod scene;
mod sensor;
mod shade;
mod shade_lanes;
mod shadow;
mod skyline;
mod surface;
mod swirl;
mod table_pattern;
mod text;
mod texture;
mod tile;
mod tile_finish;
mod trace;
mod view;
mod walk;

pub use camera::{Camera, Projection, Ray, outward};
pub use clear_view::{clearest_direction, clearest_of};
pub use colour::{from_srgb8, to_srgb8};
pub use colour_map::colour_map;
pub use contact_sheet::{Panel, contact_sheet};
pub use deposit::Deposit;
pub use environment_map::{EnvironmentMap, Surroundings};
pub use exr_file::to_exr;
pub use field::Field;
pub use frame::{Frame, Picture, VisibleObject};
pub use fusion_line::FusionLine;
pub use heat_tint::HeatTint;
pub use legend::Legend;
pub use lens::Distortion;
pub use lights::{Environment, KeyLight, LightPanel, Lights};
pub use marks::{MOST_POINTS, MarkPoint, Marks};
pub use material::{Appearance, FRESH_WELD, GROUND_STEEL, Material, PRIMER, ROLLED_STEEL};
pub use optics::Optics;
pub use oxides::{Crust, Oxides};
pub use photographer::Photographer;
pub use placement::Placement;
pub use removed::{REMOVED_RESOLUTION, removed_depth, round_full_scale};
pub use rolling_shutter::RollingShutter;
pub use scene::{FIRST_OBSTACLE, FIRST_TOOL, Raster, Scene, Table};
pub use sensor::Sensor;
pub use shade::{BASE_STEEL, SurfaceReflectance, UNTOUCHED, WELD_METAL};
pub use table_pattern::{TableKind, TablePattern};
pub use text::{draw_text, text_size};
pub use texture::Texture;
pub use trace::Hit;
pub use view::{RemovedView, View, render};
