//! A response that lags the others: a filter, a multiplexer, another clock.
//!
//! The responses of a real shape have one phase, up to their sign. A delay τ of one turns it by
//! −ω_nτ in every mode, and by nothing else. Poles and rank-one shapes absorb that; so what tells
//! it is that the others have a common phase, and that the phases of this one lie on a line
//! through zero over frequency. That must be likelier than phases of no order of the same size,
//! as complex shapes have them, by more than the looks at delays and responses bring by chance
//! (theory.md, eq. F2b).

use crate::checks::case::{Case, Checked};
use crate::checks::delay::Trials;
use crate::checks::limits;
use crate::checks::phases::{OneDelay, Phases};
use crate::tolerances::SIGMA_OF_MEDIAN;
use chladni_frf::{Finding, Mode};
use num_complex::Complex64;
use rayon::prelude::*;
use std::f64::consts::TAU;

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
    let found = at_few_responses(case, |response, seen, trials, natural| {
        delay_of(response, responses.len(), seen, trials, natural)
    })?;
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

/// What `of` finds at each response; `None` where it finds nothing, or something at half of them: of
/// two groups as large as each other neither is the one that is off.
///
/// * `of`: is given the response, the phases of all, delays to try, and the spread of the phases
pub(super) fn at_few_responses<T: Send>(
    case: &Case,
    of: impl Fn(usize, &[ModePhases], &Trials, f64) -> Option<T> + Sync,
) -> Option<Vec<T>> {
    let responses = case.model.responses.len();
    let (seen, natural) = phases_of_shapes(case)?;
    let omega: Vec<f64> = seen.iter().map(|own| own.omega).collect();
    let trials = Trials::new(&omega);
    let found: Vec<T> = (0..responses)
        .into_par_iter()
        .filter_map(|response| of(response, &seen, &trials, natural))
        .collect();
    (!found.is_empty() && 2 * found.len() < responses).then_some(found)
}

/// Phases of the modes that show at enough responses, and their spread; `None` where these are too
/// few, or shapes too complex to tell a response from the others.
fn phases_of_shapes(case: &Case) -> Option<(Vec<ModePhases>, f64)> {
    if case.model.responses.len() < limits::AGREE_LEAST {
        return None;
    }
    let modes = case.sure_modes();
    let seen: Vec<ModePhases> = modes
        .iter()
        .filter_map(|mode| ModePhases::of(mode))
        .collect();
    if seen.len() < limits::RESPONSE_LEAST_MODES {
        return None;
    }
    let natural = spread(seen.iter().flat_map(|own| own.turned()));
    (natural <= limits::LEFT_OVER).then_some((seen, natural))
}

/// Phases of a mode at the responses that show it well.
pub(super) struct ModePhases {
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

impl ModePhases {
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

/// Phases of one response in the modes that show it.
pub(super) struct OfResponse {
    pub phases: Phases,
    /// [`Phases::doubled`] of all modes; zero where not shown.
    of_all: Vec<Complex64>,
}

impl OfResponse {
    /// `None` where few modes show it, or noise explains its phases.
    pub fn new(response: usize, seen: &[ModePhases], natural: f64) -> Option<Self> {
        let mut phases = Phases::default();
        let mut of_all = vec![Complex64::default(); seen.len()];
        for (mode, doubled) in seen.iter().zip(&mut of_all) {
            if let Some((phase, variance)) = mode.at[response] {
                let weight = 1.0 / (natural.max(mode.natural).powi(2) + variance + mode.of_common);
                *doubled = weight * Complex64::from_polar(1.0, 2.0 * phase);
                phases.push(mode.omega, phase, weight);
            }
        }
        // half of what noise leaves on the line, at least
        let by_noise = limits::DELAY_SIGMAS.powi(2) + limits::NOISE_LEFT * phases.count();
        let shown = phases.omega.len() >= limits::RESPONSE_LEAST_MODES;
        (shown && phases.misfit(&phases.radians) >= by_noise).then_some(Self { phases, of_all })
    }

    /// The likeliest delay.
    pub fn delay(&self, trials: &Trials) -> OneDelay {
        self.phases.delay(trials, &self.of_all)
    }
}

/// Delay of a response where the modes show one.
fn delay_of(
    response: usize,
    responses: usize,
    seen: &[ModePhases],
    trials: &Trials,
    natural: f64,
) -> Option<Delayed> {
    let own = OfResponse::new(response, seen, natural)?;
    let delay = own.delay(trials);
    let deviation = own.phases.deviation(&delay, responses)?;
    (own.phases.at_top(&delay) > limits::LEAST_PHASE).then_some(Delayed {
        response,
        seconds: delay.seconds,
        deviation,
        modes: own.phases.omega.len(),
    })
}
