//! What physics allows: a certified upper bound on the contrast of a scene.
//!
//! For any λ ≥ 0 on hot rows with Σλ = 1 and μ ≥ 0 on cold rows and actuators, rows divided by their limits,
//!
//! Σ_h λ_h |h_h·A|² ≤ Σ_k μ_k |r_k·A|² for every A   ⟹   min_h |h_h·A|² ≤ Σ_k μ_k for every A that keeps the cold and the force limits
//!
//! (theory.md, eq. 49). The least Σμ is the dual of the scene's own problem after its phases are relaxed; on symmetric scenes
//! both meet within 0.2 dB. It is sought by Newton steps on a logarithmic barrier, whose Hessian is the squared modulus of a Gram matrix.
//! The search is not trusted: whatever λ and μ it ends at, the bound that is returned is λ_max(Q_hot, Q_cold)·Σμ of
//! these very multipliers, one eigenvalue of two matrices.

use crate::climb::Climb;
use crate::problem::{internal, Drive, Problem};
use crate::tolerances;
use chladni_frf::Result;
use chladni_linalg::{cholesky, eigh, matmul_h, solve_hermitian, solve_lower, solve_lower_adjoint};
use ndarray::{concatenate, s, Array1, Array2, ArrayView2, Axis};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// The contrast that a scene asks for, that its panel can give at most, and that the drive reached.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Ceiling {
    /// No drive within the force limits gives more, dB: least hot amplitude over the limit of cold ground, while every cold response
    /// keeps that limit.
    pub possible_db: f64,
    /// Limit of hot ground over limit of cold ground, dB.
    pub asked_db: f64,
    /// The same for the drive of most contrast that was found, dB; what is possible lies between the two.
    pub reached_db: f64,
}

impl Ceiling {
    /// The ceiling of `problem`, and the most contrasting drive that `start` leads to; `None` without force limits.
    ///
    /// # Errors
    /// Those of the kernels: a broken promise.
    pub(crate) fn of(problem: &Problem, start: &Drive) -> Result<Option<Self>> {
        let Some(bound) = certified_bound(problem)? else { return Ok(None) };
        let db = |ratio: f64| 20.0 * ratio.log10();
        let asked_db = db(problem.limits.hot_m_per_s / problem.limits.cold_m_per_s);
        let mut climb = Climb::new(problem)?;
        let mut reached = 0.0;
        for start in [bound.drive, start.clone()] {
            reached = f64::max(reached, climb.raise_hot(start)?);
            if db(reached) > db(bound.factor) - tolerances::CEILING_REACHED_DB {
                break;
            }
        }
        Ok(Some(Self { possible_db: asked_db + db(bound.factor), asked_db, reached_db: asked_db + db(reached) }))
    }

    /// True where the scene is proven to be impossible.
    pub fn forbids(&self) -> bool {
        self.possible_db < self.asked_db
    }
}

/// What the multipliers prove.
pub(crate) struct Bound {
    /// No drive moves every hot row by more than this factor over its limit while it keeps the cold and the force limits.
    pub(crate) factor: f64,
    /// The drive that the bound leans on, of arbitrary gain: the best one where the relaxation of the phases loses nothing.
    pub(crate) drive: Drive,
}

/// The certified bound of a problem; `None` without force limits, where nothing bounds what noise-like drives could do.
///
/// # Errors
/// Those of the kernels: a broken promise.
pub(crate) fn certified_bound(problem: &Problem) -> Result<Option<Bound>> {
    if !problem.drive_limits.each.is_finite() {
        return Ok(None);
    }
    let (hot, bounded) = scaled_rows(problem);
    let mut dual = Dual::start(hot, bounded)?;
    let (mut best, mut drive) = dual.certificate()?;
    let count = (dual.multipliers.len() + dual.rows.ncols()) as f64;
    let mut weight = count / best;
    while count / weight > tolerances::CEILING_GAP * best {
        weight *= tolerances::BARRIER_RISE;
        dual.centre(weight)?;
        let (bound, direction) = dual.certificate()?;
        if bound < best {
            (best, drive) = (bound, direction);
        }
    }
    Ok(Some(Bound { factor: best.sqrt(), drive }))
}

/// Hot rows over their limits, and cold rows and unit rows of the actuators over theirs, all in drives of the force limit.
fn scaled_rows(problem: &Problem) -> (Array2<Complex64>, Array2<Complex64>) {
    let each = problem.drive_limits.each;
    let scaled = |rows: ArrayView2<Complex64>, limit: f64| rows.mapv(|value| value * (each / limit));
    let hot = scaled(problem.rows.hot_rows(), problem.limits.hot_m_per_s);
    let cold = scaled(problem.rows.cold_rows(), problem.limits.cold_m_per_s);
    let actuators = Array2::from_diag_elem(hot.ncols(), Complex64::ONE);
    (hot, concatenate![Axis(0), cold, actuators])
}

/// Multipliers with S = Σ_k μ_k r_kᴴr_k − Σ_h λ_h h_hᴴh_h positive definite.
struct Dual {
    /// Bounded rows, then hot ones.
    rows: Array2<Complex64>,
    /// How many of them are bounded.
    bounded: usize,
    /// μ, then λ.
    multipliers: Array1<f64>,
}

