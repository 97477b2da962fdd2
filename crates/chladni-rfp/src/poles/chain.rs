//! The fast chain: sketch, pool, prune, refine, project, refine, and the loop that
//! settles the order.
//!
//! A mode here is what white noise cannot make; whether the residual *is* white is judged
//! at the end ([`crate::whiteness`]), and where it is not the measured-data path takes
//! over.

use crate::damping::structural::POWERS;
use crate::data::columns::{line_energy, Columns};
use crate::data::error::FitError;
use crate::data::layout::DataLayout;
use crate::data::options::Asked;
use crate::data::outliers::single_lines;
use crate::data::peaks::{fourth_difference_noise, peaks, thinned};
use crate::data::products::Projected;
use crate::data::source::{By, Source, Way};
use crate::data::watch::Watch;
use crate::poles::by_hand::{self, held};
use crate::poles::first_look::first_look;
use crate::poles::limits;
use crate::poles::passes::{basis_of, on_all_lines, Pass, Start};
use crate::poles::pool::{mixtures, starts, vector_fit, Products};
use crate::poles::prune::{is_spike, threshold};
use crate::poles::refine::{refine, removable, Projection, Refined};
use crate::poles::settle::{keep_strongest, settle};
use crate::poles::start::{self, pool_size, started};
use crate::poles::whiteness::{judge, judge_columns, Whiteness};
use crate::tolerances as tol;
use chladni_linalg::LinalgError;
use ndarray::Array1;
use num_complex::Complex64;

/// The result of the fast chain.
#[derive(Debug)]
pub(crate) enum Outcome {
    /// The residual is white: poles at the statistical limit.
    White(Box<Chain>),
    /// It did not come to that.
    Ended(Doubt),
}

/// Evidence against the fast chain.
#[derive(Debug)]
pub(crate) enum Doubt {
    /// The residual is not white; the evidence in words.
    NotWhite(String),
    /// It is not, and single lines that no neighbour supports are to blame.
    Outliers(Vec<usize>),
    /// The conjugate of the data is explained far better: they follow e^{−jωt}.
    Conjugated,
}

impl Doubt {
    /// The evidence.
    pub fn words(&self) -> String {
        match self {
            Self::NotWhite(evidence) => evidence.clone(),
            Self::Outliers(_) => "single lines stand out of the residual".into(),
            Self::Conjugated => "every resonance turns the wrong way".into(),
        }
    }
}

/// The result of the sketch alone.
enum First {
    /// Poles to project on.
    Poles(Box<Start>),
    /// A result that needs no projection.
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
    /// The test of the residual for whiteness.
    pub whiteness: Whiteness,
    /// Modes that the data show beyond the number asked for.
    pub dropped: Vec<Complex64>,
    /// Poles added by hand that explain nothing.
    pub idle: Vec<Complex64>,
    /// Orders tried: (poles, residual variance), in order.
    pub history: Vec<(usize, f64)>,
}

/// Runs the chain, or goes on where it stopped for a pass that was made since. `asked`
/// may fix the number of in-band modes, and add some.
///
/// * `doubt`: what speaks against the other law, where that was tried before
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
        Some(way) if way.law == data.law => went_on(data, sketch, way)?,
        _ => match of_sketch(data, sketch, seed, asked.modes, watch)? {
            First::Poles(start) => Start {
                doubt: doubt.map(str::to_owned),
                ..*start
            },
            First::Ended(doubt) => return Ok(Outcome::Ended(doubt)),
        },
    };
    watch.stage("projection")?;
    let (pass, history) = start.compressed(data, &energy, asked.modes.is_none())?;
    Ok(of_columns(data, pass, &energy, asked, history)?)
}

