//! The data that a check may look at, and its outcome.

use crate::data::layout::DataLayout;
use crate::data::options::FitOptions;
use crate::data::screening::Screened;
use chladni_frf::{Finding, ModalModel, Mode, Reason, Trust};

/// The fit that the checks look at.
pub(crate) struct Case<'a> {
    /// The data that were fitted, without their values.
    pub data: &'a DataLayout,
    /// The data themselves, where they are at hand: checks that look at single FRFs are
    /// left out where they are not.
    pub values: Option<&'a Screened<'a>>,
    /// The result of the fit.
    pub model: &'a ModalModel,
    /// The options of the fit.
    pub options: &'a FitOptions,
    /// True if the residual is taken for noise: it is white, or the method did not test it.
    pub noise_is_known: bool,
    /// Its level in the data as they were fitted, weights included.
    pub noise: Noise<'a>,
}

/// The level of noise.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Noise<'a> {
    /// Variance of one work value, where the residual is noise.
    pub variance: f64,
    /// Residual energy of each FRF; empty where not known.
    pub residual_energy_of_frfs: &'a [f64],
}

/// The outcome of a check. A fault: the data as a whole contradict the model.
pub(crate) struct Checked {
    /// The fault of the data, the evidence, the next step.
    pub finding: Finding,
    /// Modes (positions in the model) that are weak for it, with the reason.
    pub weak: Vec<(usize, Reason)>,
}

impl From<Finding> for Checked {
    fn from(finding: Finding) -> Self {
        Self {
            finding,
            weak: Vec::new(),
        }
    }
}

impl<'a> Case<'a> {
    /// Of a fit whose window is in question. Its residual is not taken for noise: misfit of line
    /// shapes is what is looked for.
    pub(crate) fn of_fit(
        data: &'a Screened<'a>,
        model: &'a ModalModel,
        options: &'a FitOptions,
    ) -> Self {
        Self {
            data,
            values: Some(data),
            model,
            options,
            noise_is_known: false,
            noise: Noise::default(),
        }
    }

    /// In-band modes without doubts.
    pub(crate) fn sure_modes(&self) -> Vec<&Mode> {
        self.model
            .in_band_modes()
            .filter(|mode| mode.trust == Trust::Sure)
            .collect()
    }
}
