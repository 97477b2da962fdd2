//! Pole pool by relaxed vector fitting in the plane x = ω²/ω_max² (theory.md, eq. 7).
//!
//! σ(x) = d + Σ c_q/(λ_q − x) multiplies the data; numerators are eliminated column by column, and the zeros of σ are the
//! next poles. Gustavsen & Semlyen, IEEE Trans. Power Delivery 14 (1999) 1052; relaxed form: Gustavsen, ibid. 21 (2006) 1587.
//! The only starter after which the maximum-likelihood step lost no mode in our study; as an estimator on its own it is
//! one to five times above the bound. Cost per step ≈ 8·N·m²·(r + 2) flop.

use crate::wide::{tall_qr, wide_h};
use crate::work::{basis, line_energy, Work};
use chladni_linalg::{eigenvalues, matmul, matmul_h, solve_hermitian, LinalgError};
use ndarray::{Array1, Array2, ShapeBuilder};
use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Poles as the last step left them; those with Im λ ≤ 0 are flipped in `lambda` and marked in `flipped`.
#[derive(Debug, Clone)]
pub(crate) struct Pool {
    /// Poles with Im λ > 0.
    pub lambda: Vec<Complex64>,
    /// True where the pole left with a negative loss factor.
    pub flipped: Vec<bool>,
}

