//! Accuracy against time: every method on every case, over many noise seeds, measured by the Cramér-Rao bound.

use crate::cases::Case;
use crate::csv;
use crate::problem::{Bounds, Problem};
use crate::score::{half_half_width_hz, Match, Score};
use crate::statistics::{largest, mean, median, quantile, root_mean_square};
use chladni_frf::Result;
use chladni_plate::CramerRao;
use chladni_rfp::{fit, FitOptions, Method};
use std::time::Instant;

/// Methods that do not maximise a likelihood scatter so far above the bound that one seed in so many tells as much.
const FEWER_SEEDS: usize = 10;
/// Seeds of the worst outcomes that a row names.
const NAMED_SEEDS: usize = 5;

/// What to run.
#[derive(Debug, Clone)]
pub struct AccuracyOptions {
    /// Cases.
    pub cases: Vec<&'static Case>,
    /// Methods.
    pub methods: Vec<Method>,
    /// Noise seeds 0, 1, ... of the methods that maximise the likelihood; others take a tenth of them, two at least.
    pub seeds: usize,
}

/// What one method made of one case.
#[derive(Debug, Clone)]
pub struct AccuracyRow {
    /// The case.
    pub case: &'static Case,
    /// The method.
    pub method: Method,
    /// Noise seeds.
    pub seeds: usize,
    /// Seconds of each fit: median, first and third quartile.
    pub time_s: [f64; 3],
    /// Root mean square error over the bound of free residues: natural frequencies and loss factors.
    pub over_free: [Spread; 2],
    /// The same over the bound with one shape per mode.
    pub over_rank_one: [Spread; 2],
    /// Root mean square error of all natural frequencies over the bound of free residues, a missed mode counting as half its
    /// bandwidth.
    pub with_missed: f64,
    /// Share of the 95 % intervals that hold the truth: natural frequencies, loss factors, shape entries.
    pub coverage: [f64; 3],
    /// Modes in the band.
    pub modes: usize,
    /// Missed, spurious as sure, spurious as weak: mean per fit.
    pub miscounts: [f64; 3],
    /// Share of the fits with the exact count.
    pub exact: f64,
    /// Fits that went wrong (missed or spurious modes) though they say that they can be trusted and all modes are sure.
    pub silent: usize,
    /// First seeds whose count is not exact.
    pub wrong_seeds: Vec<usize>,
    /// Modal assurance criterion with the true shape: median and least.
    pub mac: [f64; 2],
    /// Rms error of the FRFs against those without noise, dB re their rms.
    pub frf_error_db: f64,
    /// Largest relative error of a natural frequency that was found.
    pub frequency_error: f64,
    /// The largest bound of a natural frequency, in half-power bandwidths of its mode.
    pub bound_over_bandwidth: f64,
}

/// Median over the modes, and the worst one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Median.
    pub median: f64,
    /// Worst.
    pub worst: f64,
}

/// Runs every method on every case; `progress` hears what is being done.
///
/// # Errors
/// None for the cases of this crate: a fit that cannot be made counts as one that found nothing.
pub fn accuracy(options: &AccuracyOptions, progress: &dyn Fn(&str)) -> Result<Vec<AccuracyRow>> {
    let mut rows = Vec::new();
    for &case in &options.cases {
        progress(&format!("{}: truth and bounds", case.name));
        let problem = case.problem()?;
        let bounds = problem.bounds()?;
        for &method in &options.methods {
            let seeds = if statistical(method) { options.seeds } else { (options.seeds / FEWER_SEEDS).max(2).min(options.seeds) };
            progress(&format!("{}: {method}, {seeds} seeds", case.name));
            let (scores, times): (Vec<Score>, Vec<f64>) = (0..seeds).map(|seed| run(&problem, method, seed)).unzip();
            rows.push(AccuracyRow::new(case, method, &problem, bounds.as_ref(), &scores, &times));
        }
    }
    Ok(rows)
}

/// True for the methods that end in a maximum-likelihood step.
fn statistical(method: Method) -> bool {
    matches!(method.as_str(), "auto" | "lean")
}

fn run(problem: &Problem, method: Method, seed: usize) -> (Score, f64) {
    let frf = problem.measured(seed as u64);
    let modes = problem.truth.in_band_modes().count();
    // `lean` is for those who know the order
    let options = FitOptions { method, modes: (method.as_str() == "lean").then_some(modes), ..FitOptions::default() };
    let start = Instant::now();
    let fitted = fit(&frf, &options, &|_| {});
    let time_s = start.elapsed().as_secs_f64();
    (fitted.map_or_else(|_| Score::failed(problem), |fitted| Score::new(&fitted.model, problem)), time_s)
}

