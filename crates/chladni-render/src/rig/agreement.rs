//! Agreement of a measured field with its prediction.

use super::diagnosis::diagnose;
use super::field::{LaidField, Prediction};
use super::hypothesis::Hypothesis;
use crate::panel::operator::Operator;
use crate::tolerances;
use chladni_frf::{Dof, Error, Finding, ModalModel, Result};
use ndarray::Array1;
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

/// Holds the measured field against its prediction; beside it the finding that names swapped
/// cables.
///
/// * `raw`, `field`: as it was measured, and with lone points replaced
/// * `deviation`: ‖L·A‖, of the prediction under the errors that drives are made to tolerate, m/s
///
/// # Errors
/// Those of the factorisations.
pub(crate) fn agreement(
    model: &ModalModel,
    operator: &Operator,
    [raw, field]: [&LaidField; 2],
    (prediction, deviation): (&Prediction, f64),
    likeness: &Likeness,
) -> Result<(Agreement, Option<Finding>)> {
    let predicted = &prediction.velocity;
    let nis = field.nis(predicted, deviation);
    let measured = raw.phased(predicted);
    let points = raw.rows.iter().zip(measured.iter().zip(predicted));
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
    let (hypotheses, swapped) = diagnose(model, operator, field, prediction, nis)?;
    let agreement = Agreement {
        nis,
        coefficient: likeness.coefficient,
        level_db: likeness.level_db,
        phase_deg: (!field.magnitudes_only).then_some(likeness.phase_deg),
        points,
        hypotheses,
    };
    Ok((agreement, swapped.map(|swapped| swapped.finding())))
}

/// Form and level of a measured field against its prediction.
pub(crate) struct Likeness {
    /// See [`Agreement::coefficient`].
    pub(crate) coefficient: f64,
    /// See [`Agreement::level_db`].
    pub(crate) level_db: f64,
    /// The same coefficient of the conjugate of the field; 0 where phases are unknown.
    conjugate: f64,
    phase_deg: f64,
    responses: usize,
    magnitudes_only: bool,
}

impl Likeness {
    /// Of a measured field against what is predicted at its responses.
    pub(crate) fn of(predicted: &Array1<Complex64>, field: &LaidField) -> Self {
        Self::between(predicted, &field.phased(predicted), field.magnitudes_only)
    }

    /// The same of measured values that have phases, or those predicted.
    pub(super) fn between(
        predicted: &Array1<Complex64>,
        measured: &Array1<Complex64>,
        magnitudes_only: bool,
    ) -> Self {
        let pairs = predicted.iter().zip(measured);
        let inner: Complex64 = pairs.clone().map(|(a, b)| a.conj() * b).sum();
        let turned: Complex64 = pairs.map(|(a, b)| a * b).sum();
        let square = |values: &Array1<Complex64>| values.iter().map(Complex64::norm_sqr).sum();
        let [own, other]: [f64; 2] = [square(predicted), square(measured)];
        let quotient = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
        Self {
            coefficient: quotient(inner.norm_sqr(), own * other),
            conjugate: match magnitudes_only {
                true => 0.0,
                false => quotient(turned.norm_sqr(), own * other),
            },
            level_db: 10.0 * quotient(other, own).max(f64::MIN_POSITIVE).log10(),
            phase_deg: inner.arg().to_degrees(),
            responses: predicted.len(),
            magnitudes_only,
        }
    }

    /// True where the form is right and the level off by more than `most_db`: a wrong unit
    /// rather than a fault.
    fn is_level_off(&self, most_db: f64) -> bool {
        let [of_values, of_magnitudes] = tolerances::SAME_FORM;
        let same_form = if self.magnitudes_only {
            of_magnitudes
        } else {
            of_values
        };
        self.responses >= tolerances::LEVEL_RESPONSES
            && self.coefficient >= same_form
            && self.level_db.abs() > most_db
    }

    /// True where the field turns the wrong way in time.
    fn is_conjugated(&self) -> bool {
        let left = 1.0 - self.coefficient;
        self.responses >= tolerances::LEVEL_RESPONSES
            && left > tolerances::CONJUGATE_SHOWS
            && 1.0 - self.conjugate < tolerances::CONJUGATE_LEAVES * left
    }

