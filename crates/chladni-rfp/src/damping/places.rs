//! The place of a pole: λ in the plane x = ω²/ω_max², s in that of Laplace, and the value
//! that stands for it in the columns of its law.

use crate::damping::columns::{in_plane_of, viscous_pole_of};
use crate::damping::viscous::from_structural;
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
        Damping::Structural => from_structural(lambda),
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
