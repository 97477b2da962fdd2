//! A model and a scene as a calibration makes them.
//!
//! Gains go into participations and residual terms, poles into the modes, and what the
//! mobility is beside them at a measured frequency into a residual term of its own: one
//! model that knows the rig, so that no solver needs to. The scene that goes with it has no
//! calibration, drives no dead channel, and states the errors that are left.

use super::calibration::{CalibratedOperator, Calibration};
use crate::scene::actuators::Actuators;
use crate::scene::drift::Drift;
use crate::scene::scene_file::Scene;
use crate::tolerances;
use chladni_frf::{ComplexMatrix, Dof, Error, Finding, FrfKind, ModalModel, ResidualTerm, Result};
use ndarray::Array2;
use num_complex::Complex64;
use std::borrow::Cow;
use std::f64::consts::TAU;

/// A model and a scene that know the rig.
pub(crate) struct Calibrated<'a> {
    pub(crate) model: Cow<'a, ModalModel>,
    pub(crate) scene: Cow<'a, Scene>,
    /// Everything the user should know.
    pub(crate) findings: Vec<Finding>,
}

impl<'a> Calibrated<'a> {
    /// `model` under the calibration and the dead channels of `scene`, at one frequency;
    /// `drift` holds where the scene gives none.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`]: a dead channel or a gain of an actuator that the
    /// model lacks, another unit, no actuator left.
    pub(crate) fn new(
        model: &'a ModalModel,
        scene: &'a Scene,
        frequency_hz: Option<f64>,
        drift: &Drift,
    ) -> Result<Self> {
        let actuators = &scene.actuators;
        let Some(calibration) = actuators.calibration.as_deref() else {
            return Self::uncalibrated(model, scene);
        };
        let dead = dead_of(actuators);
        let mut rig = model.clone();
        let of_file = |error: Error| match &actuators.calibration_file {
            Some(file) => error.file(file),
            None => error,
        };
        scale(&mut rig, calibration).map_err(of_file)?;
        if let Some(hz) = frequency_hz {
            take_tables(&mut rig, calibration, hz).map_err(of_file)?;
        }
        let same_model = move_poles(&mut rig, calibration);
        let known = frequency_hz
            .filter(|_| same_model)
            .and_then(|hz| calibration.at(hz));
        if let Some(known) = known {
            rig.residual_terms.terms.push(remainder(&rig, known));
        }
        silence(&mut rig, &dead)?;
        let mut scene = without_dead(model, scene, &dead)?;
        let gain_error = calibration.gain_error(frequency_hz.unwrap_or(scene.frequency_hz));
        if frequency_hz.is_none() && !calibration.gain_tables.is_empty() {
            scene.tone_gains = actuators.calibration.clone();
        }
        match known {
            Some(known) if scene.drift.is_none() => scene.learned = Some(known.clone().into()),
            _ => {}
        }
        if gain_error.is_some() {
            let asked = scene.drift.unwrap_or(*drift);
            scene.drift = Some(Drift {
                drive_relative: asked.drive_relative.or(gain_error),
                ..asked
            });
        }
        let findings = applied(calibration, known, same_model)
            .into_iter()
            .chain(calibration.scan_finding())
            .collect();
        Ok(Self {
            model: Cow::Owned(rig),
            scene: Cow::Owned(scene),
            findings,
        })
    }

    /// The same of a scene that names no calibration.
    fn uncalibrated(model: &'a ModalModel, scene: &'a Scene) -> Result<Self> {
        let dead = &scene.actuators.dead;
        if dead.is_empty() {
            return Ok(Self {
                model: Cow::Borrowed(model),
                scene: Cow::Borrowed(scene),
                findings: Vec::new(),
            });
        }
        let mut model = model.clone();
        silence(&mut model, dead)?;
        let scene = without_dead(&model, scene, dead)?;
        Ok(Self {
            model: Cow::Owned(model),
            scene: Cow::Owned(scene),
            findings: Vec::new(),
        })
    }
}

/// Dead channels that the scene or its calibration names.
pub(crate) fn dead_of(actuators: &Actuators) -> Vec<Dof> {
    let learned = actuators.calibration.iter().flat_map(|known| &known.dead);
    let mut dead = actuators.dead.clone();
    for dof in learned {
        if !dead.iter().any(|known| known.same_axis(*dof)) {
            dead.push(*dof);
        }
    }
    dead
}

