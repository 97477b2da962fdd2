//! A model as a causal system about its carrier: poles, what drives them, how they move
//! the ground, and what follows at once (theory.md, eq. 60 and 61).
//!
//! Structural damping answers before it is asked: its second pole lies on the wrong side.
//! Each mode therefore has the conjugate pair p, p* with p = jω_n√(1+jη_n), or the
//! viscous s_n; what runs like 1/ω², as a free panel does as a whole, has poles at rest.
//! The rest of the response at the carrier is D₀, D₁ and D₂, so that a
//! steady drive moves the ground exactly as `render` says.

use crate::panel::interpolation::Interpolation;
use crate::panel::kernel_error::unsolvable;
use crate::panel::operator::Operator;
use crate::tolerances;
use chladni_frf::{Damping, ModalModel, Mode, Result, Trust};
use chladni_linalg::{matmul, svd_thin};
use ndarray::{concatenate, s, Array2, ArrayView2, Axis, Zip};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// A model at the rows and actuators of an operator, about the carrier.
#[derive(Debug, Clone)]
pub(crate) struct CausalModel {
    /// ω₀, rad/s.
    pub(crate) carrier_rad_per_s: f64,
    /// p of every mode, then p* of every mode, rad/s.
    pub(crate) poles: Vec<Complex64>,
    /// r·L of each pole; axes (pole, actuator).
    pub(crate) inputs: Array2<Complex64>,
    /// ψ of each pole, ψ* of the second half; axes (row, pole).
    pub(crate) shapes: Array2<Complex64>,
    /// D₀; axes (row, actuator).
    pub(crate) direct: Array2<Complex64>,
    /// D₁: velocity per rate of change of the drive; same axes.
    pub(crate) slope: Array2<Complex64>,
    /// D₂: velocity per second derivative of the drive; same axes.
    pub(crate) bend: Array2<Complex64>,
}

impl CausalModel {
    /// Of `model`, whose mobility at the carrier is `operator`.
    ///
    /// # Errors
    /// Those of the factorisation: a broken promise.
    pub(crate) fn new(model: &ModalModel, operator: &Operator) -> Result<Self> {
        let carrier = TAU * operator.frequency_hz;
        let rest = Rest::of(model, operator)?;
        let (near, inputs, shapes) = of_modes(model, operator);
        let at_rest = vec![Complex64::ZERO; rest.inputs.nrows()];
        let near: Vec<Complex64> = near.into_iter().chain(at_rest).collect();
        let inputs = concatenate![Axis(0), inputs, rest.inputs];
        let shapes = concatenate![Axis(1), shapes, rest.shapes];
        let conjugate = |matrix: &Array2<Complex64>| matrix.mapv(|value| value.conj());
        let mut causal = Self {
            carrier_rad_per_s: carrier,
            poles: near
                .iter()
                .copied()
                .chain(near.iter().map(Complex64::conj))
                .collect(),
            inputs: concatenate![Axis(0), inputs, conjugate(&inputs)],
            shapes: concatenate![Axis(1), shapes, conjugate(&shapes)],
            direct: Array2::zeros((0, 0)),
            slope: rest.slope,
            bend: rest.bend,
        };
        causal.direct = &operator.mobility - &causal.of_poles(0..causal.poles.len(), 1);
        // the rest is a real system, too: what turns it is a slope through 0 Hz
        let turning = &causal.direct - &rest.direct;
        let slope = turning.mapv(|value| Complex64::from(value.im / carrier));
        causal.slope += &slope;
        Ok(causal)
    }

    /// Number of modes: half of the poles.
    pub(crate) fn modes(&self) -> usize {
        self.poles.len() / 2
    }

    /// Σψ·r·L/(jω₀ − p)^power over some of the poles; axes (row, actuator).
    pub(crate) fn of_poles(
        &self,
        poles: impl IntoIterator<Item = usize>,
        power: i32,
    ) -> Array2<Complex64> {
        let picked: Vec<usize> = poles.into_iter().collect();
        let mut inputs = self.inputs.select(Axis(0), &picked);
        for (mut row, &n) in inputs.rows_mut().into_iter().zip(&picked) {
            let factor = self.distance(n).powi(-power);
            row.mapv_inplace(|value| value * factor);
        }
        let shapes = self.shapes.select(Axis(1), &picked);
        matmul(shapes.view(), inputs.view())
    }

