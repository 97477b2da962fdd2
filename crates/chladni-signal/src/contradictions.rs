//! The finding of blocks that contradict each other.

use super::runs_differ::{apart, Apart};
use super::takes::Takes;
use super::Group;
use crate::limits::{CLAUSES_MOST, SAME_FACTOR};
use chladni_frf::{Dof, Finding};
use std::collections::BTreeSet;

/// One block of one response beside the others.
#[derive(Debug, Clone)]
pub(super) struct Contradiction {
    response: Dof,
    /// Its block, by name.
    block: String,
    apart: Apart,
    /// Most blocks of the response agree, and this one is wrong; else either side may be.
    by_majority: bool,
    /// Responses that were measured in it.
    beside: usize,
}

/// All of one response.
pub(super) fn of_response(group: &Group, response: Dof, takes: &Takes) -> Vec<Contradiction> {
    let found = apart(takes);
    let with = |(of, apart): ([usize; 2], Apart)| Contradiction {
        response,
        block: name(group, of, takes),
        apart,
        by_majority: found.by_majority,
        beside: group.runs[of[0]].responses().count(),
    };
    found.blocks.into_iter().map(with).collect()
}

/// File of a run, with its number where the file has several, and the block in it.
fn name(group: &Group, [run, block]: [usize; 2], takes: &Takes) -> String {
    let of = group.runs[run];
    let same = |other: &usize| group.runs[*other].file == of.file;
    let before = (0..run).filter(same).count();
    let all = (0..group.runs.len()).filter(same).count();
    let mut words = String::new();
    if of.samples() >= 2 * takes.samples {
        words.push_str(&format!("block {} of ", block + 1));
    }
    if all > 1 {
        words.push_str(&format!("record {} of ", before + 1));
    }
    words + &of.file.display().to_string()
}

/// The finding of all of them.
pub(super) fn finding(contradictions: &[Contradiction]) -> Option<Finding> {
    // one clause for what several responses share in one block
    let mut clauses: Vec<Vec<&Contradiction>> = Vec::new();
    for one in contradictions {
        let shared = |clause: &&mut Vec<&Contradiction>| {
            let first = clause[0];
            first.block == one.block && is_same(&first.apart, &one.apart)
        };
        match clauses.iter_mut().find(shared) {
            Some(clause) => clause.push(one),
            None => clauses.push(vec![one]),
        }
    }
    clauses.sort_by_key(|clause| std::cmp::Reverse(clause.len()));
    let mut words: Vec<String> = clauses
        .iter()
        .take(CLAUSES_MOST)
        .map(|c| words(c))
        .collect();
    if clauses.len() > CLAUSES_MOST {
        words.push(format!("{} more", clauses.len() - CLAUSES_MOST));
    }
    let first = *clauses.first()?.first()?;
    let dofs: BTreeSet<Dof> = contradictions.iter().map(|one| one.response).collect();
    let blocks: BTreeSet<&str> = contradictions.iter().map(|one| &*one.block).collect();
    let words = format!(
        "records of one FRF contradict each other at its peaks, and their average is none of them. \
         Beside the others: {}{}",
        words.join("; "),
        without_majority(contradictions)
    );
    let mut finding = Finding::caution("runs-differ", words)
        .dofs(dofs)
        .value("records", blocks.len() as f64);
    if let Apart::Law { factor, delay } = first.apart {
        finding = finding
            .value("factor", factor)
            .value("delay_samples", delay);
    }
    Some(finding.help(
        "leave the wrong records out, or measure them again; look at sensor, cable, range and trigger",
    ))
}

/// The end of the sentence where most blocks of a response do not agree.
fn without_majority(contradictions: &[Contradiction]) -> String {
    let open = contradictions.iter().filter(|one| !one.by_majority);
    let responses: BTreeSet<String> = open.map(|one| one.response.to_string()).collect();
    if responses.is_empty() {
        return String::new();
    }
    let at = match contradictions.iter().any(|one| one.by_majority) {
        true => {
            let named: Vec<String> = responses.into_iter().collect();
            format!(" at {}", named.join(", "))
        }
        false => String::new(),
    };
    format!("; no majority agrees{at}, so the others may as well be wrong")
}

/// True where one cause may have made both.
fn is_same(a: &Apart, b: &Apart) -> bool {
    match (a, b) {
        (Apart::Otherwise, Apart::Otherwise) => true,
        (
            Apart::Law { factor, delay },
            Apart::Law {
                factor: other,
                delay: later,
            },
        ) => (factor / other - 1.0).abs() < SAME_FACTOR && (delay - later).abs() < 0.5,
        _ => false,
    }
}

/// The clause on some responses in one block.
fn words(clause: &[&Contradiction]) -> String {
    let first = clause[0];
    let who = match clause.len() {
        1 => format!("{} in {}", first.response, first.block),
        count if count == first.beside => format!("all {count} responses in {}", first.block),
        count => format!(
            "{count} responses in {}, first {},",
            first.block, first.response
        ),
    };
    let one = clause.len() == 1;
    let (has, is) = if one { ("has", "is") } else { ("have", "are") };
    match first.apart {
        Apart::Otherwise => {
            let verb = if one { "follows" } else { "follow" };
            format!("{who} {verb} no common factor, as where cables are swapped")
        }
        Apart::Law { factor, delay } => {
            let size = factor.abs();
            let mut parts = Vec::new();
            if factor < 0.0 {
                parts.push(format!("{has} the opposite sign"));
            }
            let is_plain = factor > 0.0 && delay == 0.0;
            if is_plain || size.ln().abs() > SAME_FACTOR {
                parts.push(format!("{is} {size:.3} times as large"));
            }
            if delay != 0.0 {
                let comes = if one { "comes" } else { "come" };
                let when = if delay > 0.0 { "later" } else { "earlier" };
                parts.push(format!("{comes} {:.1} samples {when}", delay.abs()));
            }
            format!("{who} {}", parts.join(" and "))
        }
    }
}
