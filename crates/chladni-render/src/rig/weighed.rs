//! The difference between a measured field and its prediction, and the evidence of changes that
//! would explain it (theory.md, eq. 57).

use super::field::{rms, LaidField, Prediction};
use crate::panel::kernel_error::unsolvable;
use crate::panel::modal_field::ModalField;
use crate::panel::operator::Operator;
use crate::tolerances;
use chladni_frf::{ModalModel, Result};
use ndarray::{Array1, Array2, ArrayView1, Axis};
use num_complex::Complex64;

/// The difference between measurement and prediction, and how it is weighed.
pub(super) struct View<'a> {
    pub(super) field: &'a LaidField,
    pub(super) predicted: &'a Array1<Complex64>,
    /// Covariance of the difference; its diagonal alone counts for magnitudes.
    covariance: Array2<Complex64>,
    /// Cholesky factor of it.
    root: Array2<Complex64>,
    /// The difference, whitened.
    pub(super) difference: Array1<f64>,
}

/// Prior variance of each part of a complex size with the standard deviation `std`.
pub(super) fn variance(std: f64) -> f64 {
    0.5 * std * std
}

/// Columns with one prior, and the factor that counts their alternatives.
pub(super) struct Cause {
    /// Whitened columns.
    pub(super) columns: Array2<f64>,
    /// Prior variance of each size.
    pub(super) prior: f64,
    pub(super) alternatives: usize,
}

/// Sizes of a cause and the evidence for it.
pub(super) struct WeighedCause {
    pub(super) sizes: Array1<f64>,
    pub(super) std: f64,
    pub(super) ln_evidence: f64,
    /// Covariance of the sizes.
    pub(super) covariance: Array2<f64>,
}

/// Evidence of a change, and the mean square of the whitened difference that it leaves: 1 or
/// less where that is noise.
pub(super) struct Explained {
    pub(super) ln_evidence: f64,
    pub(super) left: f64,
}

impl<'a> View<'a> {
    pub(super) fn new(
        model: &ModalModel,
        operator: &Operator,
        field: &'a LaidField,
        prediction: &'a Prediction,
        modal: &ModalField,
    ) -> Result<Self> {
        let predicted = &prediction.velocity;
        let covariance = covariance(model, operator, field, predicted, modal);
        let root = chladni_linalg::cholesky(covariance.view()).map_err(unsolvable)?;
        let mut view = Self {
            field,
            predicted,
            covariance,
            root,
            difference: Array1::zeros(0),
        };
        view.difference = view.against(predicted)?;
        Ok(view)
    }

    /// The measured field less `foretold`, whitened.
    fn against(&self, foretold: &Array1<Complex64>) -> Result<Array1<f64>> {
        if !self.field.magnitudes_only {
            return self.whitened((&self.field.velocity - foretold).view());
        }
        let pairs = self.field.velocity.iter().zip(foretold).enumerate();
        Ok(pairs
            .map(|(k, (measured, foretold))| (measured.norm() - foretold.norm()) / self.bar(k))
            .collect())
    }

    /// Standard deviation of a magnitude.
    fn bar(&self, k: usize) -> f64 {
        self.covariance[[k, k]].re.sqrt()
    }

    /// A change of the field as real numbers of unit variance; of magnitudes, its part along
    /// the predicted phase.
    pub(super) fn whitened(&self, change: ArrayView1<Complex64>) -> Result<Array1<f64>> {
        if self.field.magnitudes_only {
            let along = |(k, change): (usize, &Complex64)| {
                let predicted = self.predicted[k];
                let size = predicted.norm().max(f64::MIN_POSITIVE);
                (predicted.conj() * change).re / size / self.bar(k)
            };
            return Ok(change.iter().enumerate().map(along).collect());
        }
        let white = self.white(change)?;
        Ok(white
            .iter()
            .map(|v| v.re)
            .chain(white.iter().map(|v| v.im))
            .collect())
    }

