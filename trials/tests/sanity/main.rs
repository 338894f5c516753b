//! Contradictory files are always reported: swapped, mirrored, mis-scaled and copied files of a trial.
//!
//! Campaigns made elsewhere are read from `ROBOFIN_SHARED`; if they are missing the test says so, and fails if
//! `ROBOFIN_REQUIRE_SHARED` is 1.

mod damage;
mod kinds;
mod logs;
mod scans;
mod shared;
#[path = "../../../tests/common/shared_folder.rs"]
mod shared_folder;
