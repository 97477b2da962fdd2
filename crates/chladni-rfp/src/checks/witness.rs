//! Evidence of the window in the errors of neighbouring lines (theory.md, eq. F4c).
//!
//! Noise of the responses leaves in H1 of windowed records of a random force errors whose
//! correlation at a lag of q lines is |r_w(q)|², r_w the transform of w² over its sum: 0
//! without a window, 0.44 and 0.03 with Hann's. Leakage of distant modes leaves r_w itself.
//! Of one smooth force (hammer) r_w is that of noise too. Line shapes enter nowhere: the
//! lines beside modes are left out, and fourth differences take what a model misses.

use crate::checks::case::Case;
use crate::checks::limits;
use crate::checks::moving::without_others;
use crate::damping::window_kernel::{BLACKMAN, FLATTOP, HANN};
use crate::data::error::FitError;
use crate::data::options::FitOptions;
use crate::data::peaks::running_median;
use crate::data::screening::Screened;
use crate::data::window::told;
use chladni_frf::{FrfSet, ModalModel};
use chladni_linalg::{cholesky, solve_lower};
use ndarray::{Array2, ArrayView1, ShapeBuilder};
use num_complex::Complex64;
use std::f64::consts::{LN_10, PI};
use std::fmt;
use std::ops::Range;

/// The cause of correlated errors of neighbouring lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Correlation {
    /// Nothing: no window.
    White,
    /// A Hann window.
    Hann,
    /// A Blackman window.
    Blackman,
    /// A flat-top window.
    Flattop,
    /// An exponential window.
    Exponential,
    /// Records of which half are zeros.
    Padded,
}

impl fmt::Display for Correlation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::White => "without a window",
            Self::Hann => "under a Hann window",
            Self::Blackman => "under a Blackman window",
            Self::Flattop => "under a flat-top window",
            Self::Exponential => "under an exponential window",
            Self::Padded => "in records padded with zeros",
        })
    }
}

/// The likeliest correlation of the errors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Witness {
    /// The cause.
    pub likeliest: Correlation,
    /// Log-likelihood over that of the next.
    pub gain: f64,
}

impl Witness {
    /// True where the errors say enough for a finding to name their cause.
    pub fn decides(&self) -> bool {
        self.gain > limits::SAYS
    }
}

/// The likeliest correlation of what `model` leaves of the FRFs it was fitted to with
/// `options`; `None` where too few lines hold noise alone.
///
/// # Errors
/// Those of a fit that cannot begin.
pub fn error_witness(
    frf: &FrfSet,
    options: &FitOptions,
    model: &ModalModel,
) -> Result<Option<Witness>, FitError> {
    let options = told(frf, options);
    let screened = Screened::new(frf, &options)?;
    Ok(witness(&Case {
        data: &screened,
        values: Some(&screened),
        model,
        options: &options,
        white: false,
        noise_variance: 0.0,
    }))
}

/// The likeliest correlation; `None` where the data cannot be asked, or too few lines hold
/// noise alone.
pub(crate) fn witness(case: &Case) -> Option<Witness> {
    let data = case.values?;
    let lines = data.line_hz.len();
    let step_hz = data.line_spacing_hz();
    let even = |two: &[f64]| (two[1] - two[0] - step_hz).abs() < 0.01 * step_hz;
    if lines < limits::STRETCH + limits::FOURTH.len() || !data.line_hz.windows(2).all(even) {
        return None;
    }
    let beside = |hz: f64| {
        case.model.modes.iter().any(|mode| {
            let reach = (limits::BESIDE.0 * mode.loss_factor * mode.frequency_hz)
                .max(limits::BESIDE.1 * step_hz);
            (mode.frequency_hz - hz).abs() < reach
        })
    };
    let away: Vec<bool> = data.line_hz.iter().map(|hz| !beside(*hz)).collect();
    let every = data.pairs.len().div_ceil(limits::FRFS_ASKED.0);
    let frfs: Vec<usize> = (0..data.pairs.len()).step_by(every).collect();
    let (_, residual) = without_others(case, &[], 0..lines, &frfs)?;
    let stretches: Vec<Vec<Complex64>> = residual
        .columns()
        .into_iter()
        .flat_map(|errors| stretches(errors, &away))
        .collect();
    if stretches.len() < limits::STRETCHES_LEAST {
        return None;
    }
    let share = (limits::FRFS_ASKED.1 as f64 / frfs.len() as f64).min(1.0);
    judged(&stretches, share)
}

