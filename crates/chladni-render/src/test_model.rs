//! A small model and a problem for the tests of this crate.

use crate::panel::covariance::Covariance;
use crate::panel::drive::DriveLimits;
use crate::problems::problem::{Problem, Rows};
use crate::scene::limits::Limits;
use chladni_frf::{Damping, Dof, ModalModel, Node, ReferenceUnit};
use chladni_plate::{Synthetic, SyntheticShapes};
use ndarray::{Array1, Array2};
use num_complex::Complex64;

/// A model with real shapes of modes (natural frequency in Hz, loss factor), so many
/// responses and references, and the responses on a grid of four columns, 10 mm apart.
pub(crate) fn test_model(
    damping: Damping,
    modes: &[(f64, f64)],
    [responses, references]: [usize; 2],
) -> ModalModel {
    let mut model = Synthetic {
        natural_frequency_hz: modes.iter().map(|mode| mode.0).collect(),
        loss_factor: modes.iter().map(|mode| mode.1).collect(),
        responses,
        references,
        shapes: SyntheticShapes::Real,
        damping,
        frequency_hz: Array1::range(10.0, 200.0, 1.0),
        residual_powers: Vec::new(),
        ..Synthetic::default()
    }
    .build()
    .unwrap()
    .truth;
    let node = |(k, dof): (usize, &Dof)| Node {
        label: dof.node,
        xyz_m: [0.01 * (k % 4) as f64, 0.01 * (k / 4) as f64, 0.0],
    };
    model.nodes = model.responses.iter().enumerate().map(node).collect();
    model
}

/// A problem of rows with these levels, the first `hot` of them hot, felt from 1 m/s and quiet up to
/// 0.8 m/s.
///
/// * `error`: standard deviation of each entry of the mobility
/// * `each`: most of each weight
pub(crate) fn test_problem(
    (mobility, levels): (Array2<Complex64>, Array1<f64>),
    hot: usize,
    error: f64,
    each: f64,
) -> Problem {
    let gram = Array2::from_diag_elem(mobility.ncols(), Complex64::from(error * error));
    let rows = Rows {
        hot,
        positions_m: vec![[0.0; 2]; mobility.nrows()],
        mobility,
        levels,
    };
    let limits = Limits {
        threshold_m_per_s: 0.9,
        hot_m_per_s: 1.0,
        cold_m_per_s: 0.8,
    };
    let drive_limits = DriveLimits {
        each,
        effort: f64::INFINITY,
        unit: ReferenceUnit::Newton,
    };
    Problem::new(
        rows,
        Covariance::of_gram(gram).unwrap(),
        limits,
        drive_limits,
    )
}
