//! Circle fit: near a resonance the receptance traces a circle in the complex plane.
//!
//! With one mode over a constant background, α = A/(λ − x) + B is a Möbius map of the
//! line x = ω², so its image is a circle:
//!
//! ```text
//! α = c + ρ e^{jψ} (λ* − x)/(λ − x),     arg = ψ − 2 arg(λ − x)
//! ```
//!
//! Each column gives a circle around each visible peak (algebraic fit), and its angle
//! over x a natural frequency and a loss factor (three-parameter least squares of the
//! angle, as for the Q circle of resonators). The pole is the median over the columns,
//! weighted by diameter over misfit. Columns are the compressed mixtures of FRFs: the
//! same circles, less noise.
//!
//! Cost: peaks × columns × some tens of lines.
//!
//! Avoid it for modes closer than two or three bandwidths, whose neighbours are no
//! constant background; and with less than about six lines per bandwidth, where the arc
//! is too short. A mode without a peak of its own is not found.
//!
//! C. C. Kennedy, C. D. P. Pancu, J. Aeronaut. Sci. 14 (1947) 603–625. I. Kåsa, IEEE
//! Trans. Instrum. Meas. 25 (1976) 8–14 (circle). P. J. Petersan, S. M. Anlage, J. Appl.
//! Phys. 84 (1998) 3392–3402 (angle against frequency).

use super::limits::{
    ANGLE_STEP, ANGLE_STEPS, ANGLE_STILL, ARC_HALF_WIDTHS, ARC_LEAST_LINES, CIRCLE_LEAST_POINTS,
    CIRCLE_ROUNDING, ROUND,
};
use crate::data::columns::Columns;
use crate::data::error::FitError;
use crate::data::options::FitOptions;
use crate::methods::found::MethodPoles;
use crate::methods::peak::picked;
use crate::methods::selection::modes_of;
use crate::methods::survey::{Compressed, Survey};
use chladni_frf::Finding;
use chladni_linalg::{lstsq, solve_hermitian};
use ndarray::{Array2, Axis};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Poles of the visible peaks by their circles.
///
/// # Errors
/// A decomposition that fails.
pub(crate) fn circle(
    survey: &Survey,
    columns: &Compressed,
    options: &FitOptions,
) -> Result<MethodPoles, FitError> {
    let starts = picked(survey);
    let poles: Vec<Complex64> = starts
        .iter()
        .filter_map(|&start| common(&columns.work, start, &starts))
        .collect();
    let mut found = modes_of(survey, &poles, options, "circles around visible peaks")?;
    if poles.len() < starts.len() {
        found.warnings.push(Finding::caution(
            "no-circle",
            format!(
                "{} of {} peaks trace no circle and are left out",
                starts.len() - poles.len(),
                starts.len()
            ),
        ));
    }
    Ok(found)
}

/// Weighted median over the columns of what their circles say of the peak at `start`.
fn common(work: &Columns, start: Complex64, all: &[Complex64]) -> Option<Complex64> {
    // up to half way to the neighbours
    let window = work.window(start, ARC_HALF_WIDTHS, ARC_LEAST_LINES);
    let near = |x: f64| {
        all.iter()
            .all(|other| (x - start.re).abs() <= (x - other.re).abs())
    };
    let rows: Vec<usize> = window.filter(|&k| near(work.x[k])).collect();
    let x: Vec<f64> = rows.iter().map(|&k| work.x[k]).collect();
    let estimates: Vec<(Complex64, f64)> = work
        .b
        .axis_iter(Axis(1))
        .filter_map(|column| {
            resonance(
                &x,
                &rows
                    .iter()
                    .map(|&k| column[k] / work.g[k])
                    .collect::<Vec<_>>(),
                start,
            )
        })
        .collect();
    Some(Complex64::new(
        weighted_median(&estimates, |p| p.re)?,
        weighted_median(&estimates, |p| p.im)?,
    ))
}

fn weighted_median(estimates: &[(Complex64, f64)], of: impl Fn(Complex64) -> f64) -> Option<f64> {
    let mut sorted: Vec<(f64, f64)> = estimates
        .iter()
        .map(|(pole, weight)| (of(*pole), *weight))
        .collect();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * sorted.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut sum = 0.0;
    sorted
        .into_iter()
        .find(|(_, weight)| {
            sum += weight;
            sum >= half
        })
        .map(|(value, _)| value)
}

/// Pole of one circle, and its weight: (radius/misfit)².
fn resonance(x: &[f64], points: &[Complex64], start: Complex64) -> Option<(Complex64, f64)> {
    let (centre, radius) = kasa(points)?;
    let misfit = (points
        .iter()
        .map(|p| ((p - centre).norm() - radius).powi(2))
        .sum::<f64>()
        / points.len() as f64)
        .sqrt();
    if misfit > 2.0 * ROUND * radius {
        return None;
    }
    let angles: Vec<f64> = points.iter().map(|p| (p - centre).arg()).collect();
    let pole = from_angles(x, &angles, start)?;
    let inside = pole.re >= x[0] && pole.re <= x[x.len() - 1];
    inside.then(|| {
        (
            pole,
            (radius / misfit.max(CIRCLE_ROUNDING * radius)).powi(2),
        )
    })
}

