//! One tone of a play: the panel about its carrier, the steady drive of every place, and
//! how the drive passes from one to the next.

use crate::evaluate::drive_on;
use crate::methods::robust;
use crate::operator::Operator;
use crate::options::RenderOptions;
use crate::problem::{Drive, DriveLimits};
use crate::render::render;
use crate::scene::{Limits, Scene};
use crate::setup::{check_ground, drive_limits, Setup};
use crate::time::causal::CausalModel;
use crate::time::modal_ramp::{corrected, correction};
use crate::time::plan::Place;
use crate::time::programs::Programs;
use crate::time::timeline::zones_of;
use crate::weights::Weights;
use chladni_frf::{Finding, ModalModel, Result};
use ndarray::Array2;
use num_complex::Complex64;

/// One tone.
pub(crate) struct Voice {
    pub(crate) frequency_hz: f64,
    pub(crate) operator: Operator,
    pub(crate) model: CausalModel,
    pub(crate) limits: Limits,
    pub(crate) drive_limits: DriveLimits,
    /// Steady drive of each place; axes (place, actuator).
    pub(crate) patterns: Array2<Complex64>,
    /// K times it; the same axes.
    pub(crate) corrections: Array2<Complex64>,
    /// Velocity of the responses under them; axes (response, place).
    pub(crate) steady: Array2<Complex64>,
    /// Programs that were solved.
    pub(crate) programs: Programs,
    /// Findings on the steady drives.
    pub(crate) findings: Vec<Finding>,
}

impl Voice {
    /// The tone of `scene`, with the steady drives of `places`.
    ///
    /// * `given`: those of the scene's own zones, where they are known
    ///
    /// # Errors
    /// As [`crate::render`].
    pub(crate) fn new(
        model: &ModalModel,
        scene: &Scene,
        places: &[Place],
        given: Option<&Weights>,
        options: &RenderOptions,
    ) -> Result<Self> {
        let mut findings = Vec::new();
        let operator =
            Operator::of_model(model, scene.frequency_hz, scene.actuators.only.as_deref())?;
        let mut patterns = Array2::zeros((places.len(), operator.references.len()));
        let (drive_limits, _) = drive_limits(scene, operator.unit)?;
        let mut before: Option<Drive> = None;
        for (place, mut row) in places.iter().zip(patterns.rows_mut()) {
            let asked = match place {
                Place::Spot(spot) => Place::Spot(spot.for_passing()),
                other => other.clone(),
            };
            let there = Scene {
                zones: zones_of(&asked, &scene.zones),
                time: None,
                ..scene.clone()
            };
            let drive = match (place, given, &before) {
                (Place::Scene, Some(weights), _) => {
                    check_ground(&there, &operator)?;
                    drive_on(&operator, weights)
                }
                (Place::Spot(_), _, Some(before)) => {
                    let setup = Setup::new(model, &there, &options.drift)?;
                    robust::follow(&setup, before, options.effort)?
                }
                _ => {
                    let weights = render(model, &there, options)?.weights;
                    if !weights.feasible {
                        findings.extend(weights.findings.iter().cloned());
                    }
                    drive_on(&operator, &weights)
                }
            };
            if matches!(place, Place::Spot(_)) {
                before = Some(drive.clone());
            }
            row.assign(&drive);
        }
        let causal = CausalModel::new(model, &operator)?;
        let corrections = corrected(&correction(&causal)?, &patterns);
        Ok(Self {
            frequency_hz: scene.frequency_hz,
            steady: causal.steady(patterns.view()),
            programs: Programs::default(),
            model: causal,
            limits: scene.limits()?,
            drive_limits,
            operator,
            patterns,
            corrections,
            findings,
        })
    }
}