impl AccuracyRow {
    fn new(case: &'static Case, method: Method, problem: &Problem, bounds: Option<&Bounds>, scores: &[Score], times: &[f64]) -> Self {
        let known: Vec<_> = problem.truth.in_band_modes().collect();
        let found = || scores.iter().flat_map(|score| score.matches.iter().flatten());
        let per_fit = |count: fn(&Score) -> usize| mean(scores.iter().map(|score| count(score) as f64));
        let share = |covered: fn(&Match) -> f64| mean(found().map(covered));
        let over = |bound: fn(&Bounds) -> &CramerRao| match bounds.map(bound) {
            Some(bound) => [
                errors_over(scores, &bound.frequency_std_hz, |found| found.frequency_hz),
                errors_over(scores, &bound.loss_factor_std, |found| found.loss_factor),
            ],
            None => [Spread { median: f64::NAN, worst: f64::NAN }; 2],
        };
        let free = bounds.map(|bounds| bounds.free.frequency_std_hz.as_slice()).unwrap_or_default();
        let with_missed = scores.iter().flat_map(|score| {
            let modes = score.matches.iter().zip(&known).zip(free);
            modes.map(|((found, mode), bound)| found.as_ref().map_or(half_half_width_hz(mode), |found| found.frequency_hz) / bound)
        });
        let relative = scores.iter().flat_map(|score| {
            let found = score.matches.iter().zip(&known);
            found.filter_map(|(found, mode)| Some(found.as_ref()?.frequency_hz.abs() / mode.frequency_hz))
        });
        let macs: Vec<f64> = found().map(|found| found.mac).collect();
        let wrong: Vec<usize> = (0..scores.len()).filter(|&seed| !scores[seed].exact()).collect();
        Self {
            case,
            method,
            seeds: scores.len(),
            time_s: [0.5, 0.25, 0.75].map(|share| quantile(times, share)),
            over_free: over(|bounds| &bounds.free),
            over_rank_one: over(|bounds| &bounds.rank_one),
            with_missed: root_mean_square(with_missed),
            coverage: [
                share(|found| f64::from(u8::from(found.frequency_covered))),
                share(|found| f64::from(u8::from(found.loss_factor_covered))),
                share(|found| found.shape_covered),
            ],
            modes: known.len(),
            miscounts: [per_fit(Score::missed), per_fit(|score| score.spurious_sure), per_fit(|score| score.spurious_weak)],
            exact: 1.0 - wrong.len() as f64 / scores.len() as f64,
            silent: wrong.iter().filter(|&&seed| scores[seed].confident).count(),
            wrong_seeds: wrong.into_iter().take(NAMED_SEEDS).collect(),
            mac: [median(&macs), quantile(&macs, 0.0)],
            frf_error_db: 20.0 * median(&scores.iter().map(|score| score.frf_error).collect::<Vec<_>>()).log10(),
            frequency_error: largest(&relative.collect::<Vec<_>>()),
            bound_over_bandwidth: largest(
                &free.iter().zip(&known).map(|(bound, mode)| bound / (2.0 * half_half_width_hz(mode))).collect::<Vec<_>>(),
            ),
        }
    }

    /// True where the case has a target and it is reached; `None` where it has none.
    pub fn on_target(&self) -> Option<bool> {
        let target = self.case.target?;
        Some(self.over_free.iter().all(|spread| spread.median <= target.median && spread.worst <= target.worst))
    }
}

/// Root mean square over the seeds of each mode's error over its bound; median and worst mode. Modes never found are left out.
fn errors_over(scores: &[Score], bounds: &[f64], error: fn(&Match) -> f64) -> Spread {
    let of_mode =
        |n: usize| root_mean_square(scores.iter().filter_map(|score| score.matches[n].as_ref()).map(|found| error(found) / bounds[n]));
    let modes: Vec<f64> = (0..bounds.len()).map(of_mode).collect();
    Spread { median: median(&modes), worst: largest(&modes) }
}

/// Columns of the file.
const HEADER: [&str; 29] = [
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
    "mac_median",
    "mac_least",
    "frf_error_db",
    "frequency_error_largest",
    "crlb_over_bandwidth_largest",
    "seeds",
    "time_quartiles_s",
];

/// The rows as CSV.
pub fn accuracy_csv(rows: &[AccuracyRow]) -> String {
    let comment = "errors over Cramer-Rao bounds: median over the modes and worst mode; missed and spurious: mean per fit; times: median";
    csv::table(comment, &HEADER, rows.iter().map(cells))
}

fn cells(row: &AccuracyRow) -> Vec<String> {
    let spreads = row.over_free.iter().chain(&row.over_rank_one).flat_map(|spread| [spread.median, spread.worst]);
    let seeds: Vec<String> = row.wrong_seeds.iter().map(ToString::to_string).collect();
    [row.case.name.to_owned(), row.method.to_string(), csv::number(row.time_s[0])]
        .into_iter()
        .chain(spreads.chain([row.with_missed]).chain(row.coverage).map(csv::number))
        .chain([row.modes.to_string()])
        .chain(row.miscounts.into_iter().chain([row.exact]).map(csv::number))
        .chain([row.silent.to_string(), seeds.join(" ")])
        .chain(row.mac.into_iter().chain([row.frf_error_db, row.frequency_error, row.bound_over_bandwidth]).map(csv::number))
        .chain([row.seeds.to_string(), format!("{} {}", csv::number(row.time_s[1]), csv::number(row.time_s[2]))])
        .collect()
}
