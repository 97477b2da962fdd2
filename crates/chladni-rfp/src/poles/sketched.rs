//! The chain up to the second pass over the data: it ends with the poles of the sketch, or with a
//! doubt about the fast chain.

use crate::damping::basis::RESIDUAL_POWERS;
use crate::data::columns::{line_energy, Columns};
use crate::data::error::FitError;
use crate::data::layout::DataLayout;
use crate::data::outliers::single_lines;
use crate::data::peaks::{fourth_difference_noise, peaks, thinned};
use crate::data::watch::Watch;
use crate::poles::delay_alone::delay_alone;
use crate::poles::first_look::first_look;
use crate::poles::limits;
use crate::poles::passes::{on_all_lines, PassStart};
use crate::poles::pool::{mixtures, starts, vector_fit, StepBasis};
use crate::poles::prune::is_one_bad_line;
use crate::poles::refine::{orthonormal_basis, refined_poles, Projection, Refined};
use crate::poles::settle::{settle, OrderHistory};
use crate::poles::significance::threshold;
use crate::poles::start::{pool_size, started, Start};
use crate::poles::whiteness::{judge_columns, Whiteness};
use crate::tolerances as tol;
use chladni_linalg::LinalgError;
use num_complex::Complex64;

/// Evidence against the fast chain.
#[derive(Debug)]
pub(crate) enum Doubt {
    /// The residual is not white; the evidence in words.
    NotWhite(String),
    /// The residual is not white, and single lines that no neighbour supports are to blame.
    Outliers(Vec<usize>),
    /// Poles explain the conjugate of the data far better: the data follow e^{−jωt}.
    Conjugated,
    /// The data are a delay of so many seconds, and nothing else.
    Delay(f64),
}

impl Doubt {
    /// The evidence in words.
    pub fn words(&self) -> String {
        match self {
            Self::NotWhite(evidence) => evidence.clone(),
            Self::Outliers(_) => "single lines stand out of the residual".into(),
            Self::Conjugated => "every resonance turns the wrong way".into(),
            Self::Delay(_) => "a delay alone explains the data".into(),
        }
    }
}

/// The result of the sketch alone.
pub(crate) enum SketchOutcome {
    /// Poles to project on.
    Poles(Box<PassStart>),
    /// A result that needs no projection.
    Ended(Doubt),
}

/// Finds the poles of the sketch. `asked`: number of modes, if it is fixed.
///
/// # Errors
/// A kernel that fails; a watch that ends it.
pub(crate) fn poles_of_sketch(
    data: &DataLayout,
    sketch: Columns,
    seed: u64,
    asked: Option<usize>,
    watch: &Watch,
) -> Result<SketchOutcome, FitError> {
    let hz = data.hz();
    let ended = |doubt| Ok(SketchOutcome::Ended(doubt));
    if asked.is_none() {
        if let Some(seconds) = delay_alone(&sketch, data.kind, hz)? {
            return ended(Doubt::Delay(seconds));
        }
    }
    let noise = fourth_difference_noise(&sketch, limits::SKETCH_NOISE_HALF_WINDOW);
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
    let pool = PooledPoles {
        mixed: mixtures(&sketch, tol::POOL_MIXTURES, seed),
        iterations: data.effort.pool_iterations,
        sketch,
        seeds,
        size,
        hz,
    };
    let start = pool.started(size)?;
    let spoilt = spoilt_lines(&pool.sketch, &start.refined, start.variance)?;
    if !spoilt.is_empty() {
        return ended(Doubt::Outliers(
            spoilt.into_iter().map(|row| rows[row]).collect(),
        ));
    }
    let (start, whiteness) = pool.large_enough(start, asked)?;
    let history = vec![(
        start.refined.lambda.len(),
        start.refined.variance(&pool.sketch),
    )];
    if let Some(doubt) = pool.doubt(&start.refined, whiteness)? {
        return ended(doubt);
    }
    pool.settled(data, start, history)
}

/// A sketch, and the starting values of its pools of poles.
struct PooledPoles {
    sketch: Columns,
    /// A few mixtures of its columns.
    mixed: Columns,
    /// Poles of visible peaks.
    seeds: Vec<Complex64>,
    /// Number of poles of the first pool.
    size: usize,
    /// Iterations of vector fitting.
    iterations: usize,
    /// Frequency of x = 1.
    hz: f64,
}

impl PooledPoles {
    /// Poles of a pool of `size` that noise cannot make.
    fn started(&self, size: usize) -> Result<Start, LinalgError> {
        started(
            &self.sketch,
            &self.mixed,
            &self.seeds,
            size,
            self.iterations,
        )
    }

    /// Judges the residual on the sketch.
    fn judged(&self, refined: &Refined) -> Whiteness {
        let residual = &refined.projection.residual;
        judge_columns(&self.sketch, &refined.lambda, residual, self.hz)
    }

