//! Numbers in binary files.

/// Type of a stored number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Element {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

/// Order of the bytes of a number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Order {
    #[default]
    Little,
    Big,
}

/// Decodes the numbers of one type in `bytes`.
macro_rules! numbers {
    ($kind:ty, $bytes:expr, $order:expr) => {{
        let chunks = $bytes.as_chunks::<{ size_of::<$kind>() }>().0.iter();
        match $order {
            Order::Little => chunks.map(|chunk| <$kind>::from_le_bytes(*chunk) as f64).collect(),
            Order::Big => chunks.map(|chunk| <$kind>::from_be_bytes(*chunk) as f64).collect(),
        }
    }};
}

impl Element {
    /// Bytes of a number.
    pub(super) fn size(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    /// Decodes consecutive numbers; an incomplete one at the end is left out.
    pub(super) fn values(self, bytes: &[u8], order: Order) -> Vec<f64> {
        match self {
            Self::U8 => numbers!(u8, bytes, order),
            Self::I8 => numbers!(i8, bytes, order),
            Self::U16 => numbers!(u16, bytes, order),
            Self::I16 => numbers!(i16, bytes, order),
            Self::U32 => numbers!(u32, bytes, order),
            Self::I32 => numbers!(i32, bytes, order),
            Self::U64 => numbers!(u64, bytes, order),
            Self::I64 => numbers!(i64, bytes, order),
            Self::F32 => numbers!(f32, bytes, order),
            Self::F64 => numbers!(f64, bytes, order),
        }
    }

    /// Decodes the number in the first bytes, NaN if there are too few.
    pub(super) fn value(self, bytes: &[u8], order: Order) -> f64 {
        /// Decodes the number in the first bytes.
        macro_rules! first {
            ($kind:ty) => {
                match (bytes.first_chunk(), order) {
                    (Some(chunk), Order::Little) => <$kind>::from_le_bytes(*chunk) as f64,
                    (Some(chunk), Order::Big) => <$kind>::from_be_bytes(*chunk) as f64,
                    (None, _) => f64::NAN,
                }
            };
        }
        match self {
            Self::U8 => first!(u8),
            Self::I8 => first!(i8),
            Self::U16 => first!(u16),
            Self::I16 => first!(i16),
            Self::U32 => first!(u32),
            Self::I32 => first!(i32),
            Self::U64 => first!(u64),
            Self::I64 => first!(i64),
            Self::F32 => first!(f32),
            Self::F64 => first!(f64),
        }
    }
}
