//! Responses that are not distinguishable from noise: their coherence is nowhere above chance.
//!
//! The coherence γ² of noise under q references and n independent blocks has −ln(1 − γ²) as a
//! sum of q exponential variables, of mean 1/(n − q) at most. Its largest value on one line, its
//! largest sum over a few neighbouring ones, and its sum over all of them, where coherence is weak
//! and broad, tell whether anything else is in it.

use super::estimators::LineEstimate;
use super::spectra::Averages;
use super::still;
use super::takes::Take;
use crate::limits::{UNHEARD_CHANCE, UNHEARD_ERRORS, UNHEARD_FREEDOM, UNHEARD_LINES, UNHEARD_MEAN};
use chladni_frf::{Dof, Finding};
use num_complex::Complex64;
use std::collections::BTreeSet;

/// True where coherence is above chance somewhere, or where it cannot be told.
pub(super) fn is_heard(averages: &Averages, lines: &[LineEstimate], references: usize) -> bool {
    let values = lines.iter().map(|line| line.coherence).collect();
    let is_heard = is_above_chance(values, averages.independent, references);
    let takes = &averages.takes;
    // lines chosen for what one block has there are no fair sample
    let is_fair = takes.lines.len() == lines.len() && takes.takes.len() == averages.blocks;
    if !(is_heard && is_fair) {
        return is_heard;
    }
    is_above_chance(
        level_coherence(&takes.takes),
        averages.independent,
        references,
    )
}

/// Coherence of one reference with a response whose blocks weigh alike: where noise follows the
/// range of a blow, that of the hardest blow is coherent with itself.
fn level_coherence(takes: &[Take]) -> Vec<f64> {
    let of_take = |take: &Take| take.pairs.iter().map(|[_, y]| y.norm_sqr()).sum::<f64>();
    // a block at rest tells nothing
    let sized = takes.iter().map(|take| (take, of_take(take).sqrt()));
    let sized: Vec<(&Take, f64)> = sized.filter(|(_, size)| *size > 0.0).collect();
    let count = takes.first().map_or(0, |take| take.pairs.len());
    let of_line = |k: usize| {
        let (mut cross, mut of_x, mut of_y) = (Complex64::default(), 0.0, 0.0);
        for (take, size) in &sized {
            let [x, y] = take.pairs[k].map(|value| value / size);
            cross += y * x.conj();
            of_x += x.norm_sqr();
            of_y += y.norm_sqr();
        }
        let coherence = cross.norm_sqr() / (of_x * of_y);
        // the least of NaN and 1 is 1
        match coherence.is_finite() {
            true => coherence.min(1.0),
            false => 0.0,
        }
    };
    (0..count).map(of_line).collect()
}

fn is_above_chance(coherence: Vec<f64>, independent: f64, references: usize) -> bool {
    let freedom = independent - references as f64;
    let known: Vec<f64> = coherence
        .into_iter()
        .filter(|coherence| coherence.is_finite())
        .map(|coherence| -(1.0 - coherence).max(f64::MIN_POSITIVE).ln() * freedom)
        .collect();
    if freedom < UNHEARD_FREEDOM || known.len() < UNHEARD_LINES {
        return true;
    }
    let is_peak = |count: usize| {
        let sums = known.windows(count).map(|lines| lines.iter().sum::<f64>());
        let largest = sums.fold(0.0, f64::max);
        chance(largest, count * references) * (known.len() as f64) < UNHEARD_CHANCE
    };
    is_peak(1) || is_peak(UNHEARD_LINES) || is_broad(known.iter().sum(), known.len() * references)
}

/// True where a sum of `count` exponential variables of mean 1 is above chance, by the third root,
/// nearly normal (Wilson & Hilferty): far out a chance would be 0 in digits.
fn is_broad(sum: f64, count: usize) -> bool {
    let count = count as f64;
    let mean = sum / count;
    let errors = 3.0 * count.sqrt() * (mean.cbrt() - 1.0 + 1.0 / (9.0 * count));
    mean > UNHEARD_MEAN && errors > UNHEARD_ERRORS
}

/// Chance of a sum of `count` exponential variables of mean 1 above `sum`.
fn chance(sum: f64, count: usize) -> f64 {
    let mut term = (-sum).exp();
    let mut all = term;
    for k in 1..count {
        term *= sum / k as f64;
        all += term;
    }
    all
}

/// The finding that names them.
pub(super) fn finding(unheard: &BTreeSet<Dof>) -> Option<Finding> {
    let first = unheard.first()?;
    let words = match unheard.len() {
        1 => format!("the response {first} is not distinguishable from noise: its coherence is"),
        count => format!(
            "{count} responses, first {first}, are not distinguishable from noise: coherences are"
        ),
    };
    let words =
        format!("{words} neither on single lines nor on all together above what chance gives");
    let finding = Finding::caution("response-unheard", words);
    Some(finding.dofs(unheard.iter().copied()).help(still::HELP))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chance_of_a_sum_is_that_of_poisson() {
        assert!((chance(2.0, 1) - (-2.0_f64).exp()).abs() < 1e-15);
        // 1 − the 95 % point of chi square with 16 degrees of freedom
        assert!((chance(26.296 / 2.0, 8) - 0.05).abs() < 1e-5);
    }

    #[test]
    fn weak_coherence_on_all_lines_is_heard_and_that_of_noise_is_not() {
        let freedom = 2.0;
        // one value in each of 1000 parts of equal chance, neighbours far apart
        let of = |mean: f64| -> Vec<f64> {
            let part = |k: usize| ((k * 389 % 1000) as f64 + 0.5) / 1000.0;
            (0..1000)
                .map(|k| 1.0 - part(k).powf(mean / freedom))
                .collect()
        };
        for (mean, is_heard) in [(1.0, false), (1.04, false), (1.3, true), (1.7, true)] {
            assert_eq!(
                is_above_chance(of(mean), freedom + 1.0, 1),
                is_heard,
                "{mean}"
            );
        }
        assert!(is_broad(1e9, 1000));
    }

    #[test]
    fn blocks_without_power_are_not_coherent() {
        let still = |of| Take {
            of,
            is_start: false,
            pairs: vec![[Complex64::from(1.0), Complex64::default()]; 3],
        };
        assert_eq!(level_coherence(&[still([0, 0]), still([1, 0])]), [0.0; 3]);
    }
}
