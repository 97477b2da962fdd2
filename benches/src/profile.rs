//! Where the time of a fit goes, stage by stage, against the floor measured in the same run.

use crate::cases::panel;
use crate::floor::Floor;
use crate::large::{large, Size};
use crate::problem::Problem;
use crate::statistics::{largest, median};
use crate::{csv, memory};
use chladni_frf::{Error, ErrorKind, FrfSet, ModalModel, Result, Trust};
use chladni_rfp::{fit, FitOptions, Method};
use std::cell::RefCell;
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
const LARGE: Size = Size { responses: 5000, references: 20, lines: 2001, modes: 20, single: false };

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
        make: || large(Size { responses: 500, ..LARGE }),
    },
    ProfileCase {
        name: "100000-frfs-f32",
        quick: false,
        target: [2.5, 2.5],
        modes: 20,
        repeats: 2,
        make: || large(Size { single: true, ..LARGE }),
    },
    ProfileCase { name: "100000-frfs", quick: false, target: [2.5, 2.5], modes: 20, repeats: 2, make: || large(LARGE) },
];

/// One timed stage, or a sum.
#[derive(Debug, Clone)]
pub struct ProfileRow {
    /// Stage, `fit` (all of them), or `floor: ...`.
    pub stage: String,
    /// Median over the repeats, s.
    pub time_s: f64,
    /// Set.
    pub case: &'static str,
    /// Method.
    pub method: Method,
    /// Part of the fit.
    pub part: f64,
    /// Over the floor measured beside it; the median of the ratios.
    pub over_floor: f64,
    /// Work per time where it is known: flop/s, bytes/s.
    pub rate: [f64; 2],
    /// Largest resident memory during the fit, the data included, over the data; not known on all systems.
    pub memory_over_data: f64,
}

/// What to run.
#[derive(Debug, Clone)]
pub struct ProfileOptions {
    /// Sets.
    pub cases: Vec<&'static ProfileCase>,
    /// Methods.
    pub methods: Vec<Method>,
}

/// Times each method on each set; `progress` hears what is being done.
///
/// # Errors
/// None for the sets of this crate.
pub fn profile(options: &ProfileOptions, progress: &dyn Fn(&str)) -> Result<Vec<ProfileRow>> {
    let mut rows = Vec::new();
    for &case in &options.cases {
        progress(&format!("{}: making the FRFs", case.name));
        let frf = (case.make)()?;
        for &method in &options.methods {
            progress(&format!("{}: {method}, {} times", case.name, case.repeats));
            let runs: Vec<Run> = (0..case.repeats).map(|_| Run::new(case, method, &frf)).collect::<Result<_>>()?;
            rows.extend(summary(case, method, &runs));
        }
    }
    Ok(rows)
}

/// One fit with its floor.
struct Run {
    stages: Vec<(String, f64)>,
    fit_s: f64,
    floor: Floor,
    memory_over_data: f64,
}

