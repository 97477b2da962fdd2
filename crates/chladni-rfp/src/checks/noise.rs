//! Modes that noise alone would show.

use crate::checks::around::pole;
use crate::checks::case::{Case, Checked};
use crate::checks::limits;
use crate::damping::basis::{basis, RESIDUAL_POWERS};
use crate::data::columns::Columns;
use crate::data::noise_levels::UnevenNoise;
use crate::data::screening::Screened;
use crate::poles::estimate::is_uncertain;
use crate::poles::significance::threshold;
use crate::shapes::line_products::background;
use chladni_frf::{Finding, Mode, Reason, Trust};
use chladni_linalg::blocked::projected;
use chladni_linalg::matmul_h;
use ndarray::{s, stack, Array1, Array2, Axis};
use num_complex::Complex64;
use rayon::prelude::*;

/// Positions of the modes of the band that are sure.
fn sure(case: &Case) -> Vec<usize> {
    let modes = case.model.modes.iter().enumerate();
    let sure = modes.filter(|(_, mode)| mode.in_band && mode.trust == Trust::Sure);
    sure.map(|(n, _)| n).collect()
}

/// Modes that are sure, and those that their error bars alone make weak.
fn sure_or_uncertain(case: &Case) -> Vec<usize> {
    let modes = case.model.modes.iter().enumerate();
    let uncertain = |mode: &Mode| {
        mode.trust == Trust::Weak
            && !mode.reasons.is_empty()
            && mode.reasons.iter().all(is_uncertain)
    };
    let asked = |mode: &Mode| mode.in_band && (mode.trust == Trust::Sure || uncertain(mode));
    let asked = modes.filter(|(_, mode)| asked(mode));
    asked.map(|(n, _)| n).collect()
}

/// So few lines that poles, residues and residual terms would explain any values.
pub(crate) fn few_values(case: &Case) -> Option<Checked> {
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
    let reason = Reason::new("few-values", "too few values are left over to judge it by");
    Some(Checked {
        finding: Finding::caution("few-values", words)
            .value("values", (lines * frfs) as f64)
            .value("unknowns", unknowns as f64)
            .help("measure more lines or more points"),
        weak: sure(case)
            .into_iter()
            .map(|n| (n, reason.clone()))
            .collect(),
    })
}

/// Modes that stand out of the mean noise of all FRFs, but not of the noise of each FRF. The
/// loudest FRFs feign modes in data that are mostly noise, and where the weights of responses and
/// references do not make the noise of FRFs equal.
pub(crate) fn noise_alone(case: &Case) -> Option<Checked> {
    let mostly_noise = case.model.quality.relative_error >= limits::MOSTLY_NOISE;
    let uneven = case.noise_is_known.then(|| uneven_noise(case)).flatten();
    let asked: Vec<usize> = match (mostly_noise, uneven) {
        (true, _) => sure(case),
        // bars that follow the noise of FRFs may have made a feigned mode weak, and do not say why
        (false, Some(spread)) => sure_or_uncertain(case)
            .into_iter()
            .filter(|&n| may_be_noise(case, n, spread))
            .collect(),
        (false, None) => return None,
    };
    if asked.is_empty() {
        return None;
    }
    let stand_out = stand_out(case, case.values?, &asked)?;
    let modes = asked.into_iter().zip(stand_out);
    let weak: Vec<usize> = modes.filter(|(_, out)| !out).map(|(n, _)| n).collect();
    if weak.is_empty() {
        return None;
    }
    let hz = weak.iter().map(|&n| case.model.modes[n].frequency_hz);
    let words = match mostly_noise {
        true => "most of the data is noise, stronger in some FRFs than in others",
        false => "noise is stronger in some FRFs than their responses and references explain",
    };
    let finding = Finding::caution(
        "noise-alone",
        format!("{words}: over the noise of each FRF modes do not stand out"),
    )
    .modes_hz(hz)
    .help("average more, or leave the noisiest points out");
    let reason = Reason::new(
        "noise-alone",
        "it does not stand out of the noise of each FRF",
    );
    let weak = weak.into_iter().map(|n| (n, reason.clone())).collect();
    Some(Checked { finding, weak })
}

/// Variance of the noise of FRFs over the square of its mean, where that is more than chance makes.
fn uneven_noise(case: &Case) -> Option<f64> {
    let unknowns = case.model.modes.len() + case.model.residual_terms.terms.len();
    let left = case.noise.residual_energy_of_frfs;
    UnevenNoise::new(left, case.data.lines.len(), unknowns).map(|noise| noise.spread)
}

/// True for a mode whose bars are so wide that noise of this `spread` might feign it. A mode that
/// takes g·σ² out of the sum of squares has a pole of variance (half-bandwidth)²/(2g).
fn may_be_noise(case: &Case, n: usize, spread: f64) -> bool {
    let mode = &case.model.modes[n];
    let half_bandwidth_hz = 0.5 * mode.loss_factor * mode.frequency_hz;
    let gain = 0.5 * (half_bandwidth_hz / mode.frequency_std_hz).powi(2);
    let by_chance = threshold(case.data.pairs.len(), case.data.lines.len()) * (1.0 + spread);
    gain < limits::CLEAR_OF_NOISE * by_chance
}

