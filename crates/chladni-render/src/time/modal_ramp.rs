//! The matrix K that makes any path of steady drives quiet: a(t) = A(t) + K·dA/dt
//! (theory.md, eq. 64 and 65).
//!
//! Let each mode near the carrier follow the path without lag, z_n(t) = u(t)·Z_n with its
//! steady state Z_n. Its equation then asks for a = u·A + u̇·a₁ with r·Lᵀa₁ = Z_n; what
//! is far follows at once but for its own lag, which a₁ is to undo, too. Both in least
//! squares, each row weighted by what its error does to the ground.

use crate::panel::kernel_error::unsolvable;
use crate::panel::operator::Operator;
use crate::time::causal::CausalModel;
use crate::tolerances;
use chladni_frf::{ModalModel, Result};
use chladni_linalg::{
    cholesky, matmul, matmul_h, singular_values, solve_lower, solve_lower_adjoint,
};
use ndarray::{concatenate, Array2, Axis};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// K of a model about `frequency_hz`, s, for all its references; axes (actuator,
/// actuator): a(t) = A(t) + K·dA/dt.
///
/// # Errors
/// As [`Operator::of_model`].
pub fn modal_ramp(model: &ModalModel, frequency_hz: f64) -> Result<Array2<Complex64>> {
    let operator = Operator::of_model(model, frequency_hz, None)?;
    correction(&CausalModel::new(model, &operator)?)
}

/// K, s; axes (actuator, actuator). Without a mode near the carrier it undoes the lag of
/// what is far.
///
/// # Errors
/// Those of the factorisation: a broken promise.
pub(crate) fn correction(model: &CausalModel) -> Result<Array2<Complex64>> {
    let (near, far): (Vec<usize>, Vec<usize>) =
        (0..model.poles.len()).partition(|&n| n < model.modes() && is_near(model, n));
    let mut left = model.inputs.select(Axis(0), &near);
    let mut right = left.clone();
    for (k, &n) in near.iter().enumerate() {
        let distance = model.distance(n);
        let weight = model.rms_shape(n) / distance.norm().max(TAU * tolerances::NEAREST_POLE_HZ);
        left.row_mut(k).mapv_inplace(|value| value * weight);
        right
            .row_mut(k)
            .mapv_inplace(|value| value * weight / distance);
    }
    let of_row = 1.0 / (model.shapes.nrows() as f64).sqrt();
    let at_once = &model.direct + &model.of_poles(far.iter().copied(), 1);
    let lag = &model.slope - &model.of_poles(far, 2);
    let left = concatenate![Axis(0), left, at_once.mapv(|value| value * of_row)];
    let right = concatenate![Axis(0), right, lag.mapv(|value| -value * of_row)];
    regularised(&left, &right)
}

/// True for poles whose frequency lies so near that they do not follow at once.
fn is_near(model: &CausalModel, pole: usize) -> bool {
    if model.is_at_rest(pole) {
        return false;
    }
    let frequency = model.poles[pole].norm();
    (frequency - model.carrier_rad_per_s).abs() < TAU * tolerances::NEAR_MODES_HZ
}

/// (LᴴL + ε²)⁻¹·LᴴR with ε = `tolerances::MODAL_RAMP_RIDGE`·σ_max(L).
fn regularised(left: &Array2<Complex64>, right: &Array2<Complex64>) -> Result<Array2<Complex64>> {
    let mut gram = matmul_h(left.view(), left.view());
    let singular = singular_values(gram.view()).map_err(unsolvable)?;
    let largest = singular.first().copied().unwrap_or(0.0);
    let ridge = (tolerances::MODAL_RAMP_RIDGE.powi(2) * largest).max(f64::MIN_POSITIVE);
    gram.diag_mut().mapv_inplace(|value| value + ridge);
    let lower = cholesky(gram.view()).map_err(unsolvable)?;
    let projected = matmul_h(left.view(), right.view());
    let half = solve_lower(lower.view(), projected.view()).map_err(unsolvable)?;
    solve_lower_adjoint(lower.view(), half.view()).map_err(unsolvable)
}

/// K·A of each pattern; axes (pattern, actuator).
pub(crate) fn corrected(
    correction: &Array2<Complex64>,
    patterns: &Array2<Complex64>,
) -> Array2<Complex64> {
    matmul(patterns.view(), correction.t())
}
