//! Residual energy of each FRF under a model, without another look at the data: ‖b −
//! A·c‖² = ‖b‖² − 2cᵀAᵀb + cᵀAᵀA·c over the reals, where the compressed columns stand for
//! b in the product with A (theory.md, eq. 55).

use crate::data::columns::Columns;
use crate::data::layout::DataLayout;
use crate::model::limits;
use chladni_linalg::blocked::{blocked_matmul_h, interleaved};
use chladni_linalg::matmul;
use ndarray::{s, Array2, ShapeBuilder};
use rayon::prelude::*;

/// A model laid over the columns that it was found on.
pub(crate) struct Laid<'a> {
    /// The columns that the coefficients multiply, over the reals: real and imaginary part
    /// of each line in turn.
    pub basis: &'a Array2<f64>,
    /// Adds the coefficients of one FRF (position among the pairs).
    pub coefficients: &'a (dyn Fn(usize, &mut [f64]) + Sync),
    /// Columns of the data.
    pub columns: &'a Columns,
    /// From columns to FRFs; `None`: the columns are the FRFs.
    pub back: Option<&'a Array2<f64>>,
}

/// Sum of squares left of each FRF in work units of the measured data. `None` where no
/// energies are known, where the columns are the FRFs themselves or not all lines, or
/// where a residual lies in the rounding of these sums.
pub(crate) fn above_rounding(model: &Laid, data: &DataLayout) -> Option<Vec<f64>> {
    let sums = sums(model, data)?;
    sums.iter()
        .all(|(left, energy)| left > &(limits::KNOWN * energy))
        .then(|| sums.into_iter().map(|(left, _)| left).collect())
}

/// The same, rounding or not; empty where no energies are known. On weighted lines their sum is
/// right, and single FRFs are off by noise: columns that were chosen with weights do not hold all
/// of the product without.
pub(crate) fn by_sums(model: &Laid, data: &DataLayout) -> Vec<f64> {
    let plain = unweighted(model.columns, data);
    let columns = plain.as_ref().unwrap_or(model.columns);
    let known = sums(&Laid { columns, ..*model }, data);
    let left = known.into_iter().flatten().map(|(left, _)| left);
    let left: Vec<f64> = left.collect();
    let positive = left.iter().map(|left| left.max(0.0));
    let kept: f64 = positive.clone().sum();
    let scale = match plain.is_some() && kept > 0.0 {
        true => left.iter().sum::<f64>().max(0.0) / kept,
        false => 1.0,
    };
    positive.map(|left| left * scale).collect()
}

/// The columns of weighted lines as they were before; `None` where they are, or are those of
/// other lines.
fn unweighted(work: &Columns, data: &DataLayout) -> Option<Columns> {
    if work.x != data.x || work.g == data.g {
        return None;
    }
    let over = data.g.iter().zip(&work.g);
    let plain = work.reweighted(&over.map(|(plain, own)| plain / own).collect::<Vec<_>>());
    Some(Columns {
        g: data.g.clone(),
        ..plain
    })
}

/// (left, energy) of each FRF, in work units of the measured data.
fn sums(model: &Laid, data: &DataLayout) -> Option<Vec<(f64, f64)>> {
    let back = model.back?;
    let work = model.columns;
    // the measured-data path looks at some lines, or weighs them
    if data.energy.len() != data.pairs.len() || work.x != data.x || work.g != data.g {
        return None;
    }
    let basis = model.basis;
    let (gram, against) = (
        blocked_matmul_h(basis.view(), basis.view()),
        blocked_matmul_h(basis.view(), interleaved(&work.b).view()),
    );
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
        let met = matmul(against.view(), back.slice(s![.., frfs.clone()]));
        let own = matmul(gram.view(), c.view());
        let sums = frfs
            .zip(c.columns())
            .zip(met.columns().into_iter().zip(own.columns()));
        sums.map(|((l, c), (met, own))| {
            let weight = data.weight_of(data.pairs[l]).powi(2);
            let energy = unit * data.energy[l];
            (
                (energy - 2.0 * c.dot(&met) + c.dot(&own)) / weight,
                energy / weight,
            )
        })
        .collect::<Vec<_>>()
    };
    Some(starts.into_par_iter().flat_map_iter(of_block).collect())
}
