//! A simulated test, estimated and fitted in several ways, held against the truth.

use super::analyser::{analyser_window, windowed};
use super::cell::{MeasuredCell, MeasuredForce, RECORD_S};
use super::simulation::{simulated, Simulated, TrueMode, BAND_HZ, RECORD};
use chladni_frf::{BlockWindow, Estimator, FrfSet, Mode, Result, Trust};
use chladni_rfp::{error_witness, fit, Correlation, FitOptions, Window};
use chladni_signal::{estimate, EstimateOptions};
use serde::{Deserialize, Serialize};

/// The way of estimating and fitting a test.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum MeasuredWay {
    /// H1, and the fit knows from the set how it was made.
    Told,
    /// H1, and a fit of pure resonances.
    Plain,
    /// H1, and a fit that nobody tells anything.
    Blind,
    /// The local rational method.
    Lrm,
}

impl MeasuredWay {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Told, Self::Plain, Self::Blind, Self::Lrm];

    /// As in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Told => "h1, window told",
            Self::Plain => "h1, plain fit",
            Self::Blind => "h1, blind",
            Self::Lrm => "lrm",
        }
    }
}

/// A mode that was found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FoundMode {
    /// Error of the natural frequency over half the true bandwidth.
    pub frequency_error: f64,
    /// ... over its standard deviation.
    pub frequency_sigmas: f64,
    /// Relative error of the loss factor.
    pub loss_error: f64,
    /// ... over its standard deviation.
    pub loss_sigmas: f64,
    /// Distances of mass-normalised shape values over their standard deviations: complex
    /// values.
    pub shape_sigmas: Vec<f64>,
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
    /// Correlation that errors of neighbouring lines were said to have, held against the
    /// truth.
    pub witness: Decision,
}

/// A decision held against the truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Decision {
    /// Nobody asked.
    NotAsked,
    /// Too little evidence.
    Undecided,
    /// Right.
    Right,
    /// Wrong.
    Wrong,
}

/// Distance in half-bandwidths, and lines, within which a mode stands for a true one.
const NEAR: (f64, f64) = (1.0, 0.5);

/// All ways that serve a test of this seed.
pub(super) fn outcomes(
    cell: &MeasuredCell,
    seed: u64,
) -> Result<Vec<(MeasuredWay, MeasuredOutcome)>> {
    let test = simulated(cell, seed);
    let h1 = by_h1(cell, &test)?;
    let blind = FrfSet {
        estimation: None,
        variance: None,
        coherence: None,
        ..h1.clone()
    };
    let own = FitOptions {
        band_hz: Some(BAND_HZ),
        ..FitOptions::default()
    };
    let plain = FitOptions {
        window: Some(Window::None),
        exponential_window_per_s: Some(0.0),
        ..own.clone()
    };
    let held = |frf: &FrfSet, options: &FitOptions, truth: Option<Correlation>| {
        held(frf, options, &test.modes, truth)
    };
    let mut all = Vec::new();
    if cell.force != MeasuredForce::Sines {
        let named = FitOptions {
            window: cell.analyser,
            ..own.clone()
        };
        all.push((MeasuredWay::Told, held(&h1, &named, None)));
    }
    let truth = Some(cell.correlation());
    all.push((MeasuredWay::Plain, held(&h1, &plain, truth)));
    // α of an exponential window is nothing that a program may guess
    if !matches!(cell.window, BlockWindow::Exponential { .. }) {
        all.push((MeasuredWay::Blind, held(&blind, &own, None)));
    }
    // under an analyser's window it is that of the same record
    if cell.force == MeasuredForce::Random && cell.analyser.is_none() {
        let local = EstimateOptions {
            estimator: Some(Estimator::Lrm),
            ..EstimateOptions::default()
        };
        let lrm = estimate(&test.runs, &local)?.frf;
        let truth = Some(Correlation::White);
        all.push((MeasuredWay::Lrm, held(&lrm, &own, truth)));
    }
    Ok(all)
}

/// FRFs by averaged blocks, with what a set says of them.
fn by_h1(cell: &MeasuredCell, test: &Simulated) -> Result<FrfSet> {
    if let Some(frf) = &test.frf {
        return Ok(frf.clone());
    }
    let mut blocks = EstimateOptions {
        estimator: Some(Estimator::H1),
        window: Some(cell.window),
        block: Some(RECORD),
        overlap: Some(cell.overlap),
    };
    let Some(window) = cell.analyser else {
        return Ok(estimate(&test.runs, &blocks)?.frf);
    };
    let hop = (RECORD as f64 * (1.0 - cell.overlap)).round() as usize;
    let runs = windowed(&test.runs[0], &analyser_window(window, RECORD), hop);
    (blocks.window, blocks.overlap) = (Some(BlockWindow::Rectangular), Some(0.0));
    Ok(FrfSet {
        estimation: None,
        variance: None,
        ..estimate(&runs, &blocks)?.frf
    })
}

/// The fit against the truth; one that cannot be made has found nothing. `correlation`: of
/// the errors of lines, where these are to be asked.
fn held(
    frf: &FrfSet,
    options: &FitOptions,
    truth: &[TrueMode],
    correlation: Option<Correlation>,
) -> MeasuredOutcome {
    let model = fit(frf, options).ok().map(|fit| fit.model);
    let modes: Vec<Mode> = model
        .iter()
        .flat_map(|model| model.in_band_modes().cloned())
        .collect();
    let witness = match (&model, correlation) {
        (Some(model), Some(truth)) => match error_witness(frf, options, model) {
            Ok(Some(found)) if found.decides() && found.likeliest == truth => Decision::Right,
            Ok(Some(found)) if found.decides() => Decision::Wrong,
            _ => Decision::Undecided,
        },
        _ => Decision::NotAsked,
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
        witness,
    }
}

fn errors(mode: &Mode, own: &TrueMode) -> FoundMode {
    let off_hz = mode.frequency_hz - own.frequency_hz;
    let off_loss = mode.loss_factor - own.loss_factor;
    let at = &mode.shape.0;
    let side = (at[0] * own.shape[0]).re.signum();
    let shape =
        |i: usize| (at[i] - side * own.shape[i]).norm() / mode.shape_std[i].max(f64::MIN_POSITIVE);
    FoundMode {
        frequency_error: off_hz / (0.5 * own.loss_factor * own.frequency_hz),
        frequency_sigmas: off_hz / mode.frequency_std_hz,
        loss_error: off_loss / own.loss_factor,
        loss_sigmas: off_loss / mode.loss_factor_std,
        shape_sigmas: (0..own.shape.len()).map(shape).collect(),
    }
}
