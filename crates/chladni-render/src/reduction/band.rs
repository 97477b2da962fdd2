//! The band that a scene needs of a fit.
//!
//! The effect of modes outside the band at the drive frequency is left to residual terms;
//! the module `folding` knows to the last digit what their series leaves out. The band is
//! the one with the fewest modes inside for which that remainder is below a share of the
//! mobility, with edges midway between modes: a fit whose edge falls beside a mode is
//! worse than its neighbours with fewer modes.

use crate::panel::operator::Operator;
use crate::reduction::folding::{ranked, Foldable};
use crate::scene::scene_file::Scene;
use crate::tolerances;
use chladni_frf::{ModalModel, Result};
use num_complex::Complex64;

/// A part of the measured band, and what leaving out the rest costs.
#[derive(Debug, Clone, PartialEq)]
pub struct NeededBand {
    /// Hz.
    pub band_hz: [f64; 2],
    /// Modes inside, Hz, rising.
    pub inside_hz: Vec<f64>,
    /// Modes outside, Hz, rising.
    pub left_out_hz: Vec<f64>,
    /// The part that their residual terms leave out at the drive frequency (the largest
    /// of several), rms over the mobility of responses and actuators.
    pub error_relative: f64,
}

/// The band that `scene` needs, by a quick look at the modes between `whole_hz`: what its
/// tones need, and all between them.
///
/// # Errors
/// As [`Operator::of_model`].
pub fn needed_band(quick: &ModalModel, scene: &Scene, whole_hz: [f64; 2]) -> Result<NeededBand> {
    let mut needed = scene
        .tones()
        .iter()
        .map(|tone| of_tone(quick, tone, whole_hz))
        .collect::<Result<Vec<_>>>()?;
    let first = needed.swap_remove(0);
    let mut all = needed.into_iter().fold(first, |all, tone| NeededBand {
        band_hz: [
            all.band_hz[0].min(tone.band_hz[0]),
            all.band_hz[1].max(tone.band_hz[1]),
        ],
        error_relative: all.error_relative.max(tone.error_relative),
        ..all
    });
    let [low, high] = all.band_hz;
    let mut seen: Vec<f64> = all
        .inside_hz
        .drain(..)
        .chain(all.left_out_hz.drain(..))
        .collect();
    seen.sort_by(f64::total_cmp);
    (all.inside_hz, all.left_out_hz) = seen.into_iter().partition(|hz| (low..=high).contains(hz));
    Ok(all)
}

/// The same of a scene with one tone.
fn of_tone(quick: &ModalModel, scene: &Scene, whole_hz: [f64; 2]) -> Result<NeededBand> {
    let operator = Operator::of_model(quick, scene.frequency_hz, scene.actuators.only.as_deref())?;
    let rms = (operator
        .mobility
        .iter()
        .map(Complex64::norm_sqr)
        .sum::<f64>()
        / operator.mobility.len() as f64)
        .sqrt();
    let mut modes: Vec<Foldable> = ranked(quick, &operator);
    let hz = |foldable: &Foldable| quick.modes[foldable.mode].frequency_hz;
    modes.sort_by(|a, b| hz(a).total_cmp(&hz(b)));
    let share = |outside: &[&[Foldable]]| {
        outside
            .iter()
            .flat_map(|part| part.iter())
            .map(|m| m.size.powi(2))
            .sum::<f64>()
            .sqrt()
            / rms
    };
    let count = modes.len();
    // an edge below mode k: between it and the one before
    let edge = |k: usize| match k {
        0 => whole_hz[0],
        k if k == count => whole_hz[1],
        k => 0.5 * (hz(&modes[k - 1]) + hz(&modes[k])),
    };
    let holds = |&(first, end): &(usize, usize)| {
        edge(first) < scene.frequency_hz && scene.frequency_hz < edge(end)
    };
    let of = |(first, end): (usize, usize)| share(&[&modes[..first], &modes[end..]]);
    let bands = (0..count)
        .flat_map(|first| (first + 1..=count).map(move |end| (first, end)))
        .filter(holds);
    let enough = bands.filter(|&band| of(band) <= tolerances::BAND_ERROR);
    let best = enough.min_by(|&a, &b| (a.1 - a.0).cmp(&(b.1 - b.0)).then(of(a).total_cmp(&of(b))));
    let (first, end) = best.unwrap_or((0, count));
    Ok(NeededBand {
        band_hz: [edge(first), edge(end)],
        inside_hz: modes[first..end].iter().map(hz).collect(),
        left_out_hz: modes[..first].iter().chain(&modes[end..]).map(hz).collect(),
        error_relative: of((first, end)),
    })
}
