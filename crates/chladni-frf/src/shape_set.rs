//! Mode shapes wherever they come from: what a fitted model and the result of a
//! finite-element program have in common.

use crate::{Dof, ModalModel, Node};
use num_complex::Complex64;

/// Shapes at the same DOFs, with what is known of their modes.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ShapeSet {
    /// DOFs of every shape.
    pub dofs: Vec<Dof>,
    /// Positions, as far as they are known.
    pub nodes: Vec<Node>,
    /// The modes, in the order of their source.
    pub modes: Vec<ShapeMode>,
}

/// One mode of a [`ShapeSet`]. A standard deviation of 0 stands for an exact or unknown
/// value.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ShapeMode {
    /// Undamped natural frequency, Hz.
    pub frequency_hz: f64,
    /// Its standard deviation, Hz.
    pub frequency_std_hz: f64,
    /// Loss factor; `None` where the source has no damping.
    pub loss_factor: Option<f64>,
    /// Its standard deviation.
    pub loss_factor_std: f64,
    /// Values at the DOFs, in any scaling.
    pub shape: Vec<Complex64>,
    /// √E|δ|² of each value, without what only scales the whole shape.
    pub shape_std: Vec<f64>,
}

impl From<&ModalModel> for ShapeSet {
    /// The modes of the band, numbered as in its table.
    fn from(model: &ModalModel) -> Self {
        let modes = model.in_band_modes().map(|mode| ShapeMode {
            frequency_hz: mode.frequency_hz,
            frequency_std_hz: mode.frequency_std_hz,
            loss_factor: Some(mode.loss_factor),
            loss_factor_std: mode.loss_factor_std,
            shape: mode.shape.0.clone(),
            shape_std: mode.shape_std_up_to_scale(),
        });
        Self {
            dofs: model.responses.clone(),
            nodes: model.nodes.clone(),
            modes: modes.collect(),
        }
    }
}
