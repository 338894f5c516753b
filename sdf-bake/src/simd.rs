//! Loops compiled for the processor's widest lanes.

/// Result of `work`, compiled for the widest lanes of this processor. The closure must be marked `#[inline(always)]`, as
/// all that it calls, or its loops are not.
#[inline(always)]
pub fn in_wide_lanes<R>(work: impl FnMut() -> R) -> R {
    pulp::Arch::new().dispatch(Wide(work))
}

/// A closure that is called by reference: by value, one that moves nothing is called through a function of its own, which
/// is compiled for the narrowest lanes.
struct Wide<F>(F);

impl<R, F: FnMut() -> R> pulp::NullaryFnOnce for Wide<F> {
    type Output = R;

    #[inline(always)]
    fn call(mut self) -> R {
        (self.0)()
    }
}
