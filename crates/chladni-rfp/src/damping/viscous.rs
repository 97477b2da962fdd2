//! The columns of viscous modes with the residues that the file has (theory.md, eq. 16):
//! poles s and s* with residues r and r*, over the reals.
//!
//! α = Σ [r/(jω − s) + r*/(jω − s*)] is linear in Re r and Im r only over the reals, so
//! lines are stacked (real parts, then imaginary parts) and each mode has two real
//! columns. Frequencies are in units of ω_max: y = ω/ω_max = √x.

use crate::data::columns::{inverse, Columns};
use ndarray::{Array2, ShapeBuilder};
use num_complex::Complex64;

/// s = j√λ: the viscous pole of the same resonance. Using √Re λ instead is wrong by ζ².
pub(crate) fn from_structural(lambda: Complex64) -> Complex64 {
    Complex64::i() * lambda.sqrt()
}

fn stack_into(out: &mut Array2<f64>, column: usize, values: impl Iterator<Item = Complex64>) {
    let lines = out.nrows() / 2;
    let mut column = out.column_mut(column);
    let (re, im) = column
        .as_slice_mut()
        .expect("column-major")
        .split_at_mut(lines);
    for ((re, im), v) in re.iter_mut().zip(im).zip(values) {
        (*re, *im) = (v.re, v.im);
    }
}

/// Real parts of all lines over their imaginary parts.
pub(crate) fn halves(b: &Array2<Complex64>) -> Array2<f64> {
    let lines = b.nrows();
    Array2::from_shape_fn((2 * lines, b.ncols()).f(), |(row, c)| {
        let value = b[[row % lines, c]];
        if row < lines {
            value.re
        } else {
            value.im
        }
    })
}

/// What columns of the poles change by, stacked: per mode g·(u² + v²) and jg·(u² − v²), with
/// u and v of [`viscous_basis`]. Its columns c₁ and c₂ have ∂c₁/∂Re s = e₁, ∂c₂/∂Re s = e₂,
/// ∂c₁/∂Im s = e₂ and ∂c₂/∂Im s = −e₁.
pub(crate) fn pair_slopes(work: &Columns, poles: &[Complex64]) -> Array2<f64> {
    let mut slopes = Array2::zeros((2 * work.lines(), 2 * poles.len()).f());
    let j = Complex64::i();
    for (n, &pole) in poles.iter().enumerate() {
        let squares = || pair(work, pole).map(|(u, v, g)| (u * u * g, v * v * g));
        stack_into(&mut slopes, 2 * n, squares().map(|(u, v)| u + v));
        stack_into(&mut slopes, 2 * n + 1, squares().map(|(u, v)| j * (u - v)));
    }
    slopes
}

/// 1/(jy − s), 1/(jy − s*) and g, line by line.
fn pair(work: &Columns, pole: Complex64) -> impl Iterator<Item = (Complex64, Complex64, f64)> + '_ {
    work.x.iter().zip(&work.g).map(move |(&x, &g)| {
        let jy = Complex64::new(0.0, x.sqrt());
        (inverse(jy - pole), inverse(jy - pole.conj()), g)
    })
}

/// Stacked basis: per mode g·(u + v) and jg·(u − v) with u = 1/(jy − s), v = 1/(jy − s*);
/// then residual terms.
pub(crate) fn viscous_basis(work: &Columns, poles: &[Complex64], powers: &[i32]) -> Array2<f64> {
    let mut a = Array2::zeros((2 * work.lines(), 2 * (poles.len() + powers.len())).f());
    let j = Complex64::i();
    for (n, &pole) in poles.iter().enumerate() {
        let uv = || pair(work, pole).map(|(u, v, g)| (u * g, v * g));
        stack_into(&mut a, 2 * n, uv().map(|(u, v)| u + v));
        stack_into(&mut a, 2 * n + 1, uv().map(|(u, v)| j * (u - v)));
    }
    for (p, &power) in powers.iter().enumerate() {
        let column = 2 * (poles.len() + p);
        let term = || {
            work.x
                .iter()
                .zip(&work.g)
                .map(move |(&x, &g)| Complex64::new(g * x.powi(power), 0.0))
        };
        stack_into(&mut a, column, term());
        stack_into(&mut a, column + 1, term().map(|v| j * v));
    }
    a
}
