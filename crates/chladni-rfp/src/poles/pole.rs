//! A pole of the model: frequency, damping, their error bars, its grade.

use crate::damping::bars::UncertainPole;
use crate::damping::law;
use crate::damping::places::value_in;
use crate::data::grade::Grade;
use crate::poles::estimate::{is_uncertain, uncertainty_grade};
use crate::poles::limits;
use chladni_frf::{Damping, Trust};
use ndarray::Array2;
use num_complex::Complex64;

/// Shapes and participations that were found together with a pole: (shape, response) and (shape,
/// reference).
pub(crate) type Given = Option<(Array2<Complex64>, Array2<Complex64>)>;

/// A pole of the model, in units of ω_max.
#[derive(Debug, Clone)]
pub(crate) struct Pole {
    /// λ (structural) or s (viscous), in units of ω_max² or ω_max.
    pub value: Complex64,
    /// ω_n/ω_max.
    pub omega: f64,
    /// η_n.
    pub loss_factor: f64,
    /// Standard deviation of ω_n/ω_max.
    pub omega_std: f64,
    /// Standard deviation of η_n.
    pub loss_factor_std: f64,
    pub grade: Grade,
    pub given: Given,
}

impl Pole {
    /// A pole with its grade.
    pub fn new(pole: UncertainPole, grade: Grade) -> Self {
        let UncertainPole {
            value,
            omega,
            loss_factor,
            omega_std,
            loss_factor_std,
        } = pole;
        Self {
            value,
            omega,
            loss_factor,
            omega_std,
            loss_factor_std,
            grade,
            given: None,
        }
    }

    /// ω_n²(1 + jη_n)/ω_max².
    pub fn lambda(&self) -> Complex64 {
        self.omega.powi(2) * Complex64::new(1.0, self.loss_factor)
    }

    /// Factor from a residue as model files have it to one of [`crate::damping::columns`].
    pub fn residue_unit(&self, law: Damping) -> Complex64 {
        law::residue_unit(law, self.value)
    }

    /// Moves the pole to ω_n²(1 + jη_n)/ω_max² = `lambda`; error bars stay.
    pub fn move_to(&mut self, lambda: Complex64, law: Damping) {
        self.value = value_in(law, lambda);
        self.omega = lambda.re.max(0.0).sqrt();
        self.loss_factor = lambda.im / lambda.re;
    }

    /// Doubts a sure pole whose error bars have become too large, and no longer a pole for error bars
    /// that have become small enough.
    pub fn grade_anew(&mut self) {
        let doubted = match self.grade.reasons.as_slice() {
            [] => false,
            [only] => is_uncertain(only),
            _ => return,
        };
        let lambda = self.lambda();
        let of_omega = (2.0 * self.omega * self.omega_std).powi(2);
        let of_loss = (lambda.re * self.loss_factor_std).powi(2);
        if doubted || self.grade.trust == Trust::Sure {
            self.grade = uncertainty_grade(lambda, [of_omega, of_loss]);
        }
    }

    /// True if ω_n²(1 + jη_n)/ω_max² is `lambda`, to rounding.
    pub fn is_at(&self, lambda: Complex64) -> bool {
        (self.lambda() - lambda).norm() < limits::SAME * lambda.norm()
    }
}
