//! Twins: two poles that stand for one mode which moves between FRFs (roving mass,
//! temperature).
//!
//! One pole for each FRF has as many unknowns as two common ones, and to first order both fit two
//! close modes and a moving one. What is left of each FRF tells them apart. FRFs are compared one
//! by one: of noise that follows the FRFs the strongest hold most, and say least.

use super::limits::{
    MAY_BE_ONE, ONE_MODE, OWN_OVER_PAIR, SAME_SHAPE_MAC, SHAPE_LEAST_COLUMNS, TWINS_NEAR,
    TWINS_STEPS, TWINS_WINDOW,
};
use crate::damping::basis::basis;
use crate::data::columns::Columns;
use crate::measured::candidates::{Candidates, Change, Origin};
use crate::measured::local::Neighbourhood;
use crate::poles::refine::{refine, Refined};
use crate::tolerances as tol;
use chladni_frf::Finding;
use chladni_linalg::{lstsq, matmul, LinalgError};
use ndarray::{s, Array2};
use num_complex::Complex64;

/// A pole for each FRF in place of common ones.
pub(crate) struct OwnPoles {
    /// One for each FRF.
    pub poles: Vec<Complex64>,
    /// Energy that they leave over that which the common poles leave, of all FRFs.
    over_common: f64,
    /// The same as a geometric mean over the FRFs.
    over_common_each: f64,
}

/// Own pole of each FRF near `pole`: local fit of one pole and a constant, the other
/// poles' part taken off.
pub(crate) fn own_poles(
    work: &Columns,
    refined: &Refined,
    poles: &[usize],
) -> Result<OwnPoles, LinalgError> {
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
    let common: Vec<Complex64> = poles.iter().map(|&q| refined.lambda[q]).collect();
    let columns = basis(&local, &common, &[0]);
    let solution = lstsq(columns.view(), rest.view())?;
    let left = &rest - &matmul(columns.view(), solution.view());
    let (mut own, mut sums, mut logarithms) = (Vec::new(), [0.0; 2], 0.0);
    for l in 0..work.columns() {
        let column: Array2<Complex64> = rest.slice(s![.., l..l + 1]).to_owned();
        let single = refine(
            &local.with_columns(column),
            &[Complex64::new(centre.re, width)],
            &[0],
            tol::ROUGH.within(TWINS_STEPS),
        )?;
        own.push(single.lambda[0]);
        let of_common: f64 = left.column(l).iter().map(|v| v.norm_sqr()).sum();
        let of_own = single.projection.sse;
        sums = [sums[0] + of_own, sums[1] + of_common];
        logarithms += of_own.max(f64::MIN_POSITIVE).ln() - of_common.max(f64::MIN_POSITIVE).ln();
    }
    Ok(OwnPoles {
        over_common: sums[0] / sums[1].max(f64::MIN_POSITIVE),
        over_common_each: (logarithms / own.len().max(1) as f64).exp(),
        poles: own,
    })
}

/// Merges twins; returns a note for each merger, with the pole it left.
pub(crate) fn merge(
    work: &Columns,
    candidates: &mut Candidates,
    omega_to_hz: f64,
) -> Result<Vec<(Complex64, Finding)>, LinalgError> {
    let mut notes = Vec::new();
    while let Some(Twins { a, b, own, why }) = if work.columns() < 2 {
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
        if why == Why::MayBeOne {
            candidates.origin[a] = Origin::MayBeTwo;
        }
        let spread =
            (own.iter().map(|p| (p - mean).norm_sqr()).sum::<f64>() / own.len() as f64).sqrt();
        let place = start.re.max(0.0).sqrt() * omega_to_hz;
        let scatter = spread / (2.0 * start.re.max(f64::MIN_POSITIVE).sqrt()) * omega_to_hz;
        let (two, scatter_of) = (
            format!("two poles near {place:.2} Hz"),
            format!("(scatter {scatter:.2} Hz)"),
        );
        let note = match why {
            Why::Moves => Finding::note(
                "merged-twins",
                format!("{two} are one mode that differs between FRFs {scatter_of}: merged"),
            ),
            Why::OneShape => Finding::note(
                "merged-twins",
                format!("{two} have one shape, and are taken for one mode: merged"),
            ),
            Why::MayBeOne => Finding::caution(
                "merged-twins",
                format!(
                    "{two} may be one mode that differs between FRFs {scatter_of}, or two close \
                     modes: both explain the data about as well; merged"
                ),
            )
            .help("measure another reference, or average more"),
        }
        .modes_hz([place])
        .value("scatter_hz", scatter);
        notes.push((start, note));
    }
    Ok(notes)
}

/// Two poles that may be one mode.
struct Twins {
    a: usize,
    b: usize,
    /// The own poles of the FRFs.
    own: Vec<Complex64>,
    why: Why,
}

/// Evidence for one mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Why {
    /// Own poles of the FRFs explain them better.
    Moves,
    /// Both poles have one shape.
    OneShape,
    /// Own poles explain the FRFs about as well.
    MayBeOne,
}

/// A pair that is one mode, or may be.
fn find(work: &Columns, refined: &Refined) -> Result<Option<Twins>, LinalgError> {
    let n = refined.lambda.len();
    for (a, b) in (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b))) {
        let (pa, pb) = (refined.lambda[a], refined.lambda[b]);
        if !work.in_band(pa)
            || !work.in_band(pb)
            || (pa.re - pb.re).abs() >= TWINS_NEAR * pa.im.max(pb.im)
        {
            continue;
        }
        let own = own_poles(work, refined, &[a, b])?;
        let shape = |q: usize| refined.coefficients.row(q).to_vec();
        let same_shape = work.columns() >= SHAPE_LEAST_COLUMNS
            && crate::validation::mac::mac(&shape(a), &shape(b)) > SAME_SHAPE_MAC;
        let explains = own.over_common < OWN_OVER_PAIR;
        let why = match own.over_common_each {
            each if explains && each < ONE_MODE => Why::Moves,
            _ if same_shape => Why::OneShape,
            each if explains && each < MAY_BE_ONE => Why::MayBeOne,
            _ => continue,
        };
        let own = own.poles;
        return Ok(Some(Twins { a, b, own, why }));
    }
    Ok(None)
}
