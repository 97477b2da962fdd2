//! A first look at the strongest sections of a long band, before the fast chain begins.

use crate::data::columns::Columns;
use crate::data::peaks::Peak;
use crate::poles::limits;
use crate::poles::pool::mixtures;
use crate::poles::sections::split;
use crate::poles::start::{pool_size, started, Start};
use crate::poles::whiteness::judge_columns;
use crate::tolerances as tol;
use chladni_linalg::LinalgError;
use num_complex::Complex64;

/// Judges the sections with the strongest peaks: with many modes the chain is expensive, and in vain
/// if most of them are misfitted. Returns evidence that the residual is not white. `None`: it may
/// be white, or the band has too few peaks for such a look.
pub(crate) fn first_look(
    sketch: &Columns,
    peaks: &[Peak],
    seed: u64,
    hz: f64,
) -> Result<Option<String>, LinalgError> {
    if peaks.len() < limits::FIRST_LOOK_ABOVE {
        return Ok(None);
    }
    let mut sections: Vec<(Columns, Vec<Peak>)> = split(sketch, peaks)
        .into_iter()
        .map(|section| {
            let work = sketch.rows(section.lines);
            let inside = peaks
                .iter()
                .copied()
                .filter(|p| work.in_band(p.lambda))
                .collect();
            (work, inside)
        })
        .collect();
    let strength = |inside: &[Peak]| {
        inside
            .iter()
            .filter(|p| p.is_striking())
            .map(|p| p.over_noise_db)
            .sum::<f64>()
    };
    sections.sort_by(|a, b| strength(&b.1).total_cmp(&strength(&a.1)));
    // one section may lack a mode that the whole chain would find: two must speak against it
    let mut doubts = sections
        .iter()
        .take(limits::ASKED)
        .filter_map(|(work, inside)| misfit_of_section(work, inside, seed, hz).transpose());
    let first = doubts.next().transpose()?;
    let second = doubts.next().transpose()?;
    Ok(first.filter(|_| second.is_some()))
}

/// Runs a short chain on one section. Returns evidence if most of the striking peaks are misfitted,
/// if the misfit has no shape, or if the residual is far from white. Poles of lesser peaks do not
/// count: in noise they would outvote a few modes. A section whose residual is next to nothing is
/// left to the whole chain, whose poles are more exact.
fn misfit_of_section(
    work: &Columns,
    peaks: &[Peak],
    seed: u64,
    hz: f64,
) -> Result<Option<String>, LinalgError> {
    let seeds: Vec<Complex64> = peaks.iter().map(|p| p.lambda).collect();
    let size = pool_size(work, seeds.len(), None)?;
    let Start { refined, .. } = started(
        work,
        &mixtures(work, tol::POOL_MIXTURES, seed),
        &seeds,
        size,
        tol::POOL_ITERATIONS,
    )?;
    if refined.projection.sse < limits::NEXT_TO_NOTHING * work.energy() {
        return Ok(None);
    }
    let explains = |pole: &Complex64, peak: &Peak| {
        (pole.re - peak.lambda.re).abs() < limits::PEAK_EXPLAINED * peak.lambda.im
    };
    let striking: Vec<Complex64> = refined
        .lambda
        .iter()
        .copied()
        .filter(|pole| peaks.iter().any(|p| p.is_striking() && explains(pole, p)))
        .collect();
    let verdict = judge_columns(work, &striking, &refined.projection.residual, hz);
    let doubtful = verdict.misfit_share > limits::MISFIT_SHARE
        || verdict.shapeless
        || verdict.excess > limits::CLEAR;
    Ok(doubtful.then_some(verdict.evidence))
}
