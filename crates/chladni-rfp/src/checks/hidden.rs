//! Modes that these data could not show: a mode at a node of the only FRF, or between
//! modes that overlap (theory.md, eq. F7).

use crate::checks::around::{pole, strength};
use crate::checks::case::{Case, Checked};
use crate::checks::limits;
use crate::damping::basis::basis;
use crate::damping::basis::RESIDUAL_POWERS;
use crate::data::columns::Columns;
use crate::data::options::ShapeModel;
use crate::poles::significance::threshold;
use crate::shapes::line_products::background;
use chladni_frf::{Finding, Mode};
use chladni_linalg::blocked::projected;
use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// One FRF does not show every mode.
pub(crate) fn single_frf(case: &Case) -> Option<Checked> {
    (case.data.pairs.len() == 1).then(|| {
        Finding::note(
            "one-frf",
            "one FRF: a mode with a node at its response or its reference does not show in it",
        )
        .help("measure more points")
        .into()
    })
}

/// Gaps between overlapping modes in which one more, as strong as they are, would not
/// stand out of the noise.
pub(crate) fn between_modes(case: &Case) -> Option<Checked> {
    if !case.noise_is_known {
        return None;
    }
    let mut modes: Vec<&Mode> = case.model.in_band_modes().collect();
    modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    let axis = case.data.axis();
    let hides = |pair: &&[&Mode]| could_hide(case, &axis, pair).unwrap_or(false);
    let gaps: Vec<&[&Mode]> = modes.par_windows(2).filter(hides).collect();
    if gaps.is_empty() {
        return None;
    }
    let between = |pair: &&[&Mode]| {
        format!(
            "{:.1} and {:.1}",
            pair[0].frequency_hz, pair[1].frequency_hz
        )
    };
    let words = format!(
        "modes overlap: between {} Hz one more, as strong as they are, could hide in this noise",
        gaps.iter().map(between).collect::<Vec<_>>().join("; ")
    );
    let finding = Finding::note("mode-could-hide", words)
        .modes_hz(gaps.iter().copied().flatten().map(|mode| mode.frequency_hz))
        .help("more references or less noise would show it");
    Some(finding.into())
}

/// True where a mode halfway between two others would add less to the data than a mode
/// must to be found; `None` where the two do not overlap.
fn could_hide(case: &Case, axis: &Columns, pair: &[&Mode]) -> Option<bool> {
    let poles = [pole(case, pair[0]), pole(case, pair[1])];
    let place = 0.5 * (poles[0] + poles[1]);
    if !limits::HIDING_OVERLAP.contains(&(2.0 * place.im / (poles[1].re - poles[0].re))) {
        return None;
    }
    let local = axis.select(
        &axis
            .window(place, limits::HIDDEN_WINDOW.0, limits::HIDDEN_WINDOW.1)
            .collect::<Vec<_>>(),
    );
    let mut around: Vec<Complex64> = case
        .model
        .modes
        .iter()
        .map(|mode| pole(case, mode))
        .collect();
    around.sort_by(|a, b| (a - place).norm().total_cmp(&(b - place).norm()));
    around.truncate(limits::NEIGHBOURS);
    // of unit height at its resonance
    let top = axis
        .x
        .partition_point(|x| *x < place.re)
        .min(axis.lines() - 1);
    let mode = basis(&local, &[place], &[]) * Complex64::from(place.im / axis.g[top]);
    let left = |poles: &[Complex64]| -> Option<f64> {
        let taken = background(&local, poles, &RESIDUAL_POWERS).ok()?;
        Some(
            projected(taken.view(), mode.view())
                .1
                .iter()
                .map(|v| v.norm_sqr())
                .sum(),
        )
    };
    let (beside_terms, beside_all) = (left(&[])?, left(&around)?);
    let overlapping = around
        .iter()
        .filter(|near| (near.re - place.re).abs() < near.im + place.im)
        .count();
    let free = unshared(case, overlapping);
    let energy = height(case, pair[0])
        * height(case, pair[1])
        * (free * beside_terms + (1.0 - free) * beside_all);
    let frfs = case.data.pairs.len();
    Some(energy < (threshold(frfs, local.lines()) - frfs as f64) * case.noise.variance)
}

/// Part of the residues of one more mode that `modes` of rank one cannot take over,
/// whatever their shapes do: what is left of the responses · references directions.
fn unshared(case: &Case, modes: usize) -> f64 {
    let (responses, references) = (case.data.responses.len(), case.data.references.len());
    let all = responses * references;
    if case.options.shapes == ShapeModel::Free || case.data.pairs.len() < all {
        return 0.0;
    }
    (1.0 - (modes * (responses + references - 1)) as f64 / all as f64).max(0.0)
}

/// Root of the mode's energy at its resonance over all FRFs, in work units.
fn height(case: &Case, mode: &Mode) -> f64 {
    let data = case.data;
    let residue = data
        .pairs
        .iter()
        .map(|&(i, j)| (strength(mode, (i, j)) * data.weight_of((i, j))).powi(2));
    let omega = TAU * mode.frequency_hz;
    let kind = data.kind.from_receptance(omega).norm();
    residue.sum::<f64>().sqrt() * kind * data.factor().norm() / (mode.loss_factor * omega * omega)
}
