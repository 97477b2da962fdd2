//! Correlations that errors of neighbouring lines can have, and how likely they are.

use crate::checks::limits;
use crate::data::window::kernel::{BLACKMAN, FLATTOP, HANN};
use crate::data::window::kinds::Window;
use chladni_linalg::{cholesky, solve_lower};
use ndarray::{Array2, ArrayView1, ShapeBuilder};
use num_complex::Complex64;
use std::f64::consts::PI;
use std::fmt;

/// The cause of correlated errors of neighbouring lines.
///
/// Errors are noise of the responses, correlated as |r_w|², mixed with leakage, which is
/// between that and white. So they tell windows that fall off to both ends from others, but not
/// one of these from another: line shapes do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Correlation {
    /// Nothing: no window.
    White,
    /// A window that falls off to both ends of a record: Hann, Blackman, Kaiser, flat top.
    Tapered,
    /// An exponential window.
    Exponential,
    /// Records of which half are zeros.
    Padded,
}

/// Windows that fall off to both ends, the one that broadens lines most last.
pub(super) const TAPERED: [Window; 3] = [Window::Hann, Window::Blackman, Window::Flattop];

impl fmt::Display for Correlation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::White => "without a window",
            Self::Tapered => "under a window that falls off to both ends",
            Self::Exponential => "under an exponential window",
            Self::Padded => "in records padded with zeros",
        })
    }
}

/// Correlation of errors over lags of lines.
pub(super) type AtLag = Box<dyn Fn(i32) -> Complex64>;

/// A correlation and what would make it.
pub(super) struct Hypothesis {
    pub cause: Correlation,
    /// The window of continuous random excitation.
    pub window: Option<Window>,
    pub at_lag: AtLag,
}

/// Correlations of each cause.
///
/// * `leaks`: true where errors may be leakage of slope and curvature
pub(super) fn hypotheses(leaks: bool) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    let mut add = |cause, window, at_lag| {
        all.push(Hypothesis {
            cause,
            window,
            at_lag,
        });
    };
    let white = |lag: i32| Complex64::from(f64::from(u8::from(lag == 0)));
    add(Correlation::White, None, Box::new(white) as AtLag);
    for (window, terms) in TAPERED.into_iter().zip([&HANN[..], &BLACKMAN, &FLATTOP]) {
        let of_squares = squares(terms);
        let at = move |lag: i32| -> f64 {
            let place = lag.unsigned_abs() as usize;
            of_squares.get(place).copied().unwrap_or(0.0)
        };
        let squared = at.clone();
        let squared = move |lag: i32| Complex64::from(squared(lag).powi(2));
        add(Correlation::Tapered, Some(window), Box::new(squared));
        let at = move |lag: i32| Complex64::from(at(lag));
        add(Correlation::Tapered, Some(window), Box::new(at));
        for of_leakage in if leaks { leakage(terms) } else { Vec::new() } {
            let at = move |lag: i32| Complex64::from(of_leakage[lag.unsigned_abs() as usize]);
            add(Correlation::Tapered, Some(window), Box::new(at));
        }
    }
    for part in limits::PARTS {
        let of_burst = burst(part);
        let at = move |lag: i32| {
            let value = of_burst[lag.unsigned_abs() as usize];
            if lag < 0 {
                value.conj()
            } else {
                value
            }
        };
        add(Correlation::Tapered, None, Box::new(at));
    }
    for decay in limits::DECAYS {
        let at = move |lag: i32| decay / Complex64::new(decay, PI * f64::from(lag));
        add(Correlation::Exponential, None, Box::new(at));
    }
    let half = |lag: i32| match lag {
        0 => Complex64::ONE,
        lag => {
            let turn = 0.5 * PI * f64::from(lag);
            Complex64::from_polar(turn.sin() / turn, -turn)
        }
    };
    add(Correlation::Padded, None, Box::new(half));
    all
}

/// Correlations over lags of what the slope and the curvature of an FRF leak under the window
/// w = Σ_n c_n e^{2πjnu}: r_w times the transform of w²u², and of w²(u² − mean)², over its sum,
/// u from the middle of the record.
fn leakage(window: &[f64]) -> Vec<Vec<f64>> {
    let place = |k: usize| (k as f64 + 0.5) / limits::RECORD_PLACES as f64 - 0.5;
    let places: Vec<f64> = (0..limits::RECORD_PLACES).map(place).collect();
    let power = |u: f64| -> f64 {
        let term = |(n, c): (usize, &f64)| 2.0 * c * (2.0 * PI * n as f64 * (u + 0.5)).cos();
        (window.iter().enumerate().map(term).sum::<f64>() - window[0]).powi(2)
    };
    let mean = |of: &dyn Fn(f64) -> f64| -> f64 {
        let weighted = places.iter().map(|&u| power(u) * of(u));
        weighted.sum::<f64>() / places.iter().map(|&u| power(u)).sum::<f64>()
    };
    let middle = mean(&|u| u * u);
    let slope = |u: f64| u * u;
    let curvature = |u: f64| (u * u - middle).powi(2);
    let at_lag = |of: &dyn Fn(f64) -> f64, lag: usize| {
        let turn = 2.0 * PI * lag as f64;
        let of_force = mean(&|u| (turn * u).cos());
        of_force * mean(&|u| of(u) * (turn * u).cos()) / mean(of)
    };
    let lags = 0..limits::STRETCH + limits::SIXTH.len();
    [&slope as &dyn Fn(f64) -> f64, &curvature]
        .map(|of| lags.clone().map(|lag| at_lag(of, lag)).collect())
        .into()
}

