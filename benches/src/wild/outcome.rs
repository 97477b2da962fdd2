//! One fit of a drawn structure against its truth.

use super::draw::Draw;
use super::evidence::evidence;
use super::measurement::{measurement, Measurement};
use crate::journal::nan;
use crate::score::{nearest_first, pole_distance_hz};
use chladni_frf::{Damping, Finding, FrfSet, ModalModel, Mode, Result, Trust};
use chladni_rfp::{fit, FitError, FitOptions};
use serde::{Deserialize, Serialize};
use std::panic::{catch_unwind, AssertUnwindSafe};
use std::time::Instant;

/// 95 % of a normal distribution lie within so many standard deviations.
const SIGMAS_95: f64 = 1.96;
/// A mode that lies farther from the truth than this many of its stated deviations, and
/// half the half-power bandwidth, is another mode.
const SIGMAS_PAIR: f64 = 4.0;
/// An error beyond so many of its own standard deviations is a wrong result.
const BEYOND: f64 = 6.0;
/// Findings that speak of the damping law.
const LAW_UNDECIDABLE: &str = "law-undecidable";
const LAW_IF_PHASES_TRUE: &str = "law-if-phases-true";
/// Those, and findings on the scale of shapes: they announce no wrong count.
const ASIDE: [&str; 4] = [
    LAW_UNDECIDABLE,
    LAW_IF_PHASES_TRUE,
    "scale-unknown",
    "unscaled",
];

/// The outcome of one seed.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// True modes of the band that were found.
    pub found: usize,
    /// Those that were not, though the data show them.
    pub missed: usize,
    /// Those that were not, and that the data do not show.
    pub hidden: usize,
    /// Modes of the band without a partner in the truth.
    pub spurious: usize,
    /// Those of them that are called sure.
    pub spurious_sure: usize,
    /// Sure modes whose error is beyond six of its stated standard deviations.
    pub beyond: usize,
    /// The result says that something may be wrong: exit 1, a weak mode, a warning.
    pub announced: bool,
    /// Codes of the findings, in order.
    #[serde(default)]
    pub findings: Vec<String>,
    /// The law of the result; `None` where there is none.
    pub viscous: Option<bool>,
    /// The result says that the laws cannot be told apart.
    pub undecidable: bool,
    /// The law of the result is not the true one.
    pub law_wrong: bool,
    /// The other law would move a sure mode by more than its standard deviation.
    pub law_matters: bool,
    /// χ² per degree of freedom as stated.
    #[serde(deserialize_with = "nan")]
    pub chi2_per_dof: f64,
    /// Found modes whose natural frequency, and whose loss factor, lies within the 95 %
    /// interval.
    pub covered: [usize; 2],
    /// A panic or a failed kernel, in its words: a bug.
    pub internal: Option<String>,
    /// A fit that was refused, in its words.
    pub refused: Option<String>,
    /// Seconds of the fit.
    pub time_s: f64,
}

impl Outcome {
    /// Draws, measures and fits the structure of a seed.
    ///
    /// # Errors
    /// None for what [`Draw::new`] draws.
    pub(super) fn of(draw: &Draw) -> Result<Self> {
        let measured = measurement(draw)?;
        let start = Instant::now();
        let fitted = attempt(&measured.frf);
        let time_s = start.elapsed().as_secs_f64();
        let all = measured.truth.in_band_modes().count();
        let outcome = match fitted {
            Ok(model) => Self::new(&measured, &model),
            Err(failure) => Self {
                missed: all,
                chi2_per_dof: f64::NAN,
                announced: true,
                internal: failure.as_ref().err().cloned(),
                refused: failure.ok(),
                ..Self::default()
            },
        };
        Ok(Self { time_s, ..outcome })
    }

    fn new(measured: &Measurement, model: &ModalModel) -> Self {
        let known: Vec<&Mode> = measured.truth.modes.iter().collect();
        let given = |mode: &&Mode| mode.trust != Trust::Rejected;
        let found: Vec<&Mode> = model.modes.iter().filter(given).collect();
        let pairs = pair(&known, &found);
        let inside: Vec<(&Mode, &Mode)> = pairs
            .iter()
            .filter(|(k, _)| known[*k].in_band)
            .map(|&(k, f)| (known[k], found[f]))
            .collect();
        let alone = |f: &usize| found[*f].in_band && pairs.iter().all(|(_, other)| other != f);
        let spurious: Vec<usize> = (0..found.len()).filter(alone).collect();
        let left_out: Vec<usize> = (0..known.len())
            .filter(|k| known[*k].in_band && pairs.iter().all(|(other, _)| other != k))
            .collect();
        let hidden = left_out
            .iter()
            .filter(|&&k| evidence(measured, k) < 1.0)
            .count();
        let errors = |(known, found): &(&Mode, &Mode)| {
            [
                (found.frequency_hz - known.frequency_hz).abs() / found.frequency_std_hz,
                (found.loss_factor - known.loss_factor).abs() / found.loss_factor_std,
            ]
        };
        let covered = |which: usize| {
            let within = |pair: &&(&Mode, &Mode)| errors(pair)[which] <= SIGMAS_95;
            inside.iter().filter(within).count()
        };
        let beyond = |pair: &&(&Mode, &Mode)| {
            pair.1.trust == Trust::Sure && errors(pair).iter().any(|error| *error > BEYOND)
        };
        Self {
            found: inside.len(),
            missed: left_out.len() - hidden,
            hidden,
            spurious: spurious.len(),
            spurious_sure: spurious
                .iter()
                .filter(|&&f| found[f].trust == Trust::Sure)
                .count(),
            beyond: inside.iter().filter(beyond).count(),
            announced: announced(model),
            findings: model
                .quality
                .findings
                .iter()
                .map(|f| f.code.to_string())
                .collect(),
            viscous: Some(model.damping == Damping::Viscous),
            undecidable: warns_of(model, LAW_UNDECIDABLE),
            law_wrong: model.damping != measured.truth.damping,
            law_matters: model.in_band_modes().any(law_matters),
            chi2_per_dof: model.quality.chi2_per_dof,
            covered: [covered(0), covered(1)],
            ..Self::default()
        }
    }

