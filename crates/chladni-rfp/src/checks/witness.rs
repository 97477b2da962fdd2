//! Evidence of the window in the errors of neighbouring lines (theory.md, eq. F4c).
//!
//! Noise of the responses leaves in H1 of windowed records of a random force errors whose
//! correlation at a lag of q lines is |r_w(q)|², r_w the transform of w² over its sum: 0
//! without a window, 0.44 and 0.03 with Hann's. Leakage of distant modes leaves r_w itself.
//! Of one smooth force (hammer) r_w is that of noise too. Line shapes enter nowhere: the
//! lines beside modes are left out, and sixth differences take what a model misses. Where
//! they do not take all of it, one stretch of lines may decide, or errors are left that no
//! correlation explains: both count against the likeliest.
//!
//! Errors that FRFs share are leakage. Where noise is low it is what slope and curvature of
//! an FRF leak, nearly white under a Hann window.

use crate::checks::around::without_others;
use crate::checks::case::Case;
use crate::checks::correlation::{hypotheses, Correlation, Hypothesis, Judged, TAPERED};
use crate::checks::limits;
use crate::data::error::FitError;
use crate::data::options::FitOptions;
use crate::data::peaks::running_median;
use crate::data::screening::Screened;
use crate::data::window::of_set::with_set;
use chladni_frf::{FrfSet, ModalModel};
use ndarray::{Array2, ArrayView1, ShapeBuilder};
use num_complex::Complex64;
use std::f64::consts::LN_10;
use std::ops::Range;

/// The likeliest correlation of the errors.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Witness {
    /// The cause.
    pub likeliest: Correlation,
    /// Log-likelihood over that of the next best, without the stretch of lines that favours it
    /// most, less a part of the correlation that it leaves unexplained.
    pub gain: f64,
    /// True for each of [`TAPERED`] that the errors do not exclude.
    pub(crate) open: [bool; TAPERED.len()],
    /// True where FRFs share their errors: leakage, which continuous excitation alone leaves.
    pub(crate) leakage: bool,
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
    let options = with_set(frf, options);
    let screened = Screened::new(frf, &options)?;
    Ok(witness(&Case::of_fit(&screened, model, &options)))
}

