//! One-step least squares with a plain ridge (method `tikhonov`), a baseline.
//!
//! A = (HᴴH + β·I)⁻¹ Hᴴ v, v = 1 on hot rows and 0 on cold ones, β =
//! `tolerances::TIKHONOV` times the largest eigenvalue of HᴴH. The ridge knows nothing
//! of what the model knows badly: against [`super::pressure_matching`], which differs in
//! that alone, it gives up good directions with the bad ones.

use crate::methods::pressure_matching::one_phase_target;
use crate::panel::drive::Drive;
use crate::panel::kernel_error::unsolvable;
use crate::problems::problem::Problem;
use crate::tolerances;
use chladni_frf::Result;
use chladni_linalg::{eigh, matmul_h, solve_hermitian};
use ndarray::Axis;
use num_complex::Complex64;

/// The drive of ridge regression.
pub(crate) fn solve(problem: &Problem) -> Result<Drive> {
    let mobility = problem.rows.mobility.view();
    let mut normal = matmul_h(mobility, mobility);
    let (values, _) = eigh(normal.view()).map_err(unsolvable)?;
    let ridge = tolerances::TIKHONOV * values.last().copied().unwrap_or(0.0);
    normal
        .diag_mut()
        .mapv_inplace(|value| value + Complex64::from(ridge));
    let right = matmul_h(
        mobility,
        one_phase_target(problem).insert_axis(Axis(1)).view(),
    );
    Ok(solve_hermitian(normal.view(), right.view())
        .map_err(unsolvable)?
        .column(0)
        .to_owned())
}
