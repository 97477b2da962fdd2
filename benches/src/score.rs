//! One fit against its truth.

use crate::journal::nan;
use crate::problem::Problem;
use chladni_frf::{FrfValues, ModalModel, Mode, Scaling, Trust};
use chladni_plate::synthesise_by_products;
use chladni_rfp::mac;
use num_complex::Complex64;
use serde::{Deserialize, Serialize};

/// 95 % of a normal distribution lie within so many standard deviations.
const SIGMAS_95: f64 = 1.96;
/// 95 % of a circular complex one lie within so many √E|z|²: √ln 20.
const CIRCULAR_95: f64 = 1.730_818;

/// An error that no bar explains, in bars.
const NO_BAR: f64 = 1e9;

/// A true mode that was found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Match {
    /// Found minus true natural frequency, Hz.
    pub frequency_hz: f64,
    /// Found minus true loss factor.
    pub loss_factor: f64,
    /// Both errors over the standard deviations that the fit states.
    pub over_stated: [f64; 2],
    /// The 95 % interval of the natural frequency holds the truth.
    pub frequency_covered: bool,
    /// That of the loss factor does.
    pub loss_factor_covered: bool,
    /// Part of the shape's entries whose 95 % disc holds the truth.
    #[serde(deserialize_with = "nan")]
    pub shape_covered: f64,
    /// Modal assurance criterion with the true shape.
    #[serde(deserialize_with = "nan")]
    pub mac: f64,
}

/// The result of a fit of a problem.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Score {
    /// One entry per in-band mode of the truth; `None`: missed.
    pub matches: Vec<Option<Match>>,
    /// Modes without a partner in the truth, marked sure.
    pub spurious_sure: usize,
    /// The same, marked weak.
    pub spurious_weak: usize,
    /// Rms difference of the fit's FRFs from those without noise, over the rms of the
    /// latter.
    #[serde(deserialize_with = "nan")]
    pub frf_error: f64,
    /// The damping law is not the true one: natural frequencies are off by about η²/4,
    /// loss factors by 0.3η².
    pub wrong_law: bool,
    /// The fit says that it can be trusted and calls no mode weak.
    pub confident: bool,
}

impl Score {
    /// Pairs true and found modes, nearest poles first, within half a half-power bandwidth;
    /// out-of-band modes may pair too, so that a mode at the edge of the band is not
    /// called spurious.
    pub fn new(model: &ModalModel, problem: &Problem) -> Self {
        let known: Vec<&Mode> = problem.truth.modes.iter().collect();
        let found: Vec<&Mode> = model
            .modes
            .iter()
            .filter(|mode| mode.trust != Trust::Rejected)
            .collect();
        let partners = pair(&known, &found);
        let of_truth = |k: usize| {
            partners
                .iter()
                .find(|(known, _)| *known == k)
                .map(|&(_, f)| compare(known[k], found[f], model.scaling))
        };
        let lonely = |trust: Trust| {
            let alone = |f: &usize| {
                found[*f].in_band
                    && found[*f].trust == trust
                    && partners.iter().all(|(_, other)| other != f)
            };
            (0..found.len()).filter(alone).count()
        };
        Self {
            matches: (0..known.len())
                .filter(|&k| known[k].in_band)
                .map(of_truth)
                .collect(),
            spurious_sure: lonely(Trust::Sure),
            spurious_weak: lonely(Trust::Weak),
            frf_error: frf_error(model, problem),
            wrong_law: model.damping != problem.truth.damping,
            confident: model.quality.trusted
                && model.in_band_modes().all(|mode| mode.trust == Trust::Sure),
        }
    }

    /// A fit that could not be made.
    pub fn failed(problem: &Problem) -> Self {
        let matches = vec![None; problem.truth.in_band_modes().count()];
        Self {
            matches,
            spurious_sure: 0,
            spurious_weak: 0,
            frf_error: 1.0,
            wrong_law: false,
            confident: false,
        }
    }

    /// True modes that were not found.
    pub fn missed(&self) -> usize {
        self.matches
            .iter()
            .filter(|partner| partner.is_none())
            .count()
    }

    /// All found, none false.
    pub fn exact(&self) -> bool {
        self.missed() + self.spurious_sure + self.spurious_weak == 0
    }
}

/// Pairs (true mode, found mode), nearest poles first, within half a half-power bandwidth.
pub(crate) fn pair(known: &[&Mode], found: &[&Mode]) -> Vec<(usize, usize)> {
    let mut near = Vec::new();
    for (k, known) in known.iter().enumerate() {
        for (f, found) in found.iter().enumerate() {
            let distance_hz = (found.frequency_hz - known.frequency_hz).abs();
            if distance_hz <= half_half_width_hz(known) {
                near.push((pole_distance_hz(known, found), k, f));
            }
        }
    }
    nearest_first(near)
}

/// Pairs (true mode, found mode) of candidates (distance, true, found), the nearest first;
/// each mode once.
pub(crate) fn nearest_first(mut near: Vec<(f64, usize, usize)>) -> Vec<(usize, usize)> {
    near.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut pairs: Vec<(usize, usize)> = Vec::new();
    for (_, k, f) in near {
        if pairs.iter().all(|&(known, found)| known != k && found != f) {
            pairs.push((k, f));
        }
    }
    pairs
}

/// Distance of the poles, Hz: modes at one frequency are told apart by their damping.
pub(crate) fn pole_distance_hz(a: &Mode, b: &Mode) -> f64 {
    let decay_hz = |mode: &Mode| 0.5 * mode.loss_factor * mode.frequency_hz;
    (a.frequency_hz - b.frequency_hz).hypot(decay_hz(a) - decay_hz(b))
}

