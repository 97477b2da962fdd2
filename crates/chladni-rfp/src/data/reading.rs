//! Reading FRFs in the order in which they lie in memory, widened on the way.

use crate::data::incomplete::{left_out, Incomplete};
use crate::data::limits;
use chladni_frf::{FrfSet, FrfValues};
use ndarray::{ArrayView1, ArrayView2, ShapeBuilder};
use num_complex::Complex64;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::ops::Range;

/// Calls `see` with each of `targets` and the value on each of `lines` of one pair.
#[inline]
pub(crate) fn visit<I: Iterator>(
    values: &FrfValues,
    (i, j): (usize, usize),
    lines: &[usize],
    targets: I,
    see: impl FnMut(I::Item, Complex64),
) {
    match values {
        FrfValues::F64(values) => each(
            values.slice(ndarray::s![i, j, ..]),
            lines,
            targets,
            |v| v,
            see,
        ),
        FrfValues::F32(values) => {
            each(
                values.slice(ndarray::s![i, j, ..]),
                lines,
                targets,
                |v| Complex64::new(v.re.into(), v.im.into()),
                see,
            );
        }
    }
}

/// Lines without gaps are read as one stretch.
#[inline]
fn each<T: Copy, I: Iterator>(
    frf: ArrayView1<T>,
    lines: &[usize],
    targets: I,
    widen: impl Fn(T) -> Complex64,
    mut see: impl FnMut(I::Item, Complex64),
) {
    let stretch = match (lines.first(), lines.last(), frf.to_slice()) {
        (Some(&first), Some(&last), Some(frf)) if last - first + 1 == lines.len() => {
            Some(&frf[first..=last])
        }
        _ => None,
    };
    match stretch {
        Some(stretch) => {
            for (target, &value) in targets.zip(stretch) {
                see(target, widen(value));
            }
        }
        None => {
            for (target, &k) in targets.zip(lines) {
                see(target, widen(frf[k]));
            }
        }
    }
}

/// `lines` of some pairs as they lie in memory, (real and imaginary part of each line in
/// turn, pair); `None` where they are not doubles, or lines or pairs are left out between
/// them.
pub(crate) fn in_place<'a>(
    values: &'a FrfValues,
    pairs: &[(usize, usize)],
    lines: &[usize],
) -> Option<ArrayView2<'a, f64>> {
    let FrfValues::F64(values) = values else {
        return None;
    };
    let (_, references, all) = values.dim();
    let place = |&(i, j): &(usize, usize)| i * references + j;
    let (first, last, first_pair) = (*lines.first()?, *lines.last()?, place(pairs.first()?));
    if last - first + 1 != lines.len()
        || !pairs
            .iter()
            .map(place)
            .eq(first_pair..first_pair + pairs.len())
    {
        return None;
    }
    let parts: &[f64] = bytemuck::cast_slice(values.as_slice()?);
    let shape = (2 * lines.len(), pairs.len()).strides((1, 2 * all));
    ArrayView2::from_shape(shape, &parts[2 * (first_pair * all + first)..]).ok()
}

/// Sum of squares of one pair times its `weight` on `lines`, and whether one of its values
/// is zero.
pub(crate) fn energy(
    values: &FrfValues,
    pair: (usize, usize),
    lines: &[usize],
    weight: f64,
) -> (f64, bool) {
    let (mut sums, mut zero) = ([0.0; limits::READING_LANES], false);
    visit(values, pair, lines, 0.., |row: usize, value| {
        let square = (value * weight).norm_sqr();
        sums[row % limits::READING_LANES] += square;
        zero |= square == 0.0;
    });
    (sums.iter().sum(), zero)
}

/// Sum of squares of the values on `lines` of one pair.
pub(crate) fn squares_of(values: &FrfValues, pair: (usize, usize), lines: &[usize]) -> f64 {
    if let Some(frf) = in_place(values, &[pair], lines).and_then(|frf| frf.to_slice_memory_order())
    {
        return squares(frf);
    }
    let mut copy = vec![0.0; 2 * lines.len()];
    visit(
        values,
        pair,
        lines,
        copy.chunks_exact_mut(2),
        |out, value| (out[0], out[1]) = (value.re, value.im),
    );
    squares(&copy)
}

/// Sum of squares.
pub(crate) fn squares(values: &[f64]) -> f64 {
    let mut sums = [0.0; 2 * limits::READING_LANES];
    for values in values.chunks(2 * limits::READING_LANES) {
        sums.iter_mut()
            .zip(values)
            .for_each(|(sum, value)| *sum += value * value);
    }
    sums.iter().sum()
}

/// The result of a first look at all values.
pub(crate) struct Usable {
    /// Pairs with at least one finite value that is not zero, without those of `left_out`.
    pub pairs: Vec<(usize, usize)>,
    /// Pairs whose gaps cost more values than they bring.
    pub left_out: BTreeSet<(usize, usize)>,
    /// Lines (positions) on which one of `pairs` is not finite, or all are zero.
    pub bad: Vec<bool>,
    /// Number of those that some of `pairs` have.
    pub lost: usize,
    /// Sum of squares by response and reference, row by row; right where no line is bad.
    pub energy: Vec<f64>,
}

