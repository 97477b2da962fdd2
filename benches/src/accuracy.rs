//! Accuracy against time: every method on every case, over many noise seeds, measured by
//! the Cramér-Rao bound.

use crate::cases::Case;
use crate::countdown::Countdown;
use crate::journal::Journal;
use crate::knobs::{Knob, Setting, FAMILY, KNOBS, KNOB_CASES};
use crate::mode_errors::{ModeErrors, Spread};
use crate::problem::{Bounds, Problem};
use crate::score::Score;
use crate::statistics::{mean, median, quantile, root_mean_square};
use chladni_frf::Result;
use chladni_rfp::{fit, FitOptions, Method, ShapeModel};
use std::time::Instant;

/// Methods that do not maximise a likelihood scatter so far above the bound that one seed
/// in so many tells as much.
const FEWER_SEEDS: usize = 10;
/// Seeds of the worst outcomes that a row names.
const NAMED_SEEDS: usize = 5;

/// Settings of the runs.
#[derive(Debug, Clone)]
pub struct AccuracyOptions {
    /// Cases.
    pub cases: Vec<&'static Case>,
    /// Methods.
    pub methods: Vec<Method>,
    /// Constraints on shapes while poles are refined.
    pub shapes: ShapeModel,
    /// Number of noise seeds of the methods that maximise the likelihood; others take a
    /// tenth of them, two at least.
    pub seeds: usize,
    /// The first of them; the others follow it.
    pub first_seed: u64,
    /// Also turn the knobs of the methods, on the cases meant for it, with a tenth of the
    /// seeds.
    pub knobs: bool,
}

/// The result of one method on one case.
#[derive(Debug, Clone)]
pub struct AccuracyRow {
    /// The case.
    pub case: &'static Case,
    /// The method.
    pub method: Method,
    /// A knob that is turned; `None`: the method as it is.
    pub setting: Option<Setting>,
    /// Noise seeds.
    pub seeds: usize,
    /// Seconds of each fit: median, first and third quartile.
    pub time_s: [f64; 3],
    /// Root mean square error over the bound of free residues: natural frequencies and
    /// loss factors.
    pub over_free: [Spread; 2],
    /// The same over the bound with one shape per mode.
    pub over_rank_one: [Spread; 2],
    /// The same over the bound with one real shape per mode.
    pub over_real: [Spread; 2],
    /// Root mean square error of all natural frequencies over the bound of free residues,
    /// a missed mode counting as half its bandwidth.
    pub with_missed: f64,
    /// Share of the 95 % intervals that hold the truth: natural frequencies, loss
    /// factors, shape entries.
    pub coverage: [f64; 3],
    /// Each mode in the band.
    pub modes: Vec<ModeErrors>,
    /// Missed, spurious as sure, spurious as weak: mean per fit.
    pub miscounts: [f64; 3],
    /// Share of the fits with the exact count.
    pub exact: f64,
    /// Fits that went wrong (missed or spurious modes) though they say that they can be
    /// trusted and all modes are sure.
    pub silent: usize,
    /// First seeds whose count is not exact.
    pub wrong_seeds: Vec<u64>,
    /// Share of the fits with the wrong damping law.
    pub wrong_law: f64,
    /// First seeds with the wrong damping law.
    pub wrong_law_seeds: Vec<u64>,
    /// Modal assurance criterion with the true shape: median and least.
    pub mac: [f64; 2],
    /// Rms error of the FRFs against those without noise, dB re their rms.
    pub frf_error_db: f64,
    /// Largest relative error of a natural frequency that was found.
    pub frequency_error: f64,
    /// The largest bound of a natural frequency, in half-power bandwidths of its mode.
    pub bound_over_bandwidth: f64,
}

