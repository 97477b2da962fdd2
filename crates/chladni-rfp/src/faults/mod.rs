//! Faults of the data: what is wrong with a measurement although every number in it can
//! be fitted.
//!
//! Before the fit: a window whose bias can be undone ([`window`]; line shapes may tell
//! which it was, [`line_shape`]), FRFs far noisier than the others ([`noisy`]). After it,
//! with the model at hand: lines that no neighbour supports ([`outliers`], left out and
//! fitted again), then a list of checks, each of which names what it found with the
//! evidence. Last, the artificial decay of an exponential window is taken off the poles
//! ([`exponential`]).
//!
//! Elsewhere: the wrong time sign ([`crate::order::Outcome::Conjugated`]), zero-padded
//! records and leakage-prone damping ([`crate::measured`]), missing values
//! ([`crate::screen`]).

mod delay;
pub(crate) mod exponential;
mod hidden;
mod kind;
mod line_shape;
mod moving;
pub(crate) mod noisy;
pub(crate) mod outliers;
mod reciprocal;
mod split;
pub(crate) mod window;

use crate::head::Head;
use crate::options::FitOptions;
use crate::screen::Screened;
use chladni_frf::{ModalModel, Mode, Trust};
use rayon::prelude::*;

/// What a check may look at.
pub(crate) struct Case<'a> {
    /// What is known of the data that were fitted.
    pub data: &'a Head,
    /// The data themselves, where they are at hand: checks that look at single FRFs are
    /// left out where they are not.
    pub values: Option<&'a Screened<'a>>,
    /// What came of it.
    pub model: &'a ModalModel,
    /// How it was asked for.
    pub options: &'a FitOptions,
    /// True where the residual is white: the lines are pure resonances within the noise.
    pub white: bool,
}

/// What a check found.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Finding {
    /// The fault, the evidence, what to do.
    pub words: String,
    /// True where the data as a whole contradict the model: it cannot be trusted then.
    pub contradiction: bool,
    /// Modes (positions in the model) that are weak for it.
    pub weak: Vec<usize>,
    /// Why.
    pub reason: &'static str,
}

impl Finding {
    fn new(words: String, contradiction: bool) -> Self {
        Self {
            words,
            contradiction,
            weak: Vec::new(),
            reason: "",
        }
    }
    /// Words alone.
    fn note(words: String) -> Self {
        Self::new(words, false)
    }
    /// The data as a whole contradict the model.
    fn contradiction(words: String) -> Self {
        Self::new(words, true)
    }
}

/// Every check that runs after a fit.
const CHECKS: [fn(&Case) -> Option<Finding>; 8] = [
    kind::wrong_kind,
    moving::moving_poles,
    split::split_modes,
    hidden::single_frf,
    hidden::between_modes,
    delay::delayed_reference,
    reciprocal::not_reciprocal,
    window::possible_bias,
];

/// Runs all checks; their words join the model's warnings.
pub(crate) fn examine(
    data: &Head,
    values: Option<&Screened>,
    options: &FitOptions,
    white: bool,
    model: &mut ModalModel,
) {
    let case = Case {
        data,
        values,
        model,
        options,
        white,
    };
    let found: Vec<Finding> = CHECKS.par_iter().filter_map(|check| check(&case)).collect();
    for finding in found {
        model.quality.trusted &= !finding.contradiction;
        for &n in &finding.weak {
            let mode = &mut model.modes[n];
            mode.trust = Trust::Weak;
            mode.reasons.push(finding.reason.into());
        }
        model.quality.warnings.push(finding.words);
    }
    let sure = model.in_band_modes().any(|mode| mode.trust == Trust::Sure);
    model.quality.trusted &= sure;
}

impl Case<'_> {
    /// Noise variance of one work value, where the residual is noise.
    fn noise_variance(&self) -> f64 {
        (self.model.quality.relative_error * self.data.measured_over_used()).powi(2)
    }

    /// In-band modes without doubts.
    fn sure_modes(&self) -> Vec<&Mode> {
        self.model
            .in_band_modes()
            .filter(|mode| mode.trust == Trust::Sure)
            .collect()
    }
}
