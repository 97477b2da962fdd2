//! Tests whether methods know when they fail, and whether their error bars hold.

use super::{Map, StabilityRow, Trial};
use crate::solver::Solver;

/// Classes of the rank histogram.
pub(super) const RANKS: usize = 10;
/// 68 and 95 % of a normal distribution lie within so many standard deviations.
const SIGMAS: [f64; 2] = [1.0, 1.96];

/// Outcomes of one method on one map; without a map, on all of them.
#[derive(Debug, Clone)]
pub struct Calibration {
    /// The map; `None`: all maps.
    pub map: Option<&'static Map>,
    /// The method.
    pub solver: Solver,
    /// Right and quiet.
    pub quiet: usize,
    /// Right, with a weak mode or a warning all the same.
    pub false_alarms: usize,
    /// Wrong, and said so.
    pub announced: usize,
    /// Wrong without a word.
    pub silent: usize,
    /// Those of the silent ones that only miss modes which the data do not show.
    pub silent_hidden: usize,
    /// Modes found, for the shares and ranks.
    pub modes: usize,
    /// Share of the errors within 1 and within 1.96 of their standard deviations, natural
    /// frequencies: 68 and 95 % are right.
    pub frequency_coverage: [f64; 2],
    /// The same for loss factors.
    pub loss_factor_coverage: [f64; 2],
    /// Natural frequencies found by the place of their error in its stated distribution,
    /// in tenths: all alike where bars are right.
    pub frequency_ranks: [usize; RANKS],
    /// The same for loss factors.
    pub loss_factor_ranks: [usize; RANKS],
}

/// One entry for each method and map, and one for each method over all maps. Shares and
/// ranks over all maps count those where white noise is all that stands between data and
/// model.
pub fn calibration(rows: &[StabilityRow]) -> Vec<Calibration> {
    let mut solvers: Vec<Solver> = Vec::new();
    rows.iter().for_each(|row| {
        if !solvers.contains(&row.solver) {
            solvers.push(row.solver)
        }
    });
    let mut all = Vec::new();
    for solver in solvers {
        let own: Vec<&StabilityRow> = rows.iter().filter(|row| row.solver == solver).collect();
        let mut maps: Vec<&'static Map> = Vec::new();
        own.iter().for_each(|row| {
            if maps.iter().all(|map| map.name != row.map.name) {
                maps.push(row.map)
            }
        });
        all.push(Calibration::new(None, solver, &own));
        all.extend(maps.into_iter().map(|map| {
            let of_map: Vec<&StabilityRow> = own
                .iter()
                .filter(|row| row.map.name == map.name)
                .copied()
                .collect();
            Calibration::new(Some(map), solver, &of_map)
        }));
    }
    all
}

impl Calibration {
    fn new(map: Option<&'static Map>, solver: Solver, rows: &[&StabilityRow]) -> Self {
        let trials: Vec<&Trial> = rows
            .iter()
            .flat_map(|row| row.trials.iter().map(|(_, trial)| trial))
            .collect();
        let count = |wrong: bool, announced: bool| {
            trials
                .iter()
                .filter(|t| t.wrong() == wrong && t.announced() == announced)
                .count()
        };
        let bars = rows
            .iter()
            .filter(|row| map.is_some() || row.map.calibrates());
        let errors: Vec<[f64; 2]> = bars
            .flat_map(|row| {
                row.trials
                    .iter()
                    .flat_map(|(_, trial)| trial.standardised.clone())
            })
            .collect();
        let shares = |which: usize| {
            SIGMAS.map(|limit| {
                errors
                    .iter()
                    .filter(|pair| pair[which].abs() <= limit)
                    .count() as f64
                    / errors.len() as f64
            })
        };
        let ranks = |which: usize| {
            let mut classes = [0; RANKS];
            for pair in &errors {
                classes[((normal_share(pair[which]) * RANKS as f64) as usize).min(RANKS - 1)] += 1;
            }
            classes
        };
        Self {
            map,
            solver,
            quiet: count(false, false),
            false_alarms: count(false, true),
            announced: count(true, true),
            silent: count(true, false),
            silent_hidden: trials
                .iter()
                .filter(|t| t.wrong() && !t.announced() && !t.visibly_wrong())
                .count(),
            modes: errors.len(),
            frequency_coverage: shares(0),
            loss_factor_coverage: shares(1),
            frequency_ranks: ranks(0),
            loss_factor_ranks: ranks(1),
        }
    }

    /// Share of the wrong results that were announced; NaN where nothing is wrong.
    pub fn announced_share(&self) -> f64 {
        self.announced as f64 / (self.announced + self.silent) as f64
    }
}

/// Share of a standard normal distribution below `z` (Abramowitz & Stegun 26.2.17, error
/// below 1e-7); NaN counts as the middle.
fn normal_share(z: f64) -> f64 {
    if z.is_nan() {
        return 0.5;
    }
    let t = 1.0 / (1.0 + 0.231_641_9 * z.abs());
    let series = [
        0.319_381_530,
        -0.356_563_782,
        1.781_477_937,
        -1.821_255_978,
        1.330_274_429,
    ];
    let tail = (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt()
        * series.iter().rev().fold(0.0, |sum, c| (sum + c) * t);
    if z > 0.0 {
        1.0 - tail
    } else {
        tail
    }
}

#[cfg(test)]
mod tests {
    use super::super::MAPS;
    use super::*;

    #[test]
    fn shares_of_the_normal_distribution_are_those_of_the_tables() {
        for (z, share) in [
            (0.0, 0.5),
            (1.0, 0.841_344_7),
            (-1.0, 0.158_655_3),
            (1.96, 0.975_002_1),
            (-5.0, 2.867e-7),
        ] {
            assert!((normal_share(z) - share).abs() < 1e-7, "{z}");
        }
    }

    #[test]
    fn outcomes_fall_into_four_classes_and_errors_into_their_ranks() {
        let quiet = Trial {
            found: 2,
            trusted: true,
            standardised: vec![[0.1, -3.0], [-0.1, 0.5]],
            ..Trial::default()
        };
        let alarm = Trial {
            weak: 1,
            ..quiet.clone()
        };
        let silent = Trial {
            missed: 1,
            ..quiet.clone()
        };
        let hidden = Trial {
            hidden: 1,
            ..silent.clone()
        };
        let announced = Trial {
            warnings: vec!["a word".into()],
            ..silent.clone()
        };
        let trials = (0..)
            .zip([quiet, alarm, silent, hidden, announced])
            .collect();
        let row = StabilityRow {
            map: &MAPS[0],
            solver: Solver::Identify(Default::default()),
            cell: [0, 0],
            trials,
        };
        assert_eq!(
            row.silent().map(|(seed, _)| *seed).collect::<Vec<_>>(),
            [2, 3]
        );
        let all = calibration(&[row]);
        assert_eq!(all.len(), 2);
        for c in &all {
            assert_eq!(
                [
                    c.quiet,
                    c.false_alarms,
                    c.announced,
                    c.silent,
                    c.silent_hidden
                ],
                [1, 1, 1, 2, 1]
            );
            assert_eq!(
                (c.modes, c.frequency_coverage, c.loss_factor_coverage),
                (10, [1.0, 1.0], [0.5, 0.5])
            );
            assert_eq!(
                (
                    c.frequency_ranks[4],
                    c.frequency_ranks[5],
                    c.loss_factor_ranks[0]
                ),
                (5, 5, 5)
            );
            assert!((c.announced_share() - 1.0 / 3.0).abs() < 1e-12);
        }
    }
}
