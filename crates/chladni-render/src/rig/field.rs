//! A measured field laid over the operator that foretells it.

use crate::panel::drive::Drive;
use crate::panel::operator::Operator;
use crate::tolerances;
use chladni_frf::{Error, Finding, MeasuredField, Result};
use ndarray::{Array1, Array2, Axis};
use num_complex::Complex64;

/// Measured values in the order of the operator's rows.
#[derive(Clone)]
pub(crate) struct LaidField {
    /// Rows of the operator that were measured.
    pub(crate) rows: Vec<usize>,
    /// Velocities along +Z, m/s; magnitudes where phases are unknown.
    pub(crate) velocity: Array1<Complex64>,
    /// Standard deviation of each, m/s.
    pub(crate) std: Array1<f64>,
    /// The same where the file says it.
    pub(crate) stated: Vec<Option<f64>>,
    /// True where phases are unknown.
    pub(crate) magnitudes_only: bool,
    /// True where the file does not say how sure its values are.
    pub(crate) noise_assumed: bool,
}

/// The finding about a field that does not say how sure its values are.
pub(crate) fn noise_assumed() -> Finding {
    let words = format!(
        "the field does not say how sure its values are: a noise of {} % of their rms is assumed",
        100.0 * tolerances::FIELD_NOISE
    );
    Finding::caution("field-noise-assumed", words).help("add a column std, or repeats")
}

impl LaidField {
    /// Lays `field` over the responses of `operator`; `sha256` is that of the weights file.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`]: another frequency, other weights, a response
    /// that the operator lacks.
    pub(crate) fn new(
        field: &MeasuredField,
        operator: &Operator,
        sha256: Option<&str>,
    ) -> Result<Self> {
        check_weights(field, operator.frequency_hz, sha256)?;
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
        let stated: Vec<Option<f64>> = points.iter().map(|point| point.2).collect();
        Ok(Self {
            rows: points.iter().map(|point| point.0).collect(),
            std: deviations(&stated, &velocity),
            noise_assumed: stated.iter().any(Option::is_none),
            stated,
            magnitudes_only: field.magnitudes_only,
            velocity,
        })
    }

    /// Puts other values at some places, which are as sure as the rest.
    pub(crate) fn replace(&mut self, values: &[(usize, Complex64)]) {
        let is_kept = |k: &usize| values.iter().all(|(place, _)| place != k);
        let kept: Vec<f64> = (0..self.stated.len())
            .filter(is_kept)
            .filter_map(|k| self.stated[k])
            .collect();
        let square = kept.iter().map(|std| std * std).sum::<f64>() / kept.len().max(1) as f64;
        for &(place, value) in values {
            self.velocity[place] = value;
            self.stated[place] = (!kept.is_empty()).then(|| square.sqrt());
        }
        self.std = deviations(&self.stated, &self.velocity);
    }

    /// mean |v − v̂|²/(‖L·A‖² + σ²).
    ///
    /// * `deviation`: ‖L·A‖, m/s
    pub(super) fn nis(&self, predicted: &Array1<Complex64>, deviation: f64) -> f64 {
        let measured = self.phased(predicted);
        let of = |k: usize| {
            let bar = deviation.powi(2) + self.std[k].powi(2);
            (measured[k] - predicted[k]).norm_sqr() / bar
        };
        (0..measured.len()).map(of).sum::<f64>() / measured.len() as f64
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

/// Standard deviations as stated; where they are not, a share of the rms of all values.
fn deviations(stated: &[Option<f64>], velocity: &Array1<Complex64>) -> Array1<f64> {
    let size = rms(velocity);
    let assumed = tolerances::FIELD_NOISE * size;
    let least = tolerances::LEAST_FIELD_NOISE * size;
    let of = |std: &Option<f64>| std.unwrap_or(assumed).max(least);
    stated.iter().map(of).collect()
}

/// Checks that `field` is that of weights with this `sha256`, made for `asked` Hz.
fn check_weights(field: &MeasuredField, asked: f64, sha256: Option<&str>) -> Result<()> {
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
    Ok(())
}

/// Root of the mean square.
pub(crate) fn rms(values: &Array1<Complex64>) -> f64 {
    let square = values.iter().map(Complex64::norm_sqr).sum::<f64>();
    (square / values.len().max(1) as f64).sqrt()
}

/// The ingredients of a prediction of a field.
pub(crate) struct Prediction {
    /// Mobility at the measured rows.
    pub(crate) mobility: Array2<Complex64>,
    /// The drive.
    pub(crate) drive: Drive,
    /// Predicted velocities at the measured rows.
    pub(crate) velocity: Array1<Complex64>,
}

impl Prediction {
    /// The field that `operator` predicts of `drive` at the measured `rows`.
    pub(super) fn of(operator: &Operator, rows: &[usize], drive: Drive) -> Self {
        let mobility = operator.mobility.select(Axis(0), rows);
        Self {
            velocity: mobility.dot(&drive),
            mobility,
            drive,
        }
    }

    /// The part of each channel in the field of a drive, at the measured rows.
    pub(super) fn paths(&self, drive: &Drive) -> Vec<Array1<Complex64>> {
        let columns = self.mobility.columns().into_iter().zip(drive);
        columns
            .map(|(column, &weight)| column.mapv(|path| path * weight))
            .collect()
    }
}
