//! The columns of a common-pole model in the law of its lines, and their derivatives.

use crate::damping::filled::{fill, fill_terms};
use crate::data::columns::Columns;
use ndarray::{Array2, ShapeBuilder};
use num_complex::Complex64;

/// Powers of x of the residual terms: one lower (1/ω²), three upper (constant, ω², ω⁴).
pub(crate) const RESIDUAL_POWERS: [i32; 4] = [-1, 0, 1, 2];

/// Columns g/(λ_n − x), in the law of the lines, and g·x^p: the basis of a common-pole
/// model (theory.md, eq. 6).
pub(crate) fn basis(work: &Columns, lambda: &[Complex64], powers: &[i32]) -> Array2<Complex64> {
    let lines = work.lines();
    let mut a = Array2::zeros((lines, lambda.len() + powers.len()).f());
    let values = a.as_slice_memory_order_mut().unwrap_or_default();
    let (plain, terms) = values.split_at_mut(lambda.len() * lines);
    for (column, &pole) in plain.chunks_mut(lines.max(1)).zip(lambda) {
        fill(work, pole, column, None);
    }
    fill_terms(work, powers, terms);
    a
}

/// ∂/∂λ of the pole columns: −g/(λ_n − x)²; in the viscous law ∂/∂(j·Im λ).
pub(crate) fn basis_derivative(work: &Columns, lambda: &[Complex64]) -> Array2<Complex64> {
    let mut derivative = Array2::zeros((work.lines(), lambda.len()).f());
    let mut plain = vec![Complex64::ZERO; work.lines()];
    for (mut column, &pole) in derivative.columns_mut().into_iter().zip(lambda) {
        fill(work, pole, &mut plain, column.as_slice_mut());
    }
    derivative
}
