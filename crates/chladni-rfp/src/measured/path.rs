//! The measured-data path as one walk: screen the record, weigh it, let several orders vote, refine, test locally, merge
//! twins, estimate errors from the residual, grade.

use super::consensus::{consensus, Agreed};
use super::grade::{grade, look, usual_loss, Evidence};
use super::local::{one_column_gains, remove_unneeded, try_add};
use super::record::padding_factor;
use super::sandwich::variances;
use super::twins::{merge, own_poles};
use super::weights::{column_scales, NoiseModel};
use crate::model::Grade;
use crate::order::POWERS;
use crate::refine::{refine, Refined};
use crate::screen::Screened;
use crate::seeds::{fourth_difference_noise, peaks, thinned, Peak};
use crate::tolerances as tol;
use crate::work::{basis, line_energy, Work};
use chladni_frf::Trust;
use chladni_linalg::{matmul, svd_thin, LinalgError};
use ndarray::{s, Array1, Array2, Axis};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Most columns the path works on; more FRFs than that are compressed.
const COLUMNS_MOST: usize = 24;
/// Rounds of estimating the error model from residuals.
const WEIGHT_ROUNDS: usize = 2;
/// Multiplicative error above which residual peaks are leakage, not modes.
const RESEED_BELOW: f64 = 0.01;
/// Peaks this prominent and this far over the noise deserve a try, dB.
const TRY_PROMINENCE_DB: f64 = 12.0;
/// See above, dB.
const TRY_OVER_NOISE_DB: f64 = 20.0;

/// Half-width in lines from which a line counts as resolved.
const RESOLVED_LINES: f64 = 0.5;
/// Half-widths within which no other pole may stand.
const RESOLVED_ALONE: f64 = 12.0;
/// Half-widths of the window of a resolved mode.
const RESOLVED_WINDOW: f64 = 4.0;

/// What the path found.
#[derive(Debug)]
pub(crate) struct MeasuredPoles {
    /// Poles and linear part on `work`.
    pub refined: Refined,
    /// Weighted lines and columns.
    pub work: Work,
    /// From columns to FRFs, where the columns are scaled FRFs; `None` where they are mixtures.
    pub back: Option<Array2<f64>>,
    /// E|δλ|² of each pole.
    pub variance: Vec<f64>,
    /// Grade of each pole; nuisance poles are `Weak` without reasons.
    pub grades: Vec<Grade>,
    /// Warnings.
    pub warnings: Vec<String>,
}

/// Columns for the path: scaled FRFs, or the strongest mixtures of many.
fn columns(data: &Screened, seed: u64) -> Result<(Work, Option<Array2<f64>>), LinalgError> {
    if data.pairs.len() <= COLUMNS_MOST {
        let raw = data.work();
        let scales = column_scales(&raw);
        let mut b = raw.b.clone();
        for (mut column, scale) in b.columns_mut().into_iter().zip(&scales) {
            column.mapv_inplace(|v| v / scale);
        }
        return Ok((raw.with_columns(b), Some(Array2::from_diag(&Array1::from(scales)))));
    }
    let (sketch, _) = data.sketch(seed);
    let (_, _, vh) = svd_thin(sketch.b.view())?;
    let mixing = vh.slice(s![..COLUMNS_MOST.min(vh.nrows()), ..]).mapv(|v| v.conj());
    let b = matmul(sketch.b.view(), mixing.t());
    Ok((sketch.with_columns(b), None))
}

