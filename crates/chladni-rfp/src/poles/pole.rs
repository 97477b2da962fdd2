//! One pole as every later step sees it: frequency, damping, their error bars, its grade.

use crate::damping::bars::UncertainPole;
use crate::damping::law;
use crate::damping::places::value_in;
use crate::data::grade::Grade;
use crate::poles::limits;
use chladni_frf::Damping;
use ndarray::Array2;
use num_complex::Complex64;

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

    /// ω_n²(1 + jη_n) over ω_max²: the pole in the x plane of its own law.
    pub fn lambda(&self) -> Complex64 {
        self.omega.powi(2) * Complex64::new(1.0, self.loss_factor)
    }

    /// Factor that makes a saved residue that of [`crate::damping::columns`].
    pub fn residue_unit(&self, law: Damping) -> Complex64 {
        law::residue_unit(law, self.value)
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
