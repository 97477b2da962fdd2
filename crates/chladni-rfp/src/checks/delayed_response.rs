//! A response that lags the others: a filter, a multiplexer, another clock.
//!
//! The responses of a real shape have one phase, up to their sign. A delay τ of one turns it by
//! −ω_nτ in every mode, and by nothing else. Poles and rank-one shapes absorb that; so what tells
//! it is that the others have a common phase, and that the phases of this one lie on a line
//! through zero over frequency. That must be likelier than phases of no order of the same size,
//! as complex shapes have them, by more than the looks at delays and responses bring by chance
//! (theory.md, eq. F2b).

use crate::checks::case::{Case, Checked};
use crate::checks::delay::{Line, Trials};
use crate::checks::limits;
use crate::tolerances::SIGMA_OF_MEDIAN;
use chladni_frf::{Finding, Mode};
use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// A response with its delay.
struct Delayed {
    /// Its place.
    response: usize,
    /// s; positive: it lags.
    seconds: f64,
    /// s, one sigma.
    deviation: f64,
    /// Modes that tell it.
    modes: usize,
}

/// Names responses that lag or lead the others.
pub(crate) fn delayed_responses(case: &Case) -> Option<Checked> {
    let responses = &case.model.responses;
    if responses.len() < limits::AGREE_LEAST {
        return None;
    }
    let modes = case.sure_modes();
    let seen: Vec<Phases> = modes.iter().filter_map(|mode| Phases::of(mode)).collect();
    if seen.len() < limits::RESPONSE_LEAST_MODES {
        return None;
    }
    let natural = spread(seen.iter().flat_map(|own| own.turned()));
    if natural > limits::LEFT_OVER {
        return None;
    }
    let omega: Vec<f64> = seen.iter().map(|own| own.omega).collect();
    let trials = Trials::new(&omega);
    let found: Vec<Delayed> = (0..responses.len())
        .into_par_iter()
        .filter_map(|response| delay_of(response, responses.len(), &seen, &trials, natural))
        .collect();
    // of two groups as large as each other neither is the one that lags
    if found.is_empty() || 2 * found.len() >= responses.len() {
        return None;
    }
    let named: Vec<String> = found
        .iter()
        .map(|own| {
            let lags = if own.seconds > 0.0 { "lags" } else { "leads" };
            format!(
                "{} {lags} by {:.4} ms (± {:.4}, from {} modes)",
                responses[own.response],
                1e3 * own.seconds.abs(),
                1e3 * own.deviation,
                own.modes
            )
        })
        .collect();
    let words = format!(
        "delayed response: against the other responses, {}, read off the phases of the shapes; \
         poles are not touched, but shapes are wrong there, and their scale where it is a \
         driving point",
        named.join(", ")
    );
    let finding = Finding::caution("delayed-response", words)
        .list("delay_ms", found.iter().map(|own| 1e3 * own.seconds))
        .dofs(found.iter().map(|own| responses[own.response]))
        .help("correct the delay of that channel");
    Some(finding.into())
}

/// Phases of a mode at the responses that show it well.
struct Phases {
    /// rad/s.
    omega: f64,
    /// Phase against the common one, rad, modulo 180°, and its variance by noise; `None` where
    /// the mode is weak.
    at: Vec<Option<(f64, f64)>>,
    /// Spread of the phases, rad.
    natural: f64,
    /// Variance of the common phase.
    of_common: f64,
}

