//! Poly-reference least-squares complex frequency (pLSCF): a matrix denominator over the
//! references.
//!
//! H(z) = B(z)·A(z)⁻¹ with A of the size of the references: each pole comes with its own
//! participation, so that two modes at one frequency, driven differently, are two poles
//! ([`super::matrix_fraction`]). Many references and responses are reduced to their
//! strongest combinations first, those of the compressed columns: order times references
//! is the number of poles, and eight references see all modes where four strongest ones
//! of a symmetric plate do not.
//!
//! Cost: as [`super::lscf`] with 8·n³·r² flop per output for r references and order n;
//! n·r is the same number of poles.
//!
//! Avoid it where [`super::lscf`] is to be avoided. With as many poles spread over the
//! references its numerators are of lower order, so that its bias is larger: tens of
//! Cramér–Rao bounds on the reference panel. It needs every response measured from every
//! reference.
//!
//! P. Guillaume, P. Verboven, S. Vanlanduit, H. Van der Auweraer, B. Peeters, Proc. IMAC
//! 21 (2003). B. Peeters, H. Van der Auweraer, P. Guillaume, J. Leuridan, Shock Vib. 11
//! (2004) 395–409.

use super::limits::{REFERENCES, RESPONSES};
use crate::data::error::FitError;
use crate::data::options::{FitOptions, Method};
use crate::methods::found::MethodPoles;
use crate::methods::matrix_fraction::{MatrixFraction, UnitCircle};
use crate::methods::stabilization::highest;
use crate::methods::stabilization::Ladder;
use crate::methods::survey::{Compressed, Survey};
use chladni_linalg::{eigh, matmul, LinalgError};
use ndarray::{s, Array2, Array3, Axis, ShapeBuilder};
use num_complex::Complex64;

/// Poles by pLSCF with stabilization.
///
/// # Errors
/// [`FitError::UnevenAxis`], [`FitError::IncompleteMatrix`]; a decomposition that fails.
pub(crate) fn plscf(
    survey: &Survey,
    columns: &Compressed,
    options: &FitOptions,
) -> Result<MethodPoles, FitError> {
    let circle = UnitCircle::new(survey, Method::Plscf)?;
    let frf = survey.data.frf;
    let (present, total) = (survey.data.pairs.len(), frf.pairs());
    if present < total {
        return Err(FitError::IncompleteMatrix {
            method: Method::Plscf,
            present,
            total,
        });
    }
    let data = principal(columns, frf.responses.len(), frf.references.len())?;
    let expected = survey.expected(columns, options);
    let references = data.dim().2;
    let fraction = MatrixFraction::new(
        circle,
        &data,
        highest(expected, survey).div_ceil(references),
    )?;
    Ok(
        Ladder::climb(&fraction, expected.div_ceil(references))?.modes(
            survey,
            options,
            "matrix denominator in z, stable poles chosen by their residues",
        )?,
    )
}

/// The strongest combinations of responses and references; axes (response combination,
/// line, reference combination).
fn principal(
    columns: &Compressed,
    responses: usize,
    references: usize,
) -> Result<Array3<Complex64>, LinalgError> {
    let b = &columns.work.b;
    let back = columns
        .back
        .clone()
        .unwrap_or_else(|| Array2::eye(b.ncols()));
    // (column, response, reference), each column as strong as it is
    let mut maps = back
        .to_shape((b.ncols(), responses, references))
        .expect("all pairs are present")
        .to_owned();
    let strength: Vec<f64> = b
        .columns()
        .into_iter()
        .map(|column| column.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt())
        .collect();
    for (mut map, strength) in maps.outer_iter_mut().zip(&strength) {
        map *= *strength;
    }
    let right = strongest(
        maps.outer_iter().map(|map| map.t().dot(&map)),
        references,
        REFERENCES,
    )?;
    let left = strongest(
        maps.outer_iter().map(|map| map.dot(&map.t())),
        responses,
        RESPONSES,
    )?;
    let (outputs, inputs) = (left.ncols(), right.ncols());
    let mut mixing = Array2::zeros((b.ncols(), outputs * inputs).f());
    for (c, map) in maps.outer_iter().enumerate() {
        let reduced = matmul(matmul(left.t(), map).view(), right.view());
        for ((o, v), value) in reduced.indexed_iter() {
            mixing[[c, o * inputs + v]] =
                Complex64::new(value / strength[c].max(f64::MIN_POSITIVE), 0.0);
        }
    }
    let mixed = matmul(b.view(), mixing.view());
    let mut data = Array3::zeros((outputs, b.nrows(), inputs));
    for o in 0..outputs {
        data.index_axis_mut(Axis(0), o)
            .assign(&mixed.slice(s![.., o * inputs..(o + 1) * inputs]));
    }
    Ok(data)
}

/// Eigenvectors of the sum of the `grams` for its `most` largest eigenvalues.
fn strongest(
    grams: impl Iterator<Item = Array2<f64>>,
    size: usize,
    most: usize,
) -> Result<Array2<f64>, LinalgError> {
    let sum = grams.fold(Array2::zeros((size, size)), |sum, gram| sum + gram);
    let (_, vectors) = eigh(sum.view())?;
    Ok(vectors.slice(s![.., size - most.min(size)..]).to_owned())
}
