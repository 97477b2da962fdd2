//! Second pass over the data: compressed columns for poles *and* all residues (theory.md, eq.
//! 13–15).
//!
//! Q is an orthonormal basis of the model, R₀ = QᴴB and T = B·R₀ᵀ. Real and imaginary parts are
//! apart, so that every mixture of FRFs stays real and both damping laws can use it. The columns
//! T·(R₀R₀ᵀ)^{-1/2} determine the poles at the signal-to-noise ratio of the whole set, and the
//! residues of any nearby poles follow from them.

use crate::data::columns::Columns;
use crate::data::layout::DataLayout;
use crate::data::limits;
use crate::data::screening::Screened;
use chladni_linalg::blocked::{blocked_matmul, blocked_matmul_h, cleared, tree_sum};
use chladni_linalg::{add_matmul, cholesky, eigh, set_matmul_h, solve_lower_adjoint, LinalgError};
use ndarray::{s, Array1, Array2, ArrayViewMut2, Axis, ShapeBuilder};
use num_complex::Complex64;
use std::ops::Range;

/// The result of the second pass.
#[derive(Debug, Clone)]
pub(crate) struct Projected {
    /// Compressed columns, real mixtures of FRFs: at most twice as many as the model has
    /// unknowns.
    pub work: Columns,
    /// (compressed column, FRF), real, rows orthonormal: B ≈ work.b · back in the part of B that the
    /// model can explain.
    pub back: Array2<f64>,
    /// Energy of each line, over all FRFs, that the columns do not hold: noise that no model near Q
    /// can explain.
    beyond: Array1<f64>,
}

impl Projected {
    /// The columns of T·G^{-1/2} with the way back to FRFs.
    ///
    /// * `t`, `gram`: as in [`Products`]
    /// * `by_r0`: computes XᵀR₀ of an X
    /// * `line_energy`: of each line over all FRFs, before weights
    /// * `weights`: of lines; empty: all count alike
    ///
    /// # Errors
    /// A decomposition that fails.
    pub fn new(
        data: &DataLayout,
        [t, gram]: [&Array2<f64>; 2],
        by_r0: impl FnOnce(&Array2<f64>) -> Array2<f64>,
        line_energy: &Array1<f64>,
        weights: &[f64],
    ) -> Result<Self, LinalgError> {
        let lines = data.lines.len();
        let factor = data.factor();
        let half = inverse_root(gram)?;
        let columns = blocked_matmul(t.view(), half.view());
        let parts = columns.as_slice_memory_order().unwrap_or_default();
        let parts = parts.as_chunks().0.iter();
        let values = parts.map(|&[re, im]| factor * Complex64::new(re, im));
        let b = Array2::from_shape_vec((lines, half.ncols()).f(), values.collect());
        let b = b.expect("two parts of each value");
        let mut beyond = line_energy.clone();
        add_energy(&mut beyond, &b, -1.0);
        for (energy, weight) in beyond.iter_mut().zip(weights) {
            *energy *= weight * weight;
        }
        beyond.mapv_inplace(|energy| energy.max(0.0));
        let mut work = data.columns(b);
        work.weigh(weights);
        Ok(Projected {
            work,
            back: by_r0(&half),
            beyond,
        })
    }

    /// Noise energy of each line over all FRFs, from the residual of a model. The model absorbs a share
    /// Σ|Q_k|² of the noise (its leverage), most of it at its poles.
    ///
    /// * `q`: orthonormal basis of the model, (line, m)
    /// * `residual`: of the compressed columns, (line, column)
    pub fn line_noise(&self, q: &Array2<Complex64>, residual: &Array2<Complex64>) -> Array1<f64> {
        let mut energy = self.line_residual(residual);
        for (energy, q) in energy.iter_mut().zip(q.rows()) {
            let leverage = q.iter().map(|v| v.norm_sqr()).sum::<f64>();
            *energy /= (1.0 - leverage).max(limits::LEVERAGE_LEFT);
        }
        energy
    }

    /// Residual energy of each line over all FRFs, from the `residual` of the compressed columns under
    /// a model near Q.
    pub fn line_residual(&self, residual: &Array2<Complex64>) -> Array1<f64> {
        let mut energy = self.beyond.clone();
        add_energy(&mut energy, residual, 1.0);
        energy
    }
}

/// G^{-1/2} in the directions above rounding, up to a rotation: the one that is cheapest to compute.
fn inverse_root(gram: &Array2<f64>) -> Result<Array2<f64>, LinalgError> {
    let well_conditioned = |lower: &Array2<f64>| {
        lower
            .diag()
            .iter()
            .zip(gram.diag())
            .all(|(pivot, all)| pivot * pivot > limits::GRAM_SOUND * all)
    };
    if let Some(lower) = cholesky(gram.view()).ok().filter(well_conditioned) {
        return solve_lower_adjoint(lower.view(), Array2::eye(gram.nrows()).view());
    }
    let (values, vectors) = eigh(gram.view())?;
    let largest = values.last().copied().unwrap_or(0.0);
    let kept: Vec<usize> = (0..values.len())
        .filter(|&i| values[i] > limits::GRAM_ROUNDING * largest)
        .collect();
    Ok(Array2::from_shape_fn(
        (values.len(), kept.len()).f(),
        |(i, c)| vectors[[i, kept[c]]] / values[kept[c]].sqrt(),
    ))
}

