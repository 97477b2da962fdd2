//! The driver of every fit, in memory or in pieces: find poles, choose the damping law, turn
//! residues into shapes and a model, check the data.
//!
//! The walk is written once over a [`Source`]. In memory it runs to its end. Over partials it
//! stops at a pass that is not made yet, and goes on from there once other machines have made
//! it.

use crate::checks::case::{Case, Noise};
use crate::checks::examine::examine;
use crate::checks::window_bias;
use crate::data::error::FitError;
use crate::data::layout::{DataLayout, Weighting};
use crate::data::options::{FitOptions, Method};
use crate::data::outliers::{self, OutlierLines};
use crate::data::pair_weights::{Giver, PairWeights, Weights};
use crate::data::screening::Screened;
use crate::data::source::Source;
use crate::data::watch::{CancelToken, Watch};
use crate::data::window::kinds::Window;
use crate::data::window::of_set::with_set;
use crate::methods::aaa::aaa;
use crate::methods::auto::auto;
use crate::methods::bars::fit_by_method;
use crate::methods::circle::circle;
use crate::methods::fit::{Fit, FitToCheck, MethodRun};
use crate::methods::found::Finder;
use crate::methods::lean::lean;
use crate::methods::lscf::lscf;
use crate::methods::peak::peak;
use crate::methods::plscf::plscf;
use crate::methods::rfp::rfp;
use crate::methods::survey::Survey;
use crate::methods::vf::vf;
use crate::model::build::Shaped;
use crate::model::decide::with_free_residues;
use crate::model::exponential;
use crate::poles::whiteness::Residual;
use crate::tolerances::OUTLIER_ROUNDS;
use chladni_frf::{Estimator, Finding, Forcing, FrfSet, ModalModel};
use chladni_linalg::blocked::in_pool;

/// Identifies the modes in `frf`.
///
/// # Errors
/// [`FitError`]: unknown kind, a band outside the data, too few lines, no data, a window
/// of records whose length the lines do not tell. A fit that was made but cannot be trusted is no
/// error: `model.quality.trusted` says so, with the reasons in its warnings.
pub fn fit(frf: &FrfSet, options: &FitOptions) -> Result<Fit, FitError> {
    fit_watched(frf, options, &|_stage| (), &CancelToken::new())
}

/// The same as [`fit`], watched: `progress` is told the name of each stage as it begins,
/// and the fit stops there once `cancel` asks for it.
///
/// ```
/// # use chladni_plate::{simulate, Panel};
/// use chladni_rfp::{fit_watched, CancelToken, FitError, FitOptions};
/// # let mut panel = Panel::default();
/// # panel.frf.stop_hz = 150.0;
/// # let frf = simulate(&panel, None, None)?.frf;
///
/// let cancel = CancelToken::new(); // a clone of it goes to whoever may stop the fit
/// let progress = |stage: &str| {
///     eprintln!("{stage}");
///     cancel.cancel();
/// };
/// let stopped = fit_watched(&frf, &FitOptions::default(), &progress, &cancel);
/// assert_eq!(stopped.unwrap_err(), FitError::Cancelled);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Those of [`fit`], and [`FitError::Cancelled`].
pub fn fit_watched(
    frf: &FrfSet,
    options: &FitOptions,
    progress: &(dyn Fn(&str) + Sync),
    cancel: &CancelToken,
) -> Result<Fit, FitError> {
    let watch = Watch {
        tell: progress,
        cancel,
    };
    in_pool(|| {
        let options = with_set(frf, options);
        let data = Screened::new(frf, &options)?;
        let fit = walk(data.clone(), &options, &watch)?;
        match options.window.filter(|window| *window != Window::None) {
            Some(window) => with_known_window(data, fit, window, options, &watch),
            None if window_bias::is_open(&fit.model) => {
                with_window_found(frf, fit, options, &watch)
            }
            None => Ok(fit),
        }
    })
}

/// The fit under the known window. It is not trusted if line shapes doubt that window and a
/// fit without it leaves far less.
///
/// # Errors
/// Those of [`fit`].
fn with_known_window(
    data: Screened,
    mut fit: Fit,
    window: Window,
    options: FitOptions,
    watch: &Watch,
) -> Result<Fit, FitError> {
    if !window_bias::is_doubted(&Case::of_fit(&data, &fit.model, &options)) {
        return Ok(fit);
    }
    watch.stage("lines without the window")?;
    let plain = FitOptions {
        window: Some(Window::None),
        ..options
    };
    let other = Screened::new(data.frf, &plain).and_then(|data| walk(data, &plain, watch));
    match other {
        Err(FitError::Cancelled) => return Err(FitError::Cancelled),
        // nothing to compare with
        Err(_) => {}
        Ok(other) => {
            let found = window_bias::contradicted(window, [&fit.model, &other.model]);
            fit.model.quality.trusted &= found.is_none();
            fit.model.quality.findings.extend(found);
        }
    }
    Ok(fit)
}

