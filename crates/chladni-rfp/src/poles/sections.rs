//! Stretches of a long band that are searched by themselves.
//!
//! Modes far apart have no influence on each other. In a band of b sections the pole pool and
//! every refinement cost 1/b² of those of the whole band. Each section reaches over its cuts by a
//! few peaks, so that modes of its neighbour are fitted as modes and not forced into residual
//! terms. It keeps only the poles between its cuts.

use crate::data::columns::Columns;
use crate::data::peaks::Peak;
use crate::poles::limits;
use std::ops::Range;

/// One stretch.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Section {
    /// Lines that it is fitted on, overlaps included.
    pub lines: Range<usize>,
    /// The stretch between its cuts, in x; open at the ends of the band.
    pub core: Range<f64>,
}

/// Cuts the band into sections of about [`limits::PEAKS`] peaks, in the widest gap near each even
/// share.
pub(crate) fn split(work: &Columns, peaks: &[Peak]) -> Vec<Section> {
    let mut x: Vec<f64> = peaks.iter().map(|p| p.lambda.re).collect();
    x.sort_by(f64::total_cmp);
    let count = if x.len() > limits::WHOLE {
        x.len().div_ceil(limits::PEAKS)
    } else {
        1
    };
    // a cut c lies between peaks c − 1 and c
    let mut cuts = vec![0];
    for s in 1..count {
        let even = s * x.len() / count;
        let gap = |&c: &usize| x[c] - x[c - 1];
        cuts.extend((even - 1..=even + 1).max_by(|a, b| gap(a).total_cmp(&gap(b))));
    }
    cuts.push(x.len());
    // x of the cut c: the middle of the gap
    let place_of = |c: usize| match c {
        0 => f64::NEG_INFINITY,
        c if c >= x.len() => f64::INFINITY,
        c => 0.5 * (x[c - 1] + x[c]),
    };
    let line_at = |x: f64| work.x.partition_point(|v| *v < x);
    cuts.windows(2)
        .map(|cut| Section {
            lines: line_at(place_of(cut[0].saturating_sub(limits::OVERLAP)))
                ..line_at(place_of(cut[1] + limits::OVERLAP)),
            core: place_of(cut[0])..place_of(cut[1]),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;
    use num_complex::Complex64;

    fn work_and_peaks(positions: &[f64]) -> (Columns, Vec<Peak>) {
        let n = 1000;
        let x: Vec<f64> = (0..n).map(|k| (k + 1) as f64 / n as f64).collect();
        let peak = |&x: &f64| Peak {
            row: 0,
            prominence_db: 10.0,
            over_noise_db: 20.0,
            level_db: 0.0,
            lambda: Complex64::new(x, 0.001),
        };
        (
            Columns {
                g: vec![1.0; n],
                x,
                b: Array2::zeros((n, 1)),
                law: chladni_frf::Damping::Structural,
                leakage: None,
                neighbours: 0.0,
            },
            positions.iter().map(peak).collect(),
        )
    }

    #[test]
    fn few_peaks_stay_in_one_piece() {
        let (work, peaks) = work_and_peaks(&[0.2, 0.5, 0.7]);
        let sections = split(&work, &peaks);
        assert_eq!(sections.len(), 1);
        assert_eq!(sections[0].lines, 0..1000);
        assert!(sections[0].core.contains(&0.0) && sections[0].core.contains(&2.0));
    }

    #[test]
    fn sections_tile_the_band_reach_over_their_cuts_and_cut_in_gaps() {
        // 40 peaks, with a wide gap after the 12th
        let positions: Vec<f64> = (0..40)
            .map(|i| 0.02 * (i + 1) as f64 + if i >= 12 { 0.1 } else { 0.0 })
            .collect();
        let (work, peaks) = work_and_peaks(&positions);
        let sections = split(&work, &peaks);
        assert!(sections.len() > 2);
        for pair in sections.windows(2) {
            assert_eq!(pair[0].core.end, pair[1].core.start);
            assert!(pair[1].lines.start < pair[0].lines.end, "they overlap");
        }
        let middle = 0.5 * (positions[11] + positions[12]);
        assert!(
            sections.iter().any(|s| (s.core.end - middle).abs() < 1e-12),
            "one cut lies in the wide gap: {sections:?}"
        );
        assert_eq!(sections[0].lines.start, 0);
        assert_eq!(sections.last().unwrap().lines.end, 1000);
    }
}
