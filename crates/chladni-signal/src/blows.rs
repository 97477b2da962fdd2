//! Records that begin within the blow.

use super::excitation::rest_level;
use crate::limits::{BLOW_CUT, BLOW_NOISE, BLOW_PART, LAST_PART};
use chladni_frf::{Dof, Finding, Run};
use std::collections::BTreeSet;

/// The finding of blocks whose first sample is in the middle of a blow: what came before is in
/// the response, and not in the force.
pub(super) fn cut_off(runs: &[Run], block: usize) -> Option<Finding> {
    let mut dofs = BTreeSet::<Dof>::new();
    let (mut cut, mut all, mut largest) = (0, 0, 0.0_f64);
    for run in runs {
        for at in 0..run.samples() / block {
            all += 1;
            let mut is_cut = false;
            for channel in run.references() {
                let samples = &channel.samples[at * block..(at + 1) * block];
                if let Some(part) = begins_at(samples) {
                    dofs.insert(channel.dof);
                    largest = largest.max(part);
                    is_cut = true;
                }
            }
            cut += usize::from(is_cut);
        }
    }
    let first = dofs.first()?;
    let words = format!(
        "{cut} of {all} blocks begin within the blow, the force at {first} at up to {:.0} % of its \
         peak: what came before is in the responses and not in the force, and FRFs come out off",
        100.0 * largest
    );
    let finding = Finding::caution("blow-cut-off", words).dofs(dofs);
    let finding = finding.value("part_of_peak", largest);
    Some(finding.help("let records begin a little before the trigger, and measure again"))
}

/// The first sample of a blow over its peak, where the blow has begun before it.
fn begins_at(samples: &[f64]) -> Option<f64> {
    let silence = rest_level(samples);
    let size = |x: &f64| (x - silence).abs();
    let peak = samples.iter().map(size).fold(0.0, f64::max);
    let last = &samples[samples.len() - samples.len().div_ceil(LAST_PART)..];
    let power = last.iter().map(|x| size(x).powi(2)).sum::<f64>() / last.len() as f64;
    let acting = samples.iter().filter(|x| size(x) > BLOW_CUT * peak).count();
    let [first, second] = [size(samples.first()?), size(samples.get(1)?)];
    // an impulse of one sample and a step are made, not measured: they may begin at once
    let is_made = first == second || second < BLOW_CUT * first;
    let is_blow = acting as f64 <= BLOW_PART * samples.len() as f64;
    let is_cut = first > BLOW_CUT * peak && first > BLOW_NOISE * power.sqrt();
    (is_blow && is_cut && !is_made).then_some(first / peak)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blows_that_lack_their_beginning_are_told_and_no_others() {
        let bell = |at: f64| -> Vec<f64> {
            let of = |k: i32| (-((f64::from(k) - at) / 5.0).powi(2)).exp() + 0.1;
            (0..2000).map(of).collect()
        };
        for (at, part) in [(0.0, 1.0), (5.0, 0.37), (-5.0, 1.0)] {
            let told = begins_at(&bell(at)).unwrap_or_default();
            assert!((told - part).abs() < 0.01, "{at}: {told}");
        }
        assert_eq!(begins_at(&bell(9.0)), None);
        let made = |acting: usize| -> Vec<f64> {
            let of = |k| f64::from(u8::from(k < acting));
            (0..2000).map(of).collect()
        };
        let sweep = (0..2000).map(|k| (1e-4 * f64::from(k * k)).cos());
        for other in [made(1), made(4), vec![0.0; 2000], sweep.collect()] {
            assert_eq!(begins_at(&other), None);
        }
    }
}
