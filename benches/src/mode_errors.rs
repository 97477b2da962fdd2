//! Errors of one mode over many noise seeds.

use crate::problem::Bounds;
use crate::score::{half_half_width_hz, Match, Score};
use crate::statistics::{mean, median, quantile, root_mean_square};
use chladni_frf::Mode;

/// Errors of one true mode; pairs are (natural frequency, loss factor).
#[derive(Debug, Clone, PartialEq)]
pub struct ModeErrors {
    /// True natural frequency, Hz.
    pub frequency_hz: f64,
    /// True loss factor.
    pub loss_factor: f64,
    /// Share of the fits that found it.
    pub found: f64,
    /// The bounds of free residues: Hz, and of η.
    pub bound: [f64; 2],
    /// The bounds with one real shape per mode.
    pub bound_real: [f64; 2],
    /// Root mean square error over the bound of free residues.
    pub over_free: [f64; 2],
    /// Mean error over the same bound: what more seeds would not take away.
    pub bias_over_free: [f64; 2],
    /// Root mean square error over the bound with one shape per mode.
    pub over_rank_one: [f64; 2],
    /// The same with one real shape per mode.
    pub over_real: [f64; 2],
    /// Share of the 95 % intervals that hold the truth.
    pub coverage: [f64; 2],
    /// Largest |error| of the natural frequency over the frequency.
    pub relative_error: f64,
    /// The bound of the natural frequency over the half-power bandwidth.
    pub bound_over_bandwidth: f64,
}

/// The two errors of a match, in the order of all pairs here.
const ERRORS: [fn(&Match) -> f64; 2] = [|found| found.frequency_hz, |found| found.loss_factor];

impl ModeErrors {
    /// Errors of in-band mode number `n` of the truth, `known`; without bounds what is
    /// measured by them is NaN.
    pub(crate) fn new(n: usize, known: &Mode, bounds: Option<&Bounds>, scores: &[Score]) -> Self {
        let found: Vec<&Match> = scores
            .iter()
            .filter_map(|score| score.matches[n].as_ref())
            .collect();
        let bound = |pick: fn(&Bounds) -> &chladni_plate::CramerRao| {
            bounds.map(pick).map_or([f64::NAN; 2], |bound| {
                [bound.frequency_std_hz[n], bound.loss_factor_std[n]]
            })
        };
        let [free, rank_one, real] = [
            bound(|bounds| &bounds.free),
            bound(|bounds| &bounds.rank_one),
            bound(|bounds| &bounds.real),
        ];
        let over = |e: usize, bound: f64| {
            root_mean_square(found.iter().map(|found| ERRORS[e](found) / bound))
        };
        let share = |covered: fn(&Match) -> bool| {
            mean(
                found
                    .iter()
                    .map(|found| f64::from(u8::from(covered(found)))),
            )
        };
        Self {
            frequency_hz: known.frequency_hz,
            loss_factor: known.loss_factor,
            found: found.len() as f64 / scores.len() as f64,
            bound: free,
            bound_real: real,
            over_free: [0, 1].map(|e| over(e, free[e])),
            bias_over_free: [0, 1]
                .map(|e| mean(found.iter().map(|found| ERRORS[e](found) / free[e]))),
            over_rank_one: [0, 1].map(|e| over(e, rank_one[e])),
            over_real: [0, 1].map(|e| over(e, real[e])),
            coverage: [
                share(|found| found.frequency_covered),
                share(|found| found.loss_factor_covered),
            ],
            relative_error: found
                .iter()
                .map(|found| found.frequency_hz.abs() / known.frequency_hz)
                .fold(f64::NAN, f64::max),
            bound_over_bandwidth: free[0] / (2.0 * half_half_width_hz(known)),
        }
    }

    /// Root mean square of the frequency error over the bound, each miss counting as half
    /// the bandwidth.
    pub(crate) fn with_missed(&self) -> f64 {
        let missed = 0.25 / self.bound_over_bandwidth.powi(2);
        let found = if self.found > 0.0 {
            self.over_free[0].powi(2)
        } else {
            0.0
        };
        (self.found * found + (1.0 - self.found) * missed).sqrt()
    }
}

/// Median over the modes, and the worst one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Median.
    pub median: f64,
    /// Worst.
    pub worst: f64,
}

impl Spread {
    /// Of one number per mode; modes without it are left out.
    pub(crate) fn new(modes: &[ModeErrors], value: impl Fn(&ModeErrors) -> f64) -> Self {
        let values: Vec<f64> = modes.iter().map(value).collect();
        Self {
            median: median(&values),
            worst: quantile(&values, 1.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::Problem;
    use chladni_plate::Synthetic;

    #[test]
    fn a_known_shift_is_bias_and_a_miss_counts_as_half_a_bandwidth() {
        let problem = Problem::of_modes(&Synthetic::default()).unwrap();
        let bounds = problem.bounds().unwrap();
        let bound_hz = bounds.as_ref().unwrap().free.frequency_std_hz[1];
        let fitted = |shifts: f64| {
            let mut model = problem.truth.clone();
            model.modes[1].frequency_hz += shifts * bound_hz;
            Score::new(&model, &problem)
        };
        let known = problem.truth.modes[1].clone();
        let errors = ModeErrors::new(1, &known, bounds.as_ref(), &[fitted(3.0), fitted(-1.0)]);
        assert!(
            (errors.bias_over_free[0] - 1.0).abs() < 1e-6
                && (errors.over_free[0] - 5f64.sqrt()).abs() < 1e-6,
            "{errors:?}"
        );
        assert!((errors.with_missed() - errors.over_free[0]).abs() < 1e-12);
        let missed = ModeErrors::new(1, &known, bounds.as_ref(), &[Score::failed(&problem)]);
        assert!(
            (missed.with_missed() * bound_hz / (0.5 * known.loss_factor * known.frequency_hz)
                - 1.0)
                .abs()
                < 1e-12
        );
        assert!(missed.over_free[0].is_nan() && missed.found == 0.0);
    }
}
