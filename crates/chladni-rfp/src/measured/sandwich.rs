//! Covariance from the residual as it is: H⁻¹GH⁻¹ with neighbouring lines correlated (theory.md, eq. 23).

use crate::refine::Refined;
use crate::work::{basis_derivative, Work};
use chladni_linalg::{inverse_hermitian, matmul, matmul_h, LinalgError};
use ndarray::Array2;
use num_complex::Complex64;

/// Variance E|δλ|² of every pole: Bartlett-weighted over two bandwidths (White 1980; Newey & West 1987), and by white noise.
pub(crate) fn variances(work: &Work, refined: &Refined) -> Result<(Vec<f64>, Vec<f64>), LinalgError> {
    let n = refined.lambda.len();
    if n == 0 {
        return Ok((Vec::new(), Vec::new()));
    }
    let derivative = basis_derivative(work, &refined.lambda);
    let inside = matmul_h(refined.projection.q.view(), derivative.view());
    let outside = &derivative - &matmul(refined.projection.q.view(), inside.view());
    // score of a line: Σ_l conj(D_kn R_nl) E_kl
    let er = matmul(refined.projection.residual.view(), refined.coefficients.slice(ndarray::s![..n, ..]).mapv(|v| v.conj()).t());
    let scores = Array2::from_shape_fn((work.lines(), n), |(k, q)| outside[[k, q]].conj() * er[[k, q]]);
    let inverse = inverse_hermitian(refined.information.view())?;
    let influence = matmul(scores.view(), inverse.t());
    let white = refined.variance(work);
    let robust = (0..n)
        .map(|q| {
            let pole = refined.lambda[q];
            let lag_most = ((4.0 * pole.im / work.spacing(pole.re)) as usize).clamp(1, work.lines() / 4);
            let column = influence.column(q);
            let at = |lag: usize| -> f64 { (lag..work.lines()).map(|k| (column[k] * Complex64::conj(&column[k - lag])).re).sum() };
            let mut sum = at(0);
            for lag in 1..=lag_most {
                sum += 2.0 * (1.0 - lag as f64 / (lag_most + 1) as f64) * at(lag);
            }
            sum.max(0.0)
        })
        .collect();
    Ok((robust, (0..n).map(|q| white * inverse[[q, q]].re).collect()))
}
