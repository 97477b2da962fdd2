//! The viscous twin of [`crate::refine`]: poles s and s* with residues r and r*, real
//! arithmetic (theory.md, eq. 16–17).
//!
//! α = Σ [r/(jω − s) + r*/(jω − s*)] is linear in Re r and Im r only over the reals, so
//! lines are stacked (real parts, then imaginary parts) and each mode has two real
//! columns. Everything else is the same variable projection. Frequencies are in units of
//! ω_max: y = ω/ω_max = √x.

use crate::data::columns::{inverse, Columns};
use crate::tolerances as tol;
use chladni_linalg::blocked::{blocked_matmul_h, projected, tall_qr};
use chladni_linalg::{matmul, solve_hermitian, solve_upper, LinalgError};
use ndarray::{s, Array2, ShapeBuilder};
use num_complex::Complex64;

/// No more than this times what a step promises is expected of it and all that follow.
const PROMISE_KEPT: f64 = 2.0;

/// Poles with what their neighbourhood looks like.
#[derive(Debug, Clone)]
pub(crate) struct ViscousFit {
    /// Poles s/ω_max, upper half plane, Re s < 0.
    pub poles: Vec<Complex64>,
    /// Sum of squares of the residual.
    pub sse: f64,
}

impl ViscousFit {
    /// Gauss–Newton matrix of (Re s, Im s) per mode, (2n, 2n), on the data of the fit.
    pub fn information(&self, work: &Columns, powers: &[i32]) -> Result<Array2<f64>, LinalgError> {
        let linear = linear(work, &stacked_data(work), &self.poles, powers)?;
        let coefficients = solve_upper(linear.r.view(), linear.qb.view())?;
        Ok(newton_system(work, &self.poles, &linear, &coefficients).0)
    }
}

/// s = j√λ: the viscous pole of the same resonance. Using √Re λ instead is wrong by ζ².
pub(crate) fn from_structural(lambda: Complex64) -> Complex64 {
    Complex64::i() * lambda.sqrt()
}

fn stack_into(out: &mut Array2<f64>, column: usize, values: impl Iterator<Item = Complex64>) {
    let lines = out.nrows() / 2;
    let mut column = out.column_mut(column);
    let (re, im) = column
        .as_slice_mut()
        .expect("column-major")
        .split_at_mut(lines);
    for ((re, im), v) in re.iter_mut().zip(im).zip(values) {
        (*re, *im) = (v.re, v.im);
    }
}

/// Stacked basis: per mode g·(u + v) and jg·(u − v) with u = 1/(jy − s), v = 1/(jy − s*);
/// then residual terms.
pub(crate) fn viscous_basis(work: &Columns, poles: &[Complex64], powers: &[i32]) -> Array2<f64> {
    let mut a = Array2::zeros((2 * work.lines(), 2 * (poles.len() + powers.len())).f());
    let j = Complex64::i();
    for (n, &pole) in poles.iter().enumerate() {
        let uv = || {
            work.x.iter().zip(&work.g).map(move |(&x, &g)| {
                let jy = Complex64::new(0.0, x.sqrt());
                (inverse(jy - pole) * g, inverse(jy - pole.conj()) * g)
            })
        };
        stack_into(&mut a, 2 * n, uv().map(|(u, v)| u + v));
        stack_into(&mut a, 2 * n + 1, uv().map(|(u, v)| j * (u - v)));
    }
    for (p, &power) in powers.iter().enumerate() {
        let column = 2 * (poles.len() + p);
        let term = || {
            work.x
                .iter()
                .zip(&work.g)
                .map(move |(&x, &g)| Complex64::new(g * x.powi(power), 0.0))
        };
        stack_into(&mut a, column, term());
        stack_into(&mut a, column + 1, term().map(|v| j * v));
    }
    a
}

/// Derivative columns: g·(u² + v²) and jg·(u² − v²) per mode.
fn derivative(work: &Columns, poles: &[Complex64]) -> Array2<f64> {
    let mut d = Array2::zeros((2 * work.lines(), 2 * poles.len()).f());
    let j = Complex64::i();
    for (n, &pole) in poles.iter().enumerate() {
        let uv = || {
            work.x.iter().zip(&work.g).map(move |(&x, &g)| {
                let jy = Complex64::new(0.0, x.sqrt());
                let (u, v) = (inverse(jy - pole), inverse(jy - pole.conj()));
                (g * u * u, g * v * v)
            })
        };
        stack_into(&mut d, 2 * n, uv().map(|(u, v)| u + v));
        stack_into(&mut d, 2 * n + 1, uv().map(|(u, v)| j * (u - v)));
    }
    d
}

struct Linear {
    q: Array2<f64>,
    r: Array2<f64>,
    qb: Array2<f64>,
    residual: Array2<f64>,
    sse: f64,
}

fn stacked_data(work: &Columns) -> Array2<f64> {
    let lines = work.lines();
    let mut b = Array2::zeros((2 * lines, work.columns()).f());
    b.slice_mut(s![..lines, ..]).assign(&work.b.mapv(|v| v.re));
    b.slice_mut(s![lines.., ..]).assign(&work.b.mapv(|v| v.im));
    b
}

fn linear(
    work: &Columns,
    data: &Array2<f64>,
    poles: &[Complex64],
    powers: &[i32],
) -> Result<Linear, LinalgError> {
    let (q, r) = tall_qr(viscous_basis(work, poles, powers).view())?;
    let (qb, residual) = projected(q.view(), data.view());
    let sse = residual.iter().map(|v| v * v).sum();
    Ok(Linear {
        q,
        r,
        qb,
        residual,
        sse,
    })
}