/// Runs the path. `asked` fixes the number of modes.
pub(crate) fn measured_path(
    data: &Screened,
    seed: u64,
    asked: Option<usize>,
    progress: &dyn Fn(&str),
) -> Result<MeasuredPoles, LinalgError> {
    progress("screening");
    let mut warnings = Vec::new();
    let (mut work, back) = columns(data, seed)?;
    let hz = data.omega_max / TAU;
    let frequency: Vec<f64> = data.lines.iter().map(|&k| data.frf.frequency_hz[k]).collect();
    let factor = padding_factor(&work, &frequency);
    if factor > 1 {
        warnings.push(format!(
            "the impulse response ends at 1/{factor} of the record: zero-padded; every {factor}th line is used (the others are interpolation)"
        ));
        work = work.select(&(0..work.lines()).step_by(factor).collect::<Vec<_>>());
    }
    let noise = fourth_difference_noise(&work.b, (work.lines() / 20).clamp(30, 400));
    let seen = peaks(&work, &line_energy(&work.b), &noise);
    let rows = thinned(&work, &seen);
    let noise: Array1<f64> = rows.iter().map(|&k| noise[k]).collect();
    let work = work.select(&rows);

    progress("pole pool");
    let mut model = NoiseModel::start(noise);
    let level = line_energy(&work.b);
    let weighted = work.reweighted(&model.weights(&level));
    let seeds: Vec<Complex64> = seen.iter().map(|p| p.lambda).collect();
    let strongest = seen.iter().map(|p| p.level_db).fold(f64::MIN, f64::max);
    let strong: Vec<Complex64> = seen.iter().filter(|p| p.level_db > strongest - 30.0).map(|p| p.lambda).collect();
    let second = (strong.len() * 2 < seeds.len() && !strong.is_empty()).then_some(strong.as_slice());
    let base = asked.unwrap_or(0).max(seeds.len()).max(4);
    let votes = consensus(&weighted, &seeds, base, second, &POWERS)?;

    progress("refinement");
    let agreed = votes.agreed.len();
    let start: Vec<Complex64> = votes.agreed.iter().map(|a| a.lambda).chain(votes.nuisance.iter().copied()).collect();
    let (mut refined, mut weighted) = reweigh(&work, &weighted, &level, &start, &mut model)?;
    // poles by identity: 0.. agreed, then nuisance, then added ones
    let mut identity: Vec<usize> = (0..refined.lambda.len()).collect();
    let mut next_identity = refined.lambda.len();

    progress("local tests");
    let nuisance = |id: usize| id >= agreed && id < agreed + votes.nuisance.len();
    if model.multiplicative < RESEED_BELOW {
        for _ in 0..2 {
            if !reseed(&weighted, &mut refined, &mut identity, &mut next_identity)? {
                break;
            }
            (refined, weighted) = reweigh(&work, &weighted, &level, &refined.lambda.clone(), &mut model)?;
        }
    }
    remove_unneeded(&weighted, &mut refined, &mut identity, &nuisance)?;
    if data.pairs.len() == 1 {
        drop_shadows(&weighted, &work, &votes.agreed, &mut refined, &mut identity)?;
    }
    let unexplained = try_visible_peaks(&weighted, &seen, &mut refined, &mut identity, &mut next_identity)?;
    warnings.extend(merge(&weighted, &mut refined, &mut identity, hz)?);
    if let Some(modes) = asked {
        keep_strongest(&weighted, &mut refined, &mut identity, &nuisance, modes)?;
    }
    let lambda = refined.lambda.clone();
    (refined, weighted) = reweigh(&work, &weighted, &level, &lambda, &mut model)?;
    refined = refine(&weighted, &refined.lambda, &POWERS, tol::REFINE_FINE, tol::FINE_STEP)?;

    refine_resolved(&work, &weighted, &mut refined)?;

    progress("error bars and grades");
    let (robust, white) = variances(&weighted, &refined)?;
    let gains = one_column_gains(&weighted, &refined, 0)?;
    let gains_without = one_column_gains(&weighted, &refined, 2)?;
    let plain_residual = unweighted(&refined.projection.residual, &weighted, &work);
    let mut variance = Vec::new();
    let mut evidence: Vec<Evidence> = Vec::new();
    for q in 0..refined.lambda.len() {
        let pole = refined.lambda[q];
        let mut e = look(&work, &plain_residual, &refined, q);
        let vote = votes.agreed.get(identity[q]);
        e.score = vote.map_or(if nuisance(identity[q]) { 0.0 } else { 0.5 }, |a| a.score);
        let odd_even = vote.and_then(|a| a.odd_even);
        e.odd_even = odd_even.map(|d| d / pole.im);
        e.gain = gains[q];
        e.gain_without_nearest = gains_without[q];
        let mut deviation = robust[q].max(white[q]).sqrt();
        if weighted.columns() > 1 && weighted.in_band(pole) && back.is_some() {
            let (own, _, _) = own_poles(&weighted, &refined, &[q])?;
            let scatter = weighted_scatter(&refined, q, &own);
            e.scatter = Some(scatter / pole.im);
            deviation = deviation.max(scatter / (own.len() as f64).sqrt());
        }
        deviation = deviation.max(odd_even.unwrap_or(0.0) / 4.0);
        e.deviation = deviation / pole.im;
        variance.push(2.0 * 0.5 * deviation * deviation);
        evidence.push(e);
    }
    let (grades, damping_notes) = grade_all(&work, &refined, &evidence, data.pairs.len());
    warnings.extend(damping_warnings(&refined, &grades, &damping_notes, hz));
    for peak in unexplained {
        warnings.push(format!("visible peak at {:.2} Hz that no accepted mode explains", peak.lambda.re.sqrt() * hz));
    }
    Ok(MeasuredPoles { refined, work: weighted, back, variance, grades, warnings })
}

