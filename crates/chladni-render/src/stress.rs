//! Performance of given weights when the world is not the model: the stress table.

use crate::drift::Drift;
use crate::evaluate::{laid, Laid, On};
use crate::field::Field;
use crate::finger::{finger_rows, Finger};
use crate::indices::PointIndices;
use crate::modal_field::ModalField;
use crate::problem::Drive;
use crate::rig::Calibrated;
use crate::scene::Scene;
use crate::weights::{StressRow, Weights};
use chladni_frf::{Finding, ModalModel, Mode, Result};
use ndarray::Array1;
use num_complex::Complex64;
use rand_chacha::rand_core::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Open01, StandardNormal};
use std::f64::consts::FRAC_1_SQRT_2;

/// Settings of the stress table.
#[derive(Debug, Clone, PartialEq)]
pub struct StressOptions {
    /// Seed of all draws.
    pub seed: u64,
    /// Draws of each random trial.
    pub draws: usize,
    /// Drift of the panel; its isotropic part does not take part.
    pub drift: Drift,
    /// A common shift of all natural frequencies, relative: temperature.
    pub common_shift: f64,
    /// The finger.
    pub finger: Finger,
    /// A mass that someone leaves on the panel, kg.
    pub added_mass_kg: f64,
    /// Standard deviation of each actuator's amplitude, relative.
    pub amplitude_relative: f64,
    /// Standard deviation of each actuator's phase, degrees.
    pub phase_deg: f64,
    /// Bits of the converter that drives the actuators; full scale is the largest weight.
    pub converter_bits: u32,
}

impl Default for StressOptions {
    /// 200 draws, so that the worst twentieth is ten of them; 1 g is a ring or a cable; 2
    /// % and 2° are amplifiers of one batch; 8 bits are coarse.
    fn default() -> Self {
        Self {
            seed: 1,
            draws: 200,
            drift: Drift::default(),
            common_shift: 2e-3,
            finger: Finger::default(),
            added_mass_kg: 1e-3,
            amplitude_relative: 0.02,
            phase_deg: 2.0,
            converter_bits: 8,
        }
    }
}

impl StressOptions {
    /// Rms of the complex error of a gain.
    pub(crate) fn gain_error(&self) -> f64 {
        self.amplitude_relative.hypot(self.phase_deg.to_radians())
    }
}

/// Indices of `weights` in `scene` when the panel is not `model`.
///
/// Touch and added mass need mass-scaled modes; where the model has none, the second
/// value says so.
///
/// # Errors
/// As [`crate::evaluate()`].
pub fn stress(
    weights: &Weights,
    scene: &Scene,
    model: &ModalModel,
    options: &StressOptions,
) -> Result<(Vec<StressRow>, Vec<Finding>)> {
    let Calibrated { model, scene, .. } =
        Calibrated::new(model, scene, Some(weights.frequency_hz), &options.drift)?;
    let (model, scene) = (&*model, &*scene);
    let Laid {
        operator,
        drive,
        limits,
        zones,
        ..
    } = laid(weights, scene, On::Model(model))?;
    let field = Field::new(&operator, &zones, &drive);
    let modal = ModalField::new(model, &operator, &drive);
    let judge = |velocity: Array1<Complex64>| -> Result<[f64; 2]> {
        let other = Field {
            velocity_m_per_s: velocity.to_vec(),
            ..field.clone()
        };
        let points = PointIndices::of_field(&other, &zones, &limits, &drive, operator.unit)?;
        Ok([points.success_ratio, points.min_ratio])
    };
    let mut rows = Vec::new();
    let mut add = |trial: &str, fields: Vec<Array1<Complex64>>| -> Result<()> {
        let judged = fields
            .into_iter()
            .map(judge)
            .collect::<Result<Vec<[f64; 2]>>>()?;
        rows.extend(StressRow::of(trial, &judged));
        Ok(())
    };

    add("none", vec![modal.free.clone()])?;
    let mut draw = Draw::new(options.seed);
    add(
        "errors of the fit",
        (0..options.draws)
            .map(|_| modal.with_modes(|mode| draw.fit_error(mode)))
            .collect(),
    )?;
    add(
        "drift",
        (0..options.draws)
            .map(|_| modal.with_modes(|mode| draw.drift(mode, &options.drift)))
            .collect(),
    )?;
    let shifted = [-1.0, 1.0].map(|sign| {
        modal.with_modes(|mode| mode.frequency_hz *= 1.0 + sign * options.common_shift)
    });
    add(
        &format!(
            "all frequencies {} % lower or higher",
            100.0 * options.common_shift
        ),
        shifted.to_vec(),
    )?;

    let mut findings = Vec::new();
    for (trial, finger) in [
        ("a finger in the hot zone", options.finger),
        (
            "an added mass in the hot zone",
            Finger::of_mass(options.added_mass_kg),
        ),
    ] {
        let touched: Option<Vec<_>> = finger_rows(&field)
            .into_iter()
            .map(|row| modal.touched(&finger, row))
            .collect();
        match touched {
            Some(fields) => add(trial, fields)?,
            None => findings.push(
                Finding::note(
                    "trial-needs-scale",
                    format!("{trial} cannot be tried: the shapes are not mass-scaled"),
                )
                .help("measure a driving point"),
            ),
        }
    }

    let of_drive = |drive: &Drive| operator.mobility.dot(drive);
    let dead = (0..drive.len())
        .filter(|&i| drive[i].norm() > 0.0)
        .map(|dead| {
            let mut drive = drive.clone();
            drive[dead] = Complex64::ZERO;
            of_drive(&drive)
        });
    add("one dead actuator", dead.collect())?;
    let wrong =
        (0..options.draws).map(|_| of_drive(&drive.mapv(|weight| weight * draw.gain(options))));
    add("amplitudes and phases of the drives", wrong.collect())?;
    add(
        &format!("a converter of {} bits", options.converter_bits),
        vec![of_drive(&quantised(&drive, options.converter_bits))],
    )?;
    Ok((rows, findings))
}

