//! Anderson's acceleration of a slow fixed-point iteration x ← G(x).
//!
//! The next point is the combination of the last few whose change G(x) − x would be least
//! if G were linear. D. G. Anderson, J. ACM 12 (1965) 547; H. F. Walker, P. Ni, SIAM J.
//! Numer. Anal. 49 (2011) 1715.

use crate::shapes::limits;
use chladni_linalg::solve_hermitian;
use ndarray::{Array2, Zip};
use num_complex::Complex64;
use std::collections::VecDeque;

/// The last steps of the iteration.
#[derive(Default)]
pub(crate) struct Acceleration {
    /// G(x) − x and G(x) of the last step.
    last: Option<(Array2<Complex64>, Array2<Complex64>)>,
    /// Changes of both from step to step, the oldest first.
    changes: VecDeque<(Array2<Complex64>, Array2<Complex64>)>,
}

impl Acceleration {
    /// The point to go on from, where `made` = G(`from`).
    pub fn next(
        &mut self,
        from: &Array2<Complex64>,
        made: &Array2<Complex64>,
    ) -> Array2<Complex64> {
        let change = made - from;
        if let Some((last_change, last_made)) = self.last.replace((change.clone(), made.clone())) {
            self.changes
                .push_back((&change - &last_change, made - &last_made));
        }
        if self.changes.len() > limits::STEPS_REMEMBERED {
            self.changes.pop_front();
        }
        let along = |a: &Array2<Complex64>, b: &Array2<Complex64>| {
            Zip::from(a)
                .and(b)
                .fold(Complex64::ZERO, |sum, a, b| sum + a.conj() * b)
        };
        let size: Vec<f64> = self
            .changes
            .iter()
            .map(|(step, _)| along(step, step).re.sqrt().max(f64::MIN_POSITIVE))
            .collect();
        let steps = &self.changes;
        let gram = Array2::from_shape_fn((size.len(), size.len()), |(i, j)| {
            // steps that tell nearly the same twice share what they explain
            let ridge = if i == j { limits::STEPS_RIDGE } else { 0.0 };
            along(&steps[i].0, &steps[j].0) / (size[i] * size[j]) + ridge
        });
        let right = Array2::from_shape_fn((size.len(), 1), |(i, _)| {
            along(&steps[i].0, &change) / size[i]
        });
        let mut next = made.clone();
        if let Ok(shares) = solve_hermitian(gram.view(), right.view()) {
            for (((_, of_made), &share), size) in steps.iter().zip(&shares).zip(&size) {
                next.zip_mut_with(of_made, |value, part| *value -= share * part / size);
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
        // x ← R·x + c with rates 0.99, 0.9j and −0.5, next to a fourth that is still:
        // exact after three remembered steps
        let rates = [
            Complex64::new(0.99, 0.0),
            Complex64::new(0.0, 0.9),
            Complex64::new(-0.5, 0.0),
            Complex64::ZERO,
        ];
        let fixed = [
            Complex64::new(3.0, -1.0),
            Complex64::new(0.5, 2.0),
            Complex64::new(-4.0, 0.1),
            Complex64::ONE,
        ];
        let made = |x: &Array2<Complex64>| {
            Array2::from_shape_fn((2, 2), |(i, j)| {
                fixed[2 * i + j] + rates[2 * i + j] * (x[[i, j]] - fixed[2 * i + j])
            })
        };
        let (mut x, mut acceleration) = (Array2::zeros((2, 2)), Acceleration::default());
        for _ in 0..5 {
            x = acceleration.next(&x, &made(&x));
        }
        let error = x
            .iter()
            .zip(&fixed)
            .map(|(x, fixed)| (x - fixed).norm())
            .fold(0.0, f64::max);
        assert!(error < 1e-9, "{error}");
    }
}