/// ∂/∂Re s = (Re r)·d₁ + (Im r)·d₂ and ∂/∂Im s = (Re r)·d₂ − (Im r)·d₁ in the derivative
/// columns d₁, d₂.
fn newton_system(
    work: &Columns,
    poles: &[Complex64],
    linear: &Linear,
    coefficients: &Array2<f64>,
) -> (Array2<f64>, Array2<f64>) {
    let n = poles.len();
    let d = derivative(work, poles);
    let (_, outside) = projected(linear.q.view(), d.view());
    let gram = blocked_matmul_h(outside.view(), outside.view());
    let residues = coefficients.slice(s![..2 * n, ..]);
    let products = matmul(residues, residues.t());
    let along = blocked_matmul_h(d.view(), linear.residual.view());
    // parameter (mode, part) as (row of d, row of residues, sign) pairs
    let terms = |mode: usize, part: usize| {
        if part == 0 {
            [(2 * mode, 2 * mode, 1.0), (2 * mode + 1, 2 * mode + 1, 1.0)]
        } else {
            [
                (2 * mode + 1, 2 * mode, 1.0),
                (2 * mode, 2 * mode + 1, -1.0),
            ]
        }
    };
    let information = Array2::from_shape_fn((2 * n, 2 * n), |(p, q)| {
        let mut sum = 0.0;
        for (da, ra, sa) in terms(p / 2, p % 2) {
            for (db, rb, sb) in terms(q / 2, q % 2) {
                sum += sa * sb * gram[[da, db]] * products[[ra, rb]];
            }
        }
        sum
    });
    let gradient = Array2::from_shape_fn((2 * n, 1), |(p, _)| {
        terms(p / 2, p % 2)
            .iter()
            .map(|&(d, r, sign)| sign * along.row(d).dot(&residues.row(r)))
            .sum()
    });
    (information, gradient)
}

/// Refines viscous poles from `start` to `tolerance` of a half-bandwidth, or until
/// `enough(sum of squares, what the last step took off it, steps left)`.
pub(crate) fn refine_viscous(
    work: &Columns,
    start: &[Complex64],
    powers: &[i32],
    iterations: usize,
    tolerance: f64,
    enough: impl Fn(f64, f64, usize) -> bool,
) -> Result<ViscousFit, LinalgError> {
    let data = stacked_data(work);
    let mut poles = start.to_vec();
    let mut current = linear(work, &data, &poles, powers)?;
    let mut coefficients = solve_upper(current.r.view(), current.qb.view())?;
    let mut damping = tol::LM_START;
    let mut system = None;
    let (low, high) = work.range();
    for step in 1..=iterations {
        if poles.is_empty() {
            break;
        }
        let (information, gradient) = system
            .take()
            .unwrap_or_else(|| newton_system(work, &poles, &current, &coefficients));
        let mut damped = information.clone();
        damped
            .diag_mut()
            .mapv_inplace(|v| v * (1.0 + damping) + f64::MIN_POSITIVE);
        let solution = solve_hermitian(damped.view(), gradient.view()).ok();
        let promised = solution.as_ref().map(|step| {
            step.iter()
                .zip(&gradient)
                .map(|(step, along)| step * along)
                .sum::<f64>()
        });
        if promised.is_some_and(|promised| enough(current.sse, PROMISE_KEPT * promised, 1)) {
            break;
        }
        let mut largest = 0.0_f64;
        let trial: Option<Vec<Complex64>> = solution.map(|solution| {
            poles
                .iter()
                .enumerate()
                .map(|(n, &pole)| {
                    let outside = (low.sqrt() - pole.im).max(pole.im - high.sqrt()).max(0.0);
                    let cap = 0.5 * pole.re.abs() + 0.3 * outside;
                    let delta = Complex64::new(solution[[2 * n, 0]], solution[[2 * n + 1, 0]]);
                    let delta = if delta.norm() > cap {
                        delta * (cap / delta.norm())
                    } else {
                        delta
                    };
                    largest = largest.max(delta.norm() / pole.re.abs());
                    let moved =
                        Complex64::new((pole + delta).re.min(0.2 * pole.re), (pole + delta).im);
                    // what stands for the world outside stays there: inside it would pose
                    // as a mode
                    let inside = |s: Complex64| (low.sqrt()..=high.sqrt()).contains(&s.norm());
                    if inside(moved) && !inside(start[n]) {
                        pole
                    } else {
                        moved
                    }
                })
                .collect()
        });
        let candidate = trial
            .as_ref()
            .and_then(|trial| linear(work, &data, trial, powers).ok());
        match (trial, candidate) {
            (Some(trial), Some(candidate)) if candidate.sse <= current.sse => {
                let drop = current.sse - candidate.sse;
                poles = trial;
                current = candidate;
                coefficients = solve_upper(current.r.view(), current.qb.view())?;
                damping *= 0.1;
                if largest < tolerance || enough(current.sse, drop, iterations - step) {
                    break;
                }
            }
            (Some(_), _) if largest < tolerance => break,
            _ => {
                damping = (damping * 10.0).max(1e-6);
                system = Some((information, gradient));
                if damping > tol::LM_GIVE_UP {
                    break;
                }
            }
        }
    }
    Ok(ViscousFit {
        poles,
        sse: current.sse,
    })
}
