//! The second pass over a block: its products with the basis of the poles.

use crate::data::layout::{DataLayout, Weighting};
use crate::data::options::FitOptions;
use crate::data::products::{measured_basis, products};
use crate::data::reading::squares_of;
use crate::data::screening::Screened;
use crate::data::source::Way;
use crate::pieces::error::PieceError;
use crate::pieces::partial::{Block, ProductSums};
use crate::pieces::poles::{Matrix, Poles};
use crate::poles::passes::on_weighted_lines;
use chladni_frf::{Error, FrfSet};
use ndarray::{Array2, Axis};
use rayon::prelude::*;

/// The basis that products are made with.
#[derive(Debug)]
pub(crate) struct Basis {
    pub layout: DataLayout,
    /// Orthonormal on the lines used, as it meets measured values: (real and imaginary
    /// part of each line, unknown).
    measured: Array2<f64>,
}

impl Basis {
    /// From the poles that a pass found on its `way`.
    pub fn new(poles: &Poles, way: &Way, options: &FitOptions) -> Result<Self, PieceError> {
        let layout = DataLayout {
            law: way.law,
            ..poles.layout(options.effort)?
        };
        let q = on_weighted_lines(&layout, &way.lambda, way.weights())?;
        let measured = measured_basis(&layout, &q, way.weights());
        Ok(Self { measured, layout })
    }
}

/// The error of an FRF that was whole in the first pass and is not now.
fn not_finite(frf: &FrfSet, layout: &DataLayout, (i, j): (usize, usize)) -> Error {
    let line = layout
        .lines
        .iter()
        .position(|&k| !frf.values.get(i, j, k).is_finite())
        .map_or(f64::NAN, |k| layout.line_hz[k]);
    Error::bad_data("a value that is not finite, where all were finite when the poles were found")
        .field(format!(
            "FRF {} from {} at {line} Hz",
            frf.responses[i], frf.references[j]
        ))
        .found("NaN or infinity")
        .expected("the data that the first pass was run on")
        .help("run both passes over the same data")
}

/// The first of FRFs without a value on the first line that has some on others.
fn partly_there(
    frf: &FrfSet,
    layout: &DataLayout,
    missing: &[(usize, usize)],
) -> Option<(usize, usize)> {
    missing.iter().copied().find(|&(i, j)| {
        let mut values = layout.lines.iter().map(|&k| frf.values.get(i, j, k));
        values.any(|value| value.is_finite() && value.norm() > 0.0)
    })
}

/// The products. `energy`: sum of squares of each FRF, where it is known.
pub(crate) fn second_pass(
    frf: &FrfSet,
    basis: &Basis,
    weighting: &Option<Weighting>,
    energy: Option<Vec<f64>>,
) -> Result<(Block, ProductSums), PieceError> {
    let layout = &basis.layout;
    let weight = |pair: (usize, usize)| {
        let weights = weighting.as_ref().map(|weighting| &weighting.weights);
        weights.map_or(1.0, |weights| weights.of(pair))
    };
    // on the lines used, an FRF is there or it is not
    let (mut pairs, missing): (Vec<_>, Vec<_>) = frf
        .all_pairs()
        .partition(|&(i, j)| frf.values.get(i, j, layout.lines[0]).is_finite());
    let of_block = DataLayout {
        pairs: pairs.as_slice().into(),
        weighting: weighting.clone(),
        ..layout.clone()
    };
    let mut made = products(&Screened::part(frf, of_block), &basis.measured);
    let mut energy = energy
        .filter(|energy| energy.len() == pairs.len())
        .unwrap_or_else(|| {
            pairs
                .par_iter()
                .map(|&pair| weight(pair).powi(2) * squares_of(&frf.values, pair, &layout.lines))
                .collect()
        });
    let broken = pairs
        .iter()
        .zip(&energy)
        .find(|(_, energy)| !energy.is_finite())
        .map(|(&pair, _)| pair);
    if let Some(pair) = broken.or_else(|| partly_there(frf, layout, &missing)) {
        return Err(not_finite(frf, layout, pair).into());
    }
    // FRFs of zeros add nothing to the products; the first pass has left them out
    let used: Vec<usize> = (0..pairs.len()).filter(|&l| energy[l] > 0.0).collect();
    if used.len() < pairs.len() {
        pairs = used.iter().map(|&l| pairs[l]).collect();
        energy = used.iter().map(|&l| energy[l]).collect();
        made.r0 = made.r0.select(Axis(1), &used);
    }
    let block = Block {
        energy,
        r0: Some(Matrix::from(made.r0)),
        ..Block::of_pairs(pairs)
    };
    let sums = ProductSums {
        t: Matrix::from(made.t),
        gram: Matrix::from(made.gram),
    };
    Ok((block, sums))
}
