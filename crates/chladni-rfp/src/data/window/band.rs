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
//! The second is not zero, because the errors of real and imaginary part differ. A force that drops at a
//! resonance follows a white one e; the forms are then those of e. Force and poles are taken in a band
//! about one frequency, on [`limits::RECORD_POINTS`] places of a record.

use crate::data::limits;
use crate::data::window::block_errors::BlockErrors;
use crate::data::window::kernel::Force;
use chladni_linalg::matmul;
use ndarray::{s, Array1, Array2, ArrayView1};
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::ops::Range;

/// A force that drops at one resonance, made of one of even spectrum e (theory.md, after eq. F4d):
/// f_t = p·f_{t−1} + gain·(e_t − q·e_{t−1}).
#[derive(Debug, Clone, Copy)]
pub(crate) struct DroppingForce {
    p: Complex64,
    q: Complex64,
    gain: f64,
    /// Power of the noise with which it is read, over that of the force beside resonances.
    noise: f64,
}

impl DroppingForce {
    /// Weights of e that sum up to what these weights of f do, on all lines.
    fn in_even_force(&self, mut weights: Array2<Complex64>) -> Array2<Complex64> {
        let mut later = Array1::<Complex64>::zeros(weights.ncols());
        for mut row in weights.rows_mut().into_iter().rev() {
            for (weight, later) in row.iter_mut().zip(&mut later) {
                let own = *weight;
                *weight = self.gain * (own + (self.p - self.q) * *later);
                *later = own + self.p * *later;
            }
        }
        weights
    }
}

impl BlockErrors {
    /// The `force` that drops at the resonance of s.
    ///
    /// * `offset`: s less the middle of the band, over ω_max
    pub fn dropping(&self, force: Force, offset: Complex64) -> DroppingForce {
        let step = self.record / limits::RECORD_POINTS as f64;
        let [p, q] = [force.drop, 1.0]
            .map(|drop| (Complex64::new(drop * offset.re, offset.im) * step).exp());
        DroppingForce {
            p,
            q,
            gain: (1.0 - p.norm()) / (1.0 - q.norm()) / force.drop,
            noise: force.noise,
        }
    }

    /// A band of lines; `None` without a force that leaks.
    ///
    /// * `cycles`: per record, from the middle of the band to each line
    /// * `decay`: −Re s over ω_max of the slowest pole
    /// * `drop`: the force, where it is not even
    pub fn band(
        &self,
        cycles: Vec<f64>,
        decay: f64,
        drop: Option<DroppingForce>,
    ) -> Option<Band<'_>> {
        let force = self.force.as_ref()?;
        let points = limits::RECORD_POINTS;
        let memory = limits::MEMORY_NEPERS / (decay * self.record).max(limits::DECAY_LEAST_NEPERS);
        let remembered = match self.rest {
            true => 0,
            false => (memory.min(limits::MEMORY_RECORDS) * points as f64).ceil() as usize,
        };
        let followed = match drop {
            Some(drop) => (-limits::MEMORY_NEPERS / drop.p.norm().ln()).ceil() as usize,
            None => 0,
        };
        let before = followed.min(remembered);
        let turns = Array2::from_shape_fn((points, cycles.len()), |(t, k)| {
            Complex64::from_polar(1.0, TAU * cycles[k] * t as f64 / points as f64)
        });
        let mut spectra = Array2::zeros((before + points, cycles.len()));
        for ((t, k), turn) in turns.indexed_iter() {
            spectra[[before + t, k]] = force[t] * turn.conj();
        }
        let mut noise = 0.0;
        if let Some(drop) = drop {
            noise = drop.noise * force.iter().map(|w| w * w).sum::<f64>();
            spectra = drop.in_even_force(spectra);
        }
        let power = |column: ArrayView1<Complex64>| -> f64 {
            column.iter().map(|x| x.norm_sqr()).sum::<f64>() + noise
        };
        Some(Band {
            errors: self,
            powers: spectra.columns().into_iter().map(power).collect(),
            spectra,
            turns,
            drop,
            before,
            remembered,
        })
    }
}

/// Lines in a band about one frequency.
pub(crate) struct Band<'a> {
    errors: &'a BlockErrors,
    /// e^{jω_k t}, (place, line).
    turns: Array2<Complex64>,
    /// Part of the even force at each place in the spectrum of a record, (place, line). Places
    /// before the record come first.
    spectra: Array2<Complex64>,
    /// Mean square of the spectrum on each line.
    powers: Vec<f64>,
    /// The force, where it is not even.
    drop: Option<DroppingForce>,
    /// Number of places before a record from which the force depends on the even one.
    before: usize,
    /// The same for the response.
    remembered: usize,
}

