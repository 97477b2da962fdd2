//! The part of a response that the mean column of a pole does not explain (its leak), and the errors
//! of sums over lines by it (theory.md, eq. F4d).
//!
//! On line k a block of a random force f gives X = Σ_t w_x(t)·f_t·e^{−jω_k t}. With c(k) the mean
//! column of a pole, the response Y leaves U = Y − c·X unexplained. Both X and U are linear in f. So
//! the error of H1, mean(X*·U)/Σw_x², and every sum δ of it over lines, is a quadratic form
//! Σ f_t*·K(t, t′)·f_t′ summed over blocks. For white noise of unit variance and blocks that begin dh
//! apart,
//!
//! E|δ|² = (1/M) Σ_d (1 − |d|/M) Σ K(t, t′)·K*(t − dh, t′ − dh)
//! E δ²  = (1/M) Σ_d (1 − |d|/M) Σ K(t, t′)·K(t′ − dh, t − dh)
//!
//! The second is not zero, because the errors of real and imaginary part differ. Force and poles are
//! taken in a band about one frequency, on [`limits::RECORD_POINTS`] places of a record.

use crate::data::limits;
use crate::data::window::block_errors::BlockErrors;
use chladni_linalg::matmul;
use ndarray::{s, Array2, ArrayView1};
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::ops::Range;

impl BlockErrors {
    /// A band of lines; `None` without a force that leaks.
    ///
    /// * `cycles`: per record, from the middle of the band to each line
    /// * `decay`: −Re s over ω_max of the slowest pole
    pub fn band(&self, cycles: Vec<f64>, decay: f64) -> Option<Band<'_>> {
        let force = self.force.as_ref()?;
        let points = limits::RECORD_POINTS;
        let memory = limits::MEMORY_NEPERS / (decay * self.record).max(limits::DECAY_LEAST_NEPERS);
        let remembered = match self.rest {
            true => 0,
            false => (memory.min(limits::MEMORY_RECORDS) * points as f64).ceil() as usize,
        };
        let turns = Array2::from_shape_fn((points, cycles.len()), |(t, k)| {
            Complex64::from_polar(1.0, TAU * cycles[k] * t as f64 / points as f64)
        });
        let power = force.iter().map(|w| w * w).sum();
        Some(Band {
            errors: self,
            force,
            cycles,
            turns,
            remembered,
            power,
        })
    }
}

/// Lines in a band about one frequency.
pub(crate) struct Band<'a> {
    errors: &'a BlockErrors,
    force: &'a [f64],
    /// Cycles per record from the middle of the band to each line.
    cycles: Vec<f64>,
    /// e^{jω_k t}, (place, line).
    turns: Array2<Complex64>,
    /// Number of places before a record whose force the response remembers.
    remembered: usize,
    /// Σ w_x².
    power: f64,
}

/// Unexplained response on each line to the force at each place: (place, line). Places before the
/// record come first.
pub(crate) struct Leak(Array2<Complex64>);

/// A quadratic form K of the force: (place of f*, place of f).
pub(crate) struct Form(Array2<Complex64>);

