//! The ground in time: exact recursion of each pole under drives that run from sample to
//! sample by the cubic of their values and derivatives (theory.md, eq. 62).

use crate::time::causal::{CausalModel, Follower, Ground};
use crate::tolerances::{SMALL_STEP, TERMS};
use chladni_linalg::matmul;
use ndarray::Array2;
use num_complex::Complex64;

/// Complex envelopes of a drive on even samples: a(t_k) = Σ_b values[k, b]·patterns[b].
#[derive(Debug, Clone)]
pub(crate) struct SampledDrive {
    /// Time from sample to sample, s.
    pub(crate) step_s: f64,
    /// The patterns that the envelopes multiply; axes (pattern, actuator).
    pub(crate) patterns: Array2<Complex64>,
    /// Axes (time, pattern).
    pub(crate) values: Array2<Complex64>,
    /// Their derivatives, 1/s; same axes.
    pub(crate) slopes: Array2<Complex64>,
    /// Their second derivatives, 1/s²; same axes.
    pub(crate) bends: Array2<Complex64>,
}

/// A model in motion: takes a drive block by block.
pub(crate) struct Motion<'a> {
    model: &'a CausalModel,
    ground: Ground,
    /// z of each pole, and what drove it at the last sample, with its derivative.
    states: Vec<[Complex64; 3]>,
}

impl<'a> Motion<'a> {
    /// At rest.
    pub(crate) fn new(model: &'a CausalModel) -> Self {
        Self {
            model,
            ground: model.ground(),
            states: vec![[Complex64::ZERO; 3]; model.poles.len()],
        }
    }

    /// v⁺ of the rows over the samples that follow the last block, m/s; axes (time, row).
    ///
    /// ż = (p − jω₀)·z + r·Lᵀa of each pole, v⁺ = Σψz + D₀a + D₁ȧ + D₂ä.
    pub(crate) fn under(&mut self, drive: &SampledDrive) -> Array2<Complex64> {
        let states = self.modal(drive);
        let follower = |course, at_once: &Array2<Complex64>| Follower {
            course,
            fields: matmul(drive.patterns.view(), at_once.t()),
        };
        let followers = [
            follower(&drive.values, &self.model.direct),
            follower(&drive.slopes, &self.model.slope),
            follower(&drive.bends, &self.model.bend),
        ];
        self.ground.moved(states.view(), &followers)
    }

    /// z over the samples; axes (pole, time).
    fn modal(&mut self, drive: &SampledDrive) -> Array2<Complex64> {
        let forces = matmul(self.model.inputs.view(), drive.patterns.t());
        let mut states = matmul(forces.view(), drive.values.t());
        let slopes = matmul(forces.view(), drive.slopes.t());
        let rows = states.rows_mut().into_iter().zip(slopes.rows());
        for (n, ((mut row, slopes), known)) in rows.zip(&mut self.states).enumerate() {
            let step = CubicStep::new(-self.model.distance(n), drive.step_s);
            let [mut z, mut before, mut rising] = *known;
            for (value, slope) in row.iter_mut().zip(slopes) {
                // apart from z, so that steps overlap
                let added = step.of(before, rising, *value, *slope);
                (before, rising) = (*value, *slope);
                z = step.decay * z + added;
                *value = z;
            }
            *known = [z, before, rising];
        }
        states
    }
}

/// One step of a pole under forces that run straight: z⁺ = decay·z + last·u_k +
/// next·u_{k+1}.
pub(crate) struct Step {
    pub(crate) decay: Complex64,
    pub(crate) last: Complex64,
    pub(crate) next: Complex64,
}

impl Step {
    /// With λ = `rate` rad/s and steps of h s: e^{λh}, h(φ₁ − φ₂), hφ₂.
    pub(crate) fn new(rate: Complex64, step_s: f64) -> Self {
        let [decay, first, second, ..] = exponentials(rate * step_s);
        Self {
            decay,
            last: (first - second) * step_s,
            next: second * step_s,
        }
    }
}

/// One step of a pole under forces that run by the cubic of their values and derivatives at
/// both ends.
pub(crate) struct CubicStep {
    pub(crate) decay: Complex64,
    /// Of the value and the derivative before, and of those after.
    last: [Complex64; 2],
    next: [Complex64; 2],
}

impl CubicStep {
    /// ∫₀¹e^{λh(1−s)}sᵐds = m!·φ_{m+1} with the cubics of Hermite.
    pub(crate) fn new(rate: Complex64, step_s: f64) -> Self {
        let [decay, flat, straight, half, sixth] = exponentials(rate * step_s);
        let (square, cube) = (half * 2.0, sixth * 6.0);
        let risen = square * 3.0 - cube * 2.0;
        let slope = step_s * step_s;
        Self {
            decay,
            last: [
                (flat - risen) * step_s,
                (cube - square * 2.0 + straight) * slope,
            ],
            next: [risen * step_s, (cube - square) * slope],
        }
    }

    /// The part that a force adds which runs from `before` with the derivative `rising` to
    /// `after` with the derivative `then`.
    pub(crate) fn of(
        &self,
        before: Complex64,
        rising: Complex64,
        after: Complex64,
        then: Complex64,
    ) -> Complex64 {
        self.last[0] * before + self.last[1] * rising + self.next[0] * after + self.next[1] * then
    }
}

/// e^x and φ₁ to φ₄: φ_k = Σ x^j/(j+k)!.
fn exponentials(x: Complex64) -> [Complex64; 5] {
    let mut phi = [x.exp(); 5];
    let mut factorial = 1.0;
    if x.norm() < SMALL_STEP {
        let mut term = Complex64::from(1.0 / 24.0);
        phi[4] = term;
        for j in 1..TERMS {
            term *= x / f64::from(j + 4);
            phi[4] += term;
        }
        for (k, inverse) in [(3, 1.0 / 6.0), (2, 0.5), (1, 1.0)] {
            phi[k] = x * phi[k + 1] + inverse;
        }
        return phi;
    }
    for k in 1..5 {
        phi[k] = (phi[k - 1] - 1.0 / factorial) / x;
        factorial *= k as f64;
    }
    phi
}

#[cfg(test)]
mod tests;
