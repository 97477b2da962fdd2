//! Reading FRFs in the order in which they lie in memory, widened on the way.

use crate::data::incomplete::{left_out, Incomplete};
use crate::data::limits;
use chladni_frf::{FrfSet, FrfValues};
use chladni_linalg::wide;
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
        FrfValues::F64(values) => visit_lines(
            values.slice(ndarray::s![i, j, ..]),
            lines,
            targets,
            |v| v,
            see,
        ),
        FrfValues::F32(values) => {
            visit_lines(
                values.slice(ndarray::s![i, j, ..]),
                lines,
                targets,
                |v| Complex64::new(v.re.into(), v.im.into()),
                see,
            );
        }
    }
}

/// Calls `see` for the lines of one FRF. Lines without gaps are read as one stretch.
#[inline]
fn visit_lines<T: Copy, I: Iterator>(
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
/// turn, pair); `None` if they are not doubles, or not consecutive lines and pairs.
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
    let consecutive = pairs
        .iter()
        .map(place)
        .eq(first_pair..first_pair + pairs.len());
    if last - first + 1 != lines.len() || !consecutive {
        return None;
    }
    let parts: &[f64] = bytemuck::cast_slice(values.as_slice()?);
    let shape = (2 * lines.len(), pairs.len()).strides((1, 2 * all));
    ArrayView2::from_shape(shape, &parts[2 * (first_pair * all + first)..]).ok()
}

/// Energy of one FRF.
pub(crate) struct FrfEnergy {
    /// Sum of squares.
    pub sum: f64,
    /// True if a value is zero.
    pub has_zeros: bool,
}

/// Energy of one pair times its `weight` on `lines`.
pub(crate) fn energy(
    values: &FrfValues,
    pair: (usize, usize),
    lines: &[usize],
    weight: f64,
) -> FrfEnergy {
    let (mut sums, mut has_zeros) = ([0.0; limits::READING_LANES], false);
    visit(values, pair, lines, 0.., |row: usize, value| {
        let square = (value * weight).norm_sqr();
        sums[row % limits::READING_LANES] += square;
        has_zeros |= square == 0.0;
    });
    FrfEnergy {
        sum: sums.iter().sum(),
        has_zeros,
    }
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
    let (whole, rest) = values.as_chunks::<{ 2 * limits::READING_LANES }>();
    let mut sums = wide(
        #[inline(always)]
        || {
            let mut sums = [0.0; 2 * limits::READING_LANES];
            for values in whole {
                for (sum, value) in sums.iter_mut().zip(values) {
                    *sum += value * value;
                }
            }
            sums
        },
    );
    for (sum, value) in sums.iter_mut().zip(rest) {
        *sum += value * value;
    }
    sums.iter().sum()
}

/// The FRFs and lines of a set that hold values.
pub(crate) struct Usable {
    /// Pairs with at least one finite value that is not zero, without those of `left_out`.
    pub pairs: Vec<(usize, usize)>,
    /// Pairs whose gaps cost more values than they bring.
    pub left_out: BTreeSet<(usize, usize)>,
    /// True for lines (positions) on which one of `pairs` is not finite, or all are zero.
    pub bad: Vec<bool>,
    /// Number of bad lines on which some of `pairs` hold values.
    pub lost: usize,
    /// Sum of squares of all pairs, row by row; correct if no line is bad.
    pub energy: Vec<f64>,
}

/// An FRF in which some values are not finite, or zero.
struct Flawed {
    pair: (usize, usize),
    /// Lines (positions) whose value is not finite.
    gaps: Vec<Range<usize>>,
    /// Lines (positions) whose value is zero.
    zeros: Vec<Range<usize>>,
}

impl Flawed {
    /// The gaps and zeros of one pair; `None` if it holds nothing else.
    fn new(frf: &FrfSet, pair: (usize, usize), lines: &[usize]) -> Option<Self> {
        let (mut any, mut gaps, mut zeros) = (false, Vec::new(), Vec::new());
        visit(&frf.values, pair, lines, 0.., |row, value| match value {
            value if !value.is_finite() => add(&mut gaps, row),
            value if value == Complex64::default() => add(&mut zeros, row),
            _ => any = true,
        });
        any.then_some(Self { pair, gaps, zeros })
    }
}

impl Usable {
    /// All pairs and lines of a set without missing values.
    pub fn all(pairs: Vec<(usize, usize)>, lines: usize, energy: Vec<f64>) -> Self {
        Self {
            pairs,
            left_out: BTreeSet::new(),
            bad: vec![false; lines],
            lost: 0,
            energy,
        }
    }

    /// Looks at `lines` of all pairs.
    ///
    /// * `whole`: true if no FRF may be left out for its gaps
    pub fn new(frf: &FrfSet, lines: &[usize], whole: bool) -> Self {
        let all: Vec<(usize, usize)> = frf.all_pairs().collect();
        let energies: Vec<FrfEnergy> = all
            .par_iter()
            .map(|&pair| energy(&frf.values, pair, lines, 1.0))
            .collect();
        let (mut flawed, mut pairs) = (Vec::new(), Vec::new());
        for (&pair, energy) in all.iter().zip(&energies) {
            if energy.sum.is_finite() && !energy.has_zeros {
                pairs.push(pair);
            } else if let Some(of_frf) = Flawed::new(frf, pair, lines) {
                pairs.push(pair);
                flawed.push(of_frf);
            }
        }
        let incomplete: Vec<Incomplete> = flawed
            .iter()
            .filter(|of_frf| !whole && !of_frf.gaps.is_empty())
            .map(|&Flawed { pair, ref gaps, .. }| Incomplete {
                pair,
                driving_point: frf.responses[pair.0].same_axis(frf.references[pair.1]),
                rows: gaps,
            })
            .collect();
        let left_out = left_out(&pairs, &incomplete, lines.len());
        pairs.retain(|pair| !left_out.contains(pair));
        flawed.retain(|of_frf| !left_out.contains(&of_frf.pair));
        let count_frfs = |rows: fn(&Flawed) -> &Vec<Range<usize>>| {
            let mut frfs = vec![0; lines.len()];
            let rows = flawed.iter().flat_map(rows).cloned().flatten();
            rows.for_each(|row| frfs[row] += 1);
            frfs
        };
        let with_gap = count_frfs(|of_frf| &of_frf.gaps);
        let with_zero = count_frfs(|of_frf| &of_frf.zeros);
        let is_empty = |k: usize| with_gap[k] + with_zero[k] == pairs.len();
        let bad: Vec<bool> = (0..lines.len())
            .map(|k| with_gap[k] > 0 || (is_empty(k) && !pairs.is_empty()))
            .collect();
        Self {
            lost: (0..lines.len()).filter(|&k| bad[k] && !is_empty(k)).count(),
            pairs,
            left_out,
            bad,
            energy: energies.into_iter().map(|energy| energy.sum).collect(),
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
