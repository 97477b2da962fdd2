//! Rigs that are not their model: a drive is rendered for a fitted panel, played on the
//! true one with its faults, measured, corrected, and played again.

mod fault;
mod figures;
mod learning;
mod tables;
mod true_rig;

pub use fault::RigError;
pub use figures::rig_figures;
pub use tables::rig_csv;

use crate::countdown::Countdown;
use crate::journal::{nan, Journal};
use crate::scene::{measured_and_fitted, MeasuredPanel, ScenePanel};
use crate::wild::random::Random;
use chladni_frf::{ModalModel, Result};
use chladni_render::{correct, render, PlayedField, RenderOptions, Rendering, Scene};
use fault::Faults;
use ndarray::Array1;
use num_complex::Complex64;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::Mutex;
use std::time::Instant;
use true_rig::{Plate, TrueRig};

/// Panels, by turns.
const PANELS: [(ScenePanel, &str); 4] = [
    (ScenePanel::Glass, "glass"),
    (ScenePanel::Aluminium, "aluminium"),
    (ScenePanel::Rim, "rim"),
    (ScenePanel::DrivingPoints, "driving-points"),
];
/// Scenes on each of them: columns and rows of cells, the hot cell, Hz. Those that the model
/// cannot meet are left out.
const SCENES: [([usize; 2], usize, f64); 6] = [
    ([2, 2], 1, 300.0),
    ([2, 2], 2, 330.0),
    ([2, 2], 3, 300.0),
    ([3, 3], 1, 330.0),
    ([3, 3], 5, 300.0),
    ([3, 3], 8, 330.0),
];
/// Between hot and cold ground, m.
const TRANSITION_M: f64 = 0.010;
/// Stream of the choice of a scene.
const STREAM: u64 = 41;
/// Rigs that a thread takes at a time, so that the journal is written often.
const BATCH: usize = 4;

/// Rigs to run, and how many of them.
#[derive(Debug, Clone)]
pub struct RigOptions {
    /// Kinds of faults.
    pub errors: Vec<RigError>,
    /// Rigs of each kind.
    pub rigs: usize,
    /// The first seed; the others follow it.
    pub first_seed: u64,
    /// Measured fields of each rig.
    pub fields: usize,
    /// The first panel and its first scene only: the corner at 300 Hz of the study.
    pub corner_only: bool,
}

/// Way from one drive to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum RigWay {
    /// By `correct`.
    Correct,
    /// By iterative learning: A + (HᴴH + cI)⁻¹Hᴴ(v* − v).
    Learning,
    /// The first drive, again and again.
    Unchanged,
    /// By the default method, for the true mobility: what a drive can do on this rig.
    Known,
}

impl RigWay {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Correct, Self::Learning, Self::Unchanged, Self::Known];

    /// Name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Correct => "correct",
            Self::Learning => "learning",
            Self::Unchanged => "unchanged",
            Self::Known => "known",
        }
    }
}

/// A rig after some measured fields.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct RigRow {
    /// Panel.
    pub panel: String,
    /// Seed of the faults.
    pub seed: u64,
    /// Kind of faults.
    pub error: String,
    /// Measured fields so far.
    pub fields: usize,
    /// Smaller share of hot and cold responses that are truly served.
    #[serde(deserialize_with = "nan")]
    pub min_ratio: f64,
    /// Way that made the drive.
    pub way: RigWay,
    /// Time of the correction, s; NaN where there is none.
    #[serde(deserialize_with = "nan")]
    pub time_s: f64,
    /// Cells and frequency of the scene.
    pub scene: String,
    /// The smaller share that the correction foretells; NaN where there is none.
    #[serde(deserialize_with = "nan")]
    pub predicted: f64,
    /// NIS of the newest field; NaN where there is none.
    #[serde(deserialize_with = "nan")]
    pub nis: f64,
}

/// A panel as a rig starts: fitted, with a drive for each scene.
struct Bench {
    name: &'static str,
    measured: MeasuredPanel,
    model: ModalModel,
    actuators_m: Vec<[f64; 2]>,
    scenes: Vec<(String, Scene, Rendering)>,
}

