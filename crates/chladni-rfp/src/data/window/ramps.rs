//! Integrals of e^{−zu} over a record, of which all kernels are sums:
//!
//! e(z) = ∫₀¹ e^{−zu} du = (1 − e^{−z})/z,  f(z) = ∫₀¹ (1 − u)·e^{−zu} du = (1 − e(z))/z

use crate::data::limits;
use crate::data::window::lanes::Lanes;
use num_complex::Complex64;

/// e and f at some places, and the slope of f.
pub(super) struct Ramps<const L: usize> {
    pub e: Lanes<L>,
    pub f: Lanes<L>,
    /// f′ = −∫ u(1 − u)·e^{−zu} du.
    pub f_slope: Lanes<L>,
}

impl<const L: usize> Ramps<L> {
    /// * `left`: e^{−z}
    #[inline(always)]
    pub fn new(z: Lanes<L>, left: Lanes<L>) -> Self {
        let (one, over) = (Lanes::from(1.0), z.inverse());
        let e = (one - left) * over;
        let f = (one - e) * over;
        let f_slope = (e - f * 2.0) * over;
        let mut ramps = Self { e, f, f_slope };
        for (l, square) in z.norm_sqr().into_iter().enumerate() {
            if square < limits::SERIES_BELOW * limits::SERIES_BELOW {
                ramps.by_series(l, z.get(l));
            }
        }
        ramps
    }

    /// Near 0, where the closed forms cancel.
    #[cold]
    fn by_series(&mut self, l: usize, z: Complex64) {
        let [e, f, third] = [1, 2, 3].map(|first| series(z, first));
        self.e.set(l, e);
        self.f.set(l, f);
        self.f_slope.set(l, 2.0 * third - f);
    }

    /// e′ = −∫ u·e^{−zu} du.
    #[inline(always)]
    pub fn e_slope(&self) -> Lanes<L> {
        self.f - self.e
    }
}

/// Σ_k (−z)^k/(k + first)!, by Horner.
fn series(z: Complex64, first: u32) -> Complex64 {
    let inner = (1..=limits::SERIES_TERMS)
        .rev()
        .fold(Complex64::from(1.0), |sum, k| {
            1.0 - z * sum / f64::from(k + first)
        });
    inner / f64::from((1..=first).product::<u32>())
}