/// Fourth differences on the stretches of one FRF that hold noise alone.
fn stretches(errors: ArrayView1<Complex64>, away: &[bool]) -> Vec<Vec<Complex64>> {
    let differences: Vec<Complex64> = errors
        .windows(limits::FOURTH.len())
        .into_iter()
        .map(|five| five.iter().zip(limits::FOURTH).map(|(e, w)| e * w).sum())
        .collect();
    let squares: Vec<f64> = differences.iter().map(|d| d.norm_sqr()).collect();
    let level = running_median(&squares, limits::LEVEL_AROUND);
    let usable: Vec<bool> = (0..differences.len())
        .map(|k| away[k..k + limits::FOURTH.len()].iter().all(|away| *away))
        .collect();
    let mut sorted: Vec<f64> = (0..level.len())
        .filter(|&k| usable[k])
        .map(|k| level[k])
        .collect();
    sorted.sort_by(f64::total_cmp);
    let Some(&quartile) = sorted.get(sorted.len() / 4).filter(|level| **level > 0.0) else {
        return Vec::new();
    };
    let quiet = |k: usize| usable[k] && level[k] < limits::NOISE_ONLY * quartile;
    let mut found = Vec::new();
    let mut run: Range<usize> = 0..0;
    for k in 0..differences.len() {
        run = if quiet(k) {
            run.start..k + 1
        } else {
            k + 1..k + 1
        };
        if run.len() == limits::STRETCH {
            found.push(differences[run.clone()].to_vec());
            run = k + 1..k + 1;
        }
    }
    found
}

/// The likeliest of all correlations, each log-likelihood times `share`.
fn judged(stretches: &[Vec<Complex64>], share: f64) -> Option<Witness> {
    let columns = Array2::from_shape_fn((limits::STRETCH, stretches.len()).f(), |(k, c)| {
        stretches[c][k]
    });
    let mut best: Vec<(Correlation, f64)> = Vec::new();
    for (correlation, at_lag) in hypotheses() {
        let likelihood = share * log_likelihood(&columns, &at_lag)?;
        match best.iter_mut().find(|(other, _)| *other == correlation) {
            Some((_, own)) => *own = own.max(likelihood),
            None => best.push((correlation, likelihood)),
        }
    }
    best.sort_by(|a, b| b.1.total_cmp(&a.1));
    Some(Witness {
        likeliest: best[0].0,
        gain: best[0].1 - best[1].1,
    })
}

/// Correlation of errors over lags of lines.
type AtLag = Box<dyn Fn(i32) -> Complex64>;

