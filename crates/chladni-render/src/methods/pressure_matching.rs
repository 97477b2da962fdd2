//! Pressure matching with the model's own covariance (method `pressure-matching`, also
//! `fast`).
//!
//! A = (HᴴH + K·LᴴL)⁻¹ Hᴴ v, v = 1 on hot rows and 0 on cold ones; K rows, all of them
//! judged: rows of the transition are left out (with them the study's success fell from
//! 0.926 to 0.882). LᴴL is the expected error of one row of H, so this minimises the
//! expected squared misfit. The gain is set afterwards, on counts (module `gain`).
//!
//! Pressure matching is the name in sound-zone work (Poletti 2008; Betlehem et al. 2015).
//! Not for final drives: one phase all over the hot zone costs 7 to 20 points of hot
//! success against [`super::mls`].

use crate::methods::gain::within_drive_limit;
use crate::methods::solution::Solution;
use crate::problems::problem::Problem;
use crate::solving::least_squares::LeastSquares;
use chladni_frf::Result;
use ndarray::{Array1, Array2};
use num_complex::Complex64;

/// The drive of pressure matching.
pub(crate) fn solve(problem: &Problem) -> Result<Solution> {
    within_drive_limit(problem, |ridge| {
        let hot = Array2::from_elem((problem.rows.hot, 1), Complex64::ONE);
        let drives = LeastSquares::new(problem, ridge)?.drives(hot.view())?;
        Ok(problem.with_best_gain(&drives.column(0).to_owned()))
    })
}

/// 1 on hot rows, 0 on cold ones.
pub(crate) fn one_phase_target(problem: &Problem) -> Array1<Complex64> {
    Array1::from_shape_fn(problem.rows.mobility.nrows(), |k| {
        Complex64::from(if problem.rows.is_hot(k) { 1.0 } else { 0.0 })
    })
}
