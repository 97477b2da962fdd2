//! Twins: two poles that stand for one mode which moves between FRFs (roving mass,
//! temperature).

use super::limits::{
    OWN_OVER_PAIR, SAME_SHAPE_MAC, SHAPE_LEAST_COLUMNS, TWINS_NEAR, TWINS_STEPS, TWINS_WINDOW,
};
use crate::damping::structural::basis;
use crate::data::columns::Columns;
use crate::measured::candidates::{Candidates, Change};
use crate::measured::local::Neighbourhood;
use crate::poles::refine::{refine, Refined};
use crate::tolerances as tol;
use chladni_frf::Finding;
use chladni_linalg::{lstsq, matmul, LinalgError};
use ndarray::{s, Array2};
use num_complex::Complex64;

/// Own pole of each FRF near `pole`: local fit of one pole and a constant, the other
/// poles' part taken off.
pub(crate) fn own_poles(
    work: &Columns,
    refined: &Refined,
    poles: &[usize],
) -> Result<(Vec<Complex64>, f64, f64), LinalgError> {
    let centre = poles.iter().map(|&q| refined.lambda[q]).sum::<Complex64>() / poles.len() as f64;
    let width = poles
        .iter()
        .map(|&q| refined.lambda[q].im)
        .fold(0.0, f64::max);
    let rows: Vec<usize> = work
        .window(
            Complex64::new(centre.re, width),
            TWINS_WINDOW.0,
            TWINS_WINDOW.1,
        )
        .collect();
    let local = work.select(&rows);
    let mut shapes = basis(&local, &refined.lambda, &refined.powers);
    for &q in poles {
        shapes.column_mut(q).fill(Complex64::new(0.0, 0.0));
    }
    let rest = &local.b - &matmul(shapes.view(), refined.coefficients.view());
    let pair_residual: f64 = {
        let columns = basis(
            &local,
            &poles.iter().map(|&q| refined.lambda[q]).collect::<Vec<_>>(),
            &[0],
        );
        let solution = lstsq(columns.view(), rest.view())?;
        (&rest - &matmul(columns.view(), solution.view()))
            .iter()
            .map(|v| v.norm_sqr())
            .sum()
    };
    let mut own = Vec::new();
    let mut own_residual = 0.0;
    for l in 0..work.columns() {
        let column: Array2<Complex64> = rest.slice(s![.., l..l + 1]).to_owned();
        let single = refine(
            &local.with_columns(column),
            &[Complex64::new(centre.re, width)],
            &[0],
            tol::ROUGH.within(TWINS_STEPS),
        )?;
        own.push(single.lambda[0]);
        own_residual += single.projection.sse;
    }
    Ok((own, own_residual, pair_residual))
}

/// Merges twins; returns a note for each merger, with the pole it left.
pub(crate) fn merge(
    work: &Columns,
    candidates: &mut Candidates,
    omega_to_hz: f64,
) -> Result<Vec<(Complex64, Finding)>, LinalgError> {
    let mut notes = Vec::new();
    while let Some((a, b, own)) = if work.columns() < 2 {
        None
    } else {
        find(work, &candidates.refined)?
    } {
        let refined = &candidates.refined;
        let mean = own.iter().sum::<Complex64>() / own.len() as f64;
        let start = if work.in_band(mean) && mean.im > 0.0 {
            mean
        } else {
            0.5 * (refined.lambda[a] + refined.lambda[b])
        };
        let (mut moved, fit) =
            Neighbourhood::around(work, refined, start).replace(refined, &[a, b], &[start])?;
        moved.extend(fit.lambda.last().map(|&pole| (a, pole)));
        candidates.apply(
            work,
            vec![Change {
                removed: Some(b),
                moved,
                added: None,
            }],
        )?;
        let spread =
            (own.iter().map(|p| (p - mean).norm_sqr()).sum::<f64>() / own.len() as f64).sqrt();
        let place = start.re.max(0.0).sqrt() * omega_to_hz;
        let scatter = spread / (2.0 * start.re.max(f64::MIN_POSITIVE).sqrt()) * omega_to_hz;
        let note = Finding::note(
            "merged-twins",
            format!(
                "two poles near {place:.2} Hz are one mode that differs between FRFs (scatter \
                 {scatter:.2} Hz): merged"
            ),
        )
        .modes_hz([place])
        .value("scatter_hz", scatter);
        notes.push((start, note));
    }
    Ok(notes)
}

/// A pair that is one mode, with the own poles of the FRFs.
fn find(
    work: &Columns,
    refined: &Refined,
) -> Result<Option<(usize, usize, Vec<Complex64>)>, LinalgError> {
    let n = refined.lambda.len();
    for (a, b) in (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b))) {
        let (pa, pb) = (refined.lambda[a], refined.lambda[b]);
        if !work.in_band(pa)
            || !work.in_band(pb)
            || (pa.re - pb.re).abs() >= TWINS_NEAR * pa.im.max(pb.im)
        {
            continue;
        }
        let (own, own_sse, pair_sse) = own_poles(work, refined, &[a, b])?;
        let shape = |q: usize| refined.coefficients.row(q).to_vec();
        let same_shape = work.columns() >= SHAPE_LEAST_COLUMNS
            && crate::validation::mac::mac(&shape(a), &shape(b)) > SAME_SHAPE_MAC;
        if own_sse < OWN_OVER_PAIR * pair_sse || same_shape {
            return Ok(Some((a, b, own)));
        }
    }
    Ok(None)
}
