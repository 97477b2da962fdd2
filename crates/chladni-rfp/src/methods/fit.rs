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
    /// Orders tried: (poles, residual variance relative to the data's mean square), in
    /// order.
    pub history: Vec<(usize, f64)>,
    /// Poles by order, where the method looks at several.
    pub stabilization: Option<Stabilization>,
}

/// A fit with what the checks of its data need.
pub(crate) struct FitToCheck {
    pub fit: Fit,
    pub residual: Residual,
    /// Sum of squares left of each FRF; empty where that does not tell its noise.
    pub left_of_frfs: Vec<f64>,
}

/// The result of one run of a method.
pub(crate) enum MethodRun {
    /// A fit.
    Fitted(Box<FitToCheck>),
    /// Outlier lines (positions among those used) to leave out before the next run.
    LeaveOut(Vec<usize>),
}

impl MethodRun {
    /// A fit whose checks go by the noise that it found.
    pub fn whole(model: ModalModel, stabilization: Option<Stabilization>) -> Self {
        let fit = Fit {
            model,
            history: Vec::new(),
            stabilization,
        };
        Self::Fitted(Box::new(FitToCheck {
            fit,
            residual: Residual::White,
            left_of_frfs: Vec::new(),
        }))
    }
}
