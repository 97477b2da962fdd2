//! Error of the model in a given drive: the root L of the mean covariance of its mobility
//! rows.
//!
//! For one row δh_k of the error δH, E|δh_k·A|² averaged over the judged responses k is
//! ‖L·A‖². Per mode n, with γ_n = jω/(ω_n²(1+jη_n) − ω²) (the seed paper's γ_n without
//! ψ_n) and its participation φ_n at the actuators, L has the row
//!
//! √( mean_k [ |ψ_nk|²·σ_γ² + |γ_n|²·σ_ψ,nk² ] ) · φ_nᵀ,
//! σ_γ² = |γ_n|²·[ (2ω_n²·s_ω)² + (ω_n²η_n·s_η)² ] / |ω_n²(1+jη_n) − ω²|²,
//!
//! with relative standard deviations s_ω, s_η: those of the model and the drift of the
//! options, added as squares. This is what stops a drive from leaning on a mode at
//! resonance, whose frequency moves with temperature and touch. An isotropic part, one
//! row s·I, stands for everything else: errors of residual terms, of the measurement.
//! Participations are taken to be as sure as the shape they belong to. Their errors, and
//! those of the drives themselves, are independent from actuator to actuator: they stand
//! on the diagonal.
//!
//! Poles outside the band stand for the world outside; their own standard deviations are
//! those of a surrogate and are left out, the drift is not. Viscous models use the same
//! formula: at the relative size of an error bar both laws agree.

use crate::panel::kernel_error::unsolvable;
use crate::panel::operator::Operator;
use crate::scene::drift::Drift;
use crate::tolerances;
use chladni_frf::{ModalModel, Mode, Result, Trust};
use ndarray::{concatenate, Array1, Array2, ArrayView1, ArrayView2, Axis};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// The mean error covariance LᴴL of the mobility rows, ((m/s)/N)² or ((m/s)/V)², by the
/// parts of its root L.
#[derive(Debug, Clone, PartialEq)]
pub struct Covariance {
    /// Rows of L that errors of the model fill; axes (any, reference).
    rows: Array2<Complex64>,
    /// The others, a diagonal: what errs at each actuator by itself.
    own: Array1<f64>,
    /// LᴴL.
    gram: Array2<Complex64>,
}

impl Covariance {
    /// From the model's standard deviations and the drift, averaged over the rows
    /// `judged` of the operator.
    pub fn of_model(
        model: &ModalModel,
        operator: &Operator,
        judged: &[usize],
        drift: &Drift,
    ) -> Self {
        let modes: Vec<&Mode> = model
            .modes
            .iter()
            .filter(|mode| mode.trust != Trust::Rejected)
            .collect();
        let isotropic = drift.isotropic_relative * rms(&operator.mobility);
        let mut squares = Array1::from_elem(operator.references.len(), isotropic * isotropic);
        let mut rows = Array2::zeros((modes.len(), operator.references.len()));
        for (mode, mut row) in modes.iter().zip(rows.rows_mut()) {
            let deviation = RowDeviation::of(mode, operator, judged, drift);
            for ((&column, value), square) in operator
                .reference_columns
                .iter()
                .zip(&mut row)
                .zip(&mut squares)
            {
                let participation = mode.participation.0[column];
                *value = participation * deviation.common;
                *square += participation.norm_sqr() * deviation.each.powi(2);
            }
        }
        let mut gram = chladni_linalg::matmul_h(rows.view(), rows.view());
        gram.diag_mut()
            .zip_mut_with(&squares, |value, &square| *value += square);
        let of_model = Self {
            rows,
            own: squares.mapv(f64::sqrt),
            gram,
        };
        of_model.with_drive_error(drift.drive_error(), operator, judged)
    }

    /// The same with an error of each actuator's force for its weight on top, relative.
    pub(crate) fn with_drive_error(
        mut self,
        relative: f64,
        operator: &Operator,
        judged: &[usize],
    ) -> Self {
        if relative > 0.0 {
            let own = self.own.iter_mut().zip(self.gram.diag_mut());
            for ((own, value), column) in own.zip(operator.mobility.columns()) {
                let path =
                    judged.iter().map(|&k| column[k].norm_sqr()).sum::<f64>() / judged.len() as f64;
                let square = relative.powi(2) * path;
                *own = (*own * *own + square).sqrt();
                *value += square;
            }
        }
        self
    }

    /// From LᴴL itself.
    ///
    /// # Errors
    /// Those of the factorisation: no covariance.
    pub(crate) fn of_gram(gram: Array2<Complex64>) -> Result<Self> {
        let mut whole = Self {
            rows: Array2::zeros((0, gram.ncols())),
            own: Array1::zeros(gram.ncols()),
            gram,
        };
        whole.rows = whole.triangular_root()?;
        Ok(whole)
    }

    /// LᴴL, ((m/s)/N)².
    pub fn gram(&self) -> &Array2<Complex64> {
        &self.gram
    }

