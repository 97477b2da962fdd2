//! The place of a pole: λ in the plane x = ω²/ω_max², s in that of Laplace, and the value
//! that stands for it in the columns of its law.

use crate::damping::limits;
use chladni_frf::{Damping, Mode};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// The value of a pole of the x plane in its law: λ, or s.
pub(crate) fn value_in(law: Damping, lambda: Complex64) -> Complex64 {
    match law {
        Damping::Structural => lambda,
        Damping::Viscous => viscous_pole_of(lambda),
    }
}

/// λ of the pole that has this value in its law: the zero of its denominator in x.
pub(crate) fn lambda_of_value(law: Damping, value: Complex64) -> Complex64 {
    match law {
        Damping::Structural => value,
        Damping::Viscous => -value * value,
    }
}

/// s/ω_max of a pole λ.
pub(crate) fn s_of_lambda(law: Damping, lambda: Complex64) -> Complex64 {
    match law {
        Damping::Structural => s_of_structural(lambda),
        Damping::Viscous => viscous_pole_of(lambda),
    }
}

/// λ of a pole s/ω_max.
pub(crate) fn lambda_of_s(law: Damping, s: Complex64) -> Complex64 {
    match law {
        Damping::Structural => -s * s,
        Damping::Viscous => in_plane_of(law, -s * s).unwrap_or(-s * s),
    }
}

/// s of a mode, rad/s, upper half plane: −ζω + jω_d, or j√λ with λ = ω²(1 + jη).
pub(crate) fn s_of_mode(law: Damping, mode: &Mode) -> Complex64 {
    match law {
        Damping::Viscous => mode.viscous_pole(),
        Damping::Structural => {
            TAU * mode.frequency_hz * Complex64::i() * Complex64::new(1.0, mode.loss_factor).sqrt()
        }
    }
}

/// Undamped angular frequency, in the unit of `s`, and loss factor of a pole s.
pub(crate) fn frequency_and_loss(law: Damping, s: Complex64) -> (f64, f64) {
    match law {
        Damping::Viscous => (s.norm(), -2.0 * s.re / s.norm()),
        Damping::Structural => {
            let lambda = -s * s;
            (lambda.re.max(0.0).sqrt(), lambda.im / lambda.re)
        }
    }
}

/// The value in its law of a mode's pole, in units of `omega_max`² or `omega_max`.
pub(crate) fn value_of(mode: &Mode, law: Damping, omega_max: f64) -> Complex64 {
    let ratio = TAU * mode.frequency_hz / omega_max;
    match law {
        Damping::Structural => ratio * ratio * Complex64::new(1.0, mode.loss_factor),
        Damping::Viscous => mode.viscous_pole() / omega_max,
    }
}

/// s = j√λ: the viscous pole of the same resonance. Using √Re λ instead is wrong by ζ².
pub(crate) fn s_of_structural(lambda: Complex64) -> Complex64 {
    Complex64::i() * lambda.sqrt()
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
}
