//! The result of reducing blocks of FRFs, and how it is merged.

use crate::data::pair_weights::NoiseSource;
use crate::pieces::limits;
use crate::pieces::plan::Plan;
use crate::pieces::poles::{Matrix, Poles};
use chladni_frf::{Checksum, Dof, Error, Finding, Node, Source};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

/// The result of a pass over one or more blocks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Partial {
    pub(crate) plan: Plan,
    /// Those that the pass was run with; `None`: the first pass without a pilot.
    pub(crate) poles: Option<Arc<Poles>>,
    /// By rising number.
    pub(crate) blocks: Vec<Block>,
    /// By rising number; no two that could be one.
    pub(crate) runs: Vec<Run>,
}

/// The FRFs of a block.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Block {
    pub number: u64,
    /// Of its pieces, where it was reduced piece by piece.
    pub piece: u64,
    /// Number of blocks that the data were cut into, where it is known.
    pub of: Option<u64>,
    pub responses: Vec<Dof>,
    pub references: Vec<Dof>,
    /// Of these DOFs, where the data have them.
    pub nodes: Vec<Node>,
    /// (response, reference) of the FRFs used.
    pub pairs: Vec<(usize, usize)>,
    /// Sum of squares of each FRF on the lines used, in SI units of the kind (second
    /// pass).
    pub energy: Vec<f64>,
    /// R₀, (unknown, FRF) (second pass).
    pub r0: Option<Matrix<f64>>,
    /// Noise energy of each FRF, up to a factor, where the data tell it (first pass).
    pub given: Option<(NoiseSource, Vec<f64>)>,
    /// Files that it came from, by name and content.
    pub sources: Vec<(String, Checksum)>,
}

impl Block {
    /// A block of which only the FRFs are known yet.
    pub fn of_pairs(pairs: Vec<(usize, usize)>) -> Self {
        Self {
            number: 0,
            piece: 0,
            of: None,
            responses: Vec::new(),
            references: Vec::new(),
            nodes: Vec::new(),
            pairs,
            energy: Vec::new(),
            r0: None,
            given: None,
            sources: Vec::new(),
        }
    }
}

/// Sources as a block has them.
pub(crate) fn named(sources: &[Source]) -> Vec<(String, Checksum)> {
    let named = |source: &Source| (source.file.clone(), source.checksum.clone());
    sources.iter().map(named).collect()
}

/// Sums over the blocks `first..first + length`, where `length` is a power of two that
/// divides `first`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Run {
    pub first: u64,
    pub length: u64,
    pub sums: Sums,
}

/// Sums over FRFs: the sketch of a first pass, the products of a second, or both of a
/// first pass with the poles of a pilot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Sums {
    pub sketch: Option<SketchSums>,
    pub products: Option<ProductSums>,
}

/// Sums of the first pass, in units of the measured values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct SketchSums {
    /// (line, column).
    pub columns: Matrix<Complex64>,
    /// FRFs in each column.
    pub counts: Vec<u64>,
    /// Sum of squares of each line.
    pub line_energy: Vec<f64>,
    /// Lines on which an FRF is not finite.
    pub bad: Vec<bool>,
}

/// Sums of the second.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct ProductSums {
    pub t: Matrix<f64>,
    pub gram: Matrix<f64>,
}

impl Block {
    fn key(&self) -> (u64, u64) {
        (self.number, self.piece)
    }
}

impl Sums {
    /// Adds `other`; what only one of both holds is lost.
    fn add(&mut self, other: Self) {
        fn sum<T: std::ops::AddAssign>(left: &mut [T], right: Vec<T>) {
            left.iter_mut()
                .zip(right)
                .for_each(|(left, right)| *left += right);
        }
        self.sketch = self
            .sketch
            .take()
            .zip(other.sketch)
            .map(|(mut sketch, other)| {
                sum(&mut sketch.columns.values, other.columns.values);
                sum(&mut sketch.counts, other.counts);
                sum(&mut sketch.line_energy, other.line_energy);
                sketch
                    .bad
                    .iter_mut()
                    .zip(other.bad)
                    .for_each(|(bad, other)| *bad |= other);
                sketch
            });
        self.products = self
            .products
            .take()
            .zip(other.products)
            .map(|(mut products, other)| {
                sum(&mut products.t.values, other.t.values);
                sum(&mut products.gram.values, other.gram.values);
                products
            });
    }
}

impl Partial {
    /// One partial of many, in whatever order: the bits depend on the blocks alone.
    ///
    /// # Errors
    /// Nothing to merge, pieces of different fits, a block or an FRF that occurs twice.
    pub fn merge(partials: impl IntoIterator<Item = Self>) -> Result<Self, Error> {
        let mut partials = partials.into_iter();
        let nothing = || {
            Error::bad_data("nothing to merge")
                .field("partials")
                .found("none")
                .expected("at least one")
                .help("name the partials of all blocks")
        };
        let mut all = partials.next().ok_or_else(nothing)?;
        for other in partials {
            let whose = other.named();
            all.plan.same(&other.plan, &whose)?;
            if !same_poles(&all.poles, &other.poles) {
                let pass = |poles: &Option<Arc<Poles>>| {
                    poles.as_ref().map_or("no poles".into(), |poles| {
                        format!("{} poles", poles.count())
                    })
                };
                return Err(
                    Error::bad_data(format!("{whose} was reduced with other poles"))
                        .field("poles")
                        .found(pass(&other.poles))
                        .expected(format!("the same {}, as in the others", pass(&all.poles)))
                        .help("reduce every block with the same poles"),
                );
            }
            all.blocks.extend(other.blocks);
            all.runs.extend(other.runs);
        }
        all.blocks.sort_by_key(Block::key);
        if let Some(twice) = all
            .blocks
            .windows(2)
            .find(|pair| pair[0].key() == pair[1].key())
        {
            return Err(Error::bad_data("a block occurs twice")
                .field("number of the block")
                .found(twice[0].number)
                .expected("every block once")
                .help("give every block a number of its own, and merge each once"));
        }
        all.runs.sort_by_key(|run| run.first);
        let mut joined: Vec<Run> = Vec::new();
        for run in all.runs {
            joined.push(run);
            while let [.., left, right] = &joined[..] {
                if !left.is_sibling(right) {
                    break;
                }
                let right = joined.pop().expect("two are left").sums;
                let left = joined.last_mut().expect("one is left");
                left.sums.add(right);
                left.length *= 2;
            }
        }
        all.runs = joined;
        Ok(all)
    }

