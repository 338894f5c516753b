//! The workbench: a page on the loopback address on which users see where a model fails, try a cause, and watch the
//! error fall.
//!
//! 1. [`Workbench`] binds an address; `guard` refuses requests without the token or from other pages.
//! 2. `home` lists the content of a folder; `place` is one entry.
//! 3. An opened campaign has a `bench`: a thread that owns its measurements and does one task after the other. Its
//!    fitted models are `stage`s, saved by `journal`; `trail` is the undo history.
//! 4. `part` draws the workpiece from its field, reads values at a pixel and cuts sections.
//! 5. `weld` is the page on which an asset is made; it runs `robofin weld` in the background.
//! 6. `sets` reads data sets: tables of assets, images with their labels.
//! 7. `pages` are the templates, and `assets/` the style and scripts, compiled into the program.
//!
//! This crate fits and judges nothing: `lab` and `study` do, and a stage is a result of `robofin calibrate`; `weldgen`
//! places welds. The pages
//! fetch nothing from the network, and the crate prints nothing.

mod bench;
mod drop;
mod error;
mod guard;
mod home;
mod next_trial;
mod pages;
mod part;
mod place;
mod routes;
mod serve;
mod sets;
mod shell;
mod weld;

pub use error::WorkbenchError;
pub use serve::{Options, Workbench, open_in_browser};
