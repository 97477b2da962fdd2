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
//! in z. All are sums of
//!
//! e(z) = ∫₀¹ e^{−zu} du = (1 − e^{−z})/z,  f(z) = ∫₀¹ (1 − u)·e^{−zu} du = (1 − e(z))/z

use num_complex::Complex64;
use std::f64::consts::{PI, TAU};

/// Below this |z| quotients lose digits and series are used.
const SERIES_BELOW: f64 = 1.0;
/// Terms of a series: the last is below 1/22! of the sum.
const SERIES_TERMS: u32 = 20;
/// Harmonics at the end of a series with less than this share of it are left out.
const CUT_SHARE: f64 = 1e-12;

/// How force and response were cut and windowed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum WindowKernel {
    /// Blows that die out, periodic signals, stepped sines: ρ = 1. The response is cut at
    /// the end of the record.
    Transient,
    /// Noise over the first part of the record, the response to its end: ρ = 1, then
    /// falling to 0 over the last `part`.
    Burst {
        /// Part of the record with noise, above 0 to 1.
        part: f64,
    },
    /// Continuous noise, Σ_n c_n e^{2πjnu} on force and response.
    Cosines {
        /// c_0, c_1, ... with c_{−n} = c_n: Hann has 1/2, −1/4.
        coefficients: Vec<f64>,
    },
    /// Continuous noise, any window, by the cosine series of its autocorrelation, Σ_p a_p
    /// cos(πpu).
    Series {
        /// a_0, a_1, ..., of sum 1.
        harmonics: Vec<f64>,
    },
}

/// 1/2, −1/4.
const HANN: [f64; 2] = [0.5, -0.25];
/// Of R. Blackman and J. Tukey (1958): 0.54 − 0.46 cos 2πu.
const HAMMING: [f64; 2] = [0.54, -0.23];
/// 0.42 − 0.5 cos 2πu + 0.08 cos 4πu.
const BLACKMAN: [f64; 3] = [0.42, -0.25, 0.04];
/// 1 − 1.933 cos 2πu + 1.286 cos 4πu − 0.388 cos 6πu + 0.028 cos 8πu, of ISO 18431-2.
const FLATTOP: [f64; 5] = [1.0, -0.9665, 0.643, -0.194, 0.014];

impl WindowKernel {
    /// Continuous noise without a window.
    pub(crate) fn rectangular() -> Self {
        Self::cosines(&[1.0])
    }
    /// Continuous noise, sin²(πu).
    pub(crate) fn hann() -> Self {
        Self::cosines(&HANN)
    }
    /// Continuous noise, Hamming's window.
    pub(crate) fn hamming() -> Self {
        Self::cosines(&HAMMING)
    }
    /// Continuous noise, Blackman's window.
    pub(crate) fn blackman() -> Self {
        Self::cosines(&BLACKMAN)
    }
    /// Continuous noise, flat top.
    pub(crate) fn flattop() -> Self {
        Self::cosines(&FLATTOP)
    }