/// An FRF in which some values are not finite, or zero.
struct Flawed {
    pair: (usize, usize),
    gaps: Vec<Range<usize>>,
    zeros: Vec<Range<usize>>,
}

impl Usable {
    /// Looks at `lines` of all pairs.
    ///
    /// * `whole`: no FRF may be left out for its gaps
    pub fn new(frf: &FrfSet, lines: &[usize], whole: bool) -> Self {
        let all: Vec<(usize, usize)> = frf.all_pairs().collect();
        let sums: Vec<(f64, bool)> = all
            .par_iter()
            .map(|&pair| energy(&frf.values, pair, lines, 1.0))
            .collect();
        let (mut flawed, mut pairs) = (Vec::new(), Vec::new());
        for (&pair, &(sum, zero)) in all.iter().zip(&sums) {
            if sum.is_finite() && !zero {
                pairs.push(pair);
                continue;
            }
            let (mut any, mut gaps, mut zeros) = (false, Vec::new(), Vec::new());
            visit(&frf.values, pair, lines, 0.., |row, value| match value {
                value if !value.is_finite() => add(&mut gaps, row),
                value if value == Complex64::default() => add(&mut zeros, row),
                _ => any = true,
            });
            if any {
                pairs.push(pair);
                flawed.push(Flawed { pair, gaps, zeros });
            }
        }
        let incomplete: Vec<Incomplete> = flawed
            .iter()
            .filter(|own| !whole && !own.gaps.is_empty())
            .map(|own| {
                let (response, reference) = (frf.responses[own.pair.0], frf.references[own.pair.1]);
                Incomplete {
                    pair: own.pair,
                    driving_point: response.same_axis(reference),
                    rows: &own.gaps,
                }
            })
            .collect();
        let left_out = left_out(&pairs, &incomplete, lines.len());
        pairs.retain(|pair| !left_out.contains(pair));
        flawed.retain(|frf| !left_out.contains(&frf.pair));
        let count = |of: fn(&Flawed) -> &Vec<Range<usize>>| {
            let mut frfs = vec![0; lines.len()];
            let rows = flawed.iter().flat_map(of).cloned().flatten();
            rows.for_each(|row| frfs[row] += 1);
            frfs
        };
        let (gaps, zeros) = (count(|frf| &frf.gaps), count(|frf| &frf.zeros));
        let of_none = |k: usize| gaps[k] + zeros[k] == pairs.len();
        let bad: Vec<bool> = (0..lines.len())
            .map(|k| gaps[k] > 0 || (of_none(k) && !pairs.is_empty()))
            .collect();
        Self {
            lost: (0..lines.len()).filter(|&k| bad[k] && !of_none(k)).count(),
            pairs,
            left_out,
            bad,
            energy: sums.into_iter().map(|(sum, _)| sum).collect(),
        }
    }
}

/// Adds a number to rising ranges.
fn add(ranges: &mut Vec<Range<usize>>, number: usize) {
    match ranges.last_mut() {
        Some(last) if last.end == number => last.end += 1,
        _ => ranges.push(number..number + 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array3;
    use num_complex::Complex32;

    #[test]
    fn what_is_seen_in_place_is_what_a_visit_shows() {
        let value = |(i, j, k): (usize, usize, usize)| {
            Complex64::new((100 * i + 10 * j + k) as f64, -(k as f64))
        };
        let values = FrfValues::F64(Array3::from_shape_fn((3, 2, 7), value));
        let (pairs, band) = ([(0, 1), (1, 0), (1, 1)], [2, 3, 4, 5]);
        let block = in_place(&values, &pairs, &band).unwrap();
        assert_eq!(block.dim(), (8, 3));
        for (column, &pair) in block.columns().into_iter().zip(&pairs) {
            visit(&values, pair, &band, 0.., |row: usize, value| {
                assert_eq!(value, Complex64::new(column[2 * row], column[2 * row + 1]))
            });
        }
        assert!(
            in_place(&values, &[(2, 1)], &[4, 5, 6]).is_some(),
            "up to the last value"
        );
        // a line or a pair left out, pairs in another order, single precision, nothing
        assert!(in_place(&values, &pairs, &[2, 4]).is_none());
        assert!(in_place(&values, &[(0, 1), (1, 1)], &band).is_none());
        assert!(in_place(&values, &[(1, 0), (0, 1)], &band).is_none());
        assert!(in_place(
            &FrfValues::F32(Array3::from_elem((3, 2, 7), Complex32::ONE)),
            &pairs,
            &band
        )
        .is_none());
        assert!(
            in_place(&values, &pairs, &[]).is_none() && in_place(&values, &[], &band).is_none()
        );
        // sums of squares do not depend on how the values were reached
        let gap = Array3::from_shape_fn((1, 1, 4), |(_, _, k)| value((0, 1, k + 2)));
        assert_eq!(
            squares_of(&values, (0, 1), &band),
            squares_of(&FrfValues::F64(gap), (0, 0), &[0, 1, 2, 3])
        );
    }
}
