//! Multipliers that prove how far no drive can move every hot row.
//!
//! Σ_h λ_h |h_h·A|² + Σ_p ν_p Re(e^{−jφ_p}(h_i·A)*(h_j·A)) ≤ Σ_k μ_k |r_k·A|² for every A
//! bounds the least |h·A|² by Σμ where Σλ + Σν·cos δ = 1: the pairs p hold for drives
//! that move two hot rows with a phase difference within δ_p of φ_p (theory.md, eq. 49).
//! The least Σμ is sought by Newton steps on a logarithmic barrier, whose Hessian follows
//! from one Gram matrix. The search is not trusted: whatever the multipliers are that it
//! ends at, the certificate is one eigenvalue of two matrices.

use crate::panel::drive::Drive;
use crate::panel::kernel_error::unsolvable;
use crate::tolerances;
use chladni_frf::Result;
use chladni_linalg::{cholesky, eigh, matmul_h, solve_hermitian, solve_lower, solve_lower_adjoint};
use ndarray::{concatenate, s, Array1, Array2, ArrayView2, Axis};
use num_complex::Complex64;

/// Phase differences of the second of two hot rows over the first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sector {
    /// Hot rows.
    pub(crate) rows: [usize; 2],
    /// Middle, rad.
    pub(crate) middle: f64,
    /// To either side, rad, at most a quarter turn.
    pub(crate) half_width: f64,
}

/// Multipliers with S = Σ_k μ_k r_kᴴr_k − Σ_h λ_h h_hᴴh_h − Σ_p ν_p (e^{−jφ_p} h_iᴴh_j +
/// e^{jφ_p} h_jᴴh_i)/2 positive definite.
pub(crate) struct Dual {
    /// Bounded rows, then hot ones.
    rows: Array2<Complex64>,
    /// Number of them that are bounded.
    bounded: usize,
    sectors: Vec<Sector>,
    /// μ, then λ, then ν.
    multipliers: Array1<f64>,
}

impl Dual {
    /// Equal multipliers, μ large enough.
    pub(crate) fn start(
        hot: ArrayView2<Complex64>,
        bounded: ArrayView2<Complex64>,
        sectors: Vec<Sector>,
    ) -> Result<Self> {
        let count = bounded.nrows() + hot.nrows() + sectors.len();
        let rows = concatenate![Axis(0), bounded, hot];
        let mut dual = Self {
            bounded: bounded.nrows(),
            rows,
            sectors,
            multipliers: Array1::ones(count),
        };
        let prices: f64 = (0..count).map(|k| dual.price(k)).sum();
        dual.multipliers.fill(1.0 / prices);
        let (ratio, _) = largest_ratio(&dual.asked(&dual.multipliers), &gram(bounded, |_| 1.0))?;
        // where the sectors leave no drive, the ratio is negative and any μ will do
        dual.multipliers
            .slice_mut(s![..bounded.nrows()])
            .fill(f64::max(2.0 * ratio.abs(), f64::MIN_POSITIVE));
        Ok(dual)
    }

    /// Searches until the gap is small, the bound below `target`, or the end of what arithmetic
    /// resolves; returns the bound, squared, and the drive at which it is tight.
    pub(crate) fn solve(&mut self, target: f64) -> Result<(f64, Drive)> {
        let (mut best, mut drive) = self.certificate()?;
        let count = (self.multipliers.len() + self.rows.ncols()) as f64;
        let mut weight = count / best;
        while best > target && count / weight > tolerances::CEILING_GAP * best {
            weight *= tolerances::BARRIER_RISE;
            self.centre(weight);
            // what was proven holds where rounding ends the search
            let Ok((bound, direction)) = self.certificate() else {
                break;
            };
            if bound < best {
                (best, drive) = (bound, direction);
            }
        }
        Ok((best, drive))
    }

    /// μ of the bounded rows.
    pub(crate) fn of_bounded(&self) -> Vec<f64> {
        self.multipliers.slice(s![..self.bounded]).to_vec()
    }

    /// λ of the hot rows.
    pub(crate) fn of_hot(&self) -> Vec<f64> {
        self.multipliers
            .slice(s![self.bounded..self.rows.nrows()])
            .to_vec()
    }

    /// h_i·X·h_jᴴ of the hot rows, where X ∝ S⁻¹ stands for A·Aᴴ of the relaxed scene;
    /// `None` where S is not positive definite.
    pub(crate) fn hot_products(&self) -> Option<Array2<Complex64>> {
        Some(
            self.inner_products()?
                .slice(s![self.bounded.., self.bounded..])
                .to_owned(),
        )
    }

    /// Coefficient of a multiplier in the sum that must be 1.
    fn price(&self, k: usize) -> f64 {
        match (
            k.checked_sub(self.bounded),
            k.checked_sub(self.rows.nrows()),
        ) {
            (None, _) => 0.0,
            (_, None) => 1.0,
            (_, Some(pair)) => self.sectors[pair].half_width.cos(),
        }
    }

    fn sign(&self, k: usize) -> f64 {
        if k < self.bounded {
            1.0
        } else {
            -1.0
        }
    }