/// The chain up to the second pass over the data.
fn of_sketch(
    data: &DataLayout,
    sketch: Columns,
    seed: u64,
    asked: Option<usize>,
    watch: &Watch,
) -> Result<First, FitError> {
    let hz = data.hz();
    let ended = |doubt| Ok(First::Ended(doubt));
    let noise = fourth_difference_noise(&sketch.b, 40);
    let peaks = peaks(&sketch, &line_energy(&sketch.b), &noise);
    let seeds: Vec<Complex64> = peaks.iter().map(|p| p.lambda).collect();

    watch.stage("pole pool")?;
    let size = pool_size(&sketch, seeds.len(), asked)?;
    let rows = thinned(&sketch, &peaks);
    let sketch = if rows.len() < sketch.lines() {
        sketch.select(&rows)
    } else {
        sketch
    };
    if let Some(evidence) = first_look(&sketch, &peaks, seed, hz)? {
        return ended(Doubt::NotWhite(evidence));
    }
    let mixed = mixtures(&sketch, tol::POOL_MIXTURES, seed);
    let iterations = data.effort.pool_iterations;
    let mut start = started(&sketch, &mixed, &seeds, size, iterations)?;
    let look = |refined: &Refined| {
        judge_columns(&sketch, &refined.lambda, &refined.projection.residual, hz)
    };
    let spoilt = spoilt_lines(&sketch, &start.refined, start.variance)?;
    if !spoilt.is_empty() {
        return ended(Doubt::Outliers(
            spoilt.into_iter().map(|row| rows[row]).collect(),
        ));
    }
    // a missing mode leaves its mark in one place and in the shape of the residual;
    // misfit around most modes, or misfit without shape, is no question of order
    let mut first = look(&start.refined);
    if first.misfit_share > limits::MISFIT_SHARE && asked.is_none() {
        // unless a larger pool takes it away: many modes hide behind few peaks, or few
        // FRFs
        let larger = started(
            &sketch,
            &mixed,
            &seeds,
            (2 * size).min(sketch.lines() / 3),
            iterations,
        )?;
        if larger.variance < limits::LARGER_POOL_GAIN * start.variance {
            start = larger;
            first = look(&start.refined);
        }
    }
    let start::Start {
        mut refined,
        mut variance,
    } = start;
    let mut history = vec![(refined.lambda.len(), refined.variance(&sketch))];
    if first.misfit_share > limits::MISFIT_SHARE || refined.lambda.is_empty() {
        if conjugate_fits_better(&mixed, &seeds, size)? {
            return ended(Doubt::Conjugated);
        }
        if first.misfit_share > limits::MISFIT_SHARE {
            return ended(Doubt::NotWhite(first.evidence));
        }
    }
    if first.shapeless {
        return ended(Doubt::NotWhite(first.evidence));
    }
    settle(
        &sketch,
        &mut refined,
        &mut variance,
        sketch.columns(),
        &mut history,
    )?;
    let settled = look(&refined);
    if settled.shapeless {
        return ended(Doubt::NotWhite(settled.evidence));
    }

    // what the second pass keeps depends on these poles: converged, they are the same to
    // the last digits however they were found
    refined = refine(
        &sketch,
        &refined.lambda,
        &POWERS,
        data.effort.likelihood_steps,
        tol::FINE_STEP,
    )?;
    Ok(First::Poles(Box::new(Start {
        q: basis_of(data, &refined)?,
        sketch,
        lambda: refined.lambda,
        history,
        extra_passes: 0,
        doubt: None,
    })))
}

/// The point where the chain stopped on its `way`.
fn went_on(data: &DataLayout, sketch: Columns, way: &Way) -> Result<Start, LinalgError> {
    let (history, extra_passes, doubt) = match &way.by {
        By::Fast {
            history,
            extra_passes,
            doubt,
        } => (history.clone(), *extra_passes, doubt.clone()),
        By::Measured { .. } | By::Conjugated => Default::default(),
    };
    Ok(Start {
        sketch,
        lambda: way.lambda.clone(),
        q: on_all_lines(data, &way.lambda)?,
        history,
        extra_passes,
        doubt,
    })
}

