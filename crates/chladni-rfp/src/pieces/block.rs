//! One block of FRFs, reduced.

use crate::data::error::FitError;
use crate::data::layout::DataLayout;
use crate::data::options::FitOptions;
use crate::data::products::{measured_basis, products};
use crate::data::reading::{squares_of, Usable};
use crate::data::screening::Screened;
use crate::data::sketch::{self, Mixing};
use crate::data::window;
use crate::pieces::error::PieceError;
use crate::pieces::partial::{Block, Partial, ProductSums, Run, SketchSums, Sums};
use crate::pieces::plan::Plan;
use crate::pieces::poles::{Matrix, Poles};
use crate::poles::passes::on_all_lines;
use chladni_frf::{Error, FrfSet, Source};
use ndarray::{Array2, Axis};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

/// A pass over blocks, with what all of them need.
#[derive(Debug)]
pub struct Reducer {
    options: FitOptions,
    /// Of the products.
    basis: Option<Basis>,
    pass: Pass,
    reading: BTreeMap<String, String>,
}

/// What a pass leaves.
#[derive(Debug, PartialEq)]
enum Pass {
    /// A sketch, and the products too where there is a basis and nothing is missing.
    First,
    /// The products.
    Second,
}

/// What products are made with.
#[derive(Debug)]
struct Basis {
    poles: Arc<Poles>,
    head: DataLayout,
    /// Orthonormal on the lines used, as it meets measured values: (real and imaginary
    /// part of each line, unknown).
    measured: Array2<f64>,
}

impl Basis {
    fn new(poles: &Poles, options: &FitOptions) -> Result<Self, PieceError> {
        let head = poles.head(options.effort)?;
        let measured = measured_basis(&head, &on_all_lines(&head, &poles.lambda)?);
        Ok(Self {
            poles: Arc::new(poles.clone()),
            measured,
            head,
        })
    }
}

