//! The part of a response that the mean column of a pole does not explain, and the errors that it
//! leaves in sums over lines (theory.md, eq. F4d).
//!
//! On line k a block of a random force f holds X = Σ_t w_x(t)·f_t·e^{−jω_k t} and what the
//! mean column of a pole, c(k), does not explain of the response, U = Y − c·X. Either is
//! linear in f, so the error of H1, mean(X*·U)/Σw_x², and every sum of it over lines, is a
//! quadratic form Σ f_t*·K(t, t′)·f_t′ summed over blocks. White noise of unit variance
//! gives it, over blocks that begin dh apart,
//!
//! E|δ|² = (1/M) Σ_d (1 − |d|/M) Σ K(t, t′)·K*(t − dh, t′ − dh)
//! E δ²  = (1/M) Σ_d (1 − |d|/M) Σ K(t, t′)·K(t′ − dh, t − dh)
//!
//! The second is not zero: real and imaginary part of what is estimated differ. Force and
//! poles are taken in a band about one frequency, on [`limits::RECORD_POINTS`] places of a
//! record.

use crate::data::limits;
use crate::data::window::block_errors::BlockErrors;
use chladni_linalg::matmul;
use ndarray::{s, Array2, ArrayView1};
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::ops::Range;

impl BlockErrors {
    /// The lines at `cycles` from the middle of a band, and poles whose slowest has `decay`.
    ///
    /// * `decay`: −Re s over ω_max
    pub fn band(&self, cycles: Vec<f64>, decay: f64) -> Option<Band<'_>> {
        let force = self.force.as_ref()?;
        let points = limits::RECORD_POINTS;
        let memory = limits::MEMORY_NEPERS / (decay * self.record).max(limits::DECAY_LEAST_NEPERS);
        let before = match self.rest {
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
            before,
            power,
        })
    }
}

/// Lines in a band about one frequency.
pub(crate) struct Band<'a> {
    errors: &'a BlockErrors,
    force: &'a [f64],
    cycles: Vec<f64>,
    /// e^{jω_k t}, (place, line).
    turns: Array2<Complex64>,
    /// Places before a record whose force the response remembers.
    before: usize,
    /// Σ w_x².
    power: f64,
}

/// Response to a force of each place that the mean column does not explain: (place, those
/// before the record first; line).
pub(crate) struct Leak(Array2<Complex64>);

/// A quadratic form of the force: (place of f*, place of f).
pub(crate) struct Form(Array2<Complex64>);

impl Band<'_> {
    /// That of 1/(jω − s).
    ///
    /// * `offset`: s less the middle of the band, over ω_max
    pub fn leak(&self, offset: Complex64) -> Leak {
        let points = self.force.len();
        let rate = offset * self.errors.record / points as f64;
        let (step, unit) = (rate.exp(), self.errors.record / points as f64);
        let response = &self.errors.response;
        let lags: Vec<f64> = (0..points)
            .map(|lag| {
                let both = (lag..points).map(|t| response[t] * self.force[t - lag]);
                both.sum::<f64>() / self.power
            })
            .collect();
        let mut all = Array2::zeros((self.before + points, self.cycles.len()));
        for (k, &cycles) in self.cycles.iter().enumerate() {
            let turn = Complex64::from_polar(1.0, -TAU * cycles / points as f64);
            let mut mean = Complex64::from(-0.5 * lags[0]);
            let mut factor = Complex64::ONE;
            for lag in &lags {
                mean += lag * factor;
                factor *= step * turn;
            }
            let mut later = Complex64::default();
            for place in (0..points).rev() {
                let back = self.turns[[place, k]].conj();
                let here = response[place] * back;
                later = here + step * later;
                if place < self.errors.driven {
                    let left = later - 0.5 * here - mean * self.force[place] * back;
                    all[[self.before + place, k]] = unit * left;
                }
            }
            for place in (0..self.before).rev() {
                later *= step;
                all[[place, k]] = unit * later;
            }
        }
        Leak(all)
    }

    /// The form Σ_k Σ (weight·leak)(k) of the error.
    pub fn form<'b>(&self, parts: impl Iterator<Item = (Vec<Complex64>, &'b Leak)>) -> Form {
        let mut left: Array2<Complex64> =
            Array2::zeros((self.cycles.len(), self.before + self.force.len()));
        for (weights, Leak(leak)) in parts {
            for ((mut row, weight), column) in
                left.rows_mut().into_iter().zip(weights).zip(leak.columns())
            {
                row.zip_mut_with(&column, |sum, value| *sum += weight * value);
            }
        }
        let mut form = matmul(self.turns.view(), left.view());
        for (mut row, w) in form.rows_mut().into_iter().zip(self.force) {
            row.mapv_inplace(|v| v * (w / self.power));
        }
        // rows in one piece, whatever the product made
        Form(form.as_standard_layout().to_owned())
    }

    /// E d_a·d_b* of errors that these forms are, for one block.
    pub fn covariance(&self, forms: &[Form]) -> Array2<Complex64> {
        let (points, columns) = (self.force.len(), self.before + self.force.len());
        let mut all = Array2::<Complex64>::zeros((forms.len(), forms.len()));
        for (shift, weight) in self.errors.shifts() {
            let (rows, range) = (overlap(points, shift), overlap(columns, shift));
            for (a, Form(own)) in forms.iter().enumerate() {
                for (b, Form(other)) in forms[..=a].iter().enumerate() {
                    let each = rows.clone().map(|t| {
                        let own = own.slice(s![t, range.clone()]);
                        let from = moved(&range, shift);
                        dot(
                            own,
                            other.slice(s![(t as isize - shift) as usize, from]),
                            true,
                        )
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

    /// E d² of an error that this form is, for one block.
    pub fn mean_square(&self, Form(form): &Form) -> Complex64 {
        let (points, before) = (self.force.len() as isize, self.before as isize);
        let of_shift = |(shift, weight): (isize, f64)| -> Complex64 {
            // places t and t′ of one block; t − shift and t′ − shift change parts
            let rows = (shift - before).max(0)..points.min(points + shift);
            let columns = shift.max(-before)..points.min(points + shift);
            let each = rows.map(|t| {
                let own = form.slice(s![t, columns.start + before..columns.end + before]);
                let other = s![
                    columns.start - shift..columns.end - shift,
                    t - shift + before
                ];
                dot(own, form.slice(other), false)
            });
            weight * each.sum::<Complex64>()
        };
        self.errors.shifts().map(of_shift).sum()
    }
}

/// Places of `count` that are also places after a shift.
fn overlap(count: usize, shift: isize) -> Range<usize> {
    let end = count.saturating_add_signed(shift).min(count);
    (shift.max(0) as usize).min(end)..end
}

/// The range before a shift.
fn moved(range: &Range<usize>, shift: isize) -> Range<usize> {
    let from = |place: usize| (place as isize - shift) as usize;
    from(range.start)..from(range.end)
}

/// Σ a·b, or Σ a·b*.
fn dot(a: ArrayView1<Complex64>, b: ArrayView1<Complex64>, conjugate: bool) -> Complex64 {
    let products = a.iter().zip(&b);
    match conjugate {
        true => products.map(|(a, b)| a * b.conj()).sum(),
        false => products.map(|(a, b)| a * b).sum(),
    }
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
