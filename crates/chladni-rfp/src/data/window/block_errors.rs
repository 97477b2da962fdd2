//! Errors that averages over blocks of records leave on neighbouring lines of FRFs (theory.md, eq.
//! F4c).

use crate::data::limits;
use crate::data::window::kinds::Window;
use chladni_frf::{Estimation, Forcing};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// The part of the processing of blocks that errors depend on.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct BlockErrors {
    /// Window and burst of the force, at the middles of equal parts of a record; `None`: one blow.
    pub(super) force: Option<Vec<f64>>,
    /// Number of these places with a force: a burst takes the first ones.
    pub(super) driven: usize,
    /// Window of the response.
    pub(super) response: Vec<f64>,
    /// Distance from block to block, in places; blocks as far apart as a record is long share nothing.
    pub(super) hop: usize,
    /// True if the structure is at rest before each block.
    pub(super) rest: bool,
    /// Number of blocks averaged; `None`: not known.
    blocks: Option<f64>,
    /// Length of a record times ω_max.
    pub(super) record: f64,
}

impl BlockErrors {
    /// Errors of records under `window`; `None` if errors of neighbouring lines are independent, or
    /// nothing is known of them.
    ///
    /// * `made`: the estimation of the FRFs, if the set describes it
    /// * `decay`: of an exponential window over a record, nepers
    /// * `record`: length of a record times ω_max
    pub fn new(
        window: Option<Window>,
        made: Option<&Estimation>,
        decay: f64,
        record: f64,
    ) -> Option<Self> {
        let points = limits::RECORD_POINTS;
        let time = |k: usize| (k as f64 + 0.5) / points as f64;
        let window = window.unwrap_or(Window::None);
        let part = window.part().unwrap_or(1.0);
        let is_blow = matches!(window, Window::None | Window::Transient);
        let (force, response) = match window {
            Window::None | Window::Transient => {
                let padded = window == Window::Transient
                    && made.is_some_and(|made| made.gate_s < limits::GATE_WHOLE * made.transform_s);
                let forcing = made.and_then(|made| made.forcing);
                let is_random =
                    matches!(forcing, Some(Forcing::Continuous | Forcing::Burst { .. }));
                if is_random || (decay == 0.0 && !padded) {
                    return None;
                }
                // relative to the first value, so that no decay takes the whole record to zero
                let factor = |k: usize| (-decay * (time(k) - time(0))).exp();
                (None, (0..points).map(factor).collect())
            }
            _ => {
                let values = window.values(points);
                let force = |(k, w): (usize, &f64)| if time(k) < part { *w } else { 0.0 };
                (Some(values.iter().enumerate().map(force).collect()), values)
            }
        };
        let continuous = made.map_or(!is_blow, |made| made.forcing == Some(Forcing::Continuous));
        let rest = is_blow || window.part().is_some();
        let hop = match made {
            Some(made) if continuous => made.hop_s / made.gate_s * points as f64,
            None if !rest => limits::HOP_ASSUMED * points as f64,
            _ => points as f64,
        };
        Some(Self {
            force,
            driven: (0..points).filter(|&k| time(k) < part).count(),
            response,
            hop: (hop.round() as usize).clamp(1, points),
            rest,
            blocks: made
                .map(|made| made.averages[0] as f64)
                .filter(|blocks| *blocks >= 1.0),
            record,
        })
    }

    /// Errors of lines that are independent, one cycle per record apart.
    pub fn independent(record: f64) -> Self {
        Self {
            force: None,
            driven: limits::RECORD_POINTS,
            response: vec![1.0; limits::RECORD_POINTS],
            hop: limits::RECORD_POINTS,
            rest: true,
            blocks: None,
            record,
        }
    }

    /// True if the force leaks, so that errors are largest beside modes.
    pub fn leaks(&self) -> bool {
        self.force.is_some()
    }

    /// True for records of bursts that cut off the end of responses without a taper.
    pub fn cuts_off(&self) -> bool {
        self.rest && self.leaks() && self.response.last() == Some(&1.0)
    }

    /// True for records of blows.
    pub fn of_blows(&self) -> bool {
        self.force.is_none() && self.blocks.is_some()
    }

    /// Number of blocks averaged, if it is known.
    pub fn blocks(&self) -> Option<f64> {
        self.blocks
    }

    /// Cycles per record between two lines y = ω/ω_max.
    pub fn cycles(&self, distance: f64) -> f64 {
        distance * self.record / TAU
    }

