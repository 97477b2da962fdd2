//! Forward model of a measured FRF: the column of a pole in the mean of H1.
//!
//! H1 of records of length T under a white force is, in the mean, the transform of h(τ)ρ(τ),
//!
//! ρ(τ) = Σ_t w_x(t)·w_y(t+τ)/Σ_t w_x(t)²
//!
//! with the factors w_x of the force and w_y of the response (gate and window). A pole s
//! then has the column T·g(z) in place of 1/(jω − s) = T/z, with z = (jω − s)T and
//!
//! g(z) = ∫₀¹ ρ(uT)·e^{−zu} du
//!
//! so that the fit's column is multiplied by z·g(z): 1 where nothing leaks, and analytic
//! in z. All are sums of the integrals of [`Ramps`] (theory.md, eq. F4).

use crate::data::limits;
use crate::data::window::lanes::Lanes;
use crate::data::window::ramps::Ramps;
use num_complex::Complex64;
use std::f64::consts::{PI, TAU};

/// Correlation ρ of the factors of force and response.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum WindowKernel {
    /// Blows, periodic signals: ρ = 1. The response is cut at the end of the record.
    Transient,
    /// Noise over the first part of the record under a sum of cosines, the response to its end.
    Burst {
        /// Part of the record with noise, above 0 to 1.
        part: f64,
        /// Terms of ρ.
        waves: Vec<Wave>,
    },
    /// Continuous noise under a sum of cosines, ρ = Σ_q [a_q·(1 − u)·cos 2πqu + b_q·sin 2πqu].
    Cosines {
        /// (a_q, b_q) for q = 0, 1, ...
        waves: Vec<[f64; 2]>,
    },
    /// Continuous noise, any window, by the cosine series of its autocorrelation, Σ_p a_p
    /// cos(πpu).
    Series {
        /// a_0, a_1, ..., of sum 1.
        harmonics: Vec<f64>,
    },
}

/// The term of ρ that turns as e^{2πjqu}: what it is multiplied by.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Wave {
    /// q.
    turns: f64,
    /// e^{2πjqa} of the two parts a of the record that [`WindowKernel::decays`] names.
    turned: [Complex64; 2],
    /// While the response lasts as long as the burst, u up to 1 − part.
    early: Complex64,
    /// Later, (1 − u) times the first plus the second.
    late: [Complex64; 2],
}

/// c_n of windows Σ_n c_n e^{2πjnu} with c_{−n} = c_n. Hann: 1/2 − 1/2 cos 2πu.
pub(crate) const HANN: [f64; 2] = [0.5, -0.25];
/// Of R. Blackman and J. Tukey (1958): 0.54 − 0.46 cos 2πu.
pub(crate) const HAMMING: [f64; 2] = [0.54, -0.23];
/// 0.42 − 0.5 cos 2πu + 0.08 cos 4πu.
pub(crate) const BLACKMAN: [f64; 3] = [0.42, -0.25, 0.04];
/// 1 − 1.933 cos 2πu + 1.286 cos 4πu − 0.388 cos 6πu + 0.028 cos 8πu, of ISO 18431-2.
pub(crate) const FLATTOP: [f64; 5] = [1.0, -0.9665, 0.643, -0.194, 0.014];

/// A force whose power near a resonance s goes as |jω − s|²/|jω − p|², p = d·Re s + j·Im s,
/// read with white noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Force {
    /// d; 1: an even force.
    pub drop: f64,
    /// Power of the noise over that of the force beside resonances.
    pub noise: f64,
}

impl Force {
    /// Its power over that beside resonances, g at the place of p.
    fn power(&self, decay: f64, g: Complex64) -> f64 {
        1.0 - (self.drop - 1.0 / self.drop) * decay * g.re
    }
}