/// Random mixtures of the columns (fixed seed): what vector fitting works on instead of all of them.
pub(crate) fn mixtures(work: &Work, count: usize, seed: u64) -> Work {
    if work.columns() <= count {
        return work.clone();
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let scale = 1.0 / (work.columns() as f64).sqrt();
    let mixing =
        Array2::from_shape_fn((work.columns(), count).f(), |_| Complex64::from_polar(scale, rng.random_range(0.0..std::f64::consts::TAU)));
    work.with_columns(matmul(work.b.view(), mixing.view()))
}

/// Starting poles: the given seeds, and the rest spread evenly over the band.
pub(crate) fn starts(work: &Work, seeds: &[Complex64], count: usize) -> Vec<Complex64> {
    let mut poles: Vec<Complex64> = seeds.iter().copied().take(count).collect();
    let (low, high) = work.range();
    let fill = count - poles.len();
    for i in 0..fill {
        let x = low + (high - low) * (i as f64 + 0.5) / fill as f64;
        let width = (0.01 * x).max(work.spacing(x)).max(1e-6 * high);
        poles.push(Complex64::new(x, width));
    }
    separate(&mut poles);
    poles
}

/// Moves equal poles apart, so that the basis keeps full rank.
fn separate(poles: &mut [Complex64]) {
    poles.sort_by(|a, b| a.re.total_cmp(&b.re));
    for i in 1..poles.len() {
        let gap = 0.05 * poles[i - 1].im.min(poles[i].im);
        if (poles[i] - poles[i - 1]).norm() < gap {
            poles[i] = poles[i - 1] + Complex64::new(gap, 0.5 * gap);
        }
    }
}

/// Relaxed vector fitting from `start`, `iterations` steps.
pub(crate) fn vector_fit(work: &Work, start: &[Complex64], powers: &[i32], iterations: usize) -> Result<Pool, LinalgError> {
    let mut pool = Pool { lambda: start.to_vec(), flipped: vec![false; start.len()] };
    for _ in 0..iterations {
        let next = relocate(work, &pool.lambda, powers)?;
        pool.flipped = next.iter().map(|p| p.im <= 0.0).collect();
        pool.lambda = next
            .into_iter()
            .map(|p| {
                let floor = 1e-9 * work.range().1;
                Complex64::new(p.re, p.im.abs().max(floor))
            })
            .collect();
        let mut order: Vec<usize> = (0..pool.lambda.len()).collect();
        order.sort_by(|&a, &b| pool.lambda[a].re.total_cmp(&pool.lambda[b].re));
        pool = Pool { lambda: order.iter().map(|&i| pool.lambda[i]).collect(), flipped: order.iter().map(|&i| pool.flipped[i]).collect() };
        separate(&mut pool.lambda);
    }
    Ok(pool)
}

/// One step: zeros of σ.
fn relocate(work: &Work, lambda: &[Complex64], powers: &[i32]) -> Result<Vec<Complex64>, LinalgError> {
    let (n, lines) = (lambda.len(), work.lines());
    let (q, _) = tall_qr(basis(work, lambda, powers).view())?;
    let mut psi = Array2::from_elem((lines, n + 1).f(), Complex64::new(1.0, 0.0));
    for (column, &pole) in lambda.iter().enumerate() {
        for (value, &x) in psi.column_mut(column).into_iter().zip(&work.x) {
            *value = 1.0 / (pole - x);
        }
    }
    // M = Σ_l (D_lΨ)ᴴ(I − QQᴴ)(D_lΨ)
    let energy = line_energy(&work.b) * work.columns() as f64;
    let mut weighted = psi.clone();
    for mut column in weighted.columns_mut() {
        column.zip_mut_with(&energy, |v, e| *v *= e.sqrt());
    }
    let mut gram = wide_h(weighted.view(), weighted.view());
    let scale: Vec<f64> = gram.diag().iter().map(|v| 1.0 / v.re.max(f64::MIN_POSITIVE).sqrt()).collect();
    let columns: Vec<_> = work.b.columns().into_iter().collect();
    let explained = columns.into_par_iter().map(|data| {
        let mut scaled = q.clone();
        for mut column in scaled.columns_mut() {
            column.zip_mut_with(&data, |v, d| *v *= d.conj());
        }
        let inside = matmul_h(scaled.view(), psi.view());
        matmul_h(inside.view(), inside.view())
    });
    explained.collect::<Vec<_>>().iter().for_each(|part| gram -= part);
    let sums: Array1<Complex64> = psi.columns().into_iter().map(|c| c.sum()).collect();
    let sigma = minimise(&gram, &scale, &sums, lines as f64)?;
    if sigma[n].norm() == 0.0 || !sigma[n].is_finite() {
        return Ok(lambda.to_vec());
    }
    zeros(lambda, &sigma[..n], sigma[n])
}

/// Zeros of d + Σ c_q/(λ_q − x): the eigenvalues of diag(λ) + 1cᵀ/d.
pub(crate) fn zeros(lambda: &[Complex64], c: &[Complex64], d: Complex64) -> Result<Vec<Complex64>, LinalgError> {
    let mut companion = Array2::from_diag(&Array1::from(lambda.to_vec()));
    for mut row in companion.rows_mut() {
        for (value, c) in row.iter_mut().zip(c) {
            *value += c / d;
        }
    }
    Ok(eigenvalues(companion.view())?.to_vec())
}

/// Minimises vᴴMv under Σ_k σ(x_k) = `total` (the relaxation that keeps σ from vanishing).
fn minimise(gram: &Array2<Complex64>, scale: &[f64], sums: &Array1<Complex64>, total: f64) -> Result<Vec<Complex64>, LinalgError> {
    let size = gram.nrows();
    let right = Array2::from_shape_fn((size, 1), |(i, _)| sums[i].conj() * scale[i]);
    let mut ridge = 1e-14;
    loop {
        let matrix = Array2::from_shape_fn((size, size), |(i, j)| {
            let value = gram[[i, j]] * scale[i] * scale[j];
            if i == j {
                value + ridge
            } else {
                value
            }
        });
        match solve_hermitian(matrix.view(), right.view()) {
            Ok(solution) => {
                let along: Complex64 = (0..size).map(|i| sums[i] * scale[i] * solution[[i, 0]]).sum();
                return Ok((0..size).map(|i| solution[[i, 0]] * scale[i] * total / along).collect());
            }
            Err(error) if ridge > 1e-4 => return Err(error),
            Err(_) => ridge *= 100.0,
        }
    }
}
