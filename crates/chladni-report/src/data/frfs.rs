//! Measured FRFs in few bytes: every pair on chosen lines as small numbers, some pairs in
//! full.
//!
//! The page synthesises any pair from the model. Of a measured FRF it carries the
//! residual (measured − synthesised) on blocks of [`BLOCK`] lines with a common scale and
//! 8 bits per part: the step is 1/127 of the largest residual of the block, so that noise
//! keeps 30 steps per standard deviation and the measured curve is as good as the
//! residual is small. Without a model the residual is the FRF itself.

use super::array::{complex, f32s, f64s, i8s, u32s};
use super::lines::thinned;
use crate::comparison::{Comparison, Sums};
use crate::sizes;
use crate::sizes::BLOCK;
use chladni_frf::ModalModel;
use num_complex::Complex64;
use rayon::prelude::*;
use serde_json::{json, Value};

/// Stands for a value that was not measured.
const MISSING: i8 = i8::MIN;

/// Sums over all FRFs, the pairs on offer, residuals.
pub(crate) fn value(comparison: &Comparison) -> Value {
    let sums = comparison.sums();
    let frequency_hz = comparison.frequency_hz.to_vec();
    let lines = thinned(&frequency_hz, comparison.model, sizes::SHOWN_LINES);
    let offered = [
        offered(comparison.responses.len()),
        offered(comparison.references.len()),
    ];
    json!({
        "quantity": comparison.quantity.name(),
        "unit": comparison.quantity.level_unit(),
        "total_lines": frequency_hz.len(),
        "lines": f64s(lines.iter().map(|&line| &frequency_hz[line])),
        "sums": sums_value(&sums, &lines),
        "responses": offered[0],
        "references": offered[1],
        "response_names": offered[0].iter().map(|&i| comparison.responses[i]).collect::<Vec<_>>(),
        "reference_names": offered[1].iter().map(|&j| comparison.references[j]).collect::<Vec<_>>(),
        "total_pairs": comparison.pair_count(),
        "terms": comparison.model.map(|model| terms(model, &offered)),
        "errors": sums.error.as_ref().map(|error| f32s(pairs(&offered).map(|(i, j)| error[[i, j]]))),
        "residuals": comparison.measured.as_ref().map(|_| residuals(comparison, &offered)),
        "full": full(comparison, &sums, &lines),
    })
}

/// All DOFs, or evenly chosen ones where a page cannot carry all their pairs.
fn offered(count: usize) -> Vec<usize> {
    let shown = count.min(sizes::OFFERED_DOFS);
    (0..shown).map(|k| k * count / shown.max(1)).collect()
}

fn pairs(offered: &[Vec<usize>; 2]) -> impl Iterator<Item = (usize, usize)> + '_ {
    offered[0]
        .iter()
        .flat_map(|&i| offered[1].iter().map(move |&j| (i, j)))
}

fn sums_value(sums: &Sums, lines: &[usize]) -> Value {
    let curve = |curve: &Option<Vec<f64>>| {
        curve
            .as_ref()
            .map(|curve| f32s(lines.iter().map(|&line| curve[line])))
    };
    json!({"measured": curve(&sums.measured), "synthesis": curve(&sums.synthesis), "residual": curve(&sums.difference)})
}

/// Residual terms of the pairs that [`value`] offers.
pub(crate) fn model_terms(model: &ModalModel) -> Value {
    terms(
        model,
        &[
            offered(model.responses.len()),
            offered(model.references.len()),
        ],
    )
}

/// Residual terms of the offered pairs: axes (term, response, reference).
fn terms(model: &ModalModel, offered: &[Vec<usize>; 2]) -> Value {
    let terms = &model.residual_terms.terms;
    complex(
        terms
            .iter()
            .flat_map(|term| pairs(offered).map(|(i, j)| &term.matrix.0[[i, j]])),
    )
}

