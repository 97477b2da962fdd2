//! The lines around a mode, and its FRFs there without all other modes.

use crate::checks::case::Case;
use crate::checks::limits;
use crate::damping::measured_model::frf_matrix;
use crate::damping::places::{lambda_of_value, value_of};
use crate::data::columns::Columns;
use crate::validation::mac::mac;
use chladni_frf::{ModalModel, Mode};
use ndarray::{Array1, Array2, ShapeBuilder};
use num_complex::Complex64;
use std::ops::Range;

/// λ of a mode in the plane x = ω²/ω_max².
pub(crate) fn pole(case: &Case, mode: &Mode) -> Complex64 {
    let law = case.model.damping;
    lambda_of_value(law, value_of(mode, law, case.data.omega_max))
}

/// |residue| of a mode in an FRF, in the mode's own scaling.
pub(crate) fn strength(mode: &Mode, (i, j): (usize, usize)) -> f64 {
    (mode.shape.0[i] * mode.participation.0[j]).norm()
}

/// Poles of a model that a window may have made of one mode and `mode`: of one shape, and nearer
/// than lines tell.
pub(crate) fn window_pairs<'a>(model: &'a ModalModel, line_hz: f64, mode: &Mode) -> Vec<&'a Mode> {
    let is_pair = |other: &&Mode| {
        let distance = (other.frequency_hz - mode.frequency_hz).abs();
        let near = distance > 0.0 && distance < limits::ONE_LINE * line_hz;
        near && mac(&other.shape.0, &mode.shape.0) > limits::ONE_SHAPE
    };
    model.in_band_modes().filter(is_pair).collect()
}

/// (strength, position) of the FRFs that show a mode best.
pub(crate) fn strongest(case: &Case, mode: &Mode, most: usize) -> Vec<(f64, usize)> {
    let mut frfs: Vec<(f64, usize)> = case
        .data
        .pairs
        .iter()
        .map(|&pair| strength(mode, pair))
        .zip(0..)
        .collect();
    frfs.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    frfs.truncate(most);
    frfs
}

/// Lines around a mode (`reach`: half-bandwidths, and at least so many lines, on both
/// sides), and its strongest FRFs there without what the model says of all modes but it and its
/// `partners`, and of residual terms; `None` without the data.
pub(crate) fn neighbourhood(
    case: &Case,
    mode: &Mode,
    partners: &[&Mode],
    reach: (f64, usize),
    frfs_most: usize,
) -> Option<(Columns, Array2<Complex64>)> {
    let rows = case.data.axis().window(pole(case, mode), reach.0, reach.1);
    let frfs: Vec<usize> = strongest(case, mode, frfs_most)
        .into_iter()
        .map(|(_, l)| l)
        .collect();
    without_others(case, &[&[mode], partners].concat(), rows, &frfs)
}

/// FRFs (positions among the pairs) on the lines `rows` without what the model says of
/// all but `modes`; `None` without the data.
pub(crate) fn without_others(
    case: &Case,
    modes: &[&Mode],
    rows: Range<usize>,
    frfs: &[usize],
) -> Option<(Columns, Array2<Complex64>)> {
    let data = case.values?;
    let (responses, of_response) = numbered(frfs.iter().map(|&l| data.pairs[l].0));
    let (references, of_reference) = numbered(frfs.iter().map(|&l| data.pairs[l].1));
    let mut others = case.model.at_dofs(&responses, &references);
    let mut is_other = case.model.modes.iter().map(|mode| !modes.contains(&mode));
    others.modes.retain(|_| is_other.next() == Some(true));
    let mut own = Array2::zeros((rows.len(), frfs.len()).f());
    for (column, &l) in frfs.iter().enumerate() {
        own.column_mut(column)
            .assign(&data.block(l..l + 1, rows.clone()).column(0));
    }
    let factor = data.factor();
    let weights: Vec<f64> = frfs
        .iter()
        .map(|&l| data.weight_of(data.pairs[l]))
        .collect();
    for (row, k) in rows.clone().enumerate() {
        let leakage = data.leakage.as_deref();
        let in_units = (data.kind, data.omega_max);
        let rest = frf_matrix(&others, leakage, in_units, data.line_hz[k]);
        let rest: Array1<Complex64> = of_response
            .iter()
            .zip(&of_reference)
            .zip(&weights)
            .map(|((&i, &j), &weight)| rest[[i, j]] * weight * factor)
            .collect();
        own.row_mut(row)
            .scaled_add(Complex64::new(-1.0, 0.0), &rest);
    }
    Some((data.axis().select(&rows.collect::<Vec<_>>()), own))
}

/// Each of `places` once, rising, and where each of them stands there.
fn numbered(places: impl Iterator<Item = usize> + Clone) -> (Vec<usize>, Vec<usize>) {
    let mut each: Vec<usize> = places.clone().collect();
    each.sort_unstable();
    each.dedup();
    let place = |place: usize| each.partition_point(|&other| other < place);
    let of = places.map(place).collect();
    (each, of)
}
