//! Variable span trade-off (method `vast`), a baseline between contrast control and
//! pressure matching.
//!
//! With R_h U = R_c U diag(λ), UᴴR_cU = I, the `tolerances::VAST_RANK` directions of
//! largest λ carry the target: A = Σ_v u_v (u_vᴴ H_hᴴ 1)/(λ_v + 1) (Lee, Nielsen, Jensen
//! and Christensen 2018). R_c holds the error of the model, as in contrast control.

use crate::panel::drive::Drive;
use crate::panel::kernel_error::unsolvable;
use crate::problems::problem::Problem;
use crate::solving::least_squares::normal_matrix;
use crate::tolerances;
use chladni_frf::Result;
use chladni_linalg::{cholesky, eigh, matmul_h, solve_lower, solve_lower_adjoint};
use ndarray::{Array1, Array2, Axis};
use num_complex::Complex64;

/// The drive in the span of the directions of largest contrast.
pub(crate) fn solve(problem: &Problem) -> Result<Drive> {
    let rows = &problem.rows;
    let lower = cholesky(normal_matrix(problem, rows.hot..rows.mobility.nrows()).view())
        .map_err(unsolvable)?;
    let adjoint = |matrix: &Array2<Complex64>| matrix.t().mapv(|value| value.conj());
    // columns L⁻¹·h_hᴴ: whitened hot rows
    let hot = solve_lower(lower.view(), adjoint(&rows.hot_rows().to_owned()).view())
        .map_err(unsolvable)?;
    let whitened = adjoint(&hot);
    let (values, vectors) =
        eigh(matmul_h(whitened.view(), whitened.view()).view()).map_err(unsolvable)?;
    let target = hot.dot(&Array1::from_elem(rows.hot, Complex64::ONE));
    let rank = tolerances::VAST_RANK.min(values.len());
    let mut sum = Array1::<Complex64>::zeros(values.len());
    for v in values.len() - rank..values.len() {
        let direction = vectors.column(v);
        let share: Complex64 = direction
            .iter()
            .zip(&target)
            .map(|(u, t)| u.conj() * t)
            .sum();
        sum.scaled_add(share / (values[v] + 1.0), &direction);
    }
    let drive =
        solve_lower_adjoint(lower.view(), sum.insert_axis(Axis(1)).view()).map_err(unsolvable)?;
    Ok(drive.column(0).to_owned())
}
