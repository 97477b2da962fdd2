//! A simulated test, estimated and fitted in several ways, held against the truth.

use super::cell::{MeasuredCell, MeasuredForce, RECORD_S};
use super::simulation::{simulated, TrueMode, BAND_HZ, RECORD};
use chladni_frf::{Estimator, FrfSet, Mode, Result, Run, Trust};
use chladni_rfp::{fit, FitOptions, Window};
use chladni_signal::{estimate, EstimateOptions};
use serde::{Deserialize, Serialize};

/// The way of estimating and fitting a test.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum MeasuredWay {
    /// H1, and the fit knows from the set how it was made.
    Told,
    /// H1, and a fit of pure resonances.
    Plain,
    /// The local rational method.
    Lrm,
}

impl MeasuredWay {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Told, Self::Plain, Self::Lrm];

    /// As in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Told => "h1",
            Self::Plain => "h1, window not known",
            Self::Lrm => "lrm",
        }
    }
}

/// A mode that was found.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FoundMode {
    /// Error of the natural frequency over half the true bandwidth.
    pub frequency_error: f64,
    /// ... over its standard deviation.
    pub frequency_sigmas: f64,
    /// Relative error of the loss factor.
    pub loss_error: f64,
    /// ... over its standard deviation.
    pub loss_sigmas: f64,
    /// Distances of shape values, those of the driving point at 1, over their standard
    /// deviations: complex values.
    pub shape_sigmas: [f64; 2],
}

/// A fit held against the truth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MeasuredOutcome {
    /// Modes of the structure.
    pub true_modes: usize,
    /// Those that were found, by rising frequency.
    pub modes: Vec<FoundMode>,
    /// Modes of the model that stand for none.
    pub spurious: usize,
    /// Those of them that it calls sure.
    pub spurious_sure: usize,
}

/// Distance in half-bandwidths, and lines, within which a mode stands for a true one.
const NEAR: (f64, f64) = (1.0, 0.5);

/// All ways that serve a test of this seed.
pub(super) fn outcomes(
    cell: &MeasuredCell,
    seed: u64,
) -> Result<Vec<(MeasuredWay, MeasuredOutcome)>> {
    let test = simulated(cell, seed);
    let blocks = EstimateOptions {
        estimator: Some(Estimator::H1),
        window: Some(cell.window),
        block: Some(RECORD),
        overlap: Some(cell.overlap),
    };
    let h1 = estimated(&test.runs, &blocks)?;
    let told = FitOptions {
        band_hz: Some(BAND_HZ),
        ..FitOptions::default()
    };
    let plain = FitOptions {
        window: Some(Window::None),
        exponential_window_per_s: Some(0.0),
        ..told.clone()
    };
    let mut all = vec![
        (MeasuredWay::Told, held(&h1, &told, &test.modes)),
        (MeasuredWay::Plain, held(&h1, &plain, &test.modes)),
    ];
    if cell.force == MeasuredForce::Random {
        let local = EstimateOptions {
            estimator: Some(Estimator::Lrm),
            block: None,
            window: None,
            overlap: None,
        };
        let lrm = estimated(&test.runs, &local)?;
        all.push((MeasuredWay::Lrm, held(&lrm, &told, &test.modes)));
    }
    Ok(all)
}

fn estimated(runs: &[Run], options: &EstimateOptions) -> Result<FrfSet> {
    Ok(estimate(runs, options)?.frf)
}

/// The fit against the truth; one that cannot be made has found nothing.
fn held(frf: &FrfSet, options: &FitOptions, truth: &[TrueMode]) -> MeasuredOutcome {
    let modes: Vec<Mode> = match fit(frf, options) {
        Ok(fit) => fit.model.in_band_modes().cloned().collect(),
        Err(_) => Vec::new(),
    };
    let mut free: Vec<&Mode> = modes.iter().collect();
    let mut found = Vec::new();
    for own in truth {
        let off = |mode: &Mode| (mode.frequency_hz - own.frequency_hz).abs();
        let half_bandwidth = 0.5 * own.loss_factor * own.frequency_hz;
        let nearest = (0..free.len()).min_by(|&a, &b| off(free[a]).total_cmp(&off(free[b])));
        let nearest =
            nearest.filter(|&n| off(free[n]) < NEAR.0 * half_bandwidth + NEAR.1 / RECORD_S);
        if let Some(n) = nearest {
            found.push(errors(free.remove(n), own));
        }
    }
    MeasuredOutcome {
        true_modes: truth.len(),
        modes: found,
        spurious: free.len(),
        spurious_sure: free.iter().filter(|mode| mode.trust == Trust::Sure).count(),
    }
}

fn errors(mode: &Mode, own: &TrueMode) -> FoundMode {
    let off_hz = mode.frequency_hz - own.frequency_hz;
    let off_loss = mode.loss_factor - own.loss_factor;
    let at = &mode.shape.0;
    let shape = |i: usize| {
        let (ratio, expected) = (at[i] / at[0], own.shape[i] / own.shape[0]);
        let variance = mode.shape_std[i].powi(2) + ratio.norm_sqr() * mode.shape_std[0].powi(2);
        (ratio - expected).norm() * at[0].norm() / variance.sqrt().max(f64::MIN_POSITIVE)
    };
    FoundMode {
        frequency_error: off_hz / (0.5 * own.loss_factor * own.frequency_hz),
        frequency_sigmas: off_hz / mode.frequency_std_hz,
        loss_error: off_loss / own.loss_factor,
        loss_sigmas: off_loss / mode.loss_factor_std,
        shape_sigmas: [shape(1), shape(2)],
    }
}
