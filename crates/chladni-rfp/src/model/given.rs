//! Poles of a known model, for a fit of residues to other FRFs of the same structure.

use crate::damping::places::{lambda_of_value, value_of};
use crate::data::columns::Columns;
use crate::data::grade::Grade;
use crate::model::identified::{Identified, LawOpen};
use crate::model::residues::linear;
use crate::poles::pole::Pole;
use chladni_frf::{Damping, ModalModel, Mode, Trust};
use chladni_linalg::LinalgError;
use ndarray::Array2;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Poles with their error bars and grades, and the residual terms that go with them.
pub(crate) struct GivenPoles {
    damping: Damping,
    poles: Vec<Pole>,
    /// Powers of x of the residual terms.
    pub powers: Vec<i32>,
}

impl GivenPoles {
    /// The poles of all modes that are not rejected, those outside the band included.
    pub fn new(model: &ModalModel, omega_max: f64) -> Self {
        let pole = |mode: &Mode| Pole {
            value: value_of(mode, model.damping, omega_max),
            omega: TAU * mode.frequency_hz / omega_max,
            loss_factor: mode.loss_factor,
            omega_std: TAU * mode.frequency_std_hz / omega_max,
            loss_factor_std: mode.loss_factor_std,
            grade: Grade {
                trust: mode.trust,
                reasons: mode.reasons.0.clone(),
            },
            given: None,
        };
        let mut poles: Vec<Pole> = model
            .modes
            .iter()
            .filter(|mode| mode.trust != Trust::Rejected)
            .map(pole)
            .collect();
        // a model lists a pole outside the band once for each of its shapes
        poles.dedup_by(|b, a| a.value == b.value);
        Self {
            damping: model.damping,
            poles,
            powers: model
                .residual_terms
                .terms
                .iter()
                .map(|term| term.power / 2)
                .collect(),
        }
    }

    /// Poles in the x plane.
    pub fn lambda(&self) -> Vec<Complex64> {
        let lambda = |pole: &Pole| lambda_of_value(self.damping, pole.value);
        self.poles.iter().map(lambda).collect()
    }

    /// Number of columns of the model.
    pub fn unknowns(&self) -> usize {
        self.poles.len() + self.powers.len()
    }

    /// The poles with the columns that residues are to be found on.
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn on(self, work: Columns, back: Option<Array2<f64>>) -> Result<Identified, LinalgError> {
        let values: Vec<Complex64> = self.poles.iter().map(|pole| pole.value).collect();
        let dof = work.lines().saturating_sub(self.unknowns()).max(1) * work.columns().max(1);
        let work = work.in_law(self.damping);
        let variance = linear(&work, self.damping, &values, &self.powers)?.sse / dof as f64;
        Ok(Identified {
            damping: self.damping,
            poles: self.poles,
            powers: self.powers,
            work,
            back,
            variance,
            path: "residues at the poles of a model".into(),
            warnings: Vec::new(),
            consistent: true,
            real_shapes: false,
            law_open: LawOpen::No,
            fitted: false,
            residual_is_noise: true,
        })
    }
}
