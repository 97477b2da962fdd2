//! The fast chain: sketch, pool, prune, refine, project, refine, and the loop that
//! settles the number of poles.
//!
//! It takes for a mode all that white noise cannot make. At the end
//! [`crate::poles::whiteness`] judges if the residual is white. If it is not, the measured-data path
//! takes over.

use crate::damping::basis::RESIDUAL_POWERS;
use crate::data::layout::DataLayout;
use crate::data::options::Asked;
use crate::data::outliers::outliers_by_energy;
use crate::data::products::Projected;
use crate::data::source::{By, Source, Way};
use crate::data::watch::Watch;
use crate::poles::by_hand::{self, held};
use crate::poles::passes::{on_all_lines, MissedPoles, Pass, PassStart};
use crate::poles::refine::{refine, removable, Refined};
use crate::poles::settle::{keep_strongest, OrderHistory};
use crate::poles::significance::threshold;
use crate::poles::sketched::{poles_of_sketch, Doubt, SketchOutcome};
use crate::poles::whiteness::{judge, Whiteness};
use crate::tolerances as tol;
use chladni_linalg::LinalgError;
use ndarray::Array1;
use num_complex::Complex64;

/// The result of the fast chain.
#[derive(Debug)]
pub(crate) enum Outcome {
    /// The residual is white: poles at the statistical limit.
    White(Box<Chain>),
    /// The chain ended before, or the residual is not white.
    Ended(Doubt),
}

/// The poles that the fast chain found.
#[derive(Debug)]
pub(crate) struct Chain {
    /// Refined on the compressed columns of all FRFs.
    pub refined: Refined,
    /// Compressed data and the way back to FRFs.
    pub projected: Projected,
    /// Noise variance of one work value.
    pub variance: f64,
    /// Verdict on the whiteness of the residual.
    pub whiteness: Whiteness,
    /// Modes that the data show beyond the number asked for.
    pub dropped: Vec<Complex64>,
    /// Poles added by hand that explain nothing.
    pub idle: Vec<Complex64>,
    /// Orders tried, in order.
    pub history: OrderHistory,
}

/// Runs the chain, or resumes it where it stopped for a pass that was made since.
///
/// * `asked`: it may fix the number of in-band modes, and add some
/// * `doubt`: evidence against the other damping law, if that was tried before
///
/// # Errors
/// A kernel that fails; a pass that others must make; a watch that ends it.
pub(crate) fn fast_chain<S: Source>(
    data: &S,
    seed: u64,
    asked: Asked,
    doubt: Option<&str>,
    watch: &Watch,
) -> Result<Outcome, S::Stop> {
    watch.stage("sketch")?;
    let (sketch, energy) = data.sketch(seed);
    let start = match data.way() {
        // the chain stopped for a pass that is made now
        Some(Way {
            law,
            lambda,
            by:
                By::Fast {
                    history,
                    extra_passes,
                    doubt,
                },
        }) if *law == data.law => PassStart {
            sketch,
            lambda: lambda.clone(),
            q: on_all_lines(data, lambda)?,
            history: history.clone(),
            extra_passes: *extra_passes,
            doubt: doubt.clone(),
        },
        _ => match poles_of_sketch(data, sketch, seed, asked.modes, watch)? {
            SketchOutcome::Poles(start) => PassStart {
                doubt: doubt.map(str::to_owned),
                ..*start
            },
            SketchOutcome::Ended(doubt) => return Ok(Outcome::Ended(doubt)),
        },
    };
    watch.stage("projection")?;
    data.end_first_pass();
    let missed = match asked.modes {
        None => MissedPoles::Search,
        Some(_) => MissedPoles::Leave,
    };
    let (pass, history) = start.compressed(data, &energy, missed)?;
    Ok(judged(data, pass, &energy, asked, history)?)
}

/// Takes the order and the additions asked for into account, and judges the residual.
///
/// * `energy`: of each line over all FRFs
fn judged(
    data: &DataLayout,
    mut pass: Pass,
    energy: &Array1<f64>,
    asked: Asked,
    history: OrderHistory,
) -> Result<Outcome, LinalgError> {
    let mut dropped = asked.modes.map_or(Ok(Vec::new()), |modes| {
        keep_strongest(&pass.projected.work, &mut pass.refined, modes)
    })?;
    let idle = add_by_hand(data, &mut pass, asked)?;
    // a dropped pole that was added by hand is in the fit again
    let lambda = &pass.refined.lambda;
    dropped.retain(|gone| lambda.iter().all(|pole| (pole - gone).norm() > gone.im));
    let Pass {
        refined,
        projected,
        variance,
        ..
    } = pass;
    let line_residual = projected.line_residual(&refined.projection.residual);
    let whiteness = judge(
        &projected.work,
        &refined.lambda,
        &line_residual,
        data.pairs.len(),
        &refined.projection.residual,
        data.hz(),
    );
    if !whiteness.white {
        let outliers = outliers_by_energy(energy, &line_residual);
        return Ok(Outcome::Ended(if outliers.is_empty() {
            Doubt::NotWhite(whiteness.evidence)
        } else {
            Doubt::Outliers(outliers)
        }));
    }
    Ok(Outcome::White(Box::new(Chain {
        refined,
        projected,
        variance,
        whiteness,
        dropped,
        idle,
        history,
    })))
}

/// Refines the poles with those added by hand. Returns the added ones that explain no more
/// than noise would; they are left out of the fit.
fn add_by_hand(
    data: &DataLayout,
    pass: &mut Pass,
    asked: Asked,
) -> Result<Vec<Complex64>, LinalgError> {
    let work = &pass.projected.work;
    let known = pass.refined.lambda.clone();
    let starts = by_hand::starts(asked.added_hz, work, &known, data.hz());
    if starts.is_empty() {
        return Ok(starts);
    }
    let refined = |added: &[Complex64]| {
        let all = [&known, added].concat();
        refine(
            work,
            &all,
            &RESIDUAL_POWERS,
            tol::FINE.within(data.effort.likelihood_steps),
        )
    };
    let with = refined(&starts)?;
    let least_rise = threshold(work.columns(), work.lines()) * pass.variance;
    let fit = removable(work, &with.lambda, &RESIDUAL_POWERS)?;
    let is_significant = |n: usize| {
        let pole = with.lambda[known.len() + n];
        held(work, starts[n], pole) == pole && fit.rise(known.len() + n) >= least_rise
    };
    let (kept, idle): (Vec<usize>, Vec<usize>) =
        (0..starts.len()).partition(|&n| is_significant(n));
    let starts_of = |added: Vec<usize>| added.into_iter().map(|n| starts[n]).collect::<Vec<_>>();
    let kept = starts_of(kept);
    if !kept.is_empty() {
        pass.refined = if idle.is_empty() {
            with
        } else {
            refined(&kept)?
        };
    }
    Ok(starts_of(idle))
}
