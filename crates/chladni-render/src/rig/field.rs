//! A measured field laid over the operator that foretells it.

use super::agreement::{agreement, Agreement};
use crate::covariance::Covariance;
use crate::evaluate::{laid, Laid, On};
use crate::field::Field;
use crate::indices::{Indices, PointIndices};
use crate::options::Drift;
use crate::problem::Drive;
use crate::scene::{Limits, Scene};
use crate::tolerances;
use crate::weights::Weights;
use crate::zones::ZoneMap;
use chladni_frf::{Error, MeasuredField, ModalModel, Result};
use ndarray::{Array1, Array2, Axis};
use num_complex::Complex64;

/// How a measured field does, and what it says of the rig.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldEvaluation {
    /// Indices of the measured field.
    pub indices: Indices,
    /// Agreement with the prediction, and the likeliest causes of what is left.
    pub agreement: Agreement,
    /// The measured field; where phases are unknown, with those of the prediction.
    pub measured: Field,
    /// The prediction at the same responses.
    pub predicted: Field,
    /// The zones.
    pub zones: ZoneMap,
    /// Velocity limits.
    pub limits: Limits,
    /// What the user must know.
    pub warnings: Vec<String>,
}

/// Measured values in the order of the operator's rows.
pub(crate) struct LaidField {
    /// Rows of the operator that were measured.
    pub(crate) rows: Vec<usize>,
    /// Velocities along +Z, m/s; magnitudes where phases are unknown.
    pub(crate) velocity: Array1<Complex64>,
    /// Standard deviation of each, m/s.
    pub(crate) std: Array1<f64>,
    /// True where phases are unknown.
    pub(crate) magnitudes_only: bool,
    /// True where the file does not say how sure its values are.
    pub(crate) noise_assumed: bool,
}

impl LaidField {
    /// Lays `field` over the responses of `operator`; `sha256` is that of the weights file.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`]: another frequency, other weights, a response
    /// that the operator lacks.
    pub(crate) fn new(
        field: &MeasuredField,
        operator: &crate::operator::Operator,
        sha256: Option<&str>,
    ) -> Result<Self> {
        let asked = operator.frequency_hz;
        if (field.frequency_hz - asked).abs() > tolerances::SAME_FREQUENCY * asked {
            return Err(
                Error::bad_data("the field was measured at another frequency")
                    .field("frequency_hz")
                    .found(format!("{} Hz", field.frequency_hz))
                    .expected(format!("{asked} Hz, as the weights"))
                    .help("give the field that these weights make"),
            );
        }
        if let (Some(stated), Some(sha256)) = (&field.weights_sha256, sha256) {
            if stated != sha256 {
                return Err(Error::bad_data("the field is of other weights")
                    .field("weights_sha256")
                    .found(stated)
                    .expected(sha256)
                    .help("give the weights that were played when the field was measured"));
            }
        }
        let mut points = Vec::with_capacity(field.points.len());
        for point in &field.points {
            let row = operator
                .responses
                .iter()
                .position(|dof| dof.same_axis(point.response))
                .ok_or_else(|| {
                    let shown = operator.responses.iter().take(tolerances::DOFS_SHOWN);
                    let shown: Vec<String> = shown.map(ToString::to_string).collect();
                    Error::bad_data("the model has no such response along Z")
                        .field("response")
                        .found(point.response)
                        .expected(format!(
                            "one of its {} responses: {}, ...",
                            operator.responses.len(),
                            shown.join(", ")
                        ))
                        .help("name the responses as in the FRFs that the model was fitted to")
                })?;
            let sign = match field.magnitudes_only {
                true => 1.0,
                false => point.response.direction.sign(),
            };
            points.push((row, point.velocity_m_per_s * sign, point.std_m_per_s));
        }
        points.sort_by_key(|point| point.0);
        let velocity: Array1<Complex64> = points.iter().map(|point| point.1).collect();
        let size = rms(&velocity);
        let assumed = tolerances::FIELD_NOISE * size;
        let least = tolerances::LEAST_FIELD_NOISE * size;
        Ok(Self {
            rows: points.iter().map(|point| point.0).collect(),
            std: points
                .iter()
                .map(|point| point.2.unwrap_or(assumed).max(least))
                .collect(),
            noise_assumed: points.iter().any(|point| point.2.is_none()),
            magnitudes_only: field.magnitudes_only,
            velocity,
        })
    }