fn hypotheses() -> Vec<(Correlation, AtLag)> {
    let mut all: Vec<(Correlation, AtLag)> = Vec::new();
    let white = |lag: i32| Complex64::from(f64::from(u8::from(lag == 0)));
    all.push((Correlation::White, Box::new(white)));
    for (correlation, window) in [
        (Correlation::Hann, &HANN[..]),
        (Correlation::Blackman, &BLACKMAN[..]),
        (Correlation::Flattop, &FLATTOP[..]),
    ] {
        let of_squares = squares(window);
        let at = move |lag: i32| -> f64 {
            let place = lag.unsigned_abs() as usize;
            of_squares.get(place).copied().unwrap_or(0.0)
        };
        let squared = at.clone();
        let squared = move |lag: i32| Complex64::from(squared(lag).powi(2));
        all.push((correlation, Box::new(squared)));
        all.push((
            correlation,
            Box::new(move |lag: i32| Complex64::from(at(lag))),
        ));
    }
    for decay in limits::DECAYS {
        let at = move |lag: i32| decay / Complex64::new(decay, PI * f64::from(lag));
        all.push((Correlation::Exponential, Box::new(at)));
    }
    let half = |lag: i32| match lag {
        0 => Complex64::ONE,
        lag => {
            let turn = 0.5 * PI * f64::from(lag);
            Complex64::from_polar(turn.sin() / turn, -turn)
        }
    };
    all.push((Correlation::Padded, Box::new(half)));
    all
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

/// Of circular normal errors with this correlation, each stretch of its own size: −n·ln(dᴴC⁻¹d)
/// − ln det C, C that of fourth differences.
fn log_likelihood(stretches: &Array2<Complex64>, at_lag: &AtLag) -> Option<f64> {
    let white = |lag: i32| f64::from(u8::from(lag == 0));
    let of_errors = |lag: i32| at_lag(lag) + limits::ALWAYS_WHITE * white(lag);
    let of_differences = |lag: i32| -> Complex64 {
        let pairs = (0..5).flat_map(|a| (0..5).map(move |b| (a, b)));
        pairs
            .map(|(a, b)| {
                limits::FOURTH[a] * limits::FOURTH[b] * of_errors(lag + a as i32 - b as i32)
            })
            .sum()
    };
    let covariance = Array2::from_shape_fn((limits::STRETCH, limits::STRETCH).f(), |(k, q)| {
        of_differences(k as i32 - q as i32)
    });
    let lower = cholesky(covariance.view()).ok()?;
    let half = solve_lower(lower.view(), stretches.view()).ok()?;
    let determinant: f64 = lower.diag().iter().map(|pivot| 2.0 * pivot.re.ln()).sum();
    let of_stretch = |column: ArrayView1<Complex64>| {
        let sum: f64 = column.iter().map(|v| v.norm_sqr()).sum();
        -(limits::STRETCH as f64) * sum.max(f64::MIN_POSITIVE).ln() - determinant
    };
    Some(half.columns().into_iter().map(of_stretch).sum())
}

/// A log-likelihood in powers of ten, for words.
pub(crate) fn decades(gain: f64) -> f64 {
    gain / LN_10
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_linalg::fft;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Errors of H1 over 200 lines: products of the transforms of windowed noise of force
    /// and response, averaged; of one blow the response's alone.
    fn errors(window: &dyn Fn(f64) -> f64, averages: Option<usize>, seed: u64) -> Vec<Complex64> {
        const SAMPLES: usize = 1024;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let fft = fft::forward(SAMPLES);
        let mut spectrum = || {
            let mut samples: Vec<Complex64> = (0..SAMPLES)
                .map(|k| {
                    let normal: f64 = (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
                    Complex64::from(normal * window(k as f64 / SAMPLES as f64))
                })
                .collect();
            fft.process(&mut samples);
            samples[50..250].to_vec()
        };
        let Some(averages) = averages else {
            return spectrum();
        };
        let mut sum = vec![Complex64::default(); 200];
        for _ in 0..averages {
            let (force, response) = (spectrum(), spectrum());
            for ((sum, x), y) in sum.iter_mut().zip(&force).zip(&response) {
                *sum += y * x.conj();
            }
        }
        sum
    }

    fn judged_errors(window: &dyn Fn(f64) -> f64, averages: Option<usize>, seed: u64) -> Witness {
        let away = vec![true; 200];
        let all: Vec<Vec<Complex64>> = (0..3)
            .flat_map(|frf| {
                let errors = errors(window, averages, 3 * seed + frf);
                stretches(ndarray::aview1(&errors), &away)
            })
            .collect();
        judged(&all, 1.0).unwrap()
    }

    #[test]
    fn every_window_is_told_by_the_errors_it_leaves() {
        let cosines = |c: &'static [f64]| {
            move |u: f64| -> f64 {
                let term = |(n, c): (usize, &f64)| {
                    let twice = if n == 0 { 1.0 } else { 2.0 };
                    twice * c * (2.0 * PI * n as f64 * u).cos()
                };
                c.iter().enumerate().map(term).sum()
            }
        };
        let (hann, flattop) = (cosines(&HANN), cosines(&FLATTOP));
        type Case<'a> = (&'a dyn Fn(f64) -> f64, Option<usize>, Correlation);
        let cases: [Case; 6] = [
            (&|_| 1.0, Some(20), Correlation::White),
            (&|_| 1.0, None, Correlation::White),
            (&hann, Some(20), Correlation::Hann),
            (&flattop, Some(20), Correlation::Flattop),
            (&|u| (-4.0 * u).exp(), None, Correlation::Exponential),
            (&|u| f64::from(u8::from(u < 0.5)), None, Correlation::Padded),
        ];
        let mut undecided = 0;
        for (n, (window, averages, expected)) in cases.into_iter().enumerate() {
            for seed in 0..40 {
                let found = judged_errors(window, averages, 1000 * n as u64 + seed);
                undecided += usize::from(found.gain < 3.0);
                assert!(
                    found.likeliest == expected || found.gain < 3.0,
                    "{expected:?}, seed {seed}: {found:?}"
                );
            }
        }
        assert!(undecided < 12, "{undecided} of 240");
    }
}
