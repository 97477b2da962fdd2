//! The poles of a model in its law, and its FRFs as they were measured: with leakage, where
//! that is known.

use crate::damping::places::s_of_mode;
use crate::data::window::leakage::Leakage;
use chladni_frf::{Damping, FrfKind, ModalModel};
use ndarray::Array2;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// The FRF matrix of `model` on one line.
pub(crate) fn frf_matrix(
    model: &ModalModel,
    leakage: Option<&Leakage>,
    (kind, omega_max): (FrfKind, f64),
    frequency_hz: f64,
) -> Array2<Complex64> {
    let mut matrix = model.frf_matrix(kind, frequency_hz);
    let Some(leakage) = leakage else {
        return matrix;
    };
    let unit = omega_max.powi(kind.omega_power() - 2);
    let line = leakage.line(TAU * frequency_hz / omega_max);
    for mode in &model.modes {
        let s = s_of_mode(model.damping, mode) / omega_max;
        let other = match model.damping {
            Damping::Viscous => s.conj(),
            Damping::Structural => -s,
        };
        let added = unit * leakage.of_pole(s).added(other, &line);
        for (mut row, shape) in matrix.rows_mut().into_iter().zip(&mode.shape.0) {
            for (value, participation) in row.iter_mut().zip(&mode.participation.0) {
                *value += added * shape * participation;
            }
        }
    }
    matrix
}
