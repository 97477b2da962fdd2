//! Pole pool by relaxed vector fitting in the plane x = ω²/ω_max² (theory.md, eq. 7).
//!
//! σ(x) = d + Σ c_q/(λ_q − x) multiplies the data; numerators are eliminated column by
//! column, and the zeros of σ are the next poles. Gustavsen & Semlyen, IEEE Trans. Power
//! Delivery 14 (1999) 1052; relaxed form: Gustavsen, ibid. 21 (2006) 1587. In our study it was
//! the only start from which the maximum-likelihood steps lost no mode. As an estimator on its own
//! it is one to five times above the bound.
//!
//! Notation: Φ = (1/(λ_q − x), x^p) times g is the basis of the data, Q its orthonormal basis,
//! Ψ = (1/(λ_q − x), 1) that of σ, and D_l the diagonal matrix of column l of the data.

use crate::damping::basis::basis;
use crate::damping::gram::Beside;
use crate::damping::law::{is_rational, RATIONAL};
use crate::data::columns::{line_energy, Columns};
use crate::poles::limits;
use crate::poles::zeros::zeros;
use crate::tolerances as tol;
use chladni_linalg::blocked::{blocked_gram, tall_qr, tall_r};
use chladni_linalg::{cholesky, matmul, matmul_h, solve_hermitian, solve_lower, LinalgError};
use ndarray::{s, Array1, Array2, ArrayView2, ShapeBuilder};
use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Poles after the last step.
#[derive(Debug, Clone)]
pub(crate) struct Pool {
    /// Poles with Im λ > 0: others are flipped.
    pub lambda: Vec<Complex64>,
    /// True for a pole that was flipped.
    pub flipped: Vec<bool>,
}

/// Random mixtures of the columns, drawn with a fixed seed: vector fitting works on them instead of
/// all columns.
pub(crate) fn mixtures(work: &Columns, count: usize, seed: u64) -> Columns {
    if work.columns() <= count {
        return work.clone();
    }
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let scale = 1.0 / (work.columns() as f64).sqrt();
    let mixing = Array2::from_shape_fn((work.columns(), count).f(), |_| {
        Complex64::from_polar(scale, rng.random_range(0.0..std::f64::consts::TAU))
    });
    work.with_columns(matmul(work.b.view(), mixing.view()))
}

/// Starting poles: the given seeds, and the rest spread evenly over the band.
pub(crate) fn starts(work: &Columns, seeds: &[Complex64], count: usize) -> Vec<Complex64> {
    let mut poles: Vec<Complex64> = seeds.iter().copied().take(count).collect();
    let (low, high) = work.range();
    let fill = count - poles.len();
    for i in 0..fill {
        let x = low + (high - low) * (i as f64 + 0.5) / fill as f64;
        let width = (limits::START_LOSS * x)
            .max(work.spacing(x))
            .max(limits::START_WIDTH_LEAST * high);
        poles.push(Complex64::new(x, width));
    }
    separate(&mut poles);
    poles
}

/// Moves equal poles apart, so that the basis keeps full rank.
fn separate(poles: &mut [Complex64]) {
    poles.sort_by(|a, b| a.re.total_cmp(&b.re));
    for i in 1..poles.len() {
        let gap = limits::START_GAP * poles[i - 1].im.min(poles[i].im);
        if (poles[i] - poles[i - 1]).norm() < gap {
            poles[i] = poles[i - 1] + Complex64::new(gap, 0.5 * gap);
        }
    }
}

/// Relaxed vector fitting from `start`, in at most `iterations` steps. With partial fractions it
/// ends once a step hardly changes the sum of squares, because these poles will be refined.
pub(crate) fn vector_fit(
    work: &Columns,
    start: &[Complex64],
    powers: &[i32],
    iterations: usize,
    step_basis: StepBasis,
) -> Result<Pool, LinalgError> {
    // zeros of σ are poles in x, whatever law they will be refined in and whatever leaks
    let rational;
    let leakage = work
        .leakage
        .as_ref()
        .map(|leaking| leaking.leakage.as_ref());
    let work = match (is_rational(work.law), leakage) {
        (true, None) => work,
        _ => {
            rational = Columns {
                leakage: None,
                ..work.clone().in_law(RATIONAL)
            };
            &rational
        }
    };
    let mut pool = Pool {
        lambda: start.to_vec(),
        flipped: vec![false; start.len()],
    };
    let narrowest = limits::RELOCATED_WIDTH_LEAST * work.range().1;
    let mut sse_before = f64::INFINITY;
    for _ in 0..iterations {
        let (zeros, sse) = relocate(work, &pool.lambda, powers, step_basis)?;
        pool = Pool::of_zeros(zeros, narrowest);
        if matches!(step_basis, StepBasis::PartialFractions)
            && (sse_before - sse).abs() < limits::POOL_SETTLED * sse
        {
            break;
        }
        sse_before = sse;
    }
    if let Some(leakage) = leakage {
        for pole in &mut pool.lambda {
            *pole = leakage.narrowed(*pole);
        }
    }
    Ok(pool)
}

