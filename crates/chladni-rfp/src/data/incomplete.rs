//! FRFs that lack values on some lines. A fit uses only lines that every FRF has, so each of them
//! costs lines. It is left out if it costs more values than it brings.

use crate::data::limits;
use std::collections::BTreeSet;
use std::ops::Range;

/// An FRF without values on some lines.
pub(crate) struct Incomplete<'a> {
    /// Response and reference.
    pub pair: (usize, usize),
    /// True for a driving point, which is never left out: it gives modes their scale.
    pub driving_point: bool,
    /// Lines (positions) without a value.
    pub rows: &'a [Range<usize>],
}

/// The FRFs of `incomplete` to leave out, so that as many values as possible stay: FRFs times lines
/// that they all have. FRFs that lack most lines go first. No response and no reference loses its
/// last FRF, and an FRF that lacks few lines stays.
///
/// * `pairs`: all FRFs
/// * `lines`: their number
pub(crate) fn left_out(
    pairs: &[(usize, usize)],
    incomplete: &[Incomplete],
    lines: usize,
) -> BTreeSet<(usize, usize)> {
    let count_frfs = |dof: fn(&(usize, usize)) -> usize| {
        let mut frfs = vec![0; pairs.iter().map(|pair| dof(pair) + 1).max().unwrap_or(0)];
        pairs.iter().for_each(|pair| frfs[dof(pair)] += 1);
        frfs
    };
    let mut frfs_of_response = count_frfs(|pair| pair.0);
    let mut frfs_of_reference = count_frfs(|pair| pair.1);
    let lacking = |frf: &Incomplete| frf.rows.iter().map(Range::len).sum::<usize>();
    let mut by_gaps: Vec<(usize, &Incomplete)> =
        incomplete.iter().map(|frf| (lacking(frf), frf)).collect();
    by_gaps.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.pair.cmp(&b.1.pair)));
    let mut order = Vec::new();
    // for each line, the number of FRFs in `order` that must go before all others have it
    let mut needed = vec![0; lines];
    for (lacking, frf) in by_gaps {
        let pair = frf.pair;
        let (responses, references) = (
            &mut frfs_of_response[pair.0],
            &mut frfs_of_reference[pair.1],
        );
        let many = lacking as f64 > limits::LINES_LOST * lines as f64;
        let position = match many && !frf.driving_point && *responses > 1 && *references > 1 {
            true => {
                *responses -= 1;
                *references -= 1;
                order.push(pair);
                order.len()
            }
            false => usize::MAX,
        };
        let rows = frf.rows.iter().cloned().flatten();
        rows.for_each(|row| needed[row] = position.max(needed[row]));
    }
    let mut freed_lines = vec![0; order.len() + 1];
    let can_be_whole = needed.into_iter().filter(|needed| *needed <= order.len());
    can_be_whole.for_each(|needed| freed_lines[needed] += 1);
    let (mut whole_lines, mut most_values, mut best) = (0, 0, 0);
    for (gone, freed) in freed_lines.into_iter().enumerate() {
        whole_lines += freed;
        let values = whole_lines * (pairs.len() - gone);
        if values > most_values {
            (most_values, best) = (values, gone);
        }
    }
    order.into_iter().take(best).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Vec<(usize, usize)> {
        (0..24).map(|l| (l / 3, l % 3)).collect()
    }

    fn lacking(pair: (usize, usize), rows: &[Range<usize>]) -> Incomplete<'_> {
        Incomplete {
            pair,
            driving_point: pair.0 == pair.1,
            rows,
        }
    }

    #[test]
    fn an_frf_that_costs_half_of_the_lines_goes_and_one_that_costs_a_few_stays() {
        let gaps = [
            lacking((2, 0), &[7..8, 9..10]),
            lacking((7, 2), &[50..70, 80..100]),
        ];
        assert_eq!(left_out(&grid(), &gaps, 100), BTreeSet::from([(7, 2)]));
        assert!(left_out(&grid(), &gaps[..1], 100).is_empty());
        assert!(left_out(&grid(), &[], 100).is_empty());
        // of many FRFs each is worth less than a line, and stays
        let many: Vec<(usize, usize)> = (0..20_000).map(|l| (l / 2, l % 2)).collect();
        assert!(left_out(&many, &[lacking((9000, 0), &[7..9, 10..12])], 100).is_empty());
    }

    #[test]
    fn lines_that_all_frfs_lack_cost_none_of_them() {
        let gaps: Vec<_> = grid()
            .into_iter()
            .map(|p| lacking(p, &[0..40, 40..90]))
            .collect();
        assert!(left_out(&grid(), &gaps, 100).is_empty());
    }

    #[test]
    fn a_driving_point_stays() {
        assert!(left_out(&grid(), &[lacking((1, 1), &[10..50, 50..100])], 100).is_empty());
    }

    #[test]
    fn no_response_and_no_reference_loses_its_last_frf() {
        let of_response = [0, 1, 2].map(|j| lacking((7, j), &[10..50, 50..100]));
        assert!(left_out(&grid(), &of_response, 100).is_empty());
        let one_reference: Vec<(usize, usize)> = (0..8).map(|i| (i, 0)).collect();
        assert!(left_out(&one_reference, &[lacking((3, 0), &[10..50, 50..100])], 100).is_empty());
    }
}
