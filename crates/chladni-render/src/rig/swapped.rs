//! Two swapped cables: each of two channels plays what is meant for the other.
//!
//! The field is then v̂ + (h_i − h_j)(A_j − A_i), without a free size (theory.md, eq. 57a). All pairs
//! of channels are weighed: the neighbours of a pair explain a part of it and would be called odd
//! otherwise, and all channels together nearly all of it. The pair is held against faults of one
//! and two channels and against several odd ones (`channel_faults`).

use super::channel_faults::likeliest_faults;
use super::field::Prediction;
use super::weighed::View;
use crate::panel::operator::Operator;
use crate::tolerances;
use chladni_frf::{Dof, Finding, Result};
use ndarray::Array1;
use num_complex::Complex64;

/// The likeliest pair of channels that are swapped.
pub(super) struct Swap {
    channels: [usize; 2],
    references: [Dof; 2],
    /// ln of the evidence over that of no fault, pairs counted, and the same with gains that
    /// scatter besides.
    ln_evidence: [f64; 2],
    /// Mean square of the whitened difference that the swap and such gains leave.
    left: f64,
}

/// Two cables that are swapped beyond doubt.
pub(crate) struct Swapped {
    /// Places of both among the actuators.
    pub(super) channels: [usize; 2],
    references: [Dof; 2],
    ln_evidence: f64,
    /// The same of the next cause.
    next: f64,
}

impl Swapped {
    pub(super) fn finding(&self) -> Finding {
        let words = format!(
            "{} (ln of the evidence {:.1}, {:.1} of the next cause)",
            swap_in_words(self.references),
            self.ln_evidence,
            self.next
        );
        Finding::caution("channels-swapped", words)
            .dofs(self.references)
            .value("ln_evidence", self.ln_evidence)
            .help("exchange both cables, and measure the field again")
    }
}

/// Two swapped cables in words.
pub(super) fn swap_in_words([one, other]: [Dof; 2]) -> String {
    format!(
        "the cables of {one} and {other} are swapped: each channel plays the weight of the other"
    )
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
        let drive = &prediction.drive;
        let count = drive.len();
        let pairs = (0..count).flat_map(|i| (i + 1..count).map(move |j| [i, j]));
        let pairs: Vec<[usize; 2]> = pairs.filter(|&[i, j]| drive[i] != drive[j]).collect();
        let alone = match view.field.magnitudes_only {
            true => (pairs.iter())
                .map(|&pair| view.fixed(&change(prediction, pair), pairs.len()))
                .collect::<Result<_>>()?,
            false => with_phases(view, prediction, &pairs)?,
        };
        let mut swaps: Vec<([usize; 2], f64)> = pairs.iter().copied().zip(alone).collect();
        swaps.sort_by(|a, b| b.1.total_cmp(&a.1));
        swaps.truncate(tolerances::SWAPS_WEIGHED);
        let mut best: Option<Self> = None;
        for (channels, alone) in swaps {
            let paths = prediction.paths(&exchanged(drive, channels));
            let change = change(prediction, channels);
            let beside = view.fixed_and_scattered(&change, &paths, pairs.len())?;
            let swap = Self {
                channels,
                references: channels.map(|channel| operator.references[channel]),
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

    /// The swap, where no other cause comes near and it explains the field.
    ///
    /// * `likeliest`: ln of the evidence of the likeliest cause of the diagnosis
    pub(super) fn told(
        &self,
        view: &View,
        prediction: &Prediction,
        likeliest: f64,
    ) -> Result<Option<Swapped>> {
        let stands = |next: f64| self.most() > next + tolerances::SWAP_EVIDENCE;
        let explains = self.left <= tolerances::SWAP_LEAVES
            && view.field.rows.len() >= tolerances::SWAP_RESPONSES;
        if !explains || !stands(likeliest) {
            return Ok(None);
        }
        let next = likeliest.max(likeliest_faults(view, prediction)?);
        Ok(stands(next).then(|| Swapped {
            channels: self.channels,
            references: self.references,
            ln_evidence: self.most(),
            next,
        }))
    }
}

/// The drive with the weights of two channels exchanged.
pub(super) fn exchanged(drive: &Array1<Complex64>, [i, j]: [usize; 2]) -> Array1<Complex64> {
    let mut drive = drive.clone();
    drive.swap(i, j);
    drive
}

/// The change of the field by two swapped cables.
fn change(prediction: &Prediction, [i, j]: [usize; 2]) -> Array1<Complex64> {
    let (mobility, drive) = (&prediction.mobility, &prediction.drive);
    let moved = drive[j] - drive[i];
    (&mobility.column(i) - &mobility.column(j)).mapv(|path| path * moved)
}

/// True where the field is likelier with two cables exchanged than as it is, gains that scatter
/// beside both.
pub(super) fn is_exchanged(
    view: &View,
    prediction: &Prediction,
    channels: [usize; 2],
) -> Result<bool> {
    let drive = &prediction.drive;
    let weighed = |change: &Array1<Complex64>, drive: &Array1<Complex64>| -> Result<f64> {
        let beside = view.fixed_and_scattered(change, &prediction.paths(drive), 1)?;
        Ok(view.fixed(change, 1)?.max(beside.ln_evidence))
    };
    let as_it_is = weighed(&Array1::zeros(prediction.velocity.len()), drive)?;
    let swapped = weighed(&change(prediction, channels), &exchanged(drive, channels))?;
    Ok(swapped > as_it_is)
}

/// Evidence of each of `pairs`, of a field with phases: whitening is linear, so one solution per
/// channel serves all.
fn with_phases(view: &View, prediction: &Prediction, pairs: &[[usize; 2]]) -> Result<Vec<f64>> {
    let columns = prediction.mobility.columns().into_iter();
    let white = columns
        .map(|column| view.white(column))
        .collect::<Result<Vec<Array1<Complex64>>>>()?;
    let of_pair = |&[i, j]: &[usize; 2]| {
        let moved = prediction.drive[j] - prediction.drive[i];
        let change = (white[i].iter().zip(&white[j])).map(|(one, other)| (one - other) * moved);
        view.fixed_of_white(change, pairs.len())
    };
    Ok(pairs.iter().map(of_pair).collect())
}
