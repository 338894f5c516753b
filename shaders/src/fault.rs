//! What a device may fail at, in words that say what to do.

/// A fault of the device or of what was asked of it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{adapter} {} while {during}: {message}; {}", kind.verb(), kind.advice())]
pub struct DeviceFault {
    /// The adapter.
    pub adapter: String,
    /// What was being done, with its size where that counts.
    pub during: String,
    /// What kind of fault it is.
    pub kind: FaultKind,
    /// The driver's or the validator's words.
    pub message: String,
}

/// Kinds of faults, by what can be done about them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// Memory that was asked for was not given: less at once may go well.
    OutOfMemory,
    /// The device is gone, and whatever else is asked of it fails.
    Lost,
    /// Anything else, such as a kernel that the driver does not compile.
    Refused,
}

impl FaultKind {
    fn verb(self) -> &'static str {
        match self {
            Self::OutOfMemory => "ran out of memory",
            Self::Lost => "was lost",
            Self::Refused => "failed",
        }
    }

    fn advice(self) -> &'static str {
        match self {
            Self::OutOfMemory => {
                "coarser voxels, fewer trials at once or a smaller picture take less, and --backend cpu takes none of it"
            }
            Self::Lost | Self::Refused => "--backend cpu does the same work",
        }
    }
}

/// A size for people.
pub(crate) fn mib(bytes: &u64) -> String {
    format!("{:.1} MiB", *bytes as f64 / f64::from(1 << 20))
}