/// Corrects the drives of all rigs, as many at a time as there are threads.
///
/// # Errors
/// Those of the journal.
pub fn rigs(
    options: &RigOptions,
    journal: &mut Journal,
    progress: &dyn Fn(&str),
) -> Result<Vec<RigRow>> {
    let asked: Vec<(RigError, u64)> = options
        .errors
        .iter()
        .flat_map(|&error| {
            let seeds = options.first_seed..options.first_seed + options.rigs as u64;
            seeds.map(move |seed| (error, seed))
        })
        .collect();
    progress("measuring and fitting the panels");
    let count = if options.corner_only { 1 } else { PANELS.len() };
    let benches: Vec<Bench> = PANELS[..count]
        .par_iter()
        .map(|&(panel, name)| Bench::new(panel, name, options.corner_only))
        .collect::<Result<_>>()?;
    let batch = BATCH * rayon::current_num_threads();
    let mut countdown = Countdown::new(asked.len().div_ceil(batch), progress);
    let mut rows = Vec::new();
    for asked in asked.chunks(batch) {
        let name = |(error, seed): (RigError, u64)| format!("{} {seed}", error.name());
        let done = asked.iter().all(|&rig| journal.has(&name(rig)));
        countdown.next(&format!("rigs from {} on", name(asked[0])), done);
        let shared = Mutex::new(&mut *journal);
        let kept = || shared.lock().unwrap_or_else(|lock| lock.into_inner());
        let courses = asked.par_iter().map(|&(error, seed)| {
            let bench = &benches[seed as usize % benches.len()];
            let done = kept().has(&name((error, seed)));
            let course = || bench.courses(error, seed, options.fields);
            let fresh = if done { None } else { Some(course()?) };
            kept().once(&name((error, seed)), || fresh.map_or_else(course, Ok))
        });
        rows.extend(courses.collect::<Result<Vec<Vec<RigRow>>>>()?);
    }
    Ok(rows.into_iter().flatten().collect())
}

impl Bench {
    fn new(kind: ScenePanel, name: &'static str, corner_only: bool) -> Result<Self> {
        let (measured, model) = measured_and_fitted(kind)?;
        let count = if corner_only { 1 } else { SCENES.len() };
        let mut scenes = Vec::new();
        for (grid, hot, frequency_hz) in &SCENES[..count] {
            let scene = measured.scene(*grid, *hot, *frequency_hz, TRANSITION_M)?;
            let rendering = render(&model, &scene, &RenderOptions::default())?;
            if rendering.weights.feasible {
                let words = format!("{}x{}:{hot}@{frequency_hz}", grid[0], grid[1]);
                scenes.push((words, scene, rendering));
            }
        }
        Ok(Self {
            name,
            actuators_m: kind.panel().layout().references_m,
            measured,
            model,
            scenes,
        })
    }

    /// One rig, corrected in every way.
    fn courses(&self, error: RigError, seed: u64, fields: usize) -> Result<Vec<RigRow>> {
        let place = Random::new(seed, STREAM).even([0.0, self.scenes.len() as f64]) as usize;
        let (words, scene, first) = &self.scenes[place.min(self.scenes.len() - 1)];
        let mut rows = Vec::new();
        for way in RigWay::ALL {
            let mut rig = self.rig(error, seed, first)?;
            let mut drive = drive_of(first);
            let mut weights = first.weights.clone();
            let mut played = Vec::new();
            let mut time_s = f64::NAN;
            if way == RigWay::Known {
                let known = rig.known(&self.model, &first.field);
                let rendering = render(&known, scene, &RenderOptions::default())?;
                drive = drive_of(&rendering);
            }
            for taken in 0..=fields {
                let told = weights.correction.as_ref();
                rows.push(RigRow {
                    panel: self.name.into(),
                    seed,
                    error: error.name().into(),
                    fields: taken,
                    min_ratio: rig.served(&drive, &first.field, &first.limits),
                    way,
                    time_s,
                    scene: words.clone(),
                    predicted: told.map_or(f64::NAN, |told| told.predicted),
                    nis: told
                        .and_then(|told| told.fields.last())
                        .map_or(f64::NAN, |field| field.nis),
                });
                if taken == fields {
                    continue;
                }
                match way {
                    RigWay::Correct => {
                        let field = rig.measured(&drive, &first.field);
                        played.push(PlayedField::new(weights, field));
                        let clock = Instant::now();
                        let options = RenderOptions::default();
                        weights = correct(&self.model, scene, &played, &options)?;
                        time_s = clock.elapsed().as_secs_f64();
                        drive = weights.weights.iter().map(|w| w.value()).collect();
                    }
                    RigWay::Learning => {
                        let field = rig.measured(&drive, &first.field);
                        drive = learning::next(&self.model, first, &drive, &field)?;
                    }
                    RigWay::Unchanged | RigWay::Known => {}
                }
            }
        }
        Ok(rows)
    }