impl Band<'_> {
    /// The leak of 1/(jω − s).
    ///
    /// * `offset`: s less the middle of the band, over ω_max
    pub fn leak(&self, offset: Complex64) -> Leak {
        let points = self.force.len();
        let rate = offset * self.errors.record / points as f64;
        let (step, unit) = (rate.exp(), self.errors.record / points as f64);
        let response = &self.errors.response;
        // correlation of both windows
        let correlation: Vec<f64> = (0..points)
            .map(|lag| {
                let both = (lag..points).map(|t| response[t] * self.force[t - lag]);
                both.sum::<f64>() / self.power
            })
            .collect();
        let mut all = Array2::zeros((self.remembered + points, self.cycles.len()));
        for (k, &cycles) in self.cycles.iter().enumerate() {
            let turn = Complex64::from_polar(1.0, -TAU * cycles / points as f64);
            let mut mean = Complex64::from(-0.5 * correlation[0]);
            let mut factor = Complex64::ONE;
            for value in &correlation {
                mean += value * factor;
                factor *= step * turn;
            }
            // response to a force at this place, over the rest of the record
            let mut later = Complex64::default();
            for place in (0..points).rev() {
                let back = self.turns[[place, k]].conj();
                let here = response[place] * back;
                later = here + step * later;
                if place < self.errors.driven {
                    let unexplained = later - 0.5 * here - mean * self.force[place] * back;
                    all[[self.remembered + place, k]] = unit * unexplained;
                }
            }
            for place in (0..self.remembered).rev() {
                later *= step;
                all[[place, k]] = unit * later;
            }
        }
        Leak(all)
    }

    /// The form of the error Σ_k Σ weight(k)·leak(k), summed over `parts` (weights of lines, leak).
    pub fn form<'b>(&self, parts: impl Iterator<Item = (Vec<Complex64>, &'b Leak)>) -> Form {
        let mut weighted_leaks: Array2<Complex64> =
            Array2::zeros((self.cycles.len(), self.remembered + self.force.len()));
        for (weights, Leak(leak)) in parts {
            for ((mut row, weight), column) in
                (weighted_leaks.rows_mut().into_iter().zip(weights)).zip(leak.columns())
            {
                row.zip_mut_with(&column, |sum, value| *sum += weight * value);
            }
        }
        let mut form = matmul(self.turns.view(), weighted_leaks.view());
        for (mut row, w) in form.rows_mut().into_iter().zip(self.force) {
            row.mapv_inplace(|v| v * (w / self.power));
        }
        // rows contiguous in memory, whatever the layout of the product
        Form(form.as_standard_layout().to_owned())
    }

    /// E δ_a·δ_b* of the errors with these forms, per block.
    pub fn covariance(&self, forms: &[Form]) -> Array2<Complex64> {
        let (points, columns) = (self.force.len(), self.remembered + self.force.len());
        let mut all = Array2::<Complex64>::zeros((forms.len(), forms.len()));
        for (shift, weight) in self.errors.shifts() {
            let (rows, range) = (overlap(points, shift), overlap(columns, shift));
            for (a, Form(form)) in forms.iter().enumerate() {
                for (b, Form(other)) in forms[..=a].iter().enumerate() {
                    let each = rows.clone().map(|t| {
                        let row = form.slice(s![t, range.clone()]);
                        let shifted = s![(t as isize - shift) as usize, moved_back(&range, shift)];
                        dot_conjugate(row, other.slice(shifted))
                    });
                    all[[a, b]] += weight * each.sum::<Complex64>();
                }
            }
        }
        for a in 0..forms.len() {
            for b in 0..a {
                all[[b, a]] = all[[a, b]].conj();
            }
        }
        all
    }

    /// E δ² of the error with this form, per block.
    pub fn mean_square(&self, Form(form): &Form) -> Complex64 {
        let (points, before) = (self.force.len() as isize, self.remembered as isize);
        let of_shift = |(shift, weight): (isize, f64)| -> Complex64 {
            // K(t, t′)·K(t′ − shift, t − shift): the places change roles
            let rows = (shift - before).max(0)..points.min(points + shift);
            let columns = shift.max(-before)..points.min(points + shift);
            let each = rows.map(|t| {
                let row = form.slice(s![t, columns.start + before..columns.end + before]);
                let transposed = s![
                    columns.start - shift..columns.end - shift,
                    t - shift + before
                ];
                dot(row, form.slice(transposed))
            });
            weight * each.sum::<Complex64>()
        };
        self.errors.shifts().map(of_shift).sum()
    }
}

/// Places among `count` that are still places after moving back by `shift`.
fn overlap(count: usize, shift: isize) -> Range<usize> {
    let end = count.saturating_add_signed(shift).min(count);
    (shift.max(0) as usize).min(end)..end
}

/// The range moved back by `shift`.
fn moved_back(range: &Range<usize>, shift: isize) -> Range<usize> {
    let from = |place: usize| (place as isize - shift) as usize;
    from(range.start)..from(range.end)
}

/// Σ a·b.
fn dot(a: ArrayView1<Complex64>, b: ArrayView1<Complex64>) -> Complex64 {
    a.iter().zip(&b).map(|(a, b)| a * b).sum()
}

