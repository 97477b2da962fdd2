//! Poles found in one damping law, converted to the other on the same columns.

use crate::damping::basis::RESIDUAL_POWERS;
use crate::damping::places::in_plane_of;
use crate::poles::estimate::{graded, PoleEstimate};
use crate::poles::refine::{refine, refine_inside};
use crate::poles::settle::settle;
use crate::tolerances as tol;
use chladni_frf::Damping;
use chladni_linalg::LinalgError;
use num_complex::Complex64;

/// The poles of `found` in another law, refined there.
///
/// * `frfs`: number of FRFs if their residual is noise. Their number of poles is settled anew: a pole
///   that one law needs outside the band or beside its modes may be useless in the other.
///
/// # Errors
/// A kernel that fails.
pub(crate) fn in_law(
    found: PoleEstimate,
    law: Damping,
    frfs: Option<usize>,
) -> Result<PoleEstimate, LinalgError> {
    if found.work.law == law {
        return Ok(found);
    }
    let converted: Vec<(usize, Complex64)> = found
        .refined
        .lambda
        .iter()
        .enumerate()
        .filter_map(|(n, pole)| Some((n, in_plane_of(law, *pole)?)))
        .collect();
    let start: Vec<Complex64> = converted.iter().map(|(_, pole)| *pole).collect();
    let idle = found.idle.iter();
    let idle: Vec<Complex64> = idle.filter_map(|pole| in_plane_of(law, *pole)).collect();
    let work = found.work.in_law(law);
    let mut refined = match work.leakage.is_some() && frfs.is_none() {
        true => refine_inside(&work, &start, &RESIDUAL_POWERS, tol::FINE)?,
        false => refine(&work, &start, &RESIDUAL_POWERS, tol::FINE)?,
    };
    let Some(frfs) = frfs else {
        let kept = |&(n, _): &(usize, Complex64)| (found.grades[n].clone(), found.spread[n]);
        let (grades, spread) = converted.iter().map(kept).unzip();
        return Ok(PoleEstimate {
            grades,
            spread,
            work,
            refined,
            idle,
            ..found
        });
    };
    let mut variance = found.variance;
    settle(&work, &mut refined, &mut variance, frfs, &mut Vec::new())?;
    refined = refine(&work, &refined.lambda, &RESIDUAL_POWERS, tol::FINE)?;
    let rise = refined.projection.sse - found.refined.projection.sse;
    let rise_of_variance = rise / (work.lines() * frfs) as f64;
    let variance = (found.variance + rise_of_variance).max(f64::MIN_POSITIVE);
    let (grades, spread) = graded(&refined, &work, variance);
    Ok(PoleEstimate {
        grades,
        spread,
        work,
        refined,
        variance,
        idle,
        ..found
    })
}
