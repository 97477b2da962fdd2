//! The functions of a universal file in groups that are read together.
//!
//! A group is the FRFs of one pair of DOFs (one, unless a pair was measured again) with the
//! coherence of that pair. A dataset that is damaged or cut goes with the FRF before it,
//! where its error is told, or with `lenient` a cut FRF is lengthened. Time records and other
//! functions serve no FRF and are left out.

use super::stretches::Stretch;
use crate::assemble::{COHERENCE, FRF};
use crate::uff::{DatasetPlace, PlacedFunction};
use chladni_frf::{Dof, Finding};
use std::collections::{BTreeSet, HashMap};
use std::ops::Range;
use std::path::Path;

/// Response and reference of a function.
type Pair = (Dof, Dof);

/// The functions of a file.
#[derive(Debug, Clone, Default)]
pub(super) struct Groups {
    /// The functions of all groups, group by group.
    functions: Vec<Stretch>,
    /// For each group the number of functions in it and in those before.
    ends: Vec<usize>,
    /// All datasets other than functions: every group is read with these.
    pub(super) beside: Vec<Stretch>,
    /// Nodes of the responses and of the references.
    pub(super) nodes: [BTreeSet<u64>; 2],
    /// Number of functions that are neither FRFs nor coherence.
    pub(super) others: usize,
    /// Coherence of no FRF in the file: the number, and the first.
    lost_coherence: Option<(usize, Pair)>,
}

impl Groups {
    /// Groups the datasets of a file.
    pub(super) fn of(places: Vec<DatasetPlace>) -> Self {
        let mut sorting = Sorting::default();
        places.into_iter().for_each(|place| sorting.add(place));
        sorting.finish()
    }

    /// Number of groups.
    pub(super) fn count(&self) -> usize {
        self.ends.len()
    }

    /// The functions of some groups.
    pub(super) fn functions_of(&self, groups: Range<usize>) -> &[Stretch] {
        let behind = |group: usize| match group {
            0 => 0,
            group => self.ends[group - 1],
        };
        &self.functions[behind(groups.start)..behind(groups.end)]
    }

    /// Bytes of all groups, without the datasets beside them.
    pub(super) fn bytes(&self) -> u64 {
        self.functions.iter().map(Stretch::length).sum()
    }

    /// The finding about coherence that is not used.
    pub(super) fn finding(&self, file: &Path) -> Option<Finding> {
        let (count, (response, reference)) = self.lost_coherence?;
        let words = format!(
            "{count} coherence functions belong to no FRF of the same file, the first is \
             ({response}, {reference}) in {}; a set that is read part by part does not use them \
             as weights",
            file.display()
        );
        let help = "if the FRFs are in another file, convert both into one first";
        Some(Finding::note("coherence-unmatched", words).help(help))
    }
}

/// Datasets of a file while they are grouped.
#[derive(Default)]
struct Sorting {
    sorted: Groups,
    /// Group of each pair.
    group_of: HashMap<Pair, usize>,
    /// The functions with their groups.
    grouped: Vec<(usize, Stretch)>,
    coherence: Vec<(Pair, Stretch)>,
    /// Functions with something missing, their pairs, and the number of groups before them.
    damaged: Vec<(Option<Pair>, usize, Stretch)>,
}

impl Sorting {
    fn add(&mut self, place: DatasetPlace) {
        let stretch = Stretch {
            bytes: place.bytes,
            line: place.line,
        };
        let count = self.group_of.len();
        let pair = |function: PlacedFunction| (function.response, function.reference);
        match place.function {
            _ if place.number != Some(58) => self.sorted.beside.push(stretch),
            Some(function) if place.is_whole => self.add_whole(function, stretch),
            function => self.damaged.push((function.map(pair), count, stretch)),
        }
    }

    fn add_whole(&mut self, function: PlacedFunction, stretch: Stretch) {
        let pair = (function.response, function.reference);
        match function.function_type {
            FRF => {
                let next = self.group_of.len();
                let group = *self.group_of.entry(pair).or_insert(next);
                self.grouped.push((group, stretch));
            }
            COHERENCE => self.coherence.push((pair, stretch)),
            _ => {
                self.sorted.others += 1;
                return;
            }
        }
        let [responses, references] = &mut self.sorted.nodes;
        responses.insert(pair.0.node);
        references.insert(pair.1.node);
    }

    fn finish(mut self) -> Groups {
        for (pair, stretch) in self.coherence {
            match self.group_of.get(&pair) {
                Some(&group) => self.grouped.push((group, stretch)),
                None => self.sorted.lost_coherence.get_or_insert((0, pair)).0 += 1,
            }
        }
        let whole = self.group_of.len();
        for (k, (pair, before, stretch)) in self.damaged.into_iter().enumerate() {
            let own = pair.and_then(|pair| self.group_of.get(&pair));
            let group = match (whole, own) {
                (0, _) => k,
                (_, Some(&group)) => group,
                (_, None) => before.saturating_sub(1),
            };
            self.grouped.push((group, stretch));
        }
        self.sorted.fill(self.grouped);
        self.sorted
    }
}

impl Groups {
    fn fill(&mut self, mut grouped: Vec<(usize, Stretch)>) {
        grouped.sort_by_key(|(group, stretch)| (*group, stretch.bytes.start));
        let groups = grouped.chunk_by(|a, b| a.0 == b.0);
        self.ends = groups
            .scan(0, |end, group| {
                *end += group.len();
                Some(*end)
            })
            .collect();
        self.functions = grouped.into_iter().map(|(_, stretch)| stretch).collect();
    }
}
