//! Poles of a merged sketch; the fit of merged products.

use crate::data::options::{FitOptions, Method};
use crate::data::watch::{CancelToken, Watch};
use crate::driver::walk;
use crate::methods::fit::Fit;
use crate::pieces::error::PieceError;
use crate::pieces::merged::{Merged, Stop};
use crate::pieces::partial::Partial;
use crate::pieces::poles::Poles;
use crate::pieces::whole::Whole;
use chladni_linalg::blocked::in_pool;

/// The result of merged partials.
#[derive(Debug, Clone)]
pub enum Solved {
    /// Poles to reduce every block with: those of a sketch, or new ones if a pass showed that
    /// another is needed.
    Poles(Box<Poles>),
    /// The fit.
    Fit(Box<Fit>),
}

/// Solves merged partials: those of a first pass for poles, those of a second for the
/// fit; those of a first pass with a pilot for the fit where the pilot's poles will do.
///
/// The partial is used up: the sums of a million FRFs need not be in memory twice.
/// `progress` is told the name of each stage as it begins. Of `options` a first pass
/// needs `modes`, a second `damping`, `shapes` and `exponential_window_per_s`. The method is
/// the default one, whatever `options` say: the others need single FRFs.
///
/// # Errors
/// [`crate::FitError`] as for [`crate::fit()`]; no block, no sums, an FRF that stands in
/// two, a second pass over other FRFs than the first.
pub fn solve(
    partial: Partial,
    options: &FitOptions,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Solved, PieceError> {
    solve_watched(partial, options, progress, &CancelToken::new())
}

/// As [`solve`]; `cancel` stops it at its next stage.
///
/// # Errors
/// Those of [`solve`]; [`crate::FitError::Cancelled`].
pub fn solve_watched(
    partial: Partial,
    options: &FitOptions,
    progress: &(dyn Fn(&str) + Sync),
    cancel: &CancelToken,
) -> Result<Solved, PieceError> {
    let watch = Watch {
        tell: progress,
        cancel,
    };
    in_pool(|| {
        let whole = Whole::new(partial)?;
        let merged = Merged::new(&whole, options)?;
        let options = FitOptions {
            modes: merged.modes(),
            seed: whole.plan.seed,
            exponential_window_per_s: options
                .exponential_window_per_s
                .or(whole.plan.exponential_window_per_s),
            // the other methods need single FRFs
            method: Method::Auto,
            ..options.clone()
        };
        match walk(merged, &options, &watch) {
            Ok(fit) => Ok(Solved::Fit(Box::new(fit))),
            Err(Stop::Pass(poles)) => Ok(Solved::Poles(poles)),
            Err(Stop::Error(error)) => Err(error),
        }
    })
}