/// The chain from the second pass on; `energy`: of each line over all FRFs.
fn of_columns(
    data: &DataLayout,
    mut pass: Pass,
    energy: &Array1<f64>,
    asked: Asked,
    history: Vec<(usize, f64)>,
) -> Result<Outcome, LinalgError> {
    let mut dropped = asked.modes.map_or(Ok(Vec::new()), |modes| {
        keep_strongest(&pass.projected.work, &mut pass.refined, modes)
    })?;
    let idle = add(data, &mut pass, asked)?;
    // what was added is not left out
    let there = &pass.refined.lambda;
    dropped.retain(|gone| there.iter().all(|pole| (pole - gone).norm() > gone.im));
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
        let left = line_residual.to_vec();
        let fitted: Vec<f64> = energy
            .iter()
            .zip(&left)
            .map(|(all, left)| (all - left).max(0.0))
            .collect();
        let outliers = single_lines(&left, &fitted);
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

/// Refines the poles with those added by hand; returns the added ones that explain no more
/// than noise would, which are left out.
fn add(data: &DataLayout, pass: &mut Pass, asked: Asked) -> Result<Vec<Complex64>, LinalgError> {
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
            &POWERS,
            data.effort.likelihood_steps,
            tol::FINE_STEP,
        )
    };
    let with = refined(&starts)?;
    let least = threshold(work.columns(), work.lines()) * pass.variance;
    let without = removable(work, &with.lambda, &POWERS)?;
    let serves = |n: usize| {
        let pole = with.lambda[known.len() + n];
        held(work, starts[n], pole) == pole && without.rise(known.len() + n) >= least
    };
    let (kept, idle): (Vec<usize>, Vec<usize>) = (0..starts.len()).partition(|&n| serves(n));
    let at = |places: Vec<usize>| places.into_iter().map(|n| starts[n]).collect::<Vec<_>>();
    let kept = at(kept);
    if !kept.is_empty() {
        pass.refined = if idle.is_empty() {
            with
        } else {
            refined(&kept)?
        };
    }
    Ok(at(idle))
}

/// Single lines that poles narrower than a line stand for, where no other line needs
/// these, and lines like them. `variance`: of the noise.
fn spoilt_lines(
    work: &Columns,
    refined: &Refined,
    variance: f64,
) -> Result<Vec<usize>, LinalgError> {
    let limit = threshold(work.columns(), work.lines()) * variance;
    let mut physical = Vec::new();
    for (q, &pole) in refined.lambda.iter().enumerate() {
        if !is_spike(work, refined, q, limit)? {
            physical.push(pole);
        }
    }
    if physical.len() == refined.lambda.len() {
        return Ok(Vec::new());
    }
    let residual = Projection::new(work, &physical, &refined.powers)?.residual;
    let fitted = line_energy(&(&work.b - &residual));
    Ok(single_lines(
        &line_energy(&residual).to_vec(),
        &fitted.to_vec(),
    ))
}

/// True where the same number of stable poles explains the conjugate of the data far
/// better than the data: a passive structure measured in e^{−jωt}.
fn conjugate_fits_better(
    mixed: &Columns,
    seeds: &[Complex64],
    size: usize,
) -> Result<bool, LinalgError> {
    let left_over = |work: &Columns| -> Result<f64, LinalgError> {
        let pool = vector_fit(
            work,
            &starts(work, seeds, size),
            &POWERS,
            tol::POOL_ITERATIONS,
            Products::PartialFractions,
        )?;
        let stable: Vec<Complex64> = pool
            .lambda
            .iter()
            .zip(&pool.flipped)
            .filter(|(_, f)| !**f)
            .map(|(p, _)| *p)
            .collect();
        Ok(Projection::new(work, &stable, &POWERS)?.sse)
    };
    Ok(left_over(&mixed.with_columns(mixed.b.mapv(|v| v.conj())))?
        < limits::CONJUGATE_SHARE * left_over(mixed)?)
}
