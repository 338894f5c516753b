//! How often a diagnosis is right: campaigns of the virtual laboratory with known answers, diagnosed with the default
//! settings and judged.
//!
//! 1. [`cases`] lists what is hidden, family by family; sizes are multiples of what the same campaign without the effect
//!    says it could detect.
//! 2. [`Outcome`] is what came out of one case.
//! 3. [`Summary`] counts them, with intervals.
//!
//! The generator has a finer lattice, shorter steps, another path and an instrument's errors; the diagnosis sees what a
//! reader of trial folders sees.

mod cases;
mod outcome;
mod rates;

pub use cases::{Case, Design, Family, Instruments, Sized, cases};
pub use outcome::{BenchError, Outcome, run};
pub use rates::{FamilyRates, Rate, Summary};
