//! The two-step inverse of the seed paper (method `modal`), a baseline.
//!
//! 1. W by the pseudo-inverse of Γ, the γ_n at the responses, from the target field v_d =
//!    Γ·W (seed paper, eq. 10);
//! 2. A = Ψ⁺·W, Ψ the modes at the actuators (eq. 12 and 13).
//!
//! With a cut both are one: A = (ΓΨ)⁺·v_d, without small singular values. Where Γ has full
//! column rank and Ψ full row rank, Ψ⁺Γ⁺ = (ΓΨ)⁺: the same equations, and what the rig can
//! hardly do is no longer asked of it (docs/paper.md).
//!
//! Not for use: with the exact modes of the paper's panel it serves 29 to 66 % of the
//! points of a quarter at any number of modes (docs/paper.md), because what the first
//! step does not model the second one drives hard, and 34 modes of a symmetric panel
//! cannot be set independently by 34 actuators on its edge (rank 31). Both are said in
//! the warnings, with the singular values, and stand in [`ModalSteps`]. The target is 1
//! on hot and 0 on cold responses; as everywhere, the transition is left out. Only modes
//! that are summed explicitly are used (all in band, unless fewer are asked for): poles
//! outside and residual terms have no place in the equations.

use crate::methods::modal_steps::{ModalSteps, StepMatrix};
use crate::methods::pressure_matching::one_phase_target;
use crate::methods::solution::Solution;
use crate::panel::drive::{amplitude, Drive};
use crate::panel::kernel_error::unsolvable;
use crate::problems::setup::Setup;
use chladni_frf::{ComplexVector, Damping, Error, ModalModel, Mode, Result};
use ndarray::{Array1, Array2};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// The drive of the two-step inverse with the modes that `setup` sums.
/// * `cut`: see [`crate::RenderOptions::cut`]
pub(crate) fn solve(setup: &Setup, model: &ModalModel, cut: Option<f64>) -> Result<Solution> {
    let Setup {
        problem,
        operator,
        judged,
        ..
    } = setup;
    let modes: Vec<&Mode> = setup.modes.iter().map(|&n| &model.modes[n]).collect();
    if modes.is_empty() {
        return Err(Error::bad_data("the model has no mode inside its band")
            .field("modes")
            .found("none")
            .expected("at least one in-band mode for the method `modal`")
            .help("take another method, or fit a band that holds modes"));
    }
    let [gamma, psi] = matrices(setup, &modes, model.damping);
    let target = one_phase_target(problem);
    let whole = gamma.dot(&psi);
    let (gamma, asked) = pseudo_inverse_times(&gamma, &target, None)?;
    let (of_psi, two_steps): (_, Drive) = pseudo_inverse_times(&psi, &asked, None)?;
    let drive = match cut {
        Some(_) => pseudo_inverse_times(&whole, &target, cut)?.1,
        None => two_steps,
    };
    let gain = Complex64::from(problem.best_gain(&problem.field(&drive).map(amplitude), &drive));
    let drive = drive * gain;
    let sizes = [
        [judged.len(), modes.len()],
        [modes.len(), operator.references.len()],
    ];
    let matrices = [
        ("Gamma (modes at the responses)", &gamma),
        ("Psi (modes at the actuators)", &of_psi),
    ];
    let findings = matrices
        .iter()
        .filter(|_| cut.is_none())
        .zip(sizes)
        .filter_map(|((name, matrix), size)| matrix.finding(name, size))
        .collect();
    let modal = ModalSteps {
        frequency_hz: modes.iter().map(|mode| mode.frequency_hz).collect(),
        asked: ComplexVector((asked * gain).to_vec()),
        driven: ComplexVector(psi.dot(&drive).to_vec()),
        gamma,
        psi: of_psi,
    };
    Ok(Solution {
        touched_db: None,
        drive,
        findings,
        modal: Some(modal),
    })
}

/// Γ and Ψ of the modes.
fn matrices(setup: &Setup, modes: &[&Mode], damping: Damping) -> [Array2<Complex64>; 2] {
    let Setup {
        operator, judged, ..
    } = setup;
    let omega = TAU * operator.frequency_hz;
    let gammas: Vec<Complex64> = modes
        .iter()
        .map(|mode| gamma(mode, damping, omega))
        .collect();
    let gamma = Array2::from_shape_fn((judged.len(), modes.len()), |(k, n)| {
        let row = operator.response_rows[judged[k]];
        gammas[n] * modes[n].shape.0[row] * operator.responses[judged[k]].direction.sign()
    });
    let psi = Array2::from_shape_fn((modes.len(), operator.references.len()), |(n, j)| {
        modes[n].participation.0[operator.reference_columns[j]]
    });
    [gamma, psi]
}

/// γ_n = jω/(ω_n²(1+jη_n) − ω²), (m/s)/N·kg; in the viscous law, for real shapes,
/// jω/(ω_n² − ω² + jη_nω_nω).
fn gamma(mode: &Mode, damping: Damping, omega: f64) -> Complex64 {
    let omega_n = TAU * mode.frequency_hz;
    let loss = match damping {
        Damping::Structural => omega_n * omega_n * mode.loss_factor,
        Damping::Viscous => omega_n * omega * mode.loss_factor,
    };
    Complex64::new(0.0, omega) / Complex64::new(omega_n * omega_n - omega * omega, loss)
}

/// matrix⁺·right by the SVD, without singular values below `cut` of the largest, or below
/// rounding.
fn pseudo_inverse_times(
    matrix: &Array2<Complex64>,
    right: &Array1<Complex64>,
    cut: Option<f64>,
) -> Result<(StepMatrix, Array1<Complex64>)> {
    let (u, s, vh) = chladni_linalg::svd_thin(matrix.view()).map_err(unsolvable)?;
    let largest = s.first().copied().unwrap_or(0.0);
    let rounding = f64::EPSILON * matrix.nrows().max(matrix.ncols()) as f64;
    let noise = largest * rounding.max(cut.unwrap_or(0.0));
    let rank = s.iter().filter(|&&value| value > noise).count();
    let coordinates = u.t().mapv(|value| value.conj()).dot(right);
    let scaled = Array1::from_shape_fn(s.len(), |k| {
        if k < rank {
            coordinates[k] / s[k]
        } else {
            Complex64::ZERO
        }
    });
    Ok((
        StepMatrix {
            singular_values: s.to_vec(),
            rank,
        },
        vh.t().mapv(|value| value.conj()).dot(&scaled),
    ))
}
