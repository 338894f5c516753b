//! The workbench: a page on the loopback address on which one sees where a model fails, tries a cause, and watches the error
//! fall.
//!
//! 1. [`Workbench`] binds an address; `guard` answers only who has the token and comes from the page itself.
//! 2. `home` lists what a folder holds; `place` is one of them.
//! 3. A campaign that is opened has a `bench`: a thread that owns its measurements and does one task after the other. What it
//!    has made are `stage`s, kept on disk by `journal`; `trail` goes back and forth among them.
//! 4. `part` draws the workpiece from its field, reads values off it and cuts sections through it.
//! 5. `pages` are the templates, and `assets/` the style and scripts, which the program holds.
//!
//! Nothing here fits or judges: `lab` and `study` do, and a stage is what `robofin calibrate` gives. Nothing is fetched, and
//! nothing is printed.

mod bench;
mod error;
mod guard;
mod home;
mod pages;
mod part;
mod place;
mod routes;
mod serve;

pub use error::WorkbenchError;
pub use serve::{Options, Workbench, open_in_browser};
