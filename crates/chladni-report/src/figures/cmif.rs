//! Complex mode indicator function.

use super::frf_overlay::{band_lines, frequency_axis, pole_lines};
use super::{level, natural_frequencies};
use crate::chart::{Axis, Chart, Figure, Height, Place};
use crate::comparison::Comparison;
use crate::drawing::{Colour, Dash, Stroke};
use crate::input::Quantity;
use crate::sizes;
use chladni_frf::{Error, ErrorKind, FrfSet, ModalModel, Result};
use ndarray::{Array1, Array2};
use rayon::prelude::*;

/// Singular values of the FRF matrix over frequency.
pub(crate) struct Cmif {
    /// Axes (line, singular value).
    pub(crate) values: Array2<f64>,
    pub(crate) quantity: Quantity,
    /// Origin in words: `of the measured FRFs`.
    pub(crate) of: &'static str,
}

impl Cmif {
    /// The CMIF of the measured FRFs, or of the synthesis where measured pairs are missing; `None`
    /// where there is no model either.
    ///
    /// # Errors
    /// A singular value decomposition that does not converge.
    pub(crate) fn of(comparison: &Comparison, measured: Option<&FrfSet>) -> Result<Option<Self>> {
        if let Some(set) = measured {
            let values = chladni_rfp::cmif(set).map_err(failed)?;
            if values.iter().any(|value| value.is_finite()) {
                let quantity = Quantity {
                    kind: set.kind,
                    reference_unit: set.reference_unit,
                };
                return Ok(Some(Self {
                    values,
                    quantity,
                    of: "of the measured FRFs",
                }));
            }
        }
        let Some(model) = comparison.model else {
            return Ok(None);
        };
        let values = of_synthesis(model, &comparison.frequency_hz)?;
        Ok(Some(Self {
            values,
            quantity: comparison.quantity,
            of: "of the synthesis",
        }))
    }

    /// Number of singular values that are shown.
    fn shown(&self) -> usize {
        self.values.ncols().min(sizes::SINGULAR_VALUES)
    }
}

/// Singular values of the synthesis, axes (line, singular value); NaN on lines where the
/// synthesis is not finite, as at 0 Hz of a free body.
fn of_synthesis(model: &ModalModel, frequency_hz: &Array1<f64>) -> Result<Array2<f64>> {
    let count = model.responses.len().min(model.references.len());
    let rows = frequency_hz.to_vec().into_par_iter().map(|f| {
        let matrix = model.frf_matrix(model.frf_kind, f);
        if matrix.iter().any(|value| !value.is_finite()) {
            return Ok(Array1::from_elem(count, f64::NAN));
        }
        chladni_linalg::singular_values(matrix.view()).map_err(failed)
    });
    let rows: Vec<Array1<f64>> = rows.collect::<Result<_>>()?;
    Ok(Array2::from_shape_fn((rows.len(), count), |(line, k)| {
        rows[line][k]
    }))
}

fn failed(error: chladni_linalg::LinalgError) -> Error {
    Error::new(
        ErrorKind::Internal,
        format!("the CMIF cannot be computed: {error}"),
    )
}

/// The figure.
pub(crate) fn figure(comparison: &Comparison, cmif: &Cmif) -> Figure {
    let shown = cmif.shown();
    Figure {
        name: "cmif".into(),
        title: format!("Complex mode indicator function {}", cmif.of),
        caption: format!(
            "The {shown} largest singular values of the FRF matrix at each line. A peak of the first one is a mode; peaks of the first \
             and second at one frequency are two close modes."
        ),
        width: sizes::WIDE_PX,
        charts: vec![chart(comparison, cmif).height(Height::Px(300.0))],
    }
}

/// The largest singular values over frequency, with the natural frequencies and the
/// borders of the fitted band.
pub(super) fn chart(comparison: &Comparison, cmif: &Cmif) -> Chart {
    let values = &cmif.values;
    let highest = values.iter().copied().fold(f64::NAN, f64::max);
    let lowest = values
        .column(cmif.shown() - 1)
        .iter()
        .copied()
        .filter(|v| *v > 0.0)
        .fold(f64::NAN, f64::min);
    let top = level(highest);
    // levels near the rounding error of the largest value are no signal
    let bottom = level(lowest.max(highest * 1e-12)).max(top - 1.4 * sizes::AMPLITUDE_RANGE_DB);
    let axis = Axis::linear("Singular value", &cmif.quantity.level_unit())
        .range([bottom - 3.0, top + 5.0]);
    let mut chart = Chart::new(frequency_axis(comparison), axis);
    chart = chart.with(pole_lines(&natural_frequencies(comparison.model)));
    if let Some(band) = band_lines(comparison) {
        chart = chart.with(band);
    }
    let names = [
        "largest singular value",
        "second",
        "third",
        "fourth",
        "fifth",
        "sixth",
    ];
    let dashes = [
        Dash::Solid,
        Dash::Solid,
        Dash::Dashed,
        Dash::Dashed,
        Dash::Dotted,
        Dash::Dotted,
    ];
    for k in 0..cmif.shown() {
        let points: Vec<Place> = comparison
            .frequency_hz
            .iter()
            .zip(values.column(k))
            .map(|(&f, &v)| [f, level(v)])
            .collect();
        let stroke = Stroke::new(
            if k == 0 {
                Colour::Ink
            } else {
                Colour::Series(k as u8 - 1)
            },
            if k == 0 { 1.6 } else { 1.2 },
        );
        chart = chart.line(names[k], points, stroke.dashed(dashes[k]));
    }
    chart
}