    fn rig(&self, error: RigError, seed: u64, first: &Rendering) -> Result<TrueRig> {
        let drive = drive_of(first);
        let mut order: Vec<usize> = (0..drive.len()).collect();
        order.sort_by(|&a, &b| drive[b].norm().total_cmp(&drive[a].norm()));
        let plate = Plate {
            modes: self.measured.truth.modes(),
            loss_factors: self.measured.truth.loss_factors(),
            actuators_m: &self.actuators_m,
            frequency_hz: first.weights.frequency_hz,
        };
        TrueRig::new(&plate, Faults::draw(error, seed, &order), &first.field)
    }
}

fn drive_of(rendering: &Rendering) -> Array1<Complex64> {
    let weights = rendering.weights.weights.iter();
    weights.map(|weight| weight.value()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two rigs of the corner scene, from a seed on.
    fn corner(error: RigError, first_seed: u64, fields: usize) -> Vec<RigRow> {
        let options = RigOptions {
            errors: vec![error],
            rigs: 2,
            first_seed,
            fields,
            corner_only: true,
        };
        rigs(&options, &mut Journal::none(), &|_| {}).unwrap()
    }

    /// Mean share after so many fields.
    fn mean(rows: &[RigRow], way: RigWay, fields: usize) -> f64 {
        let counts = |row: &&RigRow| row.way == way && row.fields == fields;
        crate::statistics::mean(rows.iter().filter(counts).map(|row| row.min_ratio))
    }

    #[test]
    fn one_field_mends_a_dead_channel_and_learning_does_not() {
        let rows = corner(RigError::Dead, 0, 1);
        let mean = |way| mean(&rows, way, 1);
        let [corrected, learned] = [RigWay::Correct, RigWay::Learning].map(mean);
        assert!(mean(RigWay::Unchanged) < 0.9, "{rows:?}");
        assert!(corrected >= 0.99 && corrected > learned, "{rows:?}");
    }

    #[test]
    fn two_fields_mend_two_fingers_that_stay() {
        let rows = corner(RigError::Fingers, 17, 2);
        // 0.92 where the operator update starts from the errors of amplifiers
        assert!(mean(&rows, RigWay::Correct, 2) >= 0.98, "{rows:?}");
    }

    /// A rig of any faults on one of the four panels.
    fn mixed(first_seed: u64, fields: usize) -> Vec<RigRow> {
        let options = RigOptions {
            errors: vec![RigError::Mixed],
            rigs: 1,
            first_seed,
            fields,
            corner_only: false,
        };
        rigs(&options, &mut Journal::none(), &|_| {}).unwrap()
    }

    /// The second field of this rig is as that of the model, turned the wrong way in time: a mode
    /// moved across the drive. It is taken, for the first field tells.
    #[test]
    fn a_second_field_that_the_model_alone_would_refuse_is_taken() {
        let rows = mixed(989, 2);
        assert!(mean(&rows, RigWay::Correct, 2) >= 0.99, "{rows:?}");
    }

    /// Here a new drive that might serve 0.76 serves 0.33, where 0.49 was measured.
    #[test]
    fn the_way_goes_back_to_the_best_drive() {
        let rows = mixed(102, 3);
        let served = |fields| mean(&rows, RigWay::Correct, fields);
        let best = (0..3).map(served).fold(0.0, f64::max);
        assert!(served(2) < best && served(3) == best, "{rows:?}");
    }
}
