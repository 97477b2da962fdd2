//! The spectral lines that a page holds: all, or fewer, with the resonances dense.

use crate::sizes::SPARSER;
use chladni_frf::ModalModel;

/// Rising indices of `frequency_hz`, about `limit` at most: every k-th line, and within a
/// bandwidth of each mode up to [`SPARSER`] times as many.
pub(crate) fn thinned(
    frequency_hz: &[f64],
    model: Option<&ModalModel>,
    limit: usize,
) -> Vec<usize> {
    let near: Vec<bool> = frequency_hz
        .iter()
        .map(|&f| is_resonant(f, model))
        .collect();
    for step in 1.. {
        let beside = (step / SPARSER).max(1);
        let kept: Vec<usize> = (0..near.len())
            .filter(|&k| k % step == 0 || (near[k] && k % beside == 0))
            .collect();
        if kept.len() <= limit.max(2) || step >= near.len() {
            return kept;
        }
    }
    unreachable!("the loop ends at the number of lines")
}

fn is_resonant(frequency_hz: f64, model: Option<&ModalModel>) -> bool {
    model.is_some_and(|model| {
        model.in_band_modes().any(|mode| {
            (frequency_hz - mode.frequency_hz).abs() <= mode.loss_factor * mode.frequency_hz
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resonances_stay_dense_within_the_limit() {
        let simulation = chladni_plate::simulate(
            &chladni_plate::Panel::from_toml("[frf]\nstop_hz = 320\n", 1 << 30).unwrap(),
            None,
            None,
        );
        let simulation = simulation.unwrap();
        let axis = simulation.frf.frequency_hz.to_vec();
        assert_eq!(
            thinned(&axis, Some(&simulation.truth), axis.len()).len(),
            axis.len()
        );
        let kept = thinned(&axis, Some(&simulation.truth), 150);
        assert!(kept.len() <= 150 && kept.windows(2).all(|pair| pair[0] < pair[1]));
        let mode = simulation.truth.in_band_modes().last().unwrap();
        let near = |f: f64| kept.iter().filter(|&&k| (axis[k] - f).abs() < 2.0).count();
        assert!(
            near(mode.frequency_hz) > 2 * near(mode.frequency_hz - 15.0),
            "{kept:?}"
        );
    }
}