impl Phases {
    /// `None` where too few responses show the mode.
    fn of(mode: &Mode) -> Option<Self> {
        let std = mode.shape_std_up_to_scale();
        // unit phasor of the doubled phase, variance
        let seen = mode.shape.0.iter().zip(&std).map(|(value, std)| {
            let relative = std / value.norm().max(f64::MIN_POSITIVE);
            (relative < limits::WELL_SEEN)
                .then(|| (value * value / value.norm_sqr(), 0.5 * relative * relative))
        });
        let seen: Vec<Option<(Complex64, f64)>> = seen.collect();
        let count = seen.iter().flatten().count();
        if count < limits::AGREE_LEAST {
            return None;
        }
        let off = |doubled: Complex64, common: Complex64| 0.5 * (doubled * common.conj()).arg();
        let mut common = Complex64::default();
        for round in 0..limits::COMMON_ROUNDS {
            let weighted = seen.iter().flatten().map(|&(doubled, variance)| {
                let far = if round > 0 { off(doubled, common) } else { 0.0 };
                doubled / (limits::REAL_PHASE.powi(2) + variance + far * far)
            });
            common = weighted.sum();
        }
        let at: Vec<Option<(f64, f64)>> = seen
            .iter()
            .map(|own| own.map(|(doubled, variance)| (off(doubled, common), variance)))
            .collect();
        let natural = spread(at.iter().flatten().map(|(phase, _)| *phase));
        let information = |variance: f64| 1.0 / (natural.powi(2) + variance);
        let all = at
            .iter()
            .flatten()
            .map(|(_, variance)| information(*variance));
        let of_common = 1.0 / (all.sum::<f64>() * (1.0 - 1.0 / count as f64));
        Some(Self {
            omega: TAU * mode.frequency_hz,
            at,
            natural,
            of_common,
        })
    }

    /// Phases at all responses that show the mode.
    fn turned(&self) -> impl Iterator<Item = f64> + '_ {
        self.at.iter().flatten().map(|(phase, _)| *phase)
    }
}

/// Spread of phases, rad, whatever a few of them are: from the median of their size.
fn spread(phases: impl Iterator<Item = f64>) -> f64 {
    let mut sizes: Vec<f64> = phases.map(f64::abs).collect();
    sizes.sort_by(f64::total_cmp);
    let median = sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
    limits::REAL_PHASE.max(SIGMA_OF_MEDIAN * median)
}

/// Delay of a response where the modes show one.
fn delay_of(
    response: usize,
    responses: usize,
    seen: &[Phases],
    trials: &Trials,
    natural: f64,
) -> Option<Delayed> {
    let (mut omega, mut phases, mut weight) = (Vec::new(), Vec::new(), Vec::new());
    for own in seen {
        if let Some((phase, variance)) = own.at[response] {
            omega.push(own.omega);
            phases.push(phase);
            weight.push(1.0 / (natural.max(own.natural).powi(2) + variance + own.of_common));
        }
    }
    let misfit = |phases: &[f64]| -> f64 {
        let terms = phases.iter().zip(&weight);
        terms.map(|(p, w)| w * p * p).sum()
    };
    let undelayed = misfit(&phases);
    let sigmas = limits::DELAY_SIGMAS.powi(2);
    let count = omega.len() as f64;
    // half of what noise leaves on the line, at least
    if omega.len() < limits::RESPONSE_LEAST_MODES || undelayed < sigmas + limits::NOISE_LEFT * count
    {
        return None;
    }
    let turned = phases.iter().zip(&weight);
    let line = Line {
        omega: &omega,
        weight: &weight,
        doubled: turned
            .map(|(p, w)| w * Complex64::from_polar(1.0, 2.0 * p))
            .collect(),
    };
    let mut shown = line.doubled.iter();
    let of_all: Vec<Complex64> = seen
        .iter()
        .map(|own| own.at[response].and_then(|_| shown.next().copied()))
        .map(Option::unwrap_or_default)
        .collect();
    let seconds = line.settled(trials.best(&of_all, |sum| sum.re));
    let left = misfit(&line.phases(seconds));
    let known = line.moment().sqrt();
    let deviation = (left / (count - 1.0)).max(1.0).sqrt() / known;
    // log-likelihoods but for a common term: on the line; of no order, normal or uniform
    let on_line = weight.iter().map(|w| 0.5 * w.ln()).sum::<f64>() - 0.5 * left;
    let size = phases.iter().map(|p| p * p).sum::<f64>() / count;
    let of_no_order = -0.5 * count * (size.ln() + 1.0).min((0.5 * PI).ln());
    let looks = (1.0 + 2.0 * seconds.abs() * known).ln() + (responses as f64).ln();
    let top = omega.iter().copied().fold(0.0, f64::max);
    let shown = on_line - of_no_order > looks + limits::DELAY_LIKELIER
        && undelayed - left > sigmas
        && seconds.abs() > limits::DELAY_SIGMAS * deviation
        && seconds.abs() * top > limits::LEAST_PHASE;
    shown.then_some(Delayed {
        response,
        seconds,
        deviation,
        modes: omega.len(),
    })
}
