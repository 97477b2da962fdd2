//! Choice of the drive frequency: κ and success over a range, free and touched.
//!
//! A mode on the drive frequency makes loud fields cheap and breaks them at the first
//! touch: the finger moves that mode. Between modes the same scene costs more force and
//! holds.

use crate::methods::choice::{Decision, MethodChoice};
use crate::methods::options::RenderOptions;
use crate::panel::drive::Drive;
use crate::panel::finger::{finger_rows, Finger};
use crate::panel::modal_field::ModalField;
use crate::panel::operator::{is_in_band, mode_on};
use crate::problems::setup::Setup;
use crate::rig::Calibrated;
use crate::scene::scene_file::Scene;
use crate::tolerances;
use crate::touch::{touched_kappa, Touch};
use chladni_frf::{Error, ErrorKind, ModalModel, Result};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// A frequency of the sweep.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SweptFrequency {
    /// Hz.
    pub frequency_hz: f64,
    /// κ of the drive there; `None` without any model error.
    pub kappa: Option<f64>,
    /// Share of responses inside their limits in the model.
    pub success_ratio: f64,
    /// The least share with a finger at each of three places in the hot zone; `None`
    /// where the model is not mass-scaled.
    pub touched_ratio: Option<f64>,
    /// κ under the fingers of the scene; `None` where it expects none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub touched_kappa: Option<f64>,
    /// Largest weight, N or V.
    pub largest_drive: f64,
    /// The mode whose bandwidth holds this frequency, Hz.
    pub on_mode_hz: Option<f64>,
}

/// A sweep and what it suggests.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[must_use]
#[non_exhaustive]
pub struct FrequencySweep {
    /// Rising.
    pub frequencies: Vec<SweptFrequency>,
    /// The best of them in the fitted band. Where every response is served at some of them: of
    /// these the one with most responses under a finger, or the largest κ under the fingers of
    /// the scene; else the one that serves most. Among equals the largest κ. `None` where no
    /// response is served anywhere in the band.
    pub suggested_hz: Option<f64>,
    /// True where none of them lies in the fitted band.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub outside_band: bool,
}

/// Renders `scene` at frequencies from `low_hz` to `high_hz`, 2 Hz apart, by `mls` unless
/// another method is asked for; all actuators, all modes. Frequencies of which its threshold
/// says nothing are left out.
///
/// # Errors
/// As [`crate::render`]; an empty range, or one wider than 1000 Hz; a scene with several tones.
pub fn sweep(
    model: &ModalModel,
    scene: &Scene,
    options: &RenderOptions,
    [low_hz, high_hz]: [f64; 2],
) -> Result<FrequencySweep> {
    if !scene.other_tones.is_empty() {
        return Err(scene.blame(
            Error::new(ErrorKind::Usage, "a sweep looks for one frequency")
                .field("frequency_hz")
                .found(format!("{} tones in the scene", scene.tones().len()))
                .expected("one frequency")
                .help("sweep a scene with one of them"),
        ));
    }
    let steps = (high_hz - low_hz) / tolerances::SWEEP_STEP_HZ;
    let rises = high_hz > low_hz;
    if !(low_hz > 0.0 && rises && steps <= tolerances::MOST_SWEPT) {
        let help = match (low_hz > 0.0, rises) {
            (false, _) => "write LO above 0",
            (true, false) => {
                "write the lower frequency first, as in `sweep 290:310`; for one frequency alone \
                 leave `sweep` out and set `frequency_hz` of the scene"
            }
            (true, true) => "narrow the range, or sweep it in parts",
        };
        return Err(
            Error::new(ErrorKind::Usage, "no usable range of frequencies")
                .field("sweep")
                .found(format!("{low_hz}:{high_hz}"))
                .expected(format!(
                    "LO:HI in Hz, above 0, rising, at most {} Hz wide",
                    tolerances::MOST_SWEPT * tolerances::SWEEP_STEP_HZ
                ))
                .help(help),
        );
    }
    let frequencies = (0..=steps as usize).map(|k| low_hz + tolerances::SWEEP_STEP_HZ * k as f64);
    let mut frequencies: Vec<f64> = frequencies.collect();
    let limits = |frequency_hz: f64| {
        let there = Scene {
            frequency_hz,
            ..scene.clone()
        };
        there.limits()
    };
    frequencies.retain(|&hz| limits(hz).is_ok());
    if frequencies.is_empty() {
        limits(low_hz).map_err(|error| scene.blame(error))?;
    }
    let frequencies = frequencies
        .into_par_iter()
        .map(|frequency_hz| at(model, scene, options, frequency_hz))
        .collect::<Result<Vec<_>>>()?;
    Ok(FrequencySweep {
        suggested_hz: suggested_hz(model, &frequencies),
        outside_band: !frequencies
            .iter()
            .any(|f| is_in_band(model, f.frequency_hz)),
        frequencies,
    })
}

