//! Weld curves.

pub mod curvature;
pub mod topology;
pub mod trace;
