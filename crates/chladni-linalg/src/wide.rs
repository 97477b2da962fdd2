//! Plain loops compiled for the widest registers of the machine at hand.

/// Runs `work`, whose loops over slices the compiler turns into operations on several numbers at
/// once, as many as the processor has lanes for. The bits are those of plain loops: no sum is
/// taken in another order, no product joined with a sum.
///
/// Only inlined code is compiled so: `work` and every function that it calls need
/// `#[inline(always)]`.
#[inline]
pub fn wide<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}
