//! Viscous poles beyond the band, taken to where the columns of the file explain the data
//! best.
//!
//! Poles are found with columns c·φ, which are complex-analytic; a file holds pairs,
//! (α + jyβ)·φ. Near its resonance a mode has the same of both. Far from it the second
//! column differs, and a pole that stands for several modes of the world outside must move
//! with the change.

use crate::damping::viscous::{halves, pair_slopes, viscous_basis};
use crate::data::columns::Columns;
use crate::data::information::{answer, covariance};
use crate::tolerances as tol;
use chladni_linalg::blocked::{blocked_matmul_h, projected, tall_qr};
use chladni_linalg::{matmul, solve_upper};
use ndarray::{Array2, Axis};
use num_complex::Complex64;

/// Part of the sum of squares of a step that it must promise, for the next one to be made.
const PROMISED: f64 = 1e-7;
/// Part of itself that a step leaves of a pole's damping and of its frequency.
const KEPT: f64 = 0.3;
/// Largest damping ratio that a pole may come to.
const DAMPED: f64 = 0.7;

/// Poles where they explain the data best.
pub(crate) struct Pairs {
    /// s of each.
    pub poles: Vec<Complex64>,
    /// Sum of squares left.
    pub sse: f64,
    /// Covariances of (Re s, Im s) of those that were free, for unit noise variance.
    pub spread: Vec<[[f64; 2]; 2]>,
}

/// The poles s, those at the places `free` refined in at most `steps` steps with all
/// residues free, none of them into the band. `None`: columns that cannot be told apart.
pub(crate) fn refined_pairs(
    work: &Columns,
    poles: &[Complex64],
    powers: &[i32],
    free: &[usize],
    steps: usize,
) -> Option<Pairs> {
    let data = halves(&work.b);
    let mut here = Point::at(work, &data, poles, powers)?;
    let mut poles = poles.to_vec();
    let mut damping = tol::LM_START;
    for _ in 0..if free.is_empty() { 0 } else { steps } {
        let (information, gradient) = here.system(work, &poles, free);
        let mut damped = information;
        damped
            .diag_mut()
            .mapv_inplace(|v| v * (1.0 + damping) + f64::MIN_POSITIVE);
        let Ok(step) = answer(damped.view(), gradient.view()) else {
            break;
        };
        let promised: f64 = step.iter().zip(&gradient).map(|(s, g)| s * g).sum();
        let trial = moved(work, &poles, free, &step);
        match Point::at(work, &data, &trial, powers).filter(|next| next.sse <= here.sse) {
            Some(next) => {
                (poles, here) = (trial, next);
                damping *= 0.1;
            }
            None => damping = (damping * 10.0).max(1e-6),
        }
        if promised < PROMISED * here.sse || damping > tol::LM_GIVE_UP {
            break;
        }
    }
    let mut spread = Vec::new();
    if !free.is_empty() {
        let all = covariance(here.system(work, &poles, free).0.view());
        let block = |at: usize| [0, 1].map(|i| [0, 1].map(|j| 0.5 * all[[2 * at + i, 2 * at + j]]));
        spread.extend((0..free.len()).map(block));
    }
    Some(Pairs {
        spread,
        sse: here.sse,
        poles,
    })
}

/// Poles after a step of (Re s, Im s) of those `free`.
fn moved(
    work: &Columns,
    poles: &[Complex64],
    free: &[usize],
    step: &Array2<f64>,
) -> Vec<Complex64> {
    let (low, high) = work.range();
    let (low, high) = (low.sqrt(), high.sqrt());
    let mut moved = poles.to_vec();
    for (at, &n) in free.iter().enumerate() {
        let pole = poles[n];
        let size = pole.norm();
        let beyond = (low - size).max(size - high).max(0.0);
        let delta = Complex64::new(step[[2 * at, 0]], step[[2 * at + 1, 0]]);
        let cap = 0.5 * pole.re.abs() + 0.3 * beyond;
        let next = pole + delta * (cap / delta.norm().max(cap));
        let im = next.im.max(KEPT * pole.im);
        let most = -im * DAMPED / (1.0 - DAMPED * DAMPED).sqrt();
        let next = Complex64::new(next.re.min(KEPT * pole.re).max(most.min(pole.re)), im);
        if !(low..=high).contains(&next.norm()) {
            moved[n] = next;
        }
    }
    moved
}

/// Everything linear at one set of poles.
struct Point {
    /// Orthonormal basis of all columns, (2·line, ·).
    q: Array2<f64>,
    /// Coefficients of pole columns and residual terms, (·, column).
    coefficients: Array2<f64>,
    residual: Array2<f64>,
    sse: f64,
}

impl Point {
    fn at(work: &Columns, data: &Array2<f64>, poles: &[Complex64], powers: &[i32]) -> Option<Self> {
        let (q, r) = tall_qr(viscous_basis(work, poles, powers).view()).ok()?;
        let (inside, residual) = projected(q.view(), data.view());
        let coefficients = solve_upper(r.view(), inside.view()).ok()?;
        let sse: f64 = residual.iter().map(|v| v * v).sum();
        (sse.is_finite() && coefficients.iter().all(|v| v.is_finite())).then_some(Self {
            q,
            coefficients,
            residual,
            sse,
        })
    }