/// The factor of a channel on its weight at a frequency, as the scene knows it.
///
/// # Errors
/// A frequency that the gain table of the channel does not cover.
pub(crate) fn gain_of(
    actuators: &Actuators,
    reference: Dof,
    frequency_hz: f64,
) -> Result<Complex64> {
    if actuators.dead.iter().any(|dead| dead.same_axis(reference)) {
        return Ok(Complex64::ZERO);
    }
    let Some(known) = actuators.calibration.as_deref() else {
        return Ok(Complex64::ONE);
    };
    let of_table = known.table_gain_of(reference, frequency_hz);
    let of_table = of_table.map_err(|error| match &actuators.calibration_file {
        Some(file) => error.file(file),
        None => error,
    })?;
    Ok(known.gain_of(reference) * of_table)
}

/// The model as one of several tones finds it: with the gains at its frequency.
///
/// # Errors
/// A frequency that a gain table does not cover.
pub(crate) fn at_tone<'a>(model: &'a ModalModel, tone: &Scene) -> Result<Cow<'a, ModalModel>> {
    let Some(calibration) = tone.tone_gains.as_deref() else {
        return Ok(Cow::Borrowed(model));
    };
    let mut model = model.clone();
    take_tables(&mut model, calibration, tone.frequency_hz)?;
    Ok(Cow::Owned(model))
}

/// The scene without calibration and without dead channels.
fn without_dead(model: &ModalModel, scene: &Scene, dead: &[Dof]) -> Result<Scene> {
    let lives = |dof: &Dof| !dead.iter().any(|dead| dead.same_axis(*dof));
    let only = match (&scene.actuators.only, dead.is_empty()) {
        (only, true) => only.clone(),
        (Some(only), false) => Some(only.iter().copied().filter(lives).collect()),
        (None, false) => Some(model.references.iter().copied().filter(lives).collect()),
    };
    if only.as_ref().is_some_and(Vec::is_empty) {
        return Err(Error::bad_data("every actuator that may be used is dead")
            .field("actuators.dead")
            .found(format!("channels that are dead: {}", dead.len()))
            .expected("at least one that moves the panel"));
    }
    Ok(Scene {
        actuators: Actuators {
            only,
            dead: Vec::new(),
            calibration: None,
            calibration_file: None,
            ..scene.actuators.clone()
        },
        ..scene.clone()
    })
}

fn column(model: &ModalModel, reference: Dof, field: &str) -> Result<usize> {
    let place = model
        .references
        .iter()
        .position(|known| known.same_axis(reference));
    place.ok_or_else(|| {
        Error::bad_data("the model has no such actuator")
            .field(field)
            .found(reference)
            .expected(format!("one of its {} references", model.references.len()))
            .help("give the calibration and the dead channels of this rig")
    })
}

/// Multiplies what an actuator does.
fn multiply(model: &mut ModalModel, column: usize, gain: Complex64) {
    for mode in &mut model.modes {
        mode.participation.0[column] *= gain;
    }
    for term in &mut model.residual_terms.terms {
        term.matrix
            .0
            .column_mut(column)
            .mapv_inplace(|value| value * gain);
    }
}

/// Takes away what dead channels do.
fn silence(model: &mut ModalModel, dead: &[Dof]) -> Result<()> {
    for &dof in dead {
        let column = column(model, dof, "actuators.dead")?;
        multiply(model, column, Complex64::ZERO);
    }
    Ok(())
}

/// Multiplies what the actuators do by the gains of their tables at a frequency.
fn take_tables(model: &mut ModalModel, calibration: &Calibration, hz: f64) -> Result<()> {
    for table in &calibration.gain_tables {
        if let Some(reference) = table.reference {
            column(model, reference, "actuators.calibration")?;
        }
    }
    if calibration.gain_tables.is_empty() {
        return Ok(());
    }
    for (column, reference) in model.references.clone().into_iter().enumerate() {
        multiply(model, column, calibration.table_gain_of(reference, hz)?);
    }
    Ok(())
}

