//! Pictures of a part, rendered from its signed distance field. No mesh is extracted and no file is written: a view
//! gives float buffers ([`Frame`]), and these an eight-bit [`Picture`] for whoever can store one.
//!
//! The stages, in the order in which data meets them:
//! 1. [`Camera`]: a ray for every sample of the image;
//! 2. [`trace`]: sphere tracing through the bricks, exact root in the trilinear cell;
//! 3. geometry buffers: depth, normal, weld id, [`removed_depth`];
//! 4. light: shading, shadow, occlusion and drawn edges, or the [`colour_map`] of removed depth;
//! 5. [`contact_sheet`]: titles, panels side by side and the legend, in one picture.
//!
//! Every sample is a pure function of grid, camera and view, so a picture is the same for any number of threads.

// Units stand in brackets: `[m]` is no link.

mod camera;
mod clear_view;
mod colour;
mod colour_map;
mod cubic;
mod edges;
mod font;
mod frame;
mod legend;
mod removed;
mod shade;
mod sheet;
mod surface;
mod text;
mod trace;
mod view;
mod walk;

pub use camera::{Camera, Projection, Ray, outward};
pub use clear_view::{clearest_direction, clearest_of};
pub use colour::{from_srgb8, to_srgb8};
pub use colour_map::colour_map;
pub use frame::{Frame, Picture};
pub use legend::Legend;
pub use removed::{REMOVED_RESOLUTION, removed_depth, round_full_scale};
pub use shade::{BASE_STEEL, Finish, UNTOUCHED, WELD_METAL};
pub use sheet::{Panel, contact_sheet};
pub use text::{draw_text, text_size};
pub use trace::{Hit, trace};
pub use view::{RemovedView, View, render};
