//! The window that the line shapes show.
//!
//! A resonance in H1 of windowed random records is the transform of e^{pt}ρ(t) over one
//! record, not 1/(s − p). With z = (s − p)T it is (theory.md, eq. F4) T·g(z) of [`WindowKernel`].
//!
//! Each shape is fitted to the lines around every isolated mode, its pole free, and the
//! sums of squares are compared: hypotheses with the same number of unknowns.

use crate::checks::around::{neighbourhood, strongest, window_pairs};
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

/// A burst under Hann's window: its lines are those of continuous noise under a window that falls
/// off, of a structure with less damping.
pub(super) const CUT_BURST: Window = Window::HannBurst {
    part: limits::CUT_BURST,
};

/// Line shapes of windows, held against those of modes that stand alone.
#[derive(Debug, Clone)]
pub(super) struct LineShapes {
    /// Log-likelihood of each window, the likeliest first.
    ranks: Vec<(Window, f64)>,
    /// That of [`CUT_BURST`].
    burst: f64,
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
            .chain([CUT_BURST])
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
        let is_burst = |(window, _): &(Window, f64)| *window == CUT_BURST;
        let (bursts, mut ranks): (Vec<_>, Vec<_>) = ranks.into_iter().partition(is_burst);
        let burst = bursts.iter().map(|(_, score)| score).sum();
        ranks.sort_by(|a, b| b.1.total_cmp(&a.1));
        (count > 0).then_some(Self {
            ranks,
            burst,
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

    /// True where line shapes do not exclude [`CUT_BURST`].
    pub fn may_be_burst(&self) -> bool {
        self.ranks[0].1 - self.burst < limits::DECIDES
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

/// Log-likelihood of pure resonances over that of lines under `window`; `None` where no mode
/// stands alone.
pub(super) fn resonances_over(case: &Case, window: Window) -> Option<f64> {
    let modes: Vec<&Mode> = case.model.in_band_modes().collect();
    let gain = |mode: &&Mode| {
        let scores = mode_scores(case, mode, &modes, [Window::None, window].into_iter())?;
        Some(scores[0] - scores[1])
    };
    let gains: Vec<f64> = modes.iter().filter_map(gain).collect();
    (!gains.is_empty()).then(|| gains.iter().sum())
}

/// The lines around a mode that stands alone, without what the model says of all else.
struct Isolated {
    /// jω of each line, rad/s.
    s: Vec<Complex64>,
    /// Its strongest FRFs, (line, FRF).
    own: Array2<Complex64>,
    /// The pole of the model, rad/s.
    pole: Complex64,
}

impl Isolated {
    /// Poles on one line count as one mode, which a window may have split. `None` where another
    /// of `modes` stands near, a stronger one on the same line, or lines are too few.
    fn new(case: &Case, mode: &Mode, modes: &[&Mode]) -> Option<Self> {
        let half_width = 0.5 * mode.loss_factor * mode.frequency_hz;
        let partners = window_pairs(case.model, case.data.line_spacing_hz(), mode);
        let distance = |other: &Mode| (other.frequency_hz - mode.frequency_hz).abs();
        let is_near = |other: &&Mode| {
            *other != mode
                && !partners.contains(other)
                && distance(other) < limits::ALONE * half_width
        };
        let strength = |mode: &Mode| strongest(case, mode, 1).first().map_or(0.0, |own| own.0);
        let second = |partner: &&Mode| strength(partner) > strength(mode);
        if half_width <= 0.0 || modes.iter().any(is_near) || partners.iter().any(second) {
            return None;
        }
        let (work, own) = neighbourhood(
            case,
            mode,
            &partners,
            limits::REACH,
            limits::LINE_SHAPE_FRFS_MOST,
        )?;
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
    fn fitted(&self, shape: &LineShape, shift: f64) -> Result<Fitted, LinalgError> {
        best(&self.s, &self.own, shape, self.pole + shift)
    }

    /// Log-likelihood up to a constant: a noise level of its own is taken out.
    fn log_likelihood(&self, fitted: &Fitted) -> f64 {
        let free = (self.s.len() - limits::UNKNOWNS) as f64;
        -free * fitted.sse.max(f64::MIN_POSITIVE).ln()
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
        };
        Some(isolated.log_likelihood(&isolated.fitted(&shape, shift).ok()?))
    };
    windows.map(score).collect()
}

/// The line that one pole leaves in the mean of H1.
struct LineShape<'a> {
    /// The window of the records; `None`: a pure resonance.
    kernel: Option<&'a WindowKernel>,
    /// Their length, s.
    record_s: f64,
}

impl LineShape<'_> {
    /// On the lines `s` as one column, for a pole in rad/s, in units of the record length, and
    /// its derivative by the pole.
    fn columns(&self, s: &[Complex64], pole: Complex64) -> [Array2<Complex64>; 2] {
        let value_and_slope = |s: &Complex64| -> [Complex64; 2] {
            let z = (s - pole) * self.record_s;
            let of_kernel = self.kernel.map(|kernel| kernel.value_and_slope(z));
            of_kernel.unwrap_or_else(|| [z.inv(), -z.inv().powi(2)])
        };
        let all: Vec<[Complex64; 2]> = s.iter().map(value_and_slope).collect();
        let column = |of: usize, factor: f64| {
            Array2::from_shape_fn((s.len(), 1).f(), |(k, _)| all[k][of] * factor)
        };
        [column(0, 1.0), column(1, -self.record_s)]
    }
}

/// Least sum of squares over the pole: variable projection.
fn best(
    s: &[Complex64],
    own: &Array2<Complex64>,
    shape: &LineShape,
    start: Complex64,
) -> Result<Fitted, LinalgError> {
    let mut now = Fitted::new(s, own, shape, start)?;
    let mut damping = 1.0;
    for _ in 0..limits::STEPS {
        let step = damping * now.step();
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
struct Fitted {
    /// The pole, rad/s.
    pole: Complex64,
    /// Derivative of the resonance by the pole, the span of the linear part taken out.
    outside: Array2<Complex64>,
    residual: Array2<Complex64>,
    /// Coefficient of the resonance in each FRF.
    strength: Vec<Complex64>,
    sse: f64,
}

impl Fitted {
    fn new(
        s: &[Complex64],
        own: &Array2<Complex64>,
        shape: &LineShape,
        pole: Complex64,
    ) -> Result<Self, LinalgError> {
        let [resonance, derivative] = shape.columns(s, pole);
        let (first, span) = (s[0].im, s[s.len() - 1].im - s[0].im);
        let basis = Array2::from_shape_fn((s.len(), 3).f(), |(k, c)| match c {
            0 => resonance[[k, 0]],
            1 => Complex64::new(1.0, 0.0),
            _ => Complex64::new((s[k].im - first) / span, 0.0),
        });
        let (q, _) = qr_thin(basis.view())?;
        let beyond = |columns: &Array2<Complex64>| {
            columns - &matmul(q.view(), matmul_h(q.view(), columns.view()).view())
        };
        let residual = beyond(own);
        let sse = residual.iter().map(|v| v.norm_sqr()).sum();
        let strength = lstsq(basis.view(), own.view())?.row(0).to_vec();
        Ok(Self {
            pole,
            outside: beyond(&derivative),
            residual,
            strength,
            sse,
        })
    }

    /// Step of Gauss and Newton.
    fn step(&self) -> Complex64 {
        let square = |values: &[Complex64]| values.iter().map(|v| v.norm_sqr()).sum::<f64>();
        let stretch = square(self.outside.as_slice_memory_order().unwrap_or_default());
        let matched = matmul_h(self.outside.view(), self.residual.view());
        let slope: Complex64 = matched
            .iter()
            .zip(&self.strength)
            .map(|(m, r)| m * r.conj())
            .sum();
        slope / (stretch * square(&self.strength)).max(f64::MIN_POSITIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of records of two seconds.
    fn shape(kernel: Option<&WindowKernel>) -> LineShape<'_> {
        LineShape {
            kernel,
            record_s: 2.0,
        }
    }

    /// jω of these lines, and a pole of two lines per half-power bandwidth at line 120.2.
    fn lines_and_pole(lines: std::ops::Range<u32>) -> (Vec<Complex64>, Complex64) {
        let on_axis = |k| Complex64::new(0.0, TAU * 0.5 * f64::from(k));
        (
            lines.map(on_axis).collect(),
            Complex64::new(-TAU * 0.5, TAU * 60.1),
        )
    }

    #[test]
    fn the_window_of_a_line_is_told_and_its_pole_found() {
        let kernel = Window::Hann.kernel().unwrap();
        let (s, pole) = lines_and_pole(104..137);
        let [own, _] = shape(Some(&kernel)).columns(&s, pole);
        let isolated = Isolated {
            own,
            s,
            pole: pole * Complex64::new(1.0, 0.001),
        };
        let found = isolated.fitted(&shape(Some(&kernel)), 0.0).unwrap();
        let plain = isolated.fitted(&shape(None), 0.0).unwrap();
        let off = |fitted: &Fitted| (fitted.pole - pole).norm() / -pole.re;
        assert!(off(&found) < 1e-3, "{}", found.pole);
        assert!(off(&plain) > 0.1, "{}", plain.pole);
        assert!(isolated.log_likelihood(&found) > isolated.log_likelihood(&plain) + 50.0);
    }

    #[test]
    fn lines_do_not_tell_a_cut_burst_from_continuous_noise_but_its_damping_is_another() {
        let [hann, burst] = [Window::Hann, CUT_BURST].map(|window| window.kernel().unwrap());
        let (s, pole) = lines_and_pole(112..129);
        let [mut own, _] = shape(Some(&burst)).columns(&s, pole);
        // errors 30 dB below the peak, alike in no two lines
        let level = 0.03 * own.iter().map(|v| v.norm()).fold(0.0, f64::max);
        for (k, value) in own.iter_mut().enumerate() {
            *value += Complex64::from_polar(level, 2.4 * (k * k) as f64);
        }
        let isolated = Isolated { own, s, pole };
        let [of_hann, of_burst] =
            [&hann, &burst].map(|kernel| isolated.fitted(&shape(Some(kernel)), 0.0).unwrap());
        let gain = isolated.log_likelihood(&of_burst) - isolated.log_likelihood(&of_hann);
        assert!(gain.abs() < limits::DECIDES, "{gain}");
        assert!(of_hann.pole.re > 0.9 * of_burst.pole.re, "{}", of_hann.pole);
    }
}
