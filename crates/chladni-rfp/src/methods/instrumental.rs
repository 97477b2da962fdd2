//! Instrumental-variable and Gauss–Newton steps: from reweighted linear fits to the
//! likeliest poles.
//!
//! Reweighted equation errors keep a bias: the noise of B_l stands on both sides of their
//! normal equations. Here the left one is the model's own B̂_l, which the noise of the data
//! does not move in step (theory.md, eq. 60):
//!
//! ```text
//! Σ_l (B̂_l R)ᴴ (I − QQᴴ) (B_l R)(d₀ + δ) = 0,   δ and the test space normal to d₀
//! ```
//!
//! Where δ = 0 this is the gradient of the likelihood of the poles, residues eliminated:
//! the fixed point is the maximum-likelihood estimate, without partial fractions. With B̂_l
//! on both sides the steps are those of Gauss–Newton (Kaufman) and have the same fixed
//! point.
//!
//! P. C. Young, Automatica 6 (1970) 271–287 (instrumental variables); L. Kaufman, BIT 15
//! (1975) 49–57. Cost: twice a Sanathanan–Koerner step for the first, once for the second.

use crate::methods::fraction::{damped, Denominator, Fraction, Lines};
use chladni_linalg::{lstsq, matmul, matmul_h, qr_thin, LinalgError};
use ndarray::{s, Array2, ShapeBuilder};
use num_complex::Complex64;

/// A largest step, in half-bandwidths, that ends the iteration.
const CONVERGED: f64 = 1e-8;
/// Halvings of a step of Gauss–Newton that made the fit worse.
const HALVINGS: usize = 8;

/// Which steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Steps {
    /// The model's values as instruments.
    Instrumental,
    /// Gauss–Newton, halved where the fit gets worse.
    GaussNewton,
}

/// One point of the iteration.
struct Point {
    fraction: Fraction,
    /// Coefficients of the denominator itself.
    here: Vec<Complex64>,
    /// Step to the next one.
    step: Vec<Complex64>,
    /// What the numerators explain.
    explained: f64,
}

/// Poles λ after at most `most` steps from `start`.
///
/// # Errors
/// A decomposition that fails.
pub(crate) fn improved(
    lines: &Lines,
    start: &[Complex64],
    steps: Steps,
    most: usize,
) -> Result<Vec<Complex64>, LinalgError> {
    let mut lambda = start.to_vec();
    if lambda.is_empty() {
        return Ok(lambda);
    }
    let mut last: Option<Point> = None;
    let (mut taken, mut halved) = (0, 0);
    loop {
        let mut point = match Point::new(lines, &lambda, steps) {
            Ok(point) => point,
            // two poles in one place, or one that the lines do not see: no step says more
            Err(LinalgError::RankDeficient { .. }) => return Ok(lambda),
            Err(error) => return Err(error),
        };
        if let (Steps::GaussNewton, Some(before)) = (steps, &last) {
            if point.explained < before.explained && halved < HALVINGS {
                halved += 1;
                let part = 0.5f64.powi(halved as i32);
                lambda = before.next(lines, part)?;
                continue;
            }
        }
        if taken == most {
            return Ok(lambda);
        }
        (taken, halved) = (taken + 1, 0);
        let moved = point.next(lines, 1.0)?;
        let largest = largest_step(&lambda, &moved);
        lambda = moved;
        if largest < CONVERGED || lambda.is_empty() {
            return Ok(lambda);
        }
        if steps == Steps::Instrumental && taken == most {
            return Ok(lambda);
        }
        point.fraction.r = Array2::zeros((0, 0));
        last = Some(point);
    }
}

/// Largest way from a pole to the nearest of the next ones, in half-bandwidths.
fn largest_step(before: &[Complex64], after: &[Complex64]) -> f64 {
    before
        .iter()
        .map(|a| {
            after
                .iter()
                .map(|b| (a - b).norm() / a.im.abs().max(f64::MIN_POSITIVE))
                .fold(f64::INFINITY, f64::min)
        })
        .fold(0.0, f64::max)
}

