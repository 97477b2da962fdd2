//! Sanathanan–Koerner steps: the linear fit repeated with the weight 1/|a|² of the
//! denominator before, on polynomials made anew for each weight.
//!
//! The linear equation error d·B − N weights every line with |a|², which spans ten decades
//! over a band of twelve modes: the fit looks where modes are not. Divided by the |a| of
//! the step before, it becomes the error of the measured values as the steps converge
//! (theory.md, eq. 70). The scale of d is fixed by the mean of d/a instead of its leading
//! coefficient (relaxed), so that noise pulls it nowhere.
//!
//! On a basis that is made once, the same steps fail: the polynomials that were orthonormal
//! for one weight are all but parallel for the next. A test of this file shows it.
//!
//! C. K. Sanathanan, J. Koerner, IEEE Trans. Automatic Control 8 (1963) 56–58; B.
//! Gustavsen, IEEE Trans. Power Delivery 21 (2006) 1587–1592 (relaxed).

use super::limits::SANATHANAN_KOERNER_ROUNDING;
use crate::methods::fraction::{damped, if_carried, Denominator, Fraction, Lines};
use chladni_linalg::{eigh, LinalgError};
use ndarray::Array2;
use num_complex::Complex64;

/// Roots in t after the linear fit and `steps` reweighted ones, with the sign of damping
/// that the last one gave them; none where the lines do not carry so many.
///
/// # Errors
/// No convergence of a decomposition.
pub(crate) fn sanathanan_koerner(
    lines: &Lines,
    modes: usize,
    steps: usize,
) -> Result<Vec<Complex64>, LinalgError> {
    let mut known = Denominator::flat(lines.nodes.len());
    let mut roots = if_carried(step(lines, modes, &known))?.unwrap_or_default();
    for _ in 0..steps {
        known = Denominator::of(&lines.nodes, &damped(&roots));
        match if_carried(step(lines, modes, &known))? {
            Some(next) => roots = next,
            None => break,
        }
    }
    Ok(roots)
}

/// One fit with the weight of `known`.
fn step(lines: &Lines, modes: usize, known: &Denominator) -> Result<Vec<Complex64>, LinalgError> {
    let plane = lines.plane;
    let fraction = Fraction::new(lines, modes, known)?;
    let crossed = fraction.crossed(plane, &lines.work.b);
    let energy: Vec<Complex64> = lines.energy.iter().map(|&e| e.into()).collect();
    let m = fraction.reduced(plane, &energy, &crossed, &crossed);
    // Σ d/a over the lines is their product with these
    let mean = fraction.along_denominators(plane, &known.phase);
    let mean: Vec<Complex64> = mean.iter().copied().collect();
    fraction.roots(plane, &solved(&m, &mean)?)
}

/// m⁻¹·right for a matrix that noise-free data leave singular.
fn solved(m: &Array2<Complex64>, right: &[Complex64]) -> Result<Vec<Complex64>, LinalgError> {
    let (values, vectors) = eigh(m.view())?;
    let mut out = vec![Complex64::new(0.0, 0.0); right.len()];
    for (value, vector) in values.iter().zip(vectors.columns()) {
        let along: Complex64 = vector.iter().zip(right).map(|(v, r)| v.conj() * r).sum();
        let along = along / value.max(SANATHANAN_KOERNER_ROUNDING);
        out.iter_mut()
            .zip(vector)
            .for_each(|(o, v)| *o += along * v);
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::damping::plane::Plane;
    use crate::data::columns::Columns;
    use crate::data::options::FitOptions;
    use crate::data::screening::Screened;
    use crate::methods::synthetic::even;
    use chladni_frf::Damping;
    use chladni_linalg::{matmul, matmul_h, qr_r, qr_thin, singular_values, svd_thin};
    use ndarray::{concatenate, Array1, Axis, ShapeBuilder};
    use std::f64::consts::TAU;

    /// The same steps on the polynomials of the first weight: the roots, and the least over
    /// the largest singular value of the numerators in the last weight.
    fn on_one_basis(lines: &Lines, modes: usize, steps: usize) -> (Vec<Complex64>, f64) {
        let flat = Denominator::flat(lines.nodes.len());
        let basis = Fraction::new(lines, modes, &flat).unwrap();
        let weighted = |columns: &Array2<f64>, weight: &[Complex64]| {
            Array2::from_shape_fn(columns.dim().f(), |(k, c)| weight[k] * columns[[k, c]])
        };
        let mut inverse: Array1<f64> = Array1::ones(lines.nodes.len());
        let (mut roots, mut spread) = (Vec::new(), 1.0);
        for _ in 0..=steps {
            let own: Vec<Complex64> = inverse.iter().map(|&u| u.into()).collect();
            let numerators = weighted(&basis.numerators.columns, &own);
            let singular = singular_values(numerators.view()).unwrap();
            spread = singular[singular.len() - 1] / singular[0];
            let (q, _) = qr_thin(numerators.view()).unwrap();
            let reduced: Vec<Array2<Complex64>> = (lines.work.b.columns().into_iter())
                .map(|column| {
                    let values: Vec<Complex64> =
                        column.iter().zip(&own).map(|(b, u)| b * u).collect();
                    let t = weighted(&basis.r, &values);
                    let outside = &t - &matmul(q.view(), matmul_h(q.view(), t.view()).view());
                    qr_r(outside.view()).unwrap()
                })
                .collect();
            let views: Vec<_> = reduced.iter().map(|r| r.view()).collect();
            let (_, _, vh) = svd_thin(concatenate(Axis(0), &views).unwrap().view()).unwrap();
            let d: Vec<Complex64> = vh.row(modes).iter().map(|v| v.conj()).collect();
            roots = basis.roots(lines.plane, &d).unwrap();
            inverse = Denominator::of(&lines.nodes, &damped(&roots)).inverse;
        }
        (roots, spread)
    }

    /// True modes, in units of t, that no root comes near.
    fn missed(plane: Plane, truth: &[Complex64], roots: &[Complex64]) -> usize {
        let near = |mode: &&Complex64| {
            let known = plane.roots(&[**mode])[0];
            let nearest = roots.iter().map(|root| (root - known).norm());
            nearest.fold(f64::INFINITY, f64::min) > known.im
        };
        truth.iter().filter(near).count()
    }

    /// The reason why polynomials are made anew: kept as the warning it is.
    #[test]
    fn polynomials_made_once_lose_modes_that_those_made_anew_find() {
        let set = even(34, 60.0, Damping::Structural, 1);
        let data = Screened::new(&set.frf, &FitOptions::default()).unwrap();
        let work: Columns = data.work();
        let truth: Vec<Complex64> = set
            .truth
            .in_band_modes()
            .map(|mode| {
                let x = (TAU * mode.frequency_hz / data.omega_max).powi(2);
                Complex64::new(1.0, mode.loss_factor) * x
            })
            .collect();
        let plane = Plane::new(Damping::Structural, &work.x);
        let lines = Lines::new(plane, &work);
        let (order, steps) = (40, 10);
        let anew = sanathanan_koerner(&lines, order, steps).unwrap();
        let (once, spread) = on_one_basis(&lines, order, steps);
        let lost = [&anew, &once].map(|roots| missed(plane, &truth, roots));
        // how many modes rounding costs depends on its order; that digits are lost does not
        assert!(lost[0] == 0 && spread < 1e-6, "{lost:?} {spread:e}");
    }
}
