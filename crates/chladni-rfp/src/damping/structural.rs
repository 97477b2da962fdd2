//! Columns of a common-pole model in the plane x: g/(λ_n − x) and their derivatives in the
//! structural law, where they are complex-analytic in the poles, and what stands for them
//! in the viscous one.

use crate::damping::columns::{loss, resonance, Leaking};
use crate::data::columns::Columns;
use ndarray::{Array2, ShapeBuilder};
use num_complex::Complex64;

/// Powers of x of the residual terms: one lower (1/ω²), three upper (constant, ω², ω⁴).
pub(crate) const POWERS: [i32; 4] = [-1, 0, 1, 2];

/// Columns g/(λ_n − x), in the law of the lines, and g·x^p: the basis of a common-pole
/// model (theory.md, eq. 6).
pub(crate) fn basis(work: &Columns, lambda: &[Complex64], powers: &[i32]) -> Array2<Complex64> {
    let mut a = Array2::zeros((work.lines(), lambda.len() + powers.len()).f());
    for (mut column, &pole) in a.columns_mut().into_iter().zip(lambda) {
        let column = column.as_slice_mut().expect("column-major");
        let lines = column.iter_mut().zip(&work.x).zip(&work.g);
        match &work.leakage {
            None => lines.for_each(|((value, &x), &g)| *value = resonance(work.law, pole, x) * g),
            Some(leakage) => {
                let leaking = Leaking::new(work.law, leakage, pole);
                lines.for_each(|((value, &x), &g)| *value = leaking.at(x)[0] * g);
            }
        }
    }
    for (p, &power) in powers.iter().enumerate() {
        let column = a.column_mut(lambda.len() + p);
        for ((value, &x), &g) in column.into_iter().zip(&work.x).zip(&work.g) {
            *value = Complex64::new(g * x.powi(power), 0.0);
        }
    }
    a
}

/// ∂/∂λ of the pole columns: −g/(λ_n − x)²; in the viscous law ∂/∂(j·Im λ).
pub(crate) fn basis_derivative(work: &Columns, lambda: &[Complex64]) -> Array2<Complex64> {
    let mut d = Array2::zeros((work.lines(), lambda.len()).f());
    for (mut column, &pole) in d.columns_mut().into_iter().zip(lambda) {
        let column = column.as_slice_mut().expect("column-major");
        let lines = column.iter_mut().zip(&work.x).zip(&work.g);
        match &work.leakage {
            None => lines.for_each(|((value, &x), &g)| {
                let resonance = resonance(work.law, pole, x);
                *value = resonance * resonance * (-g * loss(work.law, pole, x));
            }),
            Some(leakage) => {
                let leaking = Leaking::new(work.law, leakage, pole);
                lines.for_each(|((value, &x), &g)| *value = leaking.at(x)[1] * g);
            }
        }
    }
    d
}