impl Point {
    fn new(lines: &Lines, lambda: &[Complex64], steps: Steps) -> Result<Self, LinalgError> {
        let (plane, b) = (lines.plane, &lines.work.b);
        let known = Denominator::of(&lines.nodes, &plane.roots(lambda));
        let fraction = Fraction::new(lines, lambda.len(), &known)?;
        // a·B/|a| is where the numerators live
        let turned = by_line(b, |k| known.phase[k]);
        let coefficients = fraction.nearest(plane, &turned);
        let explained = coefficients.iter().map(|v| v.norm_sqr()).sum();
        let inside = fraction.values(plane, &coefficients);
        let model = by_line(&inside, |k| known.phase[k].conj());
        let here: Vec<Complex64> = fraction
            .denominators
            .columns
            .columns()
            .into_iter()
            .enumerate()
            .map(|(k, column)| {
                let sum: Complex64 = column
                    .iter()
                    .zip(&known.phase)
                    .zip(&lines.root_energy)
                    .map(|((t, phase), root)| phase * (t * root))
                    .sum();
                plane.in_field(plane.turn(k).conj() * sum)
            })
            .collect();
        let instruments = fraction.crossed(plane, &model);
        let d = Array2::from_shape_fn((here.len(), 1), |(k, _)| here[k]);
        let (a, right) = match steps {
            Steps::Instrumental => {
                let data = fraction.crossed(plane, b);
                let weight = line_products(&model, b);
                let a = fraction.reduced(plane, &weight, &instruments, &data);
                let right = matmul(a.view(), d.view());
                (a, right)
            }
            Steps::GaussNewton => {
                let weight = line_products(&model, &model);
                let a = fraction.reduced(plane, &weight, &instruments, &instruments);
                let residual = &turned - &inside;
                let gradient = line_products(&model, &residual);
                let right = Array2::from_shape_fn((here.len(), 1), |(k, _)| {
                    let sum: Complex64 = fraction
                        .r
                        .column(k)
                        .iter()
                        .zip(&gradient)
                        .map(|(r, v)| v * *r)
                        .sum();
                    plane.in_field(plane.turn(k).conj() * sum)
                });
                (a, right)
            }
        };
        let step = normal_to(&d, &a, &right)?;
        Ok(Self {
            fraction,
            here,
            step,
            explained,
        })
    }

    /// Poles after `part` of the step.
    fn next(&self, lines: &Lines, part: f64) -> Result<Vec<Complex64>, LinalgError> {
        let d: Vec<Complex64> = self
            .here
            .iter()
            .zip(&self.step)
            .map(|(d, step)| d + step * part)
            .collect();
        let roots = self.fraction.roots(lines.plane, &d)?;
        Ok(lines.plane.poles(&damped(&roots)))
    }
}

/// Rows multiplied by one factor each.
fn by_line(b: &Array2<Complex64>, factor: impl Fn(usize) -> Complex64) -> Array2<Complex64> {
    let mut out = Array2::zeros(b.dim().f());
    out.assign(b);
    for mut column in out.columns_mut() {
        for (k, v) in column.iter_mut().enumerate() {
            *v *= factor(k);
        }
    }
    out
}

/// Σ_l conj(a_l)·b_l of each line.
fn line_products(a: &Array2<Complex64>, b: &Array2<Complex64>) -> Vec<Complex64> {
    let mut sums = vec![Complex64::new(0.0, 0.0); a.nrows()];
    for (a, b) in a.columns().into_iter().zip(b.columns()) {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += a.conj() * b;
        }
    }
    sums
}