    /// The values with the phases of `predicted` where they have none of their own.
    pub(crate) fn phased(&self, predicted: &Array1<Complex64>) -> Array1<Complex64> {
        if !self.magnitudes_only {
            return self.velocity.clone();
        }
        let phased = self.velocity.iter().zip(predicted);
        phased
            .map(|(measured, predicted)| match predicted.norm() {
                size if size > 0.0 => predicted * (measured.norm() / size),
                _ => *measured,
            })
            .collect()
    }
}

/// Root of the mean square.
pub(crate) fn rms(values: &Array1<Complex64>) -> f64 {
    let square = values.iter().map(Complex64::norm_sqr).sum::<f64>();
    (square / values.len().max(1) as f64).sqrt()
}

/// What a prediction of a field is made of.
pub(crate) struct Prediction {
    /// Mobility at the measured rows.
    pub(crate) mobility: Array2<Complex64>,
    /// The drive.
    pub(crate) drive: Drive,
    /// Predicted velocities at the measured rows.
    pub(crate) velocity: Array1<Complex64>,
    /// ‖L·A‖: its standard deviation under the errors that drives are made to bear.
    pub(crate) deviation: f64,
}

/// Scores the field that was measured while `weights` were played, against its prediction
/// by `model`.
///
/// * `sha256`: of the weights file, held against the field's own
///
/// # Errors
/// As [`crate::evaluate()`]; a field of another frequency, of other weights, with a
/// response that the model lacks, or without hot or cold responses.
pub fn evaluate_field(
    weights: &Weights,
    scene: &Scene,
    model: &ModalModel,
    field: &MeasuredField,
    sha256: Option<&str>,
) -> Result<FieldEvaluation> {
    let Laid {
        operator,
        drive,
        limits,
        zones,
        mut warnings,
    } = laid(weights, scene, On::Model(model))?;
    let laid_field = LaidField::new(field, &operator, sha256)?;
    let all: Vec<usize> = (0..operator.responses.len()).collect();
    let drift = scene.drift.unwrap_or_default();
    let drift = Drift {
        drive_relative: drift.drive_relative.max(tolerances::RIG_DRIVE_ERROR),
        ..drift
    };
    let mobility = operator.mobility.select(Axis(0), &laid_field.rows);
    let prediction = Prediction {
        velocity: mobility.dot(&drive),
        deviation: Covariance::of_model(model, &operator, &all, &drift).deviation(&drive),
        mobility,
        drive: drive.clone(),
    };
    let predicted = part(&Field::new(&operator, &zones, &drive), &laid_field.rows);
    let measured = Field {
        velocity_m_per_s: laid_field.phased(&prediction.velocity).to_vec(),
        ..predicted.clone()
    };
    let points = PointIndices::of_field(&measured, &zones, &limits, &drive, operator.unit)?;
    if laid_field.rows.len() < operator.responses.len() {
        let words = format!(
            "the field holds {} of the {} responses; only these are judged",
            laid_field.rows.len(),
            operator.responses.len()
        );
        warnings.push(words);
    }
    if laid_field.noise_assumed {
        let words = format!(
            "the field does not say how sure its values are: a noise of {} % of their rms is \
             assumed; add a column std, or repeats",
            100.0 * tolerances::FIELD_NOISE
        );
        warnings.push(words);
    }
    let agreement = agreement(model, &operator, &laid_field, &prediction)?;
    // between few responses nothing is interpolated
    let area = (laid_field.rows.len() == operator.responses.len())
        .then(|| measured.area(&zones))
        .flatten()
        .map(|area| crate::indices::AreaIndices::of_area(&area, &zones, &limits));
    Ok(FieldEvaluation {
        indices: Indices { points, area },
        agreement,
        measured,
        predicted,
        zones,
        limits,
        warnings,
    })
}

/// The field at some of its responses.
fn part(field: &Field, rows: &[usize]) -> Field {
    Field {
        responses: rows.iter().map(|&k| field.responses[k]).collect(),
        positions_m: rows.iter().map(|&k| field.positions_m[k]).collect(),
        ground: rows.iter().map(|&k| field.ground[k]).collect(),
        velocity_m_per_s: rows.iter().map(|&k| field.velocity_m_per_s[k]).collect(),
    }
}
