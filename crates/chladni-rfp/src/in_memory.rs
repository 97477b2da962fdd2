//! The fit of a set in memory: the walk of [`crate::driver`], and a second one where line shapes
//! speak against the window of the first.

use crate::checks::case::Case;
use crate::checks::window_bias;
use crate::data::error::FitError;
use crate::data::options::FitOptions;
use crate::data::screening::Screened;
use crate::data::watch::{CancelToken, Watch};
use crate::data::window::kinds::Window;
use crate::data::window::of_set::with_set;
use crate::driver::walk;
use crate::methods::fit::Fit;
use chladni_frf::{Estimator, Forcing, FrfSet};
use chladni_linalg::blocked::in_pool;

/// Identifies the modes in `frf`.
///
/// # Errors
/// [`FitError`]: data that cannot be fitted (no kind, no values, implausible numbers, a band
/// that is empty or too narrow, too few lines, a window whose records the lines do not tell), a
/// method that needs even lines or a whole FRF matrix, a kernel that fails. A fit that was made
/// but cannot be trusted is no error: `model.quality.trusted` says so, with the reasons in its
/// warnings.
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
            None if window_bias::damping_may_be_biased(&fit.model) => {
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
    if !window_bias::lines_look_unwindowed(&Case::of_fit(&data, &fit.model, &options)) {
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
            let found = window_bias::known_window_contradicted(window, [&fit.model, &other.model]);
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
    let suspected = window_bias::window_by_line_shapes(&case, &evidence).filter(|_| may_be);
    let Some(window) = suspected else {
        window_bias::widen_bars_for(&mut fit.model, &screened, evidence.suspected());
        return Ok(fit);
    };
    watch.stage("line shape of the window")?;
    let options = FitOptions {
        window: Some(window),
        ..options
    };
    // the first fit stands whatever becomes of this one
    let windowed = Screened::new(frf, &options);
    let second = windowed.and_then(|data| Ok((walk(data.clone(), &options, watch)?, data)));
    let found = match second {
        Ok((second, data)) => {
            let case = Case::of_fit(&data, &second.model, &options);
            window_bias::confirmed_window(&evidence, &case).map(|found| (found, second))
        }
        Err(FitError::Cancelled) => return Err(FitError::Cancelled),
        Err(_) => None,
    };
    let Some((found, mut second)) = found else {
        window_bias::widen_bars_for(&mut fit.model, &screened, evidence.suspected());
        return Ok(fit);
    };
    found.widen_bars_for_other_windows(&mut second.model, &screened);
    second.model.quality.findings.push(found.finding);
    Ok(second)
}
