//! A scene: its demands, the weights, the field, and the drive in modal coordinates. With these
//! the page computes the field at another frequency or without some of the modes.

use super::array::{complex, u8s};
use super::chart;
use super::geometry::Geometry;
use crate::figures::curves::curves;
use crate::figures::sweep::sweep;
use crate::figures::weights_around_edge::weights_by_actuator;
use crate::input::{RenderedScene, ReportInput, ShownField};
use crate::text::{counted, fixed, plain};
use chladni_frf::{ModalModel, ReferenceUnit};
use chladni_render::{Ground, Weights};
use num_complex::Complex64;
use serde_json::{json, Value};

/// The data of a scene; `number` counts from 1.
pub(crate) fn value(
    scene: &RenderedScene,
    number: usize,
    input: &ReportInput,
    geometry: Option<&Geometry>,
) -> Value {
    let weights = scene.weights;
    let drive = input.model.map(|model| weights.at(&model.references));
    json!({
        "name": weights.scene,
        "frequency_hz": weights.frequency_hz,
        "method": weights.method,
        "feasible": weights.feasible,
        "reservation": weights.reservation().filter(|_| weights.is_met()),
        "modes_used": weights.modes_used,
        "actuators_used": weights.actuators_used,
        "kappa": weights.kappa,
        "ceiling": weights.ceiling,
        "source": weights.source.iter().map(|source| &source.file).collect::<Vec<_>>(),
        "facts": facts(weights),
        "indices": scene.shown.as_ref().map_or(&weights.indices, |shown| shown.indices),
        "judged_on": scene.shown.as_ref().map_or("the model", |shown| shown.on),
        "unit": match weights.unit() { ReferenceUnit::Newton => "N", ReferenceUnit::Volt => "V" },
        "weights": weights.weights.iter().map(|weight| json!({"reference": weight.reference, "re": weight.re, "im": weight.im,
            "place": geometry.and_then(|geometry| geometry.place(weight.reference))})).collect::<Vec<_>>(),
        "stress": weights.stress,
        "sweep": sweep(weights, number).map(|figure| chart::value(&figure, 1)),
        "by_actuator": chart::value(&weights_by_actuator(weights, number), 2),
        "curves": curves(scene, number).iter().map(|figure| chart::value(figure, 1)).collect::<Vec<_>>(),
        "time": scene.time.map(super::time::value),
        "field": scene.shown.as_ref().map(|shown| field(shown, geometry)),
        "modal": input.model.zip(drive).map(|(model, drive)| modal(model, &drive, geometry)),
    })
}

/// The page's code of a ground.
fn code(ground: Ground) -> u8 {
    match ground {
        Ground::Ignored => 0,
        Ground::Cold => 1,
        Ground::Hot => 2,
    }
}

fn field(shown: &ShownField, geometry: Option<&Geometry>) -> Value {
    let area = shown.zones.area();
    let over_grid = geometry
        .and_then(|geometry| geometry.grid.as_ref())
        .map(|grid| {
            let points = grid
                .y_m
                .iter()
                .flat_map(|&y| grid.x_m.iter().map(move |&x| [x, y]));
            u8s(points.map(|point| code(shown.zones.classify(point))))
        });
    json!({
        "threshold": shown.limits.threshold_m_per_s,
        "felt": shown.limits.hot_m_per_s,
        "quiet": shown.limits.cold_m_per_s,
        "area_m": [area.x_min, area.y_min, area.x_max, area.y_max],
        "hot": shown.zones.hot_outlines(),
        "places": shown.field.positions_m,
        "names": shown.field.responses,
        "ground": u8s(shown.field.ground.iter().map(|&ground| code(ground))),
        "levels": shown.field.positions_m.iter().map(|&place| shown.zones.level_at(place)).collect::<Vec<_>>(),
        "velocity": complex(&shown.field.velocity_m_per_s),
        "ground_on_grid": over_grid,
        "surface": shown.area.map(|area| json!({"x": area.x_m, "y": area.y_m, "velocity": complex(&area.velocity_m_per_s),
            "ground": u8s(area.ground.iter().map(|&ground| code(ground)))})),
    })
}