/// Half the half-power bandwidth, Hz: what lies farther from a mode is not that mode.
pub(crate) fn half_half_width_hz(mode: &Mode) -> f64 {
    0.5 * mode.loss_factor * mode.frequency_hz
}

fn compare(known: &Mode, found: &Mode, scaling: Scaling) -> Match {
    let (frequency_hz, loss_factor) = (
        found.frequency_hz - known.frequency_hz,
        found.loss_factor - known.loss_factor,
    );
    Match {
        frequency_hz,
        loss_factor,
        over_stated: [
            over(frequency_hz, found.frequency_std_hz),
            over(loss_factor, found.loss_factor_std),
        ],
        frequency_covered: frequency_hz.abs() <= SIGMAS_95 * found.frequency_std_hz,
        loss_factor_covered: loss_factor.abs() <= SIGMAS_95 * found.loss_factor_std,
        shape_covered: shape_covered(known, found, scaling),
        mac: mac(&known.shape.0, &found.shape.0),
    }
}

/// An error over the bar that the fit states; an error without a bar is beyond all of
/// them.
fn over(error: f64, stated: f64) -> f64 {
    match (error / stated).clamp(-NO_BAR, NO_BAR) {
        ratio if stated > 0.0 => ratio,
        _ if error == 0.0 => 0.0,
        _ => NO_BAR.copysign(error),
    }
}

/// Part of the entries within their 95 % discs; a shape of unit modal mass is compared up
/// to its sign, others as they are scaled: one at the largest entry, which therefore has
/// no error.
fn shape_covered(known: &Mode, found: &Mode, scaling: Scaling) -> f64 {
    let (known, shape) = (&known.shape.0, &found.shape.0);
    let factor = match scaling {
        Scaling::UnitModalMass => {
            let cross: Complex64 = known.iter().zip(shape).map(|(k, f)| k.conj() * f).sum();
            Complex64::from(cross.re.signum())
        }
        Scaling::Unscaled => {
            let largest = known
                .iter()
                .zip(shape)
                .max_by(|a, b| a.1.norm().total_cmp(&b.1.norm()));
            largest.map_or(Complex64::ONE, |(k, f)| f / k)
        }
    };
    let real = shape.iter().all(|value| value.im == 0.0);
    let limit = if real { SIGMAS_95 } else { CIRCULAR_95 };
    let covered = known
        .iter()
        .zip(shape)
        .zip(&found.shape_std)
        .filter(|((k, f), std)| (*f - factor * *k).norm() <= limit * **std);
    covered.count() as f64 / shape.len() as f64
}

fn frf_error(model: &ModalModel, problem: &Problem) -> f64 {
    let FrfValues::F64(clean) = &problem.clean.values else {
        return f64::NAN;
    };
    let fitted = synthesise_by_products(model, &problem.clean.frequency_hz);
    let energy = |pairs: &mut dyn Iterator<Item = Complex64>| {
        pairs.map(|value| value.norm_sqr()).sum::<f64>()
    };
    let error = energy(
        &mut clean
            .iter()
            .zip(&fitted)
            .map(|(clean, fitted)| fitted - clean),
    );
    (error / energy(&mut clean.iter().copied())).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_plate::Synthetic;

    fn problem() -> Problem {
        Problem::of_modes(&Synthetic {
            natural_frequency_hz: vec![40.0, 40.3, 110.0],
            ..Synthetic::default()
        })
        .unwrap()
    }

    #[test]
    fn the_truth_itself_is_exact_and_a_moved_mode_is_missed_and_spurious() {
        let problem = problem();
        let score = Score::new(&problem.truth, &problem);
        assert!(score.exact() && score.confident);
        assert!(score.frf_error < 1e-14);
        assert!(score
            .matches
            .iter()
            .flatten()
            .all(|found| found.mac > 1.0 - 1e-12 && found.frequency_hz == 0.0));

        let mut moved = problem.truth.clone();
        moved.modes[2].frequency_hz += 0.6; // its half-power bandwidth is 1.1 Hz
        let score = Score::new(&moved, &problem);
        assert_eq!((score.missed(), score.spurious_sure), (1, 1));
        moved.modes[2].trust = Trust::Weak;
        let score = Score::new(&moved, &problem);
        assert_eq!(
            (score.spurious_sure, score.spurious_weak, score.confident),
            (0, 1, false)
        );
    }

    #[test]
    fn close_modes_pair_with_their_own_partner() {
        let problem = problem();
        let mut swapped = problem.truth.clone();
        swapped.modes[0].frequency_hz = 40.1;
        swapped.modes[1].frequency_hz = 40.2;
        let score = Score::new(&swapped, &problem);
        let errors: Vec<f64> = score
            .matches
            .iter()
            .flatten()
            .map(|found| found.frequency_hz)
            .collect();
        assert!(
            (errors[0] - 0.1).abs() < 1e-9 && (errors[1] + 0.1).abs() < 1e-9,
            "{errors:?}"
        );
    }

    #[test]
    fn error_discs_follow_sign_and_scale() {
        let problem = problem();
        let mut model = problem.truth.clone();
        let mode = &mut model.modes[2];
        mode.shape
            .0
            .iter_mut()
            .for_each(|value| *value = -*value + 0.01);
        mode.shape_std = vec![0.006; mode.shape.0.len()];
        assert_eq!(
            Score::new(&model, &problem).matches[2]
                .as_ref()
                .unwrap()
                .shape_covered,
            1.0
        );
        model.modes[2].shape_std = vec![0.005; 5];
        assert_eq!(
            Score::new(&model, &problem).matches[2]
                .as_ref()
                .unwrap()
                .shape_covered,
            0.0
        );
    }
}