impl Pool {
    /// Zeros of σ as poles in rising order, flipped where Im λ ≤ 0 and apart from each other.
    ///
    /// * `narrowest`: least half-bandwidth
    fn of_zeros(mut zeros: Vec<Complex64>, narrowest: f64) -> Self {
        zeros.sort_by(|a, b| a.re.total_cmp(&b.re));
        let flipped = zeros.iter().map(|zero| zero.im <= 0.0).collect();
        let mut lambda: Vec<Complex64> = zeros
            .into_iter()
            .map(|zero| Complex64::new(zero.re, zero.im.abs().max(narrowest)))
            .collect();
        separate(&mut lambda);
        Self { lambda, flipped }
    }
}

/// The basis on which the products of a step are made.
#[derive(Clone, Copy)]
pub(crate) enum StepBasis {
    /// Differences of sums over one pole column: 8·N·m·(m + 6r) flop per step. An ill-conditioned
    /// basis costs digits.
    PartialFractions,
    /// On an orthonormal basis: 8·N·m²·(r + 2) flop per step, for poles that will not be
    /// refined.
    Orthonormal,
}

/// One step: the zeros of σ, and the residual sum of squares of σ times the data.
fn relocate(
    work: &Columns,
    lambda: &[Complex64],
    powers: &[i32],
    step_basis: StepBasis,
) -> Result<(Vec<Complex64>, f64), LinalgError> {
    let (n, lines) = (lambda.len(), work.lines());
    let ones = Columns {
        x: work.x.clone(),
        g: vec![1.0; lines],
        b: Array2::zeros((lines, 0)),
        law: work.law,
        leakage: None,
        neighbours: 0.0,
    };
    let psi = basis(&ones, lambda, &[0]);
    let sums: Array1<Complex64> = psi.columns().into_iter().map(|c| c.sum()).collect();
    // minimises with M = Σ_l (D_lΨ)ᴴ(I − QQᴴ)(D_lΨ)
    let minimum = |step_basis: StepBasis| {
        let StepProducts { mut gram, inside } = match step_basis {
            StepBasis::PartialFractions => by_partial_fractions(work, lambda, powers, &psi)?,
            StepBasis::Orthonormal => on_orthonormal_basis(work, lambda, powers, &psi)?,
        };
        let scale: Vec<f64> = gram
            .diag()
            .iter()
            .map(|v| 1.0 / v.re.max(f64::MIN_POSITIVE).sqrt())
            .collect();
        let explained: Vec<_> = inside
            .into_par_iter()
            .map(|inside| matmul_h(inside.view(), inside.view()))
            .collect();
        explained.iter().for_each(|part| gram -= part);
        minimise(&gram, &scale, &sums, lines as f64)
    };
    let (sigma, sse) = match step_basis {
        // exact data on an ill-conditioned basis: partial fractions lose all digits of M
        StepBasis::PartialFractions => {
            minimum(step_basis).or_else(|_| minimum(StepBasis::Orthonormal))?
        }
        StepBasis::Orthonormal => minimum(step_basis)?,
    };
    if sigma[n].norm() == 0.0 || !sigma[n].is_finite() {
        return Ok((lambda.to_vec(), sse));
    }
    Ok((zeros(lambda, &sigma[..n], sigma[n])?, sse))
}

/// The products of a step.
struct StepProducts {
    /// Σ_l (D_lΨ)ᴴ(D_lΨ).
    gram: Array2<Complex64>,
    /// QᴴD_lΨ for every column l.
    inside: Vec<Array2<Complex64>>,
}

