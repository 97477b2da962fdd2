//! The window that the line shapes speak of.
//!
//! A resonance in H1 of windowed random records is the transform of e^{pt}ρ(t) over one
//! record, not 1/(s − p). With z = (s − p)T it is (theory.md, eq. F4) T·g(z) of [`WindowKernel`].
//!
//! Each shape is fitted to the lines around every isolated mode, its pole free, and the
//! sums of squares are compared: hypotheses with the same number of unknowns.

use crate::checks::around::neighbourhood;
use crate::checks::case::Case;
use crate::checks::correlation::TAPERED;
use crate::checks::limits;
use crate::data::window::kernel::WindowKernel;
use crate::data::window::kinds::Window;
use crate::data::window::leakage::Leakage;
use chladni_frf::Mode;
use chladni_linalg::{lstsq, matmul, matmul_h, qr_thin, LinalgError};
use ndarray::{Array2, ShapeBuilder};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Line shapes compared with those of [`TAPERED`] windows.
const UNTAPERED: [Window; 2] = [Window::None, Window::Rectangular];

/// Line shapes of windows, held against those of modes that stand alone.
#[derive(Debug, Clone)]
pub(super) struct LineShapes {
    /// Log-likelihood of each window, the likeliest first.
    ranks: Vec<(Window, f64)>,
    /// Modes that were asked.
    pub modes: usize,
}

impl LineShapes {
    /// `None` where no mode stands alone.
    pub fn new(case: &Case) -> Option<Self> {
        let modes: Vec<&Mode> = case.model.in_band_modes().collect();
        let mut ranks: Vec<(Window, f64)> = UNTAPERED
            .into_iter()
            .chain(TAPERED)
            .map(|w| (w, 0.0))
            .collect();
        let mut count = 0;
        for mode in &modes {
            let windows = ranks.iter().map(|(window, _)| *window);
            if let Some(own) = mode_scores(case, mode, &modes, windows) {
                let sums = ranks.iter_mut().zip(own);
                sums.for_each(|((_, sum), score)| *sum += score);
                count += 1;
            }
        }
        ranks.sort_by(|a, b| b.1.total_cmp(&a.1));
        (count > 0).then_some(Self {
            ranks,
            modes: count,
        })
    }

    /// The likeliest window.
    pub fn likeliest(&self) -> Window {
        self.ranks[0].0
    }

    /// The likeliest window where line shapes tell it from all others, and its
    /// log-likelihood over the second best.
    pub fn decided(&self) -> Option<(Window, f64)> {
        let gain = self.ranks[0].1 - self.ranks[1].1;
        (gain > limits::DECIDES).then(|| (self.likeliest(), gain))
    }

    /// Log-likelihood of the likeliest window over that of the best that does not fall off to
    /// both ends.
    pub fn tapered_gain(&self) -> f64 {
        let untapered = self.ranks.iter().find(|(own, _)| UNTAPERED.contains(own));
        self.ranks[0].1 - untapered.map_or(0.0, |(_, score)| *score)
    }

    /// True for each of [`TAPERED`] that line shapes do not exclude.
    pub fn open(&self) -> [bool; TAPERED.len()] {
        let open = self
            .ranks
            .iter()
            .filter(|(_, score)| self.ranks[0].1 - score < limits::DECIDES);
        let open: Vec<Window> = open.map(|(window, _)| *window).collect();
        TAPERED.map(|window| open.contains(&window))
    }
}

/// The lines around a mode that stands alone, without what the model says of all else.
pub(super) struct Isolated {
    /// jω of each line, rad/s.
    s: Vec<Complex64>,
    /// Its strongest FRFs, (line, FRF).
    own: Array2<Complex64>,
    /// The pole of the model, rad/s.
    pole: Complex64,
}

impl Isolated {
    /// `None` where another of `modes` stands near, or lines are too few.
    pub fn new(case: &Case, mode: &Mode, modes: &[&Mode]) -> Option<Self> {
        let half_width = 0.5 * mode.loss_factor * mode.frequency_hz;
        let near = |other: &&Mode| {
            *other != mode
                && (other.frequency_hz - mode.frequency_hz).abs() < limits::ALONE * half_width
        };
        if half_width <= 0.0 || modes.iter().any(near) {
            return None;
        }
        let (work, own) = neighbourhood(case, mode, limits::REACH, limits::LINE_SHAPE_FRFS_MOST)?;
        let on_axis = |x: &f64| Complex64::new(0.0, x.sqrt() * case.data.omega_max);
        (work.lines() >= 2 * limits::UNKNOWNS).then(|| Self {
            s: work.x.iter().map(on_axis).collect(),
            own,
            pole: Complex64::new(-half_width, mode.frequency_hz) * TAU,
        })
    }