/// Residuals of all offered pairs: axes (pair, line, part) beside one scale per pair and
/// block.
fn residuals(comparison: &Comparison, offered: &[Vec<usize>; 2]) -> Value {
    let frequency_hz = comparison.frequency_hz.to_vec();
    let wanted: Vec<(usize, usize)> = pairs(offered).collect();
    let lines = thinned(
        &frequency_hz,
        comparison.model,
        sizes::RESIDUAL_BYTES / 2 / wanted.len().max(1),
    );
    // the matrix of a line serves all pairs
    let by_line: Vec<Vec<Complex64>> = lines
        .par_iter()
        .map(|&line| {
            let synthesis = comparison
                .model
                .map(|model| model.frf_matrix(model.frf_kind, frequency_hz[line]));
            let of = |&(i, j): &(usize, usize)| {
                let value = comparison
                    .measured
                    .as_ref()
                    .map_or(Complex64::new(f64::NAN, 0.0), |measured| {
                        measured.value(i, j, line)
                    });
                value
                    - synthesis
                        .as_ref()
                        .map_or(Complex64::ZERO, |synthesis| synthesis[[i, j]])
            };
            wanted.iter().map(of).collect()
        })
        .collect();
    let (mut scales, mut values) = (
        Vec::new(),
        Vec::with_capacity(2 * wanted.len() * lines.len()),
    );
    for pair in 0..wanted.len() {
        let curve: Vec<Complex64> = by_line.iter().map(|line| line[pair]).collect();
        for block in curve.chunks(BLOCK) {
            let (scale, small) = quantised(block);
            scales.push(scale);
            values.extend(small);
        }
    }
    json!({"block": BLOCK, "lines": u32s(lines.iter().copied()), "frequency_hz": f64s(lines.iter().map(|&line| &frequency_hz[line])),
        "scales": f32s(scales), "values": i8s(&values)})
}

/// A scale, and the parts of the values in units of it.
fn quantised(block: &[Complex64]) -> (f64, Vec<i8>) {
    let largest = block
        .iter()
        .filter(|value| value.is_finite())
        .flat_map(|value| [value.re.abs(), value.im.abs()])
        .fold(0.0, f64::max);
    let scale = largest / 127.0;
    let part = |part: f64| match scale > 0.0 {
        true => (part / scale).round().clamp(-127.0, 127.0) as i8,
        false => 0,
    };
    let parts = |value: &Complex64| {
        if value.is_finite() {
            [part(value.re), part(value.im)]
        } else {
            [MISSING; 2]
        }
    };
    (scale, block.iter().flat_map(parts).collect())
}

/// The pairs that tell most, on all shown lines.
fn full(comparison: &Comparison, sums: &Sums, lines: &[usize]) -> Value {
    let of = |pair: &crate::comparison::Pair| {
        let [measured, _] = comparison.curves(pair);
        json!({
            "response": pair.response, "reference": pair.reference, "label": pair.label, "why": pair.why,
            "measured": measured.map(|curve| complex(lines.iter().map(|&line| &curve[line]).collect::<Vec<_>>())),
        })
    };
    comparison
        .pairs(sums)
        .iter()
        .map(of)
        .collect::<Vec<_>>()
        .into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantised_block_is_within_half_a_step_and_marks_gaps() {
        let block: Vec<Complex64> = (0..BLOCK)
            .map(|k| Complex64::from_polar(0.1 + 0.03 * k as f64, 1.7 * k as f64))
            .collect();
        let (scale, small) = quantised(&block);
        for (value, parts) in block.iter().zip(small.chunks(2)) {
            let back = Complex64::new(f64::from(parts[0]), f64::from(parts[1])) * scale;
            assert!(
                (value.re - back.re).abs() <= 0.5001 * scale
                    && (value.im - back.im).abs() <= 0.5001 * scale
            );
        }
        assert_eq!(
            quantised(&[Complex64::new(f64::NAN, 0.0), Complex64::ONE]).1[..2],
            [MISSING; 2]
        );
        assert_eq!(quantised(&[Complex64::ZERO; 2]), (0.0, vec![0; 4]));
    }
}