impl Dual {
    /// Equal multipliers, μ large enough.
    fn start(hot: Array2<Complex64>, bounded: Array2<Complex64>) -> Result<Self> {
        let share = 1.0 / hot.nrows() as f64;
        let (ratio, _) = largest_ratio(&gram(hot.view(), |_| share), &gram(bounded.view(), |_| 1.0))?;
        let mut multipliers = Array1::from_elem(bounded.nrows() + hot.nrows(), share);
        multipliers.slice_mut(s![..bounded.nrows()]).fill(2.0 * ratio);
        Ok(Self { bounded: bounded.nrows(), rows: concatenate![Axis(0), bounded, hot], multipliers })
    }

    /// The bound that these multipliers prove, squared, and the drive at which it is tight.
    fn certificate(&self) -> Result<(f64, Drive)> {
        let (bounded, hot) = self.rows.view().split_at(Axis(0), self.bounded);
        let (mu, lambda) = self.multipliers.view().split_at(Axis(0), self.bounded);
        let (ratio, drive) = largest_ratio(&gram(hot, |h| lambda[h]), &gram(bounded, |k| mu[k]))?;
        Ok((ratio * mu.sum() / lambda.sum(), drive))
    }

    /// Newton's method on weight·Σμ − ln det S − Σ ln μ − Σ ln λ with Σλ = 1.
    fn centre(&mut self, weight: f64) -> Result<()> {
        for _ in 0..tolerances::BARRIER_STEPS {
            let Some(inner) = self.inner_products() else { return Ok(()) };
            let sign = |k: usize| if k < self.bounded { 1.0 } else { -1.0 };
            let size = self.multipliers.len();
            let x = &self.multipliers;
            let hessian = Array2::from_shape_fn((size, size), |(i, j)| {
                let barrier = if i == j { x[i].powi(-2) } else { 0.0 };
                sign(i) * sign(j) * inner[[i, j]].norm_sqr() + barrier
            });
            let mut right = Array2::zeros((size, 2));
            for k in 0..size {
                let price = if k < self.bounded { weight } else { 0.0 };
                right[[k, 0]] = -(price - sign(k) * inner[[k, k]].re - 1.0 / x[k]);
                right[[k, 1]] = if k < self.bounded { 0.0 } else { 1.0 };
            }
            // rounding at the very end of the path is no fault: the certificate judges what was reached
            let Ok(solved) = solve_hermitian(hessian.view(), right.view()) else { return Ok(()) };
            let sums = [0, 1].map(|column| solved.slice(s![self.bounded.., column]).sum());
            let step = &solved.column(0) - &(&solved.column(1) * (sums[0] / sums[1]));
            let decrement = step.dot(&right.column(0));
            if decrement.is_nan() || decrement <= tolerances::BARRIER_DECREMENT || !self.advance(&step, decrement) {
                return Ok(());
            }
        }
        Ok(())
    }

    /// r_i S⁻¹ r_jᴴ for all rows; `None` where S is not positive definite.
    fn inner_products(&self) -> Option<Array2<Complex64>> {
        let lower = self.factor(&self.multipliers)?;
        let whitened = solve_lower(lower.view(), self.rows.t().mapv(|value| value.conj()).view()).ok()?;
        Some(matmul_h(whitened.view(), whitened.view()))
    }

    fn factor(&self, multipliers: &Array1<f64>) -> Option<Array2<Complex64>> {
        let sign = |k: usize| if k < self.bounded { 1.0 } else { -1.0 };
        cholesky(gram(self.rows.view(), |k| sign(k) * multipliers[k]).view()).ok()
    }

    /// Moves as far along `step` as stays inside; false where it does not move.
    fn advance(&mut self, step: &Array1<f64>, decrement: f64) -> bool {
        // the damped step of a self-concordant barrier stays inside without asking
        let damped = 1.0 / (1.0 + decrement.sqrt());
        for length in [1.0, 0.5, damped, 0.5 * damped] {
            let next = &self.multipliers + &(step * length);
            if next.iter().all(|&value| value > 0.0) && self.factor(&next).is_some() {
                self.multipliers = next;
                return true;
            }
        }
        false
    }
}

/// Σ_k weight_k·r_kᴴr_k.
fn gram(rows: ArrayView2<Complex64>, weight: impl Fn(usize) -> f64) -> Array2<Complex64> {
    let mut weighted = rows.to_owned();
    for (k, mut row) in weighted.rows_mut().into_iter().enumerate() {
        row.mapv_inplace(|value| value * weight(k));
    }
    matmul_h(rows, weighted.view())
}

/// The largest xᴴax/xᴴbx, b positive definite, and its x.
fn largest_ratio(a: &Array2<Complex64>, b: &Array2<Complex64>) -> Result<(f64, Drive)> {
    let lower = cholesky(b.view()).map_err(internal)?;
    let half = solve_lower(lower.view(), a.view()).map_err(internal)?;
    let whitened = solve_lower(lower.view(), half.t().mapv(|value| value.conj()).view()).map_err(internal)?;
    let (values, vectors) = eigh(whitened.view()).map_err(internal)?;
    let last = vectors.slice(s![.., vectors.ncols() - 1..]);
    let drive = solve_lower_adjoint(lower.view(), last).map_err(internal)?;
    Ok((values[values.len() - 1], drive.column(0).to_owned()))
}