/// Adds `sign` times the energy of each row.
fn add_energy(energy: &mut Array1<f64>, columns: &Array2<Complex64>, sign: f64) {
    for column in columns.columns() {
        energy.zip_mut_with(&column, |sum, value| *sum += sign * value.norm_sqr());
    }
}

/// A complex basis over the reals: columns q and j·q in turn, real and imaginary part of each line
/// in turn.
pub(crate) fn real_basis(q: &Array2<Complex64>) -> Array2<f64> {
    let (lines, m) = q.dim();
    let mut values = Vec::with_capacity(4 * lines * m);
    for column in q.columns() {
        values.extend(column.iter().flat_map(|v| [v.re, v.im]));
        values.extend(column.iter().flat_map(|v| [-v.im, v.re]));
    }
    Array2::from_shape_vec((2 * lines, 2 * m).f(), values).expect("as many values")
}

/// The result of the pass; the compressed columns are made from it.
#[derive(Debug, Clone)]
pub(crate) struct Products {
    /// T = B·R₀ᵀ, (real and imaginary part of each line, unknown).
    pub t: Array2<f64>,
    /// R₀R₀ᵀ.
    pub gram: Array2<f64>,
    /// R₀ = QᴴB over the reals, (unknown, FRF).
    pub r0: Array2<f64>,
}

/// Runs the pass with a [`measured_basis`] on all FRFs.
///
/// * `line_energy`: from the first pass
/// * `weights`: of lines, which the basis holds already
pub(crate) fn project(
    data: &Screened,
    basis: Array2<f64>,
    line_energy: &Array1<f64>,
    weights: &[f64],
) -> Result<Projected, LinalgError> {
    let Products { t, gram, r0 } = products(data, &basis);
    drop(basis);
    let by_r0 = |x: &Array2<f64>| blocked_matmul_h(x.view(), r0.view());
    Projected::new(data, [&t, &gram], by_r0, line_energy, weights)
}

/// Computes the products of all FRFs with a [`measured_basis`].
pub(crate) fn products(data: &Screened, basis: &Array2<f64>) -> Products {
    let (lines, total, m) = (data.lines.len(), data.pairs.len(), basis.ncols());
    let mut r0 = Array2::zeros((m, total).f());
    if total == 0 {
        // a part of a set may hold no FRF
        let (t, gram) = (Array2::zeros((2 * lines, m)), Array2::zeros((m, m)));
        return Products { t, gram, r0 };
    }
    let least = limits::GROUP_FRFS.max(limits::GROUP_COLUMNS * m);
    let groups: Vec<_> = data
        .groups(least)
        .into_iter()
        .zip(r0.axis_chunks_iter_mut(Axis(1), data.group_size(least)))
        .collect();
    let sums = |(group, mut r0): (Range<usize>, ArrayViewMut2<f64>)| {
        let (mut t, mut gram) = (cleared(2 * lines, m), cleared(m, m));
        let start = group.start;
        data.each_block(group, |frfs, block| {
            let mut inside = r0.slice_mut(s![.., frfs.start - start..frfs.end - start]);
            set_matmul_h(inside.view_mut(), basis.view(), block.view());
            add_matmul(t.view_mut(), block.view(), inside.t());
            add_matmul(gram.view_mut(), inside.view(), inside.t());
        });
        (t, gram)
    };
    let add = |left: (Array2<f64>, Array2<f64>), right: (Array2<f64>, Array2<f64>)| {
        (left.0 + right.0, left.1 + right.1)
    };
    let (t, gram) = tree_sum(groups, &sums, &add);
    Products { t, gram, r0 }
}

/// Energy Σ|qᴴb|² of all FRFs along each column of `q`, in one pass that is cheaper than [`products`].
pub(crate) fn energies(data: &Screened, q: &Array2<Complex64>) -> Vec<f64> {
    let basis = measured_basis(data, q, &[]);
    let sums = |group: Range<usize>| {
        let mut energy = vec![0.0; q.ncols()];
        data.each_block(group, |frfs, block| {
            let mut inside = Array2::zeros((basis.ncols(), frfs.len()).f());
            set_matmul_h(inside.view_mut(), basis.view(), block.view());
            for column in inside.columns() {
                column
                    .iter()
                    .enumerate()
                    .for_each(|(c, value)| energy[c / 2] += value * value);
            }
        });
        energy
    };
    tree_sum(data.groups(limits::GROUP_FRFS), &sums, &|left, right| {
        left.iter().zip(&right).map(|(l, r)| l + r).collect()
    })
}

/// The basis over the reals for products with values of the measured kind: it holds the
/// factor to work units, so that the FRFs themselves need not be multiplied.
///
/// * `weights`: of lines; empty: all count alike
pub(crate) fn measured_basis(
    data: &DataLayout,
    q: &Array2<Complex64>,
    weights: &[f64],
) -> Array2<f64> {
    let factor = data.factor();
    let mut measured = q.mapv(|v| v * factor.conj());
    for (mut row, weight) in measured.rows_mut().into_iter().zip(weights) {
        row.mapv_inplace(|v| v * weight);
    }
    real_basis(&measured)
}
