//! Agreement of a measured field with its prediction.

use super::diagnosis::{diagnose, Hypothesis};
use super::field::{LaidField, Prediction};
use crate::operator::Operator;
use chladni_frf::{Dof, ModalModel, Result};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// Agreement of a measured field with its prediction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Agreement {
    /// mean |v − v̂|²/(‖L·A‖² + σ²): about 1 or less where the error bars explain the
    /// difference.
    pub nis: f64,
    /// |v̂ᴴv|²/(‖v̂‖²‖v‖²), 1 for fields of one form; of the magnitudes where phases are
    /// unknown.
    pub coefficient: f64,
    /// Level of the measured field over the prediction, dB, over all responses.
    pub level_db: f64,
    /// Phase of the measured field against the prediction, degrees; `None` where phases are
    /// unknown.
    pub phase_deg: Option<f64>,
    /// Response by response.
    pub points: Vec<PointAgreement>,
    /// Possible causes of the difference, the likeliest first.
    pub hypotheses: Vec<Hypothesis>,
}

/// Agreement at one response.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PointAgreement {
    /// Response DOF.
    pub response: Dof,
    /// Measured over predicted level, dB; `None` where one of them is still.
    pub level_db: Option<f64>,
    /// Measured less predicted phase, degrees; `None` where it is unknown.
    pub phase_deg: Option<f64>,
}

/// Holds the measured field against its prediction.
///
/// # Errors
/// Those of the factorisations.
pub(crate) fn agreement(
    model: &ModalModel,
    operator: &Operator,
    field: &LaidField,
    prediction: &Prediction,
) -> Result<Agreement> {
    let predicted = &prediction.velocity;
    let measured = field.phased(predicted);
    let inner: Complex64 = predicted
        .iter()
        .zip(&measured)
        .map(|(a, b)| a.conj() * b)
        .sum();
    let square =
        |values: &ndarray::Array1<Complex64>| values.iter().map(Complex64::norm_sqr).sum::<f64>();
    let [own, other] = [square(predicted), square(&measured)];
    let nis = (0..measured.len())
        .map(|k| {
            let bar = prediction.deviation.powi(2) + field.std[k].powi(2);
            (measured[k] - predicted[k]).norm_sqr() / bar
        })
        .sum::<f64>()
        / measured.len() as f64;
    let points = field.rows.iter().zip(measured.iter().zip(predicted));
    let points = points
        .map(|(&row, (measured, predicted))| {
            let ratio = measured / predicted;
            let known = ratio.is_finite() && ratio.norm() > 0.0;
            PointAgreement {
                response: operator.responses[row],
                level_db: known.then(|| 20.0 * ratio.norm().log10()),
                phase_deg: (known && !field.magnitudes_only).then(|| ratio.arg().to_degrees()),
            }
        })
        .collect();
    let quotient = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
    Ok(Agreement {
        nis,
        coefficient: quotient(inner.norm_sqr(), own * other),
        level_db: 10.0 * quotient(other, own).max(f64::MIN_POSITIVE).log10(),
        phase_deg: (!field.magnitudes_only).then(|| inner.arg().to_degrees()),
        points,
        hypotheses: diagnose(model, operator, field, prediction)?,
    })
}
