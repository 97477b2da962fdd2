//! Measured FRFs in few bytes: every pair on chosen lines with few bits, some pairs in full.
//!
//! The page synthesises any pair from the model. For measured FRFs it holds the residual
//! (measured − synthesised) in blocks of [`BLOCK`] lines with a common step. A part (real or
//! imaginary) of a residual has 4 bits: the step is 1/7 of the largest part of the block, and
//! rounding adds 1 % to the power of the noise. Without a model the residual is the FRF itself,
//! and a part has 8 bits.

use super::array::{complex, f32s, f64s, u32s, u8s};
use super::lines::thinned;
use crate::comparison::{Comparison, Sums};
use crate::sizes;
use crate::sizes::{BLOCK, STEP_CODES, STEP_RATIO};
use chladni_frf::ModalModel;
use num_complex::Complex64;
use rayon::prelude::*;
use serde_json::{json, Value};

/// Number of bits of a part of a residual.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Bits {
    /// Both parts in one byte.
    Four,
    /// A byte each.
    Eight,
}

impl Bits {
    /// Bits of a part.
    fn count(self) -> u8 {
        match self {
            Self::Four => 4,
            Self::Eight => 8,
        }
    }

    /// The largest part, in steps.
    fn top(self) -> f64 {
        match self {
            Self::Four => 7.0,
            Self::Eight => 127.0,
        }
    }

    /// The bytes of a residual in steps; zeros for one that was not measured.
    fn bytes(self, steps: Option<[f64; 2]>) -> Vec<u8> {
        let shifted =
            |part: f64| (part.round().clamp(-self.top(), self.top()) + self.top() + 1.0) as u8;
        let [re, im] = steps.map_or([0; 2], |steps| steps.map(shifted));
        match self {
            Self::Four => vec![16 * re + im],
            Self::Eight => vec![re, im],
        }
    }
}

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

/// Indices of all DOFs, or of evenly chosen ones where a page cannot hold all their pairs.
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

/// Residuals of all offered pairs, axes (pair, line), and a code of the step for each pair and
/// block (see [`coded_steps`]).
fn residuals(comparison: &Comparison, offered: &[Vec<usize>; 2]) -> Value {
    let frequency_hz = comparison.frequency_hz.to_vec();
    let wanted: Vec<(usize, usize)> = pairs(offered).collect();
    let lines = thinned(
        &frequency_hz,
        comparison.model,
        sizes::RESIDUALS / wanted.len().max(1),
    );
    // the synthesised matrix of a line serves all pairs
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
    let curves: Vec<Vec<Complex64>> = (0..wanted.len())
        .map(|pair| by_line.iter().map(|line| line[pair]).collect())
        .collect();
    let bits = match comparison.model {
        Some(_) => Bits::Four,
        None => Bits::Eight,
    };
    let blocks: Vec<&[Complex64]> = curves
        .iter()
        .flat_map(|curve| curve.chunks(BLOCK))
        .collect();
    let (least_step, codes) =
        coded_steps(blocks.iter().map(|block| largest_part(block) / bits.top()));
    let values = blocks
        .iter()
        .zip(&codes)
        .flat_map(|(block, &code)| quantised(block, step(least_step, code), bits));
    let values = u8s(values);
    json!({"block": BLOCK, "lines": u32s(lines.iter().copied()), "frequency_hz": f64s(lines.iter().map(|&line| &frequency_hz[line])),
        "bits": bits.count(), "least_step": least_step, "step_ratio": STEP_RATIO,
        "steps": u8s(codes), "values": values})
}

/// The least step, and a code in a byte for each step: 0 for the step 0, otherwise the step is
/// rounded up to [`STEP_RATIO`]^(code − 1) times the least. Steps below the range of the codes
/// are raised to the least.
fn coded_steps(steps: impl Iterator<Item = f64> + Clone) -> (f64, Vec<u8>) {
    let positive = || steps.clone().filter(|&step| step > 0.0);
    let largest = positive().fold(0.0, f64::max);
    let reached = largest * STEP_RATIO.powi(-i32::from(STEP_CODES));
    let least = positive().fold(f64::INFINITY, f64::min).max(reached);
    let code = |step: f64| match step > 0.0 {
        true => {
            1 + (step / least)
                .log(STEP_RATIO)
                .ceil()
                .clamp(0.0, f64::from(STEP_CODES)) as u8
        }
        false => 0,
    };
    let codes = steps.clone().map(code).collect();
    (if least.is_finite() { least } else { 0.0 }, codes)
}

