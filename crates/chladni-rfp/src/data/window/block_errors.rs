//! Errors of FRFs over neighbouring lines, as averaged blocks of records leave them
//! (theory.md, eq. F4d).
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
use crate::data::window::kinds::Window;
use chladni_frf::{Estimation, Forcing};
use chladni_linalg::matmul;
use ndarray::{s, Array2, ArrayView1};
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::ops::Range;

/// The processing of blocks, as far as errors depend on it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct BlockErrors {
    /// Factors on the force, at the middles of equal parts of a record; `None`: one blow.
    force: Option<Vec<f64>>,
    /// Factors on the response.
    response: Vec<f64>,
    /// From block to block, in parts of a record; as many as there are: nothing is shared.
    hop: usize,
    /// True where the structure is at rest before each block.
    rest: bool,
    /// Blocks averaged; `None`: not known.
    blocks: Option<f64>,
    /// Length of a record times ω_max.
    record: f64,
}

impl BlockErrors {
    /// Of records under `window`, and how they were `made`, where a set says so; `None`
    /// where errors of neighbouring lines are independent, or nothing is known.
    ///
    /// * `decay`: of an exponential window over a record, nepers
    /// * `record`: length of a record times ω_max
    pub fn new(
        window: Option<Window>,
        made: Option<&Estimation>,
        decay: f64,
        record: f64,
    ) -> Option<Self> {
        let points = limits::RECORD_POINTS;
        let place = |k: usize| (k as f64 + 0.5) / points as f64;
        let window = window.unwrap_or(Window::None);
        let blow = matches!(window, Window::None | Window::Transient);
        let (force, response) = match window {
            Window::None | Window::Transient => {
                let padded = window == Window::Transient
                    && made.is_some_and(|made| made.gate_s < limits::GATE_WHOLE * made.transform_s);
                let blow_alone = made.is_none_or(|made| {
                    !matches!(
                        made.forcing,
                        Some(Forcing::Continuous | Forcing::Burst { .. })
                    )
                });
                if !blow_alone || (decay == 0.0 && !padded) {
                    return None;
                }
                // over the first: whatever the decay, something is left of the record
                let factor = |k: usize| (-decay * (place(k) - place(0))).exp();
                (None, (0..points).map(factor).collect())
            }
            _ => {
                let values = window.values(points);
                let part = window.part().unwrap_or(1.0);
                let force = |(k, w): (usize, &f64)| if place(k) < part { *w } else { 0.0 };
                (Some(values.iter().enumerate().map(force).collect()), values)
            }
        };
        let continuous = made.map_or(!blow, |made| made.forcing == Some(Forcing::Continuous));
        let rest = blow || window.part().is_some();
        let hop = match made {
            Some(made) if continuous => made.hop_s / made.gate_s * points as f64,
            None if !rest => limits::HOP_ASSUMED * points as f64,
            _ => points as f64,
        };
        Some(Self {
            force,
            response,
            hop: (hop.round() as usize).clamp(1, points),
            rest,
            blocks: made
                .map(|made| made.averages[0] as f64)
                .filter(|blocks| *blocks >= 1.0),
            record,
        })
    }

    /// Of lines whose errors are independent, one cycle per record apart.
    pub fn independent(record: f64) -> Self {
        Self {
            force: None,
            response: vec![1.0; limits::RECORD_POINTS],
            hop: limits::RECORD_POINTS,
            rest: true,
            blocks: None,
            record,
        }
    }

    /// True where the force leaks, so that errors are largest beside modes.
    pub fn leaks(&self) -> bool {
        self.force.is_some()
    }

    /// True for records of blows.
    pub fn of_blows(&self) -> bool {
        self.force.is_none() && self.blocks.is_some()
    }

    /// Blocks averaged, where they are known.
    pub fn blocks(&self) -> Option<f64> {
        self.blocks
    }

    /// Cycles per record between two lines y = ω/ω_max.
    pub fn cycles(&self, distance: f64) -> f64 {
        distance * self.record / TAU
    }