/// Refines with the error model that the residual shows, twice.
fn reweigh(
    work: &Work,
    first: &Work,
    level: &Array1<f64>,
    start: &[Complex64],
    model: &mut NoiseModel,
) -> Result<(Refined, Work), LinalgError> {
    let mut weighted = first.clone();
    let mut refined = refine(&weighted, start, &POWERS, 2 * tol::REFINE_ROUGH, tol::ROUGH_STEP)?;
    for _ in 0..WEIGHT_ROUNDS {
        let residual = unweighted(&refined.projection.residual, &weighted, work);
        let fitted = line_energy(&(&work.b - &residual));
        *model = NoiseModel::from_residual(&residual, &fitted);
        weighted = work.reweighted(&model.weights(level));
        refined = refine(&weighted, &refined.lambda, &POWERS, 2 * tol::REFINE_ROUGH, tol::ROUGH_STEP)?;
    }
    Ok((refined, weighted))
}

/// With one FRF nothing but the line shape tells a close pair from one misfitted mode: the partner that few orders agree on,
/// or that lies 20 dB below the other, is taken for misfit.
fn drop_shadows(work: &Work, plain: &Work, votes: &[Agreed], refined: &mut Refined, identity: &mut Vec<usize>) -> Result<(), LinalgError> {
    loop {
        let residual = unweighted(&refined.projection.residual, work, plain);
        let n = refined.lambda.len();
        let shadow = (0..n).find(|&q| {
            let pole = refined.lambda[q];
            let close = (0..n).any(|o| {
                let other = refined.lambda[o];
                o != q && work.in_band(other) && (other.re - pole.re).abs() < 2.5 * pole.im.max(other.im)
            });
            let score = votes.get(identity[q]).map_or(0.0, |a| a.score);
            work.in_band(pole) && close && (score < 0.75 || look(plain, &residual, refined, q).part < 0.1)
        });
        let Some(q) = shadow else { return Ok(()) };
        let mut fewer = refined.lambda.clone();
        fewer.remove(q);
        identity.remove(q);
        *refined = refine(work, &fewer, &refined.powers, 2 * tol::REFINE_ROUGH, tol::ROUGH_STEP)?;
    }
}

