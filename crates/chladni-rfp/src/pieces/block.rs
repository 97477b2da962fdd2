//! One block of FRFs, reduced.

use crate::data::error::FitError;
use crate::data::given_noise::given_noise;
use crate::data::layout::{DataLayout, Weighting};
use crate::data::options::{Effort, FitOptions};
use crate::data::pair_weights::NoiseSource;
use crate::data::reading::Usable;
use crate::data::screening::Screened;
use crate::data::sketch::{self, Mixing};
use crate::data::window::of_set::with_set;
use crate::pieces::error::PieceError;
use crate::pieces::partial::{named, Block, Partial, ProductSums, Run, SketchSums, Sums};
use crate::pieces::plan::Plan;
use crate::pieces::poles::{Matrix, Pass, Poles};
use crate::pieces::second_pass::{second_pass, Basis};
use chladni_frf::{Error, FrfSet, Source};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

/// A pass over blocks, with what all of them need.
#[derive(Debug)]
pub struct Reducer {
    options: FitOptions,
    /// The poles that the pass is run with; `None`: the first, which leaves a sketch.
    poles: Option<Arc<Poles>>,
    /// Of the products.
    basis: Option<Basis>,
    reading: BTreeMap<String, String>,
}

impl Reducer {
    /// Without `poles` the first pass, with them the one that they ask for.
    ///
    /// # Errors
    /// Poles of an axis without lines in their band.
    pub fn new(options: &FitOptions, poles: Option<&Poles>) -> Result<Self, PieceError> {
        let basis = poles.and_then(|poles| Some((poles, poles.way.as_ref()?)));
        Ok(Self {
            options: options.clone(),
            poles: poles.cloned().map(Arc::new),
            basis: basis
                .map(|(poles, way)| Basis::new(poles, way, options))
                .transpose()?,
            reading: BTreeMap::new(),
        })
    }

    /// The first pass, and with the poles of a `pilot` (those of a part of the data) the
    /// products of the second as well: where the whole sketch shows the same poles, one
    /// pass is enough.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn with_pilot(options: &FitOptions, pilot: &Poles) -> Result<Self, PieceError> {
        let pilot = Poles {
            pass: Pass::Pilot,
            weighting: None,
            ..pilot.clone()
        };
        Self::new(options, Some(&pilot))
    }

    /// The pass that left `partial`, to go on with it.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of(options: &FitOptions, partial: &Partial) -> Result<Self, PieceError> {
        Self::new(options, partial.poles.as_deref())
    }

    /// The options that the data are read with, by name: what was reduced with others is
    /// refused where both meet.
    #[must_use]
    pub fn with_reading(mut self, reading: BTreeMap<String, String>) -> Self {
        self.reading = reading;
        self
    }

    /// True for a pass after the first.
    pub fn is_second(&self) -> bool {
        self.pass().is_some_and(|pass| pass != Pass::Pilot)
    }

    fn pass(&self) -> Option<Pass> {
        self.poles.as_ref().map(|poles| poles.pass)
    }

    /// Reduces the FRFs of one block.
    ///
    /// * `number`: of the block, its own
    /// * `sources`: the files that it came from
    ///
    /// # Errors
    /// [`FitError`]: unknown kind, a band outside the data, no FRF with values, a window
    /// of records whose length the lines do not tell; data that differ from those the poles were found on.
    pub fn block(
        &self,
        frf: &FrfSet,
        number: u64,
        sources: Vec<Source>,
    ) -> Result<Partial, PieceError> {
        let plan = Plan {
            reading: self.reading.clone(),
            ..Plan::new(frf, &with_set(frf, &self.options))?
        };
        if let Some(poles) = &self.poles {
            poles.plan.same(&plan, &format!("block {number}"))?;
        }
        let weighting = self
            .poles
            .as_ref()
            .and_then(|poles| poles.weighting.as_ref())
            .map(|weights| weights.of(&frf.responses, &frf.references));
        let (block, sums) = self.summed(frf, &plan, &weighting)?;
        let labels: HashSet<u64> = frf
            .responses
            .iter()
            .chain(&frf.references)
            .map(|dof| dof.node)
            .collect();
        let block = Block {
            number,
            responses: frf.responses.clone(),
            references: frf.references.clone(),
            nodes: frf
                .geometry
                .nodes
                .iter()
                .filter(|node| labels.contains(&node.label))
                .copied()
                .collect(),
            sources: named(&sources),
            ..block
        };
        Ok(Partial {
            plan,
            poles: self.poles.clone(),
            blocks: vec![block],
            runs: vec![Run {
                first: number,
                length: 1,
                sums,
            }],
        })
    }

    /// The block with the sums of this pass.
    fn summed(
        &self,
        frf: &FrfSet,
        plan: &Plan,
        weighting: &Option<Weighting>,
    ) -> Result<(Block, Sums), PieceError> {
        let products = |energy| -> Option<Result<(Block, ProductSums), PieceError>> {
            Some(second_pass(frf, self.basis.as_ref()?, weighting, energy))
        };
        if self.pass() == Some(Pass::Products) {
            let (block, products) = products(None).unwrap_or_else(|| Err(no_poles()))?;
            let sums = Sums {
                sketch: None,
                products: Some(products),
            };
            return Ok((block, sums));
        }
        let (lines, _) = plan.lines()?;
        let (block, sketch, energy) = first_pass(frf, plan, &lines, weighting)?;
        let all = |basis: &Basis| basis.layout.lines == lines;
        let energy = energy.filter(|_| self.basis.as_ref().is_some_and(all));
        // products only of the very FRFs that are in the sketch
        let both = products(energy).and_then(Result::ok);
        let both = both.filter(|(other, _)| other.pairs == block.pairs);
        let (block, products) = match both {
            Some((with, products)) => {
                let given = block.given;
                (Block { given, ..with }, Some(products))
            }
            None => (block, None),
        };
        let sums = Sums {
            sketch: Some(sketch),
            products,
        };
        Ok((block, sums))
    }
}

