//! Poles of a model, moved to where measured fields have them; shapes are kept.
//!
//! One frequency tells little of a pole by itself, and nothing of one far away: what all
//! modes share is what a field tells (temperature). So the structured update (theory.md,
//! eq. 58) is asked, in which every channel may err as amplifiers do and every mode may
//! move beside the others. The study found the common shift to 1 to 3e-4.

use super::agreement::Likeness;
use super::calibrated::movable_modes;
use super::evidence::Tried;
use super::field::{noise_assumed, LaidField};
use super::lone_points::without_lone_points;
use super::parts::Parts;
use super::played_field::PlayedField;
use super::seen::Seen;
use super::structured::Structured;
use crate::panel::drive::Drive;
use crate::panel::operator::Operator;
use crate::results::weights::{Weight, Weights};
use crate::tolerances;
use chladni_frf::{Error, Finding, ModalModel, Result};
use ndarray::Axis;

/// A model with poles as fields tell them.
#[derive(Debug, Clone)]
#[must_use]
#[non_exhaustive]
pub struct PolesOfFields {
    /// The model: shapes and residual terms as before.
    pub model: ModalModel,
    /// Relative shift that all natural frequencies share.
    pub common_shift: f64,
    /// Its standard deviation.
    pub common_shift_std: f64,
    /// Rms of the single shifts about the common one.
    pub own_shifts_rms: f64,
}

/// Moves the poles of `model` to where the fields have them, each measured while its
/// weights played, all at one frequency.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`]: no field; weights of several frequencies, of
/// actuators or in a unit that the model lacks; a field of other weights or in another unit;
/// a model without modes in its band.
pub fn poles_of_fields(model: &ModalModel, played: &[PlayedField]) -> Result<PolesOfFields> {
    let Some(first) = played.first() else {
        return Err(Error::bad_data("no field to follow")
            .field("field")
            .found("none")
            .expected("at least one pair of weights and measured field")
            .help("play weights, measure the field, and give both"));
    };
    let frequency_hz = first.weights.frequency_hz;
    let operator = Operator::of_model(model, frequency_hz, None)?;
    let (mut findings, mut assumed) = (Vec::new(), false);
    let mut seen = Vec::with_capacity(played.len());
    for pair in played {
        let drive = drive_of(&pair.weights, &operator, frequency_hz)?;
        let mut field = LaidField::new(&pair.field, &operator, pair.weights_sha256.as_deref())?;
        let mobility = operator.mobility.select(Axis(0), &field.rows);
        findings.extend(without_lone_points(
            &mut field,
            &mobility,
            &operator.responses,
        )?);
        let predicted = mobility.dot(&drive);
        let likeness = Likeness::of(&predicted, &field);
        likeness.check()?;
        findings.extend(likeness.finding());
        assumed |= field.noise_assumed;
        seen.push(Seen::of(field, drive));
    }
    if assumed {
        findings.push(noise_assumed());
    }
    let parts = Parts::new(model, &operator);
    if parts.modes() == 0 {
        return Err(Error::bad_data("the model has no mode to follow")
            .field("modes")
            .found("none in the band")
            .expected("at least one mode")
            .help("give a model whose band holds the modes near the drive"));
    }
    let told = parts.update(&seen, None, &Tried::OF_SHIFT)?;
    let mut moved = model.clone();
    for (k, n) in movable_modes(model).into_iter().enumerate() {
        let mode = &mut moved.modes[n];
        let (hz, loss_factor) = told.moved_pole(k, mode, model.damping, frequency_hz);
        mode.frequency_hz = hz;
        mode.frequency_std_hz = mode.frequency_std_hz.hypot(hz * told.shift_std[k]);
        mode.damping_ratio = loss_factor / 2.0;
        // (1 + δ)² turns the square of ω_n by twice the imaginary part
        mode.loss_factor_std = mode.loss_factor_std.hypot(2.0 * told.damping_std[k]);
        mode.loss_factor = loss_factor;
    }
    let own = told
        .shifts
        .iter()
        .map(|shift| (shift.re - told.common).powi(2));
    let mut found = PolesOfFields {
        common_shift: told.common,
        common_shift_std: told.common_std,
        own_shifts_rms: (own.sum::<f64>() / told.shifts.len() as f64).sqrt(),
        model: moved,
    };
    findings.push(followed(&found, seen.len()));
    findings.extend(unexplained(&told));
    found.model.quality.findings.extend(findings);
    Ok(found)
}

/// The drive of some weights, one for each actuator of the operator.
fn drive_of(weights: &Weights, operator: &Operator, frequency_hz: f64) -> Result<Drive> {
    let apart = (weights.frequency_hz - frequency_hz).abs();
    if apart > tolerances::SAME_FREQUENCY * frequency_hz || !weights.other_tones.is_empty() {
        return Err(Error::bad_data("the weights are for several frequencies")
            .field("weights.frequency_hz")
            .found(format!("{} Hz", weights.frequency_hz))
            .expected(format!("{frequency_hz} Hz, as the first"))
            .help("follow the poles by fields of one frequency at a time"));
    }
    if weights.unit() != operator.unit {
        return Err(Error::bad_data("the weights are in another unit")
            .field("weights.unit")
            .found(weights.unit())
            .expected(format!("{}, the unit of the model", operator.unit))
            .help("give the weights that were rendered with this model"));
    }
    let is_unknown = |weight: &&Weight| {
        let mut references = operator.references.iter();
        !references.any(|reference| reference.same_axis(weight.reference))
    };
    if let Some(unknown) = weights.weights.iter().find(is_unknown) {
        return Err(Error::bad_data("the model has no such actuator")
            .field("weights")
            .found(unknown.reference)
            .expected(format!(
                "one of its {} references",
                operator.references.len()
            ))
            .help("give the weights that were rendered with this model"));
    }
    Ok(weights.at(&operator.references).into())
}

/// The finding of how far the poles moved.
fn followed(found: &PolesOfFields, fields: usize) -> Finding {
    let count = match fields {
        1 => "one measured field".to_string(),
        _ => format!("{fields} measured fields"),
    };
    let words = format!(
        "poles of a model, followed by {count}: natural frequencies moved by {:+.4} % together (± {:.4} \
         %), and by {:.4} % rms each",
        100.0 * found.common_shift,
        100.0 * found.common_shift_std,
        100.0 * found.own_shifts_rms
    );
    Finding::note("poles-followed", words)
        .value("common_shift", found.common_shift)
        .value("common_shift_std", found.common_shift_std)
        .value("own_shifts_rms", found.own_shifts_rms)
}

/// The finding of fields that moved poles do not explain.
fn unexplained(told: &Structured) -> Option<Finding> {
    let share = told.scales.unexplained;
    (share >= tolerances::SCAN_UNEXPLAINED).then(|| {
        let words = format!(
            "gains and moved poles leave {:.0} % of the mobility unexplained: the shapes are no \
             longer those of the model",
            100.0 * share
        );
        Finding::caution("shapes-changed", words)
            .value("unexplained", share)
            .help("scan again, and fit that")
    })
}
