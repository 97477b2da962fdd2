//! The fast chain with the order given: relaxed vector fitting on few mixtures of the
//! sketch, then maximum likelihood on the compressed columns of all FRFs
//! ([`crate::poles::chain`] without its loop).
//!
//! The number of modes is what was asked for, else what is significant of a pool for as
//! many modes as there are visible peaks; poles to spare are taken out before the
//! refinement. Modes just beyond the ends of the band, which a sketch hardly shows, are
//! sought with all FRFs. Where a number is given, a mode that the pool lost is looked for in the
//! residual of the sketch. At the Cramér–Rao bound in white noise, in the law that the phases of the
//! residues tell, or that is asked for.
//!
//! Cost: two passes over the data (16·N·M·m flop for N lines, M FRFs, m unknowns), vector
//! fitting as in [`super::vf`] with half the mixtures, and some ten steps of 8Nr(2m)
//! for r columns; with a number given, refinements of the sketch for each pole that is missing
//! and up to four others.
//!
//! Avoid it where the number of modes is not known (a missed mode of the band biases its
//! neighbours, and without a number nothing looks for it), or where the residual is not white noise: the
//! bars are then too small. Both are the business of `auto`.
//!
//! Equations: theory.md, section 2.

use super::limits::{BROAD, EXCHANGES};
use crate::damping::basis::basis;
use crate::damping::basis::RESIDUAL_POWERS;
use crate::data::columns::Columns;
use crate::data::error::FitError;
use crate::data::options::FitOptions;
use crate::data::products::{measured_basis, project};
use crate::methods::selection::{fewer, inside, left_by, poles_beyond_ends, select};
use crate::methods::survey::Survey;
use crate::methods::vf::{pool, signed};
use crate::poles::estimate::{graded, PoleEstimate};
use crate::poles::noise_variance::noise_variance;
use crate::poles::pool::StepBasis;
use crate::poles::prune::is_one_bad_line;
use crate::poles::refine::{refine, refined_poles, removable, Refined};
use crate::poles::scan::{scan, usual_loss, Scan};
use crate::poles::settle::keep_strongest;
use crate::poles::significance::threshold;
use crate::tolerances::{self as tol, Precision};
use chladni_linalg::blocked::tall_qr;
use chladni_linalg::LinalgError;
use num_complex::Complex64;

/// Poles at the maximum of the likelihood.
///
/// # Errors
/// A decomposition that fails.
pub(crate) fn lean(survey: Survey, options: &FitOptions) -> Result<PoleEstimate, FitError> {
    let modes = options.modes.unwrap_or(survey.peaks.len());
    let data = survey.data;
    let mut rough = of_sketch(&survey, modes, options)?;
    // memory for the pass
    drop(survey.sketch);
    let all = data.axis();
    // modes there may show in all FRFs together only
    rough.extend(poles_beyond_ends(&all, &rough, 0.0));
    let measured = {
        let columns = basis(&all, &rough, &RESIDUAL_POWERS);
        measured_basis(data, &tall_qr(columns.view())?.0, &[])
    };
    let projected = project(data, measured, &survey.energy, &[])?;
    let needed = needed(&projected.work, &rough, data.pairs.len())?;
    let refined = fine(&projected.work, &needed, options, data.pairs.len())?;
    let sse = projected.line_residual(&refined.projection.residual).sum();
    let size = (data.lines.len(), data.pairs.len());
    // normalised data: their mean square is one
    let variance = noise_variance(sse, size, refined.unknowns(), tol::VARIANCE_LEAST);
    let found = inside(&projected.work, &refined.lambda);
    let (grades, spread) = graded(&refined, &projected.work, variance);
    Ok(PoleEstimate {
        grades,
        spread,
        residual_is_noise: true,
        work: projected.work,
        back: Some(projected.back),
        variance,
        idle: Vec::new(),
        path: match options.modes {
            Some(modes) => format!("fast chain for {modes} modes, its residual not judged"),
            None => format!("fast chain from {modes} visible peaks, its residual not judged"),
        },
        warnings: fewer(options, found).into_iter().collect(),
        consistent: true,
        refined,
    })
}

