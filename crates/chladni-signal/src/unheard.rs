//! Responses that hold nothing of the force: their coherence is nowhere above chance.
//!
//! The coherence γ² of noise under q references and n independent blocks has −ln(1 − γ²) as a
//! sum of q exponential variables, of mean 1/(n − q) at most. Its largest value on one line, and
//! its largest sum over a few neighbouring ones, tell whether anything else is in it.

use super::estimators::LineEstimate;
use super::still;
use crate::limits::{UNHEARD_CHANCE, UNHEARD_LINES};
use chladni_frf::{Dof, Finding};
use std::collections::BTreeSet;

/// True where coherence is above chance somewhere, or where it cannot be told.
pub(super) fn is_heard(lines: &[LineEstimate], independent: f64, references: usize) -> bool {
    let freedom = independent - references as f64;
    let values = lines.iter().map(|line| line.coherence);
    let known: Vec<f64> = values
        .filter(|coherence| coherence.is_finite())
        .map(|coherence| -(1.0 - coherence).max(f64::MIN_POSITIVE).ln() * freedom)
        .collect();
    if freedom < 1.0 || known.len() < UNHEARD_LINES {
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