impl FrequencySweep {
    /// The suggested frequency, if there is one.
    pub fn suggestion(&self) -> Option<&SweptFrequency> {
        let is_suggested = |f: &&SweptFrequency| Some(f.frequency_hz) == self.suggested_hz;
        self.frequencies.iter().find(is_suggested)
    }
}

impl SweptFrequency {
    /// True where every response keeps its limit.
    pub fn is_met(&self) -> bool {
        self.success_ratio == 1.0
    }
}

/// The best of some frequencies: see [`FrequencySweep::suggested_hz`].
fn suggested_hz(model: &ModalModel, frequencies: &[SweptFrequency]) -> Option<f64> {
    let in_band = || {
        let frequencies = frequencies.iter();
        frequencies.filter(|f| is_in_band(model, f.frequency_hz))
    };
    let some_met = in_band().any(SweptFrequency::is_met);
    let key = |f: &SweptFrequency| {
        let touched = f.touched_kappa.or(f.touched_ratio).filter(|_| some_met);
        let kappa = f.kappa.unwrap_or(f64::INFINITY);
        [touched.unwrap_or(f.success_ratio), kappa]
    };
    let better = |best: &SweptFrequency, f: &SweptFrequency| {
        let (a, b) = (key(f), key(best));
        a[0] > b[0] + tolerances::SAME_SUCCESS
            || ((a[0] - b[0]).abs() <= tolerances::SAME_SUCCESS && a[1] > b[1])
    };
    let best = in_band().filter(|f| f.is_met() || !some_met).fold(
        None,
        |best: Option<&SweptFrequency>, f| match best {
            Some(best) if !better(best, f) => Some(best),
            _ => Some(f),
        },
    );
    best.filter(|best| best.success_ratio > 0.0)
        .map(|best| best.frequency_hz)
}

fn at(
    model: &ModalModel,
    scene: &Scene,
    options: &RenderOptions,
    frequency_hz: f64,
) -> Result<SweptFrequency> {
    let scene = Scene {
        frequency_hz,
        ..scene.clone()
    };
    let Calibrated { model, scene, .. } =
        Calibrated::new(model, &scene, Some(frequency_hz), &options.drift)?;
    let (model, scene) = (&*model, &*scene);
    let setup = Setup::new(model, scene, &options.drift)?;
    let method = match options.method {
        MethodChoice::Default => MethodChoice::Only(crate::methods::method::Method::Mls),
        other => other,
    };
    let Decision { method, effort, .. } = method.decide(&setup.problem, options.effort);
    let drive = method.solve(&setup, model, effort, options.cut)?.drive;
    let score = setup.problem.score(&drive);
    Ok(SweptFrequency {
        frequency_hz,
        kappa: Some(score.kappa).filter(|kappa| kappa.is_finite()),
        success_ratio: score.success_ratio,
        touched_ratio: touched_ratio(&setup, model, &drive),
        touched_kappa: match &setup.touch {
            Some(plan) => Some(touched_kappa(&setup, plan, &drive)?),
            None => None,
        },
        largest_drive: drive.iter().map(|weight| weight.norm()).fold(0.0, f64::max),
        on_mode_hz: mode_on(model, frequency_hz),
    })
}

/// The least share of judged responses served with a finger in the hot zone.
fn touched_ratio(setup: &Setup, model: &ModalModel, drive: &Drive) -> Option<f64> {
    let field = crate::panel::field::Field::new(&setup.operator, &setup.zones, drive);
    let modal = ModalField::new(model, &setup.operator, drive);
    let mut least = None;
    for row in finger_rows(&field) {
        let touched = modal.touched(&Finger::default(), row)?;
        let levels = &setup.problem.rows.levels;
        let amplitudes = setup
            .judged
            .iter()
            .zip(levels)
            .map(|(&k, level)| touched[k].norm() / level)
            .collect();
        let (hot, cold) = setup.problem.counts(&amplitudes, 1.0);
        let ratio = (hot + cold) as f64 / amplitudes.len() as f64;
        least = Some(least.map_or(ratio, |least: f64| least.min(ratio)));
    }
    least
}

