//! A small model for the tests of this crate.

use chladni_frf::{Damping, Dof, ModalModel, Node};
use chladni_plate::{Synthetic, SyntheticShapes};
use ndarray::Array1;

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