    /// A change of a field with phases, its parts of unit variance.
    pub(super) fn white(&self, change: ArrayView1<Complex64>) -> Result<Array1<Complex64>> {
        let column = change.insert_axis(Axis(1));
        let white = chladni_linalg::solve_lower(self.root.view(), column).map_err(unsolvable)?;
        Ok(white.column(0).mapv(|part| part * std::f64::consts::SQRT_2))
    }

    /// Columns of complex sizes: each change, and the same turned by a quarter.
    pub(super) fn complex_columns(&self, changes: &[Array1<Complex64>]) -> Result<Array2<f64>> {
        let mut columns = Array2::zeros((self.difference.len(), 2 * changes.len()));
        for (number, change) in changes.iter().enumerate() {
            columns
                .column_mut(2 * number)
                .assign(&self.whitened(change.view())?);
            let turned = change.mapv(|value| value * Complex64::I);
            columns
                .column_mut(2 * number + 1)
                .assign(&self.whitened(turned.view())?);
        }
        Ok(columns)
    }

    pub(super) fn weigh(&self, cause: &Cause) -> Result<WeighedCause> {
        self.weigh_of(cause, &self.difference)
    }

    /// The same of another difference.
    fn weigh_of(&self, cause: &Cause, difference: &Array1<f64>) -> Result<WeighedCause> {
        let b = cause.columns.t().dot(difference);
        let mut normal = cause.columns.t().dot(&cause.columns);
        normal
            .diag_mut()
            .mapv_inplace(|value| value + 1.0 / cause.prior);
        let inverse = chladni_linalg::inverse_hermitian(normal.view()).map_err(unsolvable)?;
        let root = chladni_linalg::cholesky(normal.view()).map_err(unsolvable)?;
        let ln_det = 2.0 * root.diag().iter().map(|value| value.ln()).sum::<f64>();
        let sizes = inverse.dot(&b);
        let ln_prior = cause.prior.ln() * b.len() as f64;
        Ok(WeighedCause {
            ln_evidence: 0.5 * (b.dot(&sizes) - ln_det - ln_prior)
                - (cause.alternatives as f64).ln(),
            std: inverse.diag().sum().sqrt(),
            covariance: inverse,
            sizes,
        })
    }

    /// Evidence of a change without free size.
    pub(super) fn fixed(&self, change: &Array1<Complex64>, alternatives: usize) -> Result<f64> {
        let changed = self.against(&(self.predicted + change))?;
        Ok(self.fixed_of(&changed, alternatives))
    }

    /// The same of the difference that it leaves.
    fn fixed_of(&self, changed: &Array1<f64>, alternatives: usize) -> f64 {
        0.5 * (self.difference.dot(&self.difference) - changed.dot(changed))
            - (alternatives as f64).ln()
    }

    /// The same of a whitened change of a field with phases.
    pub(super) fn fixed_of_white(
        &self,
        change: impl IntoIterator<Item = Complex64>,
        alternatives: usize,
    ) -> f64 {
        let rows = self.difference.len() / 2;
        let changed = change.into_iter().enumerate().map(|(k, change)| {
            let left = Complex64::new(self.difference[k], self.difference[rows + k]);
            (left.conj() * change).re - 0.5 * change.norm_sqr()
        });
        changed.sum::<f64>() - (alternatives as f64).ln()
    }

