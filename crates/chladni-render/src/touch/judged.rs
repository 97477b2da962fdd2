//! Performance of a drive under fingers, and the findings about it.

use super::plan::{Judged, TouchPlan};
use super::program::contrast_db;
use crate::digits::hertz;
use crate::panel::drive::{amplitude, Drive};
use crate::problems::problem::Problem;
use crate::tolerances;
use chladni_frf::Finding;
use serde::{Deserialize, Serialize};

/// A drive under fingers; `/touch` of a weights file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TouchIndices {
    /// Least hot over largest cold velocity under all fingertips and at all places, dB.
    pub contrast_db: Option<f64>,
    /// The firmest fingertip that the drive tolerates with the κ that was asked for.
    pub firmest: Option<String>,
    /// κ under it and all softer ones; under the softest where none is tolerated.
    pub kappa: Option<f64>,
    /// Places that were tried, others than the drive was made for.
    pub places: usize,
    /// The responses under all fingertips.
    pub points: TouchPoints,
    /// False where the size of the modes under a finger had to be guessed.
    pub is_known: bool,
}

/// Shares of responses inside their limits while fingers touch.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct TouchPoints {
    /// Least share of hot ones over the tried fingers.
    pub hot_ratio: f64,
    /// Least share of cold ones.
    pub cold_ratio: f64,
    /// Smaller of both.
    pub min_ratio: f64,
    /// Share of all, mean over the tried fingers.
    pub success_ratio: f64,
}

impl TouchIndices {
    /// Of `drive` on the judged responses of `problem`; `plan` has the places that the drive
    /// was made for, `between` those that it is tried at.
    pub(crate) fn of(
        problem: &Problem,
        judged: Judged,
        [plan, between]: [&TouchPlan; 2],
        drive: &Drive,
    ) -> Self {
        let all = plan.touch.impedances.len();
        let least = plan.touch.kappa_least * (1.0 - tolerances::SAME_TOUCHED_KAPPA);
        let under = |softest: usize| {
            let on = problem.with_between(&plan.rows(judged, softest), 1.0);
            (on.score(drive).kappa, contrast_db(&on, drive))
        };
        let mut found = under(all);
        let contrast_db = found.1;
        let mut softest = all;
        while softest > 1 && found.0 < least {
            softest -= 1;
            found = under(softest);
        }
        let firmest = (found.0 >= least).then(|| plan.touch.impedances[softest - 1].name.clone());
        Self {
            contrast_db,
            firmest,
            kappa: Some(found.0).filter(|kappa| kappa.is_finite()),
            places: between.places(),
            points: points(problem, judged, between, drive),
            is_known: plan.is_known,
        }
    }
}

fn points(problem: &Problem, judged: Judged, plan: &TouchPlan, drive: &Drive) -> TouchPoints {
    let levels = &problem.rows.levels;
    let (mut least, mut served, mut cases) = ([1.0; 3], 0.0, 0.0);
    plan.each(judged, plan.touch.impedances.len(), |_, touched| {
        let field = touched.dot(drive);
        let rows = judged.rows.iter().zip(levels);
        let amplitudes = rows
            .map(|(&row, level)| amplitude(&field[row]) / level)
            .collect();
        let (hot, cold) = problem.counts(&amplitudes, 1.0);
        let ratios = [
            hot as f64 / problem.rows.hot as f64,
            cold as f64 / problem.rows.cold() as f64,
            problem.min_ratio(hot, cold),
        ];
        for (least, ratio) in least.iter_mut().zip(ratios) {
            *least = f64::min(*least, ratio);
        }
        served += (hot + cold) as f64 / amplitudes.len() as f64;
        cases += 1.0;
    });
    let [hot_ratio, cold_ratio, min_ratio] = least;
    TouchPoints {
        hot_ratio,
        cold_ratio,
        min_ratio,
        success_ratio: served / cases,
    }
}

/// The finding on whether a corrected drive tolerates the fingers of its scene.
pub(crate) fn corrected_finding(told: &TouchIndices, plan: &TouchPlan) -> Option<Finding> {
    let firmest = &plan.touch.impedances.last()?.name;
    let points = &told.points;
    let shares = format!(
        "under the fingers at the worst place {:.2} of the responses of the worse zone keep their \
         limit",
        points.min_ratio
    );
    let finding = match &told.firmest {
        Some(name) if name == firmest => {
            let kappa = told
                .kappa
                .map_or(String::new(), |kappa| format!(" with κ {kappa:.1}"));
            let words = format!("the corrected drive tolerates a {name} finger{kappa}; {shares}");
            Finding::note("touch-corrected", words)
        }
        softer => {
            let softer = softer
                .as_ref()
                .map_or(String::new(), |name| format!("; it tolerates a {name} one"));
            let words = format!(
                "the corrected drive does not tolerate a {firmest} finger{softer}; {shares}"
            );
            Finding::caution("touch-corrected", words)
                .help("measure another field, take another frequency, or ask for softer fingers")
        }
    };
    Some(finding.value("min_ratio", points.min_ratio))
}

/// Findings on what no drive tolerates, and what another frequency would.
///
/// * `best_db`: contrast that was found under the firmest, dB; `asked_db`: what is needed
/// * `mode_hz`: the mode nearest to the drive, `elsewhere`: a frequency, the κ there and the
///   fingertip that it is under
pub(crate) fn findings(
    told: &TouchIndices,
    plan: &TouchPlan,
    [drive_hz, asked_db]: [f64; 2],
    best_db: Option<f64>,
    mode_hz: Option<f64>,
    elsewhere: Option<(f64, f64, String)>,
) -> Vec<Finding> {
    let mut findings = Vec::new();
    if !plan.is_known {
        findings.push(
            Finding::note(
                "touch-estimated",
                "the shapes are not mass-scaled: how much a finger changes is an estimate",
            )
            .help("measure a driving point"),
        );
    }
    let Some(firm) = plan.touch.impedances.last() else {
        return findings;
    };
    if told.firmest.as_ref() == Some(&firm.name) {
        return findings;
    }
    let mut words = format!(
        "no drive found tolerates a {} finger at {} Hz",
        firm.name,
        hertz(drive_hz)
    );
    if let Some(db) = best_db.or(told.contrast_db) {
        words += &format!(" ({db:.1} dB, {asked_db:.1} needed)");
    }
    if let Some(hz) = mode_hz {
        words += &format!(": a mode lies at {hz:.1} Hz");
    }
    if let Some(firmest) = &told.firmest {
        words += &format!("; it tolerates a {firmest} one");
    }
    if let Some((hz, kappa, name)) = &elsewhere {
        words += &format!(". At {hz} Hz a drive tolerates a {name} one with κ {kappa:.1}");
    }
    let mut finding = Finding::caution("touch-not-borne", words)
        .help("take another frequency, or ask for softer fingers");
    if let Some((hz, ..)) = elsewhere {
        finding = finding.value("better_hz", hz);
    }
    findings.push(finding.modes_hz(mode_hz));
    findings
}
