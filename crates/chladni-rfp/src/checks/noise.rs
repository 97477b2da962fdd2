//! Modes that noise alone would show.

use crate::checks::around::pole;
use crate::checks::case::{Case, Checked};
use crate::checks::limits;
use crate::damping::structural::{basis, POWERS};
use crate::data::screening::Screened;
use crate::poles::significance::threshold;
use crate::shapes::line_products::background;
use chladni_frf::{Finding, Mode, Reason, Trust};
use chladni_linalg::blocked::projected;
use chladni_linalg::matmul_h;
use ndarray::{Array1, Array2, Axis};
use num_complex::Complex64;

/// Positions of the modes of the band that are sure.
fn sure(case: &Case) -> Vec<usize> {
    let modes = case.model.modes.iter().enumerate();
    let sure = modes.filter(|(_, mode)| mode.in_band && mode.trust == Trust::Sure);
    sure.map(|(n, _)| n).collect()
}

/// So few lines that poles, residues and residual terms would explain any values.
pub(crate) fn few_lines(case: &Case) -> Option<Checked> {
    let (lines, frfs) = (case.data.lines.len(), case.data.pairs.len());
    let counts = |mode: &&Mode| mode.trust != Trust::Rejected;
    let poles = case.model.modes.iter().filter(counts).count();
    let of_frf = poles + case.model.residual_terms.terms.len();
    let left = lines.saturating_sub(of_frf) * frfs;
    if left >= poles + limits::LEAST_LEFT {
        return None;
    }
    let unknowns = of_frf * frfs + poles;
    let words = format!(
        "{} complex values, {unknowns} unknowns: what is left over says nothing of the noise",
        lines * frfs
    );
    let reason = Reason::new("few-lines", "too few lines are left over to judge it by");
    Some(Checked {
        finding: Finding::caution("few-lines", words)
            .value("values", (lines * frfs) as f64)
            .value("unknowns", unknowns as f64)
            .help("measure more lines or more points"),
        weak: sure(case)
            .into_iter()
            .map(|n| (n, reason.clone()))
            .collect(),
    })
}

/// Modes that stand out of the mean noise of all FRFs, and not where each FRF is judged by its
/// own: in data that are mostly noise the loudest FRFs pretend modes.
pub(crate) fn noise_alone(case: &Case) -> Option<Checked> {
    let data = case.values?;
    let sure = sure(case);
    if case.model.quality.relative_error < limits::MOSTLY_NOISE || sure.is_empty() {
        return None;
    }
    let weak: Vec<usize> = sure
        .into_iter()
        .filter(|&n| stands_out(case, data, n) == Some(false))
        .collect();
    if weak.is_empty() {
        return None;
    }
    let hz = weak.iter().map(|&n| case.model.modes[n].frequency_hz);
    let finding = Finding::caution(
        "noise-alone",
        "most of the data is noise, stronger in some FRFs than in others: over the noise of each \
         FRF modes do not stand out",
    )
    .modes_hz(hz)
    .help("average more, or leave the noisiest points out");
    let reason = Reason::new("noise-alone", "noise of unequal FRFs would show as much");
    let weak = weak.into_iter().map(|n| (n, reason.clone())).collect();
    Some(Checked { finding, weak })
}

/// True where a mode explains more of some FRFs, or of all together, than chance does, each
/// over its own noise.
fn stands_out(case: &Case, data: &Screened, n: usize) -> Option<bool> {
    let (axis, modes) = (case.data.axis(), &case.model.modes);
    let counts = |mode: &&Mode| mode.trust != Trust::Rejected;
    let others = modes
        .iter()
        .filter(counts)
        .filter(|mode| **mode != modes[n]);
    let others: Vec<Complex64> = others.map(|mode| pole(case, mode)).collect();
    let beside = background(&axis, &others, &POWERS).ok()?;
    let mut own = projected(
        beside.view(),
        basis(&axis, &[pole(case, &modes[n])], &[]).view(),
    )
    .1;
    let norm = own.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt();
    own.mapv_inplace(|value| value / norm);
    let free = axis.lines().checked_sub(beside.ncols() + 1)?;
    let (mut sum, mut largest, frfs) = (0.0, 0.0_f64, data.pairs.len());
    for first in (0..frfs).step_by(limits::NOISE_FRFS) {
        let last = (first + limits::NOISE_FRFS).min(frfs);
        let values: Array2<Complex64> = data.block(first..last, 0..axis.lines());
        let left = projected(beside.view(), values.view()).1;
        let explained = matmul_h(own.view(), left.view()).map(Complex64::norm_sqr);
        let all: Array1<f64> = left.map(Complex64::norm_sqr).sum_axis(Axis(0));
        for (explained, all) in explained.iter().zip(all) {
            let share = explained * free as f64 / (all - explained).max(f64::MIN_POSITIVE);
            sum += share;
            largest = largest.max(share);
        }
    }
    let of_one = threshold(1, axis.lines() * frfs);
    Some(sum > threshold(frfs, axis.lines()) || largest > of_one)
}