    /// True for poles of what moves as a whole, which only the actuators know.
    pub(crate) fn is_at_rest(&self, pole: usize) -> bool {
        self.poles[pole] == Complex64::ZERO
    }

    /// jω₀ − p of a pole, rad/s.
    pub(crate) fn distance(&self, pole: usize) -> Complex64 {
        Complex64::new(0.0, self.carrier_rad_per_s) - self.poles[pole]
    }

    /// The same model seen at other places.
    pub(crate) fn at(&self, places: &Interpolation) -> Self {
        let there = |here: &Array2<Complex64>| places.apply(here.view());
        Self {
            shapes: there(&self.shapes),
            direct: there(&self.direct),
            slope: there(&self.slope),
            bend: there(&self.bend),
            carrier_rad_per_s: self.carrier_rad_per_s,
            poles: self.poles.clone(),
            inputs: self.inputs.clone(),
        }
    }

    /// Σψz: how `states`, axes (pole, time), move the rows; axes (time, row).
    pub(crate) fn moved(&self, states: ArrayView2<Complex64>) -> Array2<Complex64> {
        self.ground().moved(states, &[])
    }

    /// The rows as [`Ground`], for many blocks of states.
    pub(crate) fn ground(&self) -> Ground {
        Ground {
            shapes: self.real_shapes(),
            modes: self.modes(),
        }
    }

    /// ψᴴp: the adjoint of [`Self::moved`], of `pull` with the axes (row, time); axes
    /// (pole, time).
    pub(crate) fn pulled(&self, pull: ArrayView2<Complex64>) -> Array2<Complex64> {
        let (modes, times) = (self.modes(), pull.ncols());
        let shapes = self.real_shapes();
        let parts = Array2::from_shape_fn((pull.nrows(), 2 * times), |(row, k)| {
            if k < times {
                pull[[row, k]].re
            } else {
                pull[[row, k - times]].im
            }
        });
        let pulled = matmul(shapes.t(), parts.view());
        let of =
            |part: usize, k: usize| Complex64::new(pulled[[part, k]], pulled[[part, times + k]]);
        Array2::from_shape_fn((2 * modes, times), |(pole, k)| {
            let real = of(pole % modes, k);
            if shapes.ncols() == modes {
                return real;
            }
            let turned = Complex64::I * of(modes + pole % modes, k);
            if pole < modes {
                real - turned
            } else {
                real + turned
            }
        })
    }

    /// Re ψ of every mode, and beside it Im ψ unless all of it is zero; axes (row, part).
    fn real_shapes(&self) -> Array2<f64> {
        let shapes = self.shapes.slice(s![.., ..self.modes()]);
        let real = shapes.mapv(|value| value.re);
        if shapes.iter().all(|value| value.im == 0.0) {
            return real;
        }
        concatenate![Axis(1), real, shapes.mapv(|value| value.im)]
    }

    /// Rms of the shape of a mode over the rows.
    pub(crate) fn rms_shape(&self, mode: usize) -> f64 {
        let column = self.shapes.column(mode);
        let sum: f64 = column.iter().map(Complex64::norm_sqr).sum();
        (sum / column.len() as f64).sqrt()
    }

    /// Velocity of the rows under steady `patterns`; axes (row, pattern).
    pub(crate) fn steady(&self, patterns: ArrayView2<Complex64>) -> Array2<Complex64> {
        let mobility = &self.direct + &self.of_poles(0..self.poles.len(), 1);
        matmul(mobility.view(), patterns.t())
    }
}

/// The rows of a model, moved by one product of real matrices.
pub(crate) struct Ground {
    /// Re ψ, and beside it Im ψ unless all of it is zero; axes (row, part).
    shapes: Array2<f64>,
    modes: usize,
}

/// The part that follows its course at once.
pub(crate) struct Follower<'a> {
    /// Axes (time, pattern).
    pub(crate) course: &'a Array2<Complex64>,
    /// Velocity of the rows under each pattern; axes (pattern, row).
    pub(crate) fields: Array2<Complex64>,
}

