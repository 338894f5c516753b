//! The workpiece: pictures of its field, values at a pixel, sections along a line, conditions in a region, the way of
//! the tool.

mod camera;
mod motion;
mod paint;
mod picture;
mod probe;
mod region;
mod section;
mod studio;
mod surfaces;

pub(crate) use camera::{Shot, Size, Turn};
pub(crate) use motion::motion;
pub(crate) use paint::painted;
pub(crate) use picture::{PictureData, PictureRequest, drawn, png, threads};
pub(crate) use probe::probed;
pub(crate) use region::region;
pub(crate) use section::{Line, section};
pub(crate) use studio::Studio;
pub(crate) use surfaces::Surfaces;
