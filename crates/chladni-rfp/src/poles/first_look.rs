//! The strongest sections of a long band, judged before the fast chain begins.

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

/// Judges the sections with the strongest peaks first: with many modes the chain is expensive,
/// and in vain if most of them are misfitted. Returns the evidence that their residual is not
/// white. `None`: it may be white, or the band is no longer than a section.
pub(crate) fn first_look(
    sketch: &Columns,
    peaks: &[Peak],
    seed: u64,
    hz: f64,
) -> Result<Option<String>, LinalgError> {
    if peaks.len() < limits::FIRST_LOOK_ABOVE {
        return Ok(None);
    }
    let mut asked: Vec<(Columns, Vec<Peak>)> = split(sketch, peaks)
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
    asked.sort_by(|a, b| strength(&b.1).total_cmp(&strength(&a.1)));
    // one section may lack a mode that the whole chain would find; two do not by chance
    let mut doubts = asked
        .iter()
        .take(limits::ASKED)
        .filter_map(|(work, inside)| misfit(work, inside, seed, hz).transpose());
    let first = doubts.next().transpose()?;
    let second = doubts.next().transpose()?;
    Ok(first.filter(|_| second.is_some()))
}

/// A short chain on one section. Returns evidence if most of the striking peaks are misfitted,
/// if the misfit has no shape, or if the residual is far from white. Poles of lesser peaks do
/// not count: between a few modes in noise they would outvote them. A section whose residual is
/// next to nothing is left to the whole chain, whose poles are more exact.
fn misfit(
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
    let stands_for = |pole: &Complex64, peak: &Peak| {
        (pole.re - peak.lambda.re).abs() < limits::PEAK_EXPLAINED * peak.lambda.im
    };
    let strong: Vec<Complex64> = refined
        .lambda
        .iter()
        .copied()
        .filter(|pole| peaks.iter().any(|p| p.is_striking() && stands_for(pole, p)))
        .collect();
    let look = judge_columns(work, &strong, &refined.projection.residual, hz);
    let doubt =
        look.misfit_share > limits::MISFIT_SHARE || look.shapeless || look.excess > limits::CLEAR;
    Ok(doubt.then_some(look.evidence))
}
