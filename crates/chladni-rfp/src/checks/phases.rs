//! Phases over the natural frequencies of modes, known modulo 180°: what tells a delay from a turn
//! by one angle, and both from phases of no order (theory.md, eq. F2b).

use crate::checks::delay::{Line, Trials};
use crate::checks::limits;
use num_complex::Complex64;
use std::f64::consts::PI;

/// A phase in each of some modes.
#[derive(Default)]
pub(super) struct Phases {
    /// rad/s.
    pub omega: Vec<f64>,
    /// rad, modulo 180°.
    pub radians: Vec<f64>,
    /// Reciprocal variances.
    pub weight: Vec<f64>,
}

/// A delay that phases may have.
#[derive(Debug, Clone, Copy)]
pub(super) struct OneDelay {
    /// s; positive: it lags.
    pub seconds: f64,
    /// χ² of the phases that it leaves.
    pub left: f64,
    /// Root of Σω²/σ², 1/s.
    pub known: f64,
}

impl Phases {
    /// One mode more.
    pub fn push(&mut self, omega: f64, radians: f64, weight: f64) {
        self.omega.push(omega);
        self.radians.push(radians);
        self.weight.push(weight);
    }

    /// Number of modes.
    pub fn count(&self) -> f64 {
        self.omega.len() as f64
    }

    /// χ² of phases that are left.
    pub fn misfit(&self, radians: &[f64]) -> f64 {
        let terms = radians.iter().zip(&self.weight);
        terms.map(|(p, w)| w * p * p).sum()
    }

    /// Log-likelihood but for a common term where this `misfit` is left.
    pub fn likelihood(&self, misfit: f64) -> f64 {
        self.weight.iter().map(|w| 0.5 * w.ln()).sum::<f64>() - 0.5 * misfit
    }

    /// The same of phases of no order, normal or uniform.
    pub fn of_no_order(&self) -> f64 {
        let size = self.radians.iter().map(|p| p * p).sum::<f64>() / self.count();
        -0.5 * self.count() * (size.ln() + 1.0).min((0.5 * PI).ln())
    }

    /// Unit phasors of the doubled phases times the weights.
    pub fn doubled(&self) -> Vec<Complex64> {
        let phasors = self.radians.iter().zip(&self.weight);
        phasors
            .map(|(phase, weight)| weight * Complex64::from_polar(1.0, 2.0 * phase))
            .collect()
    }

    /// The likeliest delay near `seconds`.
    pub fn delay_near(&self, seconds: f64) -> OneDelay {
        let line = Line {
            omega: &self.omega,
            weight: &self.weight,
            doubled: self.doubled(),
        };
        let seconds = line.settled(seconds);
        OneDelay {
            seconds,
            left: self.misfit(&line.phases(seconds)),
            known: line.moment().sqrt(),
        }
    }

    /// The likeliest turn by one angle, rad, and the misfit that it leaves.
    pub fn turn(&self) -> (f64, f64) {
        let turn = 0.5 * self.doubled().iter().sum::<Complex64>().arg();
        let off = |phase: &f64| 0.5 * Complex64::from_polar(1.0, 2.0 * (phase - turn)).arg();
        let left: Vec<f64> = self.radians.iter().map(off).collect();
        (turn, self.misfit(&left))
    }

    /// Log-likelihood of a delay over phases of no order, less what looks at all delays up to it
    /// bring by chance.
    pub fn for_delay(&self, delay: &OneDelay) -> f64 {
        let looks = (1.0 + 2.0 * delay.seconds.abs() * delay.known).ln();
        self.likelihood(delay.left) - self.of_no_order() - looks
    }

    /// The standard deviation of a delay, s, where it is likelier than none, a turn by one angle,
    /// and phases of no order of any of so many `candidates`; `None` where it is not.
    pub fn deviation(&self, delay: &OneDelay, candidates: usize) -> Option<f64> {
        let deviation = (delay.left / (self.count() - 1.0)).max(1.0).sqrt() / delay.known;
        let told = self.for_delay(delay) > (candidates as f64).ln() + limits::DELAY_LIKELIER
            && delay.left < self.turn().1
            && self.misfit(&self.radians) - delay.left > limits::DELAY_SIGMAS.powi(2)
            && delay.seconds.abs() > limits::DELAY_SIGMAS * deviation;
        told.then_some(deviation)
    }

    /// The phase of a delay, rad, in the highest mode.
    pub fn at_top(&self, delay: &OneDelay) -> f64 {
        delay.seconds.abs() * self.omega.iter().copied().fold(0.0, f64::max)
    }

    /// The likeliest delay among `trials`.
    ///
    /// * `of_all`: [`Self::doubled`] of all modes of the trials, zero where these have no phase
    pub fn delay(&self, trials: &Trials, of_all: &[Complex64]) -> OneDelay {
        self.delay_near(trials.best(of_all, |sum| sum.re))
    }
}