impl Ground {
    /// Σψz + Σ course·field: how `states`, axes (pole, time), and `followers` move the
    /// rows; axes (time, row).
    ///
    /// Poles come in pairs, ψz + ψ*z' = Re ψ·(z + z') + j·Im ψ·(z − z'): a product of real
    /// matrices, half of it where all shapes are real.
    pub(crate) fn moved(
        &self,
        states: ArrayView2<Complex64>,
        followers: &[Follower],
    ) -> Array2<Complex64> {
        let (modes, times) = (self.modes, states.ncols());
        let (rows, own) = self.shapes.dim();
        let patterns: usize = followers.iter().map(|each| each.fields.nrows()).sum();
        let mut parts = Array2::<f64>::zeros((own + 2 * patterns, 2 * times));
        for n in 0..modes {
            let pairs = states.row(n).into_iter().zip(states.row(n + modes));
            for (k, (z, mirrored)) in pairs.enumerate() {
                let (sum, difference) = (z + mirrored, z - mirrored);
                parts[[n, k]] = sum.re;
                parts[[n, times + k]] = sum.im;
                if own > modes {
                    parts[[modes + n, k]] = -difference.im;
                    parts[[modes + n, times + k]] = difference.re;
                }
            }
        }
        let mut shapes = Array2::zeros((own + 2 * patterns, rows));
        shapes.slice_mut(s![..own, ..]).assign(&self.shapes.t());
        let each = followers.iter().flat_map(|follower| {
            let columns = follower.course.columns().into_iter();
            columns.zip(follower.fields.rows())
        });
        for (at, (course, field)) in (own..).step_by(2).zip(each) {
            for (k, value) in course.iter().enumerate() {
                (parts[[at, k]], parts[[at, times + k]]) = (value.re, value.im);
                (parts[[at + 1, k]], parts[[at + 1, times + k]]) = (-value.im, value.re);
            }
            for (row, value) in field.iter().enumerate() {
                (shapes[[at, row]], shapes[[at + 1, row]]) = (value.re, value.im);
            }
        }
        let moved = matmul(parts.t(), shapes.view());
        let (real, imaginary) = moved.view().split_at(Axis(0), times);
        Zip::from(real)
            .and(imaginary)
            .map_collect(|&re, &im| Complex64::new(re, im))
    }
}

/// p of a mode, rad/s, in the upper half plane.
fn pole(mode: &Mode, damping: Damping) -> Complex64 {
    match damping {
        Damping::Structural => {
            let root = Complex64::new(1.0, mode.loss_factor).sqrt();
            Complex64::new(0.0, TAU * mode.frequency_hz) * root
        }
        Damping::Viscous => mode.viscous_pole(),
    }
}

/// r = p/(p − p*): what a unit of modal force adds to the velocity of this pole. A pole
/// at rest shares with its conjugate.
pub(crate) fn share(pole: Complex64) -> Complex64 {
    if pole.im == 0.0 {
        return Complex64::from(0.5);
    }
    pole / Complex64::new(0.0, 2.0 * pole.im)
}

/// Poles of the modes, what drives them and how they move the rows.
fn of_modes(
    model: &ModalModel,
    operator: &Operator,
) -> (Vec<Complex64>, Array2<Complex64>, Array2<Complex64>) {
    let modes: Vec<&Mode> = model
        .modes
        .iter()
        .filter(|mode| mode.trust != Trust::Rejected)
        .collect();
    let (rows, columns) = (&operator.response_rows, &operator.reference_columns);
    let poles: Vec<Complex64> = modes.iter().map(|mode| pole(mode, model.damping)).collect();
    let inputs = Array2::from_shape_fn((modes.len(), columns.len()), |(n, j)| {
        share(poles[n]) * modes[n].participation.0[columns[j]]
    });
    let sign = |i: usize| operator.responses[i].direction.sign();
    let shapes = Array2::from_shape_fn((rows.len(), modes.len()), |(i, n)| {
        modes[n].shape.0[rows[i]] * sign(i)
    });
    (poles, inputs, shapes)
}

/// The residual terms of a model: those like 1/ω² as poles at rest, the others to second
/// order about the carrier.
struct Rest {
    /// Of half of the poles; axes (pole, actuator).
    inputs: Array2<Complex64>,
    /// Axes (row, pole).
    shapes: Array2<Complex64>,
    /// Velocity at the carrier of what has no pole; axes (row, actuator).
    direct: Array2<Complex64>,
    /// Its derivative by s: Σ (power+1)·C·(ω₀/ω_s)^power.
    slope: Array2<Complex64>,
    /// Half of its second derivative: Σ (power+1)·power/(2jω₀)·C·(ω₀/ω_s)^power.
    bend: Array2<Complex64>,
}