    /// The best fit of a line shape, its pole sought from that of the model plus `shift`.
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn fitted(&self, shape: &LineShape, shift: f64) -> Result<Fitted, LinalgError> {
        best(&self.s, &self.own, shape, self.pole + shift)
    }

    /// Log-likelihood up to a constant: a noise level of its own is taken out.
    pub fn log_likelihood(&self, fitted: &Fitted) -> f64 {
        let free = (self.s.len() - limits::UNKNOWNS) as f64;
        -free * fitted.sse.max(f64::MIN_POSITIVE).ln()
    }

    /// Half-power bandwidth, rad/s.
    pub fn bandwidth(&self) -> f64 {
        -2.0 * self.pole.re
    }
}

/// Log-likelihood of each of `windows` on the lines around one mode.
fn mode_scores(
    case: &Case,
    mode: &Mode,
    modes: &[&Mode],
    windows: impl Iterator<Item = Window>,
) -> Option<Vec<f64>> {
    let isolated = Isolated::new(case, mode, modes)?;
    let record_s = 1.0 / case.data.line_spacing_hz();
    let score = |window: Window| -> Option<f64> {
        let kernel = window.kernel();
        // without its window a line is narrower
        let shift = kernel.as_ref().map_or(0.0, |kernel| {
            let seen = -isolated.pole.re;
            let leakage = Leakage::new(kernel.clone(), record_s, 0);
            (seen - leakage.unbroadened(seen)).min(limits::SHARPENED_MOST * seen)
        });
        let shape = LineShape {
            kernel: kernel.as_ref(),
            record_s,
            drop: 1.0,
        };
        Some(isolated.log_likelihood(&isolated.fitted(&shape, shift).ok()?))
    };
    windows.map(score).collect()
}

/// The line that one pole leaves in the mean of H1.
pub(super) struct LineShape<'a> {
    /// The window of the records; `None`: a pure resonance.
    pub kernel: Option<&'a WindowKernel>,
    /// Their length, s.
    pub record_s: f64,
    /// Ratio d of decays of a force that drops at the resonance, S_ff ∝ |jω − s|²/|jω − p|²,
    /// p = d·Re s + j·Im s; 1: an even force.
    pub drop: f64,
}

impl LineShape<'_> {
    /// On the lines `s` as one column, for a pole in rad/s, in units of the record length
    /// (theory.md, eq. F4f).
    fn column(&self, s: &[Complex64], pole: Complex64) -> Array2<Complex64> {
        let value = |s: Complex64| -> Complex64 {
            let Some(kernel) = self.kernel else {
                return ((s - pole) * self.record_s).inv();
            };
            let of_force = Complex64::new(self.drop * pole.re, pole.im);
            let g = kernel.value_and_slope((s - of_force) * self.record_s)[0];
            let (drop, decay) = (self.drop, -pole.re * self.record_s);
            (g - (1.0 - 1.0 / drop) * g.re) / (1.0 - (drop - 1.0 / drop) * decay * g.re)
        };
        Array2::from_shape_fn((s.len(), 1).f(), |(k, _)| value(s[k]))
    }
}

/// Least sum of squares over the pole: variable projection, the real and the imaginary part
/// two unknowns.
fn best(
    s: &[Complex64],
    own: &Array2<Complex64>,
    shape: &LineShape,
    start: Complex64,
) -> Result<Fitted, LinalgError> {
    let mut now = Fitted::new(s, own, shape, start)?;
    let mut damping = 1.0;
    for _ in 0..limits::STEPS {
        let step = damping * now.step(s, shape);
        let pole = now.pole;
        let step = if step.norm() > -limits::LINE_SHAPE_STEP * pole.re {
            step * (-limits::LINE_SHAPE_STEP * pole.re / step.norm())
        } else {
            step
        };
        let trial = Fitted::new(s, own, shape, pole + step)?;
        if trial.sse < now.sse {
            (now, damping) = (trial, 1.0);
        } else {
            damping *= limits::LINE_SHAPE_SHORTER;
        }
        if step.norm() < -limits::STILL * pole.re {
            break;
        }
    }
    Ok(now)
}

/// Linear part at one pole: the resonance, a constant and a slope.
pub(super) struct Fitted {
    /// The pole, rad/s.
    pub pole: Complex64,
    q: Array2<Complex64>,
    residual: Array2<Complex64>,
    /// Coefficient of the resonance in each FRF.
    pub strength: Vec<Complex64>,
    sse: f64,
}