    /// All blocks as the pieces of one, with this number.
    pub fn as_block(mut self, number: u64) -> Self {
        for (piece, block) in self.blocks.iter_mut().enumerate() {
            (block.number, block.piece) = (number, piece as u64);
        }
        let run = |sums| Run {
            first: number,
            length: 1,
            sums,
        };
        self.runs = sums(self.runs).map(run).into_iter().collect();
        self
    }

    /// Sets the number of blocks that the data were cut into, where it is known.
    pub fn of_blocks(mut self, count: Option<u64>) -> Self {
        self.blocks.iter_mut().for_each(|block| block.of = count);
        self
    }

    /// The finding on blocks that are not in it, where all that are say the same number of
    /// them.
    pub fn missing(&self) -> Option<Finding> {
        let of = self.blocks.first()?.of?;
        if self.blocks.iter().any(|block| block.of != Some(of)) {
            return None;
        }
        let missing = of.checked_sub(self.blocks() as u64).filter(|&n| n > 0)?;
        let numbers = (0..of).filter(|&number| !self.holds(number));
        let mut named: Vec<String> = numbers
            .take(limits::MISSING_NAMED)
            .map(|number| number.to_string())
            .collect();
        if missing > named.len() as u64 {
            named.push("…".into());
        }
        let words = format!(
            "{missing} of {of} blocks {} missing: {}",
            if missing == 1 { "is" } else { "are" },
            named.join(", ")
        );
        let finding = Finding::caution("blocks-missing", words)
            .value("missing", missing as f64)
            .value("blocks", of as f64)
            .help("merge the partials of all blocks, unless their FRFs are left out on purpose");
        Some(finding)
    }

    /// Sets the sources of the FRFs.
    pub fn with_sources(mut self, sources: &[Source]) -> Self {
        self.blocks
            .iter_mut()
            .for_each(|block| block.sources = named(sources));
        self
    }

    /// Number of blocks.
    pub fn blocks(&self) -> usize {
        self.blocks.chunk_by(|a, b| a.number == b.number).count()
    }

    /// Number of FRFs.
    pub fn frfs(&self) -> usize {
        self.blocks.iter().map(|block| block.pairs.len()).sum()
    }

    /// True where the block with this number is in it.
    pub fn holds(&self, number: u64) -> bool {
        self.blocks
            .binary_search_by_key(&number, |block| block.number)
            .is_ok()
    }

    /// The poles that the pass was run with; `None` after the first.
    pub fn poles(&self) -> Option<&Poles> {
        self.poles.as_deref().filter(|poles| !poles.is_of_pilot())
    }

    /// The poles of the pilot that the first pass was run with, if any.
    pub fn pilot(&self) -> Option<&Poles> {
        self.poles.as_deref().filter(|poles| poles.is_of_pilot())
    }

    /// The files that the blocks came from, each once.
    pub fn sources(&self) -> Vec<Source> {
        let mut seen = HashSet::new();
        let all = self.blocks.iter().flat_map(|block| &block.sources);
        let source = |(file, checksum): &(String, Checksum)| Source {
            file: file.clone(),
            checksum: checksum.clone(),
        };
        all.filter(|source| seen.insert(*source))
            .map(source)
            .collect()
    }

    /// The options that the data were read with, as [`crate::pieces::Reducer`] was told.
    pub fn reading(&self) -> &BTreeMap<String, String> {
        &self.plan.reading
    }

    fn named(&self) -> String {
        match self.blocks.as_slice() {
            [block] => format!("block {}", block.number),
            [first, .., last] => format!(
                "the partial with blocks {} to {}",
                first.number, last.number
            ),
            [] => "an empty partial".into(),
        }
    }
}

/// The sums over all blocks.
pub(crate) fn sums(runs: Vec<Run>) -> Option<Sums> {
    let mut runs = runs.into_iter().map(|run| run.sums);
    let mut all = runs.next()?;
    runs.for_each(|sums| all.add(sums));
    Some(all)
}

/// Equal, or even the same.
fn same_poles(a: &Option<Arc<Poles>>, b: &Option<Arc<Poles>>) -> bool {
    match (a, b) {
        (Some(a), Some(b)) => Arc::ptr_eq(a, b) || a == b,
        (a, b) => a.is_none() && b.is_none(),
    }
}

impl Run {
    /// True where `right` follows, and both together are a run.
    fn is_sibling(&self, right: &Self) -> bool {
        self.length == right.length
            && self.first.is_multiple_of(2 * self.length)
            && right.first == self.first + self.length
    }
}
