//! Trials and tables: files of measurements, and the reliability of each measurement.
//!
//! 1. [`trial`] reads workpieces that were scanned, finished in passes and scanned again, with the robot's logs.
//! 2. [`init`] drafts the `trial.toml` of a folder.
//! 3. [`table`] reads rows of settings and responses.
//! 4. [`measure`] registers scans, estimates the noise floor of the instrument, and computes the residual of two maps.
//!
//! SI units inside. This crate writes only files that the caller requests, and never simulates.

mod column_unit;
pub mod init;
pub mod measure;
pub mod table;
pub mod trial;
