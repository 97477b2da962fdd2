//! Cramér-Rao bounds: how well any unbiased method can find natural frequencies and loss
//! factors from FRFs with white noise.
//!
//! With x = ω² each FRF l in the measured kind is g(x_k) [Σ_n R_nl/(λ_n − x_k) + Σ_p C_pl
//! ω_k^p] + noise of variance σ², with λ_n = ω_n²(1 + jη_n), g = 1, jω or −ω². Everything
//! is complex-analytic, residues and residual terms are free in each FRF, so that
//!
//! Cov(λ) = σ² [ (Dᴴ P⊥ D) ⊙ (R̄ Rᵀ) ]⁻¹,   D_kn = −g_k/(λ_n − x_k)²,   (theory.md,
//! eq. 33)
//!
//! where P⊥ projects out the columns g/(λ_n − x) and g ω^p (Golub and Pereyra, *Inverse
//! Problems* 19, 2003, R1-R26, for the elimination; Kay, *Estimation Theory*, 1993, ch.
//! 15, for complex parameters). Real and imaginary part share the variance, hence
//!
//! sd(f)/f = √(C_nn/2) / (2 Re λ_n),   sd(η) = √(C_nn/2) √(1+η²) / Re λ_n.
//!
//! Methods that assume more may beat these bounds of free residues;
//! [`crate::cramer_rao_rank_one`] has those of one shape per mode,
//! [`crate::cramer_rao_real`] those of real shapes.

use chladni_frf::{Error, ErrorKind, ModalModel, Mode, Result};
use chladni_linalg::{cholesky, lstsq, matmul, matmul_h, solve_lower, LinalgError};
use ndarray::{concatenate, Array1, Array2, ArrayView1, Axis};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Least standard deviations of the in-band modes, in their order in the model.
#[derive(Debug, Clone, PartialEq)]
pub struct CramerRao {
    /// Of the natural frequencies, Hz.
    pub frequency_std_hz: Vec<f64>,
    /// Of the loss factors.
    pub loss_factor_std: Vec<f64>,
}

/// Bounds for the in-band modes of `model`, measured on `frequency_hz` with white noise
/// E|n|² = `noise_variance` in the measured kind.
///
/// * `residual_powers`: powers of ω (in receptance) whose coefficients are free in each
///   FRF
///
/// Modes out of band count as known; mark them `in_band` to make their poles and residues
/// unknowns too. Exact for structural damping; for viscous damping to first order in ζ.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`] where lines or FRFs are too few for the unknowns,
/// or two modes cannot be told apart.
pub fn cramer_rao(
    model: &ModalModel,
    frequency_hz: &Array1<f64>,
    noise_variance: f64,
    residual_powers: &[i32],
) -> Result<CramerRao> {
    bound(
        model,
        frequency_hz,
        noise_variance,
        residual_powers,
        |lines, modes| {
            let outside = lines.slopes_outside(true)?;
            let residue_gram =
                gram(modes, |mode| &mode.shape.0) * gram(modes, |mode| &mode.participation.0);
            let root = inverse_root(
                matmul_h(outside.view(), outside.view()) * residue_gram,
                modes.len(),
            )?;
            Ok(PoleVariance::circular(&root))
        },
    )
}

/// Least covariance of Re λ and Im λ over σ²/2, λ in units of (2π·top)².
#[derive(Debug, Clone, Copy)]
pub(crate) struct PoleVariance {
    pub re: f64,
    pub im: f64,
    pub cross: f64,
}

impl PoleVariance {
    /// Of complex unknowns, one per column of the inverse root: both parts share the
    /// variance.
    pub fn circular(root: &Array2<Complex64>) -> Vec<Self> {
        let of = |column: ArrayView1<Complex64>| {
            let variance = column.iter().map(|v| v.norm_sqr()).sum();
            Self {
                re: variance,
                im: variance,
                cross: 0.0,
            }
        };
        root.columns().into_iter().map(of).collect()
    }
}

/// Turns what `variance` says of the poles into deviations of the in-band modes.
pub(crate) fn bound(
    model: &ModalModel,
    frequency_hz: &Array1<f64>,
    noise_variance: f64,
    residual_powers: &[i32],
    variance: impl Fn(&Lines, &[&Mode]) -> std::result::Result<Vec<PoleVariance>, LinalgError>,
) -> Result<CramerRao> {
    let modes: Vec<&Mode> = model.in_band_modes().collect();
    if modes.is_empty() {
        return Ok(CramerRao {
            frequency_std_hz: Vec::new(),
            loss_factor_std: Vec::new(),
        });
    }
    let lines = Lines::new(model, &modes, frequency_hz, residual_powers);
    let variance = variance(&lines, &modes).map_err(|error| {
        let kind = if matches!(error, LinalgError::NoConvergence { .. }) {
            ErrorKind::Internal
        } else {
            ErrorKind::BadData
        };
        Error::new(
            kind,
            format!("these FRFs leave the poles undetermined: {error}"),
        )
        .help("more lines, more FRFs, or fewer modes and residual terms")
    })?;
    let deviation =
        |n: usize, variance: f64| (0.5 * noise_variance * variance).sqrt() / lines.poles[n].re;
    let of_modes = |value: &dyn Fn(usize) -> f64| (0..modes.len()).map(value).collect();
    Ok(CramerRao {
        frequency_std_hz: of_modes(&|n| deviation(n, variance[n].re) / 2.0 * modes[n].frequency_hz),
        loss_factor_std: of_modes(&|n| {
            let (eta, v) = (modes[n].loss_factor, variance[n]);
            deviation(n, v.im + eta * eta * v.re - 2.0 * eta * v.cross)
        }),
    })
}

