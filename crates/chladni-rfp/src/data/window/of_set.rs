//! The window of a set's records, if it is known.
//!
//! An FRF estimated from continuous random excitation in windowed records of length T is, in the
//! mean, the transform of h(t)·ρ(t), where ρ is the autocorrelation of the window. So every
//! resonance is broadened, and damping comes out too high by about 1/(πb) at b lines per half-power
//! bandwidth. No residual shows this. If the window is known, the columns of the fit have the same
//! line shape: `data/window/leakage.rs`.
//!
//! Theory.md, eq. F4; J. Bendat, A. Piersol, Random Data, 4th ed. (2010), chapter 11. For
//! the exponential window see `model/exponential.rs`.

use crate::data::error::FitError;
use crate::data::limits;
use crate::data::options::FitOptions;
use crate::data::window::kinds::Window;
use chladni_frf::{BlockWindow, Estimation, Estimator, Forcing, FrfSet};

/// The options, with windows from the set if the options leave them open.
pub(crate) fn with_set(frf: &FrfSet, options: &FitOptions) -> FitOptions {
    let made = frf.estimation.as_ref();
    FitOptions {
        window: options.window.or(made.and_then(window_of)),
        exponential_window_per_s: options
            .exponential_window_per_s
            .or(made.and_then(Estimation::added_decay_per_s)),
        ..options.clone()
    }
}

/// The window that leaks, from the estimation of the set; `None` if the set does not say enough.
fn window_of(made: &Estimation) -> Option<Window> {
    if made.estimator.is_local() {
        return Some(Window::None);
    }
    let found = match (made.forcing?, made.window) {
        (Forcing::Continuous, BlockWindow::Hann) => Some(Window::Hann),
        (Forcing::Continuous, BlockWindow::Rectangular) => Some(Window::Rectangular),
        (Forcing::Burst { part }, BlockWindow::Rectangular) => Some(Window::Burst { part }),
        (Forcing::Burst { part }, BlockWindow::Hann) => limits::HANN_BURST_PARTS
            .contains(&part)
            .then_some(Window::HannBurst { part }),
        // an exponential window does not leak: it moves the poles
        (Forcing::Transient, BlockWindow::Rectangular | BlockWindow::Exponential { .. }) => {
            Some(Window::Transient)
        }
        (Forcing::Periodic, BlockWindow::Rectangular) => Some(Window::None),
        _ => None,
    };
    found.filter(|window| made.estimator == Estimator::H1 || !depends_on_estimator(*window))
}

/// True for a window under which the means of H2 and Hv differ from that of H1, because leakage is in
/// their denominators too. The fit knows the line shape of H1 only.
fn depends_on_estimator(window: Window) -> bool {
    !matches!(
        window,
        Window::None | Window::Transient | Window::Burst { .. }
    )
}

/// Part of each record that holds samples, s: from the set, else the inverse of the line spacing; 0 if
/// lines are not evenly spaced.
///
/// # Errors
/// [`FitError::WindowAxis`]: a window that leaks, and lines that are not evenly spaced.
pub(crate) fn record_s(frf: &FrfSet, options: &FitOptions) -> Result<f64, FitError> {
    if let Some(made) = &frf.estimation {
        return Ok(made.gate_s);
    }
    let axis = &frf.frequency_hz;
    let lines = axis.len();
    if lines == 0 {
        return Ok(0.0);
    }
    let step_hz = (axis[lines - 1] - axis[0]) / (lines.max(2) - 1) as f64;
    let is_off_grid =
        |(k, f): (usize, &f64)| (f - axis[0] - k as f64 * step_hz).abs() > limits::EVEN * step_hz;
    let leaks = options.window.is_some_and(|window| window != Window::None);
    let uneven = lines < 2 || axis.iter().enumerate().any(is_off_grid);
    if leaks && uneven {
        return Err(FitError::WindowAxis {
            found: format!("{lines} lines from {} to {} Hz", axis[0], axis[lines - 1]),
        });
    }
    Ok(if step_hz > 0.0 && !uneven {
        1.0 / step_hz
    } else {
        0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_frf::Estimator;

    fn made(window: BlockWindow, forcing: Option<Forcing>) -> Estimation {
        Estimation {
            estimator: Estimator::H1,
            window,
            forcing,
            transform_s: 2.0,
            gate_s: 2.0,
            hop_s: 2.0,
            averages: [3; 2],
            lines_per_value: 1,
        }
    }

    #[test]
    fn an_exponential_window_moves_poles_whatever_the_force_but_continuous_noise() {
        let window = BlockWindow::Exponential { rate_per_s: 1.5 };
        let of = |forcing| made(window, forcing).added_decay_per_s();
        for forcing in [
            Forcing::Transient,
            Forcing::Periodic,
            Forcing::Burst { part: 0.4 },
        ] {
            assert_eq!(of(Some(forcing)), Some(1.5), "{forcing:?}");
        }
        assert_eq!(of(Some(Forcing::Continuous)), None);
        // nobody says
        assert_eq!(of(None), None);
        let plain = made(BlockWindow::Rectangular, Some(Forcing::Transient));
        assert_eq!(plain.added_decay_per_s(), None);
    }

    #[test]
    fn blows_under_a_hann_window_have_no_line_shape_and_say_so() {
        let blows = made(BlockWindow::Hann, Some(Forcing::Transient));
        assert!(blows.hann_on_blows() && window_of(&blows).is_none());
        let of_burst = |part| window_of(&made(BlockWindow::Hann, Some(Forcing::Burst { part })));
        assert_eq!(of_burst(0.6), Some(Window::HannBurst { part: 0.6 }));
        assert_eq!(of_burst(0.01), None);
        let noise = made(BlockWindow::Hann, Some(Forcing::Continuous));
        assert!(!noise.hann_on_blows() && window_of(&noise) == Some(Window::Hann));
    }

    #[test]
    fn local_fits_say_where_their_force_does_not_suit_them() {
        let local = |forcing| Estimation {
            estimator: Estimator::Lrm,
            ..made(BlockWindow::Rectangular, forcing)
        };
        for forcing in [Forcing::Transient, Forcing::Periodic] {
            assert!(local(Some(forcing)).local_on_smooth_force());
        }
        assert!(!local(None).local_on_smooth_force());
        let blows = made(BlockWindow::Rectangular, Some(Forcing::Transient));
        assert!(!blows.local_on_smooth_force());
    }
}