impl StressRow {
    /// The row of what was judged; `None` for no case.
    fn of(trial: &str, judged: &[[f64; 2]]) -> Option<Self> {
        let worst = |which: usize| {
            let mut values: Vec<f64> = judged.iter().map(|shares| shares[which]).collect();
            values.sort_by(f64::total_cmp);
            values.get(values.len() / 20).copied()
        };
        Some(Self {
            trial: trial.into(),
            cases: judged.len(),
            success_worst_5_percent: worst(0)?,
            min_worst_5_percent: worst(1)?,
            success_mean: judged.iter().map(|shares| shares[0]).sum::<f64>() / judged.len() as f64,
        })
    }
}

/// Real and imaginary part in steps of full scale / 2^(bits − 1).
fn quantised(drive: &Drive, bits: u32) -> Drive {
    let full_scale = drive.iter().map(|weight| weight.norm()).fold(0.0, f64::max);
    let step = full_scale / 2f64.powi(bits as i32 - 1);
    let round = |value: f64| {
        if step > 0.0 {
            (value / step).round() * step
        } else {
            value
        }
    };
    drive.mapv(|weight| Complex64::new(round(weight.re), round(weight.im)))
}

/// Seeded random changes.
pub(crate) struct Draw(ChaCha8Rng);

impl Draw {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// Evenly from 0 to 1.
    pub(crate) fn uniform(&mut self) -> f64 {
        Open01.sample(&mut self.0)
    }

    /// An error of the size that the model states. Poles outside the band stand for the
    /// world outside and keep still.
    pub(crate) fn fit_error(&mut self, mode: &mut Mode) {
        if !mode.in_band {
            return;
        }
        mode.frequency_hz += mode.frequency_std_hz * self.normal();
        mode.loss_factor += mode.loss_factor_std * self.normal();
        for response in 0..mode.shape.0.len() {
            let deviation = mode.shape_std_at_known_scale(response);
            mode.shape.0[response] +=
                Complex64::new(self.normal(), self.normal()) * (FRAC_1_SQRT_2 * deviation);
        }
    }

    pub(crate) fn drift(&mut self, mode: &mut Mode, drift: &Drift) {
        mode.frequency_hz *= 1.0 + drift.frequency_relative * self.normal();
        mode.loss_factor *= 1.0 + drift.loss_factor_relative * self.normal();
        for value in &mut mode.shape.0 {
            *value *= 1.0 + drift.shape_relative * self.normal();
        }
    }

    /// A factor on each of `count` natural frequencies, of a relative rms error.
    pub(crate) fn factors(&mut self, count: usize, error: f64) -> Vec<f64> {
        (0..count).map(|_| 1.0 + error * self.normal()).collect()
    }

    pub(crate) fn gain(&mut self, options: &StressOptions) -> Complex64 {
        let amplitude = 1.0 + options.amplitude_relative * self.normal();
        Complex64::from_polar(amplitude, options.phase_deg.to_radians() * self.normal())
    }
}
