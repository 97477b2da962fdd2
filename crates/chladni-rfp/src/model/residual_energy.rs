//! Residual energy of each FRF under a model, without another pass over the data (theory.md, eq.
//! 55): ‖b − A·c‖² = ‖b‖² − 2cᵀAᵀb + cᵀAᵀA·c over the reals. In the product with A the compressed
//! columns replace b.

use crate::data::columns::Columns;
use crate::data::layout::DataLayout;
use crate::model::limits;
use chladni_linalg::blocked::{blocked_matmul_h, interleaved};
use chladni_linalg::matmul;
use ndarray::{s, Array2, ArrayView1, ShapeBuilder};
use rayon::prelude::*;

/// A model and the columns that it was found on.
pub(crate) struct ModelOnColumns<'a> {
    /// The columns that the coefficients multiply, over the reals: real and imaginary part
    /// of each line in turn.
    pub basis: &'a Array2<f64>,
    /// Adds the coefficients of one FRF (position among the pairs) to zeros.
    pub coefficients: &'a (dyn Fn(usize, &mut [f64]) + Sync),
    /// Columns of the data.
    pub columns: &'a Columns,
    /// From columns to FRFs; `None`: the columns are the FRFs.
    pub back: Option<&'a Array2<f64>>,
}

/// Energies of one FRF, in work units of the measured data.
struct FrfEnergies {
    residual: f64,
    whole: f64,
}

/// Residual energy of each FRF. `None` if the energies of the FRFs are not known, if the columns
/// are the FRFs themselves or hold not all lines, or if a residual lies in the rounding of these
/// sums.
pub(crate) fn residuals_above_rounding(
    model: &ModelOnColumns,
    data: &DataLayout,
) -> Option<Vec<f64>> {
    let energies = energies(model, data)?;
    energies
        .iter()
        .all(|frf| frf.residual > limits::RESIDUAL_KNOWN * frf.whole)
        .then(|| energies.into_iter().map(|frf| frf.residual).collect())
}

/// Residual energy of each FRF, even if it lies in rounding; empty if the energies of the FRFs are
/// not known. On weighted lines their sum is right, and single FRFs are off by noise: columns that
/// were chosen with weights do not hold all of the product without.
pub(crate) fn residuals_by_sums(model: &ModelOnColumns, data: &DataLayout) -> Vec<f64> {
    let plain = unweighted(model.columns, data);
    let columns = plain.as_ref().unwrap_or(model.columns);
    let known = energies(&ModelOnColumns { columns, ..*model }, data);
    let residuals: Vec<f64> = known
        .into_iter()
        .flatten()
        .map(|frf| frf.residual)
        .collect();
    let positive = residuals.iter().map(|residual| residual.max(0.0));
    let sum_of_positive: f64 = positive.clone().sum();
    let scale = match plain.is_some() && sum_of_positive > 0.0 {
        true => residuals.iter().sum::<f64>().max(0.0) / sum_of_positive,
        false => 1.0,
    };
    positive.map(|residual| residual * scale).collect()
}

/// Columns of weighted lines with their weights undone; `None` if the lines are not weighted, or are
/// not those of the data.
fn unweighted(work: &Columns, data: &DataLayout) -> Option<Columns> {
    if work.x != data.x || work.g == data.g {
        return None;
    }
    let both = data.g.iter().zip(&work.g);
    let undoing: Vec<f64> = both.map(|(plain, weighted)| plain / weighted).collect();
    Some(Columns {
        g: data.g.clone(),
        ..work.reweighted(&undoing)
    })
}

type Column<'a> = ArrayView1<'a, f64>;

/// Energies of each FRF; `None` if they are not known.
fn energies(model: &ModelOnColumns, data: &DataLayout) -> Option<Vec<FrfEnergies>> {
    let back = model.back?;
    let work = model.columns;
    // the measured-data path may have taken some of the lines, or weighted them
    if data.energy.len() != data.pairs.len() || work.x != data.x || work.g != data.g {
        return None;
    }
    let basis = model.basis;
    let gram = blocked_matmul_h(basis.view(), basis.view());
    let basis_by_columns = blocked_matmul_h(basis.view(), interleaved(&work.b).view());
    let unit = data.factor().norm_sqr();
    let starts: Vec<usize> = (0..data.pairs.len())
        .step_by(limits::RESIDUAL_ENERGY_BLOCK)
        .collect();
    let of_block = |first: usize| {
        let frfs = first..(first + limits::RESIDUAL_ENERGY_BLOCK).min(data.pairs.len());
        let mut c = Array2::zeros((basis.ncols(), frfs.len()).f());
        for (mut column, l) in c.columns_mut().into_iter().zip(frfs.clone()) {
            (model.coefficients)(l, column.as_slice_memory_order_mut().expect("column-major"));
        }
        let basis_by_data = matmul(basis_by_columns.view(), back.slice(s![.., frfs.clone()]));
        let gram_by_c = matmul(gram.view(), c.view());
        let products = basis_by_data.columns().into_iter().zip(gram_by_c.columns());
        let of_frf = |((l, c), (by_data, by_c)): ((usize, Column), (Column, Column))| {
            let weight = data.weight_of(data.pairs[l]).powi(2);
            let energy = unit * data.energy[l];
            FrfEnergies {
                residual: (energy - 2.0 * c.dot(&by_data) + c.dot(&by_c)) / weight,
                whole: energy / weight,
            }
        };
        let frfs = frfs.zip(c.columns()).zip(products);
        frfs.map(of_frf).collect::<Vec<_>>()
    };
    Some(starts.into_par_iter().flat_map_iter(of_block).collect())
}