impl Fitted {
    fn new(
        s: &[Complex64],
        own: &Array2<Complex64>,
        shape: &LineShape,
        pole: Complex64,
    ) -> Result<Self, LinalgError> {
        let resonance = shape.column(s, pole);
        let (first, span) = (s[0].im, s[s.len() - 1].im - s[0].im);
        let basis = Array2::from_shape_fn((s.len(), 3).f(), |(k, c)| match c {
            0 => resonance[[k, 0]],
            1 => Complex64::new(1.0, 0.0),
            _ => Complex64::new((s[k].im - first) / span, 0.0),
        });
        let (q, _) = qr_thin(basis.view())?;
        let residual = own - &matmul(q.view(), matmul_h(q.view(), own.view()).view());
        let sse = residual.iter().map(|v| v.norm_sqr()).sum();
        let strength = lstsq(basis.view(), own.view())?.row(0).to_vec();
        Ok(Self {
            pole,
            q,
            residual,
            strength,
            sse,
        })
    }

    /// Step of Gauss and Newton; a force that drops makes the column no analytic function of
    /// the pole.
    fn step(&self, s: &[Complex64], shape: &LineShape) -> Complex64 {
        let h = limits::LINE_SHAPE_DIFFERENCE * self.pole.re;
        let outside = [Complex64::ONE, Complex64::I].map(|along| {
            let sides = [h, -h].map(|h| shape.column(s, self.pole + along * h));
            let difference: Array2<Complex64> = (&sides[0] - &sides[1]) / Complex64::from(2.0 * h);
            let inside = matmul_h(self.q.view(), difference.view());
            difference - &matmul(self.q.view(), inside.view())
        });
        let power: f64 = self.strength.iter().map(|v| v.norm_sqr()).sum();
        let product = |a: &Array2<Complex64>, b: &Array2<Complex64>| -> f64 {
            a.iter().zip(b).map(|(a, b)| (a.conj() * b).re).sum::<f64>() * power
        };
        let slope = |a: &Array2<Complex64>| -> f64 {
            let matched = matmul_h(a.view(), self.residual.view());
            let each = matched.iter().zip(&self.strength);
            each.map(|(m, r)| (m * r.conj()).re).sum()
        };
        let [re, im] = &outside;
        let (a, b, c) = (product(re, re), product(re, im), product(im, im));
        let (p, q) = (slope(re), slope(im));
        let determinant = (a * c - b * b).max(f64::MIN_POSITIVE);
        Complex64::new(c * p - b * q, a * q - b * p) / determinant
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn by_sum(line: Complex64, pole: Complex64, drop: f64, record_s: f64) -> Complex64 {
        let mut sums = (Complex64::ZERO, 0.0);
        for k in -2400..=2400 {
            let cycles = f64::from(k) / 60.0;
            let s = line + Complex64::new(0.0, TAU * cycles / record_s);
            let of_force = Complex64::new(drop * pole.re, pole.im);
            let power = hann_power(cycles) * (s - pole).norm_sqr() / (s - of_force).norm_sqr();
            sums.0 += power / (s - pole);
            sums.1 += power;
        }
        sums.0 / sums.1
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
        for drop in [1.0, 4.0, 31.6] {
            let shape = LineShape {
                kernel: Some(&kernel),
                record_s,
                drop,
            };
            let column = shape.column(&lines, pole);
            for (line, value) in lines.iter().zip(&column) {
                let expected = by_sum(*line, pole, drop, record_s);
                let off = (value * record_s - expected).norm();
                assert!(
                    off < 1e-6 * expected.norm(),
                    "drop {drop}, {line}: {value} for {expected}"
                );
            }
        }
    }

    #[test]
    fn the_ratio_of_a_drop_is_found_with_its_pole() {
        let kernel = Window::Hann.kernel().unwrap();
        let shape = |drop: f64| LineShape {
            kernel: Some(&kernel),
            record_s: 2.0,
            drop,
        };
        let pole = Complex64::new(-TAU * 0.5, TAU * 60.1);
        let s: Vec<Complex64> = (104..137)
            .map(|k| Complex64::new(0.0, TAU * 0.5 * f64::from(k)))
            .collect();
        let isolated = Isolated {
            own: shape(4.0).column(&s, pole),
            s,
            pole: pole * Complex64::new(1.0, 0.001),
        };
        let even = isolated.fitted(&shape(1.0), 0.0).unwrap();
        let found = isolated.fitted(&shape(4.0), 0.0).unwrap();
        assert!(
            (found.pole - pole).norm() < 1e-3 * -pole.re,
            "{}",
            found.pole
        );
        assert!(
            (even.pole - pole).re.abs() > 0.03 * -pole.re,
            "{}",
            even.pole
        );
        assert!(isolated.log_likelihood(&found) > isolated.log_likelihood(&even) + 50.0);
    }
}
