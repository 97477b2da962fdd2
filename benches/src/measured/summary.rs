//! A row for each cell and way: bias, error, coverage.

use super::outcome::Decision;
use super::{MeasuredCell, MeasuredOutcome, MeasuredRow, MeasuredWay};
use crate::csv;
use crate::statistics::{mean, quantile, root_mean_square};

/// Half the width of a 95 % interval of a real value, and of a complex one, in standard
/// deviations (√ln 20).
const INTERVAL: [f64; 2] = [1.96, 1.731];

/// The outcome of all tests of a cell in one way.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredSummary {
    /// Settings of its measurement.
    pub cell: MeasuredCell,
    /// The way of estimating and fitting it.
    pub way: MeasuredWay,
    /// Tests.
    pub tests: usize,
    /// Part of the true modes that was found.
    pub found: f64,
    /// Modes per test that stand for none, and those called sure.
    pub spurious: [f64; 2],
    /// Mean relative error of loss factors.
    pub loss_bias: f64,
    /// Root mean square of it.
    pub loss_rmse: f64,
    /// Root mean square error of frequencies over half the bandwidth.
    pub frequency_rmse: f64,
    /// Coverage of 95 % intervals: frequency, loss factor, shape.
    pub coverage: [f64; 3],
    /// Bounds that one value in twenty exceeds, in standard deviations: frequency, loss
    /// factor, shape.
    pub one_in_twenty: [f64; 3],
    /// Right, wrong and open decisions on what errors of neighbouring lines share.
    pub decisions: [usize; 3],
}

/// One for each cell and way, in the order of the rows.
pub fn measured_summary(rows: &[MeasuredRow]) -> Vec<MeasuredSummary> {
    let mut groups: Vec<(MeasuredCell, MeasuredWay, Vec<&MeasuredOutcome>)> = Vec::new();
    for row in rows {
        let own = groups
            .iter_mut()
            .find(|(cell, way, _)| *cell == row.cell && *way == row.way);
        match own {
            Some((.., outcomes)) => outcomes.push(&row.outcome),
            None => groups.push((row.cell, row.way, vec![&row.outcome])),
        }
    }
    groups
        .into_iter()
        .map(|(cell, way, outcomes)| summed(cell, way, &outcomes))
        .collect()
}

fn summed(cell: MeasuredCell, way: MeasuredWay, outcomes: &[&MeasuredOutcome]) -> MeasuredSummary {
    let tests = outcomes.len();
    let modes = || outcomes.iter().flat_map(|outcome| &outcome.modes);
    let count = |of: &dyn Fn(&MeasuredOutcome) -> usize| -> f64 {
        outcomes.iter().map(|outcome| of(outcome) as f64).sum()
    };
    let sigmas: [Vec<f64>; 3] = [
        modes().map(|mode| mode.frequency_sigmas.abs()).collect(),
        modes().map(|mode| mode.loss_sigmas.abs()).collect(),
        modes()
            .flat_map(|mode| &mode.shape_sigmas)
            .copied()
            .collect(),
    ];
    let intervals = [INTERVAL[0], INTERVAL[0], INTERVAL[1]];
    let covered = |n: usize| {
        mean(
            sigmas[n]
                .iter()
                .map(|sigmas| f64::from(u8::from(*sigmas < intervals[n]))),
        )
    };
    MeasuredSummary {
        cell,
        way,
        tests,
        found: count(&|o| o.modes.len()) / count(&|o| o.true_modes),
        spurious: [
            count(&|o| o.spurious) / tests as f64,
            count(&|o| o.spurious_sure) / tests as f64,
        ],
        loss_bias: mean(modes().map(|mode| mode.loss_error)),
        loss_rmse: root_mean_square(modes().map(|mode| mode.loss_error)),
        frequency_rmse: root_mean_square(modes().map(|mode| mode.frequency_error)),
        coverage: [0, 1, 2].map(covered),
        one_in_twenty: [0, 1, 2].map(|n| quantile(&sigmas[n], 0.95)),
        decisions: [Decision::Right, Decision::Wrong, Decision::Undecided]
            .map(|decision| outcomes.iter().filter(|o| o.witness == decision).count()),
    }
}

/// The table as a file.
pub fn measured_csv(summaries: &[MeasuredSummary]) -> String {
    const HEADER: [&str; 27] = [
        "case",
        "way",
        "tests",
        "responses",
        "forces",
        "window",
        "averages",
        "overlap",
        "lines_per_bandwidth",
        "drop_db",
        "force_snr_db",
        "snr_db",
        "found",
        "spurious",
        "spurious_sure",
        "loss_bias",
        "loss_rmse",
        "frequency_rmse_half_bandwidths",
        "frequency_within_95",
        "loss_within_95",
        "shape_within_95",
        "frequency_one_in_twenty",
        "loss_one_in_twenty",
        "shape_one_in_twenty",
        "decisions_right",
        "decisions_wrong",
        "decisions_open",
    ];
    let cells = |row: &MeasuredSummary| {
        let cell = &row.cell;
        let mut out = vec![
            cell.name(),
            row.way.name().to_owned(),
            row.tests.to_string(),
            cell.responses.to_string(),
            cell.forces.to_string(),
            cell.window_name(),
            cell.averages().to_string(),
        ];
        let numbers = [
            cell.overlap,
            cell.lines_per_bandwidth,
            cell.drop_db,
            cell.force_snr_db,
            cell.snr_db,
            row.found,
            row.spurious[0],
            row.spurious[1],
            row.loss_bias,
            row.loss_rmse,
            row.frequency_rmse,
        ];
        let numbers = numbers
            .into_iter()
            .chain(row.coverage)
            .chain(row.one_in_twenty);
        out.extend(numbers.map(csv::number));
        out.extend(row.decisions.map(|count| count.to_string()));
        out
    };
    let comment = "tests simulated in time; errors of loss factors are relative, those of \
                   frequencies in half-bandwidths, one_in_twenty in standard deviations";
    csv::table(comment, &HEADER, summaries.iter().map(cells))
}
