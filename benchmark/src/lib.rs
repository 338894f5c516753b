//! Benchmark of the study: campaigns of the virtual laboratory with known answers are studied with default settings,
//! and the results are judged.
//!
//! 1. [`cases`] lists the hidden effects, family by family; [`rung`] gives their size relative to the visible one,
//!    independent of the detectable size; [`sample`] takes a part of the list.
//! 2. [`run`] makes a case, writes its trials to a folder and lets a study read them from there: the [`Outcome`].
//! 3. [`CaseAnswer`] is the content of an answer, [`Judgement`] its score; [`Forecast`] holds its probabilities,
//!    [`Interval`] its intervals, [`Errors`] the held-out errors.
//! 4. [`Summary`] counts them, with intervals, beside baselines that a study must beat.
//!
//! [`OpenedSeal`] compares one study with one sealed answer.
//!
//! The generator has a finer lattice, shorter steps, another path and an instrument's errors; the study reads only the
//! trial folders.

mod answer;
mod baseline;
mod cases;
mod coverage;
mod diagram;
mod error_gap;
mod forecast;
mod ladder;
mod outcome;
mod power;
mod rate;
mod sample;
mod sealed;
mod summary;
mod table;

pub use answer::{CaseAnswer, ExpectedAnswer, Judgement, NamedEffect, describing};
pub use cases::{Case, Design, Family, cases};
pub use coverage::{Coverage, Interval, coverage};
pub use diagram::reliability_svg;
pub use error_gap::{Errors, GapClosed};
pub use forecast::{Bin, Forecast, Reliability, most_probable};
pub use ladder::{POWER_RUNGS, RUNGS, Rung, rung};
pub use outcome::{BenchError, Outcome, run};
pub use power::Power;
pub use rate::Rate;
pub use sample::sample;
pub use sealed::{OpenedSeal, SealError};
pub use summary::{Compared, CoverageOf, Scores, Summary};