/// Σ a·b*.
fn dot_conjugate(a: ArrayView1<Complex64>, b: ArrayView1<Complex64>) -> Complex64 {
    a.iter().zip(&b).map(|(a, b)| a * b.conj()).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::window::block_errors::tests::{made, RECORD};
    use crate::data::window::kinds::Window;
    use chladni_frf::{Estimation, Forcing};
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// E δ² and E|δ|² of the error of a pole, foretold and found in records of `blocks` blocks.
    fn moments(errors: &BlockErrors, blocks: usize) -> [(Complex64, Complex64); 2] {
        const DRAWS: usize = 1500;
        let points = limits::RECORD_POINTS;
        let weights_of_force = errors.force.as_ref().unwrap();
        let power: f64 = weights_of_force.iter().map(|w| w * w).sum();
        // one and a half lines per half-power bandwidth, between two lines
        let offset = Complex64::new(-1.5 * std::f64::consts::PI, 0.3 * TAU) / RECORD;
        let cycles: Vec<f64> = (-4..=4).map(f64::from).collect();
        // as in the sum that is a pole's error
        let weight = |cycles: &f64| {
            let place = Complex64::new(0.0, TAU * cycles) - offset * RECORD;
            place.powi(-2).conj()
        };
        let weights: Vec<Complex64> = cycles.iter().map(weight).collect();
        let band = errors.band(cycles.clone(), -offset.re).unwrap();
        let leak = band.leak(offset);
        let form = band.form(std::iter::once((weights.clone(), &leak)));
        let foretold = [band.mean_square(&form), band.covariance(&[form])[[0, 0]]];

        let (step, unit) = (
            (offset * RECORD / points as f64).exp(),
            RECORD / points as f64,
        );
        let mean = |cycles: f64| -> Complex64 {
            let lag = |lag: usize| {
                let both = |t: usize| errors.response[t] * weights_of_force[t - lag];
                let rho: f64 = (lag..points).map(both).sum();
                let half = if lag == 0 { 0.5 } else { 1.0 };
                let turn = -TAU * cycles * lag as f64 / points as f64;
                half * unit * rho / power * step.powi(lag as i32) * Complex64::from_polar(1.0, turn)
            };
            (0..points).map(lag).sum()
        };
        let means: Vec<Complex64> = cycles.iter().map(|c| mean(*c)).collect();
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let mut found = [Complex64::default(); 2];
        // records at rest have a force at the first places alone
        let settled = if errors.rest { 0 } else { 4 * points };
        for _ in 0..DRAWS {
            let mut normal = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
            let samples = settled + (blocks - 1) * errors.hop + points;
            let force: Vec<Complex64> = (0..samples)
                .map(|t| match t % points < errors.driven {
                    true => Complex64::new(normal(), normal()) / 2f64.sqrt(),
                    false => Complex64::ZERO,
                })
                .collect();
            let mut state = Complex64::default();
            let next = |(t, f): (usize, &Complex64)| {
                if errors.rest && t % points == 0 {
                    state = Complex64::ZERO;
                }
                let before = step * state;
                state = before + f;
                unit * (before + 0.5 * f)
            };
            let response: Vec<Complex64> = force.iter().enumerate().map(next).collect();
            let mut error = Complex64::default();
            for block in 0..blocks {
                let first = settled + block * errors.hop;
                for ((cycles, mean), weight) in cycles.iter().zip(&means).zip(&weights) {
                    let of = |samples: &[Complex64], window: &[f64]| -> Complex64 {
                        let turn = -TAU * cycles / points as f64;
                        let each = samples[first..].iter().zip(window).enumerate();
                        each.map(|(t, (v, w))| v * Complex64::from_polar(*w, turn * t as f64))
                            .sum()
                    };
                    let x = of(&force, weights_of_force);
                    let y = of(&response, &errors.response);
                    error += weight * x.conj() * (y - mean * x) / (power * blocks as f64);
                }
            }
            found[0] += error * error / DRAWS as f64;
            found[1] += error.norm_sqr() / DRAWS as f64;
        }
        [0, 1].map(|k| (foretold[k] / blocks as f64, found[k]))
    }

    #[test]
    fn moments_are_those_of_simulated_records() {
        let overlapped = made(12, 1.0 / 3.0);
        let bursts = Estimation {
            forcing: Some(Forcing::Burst { part: 0.75 }),
            ..made(4, 1.0)
        };
        let bursts_in_hann = Window::HannBurst { part: 0.75 };
        let cases = [
            (Window::Hann, overlapped, 12),
            (Window::Burst { part: 0.75 }, bursts, 4),
            (bursts_in_hann, bursts, 4),
        ];
        for (window, made, blocks) in cases {
            let errors = BlockErrors::new(Some(window), Some(&made), 0.0, RECORD).unwrap();
            let all = moments(&errors, blocks);
            let [twice, whole] = all;
            assert!(twice.0.norm() > 0.2 * whole.0.re, "{window}: {all:?}");
            for (foretold, found) in all {
                let off = (found - foretold).norm();
                assert!(
                    off < 0.1 * foretold.norm(),
                    "{window}: {found} for {foretold}"
                );
            }
        }
    }
}
