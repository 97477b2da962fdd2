//! Properties of a damping law, for rooms that need not know which it is.

use crate::damping::limits;
use crate::damping::places::in_plane_of;
use crate::tolerances as tol;
use chladni_frf::{Damping, FrfKind};
use num_complex::Complex64;

/// The law whose columns are rational in x.
pub(crate) const RATIONAL: Damping = Damping::Structural;

/// The law that is tried first: searches are fast in it.
pub(crate) const FIRST: Damping = RATIONAL;

/// The law of methods that find poles s by classic rational fractions in jω.
pub(crate) const CLASSIC: Damping = Damping::Viscous;

/// True where columns are rational in x and linear over complex residues, so that a zero
/// of a polynomial in x is a pole; otherwise residues are pairs of reals.
pub(crate) fn is_rational(law: Damping) -> bool {
    law == RATIONAL
}

/// The loss factor below which a pole has a natural frequency, as model files need it.
pub(crate) fn loss_bound(law: Damping) -> f64 {
    match law {
        Damping::Structural => f64::INFINITY,
        Damping::Viscous => tol::VISCOUS_LOSS_MOST,
    }
}

/// The pole λ after a step from `before`, kept below critical damping in the viscous law.
pub(crate) fn oscillating(law: Damping, next: Complex64, before: Complex64) -> Complex64 {
    let Complex64 { re, im } = next;
    match law {
        Damping::Structural => next,
        Damping::Viscous => Complex64::new(re, im.min((limits::LOSS_MOST * re).max(before.im))),
    }
}

/// The start in a law of a pole that vector fitting found in x; `None` where it stands for
/// nothing.
///
/// * `flipped`: below the real axis. What stands for a viscous mode below the band may have
///   a negative loss in x
/// * `in_band`: a place between the first and the last line
/// * `least`: Re λ of a pole at x < 0, which represents modes far below the band
pub(crate) fn start_of(
    law: Damping,
    pole: Complex64,
    flipped: bool,
    in_band: impl Fn(Complex64) -> bool,
    least: f64,
) -> Option<Complex64> {
    match law {
        Damping::Structural => (!flipped).then(|| Complex64::new(pole.re.max(least), pole.im)),
        Damping::Viscous if flipped && in_band(pole) => None,
        Damping::Viscous => in_plane_of(law, pole),
    }
}

/// Factor that makes a saved residue that of [`crate::damping::columns`], at the pole's
/// value in its law: 2jω_d in the viscous law, where r = ψL/(2jω_d).
pub(crate) fn residue_unit(law: Damping, value: Complex64) -> Complex64 {
    match law {
        Damping::Structural => Complex64::ONE,
        Damping::Viscous => Complex64::new(0.0, 2.0 * value.im),
    }
}

/// Power of s with which modal constants grow where the residue of an FRF of a kind stays:
/// κ(s)·α(s) with κ ∝ s^p has s^(1−p) (structural, R = 2sr) or s^−p (viscous).
pub(crate) fn constant_power(law: Damping, kind: FrfKind) -> i32 {
    match law {
        Damping::Viscous => -kind.omega_power(),
        Damping::Structural => 1 - kind.omega_power(),
    }
}