/// For each mode, true if it explains more of one FRF, of some or of all than chance does, each
/// FRF over its own noise. `None` if too few lines are left to tell.
///
/// The part e that a column explains beyond all others, over what is left ℓ on m free lines,
/// makes m·ln(1 + e/ℓ) exponential with mean 1 where there is noise alone.
fn stand_out(case: &Case, data: &Screened, modes: &[usize]) -> Option<Vec<bool>> {
    let axis = case.data.axis();
    let counts = |mode: &&Mode| mode.trust != Trust::Rejected;
    let modelled = case.model.modes.iter().filter(counts);
    let poles: Vec<Complex64> = modelled.map(|mode| pole(case, mode)).collect();
    let all = background(&axis, &poles, &RESIDUAL_POWERS).ok()?;
    let free = axis.lines().checked_sub(all.ncols() + 1)? as f64;
    let own = |&n: &usize| own_part(&axis, &poles, pole(case, &case.model.modes[n]));
    let own: Vec<Option<Array1<Complex64>>> = modes.par_iter().map(own).collect();
    let told: Vec<_> = own.iter().flatten().map(|column| column.view()).collect();
    let told = stack(Axis(1), &told).ok()?;
    let frfs = data.pairs.len();
    let mut shares = Array2::zeros((told.ncols(), frfs));
    for first in (0..frfs).step_by(limits::NOISE_FRFS) {
        let part = first..(first + limits::NOISE_FRFS).min(frfs);
        let values = data.block(part.clone(), 0..axis.lines());
        let left = projected(all.view(), values.view()).1;
        let left: Array1<f64> = left.map(Complex64::norm_sqr).sum_axis(Axis(0));
        let share =
            |e: &Complex64, left: &f64| free * (e.norm_sqr() / left.max(f64::MIN_POSITIVE)).ln_1p();
        let explained = matmul_h(told.view(), values.view());
        for (mut out, explained) in shares.rows_mut().into_iter().zip(explained.rows()) {
            let values = explained.iter().zip(&left).map(|(e, left)| share(e, left));
            out.slice_mut(s![part.clone()])
                .assign(&values.collect::<Array1<f64>>());
        }
    }
    let mut shares = shares.rows().into_iter();
    let stands = |own: &Option<_>| {
        let row = own.as_ref().and_then(|_: &Array1<Complex64>| shares.next());
        row.is_none_or(|shares| beyond_chance(shares.to_vec(), axis.lines()))
    };
    Some(own.iter().map(stands).collect())
}

/// The unit column of a pole without what other poles and residual terms explain; `None`
/// where nothing is left of it, as of poles that nearly coincide.
fn own_part(axis: &Columns, poles: &[Complex64], own: Complex64) -> Option<Array1<Complex64>> {
    let others: Vec<Complex64> = poles.iter().copied().filter(|pole| *pole != own).collect();
    let beside = background(axis, &others, &RESIDUAL_POWERS).ok()?;
    let column = basis(axis, &[own], &[]);
    let square = |column: &Array2<Complex64>| column.iter().map(Complex64::norm_sqr).sum::<f64>();
    let part = projected(beside.view(), column.view()).1;
    let told = square(&part) > limits::OWN_LEAST * square(&column);
    told.then(|| part.column(0).to_owned() / Complex64::from(square(&part).sqrt()))
}

/// True where the largest of these shares, the largest few or all of them are more than those
/// of noise.
fn beyond_chance(mut shares: Vec<f64>, lines: usize) -> bool {
    shares.sort_by(|a, b| b.total_cmp(a));
    let frfs = shares.len();
    let few = (frfs as f64).sqrt().ceil() as usize;
    [1, few, frfs].into_iter().any(|count| {
        let sum: f64 = shares[..count].iter().sum();
        let of_choice = count as f64 * (frfs as f64 / count as f64).ln();
        sum > of_choice + threshold(count, lines)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_frf::Damping;

    #[test]
    fn of_poles_that_coincide_none_has_a_part_of_its_own() {
        let x: Vec<f64> = (1..=100).map(|k| 0.01 * f64::from(k)).collect();
        let axis = Columns {
            g: vec![1.0; x.len()],
            b: Array2::zeros((x.len(), 0)),
            x,
            law: Damping::Structural,
            leakage: None,
            neighbours: 0.0,
        };
        let [pole, far] = [0.3, 0.7].map(|re| Complex64::new(re, 0.02));
        let part = own_part(&axis, &[pole, far], pole).unwrap();
        let norm: f64 = part.iter().map(Complex64::norm_sqr).sum();
        assert!((norm - 1.0).abs() < 1e-12);
        assert_eq!(
            own_part(&axis, &[pole, pole * (1.0 + 1e-9), far], pole),
            None
        );
    }

    #[test]
    fn one_frf_a_few_or_all_may_stand_out_and_noise_does_not() {
        // quantiles of an exponential distribution
        let noise = |k: usize| -((k as f64 + 0.5) / 400.0).ln();
        let shares: Vec<f64> = (0..400).map(noise).collect();
        assert!(!beyond_chance(shares.clone(), 1000));
        let raised = |count: usize, by: f64| {
            let mut shares = shares.clone();
            shares[..count].iter_mut().for_each(|share| *share += by);
            beyond_chance(shares, 1000)
        };
        assert!(raised(1, 60.0) && raised(20, 12.0) && raised(400, 1.0));
        assert!(!raised(1, 6.0) && !raised(400, 0.1));
    }
}