/// Multiplies what the actuators do by their gains at every frequency.
fn scale(model: &mut ModalModel, calibration: &Calibration) -> Result<()> {
    let unit = calibration.unit.unwrap_or(model.reference_unit);
    if unit != model.reference_unit {
        return Err(Error::bad_data("the calibration is in another unit")
            .field("actuators.calibration")
            .found(unit)
            .expected(format!(
                "{}, the unit of the references",
                model.reference_unit
            ))
            .help("give the calibration of this rig"));
    }
    for gain in &calibration.gains {
        let column = column(model, gain.reference, "actuators.calibration")?;
        multiply(model, column, calibration.gain_of(gain.reference));
    }
    Ok(())
}

/// Moves the modes to where the calibration has them; false, and nothing moved, where the
/// model has other modes.
fn move_poles(model: &mut ModalModel, calibration: &Calibration) -> bool {
    let place = |hz: f64| {
        let modes = model.modes.iter();
        let is_same = |known: f64| (known - hz).abs() <= tolerances::SAME_MODE * hz;
        modes.clone().position(|mode| is_same(mode.frequency_hz))
    };
    let places: Option<Vec<usize>> = calibration
        .modes
        .iter()
        .map(|mode| place(mode.model_hz))
        .collect();
    let Some(places) = places else {
        return false;
    };
    for (place, known) in places.into_iter().zip(&calibration.modes) {
        let mode = &mut model.modes[place];
        mode.frequency_hz = known.frequency_hz;
        mode.loss_factor = known.loss_factor;
        mode.damping_ratio = 0.5 * known.loss_factor;
    }
    true
}

/// The mobility that fields taught, less that of the model, as a term of its receptance.
fn remainder(model: &ModalModel, known: &CalibratedOperator) -> ResidualTerm {
    let own = model.frf_matrix(FrfKind::Mobility, known.frequency_hz);
    let receptance = Complex64::new(0.0, TAU * known.frequency_hz).inv();
    let place = |list: &[Dof], dof: &Dof| list.iter().position(|known| known.same_axis(*dof));
    let rows: Vec<Option<usize>> = model
        .responses
        .iter()
        .map(|dof| place(&known.responses, dof))
        .collect();
    let columns: Vec<Option<usize>> = model
        .references
        .iter()
        .map(|dof| place(&known.references, dof))
        .collect();
    let matrix = Array2::from_shape_fn(own.dim(), |(i, j)| match (rows[i], columns[j]) {
        (Some(row), Some(column)) => {
            let along_z = known.mobility.0[[row, column]] * model.responses[i].direction.sign();
            (along_z - own[[i, j]]) * receptance
        }
        _ => Complex64::ZERO,
    });
    ResidualTerm {
        power: 0,
        matrix: ComplexMatrix(matrix),
    }
}

/// The finding on what was taken from the calibration; `None` for one that holds nothing.
fn applied(
    calibration: &Calibration,
    known: Option<&CalibratedOperator>,
    same_model: bool,
) -> Option<Finding> {
    let tables = match calibration.gain_tables.len() {
        0 => "",
        _ => ", and the gain tables",
    };
    let dead = calibration.dead.iter().copied();
    if calibration.fields == 0 {
        let has_gains = !calibration.gains.is_empty() || !calibration.gain_tables.is_empty();
        let has_others = !calibration.dead.is_empty() || !calibration.modes.is_empty();
        let words = match has_gains {
            true => "the gains of the channels are those of the calibration, at each frequency",
            false => "the dead channels and natural frequencies are those of the calibration",
        };
        return (has_gains || has_others).then(|| Finding::note("calibrated", words).dofs(dead));
    }
    let fields = match calibration.fields {
        1 => "one measured field".to_owned(),
        count => format!("{count} measured fields"),
    };
    if !same_model {
        let words = format!(
            "the calibration from {fields} belongs to another model: its gains and dead channels \
             hold, its natural frequencies do not"
        );
        let finding = Finding::caution("calibration-of-another-model", words);
        let help = "correct again with this model, and take the new calibration";
        return Some(finding.help(help));
    }
    let parts = match known {
        Some(_) => "gains, natural frequencies and the mobility at this frequency",
        None => "gains and natural frequencies; no field was measured at this frequency",
    };
    let words = format!("calibrated by {fields}: {parts}{tables}");
    Some(Finding::note("calibrated", words).dofs(dead))
}

/// In-band modes that count, by their numbers in the model.
pub(crate) fn movable_modes(model: &ModalModel) -> Vec<usize> {
    let counts = |n: &usize| model.modes[*n].counts();
    (0..model.modes.len()).filter(counts).collect()
}