impl Reducer {
    /// Without `poles` the first pass, with them the second.
    ///
    /// # Errors
    /// Poles of an axis without lines in their band.
    pub fn new(options: &FitOptions, poles: Option<&Poles>) -> Result<Self, PieceError> {
        let pass = if poles.is_some() {
            Pass::Second
        } else {
            Pass::First
        };
        Ok(Self {
            options: options.clone(),
            basis: poles.map(|poles| Basis::new(poles, options)).transpose()?,
            pass,
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
        Ok(Self {
            options: options.clone(),
            basis: Some(Basis::new(pilot, options)?),
            pass: Pass::First,
            reading: BTreeMap::new(),
        })
    }

    /// The pass that left `partial`, to go on with it.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn of(options: &FitOptions, partial: &Partial) -> Result<Self, PieceError> {
        match partial.pilot() {
            Some(pilot) => Self::with_pilot(options, pilot),
            None => Self::new(options, partial.poles()),
        }
    }

    /// The options that the data are read with, by name: what was reduced with others is
    /// refused where both meet.
    #[must_use]
    pub fn with_reading(mut self, reading: BTreeMap<String, String>) -> Self {
        self.reading = reading;
        self
    }

    /// True for the second pass.
    pub fn is_second(&self) -> bool {
        self.pass == Pass::Second
    }

    /// Reduces the FRFs of one block.
    ///
    /// * `number`: of the block, its own
    /// * `sources`: the files that it came from
    ///
    /// # Errors
    /// [`FitError`]: unknown kind, a band outside the data, no FRF with values, a window
    /// that cannot be undone; data that differ from those the poles were found on.
    pub fn block(
        &self,
        frf: &FrfSet,
        number: u64,
        sources: Vec<Source>,
    ) -> Result<Partial, PieceError> {
        let plan = Plan {
            reading: self.reading.clone(),
            ..Plan::new(frf, &self.options)?
        };
        let unbiased = self
            .options
            .window
            .map_or(Ok(None), |window| window::undo(frf, window))?;
        let frf = unbiased.as_ref().unwrap_or(frf);
        if let Some(basis) = &self.basis {
            basis.poles.plan.same(&plan, &format!("block {number}"))?;
        }
        let (block, sums) = match (&self.basis, &self.pass) {
            (Some(basis), Pass::Second) => {
                let (block, products) = second_pass(frf, basis, None)?;
                (
                    block,
                    Sums {
                        sketch: None,
                        products: Some(products),
                    },
                )
            }
            (basis, _) => {
                let (lines, _) = plan.lines()?;
                let (block, sketch, energy) = first_pass(frf, &plan, &lines)?;
                let known = |basis: &Basis| energy.filter(|_| basis.head.lines == lines);
                let both = basis
                    .as_ref()
                    .and_then(|basis| second_pass(frf, basis, known(basis)).ok());
                match both.filter(|(other, _)| other.pairs == block.pairs) {
                    Some((block, products)) => (
                        block,
                        Sums {
                            sketch: Some(sketch),
                            products: Some(products),
                        },
                    ),
                    None => (
                        block,
                        Sums {
                            sketch: Some(sketch),
                            products: None,
                        },
                    ),
                }
            }
        };
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
            sources,
            ..block
        };
        let poles = self.basis.as_ref().map(|basis| basis.poles.clone());
        Ok(Partial {
            plan,
            poles,
            blocks: vec![block],
            runs: vec![Run {
                first: number,
                length: 1,
                sums,
            }],
        })
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

/// A block of which only the FRFs are known yet.
fn of_pairs(pairs: Vec<(usize, usize)>) -> Block {
    Block {
        number: 0,
        piece: 0,
        responses: Vec::new(),
        references: Vec::new(),
        nodes: Vec::new(),
        pairs,
        energy: Vec::new(),
        r0: None,
        sources: Vec::new(),
    }
}

/// The sketch; and the sum of squares of each FRF, where none is flawed.
fn first_pass(
    frf: &FrfSet,
    plan: &Plan,
    lines: &[usize],
) -> Result<(Block, SketchSums, Option<Vec<f64>>), PieceError> {
    let run = |pairs: &[(usize, usize)]| {
        let mixing = mixing(frf, pairs, plan);
        (
            sketch::Sums::new(&frf.values, pairs, lines, &mixing),
            mixing,
        )
    };
    let mut pairs: Vec<(usize, usize)> = frf.all_pairs().collect();
    let (mut sums, mut mixing) = run(&pairs);
    let energy = (!sums.flawed).then(|| std::mem::take(&mut sums.frf_energy));
    if energy.is_none() {
        pairs = Usable::new(frf, lines).pairs;
        if pairs.is_empty() {
            return Err(FitError::NoData.into());
        }
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
    Ok((of_pairs(pairs), sums, energy))
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

/// The products. `energy`: sum of squares of each FRF, where it is known.
fn second_pass(
    frf: &FrfSet,
    basis: &Basis,
    energy: Option<Vec<f64>>,
) -> Result<(Block, ProductSums), PieceError> {
    let head = &basis.head;
    // on the lines used, an FRF is there or it is not
    let is_finite = |(i, j): (usize, usize), k: usize| frf.values.get(i, j, k).is_finite();
    let (mut pairs, missing): (Vec<_>, Vec<_>) = frf
        .all_pairs()
        .partition(|&pair| is_finite(pair, head.lines[0]));
    let mut made = products(
        &Screened::part(
            frf,
            DataLayout {
                pairs: pairs.clone(),
                ..head.clone()
            },
        ),
        &basis.measured,
    );
    let mut energy = energy
        .filter(|energy| energy.len() == pairs.len())
        .unwrap_or_else(|| {
            pairs
                .par_iter()
                .map(|&pair| squares_of(&frf.values, pair, &head.lines))
                .collect()
        });
    let broken = pairs
        .iter()
        .zip(&energy)
        .find(|(_, energy)| !energy.is_finite())
        .map(|(&pair, _)| pair);
    let partly = || {
        missing.iter().copied().find(|&pair| {
            head.lines
                .iter()
                .any(|&k| is_finite(pair, k) && frf.values.get(pair.0, pair.1, k).norm() > 0.0)
        })
    };
    if let Some((i, j)) = broken.or_else(partly) {
        let line = head
            .lines
            .iter()
            .position(|&k| !is_finite((i, j), k))
            .map_or(f64::NAN, |k| head.line_hz[k]);
        return Err(Error::bad_data(
            "a value that is not finite, where all were finite when the poles were found",
        )
        .field(format!(
            "FRF {} from {} at {line} Hz",
            frf.responses[i], frf.references[j]
        ))
        .found("NaN or infinity")
        .expected("the data that the first pass was run on")
        .help("run both passes over the same data")
        .into());
    }
    // FRFs of zeros add nothing to the products; the first pass has left them out
    let used: Vec<usize> = (0..pairs.len()).filter(|&l| energy[l] > 0.0).collect();
    if used.is_empty() {
        return Err(FitError::NoData.into());
    }
    if used.len() < pairs.len() {
        pairs = used.iter().map(|&l| pairs[l]).collect();
        energy = used.iter().map(|&l| energy[l]).collect();
        made.r0 = made.r0.select(Axis(1), &used);
    }
    let block = Block {
        energy,
        r0: Some(Matrix::from(made.r0)),
        ..of_pairs(pairs)
    };
    Ok((
        block,
        ProductSums {
            t: Matrix::from(made.t),
            gram: Matrix::from(made.gram),
        },
    ))
}