    /// Gauss–Newton matrix and gradient of (Re s, Im s) of the poles `free`.
    ///
    /// A residue X₁ + jX₂ changes the model by X₁e₁ + X₂e₂ along Re s and by X₁e₂ − X₂e₁
    /// along Im s, with e₁ and e₂ of [`pair_slopes`].
    fn system(
        &self,
        work: &Columns,
        poles: &[Complex64],
        free: &[usize],
    ) -> (Array2<f64>, Array2<f64>) {
        let own: Vec<Complex64> = free.iter().map(|&n| poles[n]).collect();
        let slopes = pair_slopes(work, &own);
        let (_, outside) = projected(self.q.view(), slopes.view());
        let products = blocked_matmul_h(outside.view(), outside.view());
        let rows: Vec<usize> = free.iter().flat_map(|n| [2 * n, 2 * n + 1]).collect();
        let residues = self.coefficients.select(Axis(0), &rows);
        // of each unknown, the factors of e₁ and of e₂: rows of the residues and their signs
        let factors = |unknown: usize| {
            let first = unknown - unknown % 2;
            match unknown % 2 {
                0 => [(first, 1.0), (first + 1, 1.0)],
                _ => [(first + 1, -1.0), (first, 1.0)],
            }
        };
        let of_residues = matmul(residues.view(), residues.t());
        let along = matmul(
            blocked_matmul_h(outside.view(), self.residual.view()).view(),
            residues.t(),
        );
        let size = 2 * free.len();
        let slope = |unknown: usize, part: usize| unknown - unknown % 2 + part;
        let information = Array2::from_shape_fn((size, size), |(u, v)| {
            let (of_u, of_v) = (factors(u), factors(v));
            let mut sum = 0.0;
            for (i, (row, sign)) in of_u.into_iter().enumerate() {
                for (j, (other, other_sign)) in of_v.into_iter().enumerate() {
                    sum += sign
                        * other_sign
                        * products[[slope(u, i), slope(v, j)]]
                        * of_residues[[row, other]];
                }
            }
            sum
        });
        let gradient = Array2::from_shape_fn((size, 1), |(u, _)| {
            factors(u)
                .into_iter()
                .enumerate()
                .map(|(i, (row, sign))| sign * along[[slope(u, i), row]])
                .sum()
        });
        (information, gradient)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::ShapeBuilder;

    /// Lines with a mode in the band and two below, seen through `columns` FRFs.
    fn lines(columns: usize) -> (Columns, Vec<Complex64>) {
        let x: Vec<f64> = (0..400)
            .map(|k| (0.3 + 0.00175 * f64::from(k)).powi(2))
            .collect();
        let poles = [(0.12, 0.004), (0.55, 0.005)].map(|(y, re)| Complex64::new(-re, y));
        let mut work = Columns {
            g: x.iter().map(|x| x.sqrt()).collect(),
            b: Array2::zeros((x.len(), 0)),
            x,
            law: chladni_frf::Damping::Viscous,
        };
        let basis = viscous_basis(&work, &poles, &[-1, 0, 1, 2]);
        let coefficients = Array2::from_shape_fn((basis.ncols(), columns), |(i, c)| {
            ((3 * i + 5 * c) as f64).sin()
        });
        let values = matmul(basis.view(), coefficients.view());
        let lines = work.lines();
        work.b = Array2::from_shape_fn((lines, columns).f(), |(k, c)| {
            Complex64::new(values[[k, c]], values[[lines + k, c]])
        });
        (work, poles.to_vec())
    }

    #[test]
    fn a_pole_below_the_band_is_found_in_the_columns_of_the_file() {
        let (work, truth) = lines(3);
        let start = [truth[0] * Complex64::new(1.15, 0.05), truth[1]];
        let found = refined_pairs(&work, &start, &[-1, 0, 1, 2], &[0], 20)
            .unwrap()
            .poles;
        let distance = (found[0] - truth[0]).norm();
        assert!(distance < 1e-4 * truth[0].norm(), "{found:?}");
        assert_eq!(found[1], truth[1]);
    }

    #[test]
    fn slopes_of_the_model_are_those_of_finite_differences() {
        let (work, poles) = lines(2);
        let powers = [-1, 0];
        let data = halves(&work.b);
        let start = [poles[0] * 1.1, poles[1]];
        let sse = |poles: &[Complex64]| Point::at(&work, &data, poles, &powers).unwrap().sse;
        let here = Point::at(&work, &data, &start, &powers).unwrap();
        let (_, gradient) = here.system(&work, &start, &[0]);
        for (u, unit) in [Complex64::ONE, Complex64::I].into_iter().enumerate() {
            let step = 1e-6;
            let at = |sign: f64| sse(&[start[0] + unit * (sign * step), start[1]]);
            let difference = -(at(1.0) - at(-1.0)) / (4.0 * step);
            let error = (difference - gradient[[u, 0]]).abs();
            assert!(
                error < 1e-3 * difference.abs(),
                "{difference} for {gradient}"
            );
        }
    }
}
