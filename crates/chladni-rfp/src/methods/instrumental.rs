//! Instrumental-variable and Gauss–Newton steps: from reweighted linear fits to the
//! likeliest poles.
//!
//! Reweighted equation errors keep a bias: the noise of B_l stands on both sides of their
//! normal equations. Here the left one is the model's own B̂_l, which the noise of the data
//! does not move in step (theory.md, eq. 71):
//!
//! ```text
//! Σ_l (B̂_l R)ᴴ (I − QQᴴ) (B_l R)(d₀ + δ) = 0,   δ and the test space normal to d₀
//! ```
//!
//! At δ = 0 this is the gradient of the likelihood of the poles, residues eliminated: the
//! fixed point is the maximum-likelihood estimate, without partial fractions. With B̂_l
//! on both sides the steps are those of Gauss–Newton (Kaufman) and have the same fixed
//! point.
//!
//! P. C. Young, Automatica 6 (1970) 271–287 (instrumental variables); L. Kaufman, BIT 15
//! (1975) 49–57. Cost: twice a Sanathanan–Koerner step for the first, once for the second.

use super::limits::{CONVERGED, LEAST_PART, ROUNDING};
use crate::methods::fraction::{damped, if_carried, Denominator, Fraction, Lines};
use chladni_linalg::{lstsq, matmul, matmul_h, qr_thin, LinalgError};
use ndarray::{s, Array2, ShapeBuilder};
use num_complex::Complex64;

/// The kind of steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Steps {
    /// The model's values as instruments.
    Instrumental,
    /// Gauss–Newton.
    GaussNewton,
}

/// Poles λ, and what their fraction knows of them.
pub(crate) struct Improved {
    /// Poles.
    pub lambda: Vec<Complex64>,
    /// Leading coefficient of the denominator over its length: where it is small the
    /// roots are rounding.
    pub leading: f64,
}