    /// The poles of a pool twice as large if that removes the misfit, else those of `start`; with
    /// the verdict on their residual.
    fn large_enough(
        &self,
        start: Start,
        asked: Option<usize>,
    ) -> Result<(Start, Whiteness), LinalgError> {
        let whiteness = self.judged(&start.refined);
        if whiteness.misfit_share > limits::MISFIT_SHARE && asked.is_none() {
            // many modes hide behind few peaks, or few FRFs
            let larger =
                self.started((2 * self.size).min(self.sketch.lines() / limits::LINES_PER_POLE))?;
            if larger.variance < limits::LARGER_POOL_GAIN * start.variance {
                let whiteness = self.judged(&larger.refined);
                return Ok((larger, whiteness));
            }
        }
        Ok((start, whiteness))
    }

    /// The doubt about going on from the first poles, if there is one. A missing mode leaves
    /// its mark in one place and in the shape of the residual. More poles do not cure misfit
    /// around most modes, or misfit without shape.
    fn doubt(&self, refined: &Refined, whiteness: Whiteness) -> Result<Option<Doubt>, LinalgError> {
        let misfitted = whiteness.misfit_share > limits::MISFIT_SHARE;
        if (misfitted || refined.lambda.is_empty())
            && conjugate_fits_better(&self.mixed, &self.seeds, self.size)?
        {
            return Ok(Some(Doubt::Conjugated));
        }
        let doubtful = misfitted || whiteness.shapeless;
        Ok(doubtful.then_some(Doubt::NotWhite(whiteness.evidence)))
    }

    /// Settles the number of poles and refines them to their last digits.
    fn settled(
        self,
        data: &DataLayout,
        start: Start,
        mut history: OrderHistory,
    ) -> Result<SketchOutcome, FitError> {
        let (mut refined, mut variance) = (start.refined, start.variance);
        settle(
            &self.sketch,
            &mut refined,
            &mut variance,
            self.sketch.columns(),
            &mut history,
        )?;
        let settled = self.judged(&refined);
        // broad modes that turn the wrong way leave few poles in the band, and no misfit around them
        if !settled.white && conjugate_fits_better(&self.mixed, &self.seeds, self.size)? {
            return Ok(SketchOutcome::Ended(Doubt::Conjugated));
        }
        if settled.shapeless {
            return Ok(SketchOutcome::Ended(Doubt::NotWhite(settled.evidence)));
        }
        // refined to the last digits, the poles do not depend on how they were found, nor does
        // the second pass
        let precision = tol::FINE.within(data.effort.likelihood_steps);
        let start = refined.lambda;
        let lambda = refined_poles(&self.sketch, &start, &RESIDUAL_POWERS, precision)?;
        let q = match self.sketch.lines() == data.lines.len() {
            true => orthonormal_basis(&self.sketch, &lambda, &RESIDUAL_POWERS)?.0,
            false => on_all_lines(data, &lambda)?,
        };
        Ok(SketchOutcome::Poles(Box::new(PassStart {
            q,
            sketch: self.sketch,
            lambda,
            history,
            extra_passes: 0,
            doubt: None,
        })))
    }
}

/// Outlier lines, judged by the residual without the poles that stand for one bad line each; empty
/// if there are no such poles. `variance`: of the noise.
fn spoilt_lines(
    work: &Columns,
    refined: &Refined,
    variance: f64,
) -> Result<Vec<usize>, LinalgError> {
    let least_rise = threshold(work.columns(), work.lines()) * variance;
    let mut physical = Vec::new();
    for (q, &pole) in refined.lambda.iter().enumerate() {
        if !is_one_bad_line(work, refined, q, least_rise)? {
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

/// True if stable poles, as many as in a pool of this `size`, explain the conjugate of the data far
/// better than the data: the set is of a passive structure, measured in e^{−jωt}.
fn conjugate_fits_better(
    mixed: &Columns,
    seeds: &[Complex64],
    size: usize,
) -> Result<bool, LinalgError> {
    let residual_energy = |work: &Columns| -> Result<f64, LinalgError> {
        let pool = vector_fit(
            work,
            &starts(work, seeds, size),
            &RESIDUAL_POWERS,
            tol::POOL_ITERATIONS,
            StepBasis::PartialFractions,
        )?;
        let stable: Vec<Complex64> = pool
            .lambda
            .iter()
            .zip(&pool.flipped)
            .filter(|(_, flipped)| !**flipped)
            .map(|(pole, _)| *pole)
            .collect();
        Ok(Projection::new(work, &stable, &RESIDUAL_POWERS)?.sse)
    };
    let conjugate = mixed.with_columns(mixed.b.mapv(|v| v.conj()));
    Ok(residual_energy(&conjugate)? < limits::CONJUGATE_SHARE * residual_energy(mixed)?)
}
