//! Performance of given weights when the world is not the model: the stress table.

use crate::judging::indices::PointIndices;
use crate::judging::rig_draw::{worst_twentieth, Draw, StressOptions};
use crate::panel::drive::Drive;
use crate::panel::field::Field;
use crate::panel::finger::{finger_rows, Finger};
use crate::panel::modal_field::ModalField;
use crate::panel::operator::Operator;
use crate::results::evaluate::{laid, Laid, On};
use crate::results::weights::{StressRow, Weights};
use crate::rig::Calibrated;
use crate::scene::limits::Limits;
use crate::scene::scene_file::Scene;
use crate::scene::zones::ZoneMap;
use chladni_frf::{Finding, ModalModel, Result};
use ndarray::Array1;
use num_complex::Complex64;

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
    let mut table = Table {
        operator: &operator,
        drive: &drive,
        zones: &zones,
        limits,
        field,
        rows: Vec::new(),
    };
    table.add("none", vec![modal.free.clone()])?;
    let mut draw = Draw::new(options.seed);
    table.add_panels(&modal, &mut draw, options)?;
    let findings = table.add_fingers(&modal, options)?;
    table.add_drives(&mut draw, options)?;
    Ok((table.rows, findings))
}

/// The stress table of a drive.
struct Table<'a> {
    operator: &'a Operator,
    drive: &'a Drive,
    zones: &'a ZoneMap,
    limits: Limits,
    /// In the model.
    field: Field,
    rows: Vec<StressRow>,
}

impl Table<'_> {
    /// Adds the row of a trial that makes such velocities.
    fn add(&mut self, trial: &str, fields: Vec<Array1<Complex64>>) -> Result<()> {
        let judge = |velocity: Array1<Complex64>| -> Result<[f64; 2]> {
            let other = Field {
                velocity_m_per_s: velocity.to_vec(),
                ..self.field.clone()
            };
            let points = PointIndices::of_field(
                &other,
                self.zones,
                &self.limits,
                self.drive,
                self.operator.unit,
            )?;
            Ok([points.success_ratio, points.min_ratio])
        };
        let judged = fields.into_iter().map(judge).collect::<Result<Vec<_>>>()?;
        self.rows.extend(StressRow::of(trial, &judged));
        Ok(())
    }

    /// Modes that are not where the model has them.
    fn add_panels(
        &mut self,
        modal: &ModalField,
        draw: &mut Draw,
        options: &StressOptions,
    ) -> Result<()> {
        self.add(
            "errors of the fit",
            (0..options.draws)
                .map(|_| modal.with_modes(|mode| draw.fit_error(mode)))
                .collect(),
        )?;
        self.add(
            "drift",
            (0..options.draws)
                .map(|_| modal.with_modes(|mode| draw.drift(mode, &options.drift)))
                .collect(),
        )?;
        let shifted = [-1.0, 1.0].map(|sign| {
            modal.with_modes(|mode| mode.frequency_hz *= 1.0 + sign * options.common_shift)
        });
        let shift = format!(
            "all frequencies {} % lower or higher",
            100.0 * options.common_shift
        );
        self.add(&shift, shifted.to_vec())
    }

    /// Fingers and masses that touch the hot zone; the findings name what cannot be tried.
    fn add_fingers(&mut self, modal: &ModalField, options: &StressOptions) -> Result<Vec<Finding>> {
        let mut findings = Vec::new();
        let mass = Finger::of_mass(options.added_mass_kg);
        for (trial, finger) in [
            ("a finger in the hot zone", options.finger),
            ("an added mass in the hot zone", mass),
        ] {
            let rows = finger_rows(&self.field).into_iter();
            let touched: Option<Vec<_>> = rows.map(|row| modal.touched(&finger, row)).collect();
            match touched {
                Some(fields) => self.add(trial, fields)?,
                None => findings.push(unscaled(trial)),
            }
        }
        Ok(findings)
    }

    /// Drives that are not what was asked for.
    fn add_drives(&mut self, draw: &mut Draw, options: &StressOptions) -> Result<()> {
        let (operator, drive) = (self.operator, self.drive);
        let of_drive = |drive: &Drive| operator.mobility.dot(drive);
        self.add(
            "one dead actuator",
            one_dead(drive).map(|drive| of_drive(&drive)).collect(),
        )?;
        let wrong =
            (0..options.draws).map(|_| of_drive(&drive.mapv(|weight| weight * draw.gain(options))));
        self.add("amplitudes and phases of the drives", wrong.collect())?;
        self.add(
            &format!("a converter of {} bits", options.converter_bits),
            vec![of_drive(&quantised(drive, options.converter_bits))],
        )
    }
}

fn unscaled(trial: &str) -> Finding {
    let words = format!("{trial} cannot be tried: the shapes are not mass-scaled");
    Finding::note("trial-needs-scale", words).help("measure a driving point")
}

/// The drive without each of the actuators that it drives.
fn one_dead(drive: &Drive) -> impl Iterator<Item = Drive> + '_ {
    let driven = (0..drive.len()).filter(|&i| drive[i].norm() > 0.0);
    driven.map(|dead| {
        let mut drive = drive.clone();
        drive[dead] = Complex64::ZERO;
        drive
    })
}

impl StressRow {
    /// The row of what was judged; `None` for no case.
    fn of(trial: &str, judged: &[[f64; 2]]) -> Option<Self> {
        let worst =
            |which: usize| worst_twentieth(judged.iter().map(|shares| shares[which]).collect());
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