/// Poles of the sketch, `modes` of them in the band.
fn of_sketch(
    survey: &Survey,
    modes: usize,
    options: &FitOptions,
) -> Result<Vec<Complex64>, LinalgError> {
    let sketch = &survey.sketch;
    let mut start = start(survey, modes, options)?;
    if inside(sketch, &start) < modes {
        start = self::start(survey, modes.saturating_add(modes / 2), options)?;
    }
    let rows = survey.rows();
    let thinned = if rows.len() < sketch.lines() {
        Some(sketch.select(&rows))
    } else {
        None
    };
    let work = thinned.as_ref().unwrap_or(sketch);
    narrow(work, &mut start, modes);
    let rough = refined_poles(work, &start, &RESIDUAL_POWERS, tol::ROUGH)?;
    let rough = match inside(work, &rough) > modes {
        // without poles that are redundant once their neighbours are refined
        true => select(work, &rough, modes..=usize::MAX)?.0,
        false => rough,
    };
    match options.modes {
        Some(modes) => {
            let fine = tol::FINE.within(options.effort.likelihood_steps);
            completed(work, rough, modes, fine)
        }
        None => Ok(rough),
    }
}

/// Poles of the sketch, with those that the residual shows in place of the ones that matter less,
/// or added while there are fewer than `modes`: a pool may hold a pole of noise instead of a mode
/// between two lines.
fn completed(
    work: &Columns,
    rough: Vec<Complex64>,
    modes: usize,
    fine: Precision,
) -> Result<Vec<Complex64>, LinalgError> {
    let refined = refine(work, &rough, &RESIDUAL_POWERS, tol::NO_STEP)?;
    if MissedPlaces::new(work, &refined, modes)?
        .next(&[])
        .is_none()
    {
        return Ok(rough);
    }
    // poles that have yet to move leave a residual that is none of a missed one
    let mut best = refine(work, &rough, &RESIDUAL_POWERS, fine)?;
    let mut missed = MissedPlaces::new(work, &best, modes)?;
    let most = modes
        .saturating_sub(inside(work, &rough))
        .saturating_add(EXCHANGES);
    let mut tried = Vec::new();
    while tried.len() < most {
        let Some(place) = missed.next(&tried) else {
            break;
        };
        tried.push(place);
        let more = [best.lambda.as_slice(), &[place]].concat();
        let mut other = refine(work, &more, &RESIDUAL_POWERS, tol::ROUGH)?;
        let last = other.lambda.len() - 1;
        if !work.in_band(other.lambda[last])
            || is_one_bad_line(work, &other, last, missed.noise_gain)?
        {
            continue;
        }
        keep_strongest(work, &mut other, modes)?;
        let worth = match other.lambda.len() > best.lambda.len() {
            true => missed.noise_gain,
            false => 0.0,
        };
        if best.projection.sse - other.projection.sse > worth {
            best = other;
            missed = MissedPlaces::new(work, &best, modes)?;
        }
    }
    Ok(best.lambda)
}

/// Places of the band where one more pole would pay.
struct MissedPlaces {
    scanned: Scan,
    /// The least that it must take out of the residual.
    least_gain: f64,
    /// The most that a pole of noise takes out.
    noise_gain: f64,
}

impl MissedPlaces {
    /// With fewer than `modes` in-band poles, a new one must explain more than noise. Otherwise it
    /// replaces the weakest and must explain more than that one.
    fn new(work: &Columns, refined: &Refined, modes: usize) -> Result<Self, LinalgError> {
        let rises = refined.significance()?;
        let in_band = (0..rises.len()).filter(|&q| work.in_band(refined.lambda[q]));
        let weakest_rise = match inside(work, &refined.lambda) < modes {
            true => 0.0,
            false => in_band.map(|q| rises[q]).fold(f64::INFINITY, f64::min),
        };
        let sse = refined.projection.sse;
        let noise_gain = noise_takes(work, sse, refined.unknowns(), work.columns());
        Ok(Self {
            scanned: scan(work, refined),
            least_gain: weakest_rise.max(noise_gain),
            noise_gain,
        })
    }

