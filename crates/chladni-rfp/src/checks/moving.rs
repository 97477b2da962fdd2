//! Poles that move between FRFs: a roving sensor whose mass loads the structure,
//! temperature, a clamp that settles. One set of poles then contradicts the data as a
//! whole, however well each FRF could be fitted by itself.

use crate::checks::case::{Case, Checked};
use crate::checks::limits;
use crate::damping::measured_model::frf_matrix;
use crate::data::columns::Columns;
use crate::model::given::value_of;
use crate::poles::refine::refine;
use crate::tolerances as tol;
use chladni_frf::{Damping, Finding, Mode};
use ndarray::{Array1, Array2, ShapeBuilder};
use num_complex::Complex64;
use std::ops::Range;

/// Lets every FRF have its own pole near each mode.
pub(crate) fn moving_poles(case: &Case) -> Option<Checked> {
    if case.white || case.data.pairs.len() < 2 {
        return None;
    }
    let modes: Vec<&Mode> = case.model.in_band_modes().collect();
    let scatter: Vec<f64> = modes
        .iter()
        .filter_map(|mode| scatter(case, mode))
        .collect();
    let moving: Vec<f64> = scatter
        .iter()
        .copied()
        .filter(|s| *s > limits::MOVES)
        .collect();
    if moving.is_empty() || (moving.len() as f64) < limits::SHARE * scatter.len() as f64 {
        return None;
    }
    let most = moving.iter().copied().fold(0.0, f64::max);
    let words = format!(
        "poles differ between FRFs: {} of {} modes scatter by more than {} half-bandwidths (at \
         most {most:.1}): a roving sensor's mass, temperature, or a support that changes",
        moving.len(),
        scatter.len(),
        limits::MOVES
    );
    let finding = Finding::fault("moving-poles", words)
        .value("scatter_half_bandwidths", most)
        .help("measure with a fixed mass dummy, or fit the FRFs of each set-up by themselves");
    Some(finding.into())
}

/// Rms distance, in half-bandwidths along the frequency axis, of the FRFs' own poles from
/// their mean, weighted by strength; noise taken off. `None` where the mode cannot be
/// looked at by itself.
fn scatter(case: &Case, mode: &Mode) -> Option<f64> {
    let lambda = pole(case, mode);
    let near =
        |other: &Mode| other != mode && (pole(case, other).re - lambda.re).abs() < 2.0 * lambda.im;
    if lambda.im <= 0.0 || case.model.in_band_modes().any(near) {
        return None;
    }
    let frfs = strongest(case, mode, limits::MOVING_FRFS_MOST);
    let (local, own) = neighbourhood(case, mode, limits::MOVING_WINDOW, limits::MOVING_FRFS_MOST)?;
    let (mut places, mut noise, mut total) = (Vec::new(), 0.0, 0.0);
    for (column, &(strength, _)) in frfs.iter().enumerate() {
        let single = local.with_columns(own.slice(ndarray::s![.., column..column + 1]).to_owned());
        let Ok(fit) = refine(&single, &[lambda], &[0], tol::REFINE_FINE, tol::ROUGH_STEP) else {
            continue;
        };
        let weight = strength * strength;
        // half of E|δλ|² lies along the frequency axis
        noise += weight * 0.5 * fit.variance(&single)
            / fit.information(&single)[[0, 0]].re.max(f64::MIN_POSITIVE);
        places.push((
            weight,
            ((fit.lambda[0].re - lambda.re) / lambda.im).clamp(-4.0, 4.0),
        ));
        total += weight;
    }
    if places.len() < 2 || total <= 0.0 {
        return None;
    }
    let mean = places.iter().map(|(w, d)| w * d).sum::<f64>() / total;
    let variance = places
        .iter()
        .map(|(w, d)| w * (d - mean).powi(2))
        .sum::<f64>()
        / total;
    let noise = noise / total / lambda.im.powi(2);
    Some(
        if variance > limits::OVER_NOISE * limits::OVER_NOISE * noise {
            (variance - noise).sqrt()
        } else {
            0.0
        },
    )
}

/// λ of a mode in the plane x = ω²/ω_max².
pub(crate) fn pole(case: &Case, mode: &Mode) -> Complex64 {
    let value = value_of(mode, case.model.damping, case.data.omega_max);
    match case.model.damping {
        Damping::Structural => value,
        Damping::Viscous => -value * value,
    }
}

/// |residue| of a mode in an FRF, in the mode's own scaling.
pub(crate) fn strength(mode: &Mode, (i, j): (usize, usize)) -> f64 {
    (mode.shape.0[i] * mode.participation.0[j]).norm()
}

/// (strength, position) of the FRFs that show a mode best.
fn strongest(case: &Case, mode: &Mode, most: usize) -> Vec<(f64, usize)> {
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
/// sides), and its strongest FRFs there without what the model says of all other modes
/// and residual terms; `None` without the data.
pub(crate) fn neighbourhood(
    case: &Case,
    mode: &Mode,
    reach: (f64, usize),
    frfs_most: usize,
) -> Option<(Columns, Array2<Complex64>)> {
    let rows = case.data.axis().window(pole(case, mode), reach.0, reach.1);
    let frfs: Vec<usize> = strongest(case, mode, frfs_most)
        .into_iter()
        .map(|(_, l)| l)
        .collect();
    without_others(case, &[mode], rows, &frfs)
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
