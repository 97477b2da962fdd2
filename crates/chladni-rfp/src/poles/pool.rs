//! Pole pool by relaxed vector fitting in the plane x = ω²/ω_max² (theory.md, eq. 7).
//!
//! σ(x) = d + Σ c_q/(λ_q − x) multiplies the data; numerators are eliminated column by
//! column, and the zeros of σ are the next poles. Gustavsen & Semlyen, IEEE Trans. Power
//! Delivery 14 (1999) 1052; relaxed form: Gustavsen, ibid. 21 (2006) 1587. The only
//! starter after which the maximum-likelihood step lost no mode in our study; as an
//! estimator on its own it is one to five times above the bound.

use crate::damping::gram::Cauchy;
use crate::damping::law::{is_rational, RATIONAL};
use crate::damping::structural::basis;
use crate::data::columns::{line_energy, Columns};
use crate::poles::limits;
use crate::poles::zeros::zeros;
use crate::tolerances as tol;
use chladni_linalg::blocked::{blocked_matmul_h, tall_qr, tall_r};
use chladni_linalg::{cholesky, matmul, matmul_h, solve_hermitian, solve_lower, LinalgError};
use ndarray::{s, Array1, Array2, ArrayView2, ShapeBuilder};
use num_complex::Complex64;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

/// Poles as the last step left them; those with Im λ ≤ 0 are flipped in `lambda` and
/// marked in `flipped`.
#[derive(Debug, Clone)]
pub(crate) struct Pool {
    /// Poles with Im λ > 0.
    pub lambda: Vec<Complex64>,
    /// True where the pole left with a negative loss factor.
    pub flipped: Vec<bool>,
}

/// Random mixtures of the columns (fixed seed): what vector fitting works on instead of
/// all of them.
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

/// Relaxed vector fitting from `start`, at most `iterations` steps. With partial fractions it
/// ends before, once a step hardly changes the sum of squares: these poles will be refined.
pub(crate) fn vector_fit(
    work: &Columns,
    start: &[Complex64],
    powers: &[i32],
    iterations: usize,
    how: Products,
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
    let mut before = f64::INFINITY;
    for _ in 0..iterations {
        let (next, left) = relocate(work, &pool.lambda, powers, how)?;
        pool.flipped = next.iter().map(|p| p.im <= 0.0).collect();
        pool.lambda = next
            .into_iter()
            .map(|p| {
                let floor = limits::RELOCATED_WIDTH_LEAST * work.range().1;
                Complex64::new(p.re, p.im.abs().max(floor))
            })
            .collect();
        let mut order: Vec<usize> = (0..pool.lambda.len()).collect();
        order.sort_by(|&a, &b| pool.lambda[a].re.total_cmp(&pool.lambda[b].re));
        pool = Pool {
            lambda: order.iter().map(|&i| pool.lambda[i]).collect(),
            flipped: order.iter().map(|&i| pool.flipped[i]).collect(),
        };
        separate(&mut pool.lambda);
        if matches!(how, Products::PartialFractions)
            && (before - left).abs() < limits::POOL_SETTLED * left
        {
            break;
        }
        before = left;
    }
    if let Some(leakage) = leakage {
        for pole in &mut pool.lambda {
            *pole = leakage.narrowed(*pole);
        }
    }
    Ok(pool)
}

/// Ways of making the products of a step.
#[derive(Clone, Copy)]
pub(crate) enum Products {
    /// Differences of sums over one pole column: 8·N·m·(m + 6r) flop per step, and as
    /// many digits less as the basis is ill-conditioned.
    PartialFractions,
    /// On an orthonormal basis: 8·N·m²·(r + 2) flop per step, for poles that nothing
    /// refines.
    Orthonormal,
}

