//! Bands by evidence: where the lines are cut, and how many poles each part is given.
//!
//! A band for every eight visible peaks, its border at the deepest valley of the energy
//! near an equal share of them. Each is fitted with lines of its neighbours on both sides,
//! so that no mode stands at the end of its data. The order is the larger of what the
//! singular values of these lines say and of the peaks seen, and some more that take up
//! noise and neighbours.

use super::limits::{LEAST_LINES, LEEWAY, OVERLAP, WINDOWS_PEAKS_PER_BAND, WINDOWS_SPARE_POLES};
use crate::data::columns::Columns;
use crate::data::peaks::Peak;
use crate::poles::rank::visible_rank;
use chladni_linalg::LinalgError;
use ndarray::Array1;
use std::ops::Range;

/// One band.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct OverlappingBand {
    /// Rows whose modes are taken from this band.
    pub core: Range<usize>,
    /// Rows that are fitted.
    pub rows: Range<usize>,
}

/// `count` bands, or as many as the `peaks` ask for.
pub(crate) fn overlapping_bands(
    peaks: &[Peak],
    energy: &Array1<f64>,
    count: Option<usize>,
) -> Vec<OverlappingBand> {
    let lines = energy.len();
    let mut rows: Vec<usize> = peaks.iter().map(|peak| peak.row).collect();
    rows.sort_unstable();
    let most = (lines / (2 * LEAST_LINES)).clamp(1, rows.len().max(1));
    let count = count
        .unwrap_or(rows.len().div_ceil(WINDOWS_PEAKS_PER_BAND))
        .clamp(1, most);
    let mut borders = vec![0];
    borders.extend((1..count).filter_map(|cut| valley(&rows, energy, cut, count)));
    borders.push(lines);
    borders.dedup();
    borders
        .windows(2)
        .map(|ends| {
            let reach = (OVERLAP * (ends[1] - ends[0]) as f64).ceil() as usize;
            OverlappingBand {
                core: ends[0]..ends[1],
                rows: ends[0].saturating_sub(reach)..(ends[1] + reach).min(lines),
            }
        })
        .collect()
}

/// The row of least energy around the place where `cut` of `count` shares of the peaks
/// end, between two of them.
fn valley(peaks: &[usize], energy: &Array1<f64>, cut: usize, count: usize) -> Option<usize> {
    let share = peaks.len() as f64 / count as f64;
    let middle = share * cut as f64;
    let left_of_it = middle.round().clamp(1.0, (peaks.len() - 1) as f64);
    // fewest and most peaks left of the border
    let fewest = (middle - LEEWAY * share).ceil().clamp(1.0, left_of_it) as usize;
    let most = (middle + LEEWAY * share).floor().max(left_of_it) as usize;
    let (first, last) = (fewest - 1, most.min(peaks.len() - 1));
    (peaks[first] + 1..peaks[last]).min_by(|&a, &b| energy[a].total_cmp(&energy[b]))
}

/// Poles for the lines of one band, of which `peaks` show and `asked` are wanted.
///
/// # Errors
/// A decomposition that fails.
pub(crate) fn order(
    band: &Columns,
    peaks: usize,
    asked: Option<usize>,
) -> Result<usize, LinalgError> {
    let seen = match visible_rank(band)? {
        (rank, true) => rank.max(peaks),
        // too few columns to see the noise: their number bounds no order
        (rank, false) => peaks.max(rank.min(2 * peaks)),
    };
    let order = seen.max(asked.unwrap_or(0)) + WINDOWS_SPARE_POLES;
    Ok(order
        .min(band.lines().saturating_sub(LEAST_LINES) / 2)
        .max(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::peaks::peaks_at;

    #[test]
    fn a_crowded_band_is_cut_at_its_deepest_valley() {
        let rows: Vec<usize> = (0..10).map(|n| 10 + 20 * n).collect();
        let mut energy =
            Array1::from_shape_fn(220, |k| if rows.contains(&k) { 100.0 } else { 10.0 });
        energy[21] = 0.001; // deeper still, but far from an equal share
        energy[121] = 1.0;
        let found = overlapping_bands(&peaks_at(&rows), &energy, None);
        assert_eq!(found.len(), 2);
        assert_eq!([&found[0].core, &found[1].core], [&(0..121), &(121..220)]);
        assert!(found[0].rows.end > 121 && found[1].rows.start < 121);
    }

    #[test]
    fn as_many_bands_as_asked_for_but_no_more_than_lines_carry() {
        let rows: Vec<usize> = (0..10).map(|n| 10 + 20 * n).collect();
        let energy = Array1::from_shape_fn(220, |k| 1.0 + (k % 20) as f64);
        for (asked, count) in [(1, 1), (4, 4), (1000, 10)] {
            assert_eq!(
                overlapping_bands(&peaks_at(&rows), &energy, Some(asked)).len(),
                count
            );
        }
        assert_eq!(overlapping_bands(&[], &energy, None).len(), 1);
    }
}