impl Rest {
    fn of(model: &ModalModel, operator: &Operator) -> Result<Self> {
        let carrier = TAU * operator.frequency_hz;
        let scale = model.residual_terms.omega_scale_rad_per_s;
        let (rows, actuators) = operator.mobility.dim();
        let mut rest = Self {
            inputs: Array2::zeros((0, actuators)),
            shapes: Array2::zeros((rows, 0)),
            direct: Array2::zeros((rows, actuators)),
            slope: Array2::zeros((rows, actuators)),
            bend: Array2::zeros((rows, actuators)),
        };
        for term in &model.residual_terms.terms {
            let mut matrix = Array2::from_shape_fn((rows, actuators), |(i, j)| {
                let at = [operator.response_rows[i], operator.reference_columns[j]];
                term.matrix.0[at] * operator.responses[i].direction.sign()
            });
            if term.power == -2 {
                matrix -= &rest.take_poles(&matrix, scale)?;
            }
            let here = (carrier / scale).powi(term.power);
            let slope = f64::from(term.power + 1) * here;
            rest.direct += &matrix.mapv(|value| Complex64::I * (carrier * here) * value);
            rest.slope += &matrix.mapv(|value| value * slope);
            let bend = Complex64::new(0.0, -0.5 * f64::from(term.power) * slope / carrier);
            rest.bend += &matrix.mapv(|value| value * bend);
        }
        Ok(rest)
    }

    /// Makes −ω_s²·C/s of poles at rest, as many as matter, and says what part of C they
    /// are.
    fn take_poles(
        &mut self,
        matrix: &Array2<Complex64>,
        scale_rad_per_s: f64,
    ) -> Result<Array2<Complex64>> {
        let real = matrix.mapv(|value| value.re);
        let (left, singular, right) = svd_thin(real.view()).map_err(unsolvable)?;
        let least = tolerances::REST_POLE * singular.first().copied().unwrap_or(0.0);
        let count = singular.iter().filter(|&&value| value > least).count();
        let mut left = left.slice_move(s![.., ..count]);
        for (mut column, size) in left.columns_mut().into_iter().zip(&singular) {
            column.mapv_inplace(|value| value * size);
        }
        let right = right.slice_move(s![..count, ..]);
        let half = share(Complex64::ZERO);
        let inputs = right.mapv(|value| value * half);
        let shapes = left.mapv(|value| Complex64::from(-scale_rad_per_s.powi(2) * value));
        self.inputs = concatenate![Axis(0), self.inputs, inputs];
        self.shapes = concatenate![Axis(1), self.shapes, shapes];
        Ok(matmul(left.view(), right.view()).mapv(Complex64::from))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_linalg::matmul_h;

    #[test]
    fn pairs_move_the_rows_as_all_poles_do() {
        let some = |seed: f64, dim: (usize, usize)| {
            Array2::from_shape_fn(dim, |(i, j)| {
                Complex64::from_polar(1.0, seed * (3 * i + 5 * j + 1) as f64)
            })
        };
        let conjugate = |matrix: &Array2<Complex64>| matrix.mapv(|value| value.conj());
        let complex = some(0.7, (5, 3));
        let real = complex.mapv(|value| Complex64::from(value.re));
        for shapes in [complex, real] {
            let poles = [Complex64::new(-9.0, 1800.0); 3];
            let model = CausalModel {
                carrier_rad_per_s: 1885.0,
                poles: poles
                    .iter()
                    .copied()
                    .chain(poles.iter().map(Complex64::conj))
                    .collect(),
                inputs: Array2::zeros((6, 2)),
                shapes: concatenate![Axis(1), shapes, conjugate(&shapes)],
                direct: Array2::zeros((5, 2)),
                slope: Array2::zeros((5, 2)),
                bend: Array2::zeros((5, 2)),
            };
            let (states, pull) = (some(1.3, (6, 4)), some(0.4, (5, 4)));
            let apart = |a: Array2<Complex64>, b: Array2<Complex64>| {
                (a - b).iter().map(|value| value.norm()).fold(0.0, f64::max)
            };
            let slow = matmul(model.shapes.view(), states.view());
            assert!(apart(model.moved(states.view()), slow.reversed_axes()) < 1e-13);
            let slow = matmul_h(model.shapes.view(), pull.view());
            assert!(apart(model.pulled(pull.view()), slow) < 1e-13);
        }
    }
}
