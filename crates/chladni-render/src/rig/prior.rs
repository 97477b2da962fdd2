//! Error that a prediction may have before any new field.

use crate::panel::covariance::Covariance;
use crate::panel::operator::Operator;
use crate::scene::drift::Drift;
use crate::scene::scene_file::Scene;
use crate::tolerances;
use chladni_frf::{ModalModel, Result};

/// The drift that a prediction has: of a rig whose gains nobody has measured at least the
/// usual error of amplifiers.
///
/// * `asked`, `scene`: the scene as it was given, and as its calibration makes it
pub(crate) fn prior_drift(asked: &Scene, scene: &Scene, default: Drift) -> Drift {
    let drift = scene.drift.unwrap_or(default);
    let calibration = asked.actuators.calibration.as_deref();
    match calibration.and_then(|known| known.gain_error(asked.frequency_hz)) {
        Some(_) => drift,
        None => drift.with_drive_error(tolerances::RIG_DRIVE_ERROR),
    }
}

/// Error of a prediction before any new field: what earlier fields have left, or that of
/// the model under `drift`.
///
/// # Errors
/// Those of the factorisation.
pub(crate) fn design(
    model: &ModalModel,
    operator: &Operator,
    scene: &Scene,
    drift: &Drift,
) -> Result<Covariance> {
    let learned = scene.learned.as_deref();
    if let Some(gram) = learned.and_then(|known| known.covariance_of(operator)) {
        return Covariance::of_gram(gram);
    }
    let all: Vec<usize> = (0..operator.responses.len()).collect();
    Ok(Covariance::of_model(model, operator, &all, drift))
}
