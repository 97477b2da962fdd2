//! The table of scenes.

use super::SceneRow;
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
        let counts = [drive.modes, drive.actuators, drive.residual_terms].map(|count| count.to_string());
        let asked = [row.name(), row.means.modes.to_string(), row.means.actuators.to_string()];
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
    csv::table("from 40 dB FRFs through the fit to the drive; judged on the true plate, window and drift on a 4 mm grid", &HEADER, cells)
}
