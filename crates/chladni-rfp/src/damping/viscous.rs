//! The columns of viscous modes with the residues that the file has (theory.md, eq. 16):
//! poles s and s* with residues r and r*, over the reals.
//!
//! α = Σ [r/(jω − s) + r*/(jω − s*)] is linear in Re r and Im r only over the reals, so
//! lines come in halves (real parts, then imaginary parts) and each mode has two real
//! columns. Frequencies are in units of ω_max: y = ω/ω_max = √x.

use crate::damping::columns::inverse;
use crate::data::columns::Columns;
use ndarray::{s, Array2, ShapeBuilder};
use num_complex::Complex64;

fn in_halves_into(out: &mut Array2<f64>, column: usize, values: impl Iterator<Item = Complex64>) {
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

/// Real parts of lines over imaginary parts, as those of [`viscous_basis`].
pub(crate) fn halves(b: &Array2<Complex64>) -> Array2<f64> {
    let lines = b.nrows();
    let mut out = Array2::zeros((2 * lines, b.ncols()).f());
    out.slice_mut(s![..lines, ..]).assign(&b.mapv(|v| v.re));
    out.slice_mut(s![lines.., ..]).assign(&b.mapv(|v| v.im));
    out
}

/// Basis in halves: per mode g·(u + v) and jg·(u − v) with u = 1/(jy − s), v = 1/(jy − s*);
/// then residual terms.
pub(crate) fn viscous_basis(work: &Columns, poles: &[Complex64], powers: &[i32]) -> Array2<f64> {
    let mut a = Array2::zeros((2 * work.lines(), 2 * (poles.len() + powers.len())).f());
    let j = Complex64::i();
    for (n, &pole) in poles.iter().enumerate() {
        let leaks = work.leakage.as_ref().filter(|_| pole.re < 0.0);
        let leaks = leaks.map(|of| (of.leakage.of_pole(pole), &of.lines));
        let halves_of = |(k, (&x, &g)): (usize, (&f64, &f64))| {
            let jy = Complex64::new(0.0, x.sqrt());
            let (own, other) = (inverse(jy - pole) * g, inverse(jy - pole.conj()) * g);
            match &leaks {
                Some((leaks, lines)) => (own * leaks.factor(&lines[k]), other),
                None => (own, other),
            }
        };
        let lines = work.x.iter().zip(&work.g).enumerate();
        let uv: Vec<(Complex64, Complex64)> = lines.map(halves_of).collect();
        in_halves_into(&mut a, 2 * n, uv.iter().map(|(u, v)| u + v));
        in_halves_into(&mut a, 2 * n + 1, uv.iter().map(|(u, v)| j * (u - v)));
    }
    for (p, &power) in powers.iter().enumerate() {
        let column = 2 * (poles.len() + p);
        let term = || {
            work.x
                .iter()
                .zip(&work.g)
                .map(move |(&x, &g)| Complex64::new(g * x.powi(power), 0.0))
        };
        in_halves_into(&mut a, column, term());
        in_halves_into(&mut a, column + 1, term().map(|v| j * v));
    }
    a
}