/// Runs every method on every case; `progress` hears what is being done.
///
/// # Errors
/// None for the cases of this crate, but those of the journal: a fit that cannot be made
/// counts as one that found nothing.
pub fn accuracy(
    options: &AccuracyOptions,
    journal: &mut Journal,
    progress: &dyn Fn(&str),
) -> Result<Vec<AccuracyRow>> {
    let variants: Vec<(&'static Case, Vec<Variant>)> = options
        .cases
        .iter()
        .map(|&case| (case, options.variants(case)))
        .collect();
    let pieces = variants
        .iter()
        .flat_map(|(_, variants)| variants)
        .map(|variant| options.seeds_of(*variant))
        .sum();
    let mut countdown = Countdown::new(pieces, progress);
    let mut rows = Vec::new();
    for (case, variants) in variants {
        progress(&format!("{}: truth and bounds", case.name));
        let problem = case.problem()?;
        let bounds = problem.bounds()?;
        for variant in variants {
            let mut fits = Vec::new();
            for seed in (options.first_seed..).take(options.seeds_of(variant)) {
                let name = format!("{} {} {seed}", case.name, variant_name(variant));
                countdown.next(&name, journal.has(&name));
                let (score, time_s) =
                    journal.once(&name, || Ok(run(&problem, variant, options.shapes, seed)))?;
                fits.push((seed, score, time_s));
            }
            rows.push(AccuracyRow::new(
                case,
                variant,
                &problem,
                bounds.as_ref(),
                &fits,
            ));
        }
    }
    Ok(rows)
}

/// A method and a knob of it that is turned.
type Variant = (Method, Option<Setting>);

/// As tables name it.
fn variant_name((method, setting): Variant) -> String {
    setting.map_or_else(
        || method.to_string(),
        |setting| format!("{method}, {setting}"),
    )
}

impl AccuracyOptions {
    /// The variants that are run on a case.
    fn variants(&self, case: &Case) -> Vec<Variant> {
        let mut variants: Vec<Variant> =
            self.methods.iter().map(|&method| (method, None)).collect();
        let turned = self.knobs && KNOB_CASES.contains(&case.name);
        let knobs: &[Knob] = if turned { &KNOBS } else { &[] };
        let own = std::iter::once(&FAMILY)
            .chain(knobs)
            .filter(|knob| self.methods.contains(&knob.method));
        variants.extend(own.flat_map(|knob| {
            knob.settings
                .iter()
                .map(|&setting| (knob.method, Some(setting)))
        }));
        variants
    }

    fn seeds_of(&self, (method, setting): Variant) -> usize {
        // `auto` and `lean` end in a maximum-likelihood step
        let statistical = matches!(method, Method::Auto | Method::Lean) && setting.is_none();
        if statistical {
            self.seeds
        } else {
            (self.seeds / FEWER_SEEDS).max(2).min(self.seeds)
        }
    }
}

/// Score and seconds of one fit.
fn run(
    problem: &Problem,
    (method, setting): Variant,
    shapes: ShapeModel,
    seed: u64,
) -> (Score, f64) {
    let frf = problem.measured(seed);
    let frf = setting.map_or(frf.clone(), |setting| setting.data(frf));
    let modes = problem.truth.in_band_modes().count();
    // `lean` is for those who know the order
    let options = FitOptions {
        method,
        shapes,
        modes: (method == Method::Lean).then_some(modes),
        ..FitOptions::default()
    };
    let options = setting.map_or(options.clone(), |setting| setting.options(options, modes));
    let start = Instant::now();
    let fitted = fit(&frf, &options);
    let time_s = start.elapsed().as_secs_f64();
    (
        fitted.map_or_else(
            |_| Score::failed(problem),
            |fitted| Score::new(&fitted.model, problem),
        ),
        time_s,
    )
}

/// The first seeds whose score meets the condition.
fn seeds_where(fits: &[(u64, Score, f64)], condition: fn(&Score) -> bool) -> Vec<u64> {
    let seeds = fits.iter().filter(|(_, score, _)| condition(score));
    seeds.map(|(seed, ..)| *seed).take(NAMED_SEEDS).collect()
}

impl AccuracyRow {
    fn new(
        case: &'static Case,
        (method, setting): Variant,
        problem: &Problem,
        bounds: Option<&Bounds>,
        fits: &[(u64, Score, f64)],
    ) -> Self {
        let (scores, times): (Vec<Score>, Vec<f64>) = fits
            .iter()
            .map(|(_, score, time_s)| (score.clone(), *time_s))
            .unzip();
        let known = problem.truth.in_band_modes().enumerate();
        let modes: Vec<ModeErrors> = known
            .map(|(n, known)| ModeErrors::new(n, known, bounds, &scores))
            .collect();
        let per_fit =
            |count: fn(&Score) -> usize| mean(scores.iter().map(|score| count(score) as f64));
        let found = || scores.iter().flat_map(|score| &score.matches).flatten();
        let covered = |which: usize| {
            let shares = modes.iter().map(|mode| mode.coverage[which]);
            mean(shares.filter(|share| !share.is_nan()))
        };
        let macs: Vec<f64> = found().map(|found| found.mac).collect();
        let frf_errors: Vec<f64> = scores.iter().map(|score| score.frf_error).collect();
        let wrong = || fits.iter().filter(|(_, score, _)| !score.exact());
        Self {
            case,
            method,
            setting,
            seeds: scores.len(),
            time_s: [0.5, 0.25, 0.75].map(|share| quantile(&times, share)),
            over_free: [0, 1].map(|which| Spread::new(&modes, |mode| mode.over_free[which])),
            over_rank_one: [0, 1]
                .map(|which| Spread::new(&modes, |mode| mode.over_rank_one[which])),
            over_real: [0, 1].map(|which| Spread::new(&modes, |mode| mode.over_real[which])),
            with_missed: root_mean_square(modes.iter().map(ModeErrors::with_missed)),
            coverage: [
                covered(0),
                covered(1),
                mean(found().map(|found| found.shape_covered)),
            ],
            miscounts: [
                per_fit(Score::missed),
                per_fit(|score| score.spurious_sure),
                per_fit(|score| score.spurious_weak),
            ],
            exact: 1.0 - wrong().count() as f64 / scores.len() as f64,
            silent: wrong().filter(|(_, score, _)| score.confident).count(),
            wrong_seeds: seeds_where(fits, |score| !score.exact()),
            wrong_law: per_fit(|score| usize::from(score.wrong_law)),
            wrong_law_seeds: seeds_where(fits, |score| score.wrong_law),
            mac: [median(&macs), quantile(&macs, 0.0)],
            frf_error_db: 20.0 * median(&frf_errors).log10(),
            frequency_error: Spread::new(&modes, |mode| mode.relative_error).worst,
            bound_over_bandwidth: Spread::new(&modes, |mode| mode.bound_over_bandwidth).worst,
            modes,
        }
    }

    /// Method and setting.
    pub fn name(&self) -> String {
        variant_name((self.method, self.setting))
    }

    /// True where the case has a target and it is reached; `None` where it has none.
    pub fn on_target(&self) -> Option<bool> {
        let target = self.case.target?;
        Some(
            self.over_free
                .iter()
                .all(|spread| spread.median <= target.median && spread.worst <= target.worst),
        )
    }
}