/// Poles after at most `most` steps from `start`, each halved while it explains less of
/// the data.
///
/// # Errors
/// A decomposition that fails.
pub(crate) fn improved(
    lines: &Lines,
    start: &[Complex64],
    steps: Steps,
    most: usize,
) -> Result<Improved, LinalgError> {
    let Some(mut here) = if_carried(Point::at(lines, start.to_vec()))? else {
        return Ok(Improved {
            lambda: start.to_vec(),
            leading: 0.0,
        });
    };
    for _ in 0..most {
        // two poles in one place, or one that the lines do not see: no step says more
        let Some(next) = if_carried(here.next(lines, steps))? else {
            break;
        };
        let converged = largest_step(&here.lambda, &next.lambda) < CONVERGED;
        here = next;
        if converged {
            break;
        }
    }
    Ok(here.ended())
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

/// One point of the iteration.
struct Point {
    lambda: Vec<Complex64>,
    fraction: Fraction,
    /// Coefficients of the denominator itself, one column.
    here: Array2<Complex64>,
    /// a/|a| on the lines.
    phase: Vec<Complex64>,
    /// a·B/|a|, where the numerators live, and its part in their space.
    turned: Array2<Complex64>,
    inside: Array2<Complex64>,
    /// Energy of that part.
    explained: f64,
}

impl Point {
    fn at(lines: &Lines, lambda: Vec<Complex64>) -> Result<Self, LinalgError> {
        let plane = lines.plane;
        let known = Denominator::of(&lines.nodes, &plane.roots(&lambda));
        let fraction = Fraction::new(lines, lambda.len(), &known)?;
        let turned = by_line(&lines.work.b, |k| known.phase[k]);
        let coefficients = fraction.nearest(plane, &turned);
        let itself: Vec<Complex64> = known
            .phase
            .iter()
            .zip(&lines.energy)
            .map(|(phase, energy)| phase * *energy)
            .collect();
        Ok(Self {
            here: fraction.along_denominators(plane, &itself),
            inside: fraction.values(plane, &coefficients),
            explained: coefficients.iter().map(|v| v.norm_sqr()).sum(),
            turned,
            phase: known.phase,
            fraction,
            lambda,
        })
    }

    /// The point after a step, halved while it explains less.
    fn next(&self, lines: &Lines, steps: Steps) -> Result<Self, LinalgError> {
        let step = self.step(lines, steps)?;
        let mut part = 1.0;
        loop {
            let next = Self::at(lines, self.moved(lines, &step, part)?)?;
            let worse = next.explained < (1.0 - ROUNDING) * self.explained;
            if !worse || part < LEAST_PART {
                return Ok(next);
            }
            part *= 0.5;
        }
    }

    /// Step of the coefficients.
    fn step(&self, lines: &Lines, steps: Steps) -> Result<Array2<Complex64>, LinalgError> {
        let (plane, b) = (lines.plane, &lines.work.b);
        let model = by_line(&self.inside, |k| self.phase[k].conj());
        let instruments = self.fraction.crossed(plane, &model);
        let (a, right) = match steps {
            Steps::Instrumental => {
                let data = self.fraction.crossed(plane, b);
                let weight = line_products(&model, b);
                let a = self.fraction.reduced(plane, &weight, &instruments, &data);
                let right = matmul(a.view(), self.here.view());
                (a, right)
            }
            Steps::GaussNewton => {
                let weight = line_products(&model, &model);
                let a = self
                    .fraction
                    .reduced(plane, &weight, &instruments, &instruments);
                let gradient = line_products(&model, &(&self.turned - &self.inside));
                (a, self.fraction.along_denominators(plane, &gradient))
            }
        };
        normal_to(&self.here, &a, &right)
    }

    /// Poles after `part` of a step.
    fn moved(
        &self,
        lines: &Lines,
        step: &Array2<Complex64>,
        part: f64,
    ) -> Result<Vec<Complex64>, LinalgError> {
        let d: Vec<Complex64> = self
            .here
            .iter()
            .zip(step)
            .map(|(d, step)| d + step * part)
            .collect();
        let roots = self.fraction.roots(lines.plane, &d)?;
        Ok(lines.plane.poles(&damped(&roots)))
    }

    fn ended(self) -> Improved {
        let length = self.here.iter().map(|d| d.norm_sqr()).sum::<f64>().sqrt();
        let last = self.here.iter().last().map_or(0.0, |d| d.norm());
        Improved {
            leading: last / length,
            lambda: self.lambda,
        }
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
) -> Result<Array2<Complex64>, LinalgError> {
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
    Ok(matmul(space, along.view()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::damping::basis::RESIDUAL_POWERS;
    use crate::damping::plane::Plane;
    use crate::data::options::FitOptions;
    use crate::data::screening::Screened;
    use crate::methods::synthetic::even;
    use crate::poles::refine::refined_poles;
    use crate::tolerances::Precision;
    use chladni_frf::Damping;
    use chladni_plate::SyntheticSet;
    use std::f64::consts::TAU;

    const LAST_DIGITS: Precision = Precision {
        steps: 50,
        tolerance: 1e-11,
    };

    fn noisy(damping: Damping) -> SyntheticSet {
        even(12, 40.0, damping, 1)
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
        let likeliest = refined_poles(&work, &start, &RESIDUAL_POWERS, LAST_DIGITS).unwrap();
        let lines = Lines::new(Plane::new(Damping::Structural, &work.x), &work);
        for (steps, most) in [(Steps::Instrumental, 8), (Steps::GaussNewton, 12)] {
            let found = improved(&lines, &start, steps, most).unwrap().lambda;
            let apart = apart(&likeliest, &found);
            assert!(apart < 1e-6, "{steps:?}: {apart:e}");
        }
    }

    #[test]
    fn a_small_leading_coefficient_tells_of_lost_digits() {
        let set = noisy(Damping::Structural);
        let data = Screened::new(&set.frf, &FitOptions::default()).unwrap();
        let work = data.work();
        let lines = Lines::new(Plane::new(Damping::Structural, &work.x), &work);
        let leading = |poles: &[Complex64]| {
            let ended = improved(&lines, poles, Steps::Instrumental, 0).unwrap();
            ended.leading
        };
        let mut poles = start(&set, data.omega_max);
        assert!(leading(&poles) > 1e-3);
        poles.push(Complex64::new(5e3, 1.0)); // five thousand bands away
        assert!(leading(&poles) < 1e-3);
    }

    #[test]
    fn and_in_the_viscous_law() {
        let set = noisy(Damping::Viscous);
        let data = Screened::new(&set.frf, &FitOptions::default()).unwrap();
        let work = data.work().in_law(Damping::Viscous);
        let start = start(&set, data.omega_max);
        let likeliest = refined_poles(&work, &start, &RESIDUAL_POWERS, LAST_DIGITS).unwrap();
        let lines = Lines::new(Plane::new(Damping::Viscous, &work.x), &work);
        for (steps, most) in [(Steps::Instrumental, 8), (Steps::GaussNewton, 12)] {
            let found = improved(&lines, &start, steps, most).unwrap().lambda;
            // residual terms of one parity more leave the two a thousandth apart
            let apart = apart(&likeliest, &found);
            assert!(apart < 1e-2, "{steps:?}: {apart:e}");
        }
    }
}