fn on_orthonormal_basis(
    work: &Columns,
    lambda: &[Complex64],
    powers: &[i32],
    psi: &Array2<Complex64>,
) -> Result<StepProducts, LinalgError> {
    let (q, _) = tall_qr(basis(work, lambda, powers).view())?;
    let times = |columns: &Array2<Complex64>, factor: &(dyn Fn(usize) -> Complex64 + Sync)| {
        Array2::from_shape_fn(columns.raw_dim().f(), |(k, c)| columns[[k, c]] * factor(k))
    };
    let energy = line_energy(&work.b) * work.columns() as f64;
    let weighted = times(psi, &|k| energy[k].sqrt().into());
    let inside = (0..work.columns())
        .into_par_iter()
        .map(|l| matmul_h(times(&q, &|k| work.b[[k, l]].conj()).view(), psi.view()));
    Ok(StepProducts {
        gram: blocked_gram(weighted.view()),
        inside: inside.collect(),
    })
}

fn by_partial_fractions(
    work: &Columns,
    lambda: &[Complex64],
    powers: &[i32],
    psi: &Array2<Complex64>,
) -> Result<StepProducts, LinalgError> {
    let cauchy = psi.slice(s![.., ..lambda.len()]);
    let (lower, moments) = rayon::join(
        || well_conditioned_adjoint(work, lambda, powers),
        || Moments::new(work, cauchy, powers),
    );
    let lower = match lower {
        Some(lower) => lower,
        None => sound_adjoint(&tall_r(basis(work, lambda, powers).view())?),
    };
    let inside = (0..work.columns())
        .into_par_iter()
        .map(|l| solve_lower(lower.view(), moments.products(l, lambda).view()));
    let energy = line_energy(&work.b) * work.columns() as f64;
    Ok(StepProducts {
        gram: weighted_gram(lambda, cauchy, &energy),
        inside: inside.collect::<Result<_, _>>()?,
    })
}

/// Rᴴ of the basis Φ by Cholesky from partial fractions; `None` unless all its columns stand well
/// outside each other.
fn well_conditioned_adjoint(
    work: &Columns,
    lambda: &[Complex64],
    powers: &[i32],
) -> Option<Array2<Complex64>> {
    let m = lambda.len() + powers.len();
    let (gram, []) = Beside::new(work, powers, []).products(lambda, false);
    let norms: Vec<f64> = gram.diag().iter().take(m).map(|v| v.re.sqrt()).collect();
    let unit_gram =
        Array2::from_shape_fn((m, m).f(), |(i, j)| gram[[i, j]] / (norms[i] * norms[j]));
    let mut lower = cholesky(unit_gram.view()).ok()?;
    if lower.diag().iter().any(|pivot| pivot.re < tol::OUTSTANDING) {
        return None;
    }
    lower
        .rows_mut()
        .into_iter()
        .zip(norms)
        .for_each(|(mut row, norm)| row.mapv_inplace(|v| v * norm));
    Some(lower)
}

/// Rᴴ of a basis. Columns that depend on those before them are made to explain nothing: with a
/// rounding error as pivot they would explain anything.
fn sound_adjoint(r: &Array2<Complex64>) -> Array2<Complex64> {
    let mut lower = r.t().mapv(|v| v.conj());
    for i in 0..lower.nrows() {
        let norm = r.column(i).iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
        if lower[[i, i]].norm() <= limits::DEPENDENT * norm {
            lower[[i, i]] = Complex64::from(norm / f64::EPSILON.powi(2));
        }
    }
    lower
}

/// Σ_k w_k·conj(Ψ_kp)·Ψ_kq. The product of two columns is a difference of partial fractions,
/// 1/((a − x)(b − x)) = [1/(a − x) − 1/(b − x)]/(b − a): one sum per pole is computed instead of one
/// per pair of poles.
fn weighted_gram(
    lambda: &[Complex64],
    cauchy: ArrayView2<Complex64>,
    weights: &Array1<f64>,
) -> Array2<Complex64> {
    let n = lambda.len();
    let sum = |q: usize| {
        cauchy
            .column(q)
            .iter()
            .zip(weights)
            .map(|(c, w)| c * w)
            .sum::<Complex64>()
    };
    let sums: Vec<Complex64> = (0..n).map(sum).collect();
    Array2::from_shape_fn((n + 1, n + 1).f(), |(p, q)| match (p < n, q < n) {
        (true, true) => (sums[p].conj() - sums[q]) / (lambda[q] - lambda[p].conj()),
        (true, false) => sums[p].conj(),
        (false, true) => sums[q],
        (false, false) => Complex64::from(weights.sum()),
    })
}

