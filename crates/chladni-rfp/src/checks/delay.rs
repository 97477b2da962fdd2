//! A reference that lags another one: a filter, a multiplexer, a trigger.
//!
//! Real modes have Σ_o R_o2·R̄_o1 real; a delay τ of the second reference turns it by
//! −ω_nτ. Modulo its sign, τ maximises |Σ_n w_n(U_n/|U_n|)²·e^{2jω_nτ}|, U_n = Σ_o
//! R_o2·R̄_o1 = L_n2·L̄_n1·Σ|ψ_n|², each mode weighted by how well its phase is known
//! (theory.md, eq. F2). Poles and rank-one shapes absorb the delay; real shapes do not.

use crate::checks::case::{Case, Checked};
use crate::checks::limits;
use chladni_frf::{Finding, Mode};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// A delay with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Delay {
    /// s; positive: the second lags.
    seconds: f64,
    /// s, one sigma.
    deviation: f64,
}

/// Names references that lag or lead the first.
pub(crate) fn delayed_reference(case: &Case) -> Option<Checked> {
    let modes = case.sure_modes();
    let omega: Vec<f64> = modes.iter().map(|mode| TAU * mode.frequency_hz).collect();
    if case.model.references.len() < 2 || (omega.len() as f64) < limits::DELAY_LEAST_MODES {
        return None;
    }
    let trials = Trials::new(&omega);
    let found: Vec<String> = (1..case.model.references.len())
        .filter_map(|j| Some((j, relative_delay(&modes, &omega, &trials, 0, j)?)))
        .map(|(j, delay)| {
            let lags = if delay.seconds > 0.0 { "lags" } else { "leads" };
            let microseconds = 1e6 * delay.seconds.abs();
            format!(
                "{} {lags} by {microseconds:.1} µs (± {:.1})",
                case.model.references[j],
                1e6 * delay.deviation
            )
        })
        .collect();
    let first = case
        .model
        .references
        .first()
        .filter(|_| !found.is_empty())?;
    let words = format!(
        "delayed reference: against {first}, {}, read off the phases of {} modes; poles are not \
         touched, but participations turn with frequency and real shapes do not fit",
        found.join(", "),
        modes.len()
    );
    let finding = Finding::caution("delayed-reference", words)
        .dofs([*first])
        .help("correct the delay of that channel");
    Some(finding.into())
}

/// Delay of reference `second` against `first` where the modes show one.
fn relative_delay(
    modes: &[&Mode],
    omega: &[f64],
    trials: &Trials,
    first: usize,
    second: usize,
) -> Option<Delay> {
    let u: Vec<Complex64> = modes
        .iter()
        .map(|mode| mode.participation.0[second] * mode.participation.0[first].conj())
        .collect();
    let weight: Vec<f64> = modes
        .iter()
        .map(|mode| 1.0 / (limits::NATURAL_PHASE.powi(2) + phase_variance(mode, first, second)))
        .collect();
    let total: f64 = weight.iter().sum();
    let effective = total * total / weight.iter().map(|w| w * w).sum::<f64>();
    if !effective.is_finite() || effective < limits::DELAY_LEAST_MODES {
        return None;
    }
    let line = Line {
        omega,
        weight: &weight,
        doubled: u
            .iter()
            .zip(&weight)
            .map(|(u, w)| w * u * u / u.norm_sqr().max(f64::MIN_POSITIVE))
            .collect(),
    };
    let seconds = line.settled(trials.best(&line.doubled, |sum| sum.norm_sqr()));
    let left = line
        .phases(seconds)
        .iter()
        .zip(&weight)
        .map(|(p, w)| w * p * p)
        .sum::<f64>()
        / total
        * effective
        / (effective - 1.0);
    let deviation = (left * total / line.moment() / effective).sqrt();
    let top = omega.iter().copied().fold(0.0, f64::max);
    let shown = left.sqrt() < limits::LEFT_OVER
        && seconds.abs() > limits::DELAY_SIGMAS * deviation
        && seconds.abs() * top > limits::LEAST_PHASE;
    shown.then_some(Delay { seconds, deviation })
}

