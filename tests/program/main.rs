//! The program as users see it: started as a process, judged by its exit code, its messages and its files.
//!
//! If Python, node or the shared parts (`ROBOFIN_SHARED`) are not available, the tests that need them report so on
//! standard error and are skipped; with `ROBOFIN_REQUIRE_OUTSIDE=1` they fail.

mod backends;
mod bake_folder;
mod damage;
mod dials;
mod effects;
mod faults;
mod faulty_driver;
mod first_trial;
mod flags;
mod hostile_files;
mod inputs;
mod interruption;
mod limits;
mod manual;
mod measures;
mod memory;
mod notes;
mod outputs;
#[path = "../export/outside.rs"]
mod outside;
mod paths;
mod pictures;
mod places;
mod press;
mod process;
mod program;
mod repeatability;
mod road;
mod shared_parts;
mod surface;
mod trial_road;
mod units;
mod workbench;
