//! The linear least-squares problem of one FRF (method `rfp`, the form of 1982).
//!
//! With Y = N/D in the measured kind, multiplying by D makes the fit linear (equation
//! error):
//!
//! ```text
//! min Σ_k | D(jy_k) Y(jy_k) − N(jy_k) |²,   D = Σ_{i<m} d_i θ_i + θ_m,   N = Σ_i c_i φ_i
//! ```
//!
//! φ is orthonormal on the lines, θ on the lines with weight |Y|² ([`super::forsythe`]), and
//! the leading coefficient of D is one, as in 1982. The unknown numerator is eliminated: with
//! P the columns φ and T the columns Y θ, A = (I − PPᵀ)T and D solves A d ≈ 0. A is factored
//! by QR, then SVD; it is never squared.
//!
//! *Equation error, not output error.* The residual is the measured one times |D|, which
//! is small at the resonances and large between and beyond them: the fit looks where the
//! modes are not. Noise enters A too, so the estimate is biased, and collecting more
//! lines does not remove the bias. A well-conditioned basis changes nothing of
//! this; pole pairs to spare ([`super::limits::SPARE_PAIRS`]) change much, since they take the
//! noise on themselves.
//!
//! The covariance is the linearised one with each residual standing for its own variance
//! (White 1980), because the equation error of white noise is anything but white: C = A⁺
//! diag(e²) A⁺ᵀ, carried to the roots by ds = −Σ θ_i(s) dd_i / D′(s). Directions of d
//! that the data leave open (singular values at rounding level, as with noise-free data
//! and spare pole pairs) get the variance of the leading coefficient, one: true poles do
//! not feel them, arbitrary ones become as uncertain as they are. The covariance tells
//! the scatter, not the bias.
//!
//! Cost per band: 8·lines·(numerator + denominator)·order flop for A, then its QR.

use super::limits::RANK_CUTOFF;
use crate::methods::forsythe::Forsythe;
use crate::methods::limits::{LINES_PER_UNKNOWN, NUMERATOR_EXTRA};
use chladni_linalg::{matmul, matmul_h, qr_r, svd_thin, LinalgError};
use ndarray::{s, Array2, ArrayView1, ShapeBuilder};
use num_complex::Complex64;

/// Lines of a band and the numerator basis on them, the same for all FRFs.
#[derive(Debug)]
pub(crate) struct BandEquations {
    /// ω/ω_max of the lines.
    y: Vec<f64>,
    /// Modes of the denominator, half its degree.
    order: usize,
    /// Numerator columns: real parts over imaginary parts, (2·lines, degree + 1),
    /// orthonormal.
    numerator: Array2<f64>,
}

/// A root of D with its linearised error.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Root {
    /// s/ω_max, upper half plane; either sign of damping.
    pub s: Complex64,
    /// One sigma of |s|/ω_max and of η = −2 Re s/|s|.
    pub deviation: [f64; 2],
}

impl Root {
    /// One sigma of |s| relative to the half-bandwidth: above one, the data do not know
    /// whether this is a mode.
    pub fn uncertainty(&self) -> f64 {
        self.deviation[0] / self.s.re.abs()
    }
}

/// Solution of the equations.
#[derive(Debug)]
pub(crate) struct Denominator {
    /// Roots with Im s > 0.
    pub roots: Vec<Root>,
    /// Condition of the reduced equations, as far as rounding lets it be known (4.5e15).
    pub condition: f64,
}

impl BandEquations {
    /// Numerators get two terms per mode, one per power of jω of the measured kind, and
    /// [`NUMERATOR_EXTRA`] for what lies outside the band.
    ///
    /// # Errors
    /// Fewer lines than the numerator needs.
    pub fn new(y: Vec<f64>, order: usize, omega_power: usize) -> Result<Self, LinalgError> {
        let basis = Forsythe::new(
            &y,
            &vec![1.0; y.len()],
            numerator_degree(order, omega_power),
        )?;
        let ones = vec![Complex64::new(1.0, 0.0); y.len()];
        Ok(Self {
            numerator: columns_in_halves(&basis.half, &ones),
            y,
            order,
        })
    }