    /// The left side of the bound: hot rows and pairs of them.
    fn asked(&self, multipliers: &Array1<f64>) -> Array2<Complex64> {
        let hot = self.rows.slice(s![self.bounded.., ..]);
        let of_hot = multipliers.slice(s![self.bounded..self.rows.nrows()]);
        let mut weights = Array2::from_diag(&of_hot.mapv(Complex64::from));
        for (sector, &value) in self
            .sectors
            .iter()
            .zip(multipliers.slice(s![self.rows.nrows()..]))
        {
            let [i, j] = sector.rows;
            weights[[i, j]] += Complex64::from_polar(0.5 * value, -sector.middle);
            weights[[j, i]] += Complex64::from_polar(0.5 * value, sector.middle);
        }
        matmul_h(hot, weights.dot(&hot).view())
    }

    fn certificate(&self) -> Result<(f64, Drive)> {
        let bounded = gram(self.rows.slice(s![..self.bounded, ..]), |k| {
            self.multipliers[k]
        });
        let (ratio, drive) = largest_ratio(&self.asked(&self.multipliers), &bounded)?;
        let prices: f64 = (self.bounded..self.multipliers.len())
            .map(|k| self.price(k) * self.multipliers[k])
            .sum();
        let sum: f64 = self.multipliers.slice(s![..self.bounded]).sum();
        Ok((f64::max(ratio, f64::MIN_POSITIVE) * sum / prices, drive))
    }

    /// Newton's method on weight·Σμ − ln det S − Σ ln μ − Σ ln λ − Σ ln ν with Σλ +
    /// Σν·cos δ = 1.
    fn centre(&mut self, weight: f64) {
        for _ in 0..tolerances::BARRIER_STEPS {
            let Some(inner) = self.inner_products() else {
                return;
            };
            let (hessian, traces) = self.curvature(&inner);
            let size = self.multipliers.len();
            let mut right = Array2::zeros((size, 2));
            for k in 0..size {
                let price = if k < self.bounded { weight } else { 0.0 };
                right[[k, 0]] = -(price - self.sign(k) * traces[k] - 1.0 / self.multipliers[k]);
                right[[k, 1]] = self.price(k);
            }
            // rounding at the very end of the path is no fault: the certificate judges
            // what was reached
            let Ok(solved) = solve_hermitian(hessian.view(), right.view()) else {
                return;
            };
            let sums = [0, 1].map(|column| {
                (0..size)
                    .map(|k| self.price(k) * solved[[k, column]])
                    .sum::<f64>()
            });
            let step = &solved.column(0) - &(&solved.column(1) * (sums[0] / sums[1]));
            let decrement = step.dot(&right.column(0));
            if decrement.is_nan()
                || decrement <= tolerances::BARRIER_DECREMENT
                || !self.advance(&step, decrement)
            {
                return;
            }
        }
    }

    /// Second derivatives of the barrier, and tr(S⁻¹·Q_k) of each multiplier's matrix
    /// Q_k.
    fn curvature(&self, inner: &Array2<Complex64>) -> (Array2<f64>, Vec<f64>) {
        let (rows, size) = (self.rows.nrows(), self.multipliers.len());
        let mut hessian = Array2::zeros((size, size));
        let mut traces: Vec<f64> = inner.diag().iter().map(|value| value.re).collect();
        for ((i, j), value) in inner.indexed_iter() {
            hessian[[i, j]] = self.sign(i) * self.sign(j) * value.norm_sqr();
        }
        let pairs: Vec<([usize; 2], Complex64)> = self
            .sectors
            .iter()
            .map(|p| {
                (
                    p.rows.map(|row| self.bounded + row),
                    Complex64::from_polar(1.0, -p.middle),
                )
            })
            .collect();
        for (p, &([i, j], turn)) in pairs.iter().enumerate() {
            traces.push((turn * inner[[j, i]]).re);
            for k in 0..rows {
                let value = -self.sign(k) * (turn * inner[[k, i]] * inner[[j, k]]).re;
                (hessian[[k, rows + p]], hessian[[rows + p, k]]) = (value, value);
            }
            for (q, &([m, n], other)) in pairs.iter().enumerate() {
                let both = turn * other * inner[[j, m]] * inner[[n, i]]
                    + turn * other.conj() * inner[[j, n]] * inner[[m, i]];
                hessian[[rows + p, rows + q]] = 0.5 * both.re;
            }
        }
        for k in 0..size {
            hessian[[k, k]] += self.multipliers[k].powi(-2);
        }
        (hessian, traces)
    }

    /// r_i S⁻¹ r_jᴴ for all rows; `None` where S is not positive definite.
    fn inner_products(&self) -> Option<Array2<Complex64>> {
        let lower = self.factor(&self.multipliers)?;
        let whitened = solve_lower(
            lower.view(),
            self.rows.t().mapv(|value| value.conj()).view(),
        )
        .ok()?;
        Some(matmul_h(whitened.view(), whitened.view()))
    }

    fn factor(&self, multipliers: &Array1<f64>) -> Option<Array2<Complex64>> {
        let bounded = gram(self.rows.slice(s![..self.bounded, ..]), |k| multipliers[k]);
        cholesky((bounded - self.asked(multipliers)).view()).ok()
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
    let lower = cholesky(b.view()).map_err(unsolvable)?;
    let half = solve_lower(lower.view(), a.view()).map_err(unsolvable)?;
    let whitened = solve_lower(lower.view(), half.t().mapv(|value| value.conj()).view())
        .map_err(unsolvable)?;
    let (values, vectors) = eigh(whitened.view()).map_err(unsolvable)?;
    let last = vectors.slice(s![.., vectors.ncols() - 1..]);
    let drive = solve_lower_adjoint(lower.view(), last).map_err(unsolvable)?;
    Ok((values[values.len() - 1], drive.column(0).to_owned()))
}