    /// The place, none of those `tried`, where a pole takes out most.
    fn next(&self, tried: &[Complex64]) -> Option<Complex64> {
        self.scanned.beyond(self.least_gain, tried).first().copied()
    }
}

/// Poles that matter, at least as many in the band as asked for, out of a pool for `modes`
/// modes. One too many may be a mode outside the band that the pool puts just inside; the
/// refinement decides.
fn start(
    survey: &Survey,
    modes: usize,
    options: &FitOptions,
) -> Result<Vec<Complex64>, LinalgError> {
    let pool = pool(
        survey,
        &survey.sketch,
        tol::POOL_MIXTURES,
        survey.pool_size(modes),
        options,
        StepBasis::PartialFractions,
    )?;
    let stable: Vec<Complex64> = signed(&pool)
        .into_iter()
        .filter(|pole| pole.im > 0.0)
        .collect();
    Ok(select(
        &survey.sketch,
        &stable,
        options.modes.unwrap_or(0)..=usize::MAX,
    )?
    .0)
}

/// Takes the broadest poles out as long as more than `modes` are in the band: a broad one
/// represents out-of-band modes.
fn narrow(work: &Columns, lambda: &mut Vec<Complex64>, modes: usize) {
    let broad = BROAD * usual_loss(work, lambda);
    let loss = |pole: Complex64| pole.im / pole.re;
    while inside(work, lambda) > modes {
        let within =
            (0..lambda.len()).filter(|&q| work.in_band(lambda[q]) && loss(lambda[q]) > broad);
        let Some(broadest) = within.max_by(|&a, &b| loss(lambda[a]).total_cmp(&loss(lambda[b])))
        else {
            break;
        };
        lambda.remove(broadest);
    }
}

/// Poles without those beyond the band that the FRFs, so many, do not tell from noise.
fn needed(
    work: &Columns,
    lambda: &[Complex64],
    frfs: usize,
) -> Result<Vec<Complex64>, LinalgError> {
    let all = removable(work, lambda, &RESIDUAL_POWERS)?;
    let limit = noise_takes(work, all.sse, all.unknowns(), frfs);
    Ok(all.thin_out(lambda, |candidate| {
        !work.in_band(lambda[candidate.pole]) && candidate.rise < limit
    }))
}

/// The part of the noise of all FRFs that one more pole may take, where so many unknowns
/// leave `sse`.
fn noise_takes(work: &Columns, sse: f64, unknowns: usize, frfs: usize) -> f64 {
    threshold(frfs, work.lines()) * left_by(work, sse, unknowns)
}

/// Refines to the last digit, and again without the weakest as long as more poles are in
/// the band than asked for, or one beyond it turns out to serve the `frfs` no more than
/// noise would.
fn fine(
    work: &Columns,
    start: &[Complex64],
    options: &FitOptions,
    frfs: usize,
) -> Result<Refined, LinalgError> {
    let mut lambda = start.to_vec();
    loop {
        let refined = refine(
            work,
            &lambda,
            &RESIDUAL_POWERS,
            tol::FINE.within(options.effort.likelihood_steps),
        )?;
        let rises = refined.significance()?;
        let limit = noise_takes(work, refined.projection.sse, refined.unknowns(), frfs);
        let too_many = options
            .modes
            .is_some_and(|modes| inside(work, &refined.lambda) > modes);
        let may_go = |&q: &usize| {
            if work.in_band(refined.lambda[q]) {
                too_many
            } else {
                rises[q] < limit
            }
        };
        let Some(weakest) = (0..rises.len())
            .filter(may_go)
            .min_by(|&a, &b| rises[a].total_cmp(&rises[b]))
        else {
            return Ok(refined);
        };
        lambda = refined.lambda;
        lambda.remove(weakest);
    }
}
