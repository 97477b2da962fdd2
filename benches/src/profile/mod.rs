//! The time of a fit, stage by stage, against the floor measured in the same run.

mod figures;
mod floor;
mod least_work;
mod memory;
mod scaling;

pub use figures::{profile_figure, scaling_figure};
pub use floor::Floor;
pub use scaling::{scaling, scaling_csv, ScalingRow};

use crate::cases::panel;
use crate::countdown::Countdown;
use crate::csv;
use crate::journal::{nan, Journal};
use crate::large::{large, Size};
use crate::problem::Problem;
use crate::statistics::{distinct, largest, median};
use chladni_frf::{Error, ErrorKind, FrfSet, ModalModel, Result, Trust};
use chladni_rfp::{fit_watched, CancelToken, FitOptions, Method};
use least_work::least_work;
use serde::{Deserialize, Serialize};
use std::sync::Mutex;
use std::time::Instant;

/// Before the first stage names itself: selection of lines and FRFs, their scale.
const FIRST_STAGE: &str = "screening";

/// A set to time a fit on.
#[derive(Debug, Clone, Copy)]
pub struct ProfileCase {
    /// Name in tables.
    pub name: &'static str,
    /// Part of a quick run.
    pub quick: bool,
    /// Largest ratio of a fit to the floor: `lean`, `auto`.
    pub target: [f64; 2],
    modes: usize,
    repeats: usize,
    make: fn() -> Result<FrfSet>,
}

/// 5 000 responses from 20 references: 100 000 FRFs of 2001 lines and 20 modes.
const LARGE: Size = Size {
    responses: 5000,
    references: 20,
    lines: 2001,
    modes: 20,
    single: false,
};

/// All sets.
pub const PROFILE_CASES: [ProfileCase; 4] = [
    ProfileCase {
        name: "panel",
        quick: true,
        target: [4.0, 10.0],
        modes: 34,
        repeats: 5,
        make: || Ok(Problem::of_panel(&panel())?.measured(0)),
    },
    ProfileCase {
        name: "10000-frfs",
        quick: true,
        target: [2.5, 2.5],
        modes: 20,
        repeats: 3,
        make: || {
            large(Size {
                responses: 500,
                ..LARGE
            })
        },
    },
    ProfileCase {
        name: "100000-frfs-f32",
        quick: false,
        target: [2.5, 2.5],
        modes: 20,
        repeats: 2,
        make: || {
            large(Size {
                single: true,
                ..LARGE
            })
        },
    },
    ProfileCase {
        name: "100000-frfs",
        quick: false,
        target: [2.5, 2.5],
        modes: 20,
        repeats: 2,
        make: || large(LARGE),
    },
];

/// One timed stage, or a sum.
#[derive(Debug, Clone)]
pub struct ProfileRow {
    /// Stage, `fit` (all of them), or `floor: ...`.
    pub stage: String,
    /// Median over the repeats, s.
    pub time_s: f64,
    /// Set.
    pub case: String,
    /// Method.
    pub method: Method,
    /// Part of the fit.
    pub part: f64,
    /// Over the floor measured beside it; the median of the ratios.
    pub over_floor: f64,
    /// The least work that the stage cannot do without: flop, bytes; NaN where that is
    /// not known.
    pub work: [f64; 2],
    /// The same over the time.
    pub rate: [f64; 2],
    /// Largest resident memory during the fit, the data included, over the data; not
    /// known on all systems.
    pub memory_over_data: f64,
    /// The same, bytes.
    pub peak_bytes: f64,
}