/// A second fit under the window that line shapes show, if its residual confirms that window.
/// Otherwise the first fit, its bars widened by what a window may have added.
///
/// # Errors
/// Those of [`fit`].
fn with_window_found(
    frf: &FrfSet,
    mut fit: Fit,
    options: FitOptions,
    watch: &Watch,
) -> Result<Fit, FitError> {
    let screened = Screened::new(frf, &options)?;
    let case = Case::of_fit(&screened, &fit.model, &options);
    let evidence = window_bias::Evidence::new(&case);
    // the line shapes compared are those of continuous noise in H1
    let may_be = frf.estimation.as_ref().is_none_or(|made| {
        let forcing = made.forcing.unwrap_or(Forcing::Continuous);
        made.estimator == Estimator::H1 && forcing == Forcing::Continuous
    });
    let suspected = window_bias::of_shapes(&case, &evidence).filter(|_| may_be);
    let Some(window) = suspected else {
        window_bias::hold(&mut fit.model, &screened, evidence.suspected());
        return Ok(fit);
    };
    watch.stage("line shape of the window")?;
    let options = FitOptions {
        window: Some(window),
        ..options
    };
    // the first fit stands whatever becomes of this one
    let windowed = Screened::new(frf, &options);
    let under = windowed.and_then(|data| Ok((walk(data.clone(), &options, watch)?, data)));
    let found = match under {
        Ok((under, data)) => {
            let case = Case::of_fit(&data, &under.model, &options);
            window_bias::decided(&evidence, &case).map(|found| (found, under))
        }
        Err(FitError::Cancelled) => return Err(FitError::Cancelled),
        Err(_) => None,
    };
    let Some((found, mut under)) = found else {
        window_bias::hold(&mut fit.model, &screened, evidence.suspected());
        return Ok(fit);
    };
    found.hold_others(&mut under.model, &screened);
    under.model.quality.findings.push(found.finding);
    Ok(under)
}

/// Fits `data`, each FRF weighted by its noise if the data say how noisy it is. If they do not,
/// the first fit has no weights; a second one has those that the residuals of the first give,
/// if these are unequal; a third one those that the residuals of the second give, if they still are.
///
/// # Errors
/// A fit that cannot be made; a pass that others must make.
pub(crate) fn walk<S: Source>(
    data: S,
    options: &FitOptions,
    watch: &Watch,
) -> Result<Fit, S::Stop> {
    let given = match data.weights_left {
        Weights::Given => data.given_noise(),
        Weights::OfResidual | Weights::Again | Weights::None => None,
    };
    let given = given.and_then(|(noise, giver)| {
        let weights = PairWeights::by_noise(&data, &noise)?;
        Some((weights, Some(giver)))
    });
    let mut fitted = match given {
        Some(weights) => data.weighted(Some(weights), Weights::OfResidual)?,
        None => data.clone(),
    };
    let FitToCheck {
        mut fit,
        residual,
        left_of_frfs,
    } = loop {
        match identify(&fitted, options, outlier_lines(&fitted), watch)? {
            MethodRun::LeaveOut(lines) => fitted = fitted.without(&lines),
            MethodRun::Fitted(found) => break *found,
        }
    };
    let white = residual == Residual::White;
    // residual energy of the measured FRFs, times the squares of their weights
    let seen: Vec<f64> = fitted
        .pairs
        .iter()
        .zip(&left_of_frfs)
        .map(|(&pair, left)| left * fitted.weight_of(pair).powi(2))
        .collect();
    let error = fit.model.quality.relative_error;
    let unequal = PairWeights::new(&fitted, &seen, error)
        .filter(|_| white && fitted.weights_left != Weights::None);
    // these replace the weights of this fit: they are of the measured FRFs
    let again = (fitted.weights_left == Weights::Again && unequal.is_some())
        .then(|| PairWeights::by_noise(&fitted, &left_of_frfs))
        .flatten();
    if let Some(again) = again {
        watch.stage("FRFs weighted by their noise once more")?;
        let weighted = fitted.weighted(Some((again, None)), Weights::None)?;
        return walk(weighted, options, watch);
    }
    match (&fitted.weighting, unequal) {
        // the measured-data path has an error model of its own
        (Some(weighting), unequal)
            if weighting.giver == Some(Giver::Coherence) && (!white || unequal.is_some()) =>
        {
            let noted = data.noted(unequal.map(|_| coherence_contradicted()));
            return walk(noted.weighted(None, Weights::OfResidual)?, options, watch);
        }
        // drop weights taken from a residual if the residual of the weighted fit is not white
        (Some(weighting), _) if weighting.giver.is_none() && !white => {
            return walk(fitted.weighted(None, Weights::None)?, options, watch);
        }
        (Some(weighting), _) => {
            let words = weighting.words();
            let path = fit.model.quality.path;
            fit.model.quality.path = path.map(|path| format!("{path}; {words}"));
        }
        (None, Some(weights)) => {
            watch.stage("FRFs weighted by their noise")?;
            let weighted = fitted.weighted(Some((weights, None)), Weights::Again)?;
            return walk(weighted, options, watch);
        }
        (None, None) => {}
    }
    checked(&fitted, &seen, options, residual, &mut fit.model);
    Ok(fit)
}

