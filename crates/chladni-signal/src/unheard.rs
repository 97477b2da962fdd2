//! Responses that hold nothing of the force: their coherence is nowhere above chance.
//!
//! The coherence γ² of noise under q references and n independent blocks has −ln(1 − γ²) as a
//! sum of q exponential variables, of mean 1/(n − q) at most. Its largest value on one line, and
//! its largest sum over a few neighbouring ones, tell whether anything else is in it.

use super::estimators::LineEstimate;
use super::spectra::Averages;
use super::still;
use super::takes::Take;
use crate::limits::{UNHEARD_CHANCE, UNHEARD_FREEDOM, UNHEARD_LINES};
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
    let sizes: Vec<f64> = takes.iter().map(|take| of_take(take).sqrt()).collect();
    let count = takes.first().map_or(0, |take| take.pairs.len());
    let of_line = |k: usize| {
        let (mut cross, mut of_x, mut of_y) = (Complex64::default(), 0.0, 0.0);
        for (take, size) in takes.iter().zip(&sizes) {
            let [x, y] = take.pairs[k].map(|value| value / size);
            cross += y * x.conj();
            of_x += x.norm_sqr();
            of_y += y.norm_sqr();
        }
        (cross.norm_sqr() / (of_x * of_y)).min(1.0)
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
    [1, UNHEARD_LINES].into_iter().any(|count| {
        let sums = known.windows(count).map(|lines| lines.iter().sum::<f64>());
        let largest = sums.fold(0.0, f64::max);
        chance(largest, count * references) * (known.len() as f64) < UNHEARD_CHANCE
    })
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
        1 => format!("the coherence of the response {first} is"),
        count => format!("coherences of {count} responses, first {first}, are"),
    };
    let words =
        format!("{words} on no line above what noise has by chance: no force is heard in it");
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
}