/// Reduces the FRFs of one block: see [`Reducer`].
///
/// # Errors
/// As [`Reducer::new`] and [`Reducer::block`].
pub fn reduce(
    frf: &FrfSet,
    options: &FitOptions,
    number: u64,
    sources: Vec<Source>,
    poles: Option<&Poles>,
) -> Result<Partial, PieceError> {
    Reducer::new(options, poles)?.block(frf, number, sources)
}

fn no_poles() -> PieceError {
    Error::bad_data("no poles to make products with")
        .field("poles")
        .found("none")
        .expected("those that a first pass led to")
        .into()
}

/// The sketch; and the sum of squares of each FRF, where none is flawed.
fn first_pass(
    frf: &FrfSet,
    plan: &Plan,
    lines: &[usize],
    weighting: &Option<Weighting>,
) -> Result<(Block, SketchSums, Option<Vec<f64>>), PieceError> {
    let weights = weighting.as_ref().map(|weighting| &weighting.weights);
    let run = |pairs: &[(usize, usize)]| {
        let mixing = mixing(frf, pairs, plan);
        (
            sketch::Sums::new(&frf.values, pairs, lines, &mixing, weights),
            mixing,
        )
    };
    let mut pairs: Vec<(usize, usize)> = frf.all_pairs().collect();
    let (mut sums, mut mixing) = run(&pairs);
    let energy = (!sums.flawed).then(|| std::mem::take(&mut sums.frf_energy));
    if energy.is_none() {
        pairs = Usable::new(frf, lines, true).pairs;
        (sums, mixing) = run(&pairs);
    }
    let bad: Vec<bool> = sums
        .line_energy
        .iter()
        .map(|energy| !energy.is_finite())
        .collect();
    for (k, _) in bad.iter().enumerate().filter(|(_, bad)| **bad) {
        sums.columns.row_mut(k).fill(0.0.into());
        sums.line_energy[k] = 0.0;
    }
    let mut counts = vec![0; mixing.width];
    mixing.column.iter().for_each(|&column| counts[column] += 1);
    let sums = SketchSums {
        columns: Matrix::from(sums.columns),
        counts,
        line_energy: sums.line_energy.to_vec(),
        bad,
    };
    let given = match weighting {
        Some(_) => None,
        None => noise_of_frfs(frf, plan, lines, &sums.bad, &pairs)?,
    };
    let block = Block {
        given,
        ..Block::of_pairs(pairs)
    };
    Ok((block, sums, energy))
}

/// The noise of each FRF as the data tell it on sound lines.
fn noise_of_frfs(
    frf: &FrfSet,
    plan: &Plan,
    lines: &[usize],
    bad: &[bool],
    pairs: &[(usize, usize)],
) -> Result<Option<(NoiseSource, Vec<f64>)>, FitError> {
    let sound = lines.iter().zip(bad).filter(|(_, bad)| !**bad);
    let sound: Vec<usize> = sound.map(|(line, _)| *line).collect();
    if sound.is_empty() || pairs.is_empty() {
        return Ok(None);
    }
    let layout = DataLayout {
        pairs: pairs.into(),
        ..plan.layout(sound, Effort::default())?
    };
    let told = given_noise(&Screened::part(frf, layout));
    Ok(told.map(|(noise, noise_source)| (noise_source, noise)))
}

/// A column and a sign for each FRF that depend on its DOFs and the seed alone, not on
/// the block it lies in.
fn mixing(frf: &FrfSet, pairs: &[(usize, usize)], plan: &Plan) -> Mixing {
    let drawn = |&(i, j): &(usize, usize)| {
        let (response, reference) = (frf.responses[i], frf.references[j]);
        let directions = u64::from(response.direction.code() as u8) << 8
            | u64::from(reference.direction.code() as u8);
        let mut key = [0; 32];
        for (bytes, word) in
            key.chunks_exact_mut(8)
                .zip([plan.seed, response.node, reference.node, directions])
        {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        let mut random = ChaCha8Rng::from_seed(key);
        (
            random.random_range(0..plan.columns),
            if random.random() { 1.0 } else { -1.0 },
        )
    };
    let (column, sign) = pairs.iter().map(drawn).unzip();
    Mixing {
        width: plan.columns,
        column,
        sign,
    }
}
