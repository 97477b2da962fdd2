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
    let mut first = 0;
    let (blocks, rest) = x.as_chunks::<LANES>();
    let (weights_of_blocks, rest_weights) = g.as_chunks::<LANES>();
    // lanes beyond the last line weigh nothing
    let (mut last, mut last_weights) = ([x.last().copied().unwrap_or(0.0); LANES], [0.0; LANES]);
    last[..rest.len()].copy_from_slice(rest);
    last_weights[..rest.len()].copy_from_slice(rest_weights);
    let last = [(&last, &last_weights)]
        .into_iter()
        .filter(|_| !rest.is_empty());
    for (places, weights) in blocks.iter().zip(weights_of_blocks).chain(last) {
        let some = first..(first + LANES).min(x.len());
        let [value, slope] = of_pole.at(first, places, weights);
        sums[0] = sums[0] + value * *weights;
        value.write(&mut column[some.clone()]);
        if BOTH {
            sums[1] = sums[1] - slope * *weights;
            slope.write(&mut derivative[some]);
        }
        first += LANES;
    }
    sums.map(|lanes| lanes.sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::damping::columns::resonance;
    use crate::data::window::kinds::Window;
    use crate::data::window::leakage::{Leakage, LeakingLines};
    use chladni_frf::Damping;
    use ndarray::Array2;
    use std::sync::Arc;

    /// Lines 1/500 of ω_max apart, as many as eight does not divide.
    fn lines(law: Damping, window: Option<Window>) -> Columns {
        let y: Vec<f64> = (280..301).map(|line| f64::from(line) / 500.0).collect();
        let x: Vec<f64> = y.iter().map(|y| y * y).collect();
        let leaking = window.and_then(Window::kernel).map(|kernel| {
            let leakage = Leakage::new(kernel, 500.0 * std::f64::consts::TAU, 1);
            LeakingLines::new(Arc::new(leakage), &x)
        });
        Columns {
            b: Array2::zeros((x.len(), 0)),
            g: y,
            x,
            law,
            leakage: leaking,
            neighbours: 0.0,
        }
    }

    #[test]
    fn lines_together_are_each_by_itself() {
        let windows = [
            None,
            Some(Window::Transient),
            Some(Window::Hann),
            Some(Window::Kaiser { beta: 8.6 }),
            Some(Window::Burst { part: 1.0 }),
            Some(Window::HannBurst { part: 0.5 }),
        ];
        // beside a line, between two, below the axis
        let poles = [
            (0.58 * 0.58, 1e-6),
            (0.581 * 0.581, 4e-3),
            (0.57 * 0.57, -2e-3),
        ];
        for (window, law) in windows
            .iter()
            .flat_map(|window| [(window, Damping::Structural), (window, Damping::Viscous)])
        {
            let work = lines(law, *window);
            for pole in poles.map(|(re, im)| Complex64::new(re, im)) {
                let (mut column, mut slope) =
                    (vec![Complex64::ZERO; 21], vec![Complex64::ZERO; 21]);
                fill(&work, pole, &mut column, None);
                let alone = column.clone();
                fill(&work, pole, &mut column, Some(&mut slope));
                assert_eq!(alone, column, "{window:?} {law:?} {pole}");
                for k in 0..work.lines() {
                    let (x, g) = ([work.x[k]], [work.g[k]]);
                    let single = match &work.leakage {
                        Some(leaking) => LeakingColumn::new(law, leaking, pole).at(k, &x, &g),
                        None => PlainColumn::new(law, pole).at(k, &x, &g),
                    };
                    let both = single.map(|lanes| lanes.get(0));
                    if window.is_none() {
                        let plain = resonance(law, pole, work.x[k]) * work.g[k];
                        assert!((both[0] - plain).norm() < 1e-14 * plain.norm());
                    }
                    for (one, many) in both.iter().zip([column[k], slope[k]]) {
                        assert!(one.is_finite(), "{window:?} {law:?} {pole} {k}");
                        assert!(
                            (one - many).norm() <= 1e-14 * one.norm(),
                            "{window:?} {law:?} {pole} {k}: {one} {many}"
                        );
                    }
                }
            }
        }
    }
}
