//! RoboFin: welded workpieces, signed distance fields, grinding and sanding in simulation.
//!
//! Modules and crates in the order of the data:
//!
//! 1. [`part`] reads and cleans a mesh ([`sdf_bake::read`], [`sdf_bake::clean`]).
//! 2. [`workpiece`] places a weld on it ([`weldgen`]) and bakes part and bead ([`sdf_bake::bake`]).
//!    [`baking`] does the same for the part alone, and [`cache`] for many parts, each once.
//! 3. [`asset`] writes the result to a folder, with [`export`] for glTF and USD; [`dataset`] does the same for
//!    thousands, and [`images`] makes labelled pictures of coated ones during sanding. Both, and [`cache`], are
//!    [`store`]s, which can be resumed.
//! 4. [`finishing`] grinds the weld ([`sim`], [`pass_run`]) and [`grinding_page`] shows the result ([`report`]).
//! 5. [`paths`] plans tool paths; [`trials`] reads measurements, [`trial_run`] simulates them ([`snapshot`],
//!    [`batch`]).
//! 6. [`virtual_lab`] makes virtual experiments with hidden effects, and their answers.
//! 7. [`lab`] fits a model to measurements and finds the effects that it lacks; [`lab::study`] is the whole study, and
//!    [`report::study`] its page; [`benchmark`] counts how often it is right, and [`sealed_example`] is an example to
//!    try it on.
//! 8. [`validate`] opens the files of an asset and compares them with each other.
//!
//! Units are SI; frames are right-handed with z up; inside is negative. Only this crate prints. `ARCHITECTURE.md` lists
//! the crates and their dependencies.

pub mod asset;
pub mod baking;
pub mod batch;
pub mod cache;
pub mod commands;
pub mod console;
pub mod dataset;
pub mod finishing;
pub mod grinding_page;
pub mod images;
mod interrupt;
pub mod part;
pub mod pass_run;
pub mod photo;
pub mod picture;
pub mod sealed_example;
pub mod store;
pub mod trial_run;
pub mod validate;
pub mod workpiece;

use files::WrongUse;

/// Formats an error with its causes in one line; causes already quoted by the outer messages are left out.
pub fn in_full(error: &anyhow::Error) -> String {
    error.chain().fold(String::new(), |chain, cause| {
        let cause = cause.to_string();
        match chain.as_str() {
            "" => cause,
            chain if chain.ends_with(&cause) => chain.to_owned(),
            chain => format!("{chain}: {cause}"),
        }
    })
}

/// Makes an error that ends the program with exit code 2.
pub fn wrong_use(message: String) -> anyhow::Error {
    WrongUse(message).into()
}

/// True if the program was called wrongly.
pub fn is_wrong_use(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| cause.is::<WrongUse>())
}