/// Correlation over lags of the errors that noise of the responses leaves under Hann's window w,
/// where the force is noise in the first `part` of each record: the transform of w² times the
/// conjugate one of its part in the burst.
fn burst(part: f64) -> Vec<Complex64> {
    let place = |k: usize| (k as f64 + 0.5) / limits::RECORD_PLACES as f64;
    let places: Vec<f64> = (0..limits::RECORD_PLACES).map(place).collect();
    let power = |u: f64| (PI * u).sin().powi(4);
    let transform = |end: f64, lag: usize| -> Complex64 {
        let inside = || places.iter().filter(|u| **u < end);
        let turned = inside().map(|&u| Complex64::from_polar(power(u), -2.0 * PI * lag as f64 * u));
        turned.sum::<Complex64>() / inside().map(|&u| power(u)).sum::<f64>()
    };
    (0..limits::STRETCH + limits::SIXTH.len())
        .map(|lag| transform(1.0, lag) * transform(part, lag).conj())
        .collect()
}

/// r_w of Σ_n c_n e^{2πjnu}: Σ_n c_n c_{q−n} over its value at q = 0.
fn squares(window: &[f64]) -> Vec<f64> {
    let most = window.len() as i32 - 1;
    let c = |n: i32| {
        window
            .get(n.unsigned_abs() as usize)
            .copied()
            .unwrap_or(0.0)
    };
    let at = |q: i32| -> f64 { (-most..=most).map(|n| c(n) * c(q - n)).sum() };
    (0..=2 * most).map(|q| at(q) / at(0)).collect()
}

/// Stretches held against a correlation.
pub(super) struct Judged {
    /// Errors that are independent, if it is theirs; (place, stretch), unit mean square.
    whitened: Array2<Complex64>,
    /// Log-likelihood of each stretch.
    pub of_stretches: Vec<f64>,
}

impl Judged {
    /// Of circular normal errors with this correlation, each stretch of its own size:
    /// −n·ln(dᴴC⁻¹d) − ln det C, C that of sixth differences.
    pub fn new(stretches: &Array2<Complex64>, at_lag: &AtLag) -> Option<Self> {
        let white = |lag: i32| f64::from(u8::from(lag == 0));
        let of_errors = |lag: i32| at_lag(lag) + limits::ALWAYS_WHITE * white(lag);
        let of_differences = |lag: i32| -> Complex64 {
            let terms = limits::SIXTH.len();
            let pairs = (0..terms).flat_map(|a| (0..terms).map(move |b| (a, b)));
            pairs
                .map(|(a, b)| {
                    limits::SIXTH[a] * limits::SIXTH[b] * of_errors(lag + a as i32 - b as i32)
                })
                .sum()
        };
        let length = stretches.nrows();
        let covariance = Array2::from_shape_fn((length, length).f(), |(k, q)| {
            of_differences(k as i32 - q as i32)
        });
        let lower = cholesky(covariance.view()).ok()?;
        let mut whitened = solve_lower(lower.view(), stretches.view()).ok()?;
        let determinant: f64 = lower.diag().iter().map(|pivot| 2.0 * pivot.re.ln()).sum();
        let lines = length as f64;
        let of_stretches = whitened.columns_mut().into_iter().map(|mut column| {
            let sum: f64 = column.iter().map(|v| v.norm_sqr()).sum();
            let sum = sum.max(f64::MIN_POSITIVE);
            let unit = (lines / sum).sqrt();
            column.mapv_inplace(|v| v * unit);
            -lines * sum.ln() - determinant
        });
        let of_stretches = of_stretches.collect();
        Some(Self {
            whitened,
            of_stretches,
        })
    }

    /// Of all stretches.
    pub fn sum(&self) -> f64 {
        self.of_stretches.iter().sum()
    }

    /// Log-likelihood that correlation over the first lags would add, which has a mean of
    /// one for each where there is none: that much is taken off.
    pub fn unexplained(&self) -> f64 {
        let lines = self.whitened.nrows();
        let of_lag = |lag: usize| -> f64 {
            let pairs = (lines - lag) as f64 * self.whitened.ncols() as f64;
            let of_stretch = |column: ArrayView1<Complex64>| -> Complex64 {
                (lag..lines)
                    .map(|k| column[k] * column[k - lag].conj())
                    .sum()
            };
            let columns = self.whitened.columns().into_iter();
            columns.map(of_stretch).sum::<Complex64>().norm_sqr() / pairs
        };
        let sum: f64 = (1..=limits::LAGS_HELD).map(of_lag).sum();
        (sum - limits::LAGS_HELD as f64).max(0.0)
    }
}