/// Variance of the phase between two participations: that of the pole in half-bandwidths,
/// which is about that of a residue of usual strength, larger as the weaker of the two is
/// weaker.
fn phase_variance(mode: &Mode, first: usize, second: usize) -> f64 {
    let all = &mode.participation.0;
    let usual = all.iter().map(|v| v.norm_sqr()).sum::<f64>() / all.len() as f64;
    let weaker = all[first].norm_sqr().min(all[second].norm_sqr());
    let half_width = 0.5 * mode.loss_factor * mode.frequency_hz;
    (mode.frequency_std_hz / half_width).powi(2) * usual / weaker.max(f64::MIN_POSITIVE)
}

/// Phases that a delay would put on a straight line through zero, known modulo 180°.
pub(super) struct Line<'a> {
    /// rad/s.
    pub omega: &'a [f64],
    /// Of each phase.
    pub weight: &'a [f64],
    /// Unit phasors of the doubled phases times the weights.
    pub doubled: Vec<Complex64>,
}

impl Line<'_> {
    /// Phases, rad, that are left once a delay is taken off.
    pub fn phases(&self, seconds: f64) -> Vec<f64> {
        self.omega
            .iter()
            .zip(&self.doubled)
            .map(|(o, d)| 0.5 * (d * Complex64::from_polar(1.0, 2.0 * o * seconds)).arg())
            .collect()
    }

    /// Σwω².
    pub fn moment(&self) -> f64 {
        let terms = self.omega.iter().zip(self.weight);
        terms.map(|(o, w)| w * o * o).sum()
    }

    /// The delay near `seconds` by regression on ω.
    pub fn settled(&self, mut seconds: f64) -> f64 {
        let moment = self.moment();
        for _ in 0..limits::DELAY_ROUNDS {
            seconds -= self
                .omega
                .iter()
                .zip(self.phases(seconds))
                .zip(self.weight)
                .map(|((o, p), w)| w * o * p)
                .sum::<f64>()
                / moment;
        }
        seconds
    }
}

/// Trial delays as far as the mean spacing of the modes is unambiguous, so close that the
/// highest mode resolves them.
pub(super) struct Trials {
    /// s, the nearest to zero first.
    seconds: Vec<f64>,
    /// e^{2jω_nτ}, one row per delay.
    phasors: Vec<Vec<Complex64>>,
}

impl Trials {
    pub fn new(omega: &[f64]) -> Self {
        let (low, high) = omega
            .iter()
            .fold((f64::MAX, 0.0_f64), |(l, h), &o| (l.min(o), h.max(o)));
        let reach = limits::TRIAL_REACH * TAU * omega.len().saturating_sub(1) as f64
            / (high - low).max(f64::MIN_POSITIVE);
        let steps =
            ((reach * high / limits::TRIAL_STEP).ceil() as usize).clamp(1, limits::TRIALS_MOST);
        let at = |step: usize| reach * step as f64 / steps as f64;
        let seconds: Vec<f64> = std::iter::once(0.0)
            .chain((1..=steps).flat_map(|step| [at(step), -at(step)]))
            .collect();
        let row = |tau: &f64| {
            omega
                .iter()
                .map(|o| Complex64::from_polar(1.0, 2.0 * o * tau))
                .collect()
        };
        let phasors = seconds.iter().map(row).collect();
        Self { seconds, phasors }
    }

    /// The delay at which Σ d_n e^{2jω_nτ} scores best.
    pub fn best(&self, doubled: &[Complex64], score: impl Fn(Complex64) -> f64) -> f64 {
        let sum = |row: &Vec<Complex64>| row.iter().zip(doubled).map(|(p, d)| p * d).sum();
        let scores = self.phasors.iter().map(|row| score(sum(row)));
        scores
            .zip(&self.seconds)
            .fold((f64::MIN, 0.0), |best, (score, tau)| {
                if score > best.0 {
                    (score, *tau)
                } else {
                    best
                }
            })
            .1
    }
}
