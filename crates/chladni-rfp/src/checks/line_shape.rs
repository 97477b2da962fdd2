//! The window that the line shapes speak of.
//!
//! A resonance in H1 of windowed random records is the transform of e^{pt}ρ(t) over one
//! record, not 1/(s − p). With z = (s − p)T it is (theory.md, eq. F4) T·g(z) of [`WindowKernel`].
//!
//! Each shape is fitted to the lines around every isolated mode, its pole free, and the
//! sums of squares are compared: three hypotheses with the same number of unknowns.

use crate::checks::case::Case;
use crate::checks::limits;
use crate::checks::moving::neighbourhood;
use crate::damping::window_kernel::WindowKernel;
use crate::data::options::Window;
use chladni_frf::Mode;
use chladni_linalg::{lstsq, matmul, matmul_h, qr_thin, LinalgError};
use ndarray::{Array2, ShapeBuilder};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Line shapes compared.
const TRIED: [Window; 3] = [Window::None, Window::Hann, Window::Rectangular];

/// The window whose line shape wins, by how much (log-likelihood over the second best),
/// and on how many modes.
pub(crate) fn likely_window(case: &Case) -> Option<(Window, f64, usize)> {
    let modes: Vec<&Mode> = case.model.in_band_modes().collect();
    let mut scores = [0.0; TRIED.len()];
    let mut count = 0;
    for mode in &modes {
        if let Some(own) = mode_scores(case, mode, &modes) {
            scores
                .iter_mut()
                .zip(own)
                .for_each(|(sum, score)| *sum += score);
            count += 1;
        }
    }
    let mut order: Vec<usize> = (0..scores.len()).collect();
    order.sort_by(|&a, &b| scores[b].total_cmp(&scores[a]));
    (count > 0).then(|| (TRIED[order[0]], scores[order[0]] - scores[order[1]], count))
}

/// Log-likelihood of each window on the lines around one mode.
fn mode_scores(case: &Case, mode: &Mode, modes: &[&Mode]) -> Option<[f64; TRIED.len()]> {
    let half_width = 0.5 * mode.loss_factor * mode.frequency_hz;
    let near = |other: &&Mode| {
        *other != mode
            && (other.frequency_hz - mode.frequency_hz).abs() < limits::ALONE * half_width
    };
    if half_width <= 0.0 || modes.iter().any(near) {
        return None;
    }
    let record_s = 1.0 / case.data.line_spacing_hz();
    let (work, own) = neighbourhood(case, mode, limits::REACH, limits::LINE_SHAPE_FRFS_MOST)?;
    if work.lines() < 2 * limits::UNKNOWNS {
        return None;
    }
    let s: Vec<Complex64> = work
        .x
        .iter()
        .map(|x| Complex64::new(0.0, x.sqrt() * case.data.omega_max))
        .collect();
    let pole = Complex64::new(-half_width, mode.frequency_hz) * TAU;
    let mut scores = [0.0; TRIED.len()];
    for (score, window) in scores.iter_mut().zip(TRIED) {
        // without its window a line is narrower by about 1/T
        let shift = if window == Window::None {
            0.0
        } else {
            (1.0 / record_s).min(-0.7 * pole.re)
        };
        let kernel = window.kernel();
        let sse = best(&s, &own, kernel.as_ref(), record_s, pole + shift).ok()?;
        *score = -((work.lines() - limits::UNKNOWNS) as f64) * sse.max(f64::MIN_POSITIVE).ln();
    }
    Some(scores)
}

/// Least sum of squares over the pole: variable projection with one complex unknown.
fn best(
    s: &[Complex64],
    own: &Array2<Complex64>,
    kernel: Option<&WindowKernel>,
    record_s: f64,
    start: Complex64,
) -> Result<f64, LinalgError> {
    let mut pole = start;
    let mut now = Fitted::new(s, own, kernel, record_s, pole)?;
    let mut damping = 1.0;
    for _ in 0..limits::STEPS {
        let h = 1e-4 * pole.re;
        let difference: Array2<Complex64> = (column(s, kernel, record_s, pole + h)
            - column(s, kernel, record_s, pole - h))
            / (2.0 * h);
        let outside = &difference
            - &matmul(
                now.q.view(),
                matmul_h(now.q.view(), difference.view()).view(),
            );
        let power: f64 = outside.iter().map(|v| v.norm_sqr()).sum::<f64>()
            * now.strength.iter().map(|v| v.norm_sqr()).sum::<f64>();
        let matched = matmul_h(outside.view(), now.residual.view());
        let slope: Complex64 = matched
            .iter()
            .zip(&now.strength)
            .map(|(m, r)| m * r.conj())
            .sum();
        let step = damping * slope / power.max(f64::MIN_POSITIVE);
        let step = if step.norm() > -0.5 * pole.re {
            step * (-0.5 * pole.re / step.norm())
        } else {
            step
        };
        let trial = Fitted::new(s, own, kernel, record_s, pole + step)?;
        if trial.sse < now.sse {
            (pole, now, damping) = (pole + step, trial, 1.0);
        } else {
            damping *= 0.3;
        }
        if step.norm() < -limits::STILL * pole.re {
            break;
        }
    }
    Ok(now.sse)
}

/// Linear part at one pole: the resonance, a constant and a slope.
struct Fitted {
    q: Array2<Complex64>,
    residual: Array2<Complex64>,
    /// Coefficient of the resonance in each FRF.
    strength: Vec<Complex64>,
    sse: f64,
}

impl Fitted {
    fn new(
        s: &[Complex64],
        own: &Array2<Complex64>,
        kernel: Option<&WindowKernel>,
        record_s: f64,
        pole: Complex64,
    ) -> Result<Self, LinalgError> {
        let resonance = column(s, kernel, record_s, pole);
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
            q,
            residual,
            strength,
            sse,
        })
    }
}

/// The line shape of a pole, rad/s, on the lines `s`, as one column; in units of the
/// record length.
fn column(
    s: &[Complex64],
    kernel: Option<&WindowKernel>,
    record_s: f64,
    pole: Complex64,
) -> Array2<Complex64> {
    Array2::from_shape_fn((s.len(), 1).f(), |(k, _)| {
        let z = (s[k] - pole) * record_s;
        kernel.map_or(z.inv(), |kernel| kernel.value_and_slope(z)[0])
    })
}
