//! Isolated modes that the lines resolve: what the peak itself says, free of the error
//! model.

use super::limits::{ALONE, ALONE_OF_OTHER, RESOLVED_LEAST_LINES, RESOLVED_LINES, WINDOW};
use crate::damping::basis::basis;
use crate::data::columns::Columns;
use crate::measured::sandwich::variances;
use crate::poles::refine::{refine, Refined};
use crate::tolerances as tol;
use chladni_linalg::{matmul, LinalgError};
use ndarray::{s, Array2};
use num_complex::Complex64;

/// Refits each such mode in a narrow window without multiplicative weights, and says the
/// variance E|δλ|² of what is found there. (On the measured beam this is where
/// independent local fits agree.) `residual` and `plain` are without line weights.
pub(crate) fn refine_resolved(
    plain: &Columns,
    weighted: &Columns,
    residual: &Array2<Complex64>,
    refined: &Refined,
) -> Result<(Refined, Vec<Option<f64>>), LinalgError> {
    let mut local_variance = vec![None; refined.lambda.len()];
    let mut lambda = refined.lambda.clone();
    for (q, slot) in lambda.iter_mut().enumerate() {
        let pole = refined.lambda[q];
        let far = |p: &Complex64| {
            (p.re - pole.re).abs() > (ALONE * pole.im).max(ALONE_OF_OTHER * p.im.abs())
        };
        let alone = refined
            .lambda
            .iter()
            .enumerate()
            .all(|(o, p)| o == q || far(p));
        if !plain.in_band(pole) || pole.im < RESOLVED_LINES * plain.spacing(pole.re) || !alone {
            continue;
        }
        let window = plain.window(pole, WINDOW, RESOLVED_LEAST_LINES);
        let local = plain.rows(window.clone());
        // the mode's own part and the residual, without everything else
        let own = matmul(
            basis(&local, &[pole], &[]).view(),
            refined.coefficients.slice(s![q..q + 1, ..]),
        );
        let columns = own + residual.slice(s![window, ..]);
        let local = local.with_columns(columns);
        let Ok(single) = refine(&local, &[pole], &[0, 1], tol::ROUGH.within(tol::FINE.steps))
        else {
            continue;
        };
        let moved = single.lambda[0];
        if (moved - pole).norm() < pole.im && moved.im > 0.0 {
            *slot = moved;
            let (robust, white) = variances(&local, &single)?;
            local_variance[q] = Some(robust[0].max(white[0]));
        }
    }
    Ok((
        refine(weighted, &lambda, &refined.powers, tol::NO_STEP)?,
        local_variance,
    ))
}
