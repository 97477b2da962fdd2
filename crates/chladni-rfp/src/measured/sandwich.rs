//! Covariance from the residual as it is: H⁻¹GH⁻¹ with neighbouring lines correlated
//! (theory.md, eq. 23).

use super::limits::{LAGS, LAGS_ONE_IN};
use crate::damping::basis::basis_derivative;
use crate::data::columns::Columns;
use crate::data::information::{covariance, kept_share};
use crate::poles::refine::Refined;
use chladni_linalg::{matmul, matmul_h, LinalgError};
use ndarray::Array2;
use num_complex::Complex64;

/// Variance E|δλ|² of every pole: Bartlett-weighted over two bandwidths (White 1980;
/// Newey & West 1987), and by white noise.
pub(crate) fn variances(
    work: &Columns,
    refined: &Refined,
) -> Result<(Vec<f64>, Vec<f64>), LinalgError> {
    let n = refined.lambda.len();
    if n == 0 {
        return Ok((Vec::new(), Vec::new()));
    }
    let derivative = basis_derivative(work, &refined.lambda);
    let inside = matmul_h(refined.projection.q.view(), derivative.view());
    let outside = &derivative - &matmul(refined.projection.q.view(), inside.view());
    // score of a line: Σ_l conj(D_kn R_nl) E_kl
    let er = matmul(
        refined.projection.residual.view(),
        refined
            .coefficients
            .slice(ndarray::s![..n, ..])
            .mapv(|v| v.conj())
            .t(),
    );
    let kept = kept_share(&refined.projection.q, &outside);
    let scores = Array2::from_shape_fn((work.lines(), n), |(k, q)| {
        outside[[k, q]].conj() * er[[k, q]] / kept[k]
    });
    let inverse = covariance(refined.information(work).view());
    let influence = matmul(scores.view(), inverse.t());
    let white = refined.variance(work);
    let robust = (0..n)
        .map(|q| {
            if inverse[[q, q]].re.is_infinite() {
                return f64::INFINITY;
            }
            let pole = refined.lambda[q];
            let lag_most = ((LAGS * pole.im / work.spacing(pole.re)) as usize)
                .clamp(1, work.lines() / LAGS_ONE_IN);
            let column = influence.column(q);
            let at = |lag: usize| -> f64 {
                (lag..work.lines())
                    .map(|k| (column[k] * Complex64::conj(&column[k - lag])).re)
                    .sum()
            };
            let alone = at(0);
            let mut sum = alone;
            for lag in 1..=lag_most {
                sum += 2.0 * (1.0 - lag as f64 / (lag_most + 1) as f64) * at(lag);
            }
            // the scores of a fit add up to zero: over long lags their sum may fall below that
            // of independent lines
            sum.max(alone)
        })
        .collect();
    Ok((robust, (0..n).map(|q| white * inverse[[q, q]].re).collect()))
}
