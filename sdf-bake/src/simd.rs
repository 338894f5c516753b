//! Loops compiled for the processor's widest SIMD lanes.

/// Returns the result of `work`, compiled for the widest lanes of this processor. The closure and all functions that it
/// calls must be marked `#[inline(always)]`; otherwise their loops are not compiled for these lanes.
#[inline(always)]
pub fn in_wide_lanes<R>(work: impl FnMut() -> R) -> R {
    pulp::Arch::new().dispatch(Wide(work))
}

/// A closure that is called by reference. A closure that is called by value and moves nothing is called through a
/// separate function, which is compiled for the narrowest lanes.
struct Wide<F>(F);

impl<R, F: FnMut() -> R> pulp::NullaryFnOnce for Wide<F> {
    type Output = R;

    #[inline(always)]
    fn call(mut self) -> R {
        (self.0)()
    }
}