/// Participation of each mode in the drive, and the motion by residual terms at the responses
/// and on the grid.
fn modal(model: &ModalModel, drive: &[Complex64], geometry: Option<&Geometry>) -> Value {
    let dot = |row: &mut dyn Iterator<Item = &Complex64>| {
        row.zip(drive).map(|(a, b)| a * b).sum::<Complex64>()
    };
    let forces: Vec<Complex64> = model
        .modes
        .iter()
        .map(|mode| dot(&mut mode.participation.0.iter()))
        .collect();
    // a viscous pair needs the conjugate of the participation too
    let mirrored: Vec<Complex64> = model
        .modes
        .iter()
        .map(|mode| {
            mode.participation
                .0
                .iter()
                .zip(drive)
                .map(|(participation, force)| participation.conj() * force)
                .sum()
        })
        .collect();
    let terms: Vec<Vec<Complex64>> = model
        .residual_terms
        .terms
        .iter()
        .map(|term| {
            term.matrix
                .0
                .rows()
                .into_iter()
                .map(|row| dot(&mut row.iter()))
                .collect()
        })
        .collect();
    let on_grid: Option<Vec<Complex64>> = geometry
        .and_then(|geometry| {
            terms
                .iter()
                .map(|term| geometry.on_grid(term))
                .collect::<Option<Vec<_>>>()
        })
        .map(|all| all.concat());
    json!({
        "forces": complex(&forces),
        "mirrored": complex(&mirrored),
        "terms": complex(terms.iter().flatten()),
        "terms_on_grid": on_grid.as_ref().map(complex),
    })
}

/// The verdict on the scene, with the reservation if there is one.
fn verdict(weights: &Weights) -> String {
    if weights.own_finding("scene-impossible").is_some() {
        return "impossible: no drive can meet it".into();
    }
    if !weights.is_met() {
        return "not met in the model: some judged response misses its limit".into();
    }
    let but = weights
        .reservation()
        .map_or_else(String::new, |but| format!(", but {but}"));
    format!("met: every judged response keeps its limit in the model{but}")
}

fn facts(weights: &Weights) -> Vec<[String; 2]> {
    let mut rows = vec![
        (
            "Drive frequency",
            format!("{} Hz", plain(weights.frequency_hz)),
        ),
        ("Method", weights.method.clone()),
        ("Scene", verdict(weights)),
    ];
    if let Some(on_drive) = weights.own_finding("mode-on-drive") {
        rows.push(("Mode on the drive", on_drive.text.clone()));
    }
    if let Some(endurance) = weights.endurance {
        let share = fixed(100.0 * endurance.survival_ratio, 0);
        let words = format!("{share} % of {} simulated", endurance.rigs);
        rows.push(("Rigs that are served", words));
    }
    let used = [
        counted(weights.modes_used, "mode"),
        counted(weights.actuators_used, "actuator"),
    ];
    rows.push(("Used", used.join(", ")));
    if let Some(kappa) = weights.kappa {
        let words = match kappa >= 0.0 {
            true => format!(
                "limits are kept under model errors of {} standard deviations (κ)",
                fixed(kappa, 2)
            ),
            false => format!(
                "none: some limit is missed even without model errors (κ = {})",
                fixed(kappa, 2)
            ),
        };
        rows.push(("Robustness", words));
    }
    if let Some(ceiling) = &weights.ceiling {
        let db = |value: f64| fixed(value, 1);
        rows.push((
            "Certified",
            format!(
                "at most {} dB of contrast are possible, {} dB are asked, {} dB found",
                db(ceiling.possible_db),
                db(ceiling.asked_db),
                db(ceiling.reached_db)
            ),
        ));
    }
    if !weights.source.is_empty() {
        let files = weights.source.iter().map(|source| source.file.as_str());
        rows.push(("Made from", files.collect::<Vec<_>>().join(", ")));
    }
    rows.into_iter()
        .map(|(word, text)| [word.to_owned(), text])
        .collect()
}
