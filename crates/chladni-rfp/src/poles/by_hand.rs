//! Modes that the user has seen: they are fitted with the others whatever the evidence, and
//! graded like them.

use super::limits::{BY_HAND_EXPLAINED, BY_HAND_NARROWEST, CARRIED_AWAY};
use crate::data::columns::Columns;
use crate::poles::scan::usual_loss;
use num_complex::Complex64;

/// Starting poles at those of the frequencies `added_hz` that no `known` pole explains.
///
/// * `hz`: frequency of x = 1
pub(crate) fn starts(
    added_hz: &[f64],
    work: &Columns,
    known: &[Complex64],
    hz: f64,
) -> Vec<Complex64> {
    let loss = usual_loss(work, known);
    let start = |added_hz: &f64| {
        let x = (added_hz / hz).powi(2);
        Complex64::new(x, (loss * x).max(BY_HAND_NARROWEST * work.spacing(x)))
    };
    let explains = |start: &Complex64, pole: &Complex64| {
        (pole.re - start.re).abs() < BY_HAND_EXPLAINED * pole.im.max(work.spacing(start.re))
    };
    let starts = added_hz.iter().map(start);
    starts
        .filter(|start| work.in_band(*start))
        .filter(|start| !known.iter().any(|pole| explains(start, pole)))
        .collect()
}

/// The refined `pole` if it has stayed near its `start`, else the start.
pub(crate) fn held(work: &Columns, start: Complex64, pole: Complex64) -> Complex64 {
    let near = CARRIED_AWAY * start.im.max(work.spacing(start.re));
    match work.in_band(pole) && pole.im > 0.0 && (pole.re - start.re).abs() < near {
        true => pole,
        false => start,
    }
}
