//! The column of a mode and its derivative, in the law that a set of lines has.
//!
//! λ_n = (ω_n/ω_max)²(1 + jη_n) in both laws. A structural mode is 1/(λ − x); a viscous one
//! has a loss that grows with frequency, 1/(Re λ + j·Im λ·√(x/Re λ) − x), which is
//! 1/(ω_n² − ω² + jη_nω_nω), exact for real shapes (theory.md, eq. 16–17). Its derivative
//! by Im λ over j stands for that by Re λ as well, from which it differs by half a loss
//! factor: estimates lose η² of their information, steps converge by a factor of about η.

use crate::damping::leakage::{Leakage, LeakingPole};
use crate::damping::limits;
use crate::data::columns::inverse;
use chladni_frf::Damping;
use num_complex::Complex64;

/// Loss at x over that at the natural frequency.
#[inline]
pub(crate) fn loss(law: Damping, pole: Complex64, x: f64) -> f64 {
    match law {
        Damping::Structural => 1.0,
        Damping::Viscous => (x / pole.re.max(f64::MIN_POSITIVE)).sqrt(),
    }
}

/// The column at x that a residue of the pole multiplies.
#[inline]
pub(crate) fn resonance(law: Damping, pole: Complex64, x: f64) -> Complex64 {
    match law {
        Damping::Structural => inverse(pole - x),
        Damping::Viscous => {
            let lossy = pole.im * loss(law, pole, x);
            inverse(Complex64::new(pole.re - x, lossy))
        }
    }
}

/// The column that a residue of a pole multiplies where FRFs leak, with its derivative.
pub(crate) struct Leaking<'a> {
    law: Damping,
    leakage: &'a Leakage,
    /// Above the real axis.
    pole: Complex64,
    /// The pole asked for lies below: its column is the conjugate.
    mirrored: bool,
    of_receptance: LeakingPole,
}

impl<'a> Leaking<'a> {
    pub fn new(law: Damping, leakage: &'a Leakage, pole: Complex64) -> Self {
        let mirrored = pole.im < 0.0;
        let pole = if mirrored { pole.conj() } else { pole };
        Self {
            law,
            leakage,
            pole,
            mirrored,
            of_receptance: leaking_pole(law, pole),
        }
    }

    /// Column and derivative at x.
    #[inline]
    pub fn at(&self, x: f64) -> [Complex64; 2] {
        let plain = resonance(self.law, self.pole, x);
        let [factor, slope] = self.leakage.factor(&self.of_receptance, x.sqrt());
        let along = -plain * plain * loss(self.law, self.pole, x);
        let both = [plain * factor, along * factor + plain * slope];
        if self.mirrored {
            both.map(|v| v.conj())
        } else {
            both
        }
    }
}

/// The pole of receptance of λ (Im λ ≥ 0).
pub(crate) fn leaking_pole(law: Damping, pole: Complex64) -> LeakingPole {
    match law {
        // beyond half of critical damping s and s* draw near and meet; such a pole is
        // background, so broad that nothing leaks
        Damping::Viscous if pole.im < pole.re => {
            let s = viscous_pole_of(pole);
            LeakingPole {
                s,
                other: s.conj(),
                slope: Complex64::new(0.0, 0.5 / pole.re.sqrt()),
            }
        }
        _ => {
            let s = Complex64::i() * pole.sqrt();
            LeakingPole {
                s,
                other: -s,
                slope: -0.5 / s,
            }
        }
    }
}

/// Place of a pole of the other law in the plane of this one: the same resonance, s =
/// j√λ, has ω_n² = |λ_structural|. `None`: Re λ ≤ 0 (ζ > 0.71), which is background.
///
/// |Im λ|: below the band the loss of a viscous mode, seen from above, rises where the
/// structural one stands still, and the structural pole that mimics it best has a negative
/// one.
pub(crate) fn in_plane_of(law: Damping, lambda: Complex64) -> Option<Complex64> {
    if lambda.re <= 0.0 {
        return None;
    }
    let lambda = Complex64::new(
        lambda.re,
        lambda.im.abs().max(limits::LEAST_LOSS * lambda.re),
    );
    Some(match law {
        Damping::Viscous => {
            let s = Complex64::i() * lambda.sqrt();
            lambda.norm() * Complex64::new(1.0, -2.0 * s.re / s.norm())
        }
        Damping::Structural => -viscous_pole_of(lambda).powi(2),
    })
}

/// s/ω_max of a viscous mode with ω_n² = Re λ and η_n = Im λ/Re λ.
pub(crate) fn viscous_pole_of(lambda: Complex64) -> Complex64 {
    let zeta = 0.5 * lambda.im / lambda.re;
    let root = Complex64::new(1.0 - zeta * zeta, 0.0).sqrt();
    lambda.re.sqrt() * (Complex64::i() * root - zeta)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::damping::window_kernel::WindowKernel;

    #[test]
    fn planes_of_both_laws_hold_the_same_resonances() {
        for lambda in [Complex64::new(0.3, 0.02), Complex64::new(0.05, 0.03)] {
            let viscous = in_plane_of(Damping::Viscous, lambda).unwrap();
            let back = in_plane_of(Damping::Structural, viscous).unwrap();
            assert!((back - lambda).norm() < 1e-14, "{back} for {lambda}");
            let s = viscous_pole_of(viscous);
            assert!((s - Complex64::i() * lambda.sqrt()).norm() < 1e-14, "{s}");
        }
        let mirrored = in_plane_of(Damping::Viscous, Complex64::new(0.3, -0.02));
        assert_eq!(
            mirrored,
            in_plane_of(Damping::Viscous, Complex64::new(0.3, 0.02))
        );
        assert_eq!(
            in_plane_of(Damping::Viscous, Complex64::new(-0.1, 0.02)),
            None
        );
    }

    #[test]
    fn columns_that_leak_are_finite_however_heavy_the_damping() {
        let kernel = WindowKernel::cosines(&[0.5, -0.25]);
        let leakage = Leakage::new(kernel, 3000.0, 1);
        for law in [Damping::Structural, Damping::Viscous] {
            for (re, im) in [(0.3, 0.5), (0.3, 0.6), (0.3, 0.7), (0.3, -0.6)] {
                let pole = Complex64::new(re, im);
                let leaking = Leaking::new(law, &leakage, pole);
                for x in [0.05, 0.3, 0.9] {
                    let plain = resonance(law, pole, x);
                    let [value, slope] = leaking.at(x);
                    assert!(slope.is_finite(), "{law:?} {pole} {x}");
                    assert!(
                        (value - plain).norm() < 0.05 * plain.norm(),
                        "{law:?} {pole} {x}: {value} for {plain}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_viscous_column_is_that_of_its_pair_of_poles() {
        let lambda = Complex64::new(0.4, 0.4 * 0.06);
        let s = viscous_pole_of(lambda);
        for x in [0.05, 0.39, 0.4, 1.0_f64] {
            let jy = Complex64::new(0.0, x.sqrt());
            let over = Complex64::new(0.0, 2.0 * s.im);
            let pair = 1.0 / (over * (jy - s)) - 1.0 / (over * (jy - s.conj()));
            let column = resonance(Damping::Viscous, lambda, x);
            assert!((column - pair).norm() < 1e-13 * pair.norm(), "{x}");
        }
    }
}
