//! Drives in time on a calibrated rig: with the model and the scene that the calibration
//! makes.

use crate::judging::rig_draw::StressOptions;
use crate::results::weights::Weights;
use crate::rig::Calibrated;
use crate::scene::drift::Drift;
use crate::scene::scene_file::Scene;
use crate::time::indices::{TimeEvent, TimeIndices};
use crate::time::play::{self, PlayOptions, Played};
use crate::time::recorded::{self, Recorded};
use crate::time::stress::{self, TimeStressRow};
use chladni_frf::{Finding, ModalModel, Result};

/// The drive of a scene over time, on the panel of `model` as the calibration of the scene
/// knows it.
///
/// * `given`: the steady drive of the scene's own zones, where it is known; all others
///   are rendered
///
/// # Errors
/// As [`crate::render`]; events that overlap, ramps that do not fit or that the model's
/// band cannot describe, a path that leaves the judged ground, weights of other tones, of
/// another unit, or of actuators that the model lacks; a calibration that is not of this
/// model's rig.
pub fn play(
    model: &ModalModel,
    scene: &Scene,
    given: Option<&Weights>,
    options: &PlayOptions,
) -> Result<Played> {
    let rig = over(model, scene, &options.render.drift)?;
    let mut played = play::play(&rig.model, &rig.scene, given, options)?;
    played.findings.extend(rig.findings);
    Ok(played)
}

/// The indices of a signal that was made or recorded elsewhere.
///
/// # Errors
/// As [`play()`]; several tones, channels that the model lacks.
pub fn evaluate_signal(
    recorded: &Recorded,
    events: &[TimeEvent],
    scene: &Scene,
    model: &ModalModel,
) -> Result<(TimeIndices, Vec<Finding>)> {
    let rig = over(model, scene, &Drift::default())?;
    let (indices, mut findings) =
        recorded::evaluate_signal(recorded, events, &rig.scene, &rig.model)?;
    findings.extend(rig.findings);
    Ok((indices, findings))
}

/// Judges a drive in time when the panel is not the model.
///
/// # Errors
/// As [`play()`].
pub fn stress_in_time(
    played: &Played,
    scene: &Scene,
    model: &ModalModel,
    options: &StressOptions,
) -> Result<(Vec<TimeStressRow>, Vec<Finding>)> {
    let rig = over(model, scene, &options.drift)?;
    stress::stress_in_time(played, &rig.scene, &rig.model, options)
}

/// A mobility that was learned at one frequency is of no use to several tones.
fn over<'a>(model: &'a ModalModel, scene: &'a Scene, drift: &Drift) -> Result<Calibrated<'a>> {
    let at = scene.other_tones.is_empty().then_some(scene.frequency_hz);
    Calibrated::new(model, scene, at, drift)
}