/// The likeliest correlation; `None` where the data cannot be asked, or too few lines hold
/// noise alone.
pub(crate) fn witness(case: &Case) -> Option<Witness> {
    let data = case.values?;
    let lines = data.line_hz.len();
    let step_hz = data.line_spacing_hz();
    let even = |two: &[f64]| (two[1] - two[0] - step_hz).abs() < limits::WITNESS_UNEVEN * step_hz;
    if lines < limits::SHORT_STRETCH + limits::SIXTH.len() || !data.line_hz.windows(2).all(even) {
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
    let of_length = |length: usize| -> Vec<Stretch> {
        let columns = residual.columns().into_iter().enumerate();
        columns
            .flat_map(|(n, errors)| stretches((n, data.pairs[frfs[n]].1), errors, &away, length))
            .collect()
    };
    // short stretches say less, and are used where modes leave no long ones between them
    let stretches = [limits::STRETCH, limits::SHORT_STRETCH]
        .into_iter()
        .map(of_length)
        .find(|found| found.len() >= limits::STRETCHES_LEAST)?;
    let share = (limits::FRFS_ASKED.1 as f64 / frfs.len() as f64).min(1.0);
    judged(&stretches, share)
}

/// Neighbouring lines of one FRF that hold noise alone.
struct Stretch {
    frf: usize,
    /// Reference of the FRF.
    reference: usize,
    /// The first line.
    first: usize,
    /// Sixth differences.
    errors: Vec<Complex64>,
}

impl Stretch {
    /// |Σ a·b*|² over Σ|a|²·Σ|b|² on shared lines; `None` of one FRF, or on few lines.
    fn coherence(&self, other: &Self) -> Option<f64> {
        let first = self.first.max(other.first);
        let end = self.first.min(other.first) + self.errors.len();
        if self.frf == other.frf || end < first + limits::STRETCH / 2 {
            return None;
        }
        let of = |own: &Self| own.errors[first - own.first..end - own.first].to_vec();
        let (a, b) = (of(self), of(other));
        let across: Complex64 = a.iter().zip(&b).map(|(a, b)| a * b.conj()).sum();
        let power = |v: &[Complex64]| v.iter().map(|v| v.norm_sqr()).sum::<f64>();
        Some(across.norm_sqr() / (power(&a) * power(&b)).max(f64::MIN_POSITIVE))
    }
}

/// True if FRFs share their errors; `None` for one FRF, or if too few pairs of FRFs tell.
///
/// FRFs of one force are compared. Those of different forces share less, and are compared only
/// if no two FRFs have the same force.
fn shared(stretches: &[Stretch]) -> Option<bool> {
    let between = |of_one_force: bool| {
        let pairs = stretches.iter().enumerate().flat_map(|(n, stretch)| {
            let same = |other: &&Stretch| !of_one_force || other.reference == stretch.reference;
            let others = stretches[..n].iter().filter(move |other| same(other));
            others.filter_map(move |other| stretch.coherence(other))
        });
        pairs.fold((0.0, 0.0), |(sum, count), c| (sum + c, count + 1.0))
    };
    let (sum, count) = match between(true) {
        (_, 0.0) => between(false),
        pairs => pairs,
    };
    // by chance it goes as one over the lines
    let first = stretches.first()?;
    let coherence = sum * first.errors.len() as f64 / (count * limits::STRETCH as f64);
    if coherence > limits::SHARED {
        return Some(true);
    }
    // coherences scatter as much as their mean: few pairs do not show that errors are
    // independent
    let (of_chance, of_leakage) = limits::COHERENCE;
    let nats = (of_leakage / of_chance).ln() - coherence * (1.0 / of_chance - 1.0 / of_leakage);
    let of_one_force = stretches
        .iter()
        .all(|other| other.reference == first.reference);
    (count * nats > limits::APART[usize::from(!of_one_force)]).then_some(false)
}

/// The stretches of one FRF, of `length` lines.
///
/// * `frf`: its place and its reference
fn stretches(
    (frf, reference): (usize, usize),
    errors: ArrayView1<Complex64>,
    away: &[bool],
    length: usize,
) -> Vec<Stretch> {
    let differences: Vec<Complex64> = errors
        .windows(limits::SIXTH.len())
        .into_iter()
        .map(|seven| seven.iter().zip(limits::SIXTH).map(|(e, w)| e * w).sum())
        .collect();
    let squares: Vec<f64> = differences.iter().map(|d| d.norm_sqr()).collect();
    let level = running_median(&squares, limits::LEVEL_AROUND);
    let usable: Vec<bool> = (0..differences.len())
        .map(|k| away[k..k + limits::SIXTH.len()].iter().all(|away| *away))
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
        if run.len() == length {
            found.push(Stretch {
                frf,
                reference,
                first: run.start,
                errors: differences[run.clone()].to_vec(),
            });
            run = k + 1..k + 1;
        }
    }
    found
}

/// The likeliest of all correlations, each log-likelihood times `share`.
fn judged(stretches: &[Stretch], share: f64) -> Option<Witness> {
    let length = stretches.first()?.errors.len();
    let columns = Array2::from_shape_fn((length, stretches.len()).f(), |(k, c)| {
        stretches[c].errors[k]
    });
    let shared = shared(stretches);
    let held = |own: Hypothesis| Some((Judged::new(&columns, &own.at_lag)?, own));
    let mut all: Vec<(Judged, Hypothesis)> = hypotheses(shared.unwrap_or(true))
        .into_iter()
        .map(held)
        .collect::<Option<_>>()?;
    all.sort_by(|a, b| b.0.sum().total_cmp(&a.0.sum()));
    let (first, likeliest) = all.first()?;
    let (next, _) = all.iter().find(|(_, own)| own.cause != likeliest.cause)?;
    let gains = || {
        first
            .of_stretches
            .iter()
            .zip(&next.of_stretches)
            .map(|(a, b)| a - b)
    };
    let without_most = gains().sum::<f64>() - gains().fold(0.0, f64::max);
    let excluded = |own: &Judged| share * (first.sum() - own.sum()) > limits::DECIDES;
    let open = |window| {
        let mut of_window = all.iter().filter(|(_, own)| own.window == Some(window));
        of_window.any(|(own, _)| !excluded(own))
    };
    Some(Witness {
        likeliest: likeliest.cause,
        open: TAPERED.map(open),
        leakage: shared == Some(true),
        gain: share * (without_most - limits::MISFIT_COUNTS * first.unexplained()),
    })
}

