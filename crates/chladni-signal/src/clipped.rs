//! Records that ran into the end of their range.

use crate::limits::{CLIPPED_BESIDE, CLIPPED_LEVELS, CLIPPED_MOST, CLIPPED_SAMPLES, CLIPPED_UNDER};
use chladni_frf::{counted, Dof, Finding, Run};
use std::collections::BTreeSet;

/// The finding of channels that stay at their largest value, up or down, where a signal would
/// have passed through values a little below it far more often.
pub(super) fn clipped(runs: &[Run]) -> Option<Finding> {
    let channels = runs.iter().flat_map(|run| &run.channels);
    let dofs: BTreeSet<Dof> = channels
        .filter(|channel| is_clipped(&channel.samples))
        .map(|channel| channel.dof)
        .collect();
    if dofs.is_empty() {
        return None;
    }
    let words = format!(
        "records of {} stay at their largest value, again and again: they are clipped, and FRFs of \
         them hold what no structure does",
        counted(dofs.len(), "channel")
    );
    let finding = Finding::caution("clipped-records", words).dofs(dofs);
    Some(finding.help("measure again with a wider range of these channels"))
}

fn is_clipped(samples: &[f64]) -> bool {
    [1.0, -1.0].into_iter().any(|sign| {
        let values = || samples.iter().map(|value| sign * value);
        let top = values().fold(f64::NEG_INFINITY, f64::max);
        let of_all = |count: usize| count as f64 / samples.len() as f64;
        // a peak that a periodic signal repeats counts once
        let mut seen = BTreeSet::new();
        let at = |k: usize| samples.get(k).map_or(f64::NAN, |value| sign * value);
        let ends_there = |k: &usize| {
            let [before, after] = [k.wrapping_sub(1), k + 1].map(at);
            let flat = before == top || after == top;
            at(*k) == top && (flat || seen.insert([before, after].map(f64::to_bits)))
        };
        let at_top = (0..samples.len()).filter(ends_there).count();
        let below = values().filter(|value| *value < top && *value >= CLIPPED_UNDER * top);
        let mut levels = BTreeSet::new();
        let many = values()
            .filter(|value| *value > 0.0)
            .any(|value| levels.insert(value.to_bits()) && levels.len() == CLIPPED_LEVELS);
        // neither a signal of two levels is clipped nor one of a few steps of a converter
        many && top > 0.0
            && at_top >= CLIPPED_SAMPLES
            && of_all(at_top) < CLIPPED_MOST
            && at_top as f64 > CLIPPED_BESIDE * below.count() as f64
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_distr::StandardNormal;

    fn noise(seed: u64) -> Vec<f64> {
        let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
        (0..20_000).map(|_| random.sample(StandardNormal)).collect()
    }

    /// On the steps of a converter that has so many up to 1.
    fn rounded(samples: &[f64], steps: f64) -> Vec<f64> {
        samples.iter().map(|x| (x * steps).round()).collect()
    }

    #[test]
    fn ranges_that_end_are_found_and_nothing_else() {
        let sine: Vec<f64> = (0..20_000).map(|k| (0.003 * f64::from(k)).sin()).collect();
        let blow: Vec<f64> = (0..20_000)
            .map(|k| (-0.5 * (f64::from(k - 400) / 6.0).powi(2)).exp())
            .collect();
        let levels: Vec<f64> = noise(1).iter().map(|x| x.signum()).collect();
        for seed in 0..20 {
            let random = noise(seed);
            for steps in [0.4, 1.0, 3.0, 10.0, 100.0, 3000.0] {
                assert!(!is_clipped(&rounded(&random, steps)), "{seed} {steps}");
            }
            assert!(!is_clipped(&random));
            let cut = |most: f64| -> Vec<f64> { random.iter().map(|x| x.min(most)).collect() };
            for most in [0.5, 1.5, 2.5] {
                assert!(is_clipped(&cut(most)), "{seed} {most}");
                assert!(is_clipped(&rounded(&cut(most), 3000.0)), "{seed} {most}");
                let down: Vec<f64> = cut(most).iter().map(|x| -x).collect();
                assert!(is_clipped(&down), "{seed} {most}");
            }
        }
        assert!(!is_clipped(&noise(1)[..2000].repeat(10)));
        for steps in [100.0, 3000.0, 30_000.0] {
            for whole in [&sine, &blow, &levels] {
                assert!(!is_clipped(&rounded(whole, steps)), "{steps}");
            }
        }
        let cut = |whole: &[f64]| -> Vec<f64> { whole.iter().map(|x| x.min(0.6)).collect() };
        assert!(is_clipped(&cut(&blow)) && is_clipped(&cut(&sine)));
        assert!(!is_clipped(&[0.0; 500]) && !is_clipped(&[2.0; 500]) && !is_clipped(&[]));
    }
}