/// δ normal to d with Vᴴ(a·δ + right) = 0, V the space normal to d.
fn normal_to(
    d: &Array2<Complex64>,
    a: &Array2<Complex64>,
    right: &Array2<Complex64>,
) -> Result<Vec<Complex64>, LinalgError> {
    let n = d.nrows();
    // d beside the unit vectors: the rest of the orthonormal basis is normal to d
    let mut beside = Array2::zeros((n, n).f());
    beside.column_mut(0).assign(&d.column(0));
    let largest = (0..n)
        .max_by(|&i, &k| d[[i, 0]].norm().total_cmp(&d[[k, 0]].norm()))
        .unwrap_or(0);
    for (column, k) in (0..n).filter(|&k| k != largest).enumerate() {
        beside[[k, column + 1]] = Complex64::new(1.0, 0.0);
    }
    let (q, _) = qr_thin(beside.view())?;
    let space = q.slice(s![.., 1..]);
    let projected = matmul_h(space, matmul(a.view(), space).view());
    let along = lstsq(
        projected.view(),
        matmul_h(space, right.view()).mapv(|v| -v).view(),
    )?;
    Ok(matmul(space, along.view()).column(0).to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::damping::columns::{in_plane_of, viscous_pole_of};
    use crate::damping::structural::POWERS;
    use crate::data::options::FitOptions;
    use crate::data::screening::Screened;
    use crate::methods::plane::Plane;
    use crate::poles::refine::refined_poles;
    use chladni_frf::Damping;
    use chladni_plate::{Synthetic, SyntheticSet};
    use ndarray::Array1;
    use std::f64::consts::TAU;

    fn noisy(damping: Damping) -> SyntheticSet {
        let natural: Vec<f64> = (0..12).map(|n| 20.0 + 10.0 * f64::from(n)).collect();
        Synthetic {
            loss_factor: natural.iter().map(|f| 1.0 / f).collect(),
            natural_frequency_hz: natural,
            damping,
            responses: 6,
            references: 2,
            frequency_hz: Array1::linspace(12.0, 138.0, 800),
            snr_db: 40.0,
            ..Synthetic::default()
        }
        .build()
        .unwrap()
    }

    fn start(set: &SyntheticSet, omega_max: f64) -> Vec<Complex64> {
        set.truth
            .in_band_modes()
            .map(|mode| {
                let x = (TAU * mode.frequency_hz / omega_max).powi(2);
                Complex64::new(1.0, 1.02 * mode.loss_factor) * x
            })
            .collect()
    }

    fn apart(a: &[Complex64], b: &[Complex64]) -> f64 {
        assert_eq!(a.len(), b.len());
        largest_step(a, b)
    }

    #[test]
    fn the_fixed_point_is_that_of_maximum_likelihood() {
        let set = noisy(Damping::Structural);
        let data = Screened::new(&set.frf, &FitOptions::default()).unwrap();
        let work = data.work();
        let start = start(&set, data.omega_max);
        let likeliest = refined_poles(&work, &start, &POWERS, 50, 1e-11).unwrap();
        let lines = Lines::new(Plane::new(Damping::Structural, &work.x), &work);
        for (steps, most) in [(Steps::Instrumental, 8), (Steps::GaussNewton, 12)] {
            let found = improved(&lines, &start, steps, most).unwrap();
            let apart = apart(&likeliest, &found);
            assert!(apart < 1e-6, "{steps:?}: {apart:e}");
        }
    }

    #[test]
    fn and_in_the_viscous_law() {
        let set = noisy(Damping::Viscous);
        let data = Screened::new(&set.frf, &FitOptions::default()).unwrap();
        let work = data.work();
        let start = start(&set, data.omega_max);
        let viscous: Vec<Complex64> = start
            .iter()
            .filter_map(|pole| in_plane_of(Damping::Viscous, *pole))
            .collect();
        let lawful = work.clone().in_law(Damping::Viscous);
        let likeliest: Vec<Complex64> = refined_poles(&lawful, &viscous, &POWERS, 50, 1e-11)
            .unwrap()
            .into_iter()
            .map(|pole| -viscous_pole_of(pole).powi(2))
            .collect();
        let lines = Lines::new(Plane::new(Damping::Viscous, &work.x), &work);
        for (steps, most) in [(Steps::Instrumental, 8), (Steps::GaussNewton, 12)] {
            let found = improved(&lines, &start, steps, most).unwrap();
            // residual terms of one parity more leave the two a thousandth apart
            let apart = apart(&likeliest, &found);
            assert!(apart < 1e-2, "{steps:?}: {apart:e}");
        }
    }
}