impl WindowKernel {
    /// Continuous noise under Σ_n c_n e^{2πjnu} on force and response; a_q = c_q² over
    /// Σ c_n², twice for q > 0, and b_q = −(2/π)·c_q·Σ_{m≠−q} c_m/(q + m) over the same.
    pub(crate) fn cosines(coefficients: &[f64]) -> Self {
        let most = coefficients.len() as i32 - 1;
        let c = |n: i32| coefficients[n.unsigned_abs() as usize];
        let power: f64 = (-most..=most).map(|n| c(n) * c(n)).sum();
        let wave = |q: i32| {
            let others = (-most..=most).filter(|m| q > 0 && m + q != 0);
            let across: f64 = others.map(|m| c(m) / f64::from(q + m)).sum();
            let sides = if q == 0 { 1.0 } else { 2.0 };
            [
                sides * c(q) * c(q) / power,
                -2.0 / PI * c(q) * across / power,
            ]
        };
        Self::Cosines {
            waves: (0..=most).map(wave).collect(),
        }
    }

    /// Noise over the first `part` of a record under Σ_n c_n e^{2πjnu} on force and response (the
    /// last ρ of theory.md, eq. F4, its integrals multiplied out).
    pub(crate) fn burst(part: f64, coefficients: &[f64]) -> Self {
        let most = coefficients.len() as i32 - 1;
        let c = |n: i32| coefficients[n.unsigned_abs() as usize];
        let whole = |k: i32| match k {
            0 => Complex64::from(part),
            _ => {
                let turn = TAU * f64::from(k);
                (Complex64::from_polar(1.0, turn * part) - 1.0) / Complex64::new(0.0, turn)
            }
        };
        let early =
            |q: i32| -> Complex64 { (-most..=most).map(|n| c(q) * c(n) * whole(n + q)).sum() };
        let power: f64 = (-most..=most).map(|q| early(q).re).sum();
        let wave = |q: i32| {
            let others = (-most..=most).filter(|n| n + q != 0);
            let across: f64 = others.map(|n| c(n) / f64::from(n + q)).sum();
            let late = [
                Complex64::from(c(q) * c(q)),
                Complex64::new(0.0, c(q) * across / PI),
            ];
            let turns = TAU * f64::from(q);
            Wave {
                turns,
                turned: [1.0 - part, part].map(|a| Complex64::from_polar(1.0, turns * a)),
                early: early(q) / power,
                late: late.map(|v| v / power),
            }
        };
        Self::Burst {
            part,
            waves: (-most..=most).map(wave).collect(),
        }
    }

    /// Continuous noise, a window by its values at the middles of equal parts of the
    /// record: a_0 ∝ |W(0)|², a_p ∝ 2|W(p/2)|² with its transform W at p/2 periods per
    /// record.
    pub(crate) fn of_values(window: &[f64], harmonics: usize) -> Self {
        let power = |p: usize| {
            let turn = PI * p as f64 / window.len() as f64;
            let sum: Complex64 = window
                .iter()
                .enumerate()
                .map(|(k, w)| w * Complex64::from_polar(1.0, turn * (k as f64 + 0.5)))
                .sum();
            sum.norm_sqr() * if p == 0 { 1.0 } else { 2.0 }
        };
        let mut powers: Vec<f64> = (0..harmonics).map(power).collect();
        let sum: f64 = powers.iter().sum();
        powers.iter_mut().for_each(|power| *power /= sum);
        // harmonics that say nothing cost time in every column
        while powers.last().is_some_and(|&last| last < limits::CUT_SHARE) {
            powers.pop();
        }
        Self::Series { harmonics: powers }
    }

    /// The column over T of a pole s at whose resonance the `force` drops; an even one gives g(z)
    /// (theory.md, eq. F4f).
    ///
    /// * `z`: (jω − s)T
    /// * `decay`: −Re s·T
    pub(crate) fn under_force(&self, z: Complex64, decay: f64, force: &Force) -> Complex64 {
        let Force { drop, noise } = *force;
        let [g, _] = self.value_and_slope(z + (drop - 1.0) * decay);
        let power = force.power(decay, g);
        (1.0 + noise) * (g - (1.0 - 1.0 / drop) * g.re) / (power + noise)
    }

