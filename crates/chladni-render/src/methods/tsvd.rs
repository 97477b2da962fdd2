//! One-step least squares by a truncated singular value decomposition (method `tsvd`), a
//! baseline.
//!
//! A = Σ_s v_s (u_sᴴ v)/σ_s over the singular values of H above `tolerances::TSVD`
//! times the largest. The sharp edge between kept and dropped directions makes success
//! jump with the threshold.

use crate::methods::pressure_matching::one_phase_target;
use crate::panel::drive::Drive;
use crate::panel::kernel_error::unsolvable;
use crate::problems::problem::Problem;
use crate::tolerances;
use chladni_frf::Result;
use ndarray::Array1;
use num_complex::Complex64;

/// The drive of the truncated inverse.
pub(crate) fn solve(problem: &Problem) -> Result<Drive> {
    let (u, s, vh) = chladni_linalg::svd_thin(problem.rows.mobility.view()).map_err(unsolvable)?;
    let least = tolerances::TSVD * s.first().copied().unwrap_or(0.0);
    let coordinates = u
        .t()
        .mapv(|value| value.conj())
        .dot(&one_phase_target(problem));
    let scaled = Array1::from_shape_fn(s.len(), |k| {
        if s[k] > least {
            coordinates[k] / s[k]
        } else {
            Complex64::ZERO
        }
    });
    Ok(vh.t().mapv(|value| value.conj()).dot(&scaled))
}
