//! Zeros of a sum of partial fractions.

use crate::poles::limits;
use chladni_linalg::{eigenvalues, LinalgError};
use ndarray::{Array1, Array2};
use num_complex::Complex64;

/// Zeros of d + Σ c_q/(λ_q − x), as many as there are poles: by simultaneous iteration from the
/// poles, which are near once vector fitting has nearly settled. If that does not converge, they
/// are the eigenvalues of diag(λ) + 1cᵀ/d.
///
/// # Errors
/// A decomposition that fails.
pub(crate) fn zeros(
    lambda: &[Complex64],
    c: &[Complex64],
    d: Complex64,
) -> Result<Vec<Complex64>, LinalgError> {
    let c: Vec<Complex64> = c.iter().map(|c| c / d).collect();
    if let Some(found) = by_iteration(lambda, &c) {
        return Ok(found);
    }
    let mut companion = Array2::from_diag(&Array1::from(lambda.to_vec()));
    for mut row in companion.rows_mut() {
        for (value, c) in row.iter_mut().zip(&c) {
            *value += c;
        }
    }
    Ok(eigenvalues(companion.view())?.to_vec())
}

/// Zeros of f(x) = 1 + Σ c_q/(λ_q − x) by the iteration of Ehrlich and Aberth on the numerator
/// P = f·Π(λ_q − x), P'/P = f'/f + Σ 1/(x − λ_q) (Aberth, Math. Comp. 27 (1973) 339). `None`
/// if some do not settle.
fn by_iteration(lambda: &[Complex64], c: &[Complex64]) -> Option<Vec<Complex64>> {
    let others = |n: usize| (0..lambda.len()).filter(move |&q| q != n);
    let first_guess = |n: usize| {
        let rest: Complex64 = others(n).map(|q| c[q] / (lambda[q] - lambda[n])).sum();
        lambda[n] + c[n] / (1.0 + rest)
    };
    let mut zeros: Vec<Complex64> = (0..lambda.len()).map(first_guess).collect();
    let mut moving = vec![true; lambda.len()];
    for _ in 0..limits::ZERO_STEPS {
        for n in 0..lambda.len() {
            if !moving[n] {
                continue;
            }
            let x = zeros[n];
            // f, f' and Σ 1/(x − λ_q)
            let (mut value, mut slope, mut poles) =
                (Complex64::ONE, Complex64::ZERO, Complex64::ZERO);
            for (&pole, &c) in lambda.iter().zip(c) {
                let over = (pole - x).inv();
                value += c * over;
                slope += c * over * over;
                poles -= over;
            }
            let repulsion: Complex64 = others(n).map(|q| (x - zeros[q]).inv()).sum();
            let step = (slope / value + poles - repulsion).inv();
            if !step.is_finite() {
                // a zero of the sum, or a pole that no fraction moves
                return None;
            }
            zeros[n] -= step;
            moving[n] = step.norm() > limits::ZERO_SETTLED * x.norm();
        }
        if moving.iter().all(|moving| !moving) {
            return Some(zeros);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn eigenvalues_of(lambda: &[Complex64], c: &[Complex64]) -> Vec<Complex64> {
        let size = lambda.len();
        let companion = Array2::from_shape_fn((size, size), |(i, q)| {
            c[q] + if i == q { lambda[i] } else { Complex64::ZERO }
        });
        eigenvalues(companion.view()).unwrap().to_vec()
    }

    #[test]
    fn zeros_are_the_eigenvalues_of_the_companion() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut settled = 0;
        for case in 0..200 {
            let size = 1 + case % 40;
            let mut drawn = |re: f64, im: f64| {
                Complex64::new(rng.random_range(-re..re), rng.random_range(0.1 * im..im))
            };
            let lambda: Vec<Complex64> = (0..size)
                .map(|n| n as f64 + 1.0 + drawn(0.4, 0.1))
                .collect();
            let moves = [1e-9, 1e-3, 0.1, 3.0][case % 4];
            let c: Vec<Complex64> = (0..size).map(|_| drawn(moves, moves)).collect();
            let expected = eigenvalues_of(&lambda, &c);
            settled += usize::from(by_iteration(&lambda, &c).is_some());
            let mut found = zeros(&lambda, &c, Complex64::ONE).unwrap();
            assert_eq!(found.len(), size);
            for zero in expected {
                let away = |other: &Complex64| (other - zero).norm();
                let (at, _) = (found.iter().map(away).enumerate())
                    .min_by(|a, b| a.1.total_cmp(&b.1))
                    .unwrap();
                let near = found.swap_remove(at);
                assert!(
                    away(&near) < 1e-9 * (1.0 + zero.norm()),
                    "{case}: {near} for {zero}"
                );
            }
        }
        assert!(settled > 150, "{settled} of 200");
    }

    #[test]
    fn a_pole_without_a_fraction_stays() {
        let lambda = [1.0, 2.0].map(|re| Complex64::new(re, 0.1));
        let c = [Complex64::ZERO, Complex64::new(0.5, 0.0)];
        let mut found = zeros(&lambda, &c, Complex64::ONE).unwrap();
        found.sort_by(|a, b| a.re.total_cmp(&b.re));
        assert!((found[0] - lambda[0]).norm() < 1e-12);
        assert!((found[1] - lambda[1] - 0.5).norm() < 1e-12);
    }
}
