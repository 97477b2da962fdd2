//! Two swapped cables: each of two channels plays what is meant for the other.
//!
//! Beside every other cause the field is then v̂ + (h_i − h_j)(A_j − A_i), without a free size.
//! All pairs of channels are weighed; the neighbours of a pair explain a part of it and would be
//! called odd otherwise.

use super::diagnosis::{Hypothesis, Place};
use super::field::Prediction;
use crate::operator::Operator;
use crate::tolerances;
use chladni_frf::{Dof, Finding, Result};
use ndarray::Array1;
use num_complex::Complex64;

/// The likeliest pair of channels that are swapped.
pub(super) struct Swap {
    /// The channels.
    pub(super) channels: [Dof; 2],
    /// Weight of the second over that of the first.
    pub(super) factor: Complex64,
    /// ln of the evidence over that of no fault, pairs counted.
    pub(super) ln_evidence: f64,
}

impl Swap {
    /// The likeliest pair; `None` where its first channel is still.
    ///
    /// * `weigh`: ln of the evidence for a change of the field, of so many alternatives
    pub(super) fn likeliest(
        operator: &Operator,
        prediction: &Prediction,
        weigh: impl Fn(&Array1<Complex64>, usize) -> Result<f64>,
    ) -> Result<Option<Self>> {
        let (mobility, drive) = (&prediction.mobility, &prediction.drive);
        let count = drive.len();
        let mut best: Option<Self> = None;
        for (i, j) in (0..count).flat_map(|i| (i + 1..count).map(move |j| (i, j))) {
            let moved = drive[j] - drive[i];
            let change = (&mobility.column(i) - &mobility.column(j)).mapv(|path| path * moved);
            let ln_evidence = weigh(&change, count * (count - 1) / 2)?;
            if best
                .as_ref()
                .is_none_or(|best| ln_evidence > best.ln_evidence)
            {
                best = Some(Self {
                    channels: [i, j].map(|channel| operator.references[channel]),
                    factor: drive[j] / drive[i],
                    ln_evidence,
                });
            }
        }
        Ok(best.filter(|best| best.factor.is_finite()))
    }

    /// The swap as a hypothesis: the first channel has the weight of the second.
    pub(super) fn hypothesis(&self) -> Hypothesis {
        let error = self.factor - 1.0;
        Hypothesis {
            kind: "channel".into(),
            place: Some(Place::Channel(self.channels[0])),
            value: Some([error.re, error.im]),
            std: None,
            ln_evidence: self.ln_evidence,
        }
    }

    /// The finding, where no other of `causes` comes near.
    pub(super) fn finding(&self, causes: &[Hypothesis]) -> Option<Finding> {
        let best = causes.iter().map(|cause| cause.ln_evidence);
        let best = best.fold(f64::NEG_INFINITY, f64::max);
        let [one, other] = self.channels;
        let words = format!(
            "the cables of {one} and {other} are swapped: each channel plays the weight of the other \
             (ln of the evidence {:.1}, {best:.1} of the next cause)",
            self.ln_evidence
        );
        (self.ln_evidence > best + tolerances::SWAP_EVIDENCE).then(|| {
            Finding::caution("channels-swapped", words)
                .dofs(self.channels)
                .value("ln_evidence", self.ln_evidence)
                .help("exchange both cables, and measure the field again")
        })
    }
}
