//! Faults of a device, with advice.

/// A fault of the device or of a request to it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{adapter} {} while {during}: {message}; {}", kind.verb(), kind.advice())]
pub struct DeviceFault {
    /// The adapter.
    pub adapter: String,
    /// The operation, with its size where relevant.
    pub during: String,
    /// Kind of fault.
    pub kind: FaultKind,
    /// Message of the driver or the validator.
    pub message: String,
}

/// Kinds of faults, by their remedy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// An allocation failed: a smaller one may succeed.
    OutOfMemory,
    /// The device is lost; every further operation fails.
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

/// A size in MiB, for messages.
pub(crate) fn mib(bytes: &u64) -> String {
    format!("{:.1} MiB", *bytes as f64 / f64::from(1 << 20))
}