    /// Gains that scatter beside a change without free size, after which each channel moves the
    /// field by its path; at the likelier one of the scales of gains.
    pub(super) fn fixed_and_scattered(
        &self,
        change: &Array1<Complex64>,
        paths: &[Array1<Complex64>],
        alternatives: usize,
    ) -> Result<Explained> {
        let changed = self.against(&(self.predicted + change))?;
        let alone = self.fixed_of(&changed, alternatives);
        let mut gains = self.scattered(paths)?;
        let mut best = Explained {
            ln_evidence: f64::NEG_INFINITY,
            left: f64::INFINITY,
        };
        for scale in tolerances::SCATTER_SCALES {
            gains.prior = variance(scale);
            let found = self.weigh_of(&gains, &changed)?;
            if alone + found.ln_evidence > best.ln_evidence {
                let left = &changed - &gains.columns.dot(&found.sizes);
                best = Explained {
                    ln_evidence: alone + found.ln_evidence,
                    left: left.dot(&left) / left.len() as f64,
                };
            }
        }
        Ok(best)
    }

    /// Gains of all channels, each by itself.
    pub(super) fn scattered(&self, paths: &[Array1<Complex64>]) -> Result<Cause> {
        Ok(Cause {
            columns: self.complex_columns(paths)?,
            prior: variance(tolerances::CHANNEL_GAIN_ERROR),
            alternatives: 1,
        })
    }

    /// ln of the likelihood with `variance` added at each response, to a constant.
    pub(super) fn ln_likelihood(&self, variance: f64) -> Result<f64> {
        if self.field.magnitudes_only {
            let of = |k: usize| {
                let before = self.covariance[[k, k]].re;
                let after = before + 0.5 * variance;
                -0.5 * (self.difference[k].powi(2) * before / after + after.ln())
            };
            return Ok((0..self.difference.len()).map(of).sum());
        }
        let mut covariance = self.covariance.clone();
        covariance.diag_mut().mapv_inplace(|value| value + variance);
        let root = chladni_linalg::cholesky(covariance.view()).map_err(unsolvable)?;
        let difference = (&self.field.velocity - self.predicted).insert_axis(Axis(1));
        let white = chladni_linalg::solve_lower(root.view(), difference.view());
        let white = white.map_err(unsolvable)?;
        let ln_det = 2.0 * root.diag().iter().map(|value| value.re.ln()).sum::<f64>();
        Ok(-white.iter().map(Complex64::norm_sqr).sum::<f64>() - ln_det)
    }

    /// The measured rows of a field at all responses.
    pub(super) fn rows(&self, field: &Array1<Complex64>) -> Array1<Complex64> {
        field.select(Axis(0), &self.field.rows)
    }
}

/// S₀; for magnitudes the variances along the phase.
fn covariance(
    model: &ModalModel,
    operator: &Operator,
    field: &LaidField,
    predicted: &Array1<Complex64>,
    modal: &ModalField,
) -> Array2<Complex64> {
    let mut of_model = Array2::<Complex64>::zeros((predicted.len(), predicted.len()));
    for (number, frequency_hz) in modal.in_band(model) {
        let mode = modal.mode(number);
        // ∂v/∂η is j/2 of ∂v/∂ln ω: one column carries both deviations
        let std = (mode.frequency_std_hz / frequency_hz).hypot(0.5 * mode.loss_factor_std);
        if std > 0.0 {
            let slope = modal.slope(number).select(Axis(0), &field.rows);
            let column = slope.insert_axis(Axis(1)).mapv(|value| value * std);
            of_model += &column.dot(&column.t().mapv(|value| value.conj()));
        }
        let part = modal.part_of(number);
        for (k, &row) in field.rows.iter().enumerate() {
            let response = operator.response_rows[row];
            let shape = mode.shape.0[response].norm();
            if shape > 0.0 {
                let error = part[row].norm() * mode.shape_std_at_known_scale(response) / shape;
                of_model[[k, k]] += error * error;
            }
        }
    }
    let isotropic = (tolerances::ISOTROPIC_FIELD_ERROR * rms(predicted)).powi(2);
    of_model.diag_mut().mapv_inplace(|value| value + isotropic);
    if field.magnitudes_only {
        of_model.mapv_inplace(|value| value * 0.5);
    }
    for (value, std) in of_model.diag_mut().iter_mut().zip(&field.std) {
        *value += std * std;
    }
    of_model
}
