//! The column of a mode and its derivative, in the law that a set of lines has.
//!
//! λ_n = (ω_n/ω_max)²(1 + jη_n) in both laws. A structural mode is 1/(λ − x); a viscous one
//! has a loss that grows with frequency, 1/(Re λ + j·Im λ·√(x/Re λ) − x), which is
//! 1/(ω_n² − ω² + jη_nω_nω), exact for real shapes (theory.md, eq. 16–17). In the
//! viscous law the derivative by Re λ is replaced by that by j·Im λ. The two differ by half a loss
//! factor, so estimates lose η² of their information, and steps converge by a factor of about η.

use crate::damping::places::viscous_pole_of;
use crate::data::window::lanes::Lanes;
use crate::data::window::leakage::{LeakingLines, LeakingPole, Line, PoleLeakage};
use chladni_frf::Damping;
use num_complex::Complex64;

/// 1/z by one real division. Distances on a normalised axis have squares far inside the
/// range of f64.
#[inline]
pub(crate) fn inverse(z: Complex64) -> Complex64 {
    let scale = 1.0 / z.norm_sqr();
    Complex64::new(z.re * scale, -z.im * scale)
}

/// Loss at x over that at the natural frequency.
#[inline]
pub(crate) fn loss(law: Damping, pole: Complex64, x: f64) -> f64 {
    match law {
        Damping::Structural => 1.0,
        Damping::Viscous => (x / pole.re.max(f64::MIN_POSITIVE)).sqrt(),
    }
}

/// The column at x that a residue of the pole multiplies.
#[inline]
pub(crate) fn resonance(law: Damping, pole: Complex64, x: f64) -> Complex64 {
    match law {
        Damping::Structural => inverse(pole - x),
        Damping::Viscous => {
            let lossy = pole.im * loss(law, pole, x);
            inverse(Complex64::new(pole.re - x, lossy))
        }
    }
}

/// The column of a pole with its derivative, some lines at a time.
pub(crate) trait PoleColumn {
    /// Column and derivative on L lines from the line `first` on.
    ///
    /// * `x`, `g`: place and weight of these lines
    fn at<const L: usize>(&self, first: usize, x: &[f64; L], g: &[f64; L]) -> [Lanes<L>; 2];
}

/// The column of [`resonance`].
pub(crate) struct PlainColumn {
    law: Damping,
    pole: Complex64,
    /// 1/Re λ.
    over: f64,
}

impl PlainColumn {
    pub fn new(law: Damping, pole: Complex64) -> Self {
        let over = 1.0 / pole.re.max(f64::MIN_POSITIVE);
        Self { law, pole, over }
    }
}

impl PoleColumn for PlainColumn {
    #[inline(always)]
    fn at<const L: usize>(&self, _: usize, x: &[f64; L], g: &[f64; L]) -> [Lanes<L>; 2] {
        let (pole, mut loss, mut slope) = (self.pole, [1.0; L], [0.0; L]);
        for l in 0..L {
            if self.law == Damping::Viscous {
                loss[l] = (x[l] * self.over).sqrt();
            }
            slope[l] = -g[l] * loss[l];
        }
        let mut distance = Lanes::ZERO;
        for l in 0..L {
            distance.re[l] = pole.re - x[l];
            distance.im[l] = pole.im * loss[l];
        }
        let plain = distance.inverse();
        [plain * *g, plain * plain * slope]
    }
}

/// The column where FRFs leak.
pub(crate) struct LeakingColumn<'a> {
    /// Of the pole above the real axis.
    plain: PlainColumn,
    /// The pole asked for lies below: its column is the conjugate.
    mirrored: bool,
    of_receptance: LeakingPole,
    leaks: PoleLeakage<'a>,
    lines: &'a [Line],
}

impl<'a> LeakingColumn<'a> {
    pub fn new(law: Damping, leaking: &'a LeakingLines, pole: Complex64) -> Self {
        let mirrored = pole.im < 0.0;
        let pole = if mirrored { pole.conj() } else { pole };
        let of_receptance = leaking_pole(law, pole);
        Self {
            plain: PlainColumn::new(law, pole),
            mirrored,
            of_receptance,
            leaks: leaking.leakage.of_pole(of_receptance.s),
            lines: &leaking.lines,
        }
    }
}

