//! Lines that a draft uses: those around the known resonances, and a few of the others.
//!
//! A draft knows the modes of the last full fit. Between resonances FRFs are smooth, so that
//! few lines are enough there, and the time of a fit grows with its lines.

use crate::limits::{FEW_LINES, LINES_PER_RESONANCE, ONE_OF_OTHERS, REACH};
use chladni_frf::ModalModel;

/// Indices of the lines of `axis_hz` in `band_hz` (all lines where that is missing) that a
/// draft needs; `None` where it may use all of them.
///
/// Beyond the band of `known` every line stays, since its modes are not known there.
pub fn few_lines(
    axis_hz: &[f64],
    band_hz: Option<[f64; 2]>,
    known: &ModalModel,
) -> Option<Vec<usize>> {
    let [low, high] = band_hz.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    let inside: Vec<usize> = (0..axis_hz.len())
        .filter(|&line| (low..=high).contains(&axis_hz[line]))
        .collect();
    if inside.len() <= FEW_LINES {
        return None;
    }
    let others_hz = ONE_OF_OTHERS * (axis_hz[inside[inside.len() - 1]] - axis_hz[inside[0]])
        / (inside.len() - 1) as f64;
    let resonances: Vec<[f64; 2]> = known
        .modes
        .iter()
        .map(|mode| {
            [
                mode.frequency_hz,
                REACH * mode.loss_factor * mode.frequency_hz,
            ]
        })
        .collect();
    // least distance of neighbouring lines
    let gap_hz = |hz: f64| {
        let over = resonances
            .iter()
            .filter(|[centre, reach]| (hz - centre).abs() <= *reach);
        let narrowest = over
            .map(|[_, reach]| 2.0 * reach / LINES_PER_RESONANCE)
            .fold(others_hz, f64::min);
        if (known.band_hz[0]..=known.band_hz[1]).contains(&hz) {
            narrowest
        } else {
            0.0
        }
    };
    let mut last_hz = f64::NEG_INFINITY;
    let is_wanted = |line: &usize| {
        let hz = axis_hz[*line];
        let is_wanted = hz - last_hz >= gap_hz(hz);
        if is_wanted {
            last_hz = hz;
        }
        is_wanted
    };
    Some(inside.into_iter().filter(is_wanted).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// One mode at 50 Hz with 1 % loss, known between 10 and 100 Hz.
    fn known() -> ModalModel {
        let path =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/malformed/base/model.json");
        chladni_io::read_model(&path).unwrap()
    }

    #[test]
    fn a_resonance_keeps_its_lines_and_the_rest_is_thinned() {
        let axis: Vec<f64> = (0..=900).map(|k| 10.0 + 0.1 * f64::from(k)).collect();
        let lines = few_lines(&axis, None, &known()).unwrap();
        let within = |[low, high]: [f64; 2]| {
            lines
                .iter()
                .filter(|&&line| (low..=high).contains(&axis[line]))
                .count()
        };
        assert!(within([49.0, 51.0]) >= 10, "{lines:?}");
        // one in twelve of 389
        let others = within([10.0, 48.9]);
        assert!((31..=34).contains(&others), "{others}");
        assert!(lines.is_sorted());
    }

    #[test]
    fn lines_that_nobody_has_looked_at_stay_and_few_lines_are_all_kept() {
        let axis: Vec<f64> = (0..=600).map(|k| 10.0 + 0.5 * f64::from(k)).collect();
        let lines = few_lines(&axis, None, &known()).unwrap();
        assert_eq!(
            lines.iter().filter(|&&line| axis[line] > 100.0).count(),
            axis.iter().filter(|&&hz| hz > 100.0).count()
        );
        assert_eq!(few_lines(&axis, Some([10.0, 100.0]), &known()), None);
    }
}
