//! Sanathanan–Koerner steps: the linear fit repeated with the weight 1/|a|² of the
//! denominator before, on polynomials made anew for each weight.
//!
//! The linear equation error d·B − N weights every line with |a|², which spans ten decades
//! over a band of twelve modes: the fit looks where modes are not. Divided by the |a| of
//! the step before, it becomes the error of the measured values as the steps converge
//! (theory.md, eq. 59). The scale of d is fixed by the mean of d/a instead of its leading
//! coefficient (relaxed), so that noise pulls it nowhere.
//!
//! On a basis that is made once, the same steps fail: the polynomials that were orthonormal
//! for one weight are all but parallel for the next. A test of this file shows it.
//!
//! C. K. Sanathanan, J. Koerner, IEEE Trans. Automatic Control 8 (1963) 56–58; B.
//! Gustavsen, IEEE Trans. Power Delivery 21 (2006) 1587–1592 (relaxed).

use crate::methods::fraction::{damped, Denominator, Fraction, Lines};
use chladni_linalg::{eigh, LinalgError};
use ndarray::Array2;
use num_complex::Complex64;

/// Eigenvalues of M, whose largest is at most one, below this are rounding.
const ROUNDING: f64 = 1e-15;

/// Roots in t after the linear fit and `steps` reweighted ones, with the sign of damping
/// that the last one gave them.
///
/// # Errors
/// Too few lines; no convergence of a decomposition.
pub(crate) fn sanathanan_koerner(
    lines: &Lines,
    modes: usize,
    steps: usize,
) -> Result<Vec<Complex64>, LinalgError> {
    let mut known = Denominator::flat(lines.nodes.len());
    let mut roots = step(lines, modes, &known)?;
    for _ in 0..steps {
        known = Denominator::of(&lines.nodes, &damped(&roots));
        roots = step(lines, modes, &known)?;
    }
    Ok(roots)
}

/// One fit with the weight of `known`.
fn step(lines: &Lines, modes: usize, known: &Denominator) -> Result<Vec<Complex64>, LinalgError> {
    let plane = lines.plane;
    let fraction = Fraction::new(lines, modes, known)?;
    let crossed = fraction.crossed(plane, &lines.work.b);
    let energy: Vec<Complex64> = lines
        .root_energy
        .iter()
        .map(|root| Complex64::new(root * root, 0.0))
        .collect();
    let m = fraction.reduced(plane, &energy, &crossed, &crossed);
    // Σ d/a over the lines, as coefficients of d, conjugated
    let mean: Vec<Complex64> = fraction
        .r
        .columns()
        .into_iter()
        .enumerate()
        .map(|(k, column)| {
            let sum: Complex64 = column
                .iter()
                .zip(&known.phase)
                .map(|(r, phase)| phase.conj() * *r)
                .sum();
            plane.in_field(plane.turn(k) * sum).conj()
        })
        .collect();
    fraction.roots(plane, &solved(&m, &mean)?)
}

/// m⁻¹·right for a matrix that noise-free data leave singular.
fn solved(m: &Array2<Complex64>, right: &[Complex64]) -> Result<Vec<Complex64>, LinalgError> {
    let (values, vectors) = eigh(m.view())?;
    let mut out = vec![Complex64::new(0.0, 0.0); right.len()];
    for (value, vector) in values.iter().zip(vectors.columns()) {
        let along: Complex64 = vector.iter().zip(right).map(|(v, r)| v.conj() * r).sum();
        let along = along / value.max(ROUNDING);
        out.iter_mut()
            .zip(vector)
            .for_each(|(o, v)| *o += along * v);
    }
    Ok(out)
}
