//! The tables of accuracy: a row for each method and case, and a row for each of their
//! modes.

use crate::accuracy::AccuracyRow;
use crate::csv;
use crate::mode_errors::ModeErrors;
use crate::pareto::front;
use crate::scene::{scenes_on_front, SceneRow};

/// Columns of the table of methods and cases.
const HEADER: [&str; 38] = [
    "case",
    "method",
    "time_s",
    "frequency_rmse_over_crlb",
    "frequency_worst_rmse_over_crlb",
    "loss_factor_rmse_over_crlb",
    "loss_factor_worst_rmse_over_crlb",
    "frequency_rmse_over_rank_one_crlb",
    "frequency_worst_rmse_over_rank_one_crlb",
    "loss_factor_rmse_over_rank_one_crlb",
    "loss_factor_worst_rmse_over_rank_one_crlb",
    "frequency_rmse_over_real_crlb",
    "frequency_worst_rmse_over_real_crlb",
    "loss_factor_rmse_over_real_crlb",
    "loss_factor_worst_rmse_over_real_crlb",
    "frequency_rmse_with_missed_over_crlb",
    "frequency_coverage",
    "loss_factor_coverage",
    "shape_coverage",
    "modes",
    "missed",
    "spurious_sure",
    "spurious_weak",
    "exact_share",
    "silent_failures",
    "wrong_seeds",
    "wrong_law_share",
    "wrong_law_seeds",
    "mac_median",
    "mac_least",
    "frf_error_db",
    "frequency_error_largest",
    "crlb_over_bandwidth_largest",
    "seeds",
    "time_quartiles_s",
    "on_front",
    "backend",
    "ground_served",
];

/// A row for each method and case, as CSV; scenes of rendering have, beside their time,
/// the share of hot or of cold ground that the true plate serves, whichever is smaller.
pub fn accuracy_csv(rows: &[AccuracyRow], scenes: &[SceneRow]) -> String {
    let comment =
        "errors over Cramer-Rao bounds: median over the modes and worst mode; missed and \
                   spurious: mean per fit; times: median";
    let front = on_front(rows)
        .into_iter()
        .map(|on| on.map_or(String::new(), |on| on.to_string()));
    let backend = chladni_linalg::BACKEND.to_owned();
    let fits = rows.iter().zip(front).map(|(row, on)| {
        cells(row)
            .into_iter()
            .chain([on, backend.clone(), String::new()])
            .collect()
    });
    let drives = scenes.iter().zip(scenes_on_front(scenes)).map(|(row, on)| {
        let mut cells = vec![String::new(); HEADER.len()];
        let known = [
            ("case", row.case.name.to_owned()),
            ("method", row.name()),
            ("time_s", csv::number(row.drive.time_s[0])),
            ("time_quartiles_s", csv::quartiles(&row.drive.time_s)),
            ("on_front", on.map_or(String::new(), |on| on.to_string())),
            ("backend", backend.clone()),
            ("ground_served", csv::number(row.drive.window.least())),
        ];
        for (column, cell) in known {
            cells[HEADER.iter().position(|name| *name == column).unwrap_or(0)] = cell;
        }
        cells
    });
    csv::table(comment, &HEADER, fits.chain(drives))
}

/// True where no other method of its case beats a row in time and error together; `None`
/// where it has no error over a bound, or turns a knob.
pub fn on_front(rows: &[AccuracyRow]) -> Vec<Option<bool>> {
    let takes_part = |row: &AccuracyRow| row.setting.is_none() && row.with_missed.is_finite();
    let place = |row: &AccuracyRow| [row.time_s[0], row.with_missed];
    let on = |row: &AccuracyRow| {
        let others = rows
            .iter()
            .filter(|other| other.case.name == row.case.name && takes_part(other))
            .map(place);
        let points: Vec<_> = std::iter::once(place(row)).chain(others).collect();
        front(&points)[0]
    };
    rows.iter()
        .map(|row| takes_part(row).then(|| on(row)))
        .collect()
}

fn cells(row: &AccuracyRow) -> Vec<String> {
    let spreads = row
        .over_free
        .iter()
        .chain(&row.over_rank_one)
        .chain(&row.over_real)
        .flat_map(|spread| [spread.median, spread.worst]);
    let seeds = |seeds: &[u64]| {
        seeds
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>()
            .join(" ")
    };
    [
        row.case.name.to_owned(),
        row.name(),
        csv::number(row.time_s[0]),
    ]
    .into_iter()
    .chain(
        spreads
            .chain([row.with_missed])
            .chain(row.coverage)
            .map(csv::number),
    )
    .chain([row.modes.len().to_string()])
    .chain(
        row.miscounts
            .into_iter()
            .chain([row.exact])
            .map(csv::number),
    )
    .chain([
        row.silent.to_string(),
        seeds(&row.wrong_seeds),
        csv::number(row.wrong_law),
        seeds(&row.wrong_law_seeds),
    ])
    .chain(
        row.mac
            .into_iter()
            .chain([
                row.frf_error_db,
                row.frequency_error,
                row.bound_over_bandwidth,
            ])
            .map(csv::number),
    )
    .chain([row.seeds.to_string(), csv::quartiles(&row.time_s)])
    .collect()
}

/// Columns of the table of modes.
const MODE_HEADER: [&str; 19] = [
    "case",
    "method",
    "mode",
    "frequency_hz",
    "loss_factor",
    "found_share",
    "frequency_crlb_hz",
    "loss_factor_crlb",
    "frequency_rmse_over_crlb",
    "loss_factor_rmse_over_crlb",
    "frequency_bias_over_crlb",
    "loss_factor_bias_over_crlb",
    "frequency_rmse_over_rank_one_crlb",
    "loss_factor_rmse_over_rank_one_crlb",
    "frequency_rmse_over_real_crlb",
    "loss_factor_rmse_over_real_crlb",
    "frequency_coverage",
    "loss_factor_coverage",
    "frequency_error_largest",
];

/// A row for each mode of each method and case, as CSV.
pub fn accuracy_modes_csv(rows: &[AccuracyRow]) -> String {
    let comment = "each mode of each case; bias: mean error over the bound, which scatters by \
                   1/sqrt(seeds) where there is none";
    let modes = rows.iter().flat_map(|row| {
        row.modes
            .iter()
            .enumerate()
            .map(move |(n, mode)| mode_cells(row, n, mode))
    });
    csv::table(comment, &MODE_HEADER, modes)
}

fn mode_cells(row: &AccuracyRow, n: usize, mode: &ModeErrors) -> Vec<String> {
    let pairs = [
        mode.bound,
        mode.over_free,
        mode.bias_over_free,
        mode.over_rank_one,
        mode.over_real,
        mode.coverage,
    ];
    let numbers = [mode.frequency_hz, mode.loss_factor, mode.found]
        .into_iter()
        .chain(pairs.concat())
        .chain([mode.relative_error]);
    [row.case.name.to_owned(), row.name(), (n + 1).to_string()]
        .into_iter()
        .chain(numbers.map(csv::number))
        .collect()
}