/// Sums over lines that ΦᴴD_lΨ consists of, for every column l, d, of the data.
struct Moments {
    /// Σ g·d/(λ_q − x), (pole, column).
    poles: Array2<Complex64>,
    /// Σ g·d/(λ̄_q − x), (pole, column).
    conjugate_poles: Array2<Complex64>,
    /// Σ g·x^p·d/(λ_q − x), (pole, column), for each residual term p.
    poles_by_term: Vec<Array2<Complex64>>,
    /// Σ g·x^p·d, (residual term, column).
    terms: Array2<Complex64>,
}

impl Moments {
    fn new(work: &Columns, cauchy: ArrayView2<Complex64>, powers: &[i32]) -> Self {
        let times = |factor: &dyn Fn(usize) -> f64| {
            Array2::from_shape_fn(work.b.raw_dim().f(), |(k, l)| work.b[[k, l]] * factor(k))
        };
        let data = times(&|k| work.g[k]);
        let by_poles = |data: &Array2<Complex64>| matmul(cauchy.t(), data.view());
        let conjugate = |a: &Array2<Complex64>| a.mapv(|v| v.conj());
        let data_by_term: Vec<Array2<Complex64>> = powers
            .iter()
            .map(|&p| times(&|k| work.g[k] * work.x[k].powi(p)))
            .collect();
        Self {
            poles: by_poles(&data),
            conjugate_poles: conjugate(&by_poles(&conjugate(&data))),
            terms: Array2::from_shape_fn((powers.len(), work.columns()), |(p, l)| {
                data_by_term[p].column(l).sum()
            }),
            poles_by_term: data_by_term.par_iter().map(by_poles).collect(),
        }
    }

    /// ΦᴴD_lΨ of column l, (unknown of Φ, unknown of σ), by partial fractions.
    fn products(&self, l: usize, lambda: &[Complex64]) -> Array2<Complex64> {
        let n = lambda.len();
        Array2::from_shape_fn((n + self.poles_by_term.len(), n + 1).f(), |(p, q)| {
            match (p < n, q < n) {
                (true, true) => {
                    (self.conjugate_poles[[p, l]] - self.poles[[q, l]])
                        / (lambda[q] - lambda[p].conj())
                }
                (true, false) => self.conjugate_poles[[p, l]],
                (false, true) => self.poles_by_term[p - n][[q, l]],
                (false, false) => self.terms[[p - n, l]],
            }
        })
    }
}

/// The coefficients v of σ that minimise vᴴMv under Σ_k σ(x_k) = `total`, and the minimum. This
/// condition is the relaxation; it keeps σ from vanishing.
///
/// * `scale`: brings the diagonal of M to one
/// * `sums`: of the columns of Ψ
fn minimise(
    matrix: &Array2<Complex64>,
    scale: &[f64],
    sums: &Array1<Complex64>,
    total: f64,
) -> Result<(Vec<Complex64>, f64), LinalgError> {
    let size = matrix.nrows();
    let right = Array2::from_shape_fn((size, 1), |(i, _)| sums[i].conj() * scale[i]);
    let (mut ridge, largest_ridge, factor) = limits::POOL_RIDGE;
    loop {
        let scaled = Array2::from_shape_fn((size, size), |(i, j)| {
            let value = matrix[[i, j]] * scale[i] * scale[j];
            if i == j {
                value + ridge
            } else {
                value
            }
        });
        match solve_hermitian(scaled.view(), right.view()) {
            Ok(solution) => {
                let sum: Complex64 = (0..size)
                    .map(|i| sums[i] * scale[i] * solution[[i, 0]])
                    .sum();
                let sigma = (0..size)
                    .map(|i| solution[[i, 0]] * scale[i] * total / sum)
                    .collect();
                return Ok((sigma, total * total / sum.norm()));
            }
            Err(error) if ridge > largest_ridge => return Err(error),
            Err(_) => ridge *= factor,
        }
    }
}
