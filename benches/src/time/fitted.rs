//! The whole way in time: noisy FRFs, the fit, the drive, and the true plate every 4 mm,
//! as it is and drifted.

use super::{BURST_S, GLASS_QUARTER};
use crate::csv::{number, table};
use crate::scene::{measured_and_fitted, ScenePanel};
use chladni_frf::{ModalModel, Result};
use chladni_plate::simulate;
use chladni_render::{
    evaluate_signal, play, render, PlayOptions, Ramps, Recorded, RenderOptions, SignalOptions,
};
use rand_chacha::rand_core::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::{Deserialize, Serialize};

/// Rises that are tried, ms.
const RISES_MS: [f64; 2] = [10.0, 15.0];
/// Places on which the true plate is judged: every 4 mm over the responses.
const GRID: [usize; 2] = [51, 31];
/// See [`GRID`].
const GRID_M: f64 = 0.004;
/// Standard deviations of the drift of natural frequencies and of loss factors, relative.
const DRIFT: [f64; 2] = [1e-3, 0.1];
/// Drifted plates.
const DRAWS: u64 = 8;

/// One drive on one plate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FittedRow {
    /// `plain` or `modal`.
    pub ramps: String,
    /// Rise and fall, ms.
    pub rise_ms: f64,
    /// 0: the plate that was measured; above: one that has drifted.
    pub drift_seed: u64,
    /// Share of hot ground that keeps its limit all the time.
    pub hot_held: f64,
    /// Share of cold ground that is never over.
    pub cold_kept: f64,
    /// Worst cold ground over its limit at any instant, dB.
    pub worst_cold_db: f64,
    /// Weakest hot ground over its limit in the hold, dB.
    pub worst_hot_db: f64,
    /// Largest force over that of the steady drive.
    pub force: f64,
}

impl FittedRow {
    /// The drive and its plate, in words.
    fn name(&self) -> String {
        format!("{} ramps of {} ms", self.ramps, self.rise_ms)
    }
}

/// Modal and plain ramps from a fit of 40 dB FRFs, on the true plate and on drifted ones.
pub(super) fn fitted() -> Result<Vec<FittedRow>> {
    let (panel, model) = measured_and_fitted(ScenePanel::Glass)?;
    let scene = |rise_ms: f64| GLASS_QUARTER.scene(&format!("{}", 1e-3 * rise_ms), 0.1);
    let steady = render(&model, &scene(RISES_MS[0])?, &RenderOptions::default())?.weights;
    let plate = closely()?;
    let mut rows = Vec::new();
    for ramps in [Ramps::Modal, Ramps::Plain] {
        for rise_ms in RISES_MS {
            let scene = scene(rise_ms)?;
            let options = PlayOptions {
                ramps: Some(ramps),
                area: false,
                ..PlayOptions::default()
            };
            let played = play(&model, &scene, Some(&steady), &options)?;
            let signal = played.signal(&SignalOptions::default(), "")?;
            let mut judge = |drift_seed: u64, plate: &ModalModel| -> Result<()> {
                let recorded = Recorded {
                    rate_hz: f64::from(signal.sidecar.rate_hz),
                    // the same actuators, whatever numbers their nodes have
                    references: plate.references.clone(),
                    drive: signal.drive.clone(),
                };
                let events = &played.indices.events;
                let peak = evaluate_signal(&recorded, events, &scene, plate)?.0.peak;
                rows.push(FittedRow {
                    ramps: ramps.as_str().into(),
                    rise_ms,
                    drift_seed,
                    hot_held: peak.hot_held_ratio,
                    cold_kept: 1.0 - peak.ever_over_ratio,
                    worst_cold_db: peak.worst_cold_db.unwrap_or(f64::NAN),
                    worst_hot_db: peak.worst_hot_db.unwrap_or(f64::NAN),
                    force: played.indices.peak_drive / played.indices.steady_drive,
                });
                Ok(())
            };
            judge(0, &plate)?;
            if ramps == Ramps::Modal {
                for seed in 1..=DRAWS {
                    judge(seed, &drifted(&panel.exact, seed))?;
                }
                judge(DRAWS + 1, &panel.exact)?;
            }
        }
    }
    Ok(rows)
}

/// The true plate, seen every 4 mm.
fn closely() -> Result<ModalModel> {
    let mut panel = ScenePanel::Glass.panel();
    (panel.responses.grid, panel.responses.spacing_m) = (GRID, GRID_M);
    // few lines: the truth is what counts
    panel.frf.step_hz = 499.0;
    Ok(simulate(&panel, None, None)?.truth)
}

fn drifted(model: &ModalModel, seed: u64) -> ModalModel {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
    let mut drifted = model.clone();
    for mode in &mut drifted.modes {
        mode.frequency_hz *= 1.0 + DRIFT[0] * draw();
        mode.loss_factor *= (1.0 + DRIFT[1] * draw()).max(0.1);
        mode.damping_ratio = 0.5 * mode.loss_factor;
    }
    drifted
}

/// The table.
pub fn fitted_csv(rows: &[FittedRow]) -> String {
    let header = [
        "ramps",
        "rise_ms",
        "drift_seed",
        "hot_held",
        "cold_kept",
        "worst_cold_db",
        "worst_hot_db",
        "force_over_steady",
    ];
    let line = |row: &FittedRow| {
        let seed = row.drift_seed as f64;
        let numbers = [
            row.rise_ms,
            seed,
            row.hot_held,
            row.cold_kept,
            row.worst_cold_db,
            row.worst_hot_db,
            row.force,
        ];
        std::iter::once(row.ramps.clone())
            .chain(numbers.map(number))
            .collect::<Vec<String>>()
    };
    let title = format!(
        "quarter, 300 Hz, bursts of {} ms from a fit of 40 dB FRFs: seed 0 is the true plate every 4 mm, 1 to {DRAWS} \
         are drifted plates at the responses, {} is the true one there",
        1e3 * BURST_S,
        DRAWS + 1
    );
    table(&title, &header, rows.iter().map(line))
}

/// The verdict of the rows.
pub fn fitted_verdict(rows: &[FittedRow]) -> String {
    let mut lines = Vec::new();
    for row in rows.iter().filter(|row| row.drift_seed == 0) {
        lines.push(format!(
            "fitted from 40 dB, true plate every 4 mm, {}: hot held {:.3}, cold never over {:.3}, \
             force {:.3}",
            row.name(),
            row.hot_held,
            row.cold_kept,
            row.force
        ));
    }
    for row in rows.iter().filter(|row| row.drift_seed == DRAWS + 1) {
        let cost = |drifted: &FittedRow| {
            let cold_db = drifted.worst_cold_db - row.worst_cold_db;
            cold_db.max(row.worst_hot_db - drifted.worst_hot_db)
        };
        let most_db = rows
            .iter()
            .filter(|other| other.name() == row.name())
            .filter(|other| (1..=DRAWS).contains(&other.drift_seed))
            .map(cost)
            .fold(f64::NEG_INFINITY, f64::max);
        lines.push(format!(
            "drift of 0.1 % and 10 %, {DRAWS} plates, {}: at most {most_db:.2} dB",
            row.name()
        ));
    }
    lines.join("\n") + "\n"
}
