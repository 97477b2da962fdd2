//! The two estimators that keep an operator each: the structured update (gains and poles,
//! then an operator update on what they leave) and the operator Kalman update alone.

use super::calibration::Estimator;
use super::evidence::Tried;
use super::kalman::KalmanOperator;
use super::parts::Parts;
use super::seen::Seen;
use super::structured::Structured;
use crate::tolerances;
use chladni_frf::Result;
use ndarray::{Array1, Axis};
use num_complex::Complex64;

/// The two estimators after some fields.
pub(super) struct Estimators {
    pub(super) structured: Structured,
    /// The structured operator, updated on what it leaves.
    pub(super) remainder: KalmanOperator,
    pub(super) kalman: KalmanOperator,
}

impl Estimators {
    pub(super) fn operator(&self, estimator: Estimator) -> &KalmanOperator {
        match estimator {
            Estimator::Structured => &self.remainder,
            Estimator::Kalman => &self.kalman,
        }
    }
}

/// Both estimators from all fields so far; `first` is the model with its error bars, `open`
/// the same with those that the operator update alone starts from.
pub(super) fn estimate(
    parts: &Parts,
    [first, open]: [&KalmanOperator; 2],
    seen: &[Seen],
    before: Option<&Structured>,
) -> Result<Estimators> {
    let from = |start| parts.update(seen, start, &Tried::OF_RIG);
    let mut structured = from(before.map(|before| &before.theta))?;
    let lone_fault = parts.lone_fault(seen);
    let mut starts: Vec<Option<&Array1<f64>>> = Vec::new();
    if before.is_some_and(|before| !before.odd.is_empty()) {
        // a channel that fewer fields called odd can hold the search where it is
        starts.push(None);
    }
    if lone_fault.is_some() {
        starts.push(lone_fault.as_ref());
    }
    // each odd channel has to be worth its odds, as within a search
    let odds = (parts.actuators() as f64).ln() + tolerances::ODD_EVIDENCE;
    let worth = |found: &Structured| found.ln_evidence - odds * found.odd.len() as f64;
    for start in starts {
        let other = from(start)?;
        if worth(&other) > worth(&structured) {
            structured = other;
        }
    }
    let share = Complex64::from(tolerances::DESIGN_SHARE);
    let mut remainder = KalmanOperator {
        mobility: structured.mobility.clone(),
        covariance: &structured.covariance + &first.covariance.mapv(|value| value * share),
    };
    let unexplained = structured.scales.unexplained * parts.size();
    let mut own = remainder.covariance.diag_mut();
    own.mapv_inplace(|value| value + unexplained.powi(2));
    let mut kalman = match structured.common_factor() {
        // its error bars are those of single channels: a factor of all lies far beyond
        Some(factor) => open.scaled(factor),
        None => open.clone(),
    };
    for seen in seen {
        for operator in [&mut remainder, &mut kalman] {
            let velocity = seen.phased(&operator.mobility);
            operator.update(&seen.drive, &seen.rows, &velocity, seen.noise);
        }
    }
    Ok(Estimators {
        structured,
        remainder,
        kalman,
    })
}

fn difference(operator: &KalmanOperator, seen: &Seen) -> Array1<Complex64> {
    let foretold = operator
        .mobility
        .select(Axis(0), &seen.rows)
        .dot(&seen.drive);
    seen.phased(&operator.mobility) - foretold
}

/// Squared error of what an operator foretells of a field.
pub(super) fn miss(operator: &KalmanOperator, seen: &Seen) -> f64 {
    difference(operator, seen)
        .iter()
        .map(Complex64::norm_sqr)
        .sum()
}

/// The same over what its error bars allow.
pub(super) fn score(operator: &KalmanOperator, seen: &Seen) -> f64 {
    let through = operator.covariance.dot(&seen.drive);
    let own: Complex64 = seen
        .drive
        .iter()
        .zip(&through)
        .map(|(a, g)| a.conj() * g)
        .sum();
    let bar = own.re.max(0.0) + seen.noise * seen.noise;
    miss(operator, seen) / bar / seen.rows.len() as f64
}
