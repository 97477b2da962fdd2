//! Columns of poles written line by line: plain ones and their derivatives, in the law of the
//! lines, with what leaks where records leak.

use crate::damping::columns::{LeakingColumn, PlainColumn, PoleColumn};
use crate::damping::limits::LANES;
use crate::data::columns::Columns;
use crate::data::window::lanes::Lanes;
use chladni_linalg::wide;
use num_complex::Complex64;

/// Writes the column g/(λ − x) of a pole and, where it is asked for, its derivative, −g/(λ − x)²
/// in the structural law; returns Σ g²/(λ − x) and Σ g²/(λ − x)², the second with the derivative
/// alone, and neither where lines leak.
pub(super) fn fill(
    work: &Columns,
    pole: Complex64,
    column: &mut [Complex64],
    derivative: Option<&mut [Complex64]>,
) -> [Complex64; 2] {
    match &work.leakage {
        None => in_lanes(work, PlainColumn::new(work.law, pole), column, derivative),
        Some(leaking) => {
            let of_pole = LeakingColumn::new(work.law, leaking, pole);
            in_lanes(work, of_pole, column, derivative);
            [Complex64::ZERO; 2]
        }
    }
}

/// Writes the columns g·x^p of residual terms, one after the other.
pub(super) fn fill_terms(work: &Columns, powers: &[i32], columns: &mut [Complex64]) {
    let columns = columns.chunks_mut(work.lines().max(1));
    for (column, &power) in columns.zip(powers) {
        for ((value, &x), &g) in column.iter_mut().zip(&work.x).zip(&work.g) {
            *value = (g * x.powi(power)).into();
        }
    }
}

fn in_lanes(
    work: &Columns,
    of_pole: impl PoleColumn,
    column: &mut [Complex64],
    derivative: Option<&mut [Complex64]>,
) -> [Complex64; 2] {
    wide(
        #[inline(always)]
        || match derivative {
            None => written::<false>(work, of_pole, column, &mut []),
            Some(derivative) => written::<true>(work, of_pole, column, derivative),
        },
    )
}

#[inline(always)]
fn written<const BOTH: bool>(
    Columns { x, g, .. }: &Columns,
    of_pole: impl PoleColumn,
    column: &mut [Complex64],
    derivative: &mut [Complex64],
) -> [Complex64; 2] {
    let mut sums = [Lanes::<LANES>::ZERO; 2];
    for first in (0..x.len()).step_by(LANES) {
        let some = first..(first + LANES).min(x.len());
        // lanes beyond the last line weigh nothing
        let (mut places, mut weights) = ([x[first]; LANES], [0.0; LANES]);
        places[..some.len()].copy_from_slice(&x[some.clone()]);
        weights[..some.len()].copy_from_slice(&g[some.clone()]);
        let [value, slope] = of_pole.at(first, &places, &weights);
        sums[0] = sums[0] + value * weights;
        value.write(&mut column[some.clone()]);
        if BOTH {
            sums[1] = sums[1] - slope * weights;
            slope.write(&mut derivative[some]);
        }
    }
    sums.map(|lanes| lanes.sum())
}