/// Isolated modes that the lines resolve are refitted in a narrow window without multiplicative weights: what the peak
/// itself says, free of the error model. (On the measured beam this is where independent local fits agree.)
fn refine_resolved(work: &Work, weighted: &Work, refined: &mut Refined) -> Result<(), LinalgError> {
    let mut lambda = refined.lambda.clone();
    let residual = unweighted(&refined.projection.residual, weighted, work);
    for (q, slot) in lambda.iter_mut().enumerate() {
        let pole = refined.lambda[q];
        let alone = refined
            .lambda
            .iter()
            .enumerate()
            .all(|(o, p)| o == q || (p.re - pole.re).abs() > (RESOLVED_ALONE * pole.im).max(2.0 * p.im.abs()));
        if !work.in_band(pole) || pole.im < RESOLVED_LINES * work.spacing(pole.re) || !alone {
            continue;
        }
        let rows: Vec<usize> = work.window(pole, RESOLVED_WINDOW, 6).collect();
        let local = work.select(&rows);
        // the mode's own part and the residual, without everything else
        let own = matmul(basis(&local, &[pole], &[]).view(), refined.coefficients.slice(s![q..q + 1, ..]));
        let columns = own + residual.select(Axis(0), &rows);
        let Ok(single) = refine(&local.with_columns(columns), &[pole], &[0, 1], tol::REFINE_FINE, tol::ROUGH_STEP) else { continue };
        let moved = single.lambda[0];
        if (moved - pole).norm() < pole.im && moved.im > 0.0 {
            *slot = moved;
        }
    }
    *refined = refine(weighted, &lambda, &refined.powers, 0, tol::FINE_STEP)?;
    Ok(())
}

/// Residual of `weighted` lines in the units of `work`.
fn unweighted(residual: &Array2<Complex64>, weighted: &Work, work: &Work) -> Array2<Complex64> {
    let mut out = residual.clone();
    for (k, mut row) in out.rows_mut().into_iter().enumerate() {
        let ratio = weighted.g[k] / work.g[k].max(1e-300);
        row.mapv_inplace(|v| v / ratio);
    }
    out
}

/// Tries poles at the peaks of the residual; true where one was accepted.
fn reseed(work: &Work, refined: &mut Refined, identity: &mut Vec<usize>, next: &mut usize) -> Result<bool, LinalgError> {
    let residual = work.with_columns(refined.projection.residual.clone());
    let energy = line_energy(&residual.b);
    let noise = fourth_difference_noise(&residual.b, (work.lines() / 20).clamp(30, 400));
    let mut changed = false;
    for peak in peaks(&residual, &energy, &noise).into_iter().take(20) {
        if peak.over_noise_db > 10.0 && !explained(refined, peak.lambda) && try_add(work, refined, peak.lambda)? {
            identity.push(*next);
            *next += 1;
            changed = true;
        }
    }
    Ok(changed)
}

/// True where a pole stands within a width of `lambda`.
fn explained(refined: &Refined, lambda: Complex64) -> bool {
    refined.lambda.iter().any(|p| (p.re - lambda.re).abs() < 1.5 * p.im.max(lambda.im))
}

/// Strong visible peaks without a pole get one try each; those that do not take are returned.
fn try_visible_peaks(
    work: &Work,
    seen: &[Peak],
    refined: &mut Refined,
    identity: &mut Vec<usize>,
    next: &mut usize,
) -> Result<Vec<Peak>, LinalgError> {
    let mut left = Vec::new();
    for peak in seen.iter().filter(|p| p.prominence_db >= TRY_PROMINENCE_DB && p.over_noise_db > TRY_OVER_NOISE_DB) {
        if explained(refined, peak.lambda) {
            continue;
        }
        if try_add(work, refined, peak.lambda)? {
            identity.push(*next);
            *next += 1;
        } else {
            left.push(*peak);
        }
    }
    Ok(left)
}

