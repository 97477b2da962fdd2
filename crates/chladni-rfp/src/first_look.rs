//! One section of a long band, judged before the fast chain begins.

use crate::order::{pool_size, row_energy, started, Start};
use crate::pool::mixtures;
use crate::section::{split, Section};
use crate::seeds::Peak;
use crate::tolerances as tol;
use crate::whiteness::judge;
use crate::work::Work;
use chladni_linalg::LinalgError;
use num_complex::Complex64;

/// Many modes make the chain dear, and where most of them are misfitted it is in vain: one section is asked first. Evidence that
/// its residual is not white; `None`: it may be, or the band is no longer than a section.
pub(crate) fn first_look(sketch: &Work, peaks: &[Peak], seed: u64, hz: f64) -> Result<Option<String>, LinalgError> {
    if peaks.len() < tol::FIRST_LOOK_ABOVE {
        return Ok(None);
    }
    let inside = |lines: &std::ops::Range<usize>| {
        let (low, high) = (sketch.x[lines.start], sketch.x[lines.end - 1]);
        peaks.iter().filter(move |p| (low..=high).contains(&p.lambda.re))
    };
    let strength = |s: &Section| inside(&s.lines).map(|p| p.over_noise_db).sum::<f64>();
    let sections = split(sketch, peaks);
    let Some(section) = sections.iter().max_by(|a, b| strength(a).total_cmp(&strength(b))) else { return Ok(None) };
    let work = sketch.rows(section.lines.clone());
    let seeds: Vec<Complex64> = inside(&section.lines).map(|p| p.lambda).collect();
    let size = pool_size(&work, seeds.len(), None)?;
    let Start { refined, .. } = started(&work, &mixtures(&work, tol::POOL_MIXTURES, seed), &seeds, size)?;
    let look = judge(&work, &refined.lambda, &row_energy(&refined.projection.residual), work.columns(), &refined.projection.residual, hz);
    Ok((look.misfit_share > tol::MISFIT_SHARE).then_some(look.evidence))
}