/// Centre and radius that minimise Σ(|p|² − 2 Re c̄p + q)².
fn kasa(points: &[Complex64]) -> Option<(Complex64, f64)> {
    let scale = points.iter().map(|p| p.norm()).fold(0.0, f64::max);
    if points.len() < CIRCLE_LEAST_POINTS || scale == 0.0 {
        return None;
    }
    let unit: Vec<Complex64> = points.iter().map(|p| p / scale).collect();
    let a = Array2::from_shape_fn((unit.len(), 3), |(k, c)| {
        [2.0 * unit[k].re, 2.0 * unit[k].im, -1.0][c]
    });
    let b = Array2::from_shape_fn((unit.len(), 1), |(k, _)| unit[k].norm_sqr());
    let solution = lstsq(a.view(), b.view()).ok()?;
    let centre = Complex64::new(solution[[0, 0]], solution[[1, 0]]);
    let square = centre.norm_sqr() - solution[[2, 0]];
    (square > 0.0).then(|| (centre * scale, square.sqrt() * scale))
}

/// λ whose angle ψ − 2 arg(λ − x) follows `angles`, by Gauss–Newton from `start`.
fn from_angles(x: &[f64], angles: &[f64], start: Complex64) -> Option<Complex64> {
    let model = |pole: Complex64, x: f64| -2.0 * (pole - x).arg();
    let residual = |pole: Complex64, psi: f64, k: usize| {
        let difference = angles[k] - psi - model(pole, x[k]);
        difference - TAU * (difference / TAU).round()
    };
    let mut pole = start;
    let mut psi = angles
        .iter()
        .zip(x)
        .map(|(a, &x)| Complex64::from_polar(1.0, a - model(pole, x)))
        .sum::<Complex64>()
        .arg();
    for _ in 0..ANGLE_STEPS {
        let mut normal = Array2::<f64>::zeros((3, 3));
        let mut right = Array2::<f64>::zeros((3, 1));
        for k in 0..x.len() {
            // arg(λ − x) = Im log(λ − x)
            let slope = (pole - x[k]).inv();
            let gradient = [1.0, -2.0 * slope.im * pole.im, -2.0 * slope.re * pole.im];
            let r = residual(pole, psi, k);
            for i in 0..3 {
                right[[i, 0]] += gradient[i] * r;
                for j in 0..3 {
                    normal[[i, j]] += gradient[i] * gradient[j];
                }
            }
        }
        let step = solve_hermitian(normal.view(), right.view()).ok()?;
        let move_by = Complex64::new(step[[1, 0]], step[[2, 0]]) * pole.im;
        let short = (ANGLE_STEP * pole.im / move_by.norm()).min(1.0);
        pole += move_by * short;
        psi += step[[0, 0]] * short;
        if move_by.norm() < ANGLE_STILL * pole.im {
            break;
        }
    }
    (pole.is_finite() && pole.im > 0.0).then_some(pole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_mode_on_a_constant_is_exact() {
        let truth = Complex64::new(0.4, 0.006);
        let x: Vec<f64> = (0..40).map(|k| 0.385 + 0.0008 * k as f64).collect();
        let points: Vec<Complex64> = x
            .iter()
            .map(|&x| Complex64::new(0.3, -0.1) / (truth - x) + Complex64::new(-4.0, 2.5))
            .collect();
        let (centre, radius) = kasa(&points).unwrap();
        assert!(
            (radius - Complex64::new(0.3, -0.1).norm() / (2.0 * truth.im)).abs() < 1e-10 * radius
        );
        assert!(points
            .iter()
            .all(|p| ((p - centre).norm() - radius).abs() < 1e-10 * radius));
        let (pole, _) = resonance(&x, &points, Complex64::new(0.4015, 0.009)).unwrap();
        assert!((pole - truth).norm() < 1e-12, "{pole}");
    }

    #[test]
    fn noise_and_straight_lines_are_no_circles() {
        let x: Vec<f64> = (0..20).map(|k| 0.39 + 0.001 * k as f64).collect();
        let line: Vec<Complex64> = x.iter().map(|&x| Complex64::new(x, 2.0 * x)).collect();
        assert!(resonance(&x, &line, Complex64::new(0.4, 0.005)).is_none());
        assert!(resonance(
            &x,
            &vec![Complex64::default(); 20],
            Complex64::new(0.4, 0.005)
        )
        .is_none());
    }

    #[test]
    fn the_median_follows_the_weights() {
        let at = |re: f64, weight: f64| (Complex64::new(re, 1.0), weight);
        assert_eq!(
            weighted_median(&[at(3.0, 1.0), at(1.0, 1.0), at(2.0, 5.0)], |p| p.re),
            Some(2.0)
        );
        assert_eq!(weighted_median(&[], |p| p.re), None);
    }
}