/// Drops the in-band poles with the least local gain until `modes` are left.
fn keep_strongest(
    work: &Work,
    refined: &mut Refined,
    identity: &mut Vec<usize>,
    nuisance: &dyn Fn(usize) -> bool,
    modes: usize,
) -> Result<(), LinalgError> {
    loop {
        let gains = one_column_gains(work, refined, 0)?;
        let inside: Vec<usize> = (0..gains.len()).filter(|&q| work.in_band(refined.lambda[q]) && !nuisance(identity[q])).collect();
        if inside.len() <= modes {
            return Ok(());
        }
        let weakest = inside.into_iter().min_by(|&a, &b| gains[a].total_cmp(&gains[b])).expect("more than asked");
        let mut fewer = refined.lambda.clone();
        fewer.remove(weakest);
        identity.remove(weakest);
        *refined = refine(work, &fewer, &POWERS, 2 * tol::REFINE_ROUGH, tol::ROUGH_STEP)?;
    }
}

/// Rms distance of the own poles from the common one, each FRF weighted by how strongly it shows the mode.
fn weighted_scatter(refined: &Refined, q: usize, own: &[Complex64]) -> f64 {
    let pole = refined.lambda[q];
    let (mut sum, mut total) = (0.0, 0.0);
    for (p, r) in own.iter().zip(refined.coefficients.row(q)) {
        let weight = r.norm_sqr();
        sum += weight * (p - pole).norm_sqr().min(4.0 * pole.im * pole.im);
        total += weight;
    }
    if total > 0.0 {
        (sum / total).sqrt()
    } else {
        0.0
    }
}

/// One warning per kind of doubt about damping, with the frequencies it concerns.
fn damping_warnings(refined: &Refined, grades: &[Grade], notes: &[Option<&'static str>], hz: f64) -> Vec<String> {
    let mut kinds: Vec<(&str, Vec<String>)> = Vec::new();
    for ((pole, grade), note) in refined.lambda.iter().zip(grades).zip(notes) {
        let Some(note) = note.filter(|_| grade.0 != Trust::Rejected) else { continue };
        let frequency = format!("{:.2}", pole.re.max(0.0).sqrt() * hz);
        match kinds.iter_mut().find(|(kind, _)| *kind == note) {
            Some((_, list)) => list.push(frequency),
            None => kinds.push((note, vec![frequency])),
        }
    }
    kinds.into_iter().map(|(note, list)| format!("{note}: {} Hz", list.join(", "))).collect()
}

/// Grades of the candidates among the poles; nuisance poles pass ungraded.
fn grade_all(work: &Work, refined: &Refined, evidence: &[Evidence], frfs: usize) -> (Vec<Grade>, Vec<Option<&'static str>>) {
    let candidates: Vec<usize> = (0..evidence.len()).filter(|&q| work.in_band(refined.lambda[q])).collect();
    let mut ordered = candidates;
    ordered.sort_by(|&a, &b| refined.lambda[a].re.total_cmp(&refined.lambda[b].re));
    let listed: Vec<Evidence> = ordered.iter().map(|&q| evidence[q].clone()).collect();
    let level: Vec<f64> = ordered
        .iter()
        .map(|&q| {
            let top =
                work.window(refined.lambda[q], 1.0, 1).map(|k| work.b.row(k).iter().map(|v| v.norm_sqr()).sum::<f64>()).fold(0.0, f64::max);
            10.0 * top.max(1e-300).log10()
        })
        .collect();
    let mut grades = vec![(Trust::Weak, Vec::new()); evidence.len()];
    let mut notes = vec![None; evidence.len()];
    let sure: Vec<bool> = (0..listed.len()).map(|p| grade(&listed, &level, p, frfs, None).0 .0 == Trust::Sure).collect();
    for (position, &q) in ordered.iter().enumerate() {
        let (g, note) = grade(&listed, &level, position, frfs, usual_loss(&listed, &sure, position));
        // a broad in-band pole that several orders do not share serves the background
        grades[q] = if refined.lambda[q].im > 0.4 * refined.lambda[q].re { (Trust::Rejected, vec!["background".into()]) } else { g };
        notes[q] = note;
    }
    (grades, notes)
}
