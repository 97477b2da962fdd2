//! The results of every method: a fit, or outlier lines to leave out before there is one.

use crate::methods::found::Stabilization;
use crate::poles::whiteness::Residual;
use chladni_frf::ModalModel;

/// A fit with its history.
#[derive(Debug, Clone)]
#[must_use]
#[non_exhaustive]
pub struct Fit {
    /// The model, ready to be saved.
    pub model: ModalModel,
    /// Orders tried by the fast chain: (poles, residual variance relative to the data's mean
    /// square), in order. Empty for other methods, and if the residual is not white.
    pub history: Vec<(usize, f64)>,
    /// Poles by order, where the method looks at several.
    pub stabilization: Option<Stabilization>,
}

/// A fit with what the checks of its data need.
pub(crate) struct FitToCheck {
    pub fit: Fit,
    pub residual: Residual,
    /// Residual energy of each FRF; empty if that does not tell its noise.
    pub residual_energy_of_frfs: Vec<f64>,
}

/// The result of one run of a method.
pub(crate) enum MethodRun {
    /// A fit.
    Fitted(Box<FitToCheck>),
    /// Outlier lines (positions among those used) to leave out before the next run.
    LeaveOut(Vec<usize>),
}

impl MethodRun {
    /// A fit of a method that does not test its residual. The checks take the residual for noise.
    pub fn not_judged(model: ModalModel, stabilization: Option<Stabilization>) -> Self {
        let fit = Fit {
            model,
            history: Vec::new(),
            stabilization,
        };
        Self::Fitted(Box::new(FitToCheck {
            fit,
            residual: Residual::NotJudged,
            residual_energy_of_frfs: Vec::new(),
        }))
    }
}
