//! A delay of all FRFs alike: a filter, a sound card, the way from a loudspeaker.
//!
//! A real shape has residues of one phase, up to their sign. A delay τ turns those of mode n by
//! −ω_nτ. Where it turns the band by more than a cycle or so, a rational function needs poles for
//! it: heavy ones at even distances of about 1/τ, with error bars like those of modes. They decay
//! within the delay, as nearly all of e^{−στ} is gone there; so only modes that outlast a delay
//! say whether there is one, and the others may stand for it (theory.md, eq. F2c).

use crate::checks::case::{Case, Checked};
use crate::checks::kind::square_sum;
use crate::checks::limits;
use crate::checks::phases::{OneDelay, Phases};
use crate::data::onset::{late, onset_s};
use chladni_frf::{Finding, Mode, Reason, Trust};
use ndarray::{concatenate, Axis};
use num_complex::Complex64;
use std::f64::consts::{PI, TAU};

/// Names the delay of all FRFs where the modes show one.
pub(crate) fn common_delay(case: &Case) -> Option<Checked> {
    let mut findings = case.model.quality.findings.iter();
    match findings.any(|told| told.code == "common-delay") {
        true => None,
        false => by_phases(case).or_else(|| by_silence(case)),
    }
}

/// The delay that the impulse responses of data show where half of the modes or more overlap as poles
/// do that stand for one. Noise takes a part of these off, and phases may not tell it.
fn by_silence(case: &Case) -> Option<Checked> {
    let modes: Vec<&Mode> = case.model.in_band_modes().collect();
    let axis = &case.data.line_hz;
    let band_hz = axis.last()? - axis.first()?;
    let overlap = |mode: &&Mode| decay_per_s(mode) * modes.len() as f64 > limits::OVERLAP * band_hz;
    let broad = modes.iter().filter(|mode| overlap(mode)).count();
    if broad < limits::BROAD_LEAST.max(modes.len() / 2) {
        return None;
    }
    let values = case.values?;
    let (lines, count) = (axis.len(), case.data.pairs.len());
    let step = count.div_ceil(limits::SILENCE_FRFS_MOST).max(1);
    let frfs: Vec<_> = (0..count)
        .step_by(step)
        .map(|l| values.block(l..l + 1, 0..lines))
        .collect();
    let views: Vec<_> = frfs.iter().map(|frf| frf.view()).collect();
    let frfs = concatenate(Axis(1), &views).ok()?;
    Some(late(onset_s(frfs.view(), axis)?).into())
}

/// The delay that the phases of the sure modes show, with the poles that may stand for it.
fn by_phases(case: &Case) -> Option<Checked> {
    let modes = case.model.modes.iter().enumerate();
    let residues: Vec<Residue> = modes.filter_map(|(n, mode)| Residue::of(n, mode)).collect();
    let shared = likeliest(&residues)?;
    let Shared { delay, phases, .. } = &shared;
    let deviation = phases.deviation(delay, 1)?;
    let rms = (delay.left / phases.weight.iter().sum::<f64>()).sqrt();
    if phases.at_top(delay) < limits::LEAST_TURN || rms > limits::LEFT_OVER {
        return None;
    }
    let reason = || Reason::new("stands-for-delay", "may stand for the delay of all FRFs");
    let modes = case.model.modes.iter().enumerate();
    let weak: Vec<(usize, Reason)> = modes
        .filter(|(n, mode)| mode.in_band && mode.counts() && shared.may_be(*n, mode))
        .map(|(n, _)| (n, reason()))
        .collect();
    let poles = match weak.len() {
        0 => String::new(),
        1 => "; one pole stands for the delay".into(),
        more => format!("; {more} poles stand for the delay"),
    };
    let words = format!(
        "all FRFs {} by {:.4} ms (± {:.4}, read off the phases of {} modes): a filter, a sound \
         card, the way from a loudspeaker; poles of modes are not touched, but shapes turn with \
         frequency, and real shapes do not fit{poles}",
        if delay.seconds > 0.0 { "lag" } else { "lead" },
        1e3 * delay.seconds.abs(),
        1e3 * deviation,
        phases.omega.len(),
    );
    let finding = Finding::caution("common-delay", words)
        .value("delay_ms", 1e3 * delay.seconds)
        .help(format!("take it off: `delay {:.7}`", delay.seconds));
    Some(Checked { finding, weak })
}

/// A delay, and what modes say about it.
struct Shared {
    delay: OneDelay,
    /// Of the modes that it turns.
    phases: Phases,
    /// Positions of the modes that outlast it, and that it does not turn.
    others: Vec<usize>,
    /// Log-likelihood over phases of no order, less the looks.
    gain: f64,
}

impl Shared {
    /// True for a mode of the model, the `n`th, that may stand for the delay.
    fn may_be(&self, n: usize, mode: &Mode) -> bool {
        let decayed = decay_per_s(mode) * self.delay.seconds;
        decayed > limits::OUTLASTED || (decayed > 1.0 && self.others.contains(&n))
    }
}

/// Decay of a mode, 1/s.
fn decay_per_s(mode: &Mode) -> f64 {
    PI * mode.loss_factor * mode.frequency_hz
}