impl PoleColumn for LeakingColumn<'_> {
    #[inline(always)]
    fn at<const L: usize>(&self, first: usize, x: &[f64; L], g: &[f64; L]) -> [Lanes<L>; 2] {
        let [plain, along] = self.plain.at(first, x, g);
        let last = self.lines.len() - 1;
        let mut lines = [self.lines[last]; L];
        for l in 0..L {
            lines[l] = self.lines[(first + l).min(last)];
        }
        let [factor, slope] = self.leaks.factors_of_column(&self.of_receptance, &lines);
        let both = [plain * factor, along * factor + plain * slope];
        if self.mirrored {
            both.map(Lanes::conj)
        } else {
            both
        }
    }
}

/// The pole of receptance of λ (Im λ ≥ 0).
pub(crate) fn leaking_pole(law: Damping, pole: Complex64) -> LeakingPole {
    match law {
        // beyond half of critical damping s and s* draw near and meet; such a pole is
        // background, so broad that nothing leaks
        Damping::Viscous if pole.im < pole.re => {
            let s = viscous_pole_of(pole);
            LeakingPole {
                s,
                other: s.conj(),
                slope: Complex64::new(0.0, 0.5 / pole.re.sqrt()),
            }
        }
        _ => {
            let s = Complex64::i() * pole.sqrt();
            LeakingPole {
                s,
                other: -s,
                slope: -0.5 / s,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::window::kernel::WindowKernel;
    use crate::data::window::kinds::Window;
    use crate::data::window::leakage::Leakage;
    use std::sync::Arc;

    /// T·ω_max: lines 1/500 of ω_max apart.
    const RECORD: f64 = 500.0 * std::f64::consts::TAU;

    /// The leaking column at x and its derivative.
    fn at(law: Damping, leakage: &Arc<Leakage>, pole: Complex64, x: f64) -> [Complex64; 2] {
        let leaking = LeakingLines::new(leakage.clone(), &[x]);
        let column = LeakingColumn::new(law, &leaking, pole);
        column.at(0, &[x], &[1.0]).map(|lanes| lanes.get(0))
    }

    #[test]
    fn columns_that_leak_are_finite_however_heavy_the_damping() {
        let kernel = WindowKernel::cosines(&[0.5, -0.25]);
        let leakage = Arc::new(Leakage::new(kernel, 3000.0, 1));
        for law in [Damping::Structural, Damping::Viscous] {
            for (re, im) in [(0.3, 0.5), (0.3, 0.6), (0.3, 0.7), (0.3, -0.6)] {
                let pole = Complex64::new(re, im);
                for x in [0.05, 0.3, 0.9] {
                    let plain = resonance(law, pole, x);
                    let [value, slope] = at(law, &leakage, pole, x);
                    assert!(slope.is_finite(), "{law:?} {pole} {x}");
                    assert!(
                        (value - plain).norm() < 0.05 * plain.norm(),
                        "{law:?} {pole} {x}: {value} for {plain}"
                    );
                }
            }
        }
    }

    #[test]
    fn a_viscous_column_is_that_of_its_pair_of_poles() {
        let lambda = Complex64::new(0.4, 0.4 * 0.06);
        let s = viscous_pole_of(lambda);
        for x in [0.05, 0.39, 0.4, 1.0_f64] {
            let jy = Complex64::new(0.0, x.sqrt());
            let over = Complex64::new(0.0, 2.0 * s.im);
            let pair = 1.0 / (over * (jy - s)) - 1.0 / (over * (jy - s.conj()));
            let column = resonance(Damping::Viscous, lambda, x);
            assert!((column - pair).norm() < 1e-13 * pair.norm(), "{x}");
        }
    }

    /// The part that leakage adds to ∫₀^∞ e^{st}e^{−jωt} dt, by the trapezium rule on a
    /// record whose force and response are `window` times noise and what it makes.
    fn by_quadrature(window: &[f64], s: Complex64, y: f64) -> Complex64 {
        let count = window.len();
        let power: f64 = window.iter().map(|w| w * w).sum();
        let step = RECORD / count as f64;
        let turn = s - Complex64::new(0.0, y);
        let value = |lag: usize| {
            let shared: f64 = window.iter().zip(&window[lag..]).map(|(a, b)| a * b).sum();
            let half = if lag == 0 { 0.5 } else { 1.0 };
            shared / power * half * (turn * step * lag as f64).exp() * step
        };
        // Euler and Maclaurin: the slope at lag 0 is that of the exponential
        (0..count).map(value).sum::<Complex64>() + step * step / 12.0 * turn + 1.0 / turn
    }

    #[test]
    fn the_column_is_that_of_a_simulated_windowed_record() {
        let count = 8000;
        let hann: Vec<f64> = (0..count)
            .map(|k| {
                (std::f64::consts::PI * (k as f64 + 0.5) / count as f64)
                    .sin()
                    .powi(2)
            })
            .collect();
        for law in [Damping::Structural, Damping::Viscous] {
            // one line per half-power bandwidth
            let lambda = Complex64::new(0.36, 0.0012);
            let pole = leaking_pole(law, lambda);
            for (kind, line) in [(0, 300), (1, 299), (2, 302), (1, 310)] {
                let y = f64::from(line) / 500.0;
                let kernel = Window::Hann.kernel().unwrap();
                let leakage = Arc::new(Leakage::new(kernel, RECORD, kind));
                let added = leakage.of_pole(pole.s).added(pole.other, &leakage.line(y));
                let expected =
                    by_quadrature(&hann, pole.s, y) * pole.s.powi(kind) / (pole.s - pole.other);
                assert!(
                    (added - expected).norm() < 1e-4 * expected.norm(),
                    "{law:?} {kind} {line}: {added} for {expected}"
                );
                // the column in the kind is the plain one and that
                let column = at(law, &leakage, lambda, y * y)[0];
                let plain = resonance(law, lambda, y * y);
                let of_kind = added / Complex64::new(0.0, y).powi(kind);
                assert!(
                    (column - plain - of_kind).norm() < 1e-12 * plain.norm(),
                    "{law:?} {kind} {line}: {column} for {}",
                    plain + of_kind
                );
            }
        }
    }

    #[test]
    fn slopes_are_those_of_finite_differences() {
        let windows = [
            Window::Transient,
            Window::Rectangular,
            Window::Hann,
            Window::Flattop,
            Window::Kaiser { beta: 8.6 },
            Window::Burst { part: 0.7 },
            Window::HannBurst { part: 0.7 },
        ];
        for window in windows {
            let leakage = Arc::new(Leakage::new(window.kernel().unwrap(), RECORD, 1));
            for lambda in [Complex64::new(0.36, 0.0012), Complex64::new(0.36, -0.004)] {
                // the derivative of the viscous law is one by j·Im λ
                for (law, unit) in [
                    (Damping::Structural, Complex64::ONE),
                    (Damping::Structural, Complex64::I),
                    (Damping::Viscous, Complex64::I),
                ] {
                    let step = 1e-7;
                    let at = |lambda, y: f64| at(law, &leakage, lambda, y * y);
                    let lines = (285..315).map(|line| f64::from(line) / 500.0);
                    let (mut off, mut size) = (0.0f64, 0.0f64);
                    for y in lines {
                        let sides = [1.0, -1.0].map(|sign| at(lambda + unit * (sign * step), y)[0]);
                        let difference = (sides[0] - sides[1]) / (2.0 * step * unit);
                        let slope = at(lambda, y)[1];
                        off = off.max((difference - slope).norm());
                        size = size.max(slope.norm());
                    }
                    assert!(
                        off < 1e-2 * size,
                        "{window} {law:?} {lambda}: {off} of {size}"
                    );
                }
            }
        }
    }
}