    /// Distances of blocks that share samples, in places, each with its number of pairs of blocks
    /// over the number of blocks.
    pub(super) fn shifts(&self) -> impl Iterator<Item = (isize, f64)> + '_ {
        let overlapping = (limits::RECORD_POINTS - 1) / self.hop;
        let most = match self.blocks {
            Some(blocks) => overlapping.min(blocks as usize - 1),
            None => overlapping,
        } as isize;
        let weight = |d: isize| 1.0 - self.blocks.map_or(0.0, |m| d.unsigned_abs() as f64 / m);
        (-most..=most).map(move |d| (d * self.hop as isize, weight(d)))
    }

    /// Covariance of noise of the responses between two blocks, `shift` places apart, on lines
    /// `cycles` apart.
    fn covariance_of_blocks(&self, shift: isize, cycles: f64) -> Complex64 {
        let of_window = |window: &[f64]| -> Complex64 {
            let points = window.len() as isize;
            let term = |t: isize| {
                let both = window[t as usize] * window[(t - shift) as usize];
                let turn = -TAU * cycles * (t as f64 + 0.5) / points as f64;
                Complex64::from_polar(both, turn)
            };
            (shift.max(0)..points.min(points + shift)).map(term).sum()
        };
        let of_force = self.force.as_deref().map(|force| of_window(force).conj());
        of_force.unwrap_or(Complex64::ONE) * of_window(&self.response)
    }

    /// The sum of these covariances over all blocks, per block.
    fn covariance_of_mean(&self, cycles: f64) -> Complex64 {
        let of_shift = |(shift, weight)| weight * self.covariance_of_blocks(shift, cycles);
        self.shifts().map(of_shift).sum()
    }

    /// Correlation of the errors that noise of the responses leaves on two lines, `cycles` apart,
    /// overlapping blocks included.
    pub fn of_noise(&self, cycles: f64) -> Complex64 {
        self.covariance_of_mean(cycles) / self.covariance_of_mean(0.0).re
    }

    /// Variance of noise of the mean over all blocks, over that of one block; `None` if their number is
    /// not known.
    pub fn averaged(&self) -> Option<f64> {
        let blocks = self.blocks?;
        Some(self.covariance_of_mean(0.0).re / (self.covariance_of_blocks(0, 0.0).re * blocks))
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use chladni_frf::{BlockWindow, Estimator};

    /// T·ω_max: lines 1/500 of ω_max apart.
    pub const RECORD: f64 = 500.0 * TAU;

    pub fn made(blocks: usize, hop: f64) -> Estimation {
        Estimation {
            estimator: Estimator::H1,
            window: BlockWindow::Hann,
            forcing: Some(Forcing::Continuous),
            transform_s: 1.0,
            gate_s: 1.0,
            hop_s: hop,
            averages: [blocks; 2],
            lines_per_value: 1,
        }
    }

    #[test]
    fn noise_of_half_overlapped_hann_blocks_is_correlated_as_the_study_says() {
        let errors =
            BlockErrors::new(Some(Window::Hann), Some(&made(1000, 0.5)), 0.0, RECORD).unwrap();
        for (lag, expected) in [(0.0, 1.0), (1.0, 0.458), (2.0, 0.039), (3.0, 0.001)] {
            let found = errors.of_noise(lag);
            assert!((found - expected).norm() < 2e-3, "{lag}: {found}");
        }
        // 1000 blocks of which neighbours share 1/6
        let averaged = errors.averaged().unwrap();
        assert!(
            (averaged * 1000.0 - 1.0 - 2.0 * 0.999 / 36.0).abs() < 1e-6,
            "{averaged}"
        );
        let alone =
            BlockErrors::new(Some(Window::Hann), Some(&made(10, 1.0)), 0.0, RECORD).unwrap();
        assert!((alone.of_noise(1.0) - 4.0 / 9.0).norm() < 1e-3);
        assert!(BlockErrors::new(None, None, 0.0, RECORD).is_none());
        assert!(BlockErrors::new(Some(Window::Transient), None, 0.0, RECORD).is_none());
        // noise of bursts under an exponential window has the force's correlation, too
        let bursts = Estimation {
            forcing: Some(Forcing::Burst { part: 0.5 }),
            ..made(10, 1.0)
        };
        assert!(BlockErrors::new(None, Some(&bursts), 3.0, RECORD).is_none());
        let blows = BlockErrors::new(None, None, 3.0, RECORD).unwrap();
        let expected = 3.0 / Complex64::new(3.0, std::f64::consts::PI);
        assert!((blows.of_noise(1.0) - expected).norm() < 1e-2);
    }
}
