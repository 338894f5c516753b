//! Trials from users: complete, damaged, in other units and in other programs' formats.
//!
//! Campaigns made elsewhere are read from `ROBOFIN_SHARED`; if they are missing, the test reports so, and fails if
//! `ROBOFIN_REQUIRE_SHARED` is 1.

mod begun;
mod columns;
mod files;
mod hostile;
mod instrument;
mod keyence;
mod meshes;
mod nominal;
mod plausible;
mod poses;
mod repeated;
mod reproduced;
mod scanner;
mod shared;
#[path = "../common/shared_folder.rs"]
mod shared_folder;
mod written;
mod x3p;
