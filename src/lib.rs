//! placeholder
pub mod export;
pub mod python;