/// Unexplained response on each line to the even force at each place: (place, line). Places before
/// the record come first.
pub(crate) struct Leak(Array2<Complex64>);

/// A quadratic form K of the even force: (place of f*, place of f).
pub(crate) struct Form(Array2<Complex64>);

impl Band<'_> {
    /// The leak of 1/(jω − s).
    ///
    /// * `offset`: s less the middle of the band, over ω_max
    pub fn leak(&self, offset: Complex64) -> Leak {
        let points = limits::RECORD_POINTS;
        let unit = self.errors.record / points as f64;
        let step = (offset * unit).exp();
        let mut all = Array2::zeros((self.remembered + points, self.powers.len()));
        for (k, mut line) in all.columns_mut().into_iter().enumerate() {
            // response to a force at this place, over the rest of the record
            let mut later = Complex64::default();
            for place in (0..points).rev() {
                let here = self.errors.response[place] * self.turns[[place, k]].conj();
                later = here + step * later;
                if place < self.errors.driven {
                    line[self.remembered + place] = unit * (later - 0.5 * here);
                }
            }
            for place in (0..self.remembered).rev() {
                later *= step;
                line[place] = unit * later;
            }
        }
        if let Some(drop) = &self.drop {
            all = drop.in_even_force(all);
        }
        let mut with_force = all.slice_mut(s![self.remembered - self.before.., ..]);
        for (k, spectrum) in self.spectra.columns().into_iter().enumerate() {
            let mut line = with_force.column_mut(k);
            let mean = dot_conjugate(line.view(), spectrum) / self.powers[k];
            line.zip_mut_with(&spectrum, |leak, x| *leak -= mean * x);
        }
        Leak(all)
    }

    /// The form of the error Σ_k Σ weight(k)·leak(k), summed over `parts` (weights of lines, leak).
    pub fn form<'b>(&self, parts: impl Iterator<Item = (Vec<Complex64>, &'b Leak)>) -> Form {
        let mut weighted_leaks: Array2<Complex64> =
            Array2::zeros((self.powers.len(), self.remembered + limits::RECORD_POINTS));
        for (weights, Leak(leak)) in parts {
            for ((mut row, weight), column) in
                (weighted_leaks.rows_mut().into_iter().zip(weights)).zip(leak.columns())
            {
                row.zip_mut_with(&column, |sum, value| *sum += weight * value);
            }
        }
        for (mut row, power) in weighted_leaks.rows_mut().into_iter().zip(&self.powers) {
            row.mapv_inplace(|v| v / power);
        }
        let conjugate = self.spectra.mapv(|x| x.conj());
        let form = matmul(conjugate.view(), weighted_leaks.view());
        // rows contiguous in memory, whatever the layout of the product
        Form(form.as_standard_layout().to_owned())
    }

    /// E δ_a·δ_b* of the errors with these forms, per block.
    pub fn covariance(&self, forms: &[Form]) -> Array2<Complex64> {
        let [rows, columns] = [self.before, self.remembered].map(|n| n + limits::RECORD_POINTS);
        let mut all = Array2::<Complex64>::zeros((forms.len(), forms.len()));
        for (shift, weight) in self.errors.shifts() {
            let (rows, range) = (overlap(rows, shift), overlap(columns, shift));
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
        let points = limits::RECORD_POINTS as isize;
        let [before, remembered] = [self.before, self.remembered].map(|n| n as isize);
        let of_shift = |(shift, weight): (isize, f64)| -> Complex64 {
            // K(t, t′)·K(t′ − shift, t − shift): the places change roles
            let end = points.min(points + shift);
            let rows = (shift - remembered).max(-before)..end;
            let columns = (shift - before).max(-remembered)..end;
            let each = rows.map(|t| {
                let from_first = columns.start + remembered..columns.end + remembered;
                let row = form.slice(s![t + before, from_first]);
                let transposed = s![
                    columns.start - shift + before..columns.end - shift + before,
                    t - shift + remembered
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

    /// E δ² and E|δ|² of the error of a pole, foretold and found in records of `blocks` blocks
    /// under a force that drops by `drop`.
    fn moments(
        errors: &BlockErrors,
        blocks: usize,
        drop: Option<f64>,
    ) -> [(Complex64, Complex64); 2] {
        // one and a half lines per half-power bandwidth, between two lines
        let offset = Complex64::new(-1.5 * std::f64::consts::PI, 0.3 * TAU) / RECORD;
        let cycles: Vec<f64> = (-4..=4).map(f64::from).collect();
        // as in the sum that is a pole's error
        let weight = |cycles: &f64| {
            let place = Complex64::new(0.0, TAU * cycles) - offset * RECORD;
            place.powi(-2).conj()
        };
        let weights: Vec<Complex64> = cycles.iter().map(weight).collect();
        let force = drop.map(|drop| errors.dropping(Force { drop, noise: 0.0 }, offset));
        let band = errors.band(cycles.clone(), -offset.re, force).unwrap();
        let leak = band.leak(offset);
        let form = band.form(std::iter::once((weights.clone(), &leak)));
        let foretold = [band.mean_square(&form), band.covariance(&[form])[[0, 0]]];

        let mut random = ChaCha8Rng::seed_from_u64(3);
        let spectra: Vec<Vec<[Complex64; 2]>> = (0..DRAWS)
            .map(|_| simulated(errors, blocks, offset, force, &cycles, &mut random))
            .collect();
        // both sums over all tests, of each line
        let sum = |k: usize, of: fn(&[Complex64; 2]) -> Complex64| -> Complex64 {
            let each = spectra.iter().flatten().skip(k).step_by(cycles.len());
            each.map(of).sum()
        };
        let power: Vec<Complex64> = (0..cycles.len())
            .map(|k| sum(k, |[x, _]| x * x.conj()))
            .collect();
        let column: Vec<Complex64> = (0..cycles.len())
            .map(|k| sum(k, |[x, y]| x.conj() * y) / power[k])
            .collect();
        let mut found = [Complex64::default(); 2];
        for spectra in &spectra {
            let of = |(n, [x, y]): (usize, &[Complex64; 2])| {
                let k = n % cycles.len();
                weights[k] * x.conj() * (y - column[k] * x) / power[k]
            };
            let error = DRAWS as f64 * spectra.iter().enumerate().map(of).sum::<Complex64>();
            found[0] += error * error / DRAWS as f64;
            found[1] += error.norm_sqr() / DRAWS as f64;
        }
        [0, 1].map(|k| (foretold[k] / blocks as f64, found[k]))
    }

    const DRAWS: usize = 1500;

    /// Windowed spectra of force and response: the lines of each block.
    fn simulated(
        errors: &BlockErrors,
        blocks: usize,
        offset: Complex64,
        drop: Option<DroppingForce>,
        cycles: &[f64],
        random: &mut ChaCha8Rng,
    ) -> Vec<[Complex64; 2]> {
        let points = limits::RECORD_POINTS;
        let unit = RECORD / points as f64;
        let step = (offset * unit).exp();
        // records at rest have a force at the first places alone
        let settled = if errors.rest { 0 } else { 4 * points };
        let samples = settled + (blocks - 1) * errors.hop + points;
        let mut normal = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
        let mut even = Complex64::ZERO;
        let [mut force, mut state] = [Complex64::ZERO; 2];
        let next = |t: usize| -> [Complex64; 2] {
            let before = match errors.rest && t.is_multiple_of(points) {
                true => Complex64::ZERO,
                false => step * state,
            };
            let last = even;
            even = match t % points < errors.driven || !errors.rest {
                true => Complex64::new(normal(), normal()) / 2f64.sqrt(),
                false => Complex64::ZERO,
            };
            force = match drop {
                Some(DroppingForce { p, q, gain, .. }) => p * force + gain * (even - q * last),
                None => even,
            };
            state = before + force;
            [force, unit * (before + 0.5 * force)]
        };
        let all: Vec<[Complex64; 2]> = (0..samples).map(next).collect();
        let windows = [errors.force.as_ref().unwrap(), &errors.response];
        let line = |block: usize, cycles: f64| {
            let record = &all[settled + block * errors.hop..][..points];
            let turn =
                |t: usize| Complex64::from_polar(1.0, -TAU * cycles * t as f64 / points as f64);
            [0, 1].map(|channel| -> Complex64 {
                let each = record.iter().zip(windows[channel]).enumerate();
                each.map(|(t, (values, w))| values[channel] * turn(t) * *w)
                    .sum()
            })
        };
        (0..blocks)
            .flat_map(|block| cycles.iter().map(move |cycles| (block, *cycles)))
            .map(|(block, cycles)| line(block, cycles))
            .collect()
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
            (Window::Hann, overlapped, 12, None),
            (Window::Hann, overlapped, 12, Some(4.0)),
            (Window::Burst { part: 0.75 }, bursts, 4, None),
            (bursts_in_hann, bursts, 4, None),
        ];
        for (window, made, blocks, drop) in cases {
            let errors = BlockErrors::new(Some(window), Some(&made), 0.0, RECORD).unwrap();
            let all = moments(&errors, blocks, drop);
            let [twice, whole] = all;
            assert!(
                twice.0.norm() > 0.2 * whole.0.re,
                "{window}, {drop:?}: {all:?}"
            );
            for (foretold, found) in all {
                let off = (found - foretold).norm();
                assert!(
                    off < 0.1 * foretold.norm(),
                    "{window}, {drop:?}: {found} for {foretold}"
                );
            }
        }
    }
}
