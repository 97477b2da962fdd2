//! One pole as every later step sees it: frequency, damping, their error bars, its grade.

use crate::damping::columns::viscous_pole_of;
use crate::poles::limits;
use chladni_frf::{Damping, Reason, Trust};
use ndarray::Array2;
use num_complex::Complex64;

/// Grade of one pole with its reasons.
pub(crate) type Grade = (Trust, Vec<Reason>);

/// Shapes and participations of some poles that are given: (row, response) and (row,
/// reference).
pub(crate) type Given = Option<(Array2<Complex64>, Array2<Complex64>)>;

/// One pole as the model will show it, in units of ω_max.
#[derive(Debug, Clone)]
pub(crate) struct Pole {
    /// λ (structural) or s (viscous), in units of ω_max² or ω_max.
    pub value: Complex64,
    /// ω_n/ω_max.
    pub omega: f64,
    /// η_n.
    pub loss_factor: f64,
    /// Standard deviations of the two.
    pub omega_std: f64,
    /// Standard deviation of η_n.
    pub loss_factor_std: f64,
    /// Grade.
    pub grade: Grade,
    /// Shapes and participations that came with the pole.
    pub given: Given,
}

impl Pole {
    /// ω_n²(1 + jη_n) over ω_max²: the pole in the x plane of its own law.
    pub fn lambda(&self) -> Complex64 {
        self.omega.powi(2) * Complex64::new(1.0, self.loss_factor)
    }

    /// Factor that makes a saved residue that of [`crate::damping::columns`]: 2jω_d in
    /// the viscous law, where r = ψL/(2jω_d).
    pub fn residue_unit(&self, law: Damping) -> Complex64 {
        match law {
            Damping::Structural => Complex64::ONE,
            Damping::Viscous => Complex64::new(0.0, 2.0 * self.value.im),
        }
    }

    /// Puts the pole at `lambda` of the x plane, in its own law; error bars stay.
    pub fn move_to(&mut self, lambda: Complex64, law: Damping) {
        self.value = value_in(law, lambda);
        self.omega = lambda.re.max(0.0).sqrt();
        self.loss_factor = lambda.im / lambda.re;
    }

    /// True where that is `lambda`, to rounding.
    pub fn stands_at(&self, lambda: Complex64) -> bool {
        (self.lambda() - lambda).norm() < limits::SAME * lambda.norm()
    }
}

/// A pole of the x plane as its law has it: λ, or s.
pub(crate) fn value_in(law: Damping, lambda: Complex64) -> Complex64 {
    match law {
        Damping::Structural => lambda,
        Damping::Viscous => viscous_pole_of(lambda),
    }
}

/// Undamped frequency, loss factor and their deviations of a structural pole with the
/// variances of Re λ and Im λ.
pub(crate) fn structural_pole(lambda: Complex64, variance: [f64; 2], grade: Grade) -> Pole {
    let omega = lambda.re.max(0.0).sqrt();
    let deviation = variance.map(|v| v.max(0.0).sqrt());
    Pole {
        value: lambda,
        omega,
        loss_factor: lambda.im / lambda.re,
        omega_std: deviation[0] / (2.0 * omega),
        loss_factor_std: deviation[1] / lambda.re.abs(),
        grade,
        given: None,
    }
}

/// The same of a viscous pole with the 2 × 2 covariance of (Re s, Im s).
pub(crate) fn viscous_pole(s: Complex64, covariance: [[f64; 2]; 2], grade: Grade) -> Pole {
    let omega = s.norm();
    let zeta = -s.re / omega;
    // ∂|s| = (Re s, Im s)/|s|; ∂ζ = (−Im², Re·Im)/|s|³
    let along = |g: [f64; 2]| {
        (g[0] * g[0] * covariance[0][0]
            + 2.0 * g[0] * g[1] * covariance[0][1]
            + g[1] * g[1] * covariance[1][1])
            .max(0.0)
            .sqrt()
    };
    let cubed = omega.powi(3);
    Pole {
        value: s,
        omega,
        loss_factor: 2.0 * zeta,
        omega_std: along([s.re / omega, s.im / omega]),
        loss_factor_std: 2.0 * along([-s.im * s.im / cubed, s.re * s.im / cubed]),
        grade,
        given: None,
    }
}