/// One step: zeros of σ, and the sum of squares that σ times the data leaves.
fn relocate(
    work: &Columns,
    lambda: &[Complex64],
    powers: &[i32],
    how: Products,
) -> Result<(Vec<Complex64>, f64), LinalgError> {
    let (n, lines) = (lambda.len(), work.lines());
    let ones = Columns {
        x: work.x.clone(),
        g: vec![1.0; lines],
        b: Array2::zeros((lines, 0)),
        law: work.law,
        leakage: None,
    };
    let psi = basis(&ones, lambda, &[0]);
    let sums: Array1<Complex64> = psi.columns().into_iter().map(|c| c.sum()).collect();
    // M = Σ_l (D_lΨ)ᴴ(I − QQᴴ)(D_lΨ)
    let solved = |how: Products| {
        let (mut gram, inside) = match how {
            Products::PartialFractions => by_partial_fractions(work, lambda, powers, &psi)?,
            Products::Orthonormal => on_orthonormal_basis(work, lambda, powers, &psi)?,
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
    let (sigma, left) = match how {
        // exact data on an ill-conditioned basis: the digits that partial fractions lose
        // are all that is left of M
        Products::PartialFractions => solved(how).or_else(|_| solved(Products::Orthonormal))?,
        Products::Orthonormal => solved(how)?,
    };
    if sigma[n].norm() == 0.0 || !sigma[n].is_finite() {
        return Ok((lambda.to_vec(), left));
    }
    Ok((zeros(lambda, &sigma[..n], sigma[n])?, left))
}

/// Σ_l (D_lΨ)ᴴ(D_lΨ), and QᴴD_lΨ for every column l.
type Step = (Array2<Complex64>, Vec<Array2<Complex64>>);

fn on_orthonormal_basis(
    work: &Columns,
    lambda: &[Complex64],
    powers: &[i32],
    psi: &Array2<Complex64>,
) -> Result<Step, LinalgError> {
    let (q, _) = tall_qr(basis(work, lambda, powers).view())?;
    let times = |columns: &Array2<Complex64>, factor: &(dyn Fn(usize) -> Complex64 + Sync)| {
        Array2::from_shape_fn(columns.raw_dim().f(), |(k, c)| columns[[k, c]] * factor(k))
    };
    let energy = line_energy(&work.b) * work.columns() as f64;
    let weighted = times(psi, &|k| energy[k].sqrt().into());
    let inside = (0..work.columns())
        .into_par_iter()
        .map(|l| matmul_h(times(&q, &|k| work.b[[k, l]].conj()).view(), psi.view()));
    Ok((
        blocked_matmul_h(weighted.view(), weighted.view()),
        inside.collect(),
    ))
}

fn by_partial_fractions(
    work: &Columns,
    lambda: &[Complex64],
    powers: &[i32],
    psi: &Array2<Complex64>,
) -> Result<Step, LinalgError> {
    let cauchy = psi.slice(s![.., ..lambda.len()]);
    let (lower, moments) = rayon::join(
        || well_conditioned(work, lambda, powers),
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
    Ok((
        weighted_gram(lambda, cauchy, &energy),
        inside.collect::<Result<_, _>>()?,
    ))
}

/// Rᴴ of a basis by Cholesky from partial fractions, where all its columns stand well
/// outside each other.
fn well_conditioned(
    work: &Columns,
    lambda: &[Complex64],
    powers: &[i32],
) -> Option<Array2<Complex64>> {
    let m = lambda.len() + powers.len();
    let gram = Cauchy::without_derivatives(work, lambda, powers).gram();
    let norms: Vec<f64> = gram.diag().iter().take(m).map(|v| v.re.sqrt()).collect();
    let mut lower = cholesky(
        Array2::from_shape_fn((m, m).f(), |(i, j)| gram[[i, j]] / (norms[i] * norms[j])).view(),
    )
    .ok()?;
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

/// Rᴴ of a basis. Columns that add nothing to those before them are made to explain nothing:
/// with rounding for a pivot they would explain anything.
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

/// Σ_k w_k·conj(Ψ_kp)·Ψ_kq with Ψ = (1/(λ_q − x), 1). Products of two such columns fall
/// apart into partial fractions, 1/((a − x)(b − x)) = [1/(a − x) − 1/(b − x)]/(b − a):
/// one sum per pole instead of one per pair of poles.
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

/// The evidence of the data on ΦᴴD_lΨ, by sums over lines for every column l of the data.
struct Moments {
    /// Σ g·d/(λ_q − x) and Σ g·d/(λ̄_q − x), (pole, column).
    above: Array2<Complex64>,
    below: Array2<Complex64>,
    /// Σ g·x^p·d/(λ_q − x), (pole, column), for each residual term; and Σ g·x^p·d,
    /// (residual term, column).
    terms: Vec<Array2<Complex64>>,
    plain: Array2<Complex64>,
}

impl Moments {
    fn new(work: &Columns, cauchy: ArrayView2<Complex64>, powers: &[i32]) -> Self {
        let times = |factor: &dyn Fn(usize) -> f64| {
            Array2::from_shape_fn(work.b.raw_dim().f(), |(k, l)| work.b[[k, l]] * factor(k))
        };
        let data = times(&|k| work.g[k]);
        let against = |data: &Array2<Complex64>| matmul(cauchy.t(), data.view());
        let conjugate = |a: &Array2<Complex64>| a.mapv(|v| v.conj());
        let of_terms: Vec<Array2<Complex64>> = powers
            .iter()
            .map(|&p| times(&|k| work.g[k] * work.x[k].powi(p)))
            .collect();
        Self {
            above: against(&data),
            below: conjugate(&against(&conjugate(&data))),
            plain: Array2::from_shape_fn((powers.len(), work.columns()), |(p, l)| {
                of_terms[p].column(l).sum()
            }),
            terms: of_terms.par_iter().map(against).collect(),
        }
    }

    /// ΦᴴD_lΨ of column l, (unknown of Φ, unknown of σ), by partial fractions.
    fn products(&self, l: usize, lambda: &[Complex64]) -> Array2<Complex64> {
        let n = lambda.len();
        Array2::from_shape_fn((n + self.terms.len(), n + 1).f(), |(p, q)| {
            match (p < n, q < n) {
                (true, true) => {
                    (self.below[[p, l]] - self.above[[q, l]]) / (lambda[q] - lambda[p].conj())
                }
                (true, false) => self.below[[p, l]],
                (false, true) => self.terms[p - n][[q, l]],
                (false, false) => self.plain[[p - n, l]],
            }
        })
    }
}

/// Minimises vᴴMv under Σ_k σ(x_k) = `total` (the relaxation that keeps σ from
/// vanishing): v, and the minimum.
fn minimise(
    gram: &Array2<Complex64>,
    scale: &[f64],
    sums: &Array1<Complex64>,
    total: f64,
) -> Result<(Vec<Complex64>, f64), LinalgError> {
    let size = gram.nrows();
    let right = Array2::from_shape_fn((size, 1), |(i, _)| sums[i].conj() * scale[i]);
    let (mut ridge, most, up) = limits::POOL_RIDGE;
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
                let along: Complex64 = (0..size)
                    .map(|i| sums[i] * scale[i] * solution[[i, 0]])
                    .sum();
                let sigma = (0..size)
                    .map(|i| solution[[i, 0]] * scale[i] * total / along)
                    .collect();
                return Ok((sigma, total * total / along.norm()));
            }
            Err(error) if ridge > most => return Err(error),
            Err(_) => ridge *= up,
        }
    }
}