/// The phase that the residues of a mode have in common, up to their sign.
struct Residue {
    /// Position of the mode.
    mode: usize,
    /// rad/s.
    omega: f64,
    /// 1/s.
    decay_per_s: f64,
    /// rad, modulo 180°.
    phase: f64,
    /// Reciprocal variance.
    weight: f64,
    /// Phasor of the doubled phase times the weight.
    doubled: Complex64,
}

impl Residue {
    /// `None` for a mode that is not sure, or a shape of no common phase.
    fn of(n: usize, mode: &Mode) -> Option<Self> {
        let square = square_sum(&mode.shape.0) * square_sum(&mode.participation.0);
        let sure = mode.in_band && mode.trust == Trust::Sure;
        if !sure || square.norm() < limits::COHERENT {
            return None;
        }
        // a pole off by a half-bandwidth turns its residues by a radian
        let half_width_hz = 0.5 * mode.loss_factor * mode.frequency_hz;
        let by_noise = mode.frequency_std_hz / half_width_hz;
        let weight = 1.0 / (limits::NATURAL_PHASE.powi(2) + by_noise.powi(2));
        weight.is_finite().then(|| Self {
            mode: n,
            omega: TAU * mode.frequency_hz,
            decay_per_s: decay_per_s(mode),
            phase: 0.5 * square.arg(),
            weight,
            doubled: weight * square / square.norm(),
        })
    }
}

/// The likeliest delay. Delays are looked at in parts, each with the modes that outlast all of its
/// delays.
fn likeliest(residues: &[Residue]) -> Option<Shared> {
    let (low, high) = residues
        .iter()
        .fold((f64::MAX, 0.0_f64), |(low, high), own| {
            (low.min(own.omega), high.max(own.omega))
        });
    let step = limits::TRIAL_STEP / high;
    // poles that stand for a delay lie its reciprocal apart
    let reach = limits::COMMON_REACH * TAU * residues.len() as f64 / (high - low);
    let longest = reach.min(step * limits::TRIALS_MOST as f64);
    let parts = std::iter::successors(Some(longest), |most| Some(limits::PART_FROM * most))
        .take_while(|most| most * high > limits::LEAST_TURN);
    let of_part = |most: f64| {
        let outlast = |own: &&Residue| own.decay_per_s * most < limits::OUTLASTED;
        let modes: Vec<&Residue> = residues.iter().filter(outlast).collect();
        let seconds = nearest_trial(&modes, [limits::PART_FROM * most, most], step);
        shared(&modes, phases_of(&modes).delay_near(seconds))
    };
    let found = parts.filter_map(of_part);
    found.max_by(|a, b| a.gain.total_cmp(&b.gain))
}

fn phases_of(modes: &[&Residue]) -> Phases {
    let mut phases = Phases::default();
    for own in modes {
        phases.push(own.omega, own.phase, own.weight);
    }
    phases
}

/// The delay of the modes that lie near its line, if they are most; each of the others is one of
/// all, which counts against it.
fn shared(modes: &[&Residue], delay: OneDelay) -> Option<Shared> {
    let off = |own: &Residue| {
        let doubled = 2.0 * (own.phase + own.omega * delay.seconds);
        0.5 * Complex64::from_polar(1.0, doubled).arg()
    };
    let is_near = |own: &&Residue| own.weight * off(own).powi(2) < limits::DELAY_SIGMAS.powi(2);
    let (near, others): (Vec<&Residue>, Vec<&Residue>) = modes.iter().partition(|own| is_near(own));
    if (near.len() as f64) < limits::DELAY_LEAST_MODES.max(limits::ON_LINE * modes.len() as f64) {
        return None;
    }
    let phases = phases_of(&near);
    let delay = phases.delay_near(delay.seconds);
    let looks = others.len() as f64 * (modes.len() as f64).ln();
    Some(Shared {
        gain: phases.for_delay(&delay) - looks,
        others: others.iter().map(|own| own.mode).collect(),
        delay,
        phases,
    })
}

/// The delay or lead between two sizes, s, that phases fit best, of trials a `step` apart.
fn nearest_trial(modes: &[&Residue], [least, most]: [f64; 2], step: f64) -> f64 {
    let phasors = |seconds: f64| {
        let turned = modes.iter().map(move |own| 2.0 * own.omega * seconds);
        turned.map(|angle| Complex64::from_polar(1.0, angle))
    };
    let mut turned: Vec<Complex64> = phasors(least).collect();
    let further: Vec<Complex64> = phasors(step).collect();
    let mut best = (f64::MIN, 0.0);
    for trial in 0..=((most - least) / step) as usize {
        let seconds = least + step * trial as f64;
        // conjugates for a lead
        let (mut lag, mut lead) = (0.0, 0.0);
        for (own, phasor) in modes.iter().zip(&turned) {
            let (even, odd) = (own.doubled.re * phasor.re, own.doubled.im * phasor.im);
            lag += even - odd;
            lead += even + odd;
        }
        for (score, seconds) in [(lag, seconds), (lead, -seconds)] {
            if score > best.0 {
                best = (score, seconds);
            }
        }
        for (phasor, further) in turned.iter_mut().zip(&further) {
            *phasor *= further;
        }
    }
    best.1
}
