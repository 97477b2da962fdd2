//! The upper halves of the processor's vector registers.
//!
//! The kernels of faer's products leave values there. Every scalar instruction after
//! them, of which this program has many, then waits for what its register held before.

/// Clears the upper halves, where the processor has them.
pub fn clear() {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx") {
        // SAFETY: the processor has AVX.
        #[allow(unsafe_code)]
        unsafe {
            std::arch::x86_64::_mm256_zeroupper();
        }
    }
}