    /// Shifts of blocks that share samples, in parts of a record, and their weights for
    /// one block.
    fn shifts(&self) -> impl Iterator<Item = (isize, f64)> + '_ {
        let most = (limits::RECORD_POINTS - 1) / self.hop;
        let most = match self.blocks {
            Some(blocks) => most.min(blocks as usize - 1),
            None => most,
        } as isize;
        let weight = |d: isize| 1.0 - self.blocks.map_or(0.0, |m| d.unsigned_abs() as f64 / m);
        (-most..=most).map(move |d| (d * self.hop as isize, weight(d)))
    }

    /// The noise of the responses that two blocks, `shift` parts of a record apart, share on
    /// lines `cycles` apart.
    fn shared(&self, shift: isize, cycles: f64) -> Complex64 {
        let at = |factors: &[f64]| -> Complex64 {
            let points = factors.len() as isize;
            let term = |t: isize| {
                let both = factors[t as usize] * factors[(t - shift) as usize];
                let turn = -TAU * cycles * (t as f64 + 0.5) / points as f64;
                Complex64::from_polar(both, turn)
            };
            (shift.max(0)..points.min(points + shift)).map(term).sum()
        };
        let of_force = self.force.as_deref().map(|force| at(force).conj());
        of_force.unwrap_or(Complex64::ONE) * at(&self.response)
    }

    /// The same over all blocks, for one.
    fn over_blocks(&self, cycles: f64) -> Complex64 {
        let of_shift = |(shift, weight)| weight * self.shared(shift, cycles);
        self.shifts().map(of_shift).sum()
    }

    /// Correlation of the errors that noise of the responses leaves on two lines, `cycles`
    /// apart; that of overlapping blocks included.
    pub fn of_noise(&self, cycles: f64) -> Complex64 {
        self.over_blocks(cycles) / self.over_blocks(0.0).re
    }

    /// Variance of noise of one block left by the mean over all that overlap; `None` where nobody
    /// knows how many there are.
    pub fn averaged(&self) -> Option<f64> {
        let blocks = self.blocks?;
        Some(self.over_blocks(0.0).re / (self.shared(0, 0.0).re * blocks))
    }

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
                let left = later - 0.5 * here - mean * self.force[place] * back;
                all[[self.before + place, k]] = unit * left;
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
    use chladni_frf::{BlockWindow, Estimator};
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// T·ω_max: lines 1/500 of ω_max apart.
    const RECORD: f64 = 500.0 * TAU;

    fn made(blocks: usize, hop: f64) -> Estimation {
        Estimation {
            estimator: Estimator::H1,
            window: BlockWindow::Hann,
            forcing: Some(Forcing::Continuous),
            transform_s: 1.0,
            gate_s: 1.0,
            hop_s: hop,
            averages: [blocks; 2],
            lines_per_value: 1,
        }
    }

    #[test]
    fn noise_of_half_overlapped_hann_blocks_is_correlated_as_the_study_says() {
        let errors =
            BlockErrors::new(Some(Window::Hann), Some(&made(1000, 0.5)), 0.0, RECORD).unwrap();
        for (lag, expected) in [(0.0, 1.0), (1.0, 0.458), (2.0, 0.039), (3.0, 0.001)] {
            let found = errors.of_noise(lag);
            assert!((found - expected).norm() < 2e-3, "{lag}: {found}");
        }
        // 1000 blocks of which neighbours share 1/6
        let averaged = errors.averaged().unwrap();
        assert!(
            (averaged * 1000.0 - 1.0 - 2.0 * 0.999 / 36.0).abs() < 1e-6,
            "{averaged}"
        );
        let alone =
            BlockErrors::new(Some(Window::Hann), Some(&made(10, 1.0)), 0.0, RECORD).unwrap();
        assert!((alone.of_noise(1.0) - 4.0 / 9.0).norm() < 1e-3);
        assert!(BlockErrors::new(None, None, 0.0, RECORD).is_none());
        assert!(BlockErrors::new(Some(Window::Transient), None, 0.0, RECORD).is_none());
        // noise of bursts under an exponential window has the force's correlation, too
        let bursts = Estimation {
            forcing: Some(Forcing::Burst { part: 0.5 }),
            ..made(10, 1.0)
        };
        assert!(BlockErrors::new(None, Some(&bursts), 3.0, RECORD).is_none());
        let blows = BlockErrors::new(None, None, 3.0, RECORD).unwrap();
        let expected = 3.0 / Complex64::new(3.0, std::f64::consts::PI);
        assert!((blows.of_noise(1.0) - expected).norm() < 1e-2);
    }

    #[test]
    fn moments_are_those_of_simulated_records() {
        const BLOCKS: usize = 12;
        const DRAWS: usize = 1500;
        let errors = BlockErrors::new(
            Some(Window::Hann),
            Some(&made(BLOCKS, 1.0 / 3.0)),
            0.0,
            RECORD,
        )
        .unwrap();
        let points = limits::RECORD_POINTS;
        let (hop, window) = (errors.hop, Window::Hann.values(points));
        let power: f64 = window.iter().map(|w| w * w).sum();
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
        let foretold = foretold.map(|sum| sum / BLOCKS as f64);

        let (step, unit) = (
            (offset * RECORD / points as f64).exp(),
            RECORD / points as f64,
        );
        let mean = |cycles: f64| -> Complex64 {
            let lag = |lag: usize| {
                let rho: f64 = (lag..points).map(|t| window[t] * window[t - lag]).sum();
                let half = if lag == 0 { 0.5 } else { 1.0 };
                let turn = -TAU * cycles * lag as f64 / points as f64;
                half * unit * rho / power * step.powi(lag as i32) * Complex64::from_polar(1.0, turn)
            };
            (0..points).map(lag).sum()
        };
        let means: Vec<Complex64> = cycles.iter().map(|c| mean(*c)).collect();
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let mut found = [Complex64::default(); 2];
        for _ in 0..DRAWS {
            let mut normal = || (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
            let samples = (BLOCKS - 1) * hop + 5 * points;
            let force: Vec<Complex64> = (0..samples)
                .map(|_| Complex64::new(normal(), normal()) / 2f64.sqrt())
                .collect();
            let mut state = Complex64::default();
            let response: Vec<Complex64> = force
                .iter()
                .map(|f| {
                    let before = step * state;
                    state = before + f;
                    unit * (before + 0.5 * f)
                })
                .collect();
            let mut error = Complex64::default();
            for block in 0..BLOCKS {
                let first = 4 * points + block * hop;
                for ((cycles, mean), weight) in cycles.iter().zip(&means).zip(&weights) {
                    let of = |samples: &[Complex64]| -> Complex64 {
                        let turn = -TAU * cycles / points as f64;
                        let each = samples[first..].iter().zip(&window).enumerate();
                        each.map(|(t, (v, w))| v * Complex64::from_polar(*w, turn * t as f64))
                            .sum()
                    };
                    let (x, y) = (of(&force), of(&response));
                    error += weight * x.conj() * (y - mean * x) / (power * BLOCKS as f64);
                }
            }
            found[0] += error * error / DRAWS as f64;
            found[1] += error.norm_sqr() / DRAWS as f64;
        }
        assert!(foretold[0].norm() > 0.2 * foretold[1].re, "{foretold:?}");
        for (found, foretold) in found.iter().zip(foretold) {
            let off = (found - foretold).norm();
            assert!(off < 0.1 * foretold.norm(), "{found} for {foretold}");
        }
    }
}