    fn cosines(coefficients: &[f64]) -> Self {
        Self::Cosines {
            coefficients: coefficients.to_vec(),
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
        // harmonics that say nothing cost two exponentials each
        while powers.last().is_some_and(|&last| last < CUT_SHARE) {
            powers.pop();
        }
        Self::Series { harmonics: powers }
    }

    /// g(z).
    pub(crate) fn value(&self, z: Complex64) -> Complex64 {
        match self {
            Self::Transient => ramp_0(z),
            Self::Burst { part } => {
                let full = 1.0 - part;
                full * ramp_0(z * full) + part * (-z * full).exp() * ramp_1(z * part)
            }
            Self::Cosines { coefficients } => cosine_sum(coefficients, z),
            Self::Series { harmonics } => {
                let term = |(p, a): (usize, &f64)| {
                    let turn = Complex64::new(0.0, PI * p as f64);
                    0.5 * a * (ramp_0(z - turn) + ramp_0(z + turn))
                };
                harmonics.iter().enumerate().map(term).sum()
            }
        }
    }

    /// z·g(z) of records that hold samples in the first `gate` of T, the rest zeros: the
    /// factor of a fit's column.
    pub(crate) fn factor(&self, z: Complex64, gate: f64) -> Complex64 {
        z * gate * self.value(z * gate)
    }
}

/// e(z).
fn ramp_0(z: Complex64) -> Complex64 {
    if z.norm() < SERIES_BELOW {
        return series(z, 1);
    }
    (1.0 - (-z).exp()) / z
}

/// f(z).
fn ramp_1(z: Complex64) -> Complex64 {
    if z.norm() < SERIES_BELOW {
        return series(z, 2);
    }
    (1.0 - ramp_0(z)) / z
}

/// Σ_k (−z)^k/(k + first)!, by Horner.
fn series(z: Complex64, first: u32) -> Complex64 {
    let inner = (1..=SERIES_TERMS)
        .rev()
        .fold(Complex64::from(1.0), |sum, k| {
            1.0 - z * sum / f64::from(k + first)
        });
    inner / f64::from((1..=first).product::<u32>())
}

/// g of Σ_n c_n e^{2πjnu} on force and response:
///
/// g·Σc² = Σ_n c_n² f(z − 2πjn) + Σ_{m+n=q≠0} c_m c_n [e(z + 2πjm) − e(z − 2πjn)]/(2πjq)
fn cosine_sum(coefficients: &[f64], z: Complex64) -> Complex64 {
    let most = coefficients.len() as i32 - 1;
    let c = |n: i32| coefficients[n.unsigned_abs() as usize];
    let turn = |n: i32| Complex64::new(0.0, TAU * f64::from(n));
    let mut sum = Complex64::default();
    let mut power = 0.0;
    for n in -most..=most {
        power += c(n) * c(n);
        sum += c(n) * c(n) * ramp_1(z - turn(n));
        for m in (-most..=most).filter(|m| m + n != 0) {
            sum += c(m) * c(n) * (ramp_0(z + turn(m)) - ramp_0(z - turn(n))) / turn(m + n);
        }
    }
    sum / power
}

#[cfg(test)]
mod tests {
    use super::*;

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

    fn check(name: &str, kernel: &WindowKernel, rho: impl Fn(f64) -> f64) {
        let rho: Vec<f64> = (0..=POINTS)
            .map(|k| rho(k as f64 / POINTS as f64))
            .collect();
        for z in places() {
            let expected = integral(|u| (-z * u).exp() * rho[(u * POINTS as f64).round() as usize]);
            let error = (kernel.value(z) - expected).norm();
            assert!(error < 1e-7, "{name}, z = {z}: {error:e}");
        }
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
        for (name, kernel) in [
            ("rectangular", WindowKernel::rectangular()),
            ("hann", WindowKernel::hann()),
            ("hamming", WindowKernel::hamming()),
            ("blackman", WindowKernel::blackman()),
            ("flattop", WindowKernel::flattop()),
        ] {
            let WindowKernel::Cosines { coefficients } = &kernel else {
                panic!("a cosine window");
            };
            let window = |t| cosines(coefficients, t);
            let power = overlap(window, 0.0);
            check(name, &kernel, |u| overlap(window, u) / power);
        }
    }

    #[test]
    fn blows_and_bursts_are_their_integrals() {
        check("transient", &WindowKernel::Transient, |_| 1.0);
        // corners on points of the rule, and a burst as long as the record
        for part in [0.25, 0.5, 0.9, 1.0] {
            let kernel = WindowKernel::Burst { part };
            let full = 1.0 - part;
            for z in places() {
                let flat = integral(|u| (-z * u * full).exp()) * full;
                let falling = integral(|u| (1.0 - u) * (-z * (full + part * u)).exp()) * part;
                let error = (kernel.value(z) - flat - falling).norm();
                assert!(error < 1e-7, "burst {part}, z = {z}: {error:e}");
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
        for (coefficients, kernel) in [
            (&HANN[..], WindowKernel::hann()),
            (&BLACKMAN[..], WindowKernel::blackman()),
        ] {
            let series = WindowKernel::of_values(&values(coefficients), 200);
            for z in places() {
                let error = (series.value(z) - kernel.value(z)).norm();
                assert!(error < 1e-7, "{coefficients:?}, z = {z}: {error:e}");
            }
        }
    }

    #[test]
    fn a_column_far_from_its_pole_is_the_plain_one_and_zeros_behind_cut_it() {
        let far = Complex64::new(400.0, 3000.0);
        for kernel in [
            WindowKernel::Transient,
            WindowKernel::Burst { part: 0.5 },
            WindowKernel::hann(),
            WindowKernel::flattop(),
        ] {
            assert!((kernel.factor(far, 1.0) - 1.0).norm() < 2e-3, "{kernel:?}");
            let z = Complex64::new(0.7, 3.0);
            assert_eq!(kernel.factor(2.0 * z, 0.5), kernel.factor(z, 1.0));
        }
    }
}