/// The step of a code.
fn step(least_step: f64, code: u8) -> f64 {
    match code {
        0 => 0.0,
        code => least_step * STEP_RATIO.powi(i32::from(code) - 1),
    }
}

fn largest_part(block: &[Complex64]) -> f64 {
    block
        .iter()
        .filter(|value| value.is_finite())
        .flat_map(|value| [value.re.abs(), value.im.abs()])
        .fold(0.0, f64::max)
}

/// The values of a block in steps.
fn quantised(block: &[Complex64], step: f64, bits: Bits) -> Vec<u8> {
    let in_steps = |part: f64| if step > 0.0 { part / step } else { 0.0 };
    let steps = |value: &Complex64| {
        value
            .is_finite()
            .then(|| [in_steps(value.re), in_steps(value.im)])
    };
    block
        .iter()
        .flat_map(|value| bits.bytes(steps(value)))
        .collect()
}

/// The notable pairs, on all shown lines.
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
    use chladni_plate::add_noise_of_variance;
    use ndarray::Array3;

    #[test]
    fn a_quantised_block_is_within_half_a_step_and_marks_gaps() {
        let block: Vec<Complex64> = (0..BLOCK)
            .map(|k| Complex64::from_polar(0.1 + 0.03 * k as f64, 1.7 * k as f64))
            .collect();
        for (bits, top) in [(Bits::Four, 7.0), (Bits::Eight, 127.0)] {
            let (least, codes) = coded_steps([1e-9, largest_part(&block) / top].into_iter());
            let step = step(least, codes[1]);
            assert!((step * top / largest_part(&block) - 1.0) * (1.0 / (STEP_RATIO - 1.0)) <= 1.0);
            let bytes = quantised(&block, step, bits);
            let parts: Vec<f64> = match bits {
                Bits::Four => bytes
                    .iter()
                    .flat_map(|&byte| [byte >> 4, byte & 15])
                    .collect::<Vec<_>>(),
                Bits::Eight => bytes,
            }
            .iter()
            .map(|&part| (f64::from(part) - top - 1.0) * step)
            .collect();
            for (value, back) in block.iter().zip(parts.chunks(2)) {
                let error = (value - Complex64::new(back[0], back[1])).l1_norm();
                assert!(error <= 1.0001 * step, "{value} {back:?}");
            }
        }
    }

    #[test]
    fn rounding_adds_a_hundredth_to_the_power_of_noise() {
        let mut noise = Array3::zeros((1, 1, 64 * BLOCK));
        add_noise_of_variance(&mut noise, 1.0, 1);
        let noise = noise.into_raw_vec_and_offset().0;
        let blocks = || noise.chunks(BLOCK);
        let (least, codes) = coded_steps(blocks().map(|block| largest_part(block) / 7.0));
        let (mut added, mut power) = (0.0, 0.0);
        for (block, &code) in blocks().zip(&codes) {
            let step = step(least, code);
            for (value, byte) in block.iter().zip(quantised(block, step, Bits::Four)) {
                let back = [byte >> 4, byte & 15].map(|part| (f64::from(part) - 8.0) * step);
                added += (value - Complex64::new(back[0], back[1])).norm_sqr();
                power += value.norm_sqr();
            }
        }
        let share = added / power;
        assert!((0.008..0.015).contains(&share), "{share}");
    }

    #[test]
    fn gaps_silence_and_ranges_beyond_the_codes_are_told_apart() {
        let gap = [Complex64::new(f64::NAN, 0.0), Complex64::ONE];
        assert_eq!(quantised(&gap, 1.0 / 7.0, Bits::Four), [0, 16 * 15 + 8]);
        assert_eq!(quantised(&gap, 1.0 / 127.0, Bits::Eight), [0, 0, 255, 128]);
        assert_eq!(
            quantised(&[Complex64::ZERO; 2], 0.0, Bits::Four),
            [16 * 8 + 8; 2]
        );
        assert_eq!(coded_steps([0.0, 0.0].into_iter()), (0.0, vec![0, 0]));
        // the largest keeps its step, what is 240 dB below it is raised
        let (least, codes) = coded_steps([1e-9, 0.0, 1.0, 1e3].into_iter());
        assert_eq!((codes[0], codes[1], codes[3]), (1, 0, 255));
        assert!(least > 1e-9 && codes[2] < codes[3]);
        assert!(step(least, codes[2]) >= 1.0 - 1e-9 && step(least, codes[3]) >= 1e3 * (1.0 - 1e-9));
        // a step within their range is the least itself
        let (least, codes) = coded_steps([1e-5, 1e3].into_iter());
        assert_eq!((least, codes[0]), (1e-5, 1));
    }
}