/// Runs the checks of the data, then takes an exponential window off the poles. `seen`:
/// residual energy of each FRF, weighted.
fn checked<S: Source>(
    fitted: &S,
    seen: &[f64],
    options: &FitOptions,
    residual: Residual,
    model: &mut ModalModel,
) {
    model.quality.findings.extend(outliers::finding(fitted));
    let noise = Noise {
        variance: noise_variance(fitted, seen, model.quality.relative_error),
        left_of_frfs: seen,
    };
    examine(fitted, fitted.values(), options, residual, noise, model);
    if fitted.values().is_none() {
        model.quality.findings.push(not_checked());
    }
    if let Some(alpha) = options.exponential_window_per_s {
        exponential::undo(model, alpha);
    }
}

/// Noise variance of one work value: from the residuals of weighted FRFs if they are known,
/// else from the relative error of the model.
fn noise_variance(data: &DataLayout, seen: &[f64], relative_error: f64) -> f64 {
    match data.weighting.is_some() && !seen.is_empty() {
        true => seen.iter().sum::<f64>() / (data.lines.len() * data.pairs.len()) as f64,
        false => (relative_error * data.measured_over_used()).powi(2),
    }
}

/// The finding where a coherence was given and not used.
fn coherence_contradicted() -> Finding {
    Finding::note(
        "coherence-contradicted",
        "the coherence of the set does not tell its noise: the residuals of the FRFs differ \
         otherwise; weighted by those instead",
    )
}

/// The checks that need single FRFs, where these are not at hand.
fn not_checked() -> Finding {
    Finding::note(
        "not-checked",
        "fitted in pieces: whether poles move between FRFs or split into several, a reference is \
         not reciprocal, a window broadens the lines, or noise of unequal FRFs shows modes was \
         not looked at",
    )
    .help("fit some blocks by themselves to see")
}

/// Outlier lines are left out at most [`OUTLIER_ROUNDS`] times, and never after FRFs were
/// weighted by a residual.
fn outlier_lines(data: &DataLayout) -> OutlierLines {
    let by_residual = |weighting: &Weighting| weighting.giver.is_none();
    match data.outlier_rounds < OUTLIER_ROUNDS && !data.weighting.as_ref().is_some_and(by_residual)
    {
        true => OutlierLines::LeaveOut,
        false => OutlierLines::Keep,
    }
}

/// Runs the method asked for; the default one where single FRFs are not at hand.
fn identify<S: Source>(
    data: &S,
    options: &FitOptions,
    outlier_lines: OutlierLines,
    watch: &Watch,
) -> Result<MethodRun, S::Stop> {
    let Some(values) = data.values() else {
        return auto(data, options, outlier_lines, watch);
    };
    let by = |method: Finder| -> Result<MethodRun, S::Stop> {
        let (model, stabilization) = fit_by_method(values, options, method, watch)?;
        Ok(MethodRun::whole(model, stabilization))
    };
    match options.method {
        Method::Auto => auto(data, options, outlier_lines, watch),
        Method::Lean => Ok(MethodRun::whole(fit_lean(values, options, watch)?, None)),
        Method::Vf => by(vf),
        Method::Lscf => by(lscf),
        Method::Plscf => by(plscf),
        Method::Aaa => by(aaa),
        Method::Rfp | Method::Grfp => by(rfp),
        Method::Peak => by(peak),
        Method::Circle => by(circle),
    }
}

/// The fast chain with the order given.
fn fit_lean(data: &Screened, options: &FitOptions, watch: &Watch) -> Result<ModalModel, FitError> {
    watch.stage("sketch")?;
    let survey = Survey::new(data, options.seed);
    watch.stage("poles")?;
    let found = lean(survey, options)?;
    watch.stage("damping law")?;
    let identified = with_free_residues(data, found, options)?;
    watch.stage("shapes")?;
    let shaped = Shaped::new(data, identified, options.most_modes())?;
    let residual_energy = shaped.residual_energy(data);
    Ok(shaped.model(data, options, &residual_energy)?)
}