/// Change of an FRF along the lines when its unknowns change.
pub(crate) struct Lines {
    /// λ_n in units of (2π·top)², top the end of the axis.
    poles: Vec<Complex64>,
    /// g/(λ_n − x), (line, mode).
    modal: Array2<Complex64>,
    /// g ω^p, (line, term).
    residual: Array2<Complex64>,
    /// −g/(λ_n − x)², (line, mode).
    slopes: Array2<Complex64>,
}

impl Lines {
    fn new(
        model: &ModalModel,
        modes: &[&Mode],
        frequency_hz: &Array1<f64>,
        residual_powers: &[i32],
    ) -> Self {
        let top = frequency_hz.iter().fold(0.0f64, |top, &f| top.max(f));
        let poles: Vec<Complex64> = modes
            .iter()
            .map(|mode| (mode.frequency_hz / top).powi(2) * Complex64::new(1.0, mode.loss_factor))
            .collect();
        let (lines, scale) = (frequency_hz.len(), (TAU * top).powi(2));
        let weight = |k: usize| model.frf_kind.from_receptance(TAU * frequency_hz[k]);
        let distance = |k: usize, n: usize| poles[n] - (frequency_hz[k] / top).powi(2);
        Self {
            modal: Array2::from_shape_fn((lines, modes.len()), |(k, n)| {
                weight(k) / (scale * distance(k, n))
            }),
            residual: Array2::from_shape_fn((lines, residual_powers.len()), |(k, p)| {
                weight(k) * (frequency_hz[k] / top).powi(residual_powers[p])
            }),
            slopes: Array2::from_shape_fn((lines, modes.len()), |(k, n)| {
                -weight(k) / (scale * distance(k, n).powi(2))
            }),
            poles,
        }
    }

    /// The part of the slopes that residual terms, and free residues too where `residues`
    /// says so, cannot explain.
    fn slopes_outside(
        &self,
        residues: bool,
    ) -> std::result::Result<Array2<Complex64>, LinalgError> {
        let columns = if residues {
            concatenate![Axis(1), self.modal, self.residual]
        } else {
            self.residual.clone()
        };
        outside(&columns, &self.slopes)
    }

    /// The part of the modal columns and of the slopes that residual terms cannot
    /// explain.
    pub fn outside_residual_terms(
        &self,
    ) -> std::result::Result<[Array2<Complex64>; 2], LinalgError> {
        Ok([
            outside(&self.residual, &self.modal)?,
            self.slopes_outside(false)?,
        ])
    }
}

/// The part of `of` outside the span of `columns`.
pub(crate) fn outside(
    columns: &Array2<Complex64>,
    of: &Array2<Complex64>,
) -> std::result::Result<Array2<Complex64>, LinalgError> {
    if columns.is_empty() {
        return Ok(of.clone());
    }
    Ok(of - matmul(columns.view(), lstsq(columns.view(), of.view())?.view()))
}

/// W with WᴴW = the first `count` rows and columns of the inverse of an information
/// matrix.
pub(crate) fn inverse_root(
    information: Array2<Complex64>,
    count: usize,
) -> std::result::Result<Array2<Complex64>, LinalgError> {
    // unit diagonal, so that strong and weak modes can stand side by side
    let size: Vec<f64> = information.diag().iter().map(|v| v.re.sqrt()).collect();
    let scaled = Array2::from_shape_fn(information.dim(), |(m, n)| {
        information[[m, n]] / (size[m] * size[n])
    });
    let first = Array2::from_shape_fn((size.len(), count), |(m, n)| {
        Complex64::from(if m == n { 1.0 / size[n] } else { 0.0 })
    });
    solve_lower(cholesky(scaled.view())?.view(), first.view())
}

/// Σ_i conj(v_mi) v_ni over all pairs of modes.
pub(crate) fn gram<'a>(
    modes: &[&'a Mode],
    vector: impl Fn(&'a Mode) -> &'a [Complex64],
) -> Array2<Complex64> {
    Array2::from_shape_fn((modes.len(), modes.len()), |(m, n)| {
        vector(modes[m])
            .iter()
            .zip(vector(modes[n]))
            .map(|(a, b)| a.conj() * b)
            .sum()
    })
}
