//! Trials and tables: the files of what was measured, and how far each measurement can be trusted.
//!
//! 1. [`trial`] reads workpieces that were scanned, finished in passes and scanned again, with the robot's logs.
//! 2. [`init`] guesses the `trial.toml` of a folder.
//! 3. [`table`] reads rows of settings and responses.
//! 4. [`measure`] registers scans on each other, finds the noise floor of the instrument, and the residual of two maps.
//!
//! SI units inside. This crate writes only what it is asked to, and never simulates.

mod column_unit;
pub mod init;
pub mod measure;
pub mod table;
pub mod trial;
