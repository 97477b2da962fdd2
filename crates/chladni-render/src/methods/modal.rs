//! The two-step inverse of the seed paper (method `modal`), a baseline.
//!
//! 1. W by the pseudo-inverse of Γ, the γ_n at the responses, from the target field v_d = Γ·W (seed paper, eq. 10);
//! 2. A = Ψ⁺·W, Ψ the modes at the actuators (eq. 12 and 13).
//!
//! Not for use: with the exact modes of the study's panel it serves 30 to 53 % of the points at any number of modes, because
//! what the first step does not model the second one drives hard, and 34 modes of a symmetric panel cannot be set
//! independently by 34 actuators on its edge (rank 32 at most). Both are said in the warnings, with the singular values. The
//! target is 1 on hot and 0 on cold responses; as everywhere, the transition is left out. Only modes that are summed
//! explicitly are used (all in band, unless fewer are asked for): poles outside and residual terms have no place in the equations.

use crate::methods::{pressure_matching::one_phase_target, Solution};
use crate::problem::{internal, Drive};
use crate::setup::Setup;
use chladni_frf::{Damping, Error, ModalModel, Mode, Result};
use ndarray::{Array1, Array2};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// The drive of the two-step inverse with the modes that `setup` sums.
pub(crate) fn solve(setup: &Setup, model: &ModalModel) -> Result<Solution> {
    let Setup { problem, operator, judged, .. } = setup;
    let modes: Vec<&Mode> = setup.modes.iter().map(|&n| &model.modes[n]).collect();
    if modes.is_empty() {
        return Err(Error::bad_data("the model has no mode inside its band")
            .field("modes")
            .found("none")
            .expected("at least one in-band mode for the method `modal`")
            .help("take another method, or fit a band that holds modes"));
    }
    let omega = TAU * operator.frequency_hz;
    let gammas: Vec<Complex64> = modes.iter().map(|mode| gamma(mode, model.damping, omega)).collect();
    let gamma = Array2::from_shape_fn((judged.len(), modes.len()), |(k, n)| {
        let row = operator.response_rows[judged[k]];
        gammas[n] * modes[n].shape.0[row] * operator.responses[judged[k]].direction.sign()
    });
    let psi =
        Array2::from_shape_fn((modes.len(), operator.references.len()), |(n, j)| modes[n].participation.0[operator.reference_columns[j]]);

    let mut warnings = Vec::new();
    let modal_weights = pseudo_inverse_times(&gamma, &one_phase_target(problem), "Gamma (modes at the responses)", &mut warnings)?;
    let drive: Drive = pseudo_inverse_times(&psi, &modal_weights, "Psi (modes at the actuators)", &mut warnings)?;
    Ok(Solution { drive: problem.with_best_gain(&drive), warnings })
}

/// γ_n = jω/(ω_n²(1+jη_n) − ω²), (m/s)/N·kg; in the viscous law, for real shapes, jω/(ω_n² − ω² + jη_nω_nω).
fn gamma(mode: &Mode, damping: Damping, omega: f64) -> Complex64 {
    let omega_n = TAU * mode.frequency_hz;
    let loss = match damping {
        Damping::Structural => omega_n * omega_n * mode.loss_factor,
        Damping::Viscous => omega_n * omega * mode.loss_factor,
    };
    Complex64::new(0.0, omega) / Complex64::new(omega_n * omega_n - omega * omega, loss)
}

/// matrix⁺·right by the SVD; says so where the rank is short.
fn pseudo_inverse_times(
    matrix: &Array2<Complex64>,
    right: &Array1<Complex64>,
    name: &str,
    warnings: &mut Vec<String>,
) -> Result<Array1<Complex64>> {
    let (u, s, vh) = chladni_linalg::svd_thin(matrix.view()).map_err(internal)?;
    let largest = s.first().copied().unwrap_or(0.0);
    let noise = largest * f64::EPSILON * matrix.nrows().max(matrix.ncols()) as f64;
    let rank = s.iter().filter(|&&value| value > noise).count();
    if rank < s.len() {
        let values: Vec<String> = s.iter().map(|value| format!("{value:.1e}")).collect();
        warnings.push(format!(
            "{name} is rank deficient: {} x {}, rank {rank} of {}; singular values {}",
            matrix.nrows(),
            matrix.ncols(),
            s.len(),
            values.join(", ")
        ));
    } else if largest / s[s.len() - 1] > crate::tolerances::ILL_CONDITIONED {
        warnings.push(format!("{name} is ill conditioned: singular values from {:.1e} down to {:.1e}", largest, s[s.len() - 1]));
    }
    let coordinates = u.t().mapv(|value| value.conj()).dot(right);
    let scaled = Array1::from_shape_fn(s.len(), |k| if k < rank { coordinates[k] / s[k] } else { Complex64::ZERO });
    Ok(vh.t().mapv(|value| value.conj()).dot(&scaled))
}