    /// ‖L·A‖: one standard deviation of the velocity at a response under the drive A,
    /// m/s.
    pub fn deviation(&self, drive: &Array1<Complex64>) -> f64 {
        self.deviation_of(self.rows.dot(drive).view(), drive.view())
    }

    /// The same of many drives; axes (reference, drive).
    pub(crate) fn deviations(&self, drives: ArrayView2<Complex64>) -> Vec<f64> {
        let of_model = chladni_linalg::matmul(self.rows.view(), drives);
        let each = of_model.columns().into_iter().zip(drives.columns());
        each.map(|(of_model, drive)| self.deviation_of(of_model, drive))
            .collect()
    }

    /// ‖L·A‖ of what the rows of the model make of A.
    fn deviation_of(&self, of_model: ArrayView1<Complex64>, drive: ArrayView1<Complex64>) -> f64 {
        let own = drive
            .iter()
            .zip(&self.own)
            .map(|(weight, own)| weight.norm_sqr() * own * own)
            .sum::<f64>();
        (of_model.iter().map(Complex64::norm_sqr).sum::<f64>() + own).sqrt()
    }

    /// A square L with the same LᴴL, upper triangular; no row where there is no error at
    /// all.
    ///
    /// # Errors
    /// Those of the factorisation: a broken promise.
    pub(crate) fn triangular_root(&self) -> Result<Array2<Complex64>> {
        let mut gram = self.gram.clone();
        let mean = gram.diag().iter().map(|value| value.re).sum::<f64>() / gram.nrows() as f64;
        if mean == 0.0 {
            return Ok(Array2::zeros((0, gram.ncols())));
        }
        gram.diag_mut()
            .mapv_inplace(|value| value + mean * tolerances::RIDGE);
        let lower = chladni_linalg::cholesky(gram.view()).map_err(unsolvable)?;
        Ok(lower.t().mapv(|value| value.conj()))
    }

    /// The same with further rows of errors.
    pub(crate) fn with_errors(&self, errors: Array2<Complex64>) -> Self {
        let gram = &self.gram + &chladni_linalg::matmul_h(errors.view(), errors.view());
        Self {
            rows: concatenate![Axis(0), self.rows, errors],
            gram,
            ..self.clone()
        }
    }

    /// The error of the columns `actuators` alone.
    pub(crate) fn with_actuators(&self, actuators: &[usize]) -> Self {
        Self {
            rows: self.rows.select(Axis(1), actuators),
            own: self.own.select(Axis(0), actuators),
            gram: self
                .gram
                .select(Axis(0), actuators)
                .select(Axis(1), actuators),
        }
    }
}

/// The part that a mode adds to the error of a row, over its participations.
struct RowDeviation {
    /// √( mean_k [ |ψ_nk|²·σ_γ² + |γ_n|²·σ_ψ,nk² ] ): the same error under every
    /// actuator.
    common: f64,
    /// |γ_n| √( mean_k |ψ_nk|² ) σ_φ with the participations as sure as the shape: an error of
    /// its own under each actuator.
    each: f64,
}

impl RowDeviation {
    fn of(mode: &Mode, operator: &Operator, judged: &[usize], drift: &Drift) -> Self {
        let omega = TAU * operator.frequency_hz;
        let omega_n = TAU * mode.frequency_hz;
        let denominator = 1.0 / mode.structural_factor(omega).norm();
        let gamma = omega / denominator;
        let own = if mode.in_band { 1.0 } else { 0.0 };
        let frequency_relative = drift
            .frequency_relative
            .hypot(own * ratio(mode.frequency_std_hz, mode.frequency_hz));
        let loss_relative = drift
            .loss_factor_relative
            .hypot(own * ratio(mode.loss_factor_std, mode.loss_factor));
        let sigma_gamma = gamma / denominator
            * (2.0 * omega_n.powi(2) * frequency_relative)
                .hypot(omega_n.powi(2) * mode.loss_factor * loss_relative);
        let (mut energy, mut of_bars) = (0.0, 0.0);
        for &k in judged {
            let row = operator.response_rows[k];
            energy += mode.shape.0[row].norm_sqr();
            of_bars += mode.shape_variance_at_known_scale(row);
        }
        let of_pole = energy * sigma_gamma.powi(2);
        let of_shape = gamma.powi(2) * (own * of_bars + drift.shape_relative.powi(2) * energy);
        let count = judged.len() as f64;
        Self {
            common: ((of_pole + of_shape) / count).sqrt(),
            each: (of_shape / count).sqrt(),
        }
    }
}

/// |deviation/value|; 0 where the value is 0 (a rigid-body mode, an undamped one).
fn ratio(deviation: f64, value: f64) -> f64 {
    if value == 0.0 {
        0.0
    } else {
        (deviation / value).abs()
    }
}

fn rms(matrix: &Array2<Complex64>) -> f64 {
    (matrix.iter().map(Complex64::norm_sqr).sum::<f64>() / matrix.len() as f64).sqrt()
}
