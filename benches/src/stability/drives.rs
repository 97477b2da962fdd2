//! The drives behind the maps of rendering: found in a model, judged on the true plate.

use super::trial::Trial;
use crate::scene::{condition, MeasuredPanel, ScenePanel, Served};
use chladni_frf::{Error, ErrorKind, ModalModel, Result};
use chladni_render::{render, Count, Drift, Finger, MethodChoice, RenderOptions, Rendering, Scene};
use chladni_rfp::{fit, FitOptions};
use ndarray::Array1;
use num_complex::Complex64;
use rand_chacha::rand_core::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Share of hot and of cold ground that a drive must serve; less is a failure, as in
/// `chladni demo`.
const SERVES: f64 = 0.95;
/// Drive frequency where it is not the question, Hz.
const DRIVE_HZ: f64 = 300.0;
/// Width of the transition, m.
const TRANSITION_M: f64 = 0.010;

/// A panel as it is, and as it was fitted.
pub(crate) struct Stage {
    panel: MeasuredPanel,
    model: ModalModel,
}

impl Stage {
    /// Measures and fits the glass panel.
    ///
    /// # Errors
    /// None for this panel.
    pub(crate) fn new() -> Result<Self> {
        let panel = ScenePanel::Glass.measure()?;
        let fitted = fit(&panel.frf, &FitOptions::default());
        let model = fitted
            .map_err(|error| {
                Error::new(
                    ErrorKind::Internal,
                    format!("the fit of the panel fails: {error}"),
                )
            })?
            .model;
        Ok(Self { panel, model })
    }
}

/// Rms error of the natural frequencies of the model, relative × isotropic part of the
/// drift assumed.
pub(super) fn error_ridge(
    stage: &Stage,
    method: MethodChoice,
    error: f64,
    ridge: f64,
    seed: u64,
) -> Result<Trial> {
    let mut model = stage.model.clone();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    for mode in model.modes.iter_mut().filter(|mode| mode.in_band) {
        let normal: f64 = StandardNormal.sample(&mut random);
        mode.frequency_hz *= 1.0 + error * normal;
    }
    let drift = Drift {
        isotropic_relative: ridge,
        drive_relative: Some(0.0),
        ..Drift::default()
    };
    let options = RenderOptions {
        method,
        drift,
        ..RenderOptions::default()
    };
    let scene = stage
        .panel
        .scene([2, 2], hot(4, seed), DRIVE_HZ, TRANSITION_M)?;
    stage.tried(&model, &scene, &options, |drive, rendering| {
        Ok(stage.free(drive, &scene, rendering))
    })
}

/// Drive frequency, Hz × impedance of the touch over that of a light one.
pub(super) fn frequency_touch(
    stage: &Stage,
    method: MethodChoice,
    frequency_hz: f64,
    touch: f64,
    seed: u64,
) -> Result<Trial> {
    let light = Finger::default();
    let finger = Finger {
        damping_n_s_per_m: touch * light.damping_n_s_per_m,
        mass_kg: touch * light.mass_kg,
        stiffness_n_per_m: touch * light.stiffness_n_per_m,
    };
    let scene = stage
        .panel
        .scene([2, 2], hot(4, seed), frequency_hz, TRANSITION_M)?;
    let options = RenderOptions {
        method,
        ..RenderOptions::default()
    };
    stage.tried(&stage.model, &scene, &options, |drive, rendering| {
        let mut least = stage.free(drive, &scene, rendering);
        let places = if touch > 0.0 {
            chladni_render::finger_places(&rendering.field)
        } else {
            Vec::new()
        };
        for place in places {
            let served = stage.panel.truth.touched(
                drive,
                frequency_hz,
                &finger,
                place,
                &rendering.zones,
                &rendering.limits,
            )?;
            if served.least() < least.least() {
                least = served;
            }
        }
        Ok(least)
    })
}

/// Number of actuators × cells along each side.
pub(super) fn actuators_zones(
    stage: &Stage,
    method: MethodChoice,
    actuators: f64,
    cells: f64,
    seed: u64,
) -> Result<Trial> {
    let side = cells as usize;
    let scene = stage
        .panel
        .scene([side, side], hot(side * side, seed), DRIVE_HZ, TRANSITION_M)?;
    let options = RenderOptions {
        method,
        actuators: Count::Number(actuators as usize),
        ..RenderOptions::default()
    };
    stage.tried(&stage.model, &scene, &options, |drive, rendering| {
        Ok(stage.free(drive, &scene, rendering))
    })
}

/// The hot one of so many cells.
fn hot(cells: usize, seed: u64) -> usize {
    // seven is prime to all numbers of cells here, so that few seeds visit far places
    1 + (7 * seed as usize) % cells
}

impl Stage {
    fn free(&self, drive: &Array1<Complex64>, scene: &Scene, rendering: &Rendering) -> Served {
        self.panel.truth.free(
            drive,
            scene.frequency_hz,
            &rendering.zones,
            &rendering.limits,
        )
    }

    /// A drive found in `model` and judged.
    fn tried(
        &self,
        model: &ModalModel,
        scene: &Scene,
        options: &RenderOptions,
        judge: impl Fn(&Array1<Complex64>, &Rendering) -> Result<Served>,
    ) -> Result<Trial> {
        let rendering = match render(model, scene, options) {
            Ok(rendering) => rendering,
            Err(error) => {
                let [chi2, ill, error_over_bound, worst] = [f64::NAN; 4];
                let refused = Trial {
                    missed: 1,
                    refused: true,
                    warnings: vec![error.to_string()],
                    ..Trial::default()
                };
                return Ok(Trial {
                    chi2,
                    condition: ill,
                    error_over_bound,
                    error: worst,
                    ..refused
                });
            }
        };
        let weights = &rendering.weights;
        let drive: Array1<Complex64> = weights
            .weights
            .iter()
            .map(|weight| weight.value())
            .collect();
        let least = judge(&drive, &rendering)?.least();
        // what is said of baselines as such tells nothing of this scene
        let warnings = weights
            .findings
            .iter()
            .filter(|finding| finding.code != "baseline-method")
            .map(ToString::to_string)
            .collect();
        Ok(Trial {
            found: usize::from(least >= SERVES),
            missed: usize::from(least < SERVES),
            trusted: weights.feasible,
            warnings,
            chi2: weights.kappa.unwrap_or(f64::NAN),
            condition: condition(model, &drive, scene.frequency_hz),
            error_over_bound: f64::NAN,
            error: least,
            ..Trial::default()
        })
    }
}
