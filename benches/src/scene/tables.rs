//! The table of scenes.

use super::{PaperRow, SceneRow};
use crate::csv;

const HEADER: [&str; 26] = [
    "scene",
    "method",
    "modes",
    "actuators",
    "residual_terms",
    "asked_method",
    "asked_modes",
    "asked_actuators",
    "frequency_hz",
    "time_s",
    "feasible",
    "kappa",
    "condition",
    "points_hot",
    "points_cold",
    "points_success",
    "points_silence",
    "window_hot",
    "window_cold",
    "window_total",
    "drift_mean",
    "drift_least",
    "touched_least",
    "max_force_n",
    "possible_db",
    "time_quartiles_s",
];

/// A row for each drive, as CSV.
pub fn scene_csv(rows: &[SceneRow]) -> String {
    let cells = rows.iter().map(|row| {
        let drive = &row.drive;
        let counts =
            [drive.modes, drive.actuators, drive.residual_terms].map(|count| count.to_string());
        let asked = [
            row.name(),
            row.means.modes.to_string(),
            row.means.actuators.to_string(),
        ];
        let numbers = [row.case.frequency_hz, drive.time_s[0]].map(csv::number);
        let judged = [
            drive.kappa,
            drive.condition,
            drive.points.hot,
            drive.points.cold,
            drive.points.total,
            drive.silence,
            drive.window.hot,
            drive.window.cold,
            drive.window.total,
            drive.drifted[0],
            drive.drifted[1],
            drive.touched,
            drive.max_force_n,
            drive.possible_db,
        ];
        [row.case.name.to_owned(), drive.method.clone()]
            .into_iter()
            .chain(counts)
            .chain(asked)
            .chain(numbers)
            .chain([drive.feasible.to_string()])
            .chain(judged.map(csv::number))
            .chain([csv::quartiles(&drive.time_s)])
            .collect()
    });
    csv::table(
        "from 40 dB FRFs through the fit to the drive; judged on the true plate, window and \
                drift on a 4 mm grid",
        &HEADER,
        cells,
    )
}

const PAPER_HEADER: [&str; 21] = [
    "scene",
    "method",
    "modes_of",
    "modes",
    "highest_hz",
    "gamma_condition",
    "psi_rank",
    "psi_condition",
    "points_hot",
    "points_cold",
    "points_success",
    "points_silence",
    "window_hot",
    "window_cold",
    "window_total",
    "max_force_n",
    "predicted_hot",
    "predicted_cold",
    "alone_hot",
    "alone_cold",
    "cut",
];

/// A row for each drive of the seed paper's reproduction, as CSV.
pub fn paper_csv(rows: &[PaperRow]) -> String {
    let cells = rows.iter().map(|row| {
        let (indices, steps) = (&row.weights.indices.points, row.steps());
        let condition = |value: Option<f64>| csv::number(value.unwrap_or(f64::NAN));
        let counts = [
            row.weights.modes_used.to_string(),
            csv::number(row.highest_hz),
        ];
        let judged = [
            row.points.hot,
            row.points.cold,
            row.points.total,
            indices.silence_ratio,
            row.window.hot,
            row.window.cold,
            row.window.total,
            indices.max_force_n.unwrap_or(f64::NAN),
            indices.hot_ratio,
            indices.cold_ratio,
            row.alone.map_or(f64::NAN, |alone| alone.hot_ratio),
            row.alone.map_or(f64::NAN, |alone| alone.cold_ratio),
        ];
        [
            row.case.name.to_owned(),
            row.weights.method.clone(),
            row.modes_of.as_str().to_owned(),
        ]
        .into_iter()
        .chain(counts)
        .chain([condition(steps.map(|steps| steps.gamma.condition()))])
        .chain([steps.map_or_else(String::new, |steps| steps.psi.rank.to_string())])
        .chain([condition(steps.map(|steps| steps.psi.condition()))])
        .chain(judged.map(csv::number))
        .chain([row.cut.map_or_else(String::new, csv::number)])
        .collect()
    });
    csv::table(
        "the seed paper's two steps with the lowest modes, and the default method; judged \
                on the true plate at the responses and on a 4 mm grid",
        &PAPER_HEADER,
        cells,
    )
}
