//! Two swapped cables: each of two channels plays what is meant for the other.
//!
//! The field is then v̂ + (h_i − h_j)(A_j − A_i), without a free size (theory.md, eq. 57a). All pairs
//! of channels are weighed: the neighbours of a pair explain a part of it and would be called odd
//! otherwise, and all channels together nearly all of it.

use super::field::Prediction;
use super::hypothesis::{Hypothesis, Place};
use super::weighed::View;
use crate::panel::operator::Operator;
use crate::tolerances;
use chladni_frf::{Dof, Finding, Result};
use ndarray::Array1;
use num_complex::Complex64;

/// The likeliest pair of channels that are swapped.
pub(super) struct Swap {
    channels: [Dof; 2],
    /// ln of the evidence over that of no fault, pairs counted, and the same with gains that
    /// scatter besides.
    ln_evidence: [f64; 2],
    /// Mean square of the whitened difference that the swap and such gains leave.
    left: f64,
}

impl Swap {
    /// The likeliest pair; `None` where no two channels differ in weight. Gains that scatter
    /// explain a field that is swapped, too: of the likeliest pairs those of the swapped
    /// channels have a say.
    pub(super) fn likeliest(
        view: &View,
        operator: &Operator,
        prediction: &Prediction,
    ) -> Result<Option<Self>> {
        let (mobility, drive) = (&prediction.mobility, &prediction.drive);
        let count = drive.len();
        let pairs = (0..count).flat_map(|i| (i + 1..count).map(move |j| [i, j]));
        let pairs: Vec<[usize; 2]> = pairs.filter(|&[i, j]| drive[i] != drive[j]).collect();
        let change = |[i, j]: [usize; 2]| {
            let moved = drive[j] - drive[i];
            (&mobility.column(i) - &mobility.column(j)).mapv(|path| path * moved)
        };
        let alone = match view.field.magnitudes_only {
            true => (pairs.iter())
                .map(|&pair| view.fixed(&change(pair), pairs.len()))
                .collect::<Result<_>>()?,
            false => with_phases(view, prediction, &pairs)?,
        };
        let mut swaps: Vec<([usize; 2], f64)> = pairs.iter().copied().zip(alone).collect();
        swaps.sort_by(|a, b| b.1.total_cmp(&a.1));
        swaps.truncate(tolerances::SWAPS_WEIGHED);
        let mut best: Option<Self> = None;
        for ([i, j], alone) in swaps {
            let mut swapped = drive.clone();
            swapped.swap(i, j);
            let paths = prediction.paths(&swapped);
            let beside = view.fixed_and_scattered(&change([i, j]), &paths, pairs.len())?;
            let swap = Self {
                channels: [i, j].map(|channel| operator.references[channel]),
                ln_evidence: [alone, beside.ln_evidence],
                left: beside.left,
            };
            if best.as_ref().is_none_or(|best| swap.most() > best.most()) {
                best = Some(swap);
            }
        }
        Ok(best)
    }

    fn most(&self) -> f64 {
        self.ln_evidence[0].max(self.ln_evidence[1])
    }

    /// The finding, where no other of `causes` comes near and the swap explains the field; faults
    /// of one channel are weighed as the swap is, alone and with gains that scatter besides.
    pub(super) fn finding(
        &self,
        view: &View,
        prediction: &Prediction,
        operator: &Operator,
        causes: &[Hypothesis],
    ) -> Result<Option<Finding>> {
        let mut next = f64::NEG_INFINITY;
        for cause in causes {
            next = next.max(cause.ln_evidence);
            let (Some(Place::Channel(dof)), Some([re, im])) = (cause.place, cause.value) else {
                continue;
            };
            let Some(i) = operator.references.iter().position(|own| *own == dof) else {
                continue;
            };
            let error = Complex64::new(re, im);
            let mut paths = prediction.paths(&prediction.drive);
            let change = paths[i].mapv(|path| path * error);
            paths[i] += &change;
            let count = prediction.drive.len();
            let beside = view.fixed_and_scattered(&change, &paths, count)?;
            next = next.max(beside.ln_evidence);
        }
        let told = self.most() > next + tolerances::SWAP_EVIDENCE
            && self.left <= tolerances::SWAP_LEAVES
            && view.field.rows.len() >= tolerances::SWAP_RESPONSES;
        if !told {
            return Ok(None);
        }
        let [one, other] = self.channels;
        let words = format!(
            "the cables of {one} and {other} are swapped: each channel plays the weight of the other \
             (ln of the evidence {:.1}, {next:.1} of the next cause)",
            self.most()
        );
        Ok(Some(
            Finding::caution("channels-swapped", words)
                .dofs(self.channels)
                .value("ln_evidence", self.most())
                .help("exchange both cables, and measure the field again"),
        ))
    }
}

/// Evidence of each of `pairs`, of a field with phases: whitening is linear, so one solution per
/// channel serves all.
fn with_phases(view: &View, prediction: &Prediction, pairs: &[[usize; 2]]) -> Result<Vec<f64>> {
    let columns = prediction.mobility.columns().into_iter();
    let white = columns
        .map(|column| view.white(column))
        .collect::<Result<Vec<Array1<Complex64>>>>()?;
    let rows = view.difference.len() / 2;
    let of_pair = |&[i, j]: &[usize; 2]| {
        let moved = prediction.drive[j] - prediction.drive[i];
        let changed = (0..rows).map(|k| {
            let change = (white[i][k] - white[j][k]) * moved;
            let left = Complex64::new(view.difference[k], view.difference[rows + k]);
            (left.conj() * change).re - 0.5 * change.norm_sqr()
        });
        changed.sum::<f64>() - (pairs.len() as f64).ln()
    };
    Ok(pairs.iter().map(of_pair).collect())
}