    /// Denominator of an FRF, in the measured kind up to a real factor.
    ///
    /// # Errors
    /// Too few lines with data; no convergence of a decomposition.
    pub fn solve(&self, frf: &[Complex64]) -> Result<Denominator, LinalgError> {
        let weights: Vec<f64> = frf.iter().map(Complex64::norm_sqr).collect();
        let theta = Forsythe::new(&self.y, &weights, 2 * self.order)?;
        let reduced = self.reduced(&theta, &weights, frf);
        let m = theta.degree();
        let small = match reduced.nrows() > m {
            true => qr_r(reduced.view())?,
            false => reduced.clone(),
        };
        let (u, sigma, vh) = svd_thin(small.slice(s![.., ..m]))?;
        let cutoff = sigma[0] * RANK_CUTOFF;
        let inverse = sigma.mapv(|v| if v > cutoff { 1.0 / v } else { 0.0 });
        let condition = 1.0 / (sigma[m - 1] / sigma[0]).max(f64::EPSILON);
        let mut along = matmul_h(u.view(), small.slice(s![.., m..]));
        along
            .column_mut(0)
            .iter_mut()
            .zip(&inverse)
            .for_each(|(v, i)| *v *= -i);
        let mut d = matmul_h(vh.view(), along.view()).column(0).to_vec();
        d.push(1.0);
        // (AᵀA)⁺ = V Σ⁻² Vᵀ; directions that the data leave open are as uncertain as the
        // leading coefficient is large
        let scaled = |factor: &dyn Fn(f64) -> f64| {
            let mut rows = vh.clone();
            rows.rows_mut()
                .into_iter()
                .zip(&inverse)
                .for_each(|(mut row, i)| row *= factor(*i));
            matmul_h(vh.view(), rows.view())
        };
        let open = scaled(&|i| f64::from(u8::from(i == 0.0)));
        let covariance =
            covariance(&reduced, &d, &scaled(&|i| i * i), self.numerator.ncols()) + open;
        let roots = theta.roots(&d)?.into_iter().filter(|s| s.im > 0.0);
        Ok(Denominator {
            roots: roots
                .map(|s| Root {
                    s,
                    deviation: deviation(&theta, &d, &covariance, s),
                })
                .collect(),
            condition,
        })
    }

    /// A = (I − PPᵀ)·Yθ, real parts over imaginary parts.
    fn reduced(&self, theta: &Forsythe, weights: &[f64], frf: &[Complex64]) -> Array2<f64> {
        let ratio: Vec<Complex64> = frf
            .iter()
            .zip(weights)
            .map(|(v, w)| {
                if *w > 0.0 {
                    v / w.sqrt()
                } else {
                    Complex64::new(0.0, 0.0)
                }
            })
            .collect();
        let t = columns_in_halves(&theta.half, &ratio);
        let inside = matmul(
            self.numerator.view(),
            matmul_h(self.numerator.view(), t.view()).view(),
        );
        t - inside
    }
}

/// Degree of the numerators.
fn numerator_degree(order: usize, omega_power: usize) -> usize {
    2 * order + omega_power + NUMERATOR_EXTRA
}

/// Largest order that `lines` support with [`LINES_PER_UNKNOWN`] lines for each real
/// unknown of one FRF; at least one.
pub(crate) fn largest_order(lines: usize, omega_power: usize) -> usize {
    let unknowns = lines / LINES_PER_UNKNOWN;
    (unknowns.saturating_sub(numerator_degree(0, omega_power) + 1) / 4).max(1)
}

/// Columns factor·jᵏ·p_k with real parts over imaginary parts.
fn columns_in_halves(half: &Array2<f64>, factor: &[Complex64]) -> Array2<f64> {
    let lines = half.nrows();
    let mut out = Array2::zeros((2 * lines, half.ncols()).f());
    for (k, column) in half.columns().into_iter().enumerate() {
        let phase = Complex64::i().powu((k % 4) as u32);
        for (row, (p, f)) in column.iter().zip(factor).enumerate() {
            let value = phase * f * *p;
            out[[row, k]] = value.re;
            out[[lines + row, k]] = value.im;
        }
    }
    out
}

/// G·(Σ e² a aᵀ)·G with G = (AᵀA)⁺, e = A d, enlarged by the degrees of freedom the
/// unknowns took.
fn covariance(
    reduced: &Array2<f64>,
    d: &[f64],
    inverse_gram: &Array2<f64>,
    numerator_terms: usize,
) -> Array2<f64> {
    let m = d.len() - 1;
    let error = reduced.dot(&ArrayView1::from(d));
    let mut weighted = reduced.slice(s![.., ..m]).to_owned();
    weighted
        .rows_mut()
        .into_iter()
        .zip(&error)
        .for_each(|(mut row, e)| row *= *e);
    let carried = matmul(weighted.view(), inverse_gram.view());
    let rows = reduced.nrows();
    let unknowns = numerator_terms + m;
    matmul_h(carried.view(), carried.view())
        * (rows as f64 / rows.saturating_sub(unknowns).max(1) as f64)
}

/// One sigma of |s| and of η = −2 Re s/|s| for a root of Σ d_i θ_i.
fn deviation(theta: &Forsythe, d: &[f64], covariance: &Array2<f64>, root: Complex64) -> [f64; 2] {
    let (values, slopes) = theta.evaluate(root);
    let slope: Complex64 = slopes.iter().zip(d).map(|(v, d)| v * *d).sum();
    let modulus = root.norm();
    let m = d.len() - 1;
    let mut gradients = Array2::zeros((m, 2));
    for (i, value) in values.iter().take(m).enumerate() {
        let ds = -value / slope;
        let d_modulus = (root.conj() * ds).re / modulus;
        gradients[[i, 0]] = d_modulus;
        gradients[[i, 1]] = 2.0 * (root.re * d_modulus / modulus - ds.re) / modulus;
    }
    let variance = |q: usize| {
        gradients
            .column(q)
            .dot(&covariance.dot(&gradients.column(q)))
            .max(0.0)
    };
    [variance(0).sqrt(), variance(1).sqrt()]
}
