//! From free residues to shapes: one shape and one participation vector per mode
//! (theory.md, eq. 18–19).
//!
//! A mode of a linear structure moves in one shape, whichever reference drives it: R_n =
//! ψ_n·L_nᵀ. The refit weighs residues by what the data say of them (the Schur complement
//! of the basis with the residual terms eliminated), so close modes share their error
//! correctly; it alternates between all shapes and all participations, each an exact
//! linear problem. The model file holds the result, and with it the whole fit.

use crate::data::columns::Columns;
use crate::data::information::covariance;
use crate::shapes::limits;
use chladni_linalg::{matmul, matmul_h, singular_values, svd_thin, LinalgError};
use ndarray::{Array1, Array2, ArrayView1, Axis, ShapeBuilder};
use num_complex::Complex64;

/// Free residues, their weight, and which pairs exist.
pub(crate) struct Residues<'a> {
    /// (mode, pair), response by response, column-major; zero where missing.
    pub values: &'a Array2<Complex64>,
    /// Weight matrix K, (mode, mode): the sum of squares rises by δᴴKδ per pair.
    pub weight: &'a Array2<Complex64>,
    /// (response, reference): false where a pair was not measured.
    pub present: &'a Array2<bool>,
}

impl Residues<'_> {
    /// The residues of one pole, (response, reference).
    pub(crate) fn of_pole(&self, pole: usize) -> Array2<Complex64> {
        let (responses, references) = self.present.dim();
        Array2::from_shape_fn((responses, references).f(), |(i, j)| {
            self.values[[pole, i * references + j]]
        })
    }
}

/// u and v of a term u·vᵀ.
pub(crate) type Term = (Array1<Complex64>, Array1<Complex64>);

/// The strongest terms of a matrix. One alone comes from a few power steps: it is where a
/// search starts.
pub(crate) fn strongest(
    matrix: &Array2<Complex64>,
    count: usize,
) -> Result<Vec<Term>, LinalgError> {
    if count > 1 {
        let (u, sv, vh) = svd_thin(matrix.view())?;
        return Ok((0..count)
            .map(|c| (&u.column(c) * Complex64::from(sv[c]), vh.row(c).to_owned()))
            .collect());
    }
    let squares = |values: ArrayView1<Complex64>| values.iter().map(|v| v.norm_sqr()).sum::<f64>();
    let rows = matrix.rows().into_iter();
    let largest = rows.max_by(|a, b| squares(a.view()).total_cmp(&squares(b.view())));
    let conjugate = |v: ArrayView1<Complex64>| v.mapv(|v| v.conj());
    // v̄, a column of unit norm
    let unit = |v: Array2<Complex64>| {
        let norm = v.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
        v / Complex64::from(norm.max(f64::MIN_POSITIVE))
    };
    let largest = largest.expect("a response at least");
    let mut v = unit(conjugate(largest).insert_axis(Axis(1)));
    for _ in 0..limits::POWER_STEPS {
        v = unit(matmul_h(
            matrix.view(),
            matmul(matrix.view(), v.view()).view(),
        ));
    }
    let u = matmul(matrix.view(), v.view());
    Ok(vec![(u.column(0).to_owned(), conjugate(v.column(0)))])
}

/// A rise of the sum of squares over that of a wider model, against what chance allows:
/// standard deviations over the mean of χ² with `constraints` degrees of freedom, for
/// complex data of noise variance `variance`. `rounding`: of the sums of squares.
pub(crate) fn beyond_chance(rise: f64, constraints: usize, variance: f64, rounding: f64) -> f64 {
    let k = constraints as f64;
    ((rise - rounding).max(0.0) / (0.5 * variance).max(f64::MIN_POSITIVE) - k)
        / (2.0 * k).sqrt().max(1.0)
}

/// The largest rise of the sum of squares, of the model as saved over free residues, that is
/// accepted as chance. A misfit that χ² hardly shows is accepted too: many data make even a
/// misfit far below the error bars significant. `work` holds the data of `frfs` FRFs.
pub(crate) fn most_by_chance(
    constraints: usize,
    variance: f64,
    rounding: f64,
    (work, frfs): (&Columns, usize),
) -> f64 {
    let values = (work.lines() * work.columns()) as f64;
    let seen = match work.columns() < frfs {
        true => limits::EXCESS_SEEN_COMPRESSED,
        false => limits::EXCESS_SEEN,
    };
    let mean = 0.5 * constraints as f64;
    let scatter = (2.0 * constraints as f64).sqrt().max(1.0);
    let by_chance = rounding + variance * (mean + 0.5 * limits::STRUCTURE_SIGMAS * scatter);
    by_chance.max(variance * (mean + seen * (values + mean)))
}

/// Singular values of the residues of one pole that noise of variance `variance` in the data
/// cannot make (the largest of pure noise is about σ(√responses + √references)), falling.
pub(crate) fn significant_values(
    residues: &Residues,
    pole: usize,
    variance: f64,
) -> Result<Vec<f64>, LinalgError> {
    let (responses, references) = residues.present.dim();
    let values = singular_values(residues.of_pole(pole).view())?;
    let inverse = covariance(ridge(residues.weight).view());
    let noise = (variance * inverse[[pole, pole]].re).sqrt()
        * ((responses as f64).sqrt() + (references as f64).sqrt());
    Ok(values
        .into_iter()
        .filter(|s| *s > limits::RANK_OVER_NOISE * noise)
        .collect())
}

/// A pair of modes with the same pole makes the system singular; a trace of ridge shares
/// the residue between them.
pub(crate) fn ridge(matrix: &Array2<Complex64>) -> Array2<Complex64> {
    let mut out = matrix.clone();
    let (own, of_largest) = limits::RESIDUES_RIDGE;
    let largest = matrix.diag().iter().fold(0.0_f64, |m, v| m.max(v.re));
    out.diag_mut()
        .mapv_inplace(|v| v * (1.0 + own) + of_largest * largest + f64::MIN_POSITIVE);
    out
}

/// Weight of the mode columns with the other columns eliminated: K = R₂₂ᴴR₂₂ of the QR
/// with the others first.
pub(crate) fn schur_weight(
    modes: &Array2<Complex64>,
    others: &Array2<Complex64>,
) -> Result<Array2<Complex64>, LinalgError> {
    let outside = if others.ncols() == 0 {
        modes.clone()
    } else {
        let (q, _) = chladni_linalg::qr_thin(others.view())?;
        modes - &matmul(q.view(), matmul_h(q.view(), modes.view()).view())
    };
    Ok(matmul_h(outside.view(), outside.view()))
}

/// The references that responses were measured from, with these responses.
pub(crate) fn alike(present: &Array2<bool>) -> Vec<(Vec<bool>, Vec<usize>)> {
    let mut kinds: Vec<(Vec<bool>, Vec<usize>)> = Vec::new();
    for (i, row) in present.rows().into_iter().enumerate() {
        match kinds.iter_mut().find(|(kept, _)| *kept == row.to_vec()) {
            Some((_, responses)) => responses.push(i),
            None => kinds.push((row.to_vec(), vec![i])),
        }
    }
    kinds
}
