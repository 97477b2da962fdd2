//! Scenes with `[touch]` at many frequencies: what a drive bears on the true plate, beside the
//! drive of the same scene without fingers.

use super::{measured_and_fitted, MeasuredPanel, ScenePanel};
use crate::csv;
use chladni_frf::{ModalModel, Result};
use chladni_render::{render, Finger, Ground, RenderOptions, Rendering, Scene};
use ndarray::Array1;
use num_complex::Complex64;
use std::time::Instant;

/// Scenes: columns and rows of cells, hot cell. The classes of ninths are corner, long edge,
/// short edge and centre.
const SCENES: [(&str, [usize; 2], usize); 5] = [
    ("quarter-1", [2, 2], 1),
    ("ninth-1", [3, 3], 1),
    ("ninth-2", [3, 3], 2),
    ("ninth-4", [3, 3], 4),
    ("ninth-5", [3, 3], 5),
];
/// Drive frequencies, Hz, and those of a quick run.
const FREQUENCIES_HZ: [f64; 5] = [300.0, 320.0, 330.0, 335.0, 340.0];
const QUICK_HZ: [f64; 1] = [330.0];
/// Between hot and cold ground, m.
const TRANSITION_M: f64 = 0.010;
/// Distance of the places that are touched on the true plate, m: none of the grid that drives
/// are made for.
const PLACES_M: f64 = 0.007;
/// Fingers that touch it.
const FINGERS: [Finger; 2] = [Finger::LIGHT, Finger::MID];

/// One scene at one frequency.
#[derive(Debug, Clone)]
pub struct TouchRow {
    /// The scene.
    pub scene: &'static str,
    /// Hz.
    pub frequency_hz: f64,
    /// With `[touch]` or without.
    pub touch: bool,
    /// The firmest finger that is borne; empty: none.
    pub firmest: String,
    /// κ under it; NaN without fingers.
    pub kappa: f64,
    /// κ with nobody there.
    pub kappa_free: f64,
    /// Largest force, N.
    pub max_force_n: f64,
    /// Share of all responses that are truly served, mean over fingers and places.
    pub total: f64,
    /// Smaller share of hot and cold ones, the least over fingers and places.
    pub least: f64,
    /// The smaller share of ground between the responses, in the model with nobody there.
    pub area: f64,
    /// Time to render, s.
    pub time_s: f64,
}

/// Renders all scenes at all frequencies.
///
/// # Errors
/// None for the named scenes.
pub fn touch(quick: bool, progress: &dyn Fn(&str)) -> Result<Vec<TouchRow>> {
    progress("measuring and fitting the panel");
    let (panel, model) = measured_and_fitted(ScenePanel::DrivingPoints)?;
    let frequencies: &[f64] = if quick { &QUICK_HZ } else { &FREQUENCIES_HZ };
    let mut rows = Vec::new();
    for (name, grid, hot) in SCENES {
        for &frequency_hz in frequencies {
            progress(&format!("{name} at {frequency_hz} Hz"));
            let plain = panel.scene(grid, hot, frequency_hz, TRANSITION_M)?;
            let touched = panel.scene_with(grid, hot, frequency_hz, TRANSITION_M, "[touch]\n")?;
            rows.push(row(name, &panel, &model, &plain)?);
            rows.push(row(name, &panel, &model, &touched)?);
        }
    }
    Ok(rows)
}

fn row(
    name: &'static str,
    panel: &MeasuredPanel,
    model: &ModalModel,
    scene: &Scene,
) -> Result<TouchRow> {
    let clock = Instant::now();
    let rendering = render(model, scene, &RenderOptions::default())?;
    let time_s = clock.elapsed().as_secs_f64();
    let weights = &rendering.weights;
    let told = weights.touch.as_ref();
    let [total, least] = served(panel, scene.frequency_hz, &rendering)?;
    let area = weights.indices.area.as_ref();
    let ratios = area.map(|area| [area.hot_ratio, area.cold_ratio]);
    let kappa = told.and_then(|told| told.kappa);
    Ok(TouchRow {
        scene: name,
        frequency_hz: scene.frequency_hz,
        touch: scene.touch.is_some(),
        firmest: told
            .and_then(|told| told.firmest.clone())
            .unwrap_or_default(),
        kappa: kappa.unwrap_or(f64::NAN),
        kappa_free: weights.kappa.unwrap_or(f64::INFINITY),
        max_force_n: weights.indices.points.max_force_n.unwrap_or(f64::NAN),
        total,
        least,
        area: ratios.into_iter().flatten().flatten().fold(1.0, f64::min),
        time_s,
    })
}

/// Mean share of all responses, and least share of hot or cold ones, that the true plate
/// serves under the fingers.
fn served(panel: &MeasuredPanel, frequency_hz: f64, rendering: &Rendering) -> Result<[f64; 2]> {
    let values = rendering.weights.weights.iter();
    let drive: Array1<Complex64> = values.map(|weight| weight.value()).collect();
    let (mut sum, mut count, mut least) = (0.0, 0.0, 1.0f64);
    for place in places(rendering) {
        for finger in &FINGERS {
            let (field, limits) = (&rendering.field, &rendering.limits);
            let truth = &panel.truth;
            let served = truth.touched_at(&drive, frequency_hz, finger, place, field, limits)?;
            least = least.min(served.least());
            sum += served.total;
            count += 1.0;
        }
    }
    Ok([sum / count, least])
}

/// Hot places within the responses.
fn places(rendering: &Rendering) -> Vec<[f64; 2]> {
    let around = |axis: usize| {
        let along = rendering.field.positions_m.iter().map(|place| place[axis]);
        let low = along.clone().fold(f64::INFINITY, f64::min);
        let high = along.fold(f64::NEG_INFINITY, f64::max);
        let steps = ((high - low) / PLACES_M) as usize;
        (0..=steps).map(move |k| low + PLACES_M * k as f64)
    };
    let all = around(1).flat_map(|y| around(0).map(move |x| [x, y]));
    all.filter(|&place| rendering.zones.classify(place) == Ground::Hot)
        .collect()
}

/// A row for each drive, as CSV.
pub fn touch_csv(rows: &[TouchRow]) -> String {
    const HEADER: [&str; 11] = [
        "scene",
        "method",
        "frequency_hz",
        "firmest",
        "kappa",
        "kappa_free",
        "max_force_n",
        "total",
        "least",
        "area",
        "time_s",
    ];
    let cells = rows.iter().map(|row| {
        let method = if row.touch { "robust, touch" } else { "robust" };
        let numbers = [
            row.kappa,
            row.kappa_free,
            row.max_force_n,
            row.total,
            row.least,
            row.area,
            row.time_s,
        ];
        let named = [
            row.scene.to_owned(),
            method.to_owned(),
            csv::number(row.frequency_hz),
            row.firmest.clone(),
        ];
        named.into_iter().chain(numbers.map(csv::number)).collect()
    });
    csv::table(
        "light and mid fingers anywhere on hot ground of the true plate; total: share of all responses, mean; least: of hot or cold ones",
        &HEADER,
        cells.collect::<Vec<_>>(),
    )
}
