//! Anderson's acceleration of a slow fixed-point iteration x ← G(x).
//!
//! The next point is the combination of the last few whose change G(x) − x would be least if G were linear. D. G. Anderson, J. ACM 12
//! (1965) 547; H. F. Walker, P. Ni, SIAM J. Numer. Anal. 49 (2011) 1715.

use crate::tolerances as tol;
use chladni_linalg::lstsq;
use ndarray::{Array2, ShapeBuilder};
use num_complex::Complex64;
use std::collections::VecDeque;

/// What the last steps looked like.
#[derive(Default)]
pub(crate) struct Acceleration {
    /// G(x) − x and G(x) of the last step.
    last: Option<(Array2<Complex64>, Array2<Complex64>)>,
    /// How both changed from step to step, the oldest first.
    changes: VecDeque<(Array2<Complex64>, Array2<Complex64>)>,
}

impl Acceleration {
    /// The point to go on from, where `made` = G(`from`).
    pub fn next(&mut self, from: &Array2<Complex64>, made: &Array2<Complex64>) -> Array2<Complex64> {
        let change = made - from;
        if let Some((last_change, last_made)) = self.last.replace((change.clone(), made.clone())) {
            self.changes.push_back((&change - &last_change, made - &last_made));
        }
        if self.changes.len() > tol::STEPS_REMEMBERED {
            self.changes.pop_front();
        }
        let mut columns = Array2::zeros((change.len(), self.changes.len()).f());
        for (mut column, (of_change, _)) in columns.columns_mut().into_iter().zip(&self.changes) {
            column.iter_mut().zip(of_change).for_each(|(value, part)| *value = *part);
        }
        let right = Array2::from_shape_vec((change.len(), 1), change.iter().copied().collect()).expect("one column");
        let mut next = made.clone();
        // steps that tell the same twice: the next will differ
        if let Ok(shares) = lstsq(columns.view(), right.view()) {
            for ((_, of_made), &share) in self.changes.iter().zip(&shares) {
                next.zip_mut_with(of_made, |value, part| *value -= share * part);
            }
        }
        next
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_iteration_ends_after_as_many_steps_as_it_has_rates() {
        // x ← R·x + c with rates 0.99, 0.9j and −0.5, next to a fourth that is still: exact after three remembered steps
        let rates = [Complex64::new(0.99, 0.0), Complex64::new(0.0, 0.9), Complex64::new(-0.5, 0.0), Complex64::ZERO];
        let fixed = [Complex64::new(3.0, -1.0), Complex64::new(0.5, 2.0), Complex64::new(-4.0, 0.1), Complex64::ONE];
        let made = |x: &Array2<Complex64>| {
            Array2::from_shape_fn((2, 2), |(i, j)| fixed[2 * i + j] + rates[2 * i + j] * (x[[i, j]] - fixed[2 * i + j]))
        };
        let (mut x, mut acceleration) = (Array2::zeros((2, 2)), Acceleration::default());
        for _ in 0..5 {
            x = acceleration.next(&x, &made(&x));
        }
        let error = x.iter().zip(&fixed).map(|(x, fixed)| (x - fixed).norm()).fold(0.0, f64::max);
        assert!(error < 1e-9, "{error}");
    }
}
