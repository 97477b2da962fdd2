//! Contrast control: the drive with the most mean-square velocity in the hot zone for
//! what it spills into the cold one.
//!
//! max over A of ‖H_h·A‖² / (‖H_c·A‖² + K_c‖L·A‖²): the largest eigenvector of H_h B⁻¹
//! H_hᴴ, B = H_cᴴH_c + K_c LᴴL, mapped back by A = B⁻¹ H_hᴴ z (Choi and Kim 2002). Serves
//! as a start of [`super::mls`]; alone it lets the hot zone have nodal lines.

use crate::panel::drive::Drive;
use crate::panel::kernel_error::unsolvable;
use crate::problems::problem::Problem;
use crate::solving::least_squares::normal_matrix;
use chladni_frf::Result;
use chladni_linalg::{eigh, matmul, solve_hermitian};

/// The contrast-control direction, of arbitrary gain; the mean velocity of the hot rows
/// has phase 0, whatever phase the eigenvector came with.
pub(crate) fn direction(problem: &Problem) -> Result<Drive> {
    let rows = &problem.rows;
    let cold = normal_matrix(problem, rows.hot..rows.mobility.nrows());
    let adjoint = rows.hot_rows().t().mapv(|value| value.conj());
    let back = solve_hermitian(cold.view(), adjoint.view()).map_err(unsolvable)?;
    let (_, vectors) = eigh(matmul(rows.hot_rows(), back.view()).view()).map_err(unsolvable)?;
    let direction = back.dot(&vectors.column(vectors.ncols() - 1));
    Ok(problem.in_phase(direction))
}