    /// True where the field may as well have nothing to do with its drive.
    pub(super) fn is_unlike(&self) -> bool {
        let many = self.responses >= tolerances::LEVEL_RESPONSES;
        let is_low = self.coefficient < tolerances::UNLIKE;
        many && !self.magnitudes_only && is_low && !self.is_conjugated()
    }

    /// The level and the coefficient in words.
    fn in_words(&self) -> String {
        format!(
            "{:+.1} dB against the prediction, at an agreement of {:.3} in form",
            self.level_db, self.coefficient
        )
    }

    /// The finding of a field that has the right form at a wrong level, the form of its
    /// conjugate, or no form that its drive could make.
    pub(crate) fn finding(&self) -> Option<Finding> {
        if self.is_conjugated() {
            let words = format!(
                "the conjugate of the field agrees with the prediction ({:.3} in form), the field does \
                 not ({:.3}): it turns the wrong way in time",
                self.conjugate, self.coefficient
            );
            let finding = Finding::caution("field-conjugated", words)
                .value("coefficient", self.coefficient)
                .value("of_conjugate", self.conjugate);
            return Some(finding.help(CONJUGATE_HELP));
        }
        if self.is_unlike() {
            let words = format!(
                "the field has hardly any of the form that its weights should make (agreement {:.3}): \
                 it may be that of other weights, of other points, of nothing but noise, or of a fault \
                 as large as the field",
                self.coefficient
            );
            let finding = Finding::caution("field-unlike", words);
            return Some(finding.value("coefficient", self.coefficient).help(
                "see that these weights were played, that points have their names, and that the \
                 panel moved",
            ));
        }
        self.is_level_off(tolerances::LEVEL_OFF_DB).then(|| {
            let words = format!("the field lies at {}", self.in_words());
            Finding::caution("field-level-off", words)
                .value("level_db", self.level_db)
                .value("coefficient", self.coefficient)
                .help(LEVEL_HELP)
        })
    }

    /// Refuses a field that turns the wrong way, or fails [`Self::check_level`].
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`].
    pub(crate) fn check(&self) -> Result<()> {
        if self.is_conjugated() {
            return Err(Error::bad_data("the field turns the wrong way in time")
                .field("velocity")
                .found(format!(
                    "agreement {:.3} with the prediction, {:.3} of its conjugate",
                    self.coefficient, self.conjugate
                ))
                .expected("phases of e^(+jωt)")
                .help(CONJUGATE_HELP));
        }
        self.check_level()
    }

    /// Refuses a field at a level from which a correction would learn large gains.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`].
    pub(super) fn check_level(&self) -> Result<()> {
        if !self.is_level_off(tolerances::LEVEL_REFUSED_DB) {
            return Ok(());
        }
        Err(
            Error::bad_data("the level of the field is not that of its drive")
                .field("unit")
                .found(self.in_words())
                .expected(format!(
                    "a level within {} dB of the prediction",
                    tolerances::LEVEL_REFUSED_DB
                ))
                .help(LEVEL_HELP),
        )
    }
}

const CONJUGATE_HELP: &str = "change the sign of its imaginary parts, or of its phases";
const LEVEL_HELP: &str = "check the unit of the field (m/s, mm/s, um/s; peak) and the gain of the \
                          amplifiers; a gain that is meant belongs in the calibration";

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn a_field_turns_the_wrong_way_however_well_its_real_parts_agree() {
        let wave = |imaginary: f64| -> Array1<Complex64> {
            let turns = (0..16).map(|k| TAU * f64::from(k) / 16.0);
            turns
                .map(|turn| Complex64::new(turn.cos(), imaginary * turn.sin()))
                .collect()
        };
        for (imaginary, is_turned) in [(0.8, true), (0.3, true), (0.05, false), (0.0, false)] {
            let predicted = wave(imaginary);
            let of = |field: &Array1<Complex64>| Likeness::between(&predicted, field, false);
            let conjugated = of(&predicted.mapv(|value| value.conj()));
            assert_eq!(conjugated.check().is_err(), is_turned, "{imaginary}");
            assert!(of(&predicted).check().is_ok(), "{imaginary}");
        }
    }
}
