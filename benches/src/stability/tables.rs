//! The tables of stability: cells, failures, calibration.

use super::{Calibration, StabilityRow, Trial};
use crate::csv;
use crate::statistics::{mean, median};

/// Columns after the two axes.
const MEASURED: [&str; 15] = [
    "found",
    "missed",
    "spurious",
    "announced",
    "wrong",
    "silent",
    "beyond_stated",
    "missed_hidden",
    "error_over_bound",
    "error_over_stated",
    "served",
    "condition",
    "trusted",
    "chi2_per_dof",
    "seeds",
];

/// A row for each method and cell: counts are means per try; `announced`, `wrong`,
/// `silent` and `trusted` shares of the tries. A row has numbers in the columns of its
/// own map's axes.
pub fn stability_csv(rows: &[StabilityRow]) -> String {
    let mut axes: Vec<&str> = Vec::new();
    for column in rows
        .iter()
        .flat_map(|row| [row.map.x.column, row.map.y.column])
    {
        if !axes.contains(&column) {
            axes.push(column);
        }
    }
    let header: Vec<&str> = ["case", "method"]
        .into_iter()
        .chain(axes.iter().copied())
        .chain(MEASURED)
        .collect();
    let comment =
        "mean counts per try; shares of tries that are announced (weak mode, warning, refusal, not \
         trusted), wrong, wrong and silent";
    let cells = rows.iter().map(|row| {
        let place = axes.iter().map(|column| match *column {
            own if own == row.map.x.column => row.map.x.text(row.cell[0]),
            own if own == row.map.y.column => row.map.y.text(row.cell[1]),
            _ => String::new(),
        });
        [row.map.name.to_owned(), row.solver.to_string()]
            .into_iter()
            .chain(place)
            .chain(measured(row))
            .collect()
    });
    csv::table(comment, &header, cells)
}

fn measured(row: &StabilityRow) -> impl Iterator<Item = String> {
    let per_try = |count: &dyn Fn(&Trial) -> usize| {
        mean(row.trials.iter().map(|(_, trial)| count(trial) as f64))
    };
    let share = |holds: &dyn Fn(&Trial) -> bool| per_try(&|trial| usize::from(holds(trial)));
    let middle = |value: &dyn Fn(&Trial) -> f64| {
        median(
            &row.trials
                .iter()
                .map(|(_, trial)| value(trial))
                .collect::<Vec<_>>(),
        )
    };
    let error = middle(&|trial| trial.error);
    let [stated, served] = if row.map.identifies() {
        [error, f64::NAN]
    } else {
        [f64::NAN, error]
    };
    [
        per_try(&|trial| trial.found),
        per_try(&|trial| trial.missed),
        per_try(&|trial| trial.spurious_sure + trial.spurious_weak),
        share(&Trial::announced),
        share(&Trial::wrong),
        share(&|trial| trial.wrong() && !trial.announced()),
        per_try(&|trial| trial.beyond),
        per_try(&|trial| trial.hidden),
        middle(&|trial| trial.error_over_bound),
        stated,
        served,
        middle(&|trial| trial.condition),
        share(&|trial| trial.trusted),
        middle(&|trial| trial.chi2),
        row.trials.len() as f64,
    ]
    .map(csv::number)
    .into_iter()
}

/// Columns of the table of failures.
const FAILURES: [&str; 15] = [
    "case",
    "method",
    "x",
    "y",
    "seed",
    "announced",
    "missed",
    "missed_hidden",
    "spurious_sure",
    "spurious_weak",
    "beyond_stated",
    "worst_error",
    "weak",
    "chi2_per_dof",
    "warnings",
];

/// A row for each try that went wrong, with its seed.
pub fn failures_csv(rows: &[StabilityRow]) -> String {
    let wrong = rows.iter().flat_map(|row| {
        row.trials
            .iter()
            .filter(|(_, trial)| trial.wrong())
            .map(move |tried| (row, tried))
    });
    let cells = wrong.map(|(row, (seed, trial))| {
        let place = [
            row.map.name.to_owned(),
            row.solver.to_string(),
            format!("{} {}", row.map.x.column, row.map.x.text(row.cell[0])),
            format!("{} {}", row.map.y.column, row.map.y.text(row.cell[1])),
            seed.to_string(),
            trial.announced().to_string(),
        ];
        let counts = [
            trial.missed,
            trial.hidden,
            trial.spurious_sure,
            trial.spurious_weak,
            trial.beyond,
        ]
        .map(|count| count.to_string());
        let rest = [
            csv::number(trial.error),
            trial.weak.to_string(),
            csv::number(trial.chi2),
            trial.warnings.join(" | "),
        ];
        place.into_iter().chain(counts).chain(rest).collect()
    });
    csv::table(
        "every try with a missed or spurious mode, an error beyond 5 stated standard deviations, \
         or a drive that does not serve",
        &FAILURES,
        cells,
    )
}

/// A row for each method over all maps, and for each of them.
pub fn calibration_csv(all: &[Calibration]) -> String {
    let ranks = |name: &'static str| {
        (1..=super::calibration::RANKS).map(move |k| format!("{name}_rank_{k}"))
    };
    let header: Vec<String> = [
        "case",
        "method",
        "right_quiet",
        "right_announced",
        "wrong_announced",
        "wrong_silent",
        "wrong_silent_hidden",
        "announced_share_of_wrong",
        "modes",
        "frequency_within_1_sigma",
        "frequency_within_1.96_sigma",
        "loss_factor_within_1_sigma",
        "loss_factor_within_1.96_sigma",
    ]
    .into_iter()
    .map(String::from)
    .chain(ranks("frequency"))
    .chain(ranks("loss_factor"))
    .collect();
    let cells = all.iter().map(|c| {
        let names = [
            c.map.map_or("all", |map| map.name).to_owned(),
            c.solver.to_string(),
        ];
        let counts = [
            c.quiet,
            c.false_alarms,
            c.announced,
            c.silent,
            c.silent_hidden,
        ]
        .map(|count| count.to_string());
        let shares = [c.frequency_coverage, c.loss_factor_coverage].concat();
        let ranks = c
            .frequency_ranks
            .iter()
            .chain(&c.loss_factor_ranks)
            .map(ToString::to_string);
        names
            .into_iter()
            .chain(counts)
            .chain([csv::number(c.announced_share()), c.modes.to_string()])
            .chain(shares.into_iter().map(csv::number))
            .chain(ranks)
            .collect()
    });
    let comment =
        "tries that are right or wrong, and whether they say so; coverage and ranks over all maps \
         count those with white noise alone";
    csv::table(
        comment,
        &header.iter().map(String::as_str).collect::<Vec<_>>(),
        cells,
    )
}