impl Run {
    fn new(case: &ProfileCase, method: Method, frf: &FrfSet) -> Result<Self> {
        let options = FitOptions { method, modes: (method.as_str() == "lean").then_some(case.modes), ..FitOptions::default() };
        let before = memory::resident_bytes().filter(|_| memory::forget_peak());
        let marks = RefCell::new(vec![(FIRST_STAGE.to_owned(), Instant::now())]);
        let fitted = fit(frf, &options, &|stage| marks.borrow_mut().push((stage.to_owned(), Instant::now())));
        let end = Instant::now();
        let peak = memory::peak_bytes();
        let model = fitted.map_err(|error| Error::new(ErrorKind::Internal, format!("{method} fails on {}: {error}", case.name)))?.model;
        let marks = marks.into_inner();
        let ends = marks.iter().skip(1).map(|mark| mark.1).chain([end]);
        let floor = Floor::measure(frf, unknowns(&model));
        let added = before.zip(peak).map_or(f64::NAN, |(before, peak)| peak - before);
        Ok(Self {
            fit_s: (end - marks[0].1).as_secs_f64(),
            stages: joined(marks.iter().zip(ends).map(|((stage, start), end)| (stage.clone(), (end - *start).as_secs_f64()))),
            memory_over_data: 1.0 + added / floor.bytes,
            floor,
        })
    }
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

fn summary(case: &'static ProfileCase, method: Method, runs: &[Run]) -> Vec<ProfileRow> {
    let over_runs = |value: &dyn Fn(&Run) -> f64| median(&runs.iter().map(value).collect::<Vec<_>>());
    let fit_s = over_runs(&|run| run.fit_s);
    let row = |stage: &str, value: &dyn Fn(&Run) -> f64, rate: [f64; 2]| ProfileRow {
        stage: stage.to_owned(),
        time_s: over_runs(value),
        case: case.name,
        method,
        part: over_runs(value) / fit_s,
        over_floor: over_runs(&|run| value(run) / run.floor.total_s()),
        rate,
        memory_over_data: f64::NAN,
    };
    let unknown = [f64::NAN; 2];
    let stage_s = |run: &Run, name: &str| run.stages.iter().find(|(stage, _)| stage == name).map_or(0.0, |(_, time_s)| *time_s);
    let mut names: Vec<&String> = runs.iter().flat_map(|run| run.stages.iter().map(|(name, _)| name)).collect();
    let mut seen = Vec::new();
    names.retain(|name| {
        !seen.contains(name) && {
            seen.push(name);
            true
        }
    });
    let mut rows: Vec<ProfileRow> = names.into_iter().map(|name| row(name, &|run| stage_s(run, name), unknown)).collect();
    let memory_over_data = largest(&runs.iter().map(|run| run.memory_over_data).collect::<Vec<_>>());
    rows.push(ProfileRow { memory_over_data, ..row("fit", &|run| run.fit_s, unknown) });
    let bandwidth = over_runs(&|run| run.floor.bytes / run.floor.memory_s);
    rows.push(row("floor: one pass over memory", &|run| run.floor.memory_s, [f64::NAN, bandwidth]));
    rows.push(row("floor: 16NMm flop", &|run| run.floor.flop_s(), [over_runs(&|run| run.floor.flop_per_s), f64::NAN]));
    rows.push(row("floor", &|run| run.floor.total_s(), unknown));
    rows
}

impl ProfileRow {
    /// The most that `fit` may take over the floor; `None` for stages, and for methods without such a target.
    pub fn target(&self) -> Option<f64> {
        let case = PROFILE_CASES.iter().find(|case| case.name == self.case).filter(|_| self.stage == "fit")?;
        match self.method.as_str() {
            "lean" => Some(case.target[0]),
            "auto" => Some(case.target[1]),
            _ => None,
        }
    }
}

/// The rows as CSV.
pub fn profile_csv(rows: &[ProfileRow]) -> String {
    let header = ["stage", "time_s", "case", "method", "part_of_fit", "over_floor", "gflop_per_s", "gbyte_per_s", "memory_over_data"];
    let comment = "medians over the repeats; floor: one pass over memory and 16 N M m flop at the speed of the back end's complex product";
    let cells = |row: &ProfileRow| {
        let numbers = [row.part, row.over_floor, 1e-9 * row.rate[0], 1e-9 * row.rate[1], row.memory_over_data];
        let names = [row.stage.clone(), csv::number(row.time_s), row.case.to_owned(), row.method.to_string()];
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
        make: || large(Size { responses: 60, references: 2, lines: 400, modes: 3, single: true }),
    };

    #[test]
    fn stages_add_up_to_the_fit_and_the_floor_to_its_parts() {
        let rows = profile(&ProfileOptions { cases: vec![&SMALL], methods: vec![Method::Auto] }, &|_| {}).unwrap();
        let time_s = |stage: &str| rows.iter().find(|row| row.stage == stage).unwrap().time_s;
        let stages = rows.iter().filter(|row| row.stage != "fit" && !row.stage.starts_with("floor"));
        assert!((stages.map(|row| row.time_s).sum::<f64>() / time_s("fit") - 1.0).abs() < 1e-9);
        let parts = time_s("floor: one pass over memory") + time_s("floor: 16NMm flop");
        assert!((parts / time_s("floor") - 1.0).abs() < 1e-9);
        // three modes and at least one residual term: 16 flop each per value
        let [flop_per_s, _] = rows.iter().find(|row| row.stage == "floor: 16NMm flop").unwrap().rate;
        assert!(time_s("floor: 16NMm flop") * flop_per_s >= 16.0 * 4.0 * (120 * 400) as f64 * (1.0 - 1e-9));
        assert!(profile_csv(&rows).lines().nth(1).unwrap().starts_with("stage,time_s,"));
    }
}
