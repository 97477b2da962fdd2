//! A fitted model compared with the model that its data were simulated from.

use crate::limits::{FREQUENCY_ERROR, LEAST_MAC, LOSS_FACTOR_ERROR};
use chladni_frf::{ModalModel, Mode};
use chladni_rfp::mac;

/// Errors of the modes that were found, and numbers of missed and spurious modes.
pub struct Comparison {
    /// Modes in band of the truth.
    pub known: usize,
    /// Those without a partner in the fit.
    pub missed: usize,
    /// Modes of the fit without a partner in the truth.
    pub spurious: usize,
    /// Found minus known natural frequency of each known mode, Hz; `None`: missed.
    pub frequency_errors_hz: Vec<Option<f64>>,
    /// Relative errors of the natural frequencies, rising.
    pub frequency_errors: Vec<f64>,
    /// Relative errors of the loss factors, rising.
    pub loss_factor_errors: Vec<f64>,
    /// Modal assurance criterion of each shape with the true one, rising.
    pub mac: Vec<f64>,
}

impl Comparison {
    /// Pairs each known mode with the nearest fitted one within half its half-power
    /// bandwidth, nearest pairs first.
    pub fn new(fitted: &ModalModel, truth: &ModalModel) -> Self {
        let (found, known): (Vec<&Mode>, Vec<&Mode>) = (
            fitted.in_band_modes().collect(),
            truth.in_band_modes().collect(),
        );
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (i, known) in known.iter().enumerate() {
            for (k, found) in found.iter().enumerate() {
                let distance = (found.frequency_hz - known.frequency_hz).abs();
                if distance <= 0.5 * known.loss_factor * known.frequency_hz {
                    pairs.push((distance, i, k));
                }
            }
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut partners = vec![None; known.len()];
        let mut taken = vec![false; found.len()];
        for (_, i, k) in pairs {
            if partners[i].is_none() && !taken[k] {
                (partners[i], taken[k]) = (Some(found[k]), true);
            }
        }
        let matched: Vec<(&Mode, &Mode)> = known
            .iter()
            .zip(&partners)
            .filter_map(|(&known, partner)| Some((known, (*partner)?)))
            .collect();
        let frequency_errors_hz = known
            .iter()
            .zip(&partners)
            .map(|(known, found)| found.map(|found| found.frequency_hz - known.frequency_hz));
        let sorted = |of: fn(&Mode, &Mode) -> f64| {
            let mut values: Vec<f64> = matched
                .iter()
                .map(|(known, found)| of(known, found))
                .collect();
            values.sort_by(f64::total_cmp);
            values
        };
        Self {
            known: known.len(),
            missed: known.len() - matched.len(),
            spurious: found.len() - matched.len(),
            frequency_errors_hz: frequency_errors_hz.collect(),
            frequency_errors: sorted(|known, found| {
                (found.frequency_hz / known.frequency_hz - 1.0).abs()
            }),
            loss_factor_errors: sorted(|known, found| {
                (found.loss_factor / known.loss_factor - 1.0).abs()
            }),
            mac: sorted(|known, found| mac(&known.shape.0, &found.shape.0)),
        }
    }

    /// The reasons why the fit misses the truth; `None` for a good fit.
    pub fn complaint(&self) -> Option<String> {
        let worst = |errors: &[f64]| errors.last().copied().unwrap_or(f64::INFINITY);
        let checks = [
            (
                self.missed > 0,
                format!("{} of {} modes missed", self.missed, self.known),
            ),
            (
                self.spurious > 0,
                format!("{} spurious modes", self.spurious),
            ),
            (
                worst(&self.frequency_errors) > FREQUENCY_ERROR,
                format!(
                    "a frequency is wrong by {:.2e}",
                    worst(&self.frequency_errors)
                ),
            ),
            (
                worst(&self.loss_factor_errors) > LOSS_FACTOR_ERROR,
                format!(
                    "a loss factor is wrong by {:.2e}",
                    worst(&self.loss_factor_errors)
                ),
            ),
            (
                self.mac.first().is_none_or(|&mac| mac < LEAST_MAC),
                "a mode shape is wrong".to_owned(),
            ),
        ];
        let wrong: Vec<String> = checks
            .into_iter()
            .filter(|(fails, _)| *fails)
            .map(|(_, words)| words)
            .collect();
        (!wrong.is_empty()).then(|| format!("the known truth is missed: {}", wrong.join(", ")))
    }
}