/// A frequency near that of the scene at which a firmer finger is tolerated, Hz, with the κ there
/// and the name of the fingertip. It is the best of the few frequencies at which a finger
/// takes least of its own motion.
///
/// * `firmest`: the firmest fingertip that is tolerated at the scene's own frequency
pub(crate) fn less_sensitive_frequency(
    model: &ModalModel,
    scene: &Scene,
    options: &RenderOptions,
    firmest: Option<&str>,
) -> Result<Option<(f64, f64, String)>> {
    let Some(touch) = &scene.touch else {
        return Ok(None);
    };
    let touch = touch.softest_first(scene.frequency_hz);
    for softest in (1..=touch.impedances.len()).rev() {
        let name = &touch.impedances[softest - 1].name;
        if Some(name.as_str()) == firmest {
            break;
        }
        let mut asked = scene.clone();
        asked.touch = Some(Touch {
            impedances: touch.impedances[..softest].to_vec(),
            ..touch.clone()
        });
        let tried = still_frequencies(model, &asked, options)?
            .into_par_iter()
            .map(|hz| at(model, &asked, options, hz))
            .collect::<Result<Vec<_>>>()?;
        let tolerated = tried
            .iter()
            .filter_map(|f| Some((f.frequency_hz, f.touched_kappa?)));
        let enough = tolerated.filter(|(_, kappa)| *kappa >= touch.kappa_least);
        if let Some((hz, kappa)) = enough.max_by(|a, b| a.1.total_cmp(&b.1)) {
            return Ok(Some((hz, kappa, name.clone())));
        }
    }
    Ok(None)
}

/// Frequencies near that of the scene where a finger takes least of its own motion, Hz.
fn still_frequencies(
    model: &ModalModel,
    scene: &Scene,
    options: &RenderOptions,
) -> Result<Vec<f64>> {
    let [reach, step] = tolerances::TOUCH_SEARCH_HZ;
    let steps = (reach / step) as i32;
    let mut candidates: Vec<(f64, f64)> = Vec::new();
    for k in (-steps..=steps).filter(|&k| k != 0) {
        let frequency_hz = scene.frequency_hz + f64::from(k) * step;
        let there = Scene {
            frequency_hz,
            ..scene.clone()
        };
        let calibration = scene.actuators.calibration.as_deref();
        let covered = calibration.is_none_or(|known| known.covers(frequency_hz));
        if !is_in_band(model, frequency_hz) || !covered || there.limits().is_err() {
            continue;
        }
        let setup = Setup::new(model, &there, &options.drift)?;
        if let Some(plan) = &setup.touch {
            candidates.push((plan.loss_db(plan.touch.impedances.len()), frequency_hz));
        }
    }
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    candidates.truncate(tolerances::TOUCH_TRIED);
    Ok(candidates.into_iter().map(|(_, hz)| hz).collect())
}

/// Natural frequency, Hz, of the mode nearest to `frequency_hz`, at most so many of its bandwidths
/// away as a finger may move it ([`tolerances::NEAR_BANDWIDTHS`]).
pub(crate) fn mode_near(model: &ModalModel, frequency_hz: f64) -> Option<f64> {
    let distance = |hz: f64| (hz - frequency_hz).abs();
    let near = model.in_band_modes().filter(|mode| {
        distance(mode.frequency_hz)
            <= tolerances::NEAR_BANDWIDTHS * mode.loss_factor * mode.frequency_hz
    });
    near.map(|mode| mode.frequency_hz)
        .min_by(|a, b| distance(*a).total_cmp(&distance(*b)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_model::test_model;
    use chladni_frf::Damping;

    #[test]
    fn a_frequency_that_serves_every_response_is_better_than_one_that_a_finger_spares() {
        let swept = |frequency_hz, success_ratio, touched: f64, kappa| SweptFrequency {
            frequency_hz,
            kappa: Some(kappa),
            success_ratio,
            touched_ratio: Some(touched),
            touched_kappa: None,
            largest_drive: 1.0,
            on_mode_hz: None,
        };
        let model = test_model(Damping::Structural, &[(60.0, 0.01), (120.0, 0.01)], [4, 2]);
        let [low_hz, high_hz] = model.band_hz;
        let at = |part: f64| low_hz + part * (high_hz - low_hz);
        let best = |swept: &[SweptFrequency]| suggested_hz(&model, swept).unwrap();
        let met = swept(at(0.2), 1.0, 0.875, 1.1);
        let spared = swept(at(0.4), 0.917, 0.917, -13.2);
        let held = swept(at(0.6), 1.0, 0.9, 0.5);
        assert_eq!(best(&[met, spared]), met.frequency_hz);
        assert_eq!(best(&[met, spared, held]), held.frequency_hz);
        // of two that are met, the one that tolerates the fingers of the scene
        let under = |swept: SweptFrequency, kappa| SweptFrequency {
            touched_kappa: Some(kappa),
            ..swept
        };
        let fingers = [under(met, 0.9), under(held, 0.2), under(spared, 3.0)];
        assert_eq!(best(&fingers), met.frequency_hz);
        // none is met: the nearest to it
        let nearer = swept(at(0.8), 0.917, 0.5, -5.7);
        assert_eq!(best(&[spared, nearer]), nearer.frequency_hz);
    }
}
