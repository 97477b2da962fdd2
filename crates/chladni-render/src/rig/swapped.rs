//! Two swapped cables: each of two channels plays what is meant for the other.
//!
//! Beside every other cause the field is then v̂ + (h_i − h_j)(A_j − A_i), without a free size.
//! All pairs of channels are weighed; the neighbours of a pair explain a part of it and would be
//! called odd otherwise, and all channels together nearly all of it.

use super::diagnosis::{Hypothesis, Place, View};
use super::field::Prediction;
use crate::operator::Operator;
use crate::tolerances;
use chladni_frf::{Dof, Finding, Result};
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
    /// The likeliest pair; `None` where none plays another weight than before. Gains that
    /// scatter explain a field that is swapped, too: of the likeliest pairs those of the
    /// swapped channels have a say.
    pub(super) fn likeliest(
        view: &View,
        operator: &Operator,
        prediction: &Prediction,
    ) -> Result<Option<Self>> {
        let (mobility, drive) = (&prediction.mobility, &prediction.drive);
        let count = drive.len();
        let pairs = count * count.saturating_sub(1) / 2;
        let change = |[i, j]: [usize; 2]| {
            let moved = drive[j] - drive[i];
            (&mobility.column(i) - &mobility.column(j)).mapv(|path| path * moved)
        };
        let mut swaps = Vec::with_capacity(pairs);
        for (i, j) in (0..count).flat_map(|i| (i + 1..count).map(move |j| (i, j))) {
            let factor = drive[j] / drive[i];
            if factor.is_finite() {
                swaps.push(([i, j], factor, view.fixed(&change([i, j]), pairs)?));
            }
        }
        swaps.sort_by(|a, b| b.2.total_cmp(&a.2));
        if !view.magnitudes_only() {
            swaps.truncate(tolerances::SWAPS_WEIGHED);
            for (pair, _, ln_evidence) in &mut swaps {
                let mut swapped = drive.clone();
                swapped.swap(pair[0], pair[1]);
                let paths = prediction.paths(&swapped);
                let scattered = view.fixed_and_scattered(&change(*pair), &paths, pairs)?;
                *ln_evidence = ln_evidence.max(scattered);
            }
        }
        let best = swaps.into_iter().max_by(|a, b| a.2.total_cmp(&b.2));
        Ok(best.map(|(pair, factor, ln_evidence)| Self {
            channels: pair.map(|channel| operator.references[channel]),
            factor,
            ln_evidence,
        }))
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