    /// All modes that the data show were found, and no other.
    pub fn exact(&self) -> bool {
        self.missed + self.spurious == 0 && self.failure().is_none()
    }

    /// A sure mode lies beyond six of its stated standard deviations, and nothing is said
    /// that would explain it: a law that cannot be told shifts all modes.
    pub fn overconfident(&self) -> bool {
        let of_law = self.law_conditional() && self.law_wrong;
        let said = self.undecidable || self.announced || of_law;
        self.beyond > 0 && !said
    }

    /// The result says that its law holds if phases are true.
    pub fn law_conditional(&self) -> bool {
        self.findings.iter().any(|code| code == LAW_IF_PHASES_TRUE)
    }

    /// The count is wrong, and the result does not say that anything may be.
    pub fn silent(&self) -> bool {
        !self.exact() && !self.announced
    }

    /// The reason that there is no result.
    pub fn failure(&self) -> Option<&str> {
        self.internal.as_deref().or(self.refused.as_deref())
    }
}

/// The model; else why there is none, `Err` where that is a bug.
fn attempt(frf: &FrfSet) -> std::result::Result<ModalModel, std::result::Result<String, String>> {
    let fitted = catch_unwind(AssertUnwindSafe(|| fit(frf, &FitOptions::default())));
    match fitted {
        Ok(Ok(fitted)) => match broken(&fitted.model) {
            None => Ok(fitted.model),
            Some(field) => Err(Err(format!("{field} is not finite"))),
        },
        Ok(Err(FitError::Kernel(error))) => Err(Err(error.to_string())),
        Ok(Err(error)) => Err(Ok(error.to_string())),
        Err(panic) => {
            let text = panic
                .downcast_ref::<String>()
                .cloned()
                .or_else(|| panic.downcast_ref::<&str>().map(ToString::to_string));
            Err(Err(format!("panic: {}", text.unwrap_or_default())))
        }
    }
}

/// A number of the model that no file can hold.
fn broken(model: &ModalModel) -> Option<String> {
    let quality = [model.quality.relative_error, model.quality.chi2_per_dof];
    if quality.iter().any(|value| !value.is_finite()) {
        return Some("quality".into());
    }
    let of_mode = |mode: &&Mode| {
        let numbers = [
            mode.frequency_hz,
            mode.frequency_std_hz,
            mode.loss_factor,
            mode.loss_factor_std,
            mode.mpc,
        ];
        let vectors = mode.shape.0.iter().chain(&mode.participation.0);
        !numbers
            .into_iter()
            .chain(vectors.flat_map(|v| [v.re, v.im]))
            .chain(mode.shape_std.iter().copied())
            .all(f64::is_finite)
    };
    let mode = model.modes.iter().find(of_mode)?;
    Some(format!("a number of the mode at {} Hz", mode.frequency_hz))
}

/// True where the mode is sure and the other law, which shifts frequencies by η²/4 and loss
/// factors by about 0.28η² of themselves (theory.md, section 2), would move it beyond its
/// standard deviation.
fn law_matters(mode: &Mode) -> bool {
    let square = mode.loss_factor.powi(2);
    let moved = |share: f64, value: f64, std: f64| share * square * value > std;
    mode.trust == Trust::Sure
        && (moved(0.25, mode.frequency_hz, mode.frequency_std_hz)
            || moved(0.28, mode.loss_factor, mode.loss_factor_std))
}

fn announced(model: &ModalModel) -> bool {
    let tells = |finding: &Finding| !ASIDE.contains(&finding.code.as_ref());
    !model.quality.trusted
        || model.in_band_modes().any(|mode| mode.trust == Trust::Weak)
        || model.quality.findings.iter().any(tells)
}

fn warns_of(model: &ModalModel, code: &str) -> bool {
    model
        .quality
        .findings
        .iter()
        .any(|finding| finding.code == code)
}

/// Pairs (true mode, found mode), poles nearest first: within half the half-power bandwidth,
/// or, up to the whole of it, within what the bar allows.
fn pair(known: &[&Mode], found: &[&Mode]) -> Vec<(usize, usize)> {
    let mut near = Vec::new();
    for (k, known) in known.iter().enumerate() {
        let bandwidth_hz = known.loss_factor * known.frequency_hz;
        for (f, found) in found.iter().enumerate() {
            let distance_hz = (found.frequency_hz - known.frequency_hz).abs();
            let allowed_hz = SIGMAS_PAIR * found.frequency_std_hz;
            if distance_hz <= allowed_hz.clamp(0.5 * bandwidth_hz, bandwidth_hz) {
                near.push((pole_distance_hz(known, found), k, f));
            }
        }
    }
    nearest_first(near)
}