/// A log-likelihood in powers of ten, for words.
pub(crate) fn decades(gain: f64) -> f64 {
    gain / LN_10
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::window::kernel::{FLATTOP, HANN};
    use chladni_linalg::fft;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use std::f64::consts::PI;

    /// Errors of H1 over 200 lines: products of the transforms of windowed noise of force
    /// and response, averaged; of one blow the response's alone.
    fn errors(window: &dyn Fn(f64) -> f64, averages: Option<usize>, seed: u64) -> Vec<Complex64> {
        errors_of([window, window], averages, seed)
    }

    /// The same under one window for the force and one for the response.
    fn errors_of(
        [of_force, of_response]: [&dyn Fn(f64) -> f64; 2],
        averages: Option<usize>,
        seed: u64,
    ) -> Vec<Complex64> {
        const SAMPLES: usize = 1024;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let fft = fft::forward(SAMPLES);
        let mut spectrum = |window: &dyn Fn(f64) -> f64| {
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
            return spectrum(of_response);
        };
        let mut sum = vec![Complex64::default(); 200];
        for _ in 0..averages {
            let (force, response) = (spectrum(of_force), spectrum(of_response));
            for ((sum, x), y) in sum.iter_mut().zip(&force).zip(&response) {
                *sum += y * x.conj();
            }
        }
        sum
    }

    fn judged_errors(window: &dyn Fn(f64) -> f64, averages: Option<usize>, seed: u64) -> Witness {
        let away = vec![true; 200];
        let all: Vec<Stretch> = (0..3)
            .flat_map(|frf| {
                let errors = errors(window, averages, 3 * seed + frf);
                stretches(
                    (frf as usize, 0),
                    ndarray::aview1(&errors),
                    &away,
                    limits::STRETCH,
                )
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
        type Case<'a> = (
            &'a dyn Fn(f64) -> f64,
            Option<usize>,
            Correlation,
            Option<usize>,
        );
        let cases: [Case; 6] = [
            (&|_| 1.0, Some(20), Correlation::White, None),
            (&|_| 1.0, None, Correlation::White, None),
            (&hann, Some(20), Correlation::Tapered, Some(0)),
            (&flattop, Some(20), Correlation::Tapered, Some(2)),
            (&|u| (-4.0 * u).exp(), None, Correlation::Exponential, None),
            (
                &|u| f64::from(u8::from(u < 0.5)),
                None,
                Correlation::Padded,
                None,
            ),
        ];
        let mut undecided = 0;
        for (n, (window, averages, expected, made)) in cases.into_iter().enumerate() {
            for seed in 0..40 {
                let found = judged_errors(window, averages, 1000 * n as u64 + seed);
                // what made the errors is not excluded
                let open = made.is_none_or(|place: usize| found.open[place]);
                assert!(open, "{expected:?}, {seed}");
                undecided += usize::from(found.gain < 3.0);
                assert!(
                    found.likeliest == expected || found.gain < 3.0,
                    "{expected:?}, seed {seed}: {found:?}"
                );
            }
        }
        assert!(undecided < 12, "{undecided} of 240");
    }

    #[test]
    fn bursts_under_a_hann_window_are_not_taken_for_padded_records() {
        let hann = |u: f64| (PI * u).sin().powi(2);
        let mut told = 0;
        for (n, part) in [0.3, 0.35, 0.6].into_iter().enumerate() {
            let burst = |u: f64| if u < part { hann(u) } else { 0.0 };
            for seed in 0..20 {
                let all: Vec<Stretch> = (0..3)
                    .flat_map(|frf| {
                        let seed = 5000 + 300 * n as u64 + 3 * seed + frf;
                        let errors = errors_of([&burst, &hann], Some(20), seed);
                        let frf = (frf as usize, 0);
                        let errors = ndarray::aview1(&errors);
                        stretches(frf, errors, &[true; 200], limits::STRETCH)
                    })
                    .collect();
                let found = judged(&all, 1.0).unwrap();
                told += usize::from(found.decides());
                assert!(
                    found.likeliest == Correlation::Tapered || !found.decides(),
                    "{part}, seed {seed}: {found:?}"
                );
            }
        }
        assert!(told > 40, "{told} of 60");
    }

    #[test]
    fn frfs_of_one_force_tell_whether_errors_are_shared() {
        // two responses to four forces; half of the errors is their own
        let noise = |seed: u64| -> Vec<Complex64> { errors(&|_| 1.0, Some(20), seed) };
        let all = |first: u64| -> Vec<Stretch> {
            (0..8)
                .flat_map(|frf: usize| {
                    let of_force = noise(first + (frf / 2) as u64);
                    let own = noise(first + 100 + frf as u64);
                    let sum: Vec<Complex64> =
                        of_force.iter().zip(&own).map(|(a, b)| a + b).collect();
                    let sum = ndarray::aview1(&sum);
                    stretches((frf, frf / 2), sum, &[true; 200], limits::STRETCH)
                })
                .collect()
        };
        for seed in 0..10 {
            assert_eq!(shared(&all(9000 + 200 * seed)), Some(true), "{seed}");
        }
    }

    #[test]
    fn few_frfs_do_not_tell_that_errors_are_independent() {
        let of = |frfs: u64, seed: u64| -> Vec<Stretch> {
            (0..frfs)
                .flat_map(|frf| {
                    let own = errors(&|_| 1.0, Some(20), 20_000 + 10 * seed + frf);
                    let own = ndarray::aview1(&own);
                    stretches((frf as usize, 0), own, &[true; 200], limits::STRETCH)
                })
                .collect()
        };
        // one pair each, then the fifteen pairs of six FRFs on each of four stretches
        let mut apart = [0; 2];
        for seed in 0..20 {
            let one_pair = of(2, seed).into_iter().filter(|own| own.first == 0);
            let one_pair: Vec<Stretch> = one_pair.collect();
            let told = [shared(&one_pair), shared(&of(6, seed))];
            for (count, told) in apart.iter_mut().zip(told) {
                *count += usize::from(told == Some(false));
            }
        }
        assert_eq!(apart, [0, 20]);
    }

    /// Sums over blocks of X*·(what a slope of an FRF leaks), the same in three FRFs.
    fn leaked_slopes(seed: u64) -> Vec<Stretch> {
        const SAMPLES: usize = 1024;
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let fft = fft::forward(SAMPLES);
        let mut sum = vec![Complex64::default(); 200];
        for _ in 0..20 {
            let mut normal = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
            let place = |k: usize| (k as f64 + 0.5) / SAMPLES as f64 - 0.5;
            let mut force: Vec<Complex64> = (0..SAMPLES)
                .map(|k| Complex64::from(normal() * (PI * place(k)).cos().powi(2)))
                .collect();
            let mut slope: Vec<Complex64> = (0..SAMPLES).map(|k| force[k] * place(k)).collect();
            fft.process(&mut force);
            fft.process(&mut slope);
            let both = force[50..250].iter().zip(&slope[50..250]);
            for (sum, (x, z)) in sum.iter_mut().zip(both) {
                *sum += z * x.conj();
            }
        }
        let away = vec![true; 200];
        (0..3)
            .flat_map(|frf| stretches((frf, 0), ndarray::aview1(&sum), &away, limits::STRETCH))
            .collect()
    }

    #[test]
    fn leakage_of_slopes_is_not_read_as_no_window() {
        for seed in 0..40 {
            let all = leaked_slopes(seed);
            assert_eq!(shared(&all), Some(true));
            let found = judged(&all, 1.0).unwrap();
            assert!(
                found.likeliest == Correlation::Tapered || !found.decides(),
                "seed {seed}: {found:?}"
            );
        }
    }
}
