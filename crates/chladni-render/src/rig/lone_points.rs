//! Points whose value no motion of the panel explains: speckle, a mirror, a bumped tripod.
//!
//! Whatever the channels and the poles do, a field stays a sum of the columns of the mobility, but
//! for its noise. Without point k, these leave d_k = e_k/(1 − h_kk) of it, with the residual e of
//! all points and the leverage h (R. D. Cook, S. Weisberg, *Residuals and Influence in
//! Regression*, 1982, chapter 2). One point that is off would otherwise pass for odd channels.

use super::field::{rms, LaidField};
use crate::panel::kernel_error::unsolvable;
use crate::tolerances;
use chladni_frf::{Dof, Finding, Result};
use chladni_linalg::blocked::range;
use chladni_linalg::lstsq;
use ndarray::{concatenate, Array1, Array2, Axis};
use num_complex::Complex64;

/// Sets the values of lone points to what all others tell of them.
///
/// * `mobility`: at the rows of `field`
/// * `all`: the responses of the operator
///
/// # Errors
/// Those of the factorisation.
pub(super) fn without_lone_points(
    field: &mut LaidField,
    mobility: &Array2<Complex64>,
    all: &[Dof],
) -> Result<Option<Finding>> {
    if field.magnitudes_only {
        return Ok(None);
    }
    let Some(motions) = motions(mobility)? else {
        return Ok(None);
    };
    let responses: Vec<Dof> = field.rows.iter().map(|&row| all[row]).collect();
    let mut basis = motions.clone();
    let most = (responses.len() / tolerances::ONE_LONE_OF).max(1);
    let mut lone: Vec<usize> = Vec::new();
    while let Some(place) = loneliest(&basis, &field.velocity) {
        if lone.len() == most {
            // so many are no exceptions: the field as a whole is another one
            return Ok(None);
        }
        lone.push(place);
        let alone = Array2::from_shape_fn((responses.len(), 1), |(k, _)| {
            Complex64::from(f64::from(u8::from(k == place)))
        });
        let new = left(&basis, &alone.column(0).to_owned());
        let size = new.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
        let new = new.mapv(|value| value / size).insert_axis(Axis(1));
        basis = concatenate![Axis(1), basis, new];
    }
    if lone.is_empty() {
        return Ok(None);
    }
    let others: Vec<usize> = (0..responses.len()).filter(|k| !lone.contains(k)).collect();
    let measured = field.velocity.select(Axis(0), &others).insert_axis(Axis(1));
    let sizes = lstsq(motions.select(Axis(0), &others).view(), measured.view());
    let told = motions.dot(&sizes.map_err(unsolvable)?.column(0));
    let values: Vec<(usize, Complex64)> = lone.iter().map(|&k| (k, told[k])).collect();
    field.replace(&values);
    let names: Vec<String> = lone.iter().map(|&k| responses[k].to_string()).collect();
    let words = format!(
        "no motion of the panel explains the field at {}: the value that all other points predict is \
         used there",
        names.join(", ")
    );
    Ok(Some(
        Finding::caution("field-point-off", words)
            .dofs(lone.iter().map(|&k| responses[k]))
            .help("measure these points again; look for dust, a speckle, a reflection"),
    ))
}

/// The motions that the channels can make, as columns of unit length; `None` where the points are
/// too few to tell of any other.
///
/// # Errors
/// Those of the factorisation.
pub(super) fn motions(mobility: &Array2<Complex64>) -> Result<Option<Array2<Complex64>>> {
    if mobility.nrows() <= mobility.ncols() + tolerances::SPARE_POINTS {
        return Ok(None);
    }
    let mut unit = mobility.clone();
    for mut column in unit.columns_mut() {
        let size = column.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
        column.mapv_inplace(|value| value / size.max(f64::MIN_POSITIVE));
    }
    let motions = range(unit.view(), tolerances::FIELD_RANK).map_err(unsolvable)?;
    Ok(Some(motions))
}

/// The part of a field outside `basis`.
pub(super) fn left(basis: &Array2<Complex64>, field: &Array1<Complex64>) -> Array1<Complex64> {
    let sizes = basis.t().mapv(|value| value.conj()).dot(field);
    field - &basis.dot(&sizes)
}

/// The point that fits the others least, where that is beyond doubt.
fn loneliest(basis: &Array2<Complex64>, field: &Array1<Complex64>) -> Option<usize> {
    let residual = left(basis, field);
    let squares = residual.mapv(|value| value.norm_sqr());
    let (all, size) = (squares.sum(), rms(field));
    let freedom = field.len().checked_sub(basis.ncols() + 1)?;
    if freedom == 0 {
        return None;
    }
    let off = |k: usize| {
        let free = 1.0 - basis.row(k).iter().map(|v| v.norm_sqr()).sum::<f64>();
        if free < tolerances::LEAST_FREE {
            return None;
        }
        let own = squares[k] / free;
        let noise = ((all - own).max(0.0) / freedom as f64).sqrt();
        let beyond = own.sqrt() > tolerances::LONE_DEVIATIONS * noise;
        let large = squares[k].sqrt() / free > tolerances::LONE_SIZE * size;
        (beyond && large).then_some((k, own))
    };
    let points = (0..field.len()).filter_map(off);
    points.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| k)
}
