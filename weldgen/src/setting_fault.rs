//! Error for settings that no weld on a part can have, naming the flag that sets them.

use thiserror::Error;

use crate::dial_fault::DialFault;
use crate::dials::{Dial, TOE_RADIUS};

/// A setting that is impossible for a part of any shape.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum SettingFault {
    /// The size is far below the voxel: the ground truth would have it and the field would not.
    #[error(
        "--{} {:?}: with a voxel of {:.4} mm, {:.4} mm or more is accepted; a smaller --voxel-mm allows less",
        dial.key, 1e3 * size, 1e3 * voxel, 1e3 * least
    )]
    BelowVoxel {
        /// The dial.
        dial: Dial,
        /// Its value [m].
        size: f64,
        /// The voxel [m].
        voxel: f64,
        /// Least accepted value [m].
        least: f64,
    },
    /// A dial is out of range.
    #[error("{}{fault}", flag_of(fault))]
    Dial {
        /// The dial, what was found and what is accepted.
        fault: DialFault,
    },
    /// The round toes reach beyond the band of the field.
    #[error(
        "--{} {:?}: 0 to {:.4} mm are accepted for a bead {:.3} mm wide and {:.3} mm high in a band of {:.3} mm; a wider \
         --band allows more",
        TOE_RADIUS.key, 1e3 * radius, 1e3 * most, 1e3 * bead[0], 1e3 * bead[1], 1e3 * band
    )]
    Toes {
        /// Requested radius [m].
        radius: f64,
        /// Greatest accepted radius [m].
        most: f64,
        /// Width and height of the bead [m].
        bead: [f64; 2],
        /// Half width of the band [m].
        band: f64,
    },
}

/// Returns the flag of a dial as the prefix of a message; empty if no flag sets it.
fn flag_of(fault: &DialFault) -> String {
    Dial::named(fault.dial).map_or(String::new(), |dial| format!("--{}: ", dial.key))
}
