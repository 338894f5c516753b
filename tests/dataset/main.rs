//! Data sets as users see them: made, interrupted, damaged and repaired by the program as a process.

#[path = "../program/program.rs"]
#[allow(dead_code, reason = "the helpers of the program's tests, of which these need some")]
mod program;

mod failing;
mod flags;
mod images;
mod interrupted;
mod made;
mod set;
mod validated;