    /// Power of the `force` on a line over that beside resonances.
    pub(crate) fn power_of_force(&self, z: Complex64, decay: f64, force: &Force) -> f64 {
        let [g, _] = self.value_and_slope(z + (force.drop - 1.0) * decay);
        force.power(decay, g)
    }

    /// e^{−za} at the corners of ρ: a = 1 − part and a = part of a burst, otherwise a = 1 (and 0).
    /// The factors of a sum of z multiply.
    pub(crate) fn decays(&self, z: Complex64) -> [Complex64; 2] {
        match self {
            Self::Burst { part, .. } => [1.0 - part, *part].map(|a| (-z * a).exp()),
            _ => [(-z).exp(), Complex64::ONE],
        }
    }

    /// g(z) and its derivative.
    pub(crate) fn value_and_slope(&self, z: Complex64) -> [Complex64; 2] {
        let both: [Lanes<1>; 2] = self.by_decays(z.into(), self.decays(z).map(Lanes::from));
        both.map(|lanes| lanes.get(0))
    }

    /// The same for some z with their [`Self::decays`].
    #[inline(always)]
    pub(crate) fn by_decays<const L: usize>(
        &self,
        z: Lanes<L>,
        decays: [Lanes<L>; 2],
    ) -> [Lanes<L>; 2] {
        let [left, _] = decays;
        let turn = |turns: f64| Lanes::from(Complex64::new(0.0, turns));
        let mut value = Lanes::ZERO;
        let mut slope = Lanes::ZERO;
        match self {
            Self::Transient => {
                let ramps = Ramps::new(z, left);
                (value, slope) = (ramps.e, ramps.e_slope());
            }
            Self::Burst { part, waves } => {
                let full = 1.0 - part;
                for wave in waves {
                    let z = z - turn(wave.turns);
                    let [before, during] = [0, 1].map(|a| decays[a] * wave.turned[a]);
                    let flat = Ramps::new(z * full, before);
                    let left = Ramps::new(z * *part, during);
                    let [falling, level] = wave.late;
                    let late = left.f * (falling * part) + left.e * level;
                    let moved = left.f_slope * (falling * part) + left.e_slope() * level;
                    let over = before * *part;
                    value = value + flat.e * (wave.early * full) + over * late;
                    slope = slope
                        + flat.e_slope() * (wave.early * full * full)
                        + over * (moved * *part - late * full);
                }
            }
            Self::Cosines { waves } => {
                for (q, &[a, b]) in waves.iter().enumerate() {
                    let turn = turn(TAU * q as f64);
                    let up = Ramps::new(z - turn, left);
                    if q == 0 {
                        (value, slope) = (up.f * a, up.f_slope * a);
                        continue;
                    }
                    let down = Ramps::new(z + turn, left);
                    let sine = Complex64::new(0.0, -0.5 * b);
                    value = value + (up.f + down.f) * (0.5 * a) + (up.e - down.e) * sine;
                    slope = slope
                        + (up.f_slope + down.f_slope) * (0.5 * a)
                        + (up.e_slope() - down.e_slope()) * sine;
                }
            }
            Self::Series { harmonics } => {
                for (p, a) in harmonics.iter().enumerate() {
                    let turn = turn(PI * p as f64);
                    let left = if p % 2 == 0 { left } else { left * -1.0 };
                    let (up, down) = (Ramps::new(z - turn, left), Ramps::new(z + turn, left));
                    value = value + (up.e + down.e) * (0.5 * a);
                    slope = slope + (up.e_slope() + down.e_slope()) * (0.5 * a);
                }
            }
        }
        [value, slope]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::window::kinds::Window;

    /// Points of Simpson's rule.
    const POINTS: usize = 1200;

    /// ∫₀¹ of a smooth function.
    fn integral<T>(of: impl Fn(f64) -> T) -> T
    where
        T: std::iter::Sum<T> + std::ops::Mul<f64, Output = T>,
    {
        let weight = |k: usize| match k {
            0 | POINTS => 1.0,
            k if k % 2 == 1 => 4.0,
            _ => 2.0,
        };
        (0..=POINTS)
            .map(|k| of(k as f64 / POINTS as f64) * (weight(k) / (3 * POINTS) as f64))
            .sum()
    }

    /// ∫ w(t)·w(t + u) dt of a window on force and response.
    fn overlap(window: impl Fn(f64) -> f64, u: f64) -> f64 {
        (1.0 - u) * integral(|t| window(t * (1.0 - u)) * window(t * (1.0 - u) + u))
    }

    /// Near a mode, between lines, far away; weakly and strongly damped.
    fn places() -> impl Iterator<Item = Complex64> {
        let re = [0.0, 1e-9, 0.1, 1.0, 3.0, 12.0];
        let im = [0.0, 1e-6, 0.4, 1.0, PI, TAU, 2.0 * TAU, 20.0, -7.5];
        re.into_iter()
            .flat_map(move |re| im.map(|im| Complex64::new(re, im)))
    }

    fn value(kernel: &WindowKernel, z: Complex64) -> Complex64 {
        kernel.value_and_slope(z)[0]
    }

    fn check(name: &str, kernel: &WindowKernel, rho: impl Fn(f64) -> f64) {
        let rho: Vec<f64> = (0..=POINTS)
            .map(|k| rho(k as f64 / POINTS as f64))
            .collect();
        let at = |u: f64| rho[(u * POINTS as f64).round() as usize];
        for z in places() {
            let [value, slope] = kernel.value_and_slope(z);
            let expected = integral(|u| (-z * u).exp() * at(u));
            let error = (value - expected).norm();
            assert!(error < 1e-7, "{name}, z = {z}: {error:e}");
            let error = (slope - integral(|u| -u * (-z * u).exp() * at(u))).norm();
            assert!(error < 1e-7, "{name}, slope, z = {z}: {error:e}");
        }
    }

    /// Values at the points of the rule.
    fn places_of<T>(of: impl Fn(f64) -> T) -> Vec<T> {
        (0..=POINTS).map(|k| of(k as f64 / POINTS as f64)).collect()
    }

    fn cosines(coefficients: &[f64], u: f64) -> f64 {
        let term = |(n, c): (usize, &f64)| {
            let twice = if n == 0 { 1.0 } else { 2.0 };
            twice * c * (TAU * n as f64 * u).cos()
        };
        coefficients.iter().enumerate().map(term).sum()
    }

    #[test]
    fn every_cosine_window_is_the_integral_of_its_autocorrelation() {
        for (name, coefficients) in [
            ("rectangular", &[1.0][..]),
            ("hann", &HANN[..]),
            ("hamming", &HAMMING[..]),
            ("blackman", &BLACKMAN[..]),
            ("flattop", &FLATTOP[..]),
        ] {
            let window = |t| cosines(coefficients, t);
            let power = overlap(window, 0.0);
            check(name, &WindowKernel::cosines(coefficients), |u| {
                overlap(window, u) / power
            });
        }
    }

    #[test]
    fn blows_and_bursts_are_their_integrals() {
        check("transient", &WindowKernel::Transient, |_| 1.0);
        // corners on points of the rule, and a burst as long as the record
        for part in [0.05, 0.25, 0.5, 0.9, 1.0] {
            for (name, coefficients) in [("plain", &[1.0][..]), ("hann", &HANN), ("flat", &FLATTOP)]
            {
                let kernel = WindowKernel::burst(part, coefficients);
                let window = |t| cosines(coefficients, t);
                let until = |end: f64, lag: f64| {
                    integral(|t| window(t * end) * window(t * end + lag)) * end
                };
                let power = until(part, 0.0);
                let full = 1.0 - part;
                // either side of the corner by itself
                let early = places_of(|u| (u * full, until(part, u * full) / power * full));
                let late = places_of(|u| {
                    let lag = full + part * u;
                    (lag, until(1.0 - lag, lag) / power * part)
                });
                for z in places() {
                    let both = |weight: &dyn Fn(f64) -> f64| -> Complex64 {
                        let at = |of: &[(f64, f64)], u: f64| {
                            let (lag, rho) = of[(u * POINTS as f64).round() as usize];
                            (-z * lag).exp() * rho * weight(lag)
                        };
                        integral(|u| at(&early, u)) + integral(|u| at(&late, u))
                    };
                    let [value, slope] = kernel.value_and_slope(z);
                    let error = (value - both(&|_| 1.0)).norm();
                    assert!(error < 1e-7, "{name}, burst {part}, z = {z}: {error:e}");
                    let error = (slope - both(&|u| -u)).norm();
                    assert!(
                        error < 1e-7,
                        "{name}, burst {part}, slope, z = {z}: {error:e}"
                    );
                }
            }
        }
    }

    #[test]
    fn windows_by_their_values_are_the_closed_forms() {
        let values = |coefficients: &[f64]| -> Vec<f64> {
            (0..POINTS)
                .map(|k| cosines(coefficients, (k as f64 + 0.5) / POINTS as f64))
                .collect()
        };
        for coefficients in [&HANN[..], &BLACKMAN[..]] {
            let kernel = WindowKernel::cosines(coefficients);
            let series = WindowKernel::of_values(&values(coefficients), 200);
            for z in places() {
                let error = (value(&series, z) - value(&kernel, z)).norm();
                assert!(error < 1e-7, "{coefficients:?}, z = {z}: {error:e}");
            }
        }
    }

    #[test]
    fn a_column_far_from_its_pole_is_the_plain_one() {
        let far = Complex64::new(400.0, 3000.0);
        for kernel in [
            WindowKernel::Transient,
            WindowKernel::burst(0.5, &[1.0]),
            WindowKernel::burst(0.5, &HANN),
            WindowKernel::cosines(&HANN),
            WindowKernel::cosines(&FLATTOP),
        ] {
            assert!(
                (far * value(&kernel, far) - 1.0).norm() < 2e-3,
                "{kernel:?}"
            );
        }
    }

    /// Power of the transform of a Hann window, `x` cycles per record from its middle, up to
    /// a factor.
    fn hann_power(x: f64) -> f64 {
        let turn = std::f64::consts::PI * x;
        let near = |value: f64| (x.abs() - value).abs() < 1e-9;
        let value = if near(0.0) {
            1.0
        } else if near(1.0) {
            0.5
        } else {
            turn.sin() / (turn * (1.0 - x * x))
        };
        value * value
    }

    /// Mean cross spectrum over mean power of the force, summed over frequencies.
    fn by_sum(line: Complex64, pole: Complex64, force: &Force, record_s: f64) -> Complex64 {
        let mut sums = (Complex64::ZERO, 0.0);
        for k in -2400..=2400 {
            let cycles = f64::from(k) / 60.0;
            let s = line + Complex64::new(0.0, TAU * cycles / record_s);
            let of_force = Complex64::new(force.drop * pole.re, pole.im);
            let window = hann_power(cycles);
            let power = window * (s - pole).norm_sqr() / (s - of_force).norm_sqr();
            sums.0 += power / (s - pole);
            sums.1 += power + force.noise * window;
        }
        (1.0 + force.noise) * sums.0 / sums.1
    }

    #[test]
    fn the_line_of_a_force_that_drops_is_the_mean_of_its_spectra() {
        let kernel = Window::Hann.kernel().unwrap();
        let record_s = 2.0;
        // two lines per half-power bandwidth
        let pole = Complex64::new(-TAU * 0.5, TAU * 60.1);
        let lines: Vec<Complex64> = (116..125)
            .map(|k| Complex64::new(0.0, TAU * 0.5 * f64::from(k)))
            .collect();
        for (drop, noise) in [(1.0, 0.0), (4.0, 0.0), (31.6, 0.0), (4.0, 0.01)] {
            let force = Force { drop, noise };
            for line in &lines {
                let z = (line - pole) * record_s;
                let value = kernel.under_force(z, -pole.re * record_s, &force);
                let expected = by_sum(*line, pole, &force, record_s);
                let off = (value * record_s - expected).norm();
                assert!(
                    off < 1e-6 * expected.norm(),
                    "{force:?}, {line}: {value} for {expected}"
                );
            }
        }
    }
}