/// A set of FRFs to profile.
#[derive(Debug, Clone)]
pub enum ProfileSource {
    /// A named one.
    Named(&'static ProfileCase),
    /// One that was measured: its name, and its FRFs.
    Given(String, Box<FrfSet>),
}

/// Fits of a set that somebody brings.
const GIVEN_REPEATS: usize = 3;

impl ProfileSource {
    fn name(&self) -> &str {
        match self {
            Self::Named(case) => case.name,
            Self::Given(name, _) => name,
        }
    }
    fn repeats(&self) -> usize {
        match self {
            Self::Named(case) => case.repeats,
            Self::Given(..) => GIVEN_REPEATS,
        }
    }
    /// The modes that it holds, where that is known.
    fn modes(&self) -> Option<usize> {
        match self {
            Self::Named(case) => Some(case.modes),
            Self::Given(..) => None,
        }
    }
    fn frf(&self) -> Result<FrfSet> {
        match self {
            Self::Named(case) => (case.make)(),
            Self::Given(_, frf) => Ok((**frf).clone()),
        }
    }
}

/// Settings of the run.
#[derive(Debug, Clone)]
pub struct ProfileOptions {
    /// Sets.
    pub cases: Vec<ProfileSource>,
    /// Methods.
    pub methods: Vec<Method>,
}

/// Times each method on each set; `progress` hears what is being done.
///
/// # Errors
/// None for the sets of this crate, but those of the journal.
pub fn profile(
    options: &ProfileOptions,
    journal: &mut Journal,
    progress: &dyn Fn(&str),
) -> Result<Vec<ProfileRow>> {
    let fits = options
        .cases
        .iter()
        .map(|source| source.repeats() * options.methods.len())
        .sum();
    let mut countdown = Countdown::new(fits, progress);
    let mut rows = Vec::new();
    for source in &options.cases {
        let mut frf = None;
        for &method in &options.methods {
            let mut runs: Vec<Run> = Vec::new();
            for repeat in 1..=source.repeats() {
                let name = format!(
                    "{}: {method}, {repeat} of {}",
                    source.name(),
                    source.repeats()
                );
                let done = journal.has(&name);
                if frf.is_none() && !done {
                    progress(&format!("{}: FRFs", source.name()));
                    frf = Some(source.frf()?);
                }
                countdown.next(&name, done);
                runs.push(journal.once(&name, || match &frf {
                    Some(frf) => Run::new(source, method, frf),
                    None => Err(Error::new(
                        ErrorKind::Internal,
                        "the journal forgot a finished fit",
                    )),
                })?);
            }
            rows.extend(summary(source, method, &runs));
        }
    }
    Ok(rows)
}

/// One fit with its floor.
#[derive(Serialize, Deserialize)]
struct Run {
    stages: Vec<(String, f64)>,
    fit_s: f64,
    floor: Floor,
    /// Values, unknowns of one FRF.
    size: [f64; 2],
    #[serde(deserialize_with = "nan")]
    memory_over_data: f64,
    #[serde(deserialize_with = "nan")]
    peak_bytes: f64,
}

impl Run {
    fn new(source: &ProfileSource, method: Method, frf: &FrfSet) -> Result<Self> {
        let options = FitOptions {
            method,
            modes: source.modes().filter(|_| method == Method::Lean),
            ..FitOptions::default()
        };
        let before = memory::resident_bytes().filter(|_| memory::forget_peak());
        let marks = Mutex::new(vec![(FIRST_STAGE.to_owned(), Instant::now())]);
        let mark = |stage: &str| {
            marks
                .lock()
                .expect("no other thread")
                .push((stage.to_owned(), Instant::now()))
        };
        let fitted = fit_watched(frf, &options, &mark, &CancelToken::new());
        let end = Instant::now();
        let peak = memory::peak_bytes();
        let model = fitted
            .map_err(|error| refused(source, method, &error.to_string()))?
            .model;
        let marks = marks.into_inner().expect("no other thread");
        let ends = marks.iter().skip(1).map(|mark| mark.1).chain([end]);
        let unknowns = unknowns(&model);
        let (responses, references, lines) = frf.values.dim();
        let floor = Floor::measure(frf, unknowns);
        let added = before
            .zip(peak)
            .map_or(f64::NAN, |(before, peak)| peak - before);
        Ok(Self {
            fit_s: (end - marks[0].1).as_secs_f64(),
            stages: joined(
                marks
                    .iter()
                    .zip(ends)
                    .map(|((stage, start), end)| (stage.clone(), (end - *start).as_secs_f64())),
            ),
            memory_over_data: 1.0 + added / floor.bytes,
            peak_bytes: floor.bytes + added,
            size: [(responses * references * lines) as f64, unknowns as f64],
            floor,
        })
    }
}

/// A fit that was refused: our bug on our own sets, a matter of the data on others.
fn refused(source: &ProfileSource, method: Method, why: &str) -> Error {
    let kind = if let ProfileSource::Named(_) = source {
        ErrorKind::Internal
    } else {
        ErrorKind::BadData
    };
    Error::new(
        kind,
        format!("{method} cannot fit {}: {why}", source.name()),
    )
}

/// Stages of the same name together, in the order of their first appearance.
fn joined(stages: impl Iterator<Item = (String, f64)>) -> Vec<(String, f64)> {
    let mut sums: Vec<(String, f64)> = Vec::new();
    for (stage, time_s) in stages {
        match sums.iter_mut().find(|(name, _)| *name == stage) {
            Some((_, sum)) => *sum += time_s,
            None => sums.push((stage, time_s)),
        }
    }
    sums
}

/// Poles and residual terms of one FRF; a pole of higher rank counts once.
fn unknowns(model: &ModalModel) -> usize {
    let mut poles: Vec<[u64; 2]> = model
        .modes
        .iter()
        .filter(|mode| mode.trust != Trust::Rejected)
        .map(|mode| [mode.frequency_hz.to_bits(), mode.loss_factor.to_bits()])
        .collect();
    poles.sort_unstable();
    poles.dedup();
    poles.len() + model.residual_terms.terms.len()
}

fn summary(source: &ProfileSource, method: Method, runs: &[Run]) -> Vec<ProfileRow> {
    let over_runs =
        |value: &dyn Fn(&Run) -> f64| median(&runs.iter().map(value).collect::<Vec<_>>());
    let fit_s = over_runs(&|run| run.fit_s);
    let row =
        |stage: &str, value: &dyn Fn(&Run) -> f64, work: &dyn Fn(&Run) -> [f64; 2]| ProfileRow {
            stage: stage.to_owned(),
            time_s: over_runs(value),
            case: source.name().to_owned(),
            method,
            part: over_runs(value) / fit_s,
            over_floor: over_runs(&|run| value(run) / run.floor.total_s()),
            work: [0, 1].map(|which| over_runs(&|run| work(run)[which])),
            rate: [0, 1].map(|which| over_runs(&|run| work(run)[which] / value(run))),
            memory_over_data: f64::NAN,
            peak_bytes: f64::NAN,
        };
    let unknown = |_: &Run| [f64::NAN; 2];
    let stage_s = |run: &Run, name: &str| {
        run.stages
            .iter()
            .find(|(stage, _)| stage == name)
            .map_or(0.0, |(_, time_s)| *time_s)
    };
    let stages = runs.iter().flat_map(|run| &run.stages);
    let names = distinct(stages.map(|(name, _)| name));
    let least = |name: &str| {
        let name = name.to_owned();
        move |run: &Run| least_work(&name, run.size, run.floor.bytes)
    };
    let mut rows: Vec<ProfileRow> = names
        .into_iter()
        .map(|name| row(name, &|run| stage_s(run, name), &least(name)))
        .collect();
    let largest_of = |value: fn(&Run) -> f64| largest(&runs.iter().map(value).collect::<Vec<_>>());
    rows.push(ProfileRow {
        memory_over_data: largest_of(|run| run.memory_over_data),
        peak_bytes: largest_of(|run| run.peak_bytes),
        ..row("fit", &|run| run.fit_s, &unknown)
    });
    rows.push(row(
        "floor: one pass over memory",
        &|run| run.floor.memory_s,
        &|run| [f64::NAN, run.floor.bytes],
    ));
    rows.push(row(
        "floor: 16NMm flop",
        &|run| run.floor.flop_s(),
        &|run| [run.floor.flop, f64::NAN],
    ));
    rows.push(row("floor", &|run| run.floor.total_s(), &|run| {
        [run.floor.flop, run.floor.bytes]
    }));
    rows
}

impl ProfileRow {
    /// The most that `fit` may take over the floor; `None` for stages, and for methods
    /// without such a target.
    pub fn target(&self) -> Option<f64> {
        let case = PROFILE_CASES
            .iter()
            .find(|case| case.name == self.case)
            .filter(|_| self.stage == "fit")?;
        match self.method.as_str() {
            "lean" => Some(case.target[0]),
            "auto" => Some(case.target[1]),
            _ => None,
        }
    }
}

/// The rows as CSV.
pub fn profile_csv(rows: &[ProfileRow]) -> String {
    let header = [
        "stage",
        "time_s",
        "case",
        "method",
        "part_of_fit",
        "over_floor",
        "least_gflop",
        "least_gbyte",
        "gflop_per_s",
        "gbyte_per_s",
        "memory_over_data",
        "peak_gbyte",
    ];
    let comment =
        "medians over the repeats; floor: one pass over memory and 16 N M m flop at the speed of the back end's complex product; \
                   least: what a stage cannot do without, so that its rates are at least these";
    let cells = |row: &ProfileRow| {
        let giga = [row.work[0], row.work[1], row.rate[0], row.rate[1]].map(|value| 1e-9 * value);
        let memory = [row.memory_over_data, 1e-9 * row.peak_bytes];
        let numbers = [row.part, row.over_floor]
            .into_iter()
            .chain(giga)
            .chain(memory);
        let names = [
            row.stage.clone(),
            csv::number(row.time_s),
            row.case.clone(),
            row.method.to_string(),
        ];
        names.into_iter().chain(numbers.map(csv::number)).collect()
    };
    csv::table(comment, &header, rows.iter().map(cells))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: ProfileCase = ProfileCase {
        name: "small",
        quick: true,
        target: [1.0, 1.0],
        modes: 3,
        repeats: 1,
        make: || {
            large(Size {
                responses: 60,
                references: 2,
                lines: 400,
                modes: 3,
                single: true,
            })
        },
    };

    #[test]
    fn stages_add_up_to_the_fit_and_the_floor_to_its_parts() {
        let options = ProfileOptions {
            cases: vec![ProfileSource::Named(&SMALL)],
            methods: vec![Method::Auto],
        };
        let rows = profile(&options, &mut Journal::none(), &|_| {}).unwrap();
        let time_s = |stage: &str| rows.iter().find(|row| row.stage == stage).unwrap().time_s;
        let stages = rows
            .iter()
            .filter(|row| row.stage != "fit" && !row.stage.starts_with("floor"));
        assert!((stages.map(|row| row.time_s).sum::<f64>() / time_s("fit") - 1.0).abs() < 1e-9);
        let parts = time_s("floor: one pass over memory") + time_s("floor: 16NMm flop");
        assert!((parts / time_s("floor") - 1.0).abs() < 1e-9);
        // three modes and at least one residual term: 16 flop each per value
        let [flop_per_s, _] = rows
            .iter()
            .find(|row| row.stage == "floor: 16NMm flop")
            .unwrap()
            .rate;
        assert!(
            time_s("floor: 16NMm flop") * flop_per_s
                >= 16.0 * 4.0 * (120 * 400) as f64 * (1.0 - 1e-9)
        );
        assert!(profile_csv(&rows)
            .lines()
            .nth(1)
            .unwrap()
            .starts_with("stage,time_s,"));
    }
}
