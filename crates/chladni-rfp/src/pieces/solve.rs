//! Poles of a merged sketch; the fit of merged products.

use crate::checks::examine::examine;
use crate::damping::structural::basis;
use crate::damping::structural::POWERS;
use crate::data::columns::Columns;
use crate::data::error::FitError;
use crate::data::layout::DataLayout;
use crate::data::options::FitOptions;
use crate::data::outliers;
use crate::data::pair_weights::PairWeights;
use crate::data::products::{Products, Projected};
use crate::data::screening::{enough, lines_left_out};
use crate::driver::{conjugated, finished, from_chain, Fit, OUTLIER_ROUNDS};
use crate::measured::path::{on_columns, strongest};
use crate::model::exponential;
use crate::model::in_law::in_law;
use crate::pieces::error::PieceError;
use crate::pieces::partial::{Block, Partial, ProductSums, SketchSums, Sums};
use crate::pieces::plan::Plan;
use crate::pieces::poles::{Matrix, Path, Poles};
use crate::poles::chain::{of_columns, of_sketch, Chain, Doubt, First, Outcome};
use crate::poles::estimate::PoleEstimate;
use crate::poles::passes::{on_all_lines, same, Pass};
use crate::poles::refine::refine;
use crate::tolerances as tol;
use chladni_frf::{Dof, Error, Finding, Node};
use chladni_linalg::blocked::{in_pool, projected};
use chladni_linalg::LinalgError;
use ndarray::{Array1, Array2, ArrayView1, Axis, ShapeBuilder};
use num_complex::Complex64;
use std::collections::{HashMap, HashSet};

/// What merged partials lead to.
#[derive(Debug, Clone)]
pub enum Solved {
    /// Poles to reduce every block with: of a sketch; or anew, where the second pass
    /// showed that those it was run with do not do.
    Poles(Box<Poles>),
    /// The fit.
    Fit(Box<Fit>),
}

/// Most times that poles are sought.
const ROUNDS: usize = 3;

/// Solves merged partials: those of a first pass for poles, those of a second for the
/// fit; those of a first pass with a pilot for the fit where the pilot's poles will do.
///
/// `progress` is told the name of each stage as it begins. Of `options` a first pass
/// needs `modes`, a second `damping`, `shapes` and `exponential_window_per_s`.
///
/// # Errors
/// [`FitError`] as for [`crate::fit()`]; no block, no sums, an FRF that stands in two, a
/// second pass over other FRFs than the first.
pub fn solve(
    partial: &Partial,
    options: &FitOptions,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Solved, PieceError> {
    in_pool(|| solve_here(partial, options, progress))
}

fn solve_here(
    partial: &Partial,
    options: &FitOptions,
    progress: &dyn Fn(&str),
) -> Result<Solved, PieceError> {
    let none = || {
        Error::bad_data("nothing to solve")
            .field("blocks")
            .found("none")
            .expected("at least one")
            .help("reduce a block first")
    };
    let (set, order) = whole(partial)?;
    let Sums { sketch, products } = partial.sums().ok_or_else(none)?;
    let poles = match (sketch, partial.poles.as_deref()) {
        (Some(sums), pilot) => {
            let sketch = Sketch::of_sums(&partial.plan, set.clone(), &sums, options)?;
            let found = sketch.poles(&partial.plan, options.modes, 0, progress)?;
            if products.is_none()
                || !pilot.map_or(Ok(false), |pilot| serves(pilot, &found, options))?
            {
                return Ok(Solved::Poles(Box::new(found)));
            }
            found
        }
        (None, Some(poles)) => poles.clone(),
        (None, None) => return Err(none().into()),
    };
    let Some(ProductSums { t, gram }) = products else {
        return Err(none().into());
    };
    let head = with_dofs(poles.head(options.effort)?, set);
    let r0 = in_order(&partial.blocks, gram.rows, &order);
    // the number of modes was settled with the poles
    let options = &FitOptions {
        modes: poles.modes,
        ..options.clone()
    };
    of_products(
        &poles,
        head,
        Products {
            t: t.array(),
            gram: gram.array(),
            r0,
        },
        options,
        progress,
    )
}

/// True where products with the basis of the `pilot` compress the data for the poles
/// `found` as well: on the same lines, as many poles, each within that basis but for a
/// small share. What lies outside costs a share of the information, and no bias:
/// compressed columns are mixtures of whole FRFs, and the basis only says how they are
/// mixed.
fn serves(pilot: &Poles, found: &Poles, options: &FitOptions) -> Result<bool, PieceError> {
    if pilot.lines != found.lines || pilot.lambda.len() != found.lambda.len() {
        return Ok(false);
    }
    let head = found.head(options.effort)?;
    let columns = basis(&head.axis(), &found.lambda, &[]);
    let (_, outside) = projected(on_all_lines(&head, &pilot.lambda)?.view(), columns.view());
    let energy =
        |column: ArrayView1<Complex64>| column.iter().map(|value| value.norm_sqr()).sum::<f64>();
    Ok(outside
        .columns()
        .into_iter()
        .zip(columns.columns())
        .all(|(outside, all)| energy(outside) < tol::PILOT_SHARE * energy(all)))
}

/// DOFs and FRFs of all blocks, row by row; for each FRF its place among those of the
/// blocks one after another.
fn whole(partial: &Partial) -> Result<(Block, Vec<usize>), Error> {
    fn place(all: &mut Vec<Dof>, known: &mut HashMap<Dof, usize>, dof: Dof) -> usize {
        *known.entry(dof).or_insert_with(|| {
            all.push(dof);
            all.len() - 1
        })
    }
    let (mut responses, mut references) =
        ((Vec::new(), HashMap::new()), (Vec::new(), HashMap::new()));
    let mut nodes: Vec<Node> = Vec::new();
    let mut labels = HashSet::new();
    let (mut pairs, mut energy) = (Vec::new(), Vec::new());
    for block in &partial.blocks {
        let rows: Vec<usize> = block
            .responses
            .iter()
            .map(|&dof| place(&mut responses.0, &mut responses.1, dof))
            .collect();
        let columns: Vec<usize> = block
            .references
            .iter()
            .map(|&dof| place(&mut references.0, &mut references.1, dof))
            .collect();
        pairs.extend(block.pairs.iter().map(|&(i, j)| (rows[i], columns[j])));
        energy.extend(&block.energy);
        nodes.extend(block.nodes.iter().filter(|node| labels.insert(node.label)));
    }
    let mut order: Vec<usize> = (0..pairs.len()).collect();
    order.sort_by_key(|&l| pairs[l]);
    if let Some(twice) = order.windows(2).find(|two| pairs[two[0]] == pairs[two[1]]) {
        let (i, j) = pairs[twice[0]];
        return Err(Error::bad_data("an FRF stands in two blocks")
            .field("response and reference")
            .found(format!("{} from {}", responses.0[i], references.0[j]))
            .expected("every FRF once")
            .help("cut the data into blocks that share no FRF"));
    }
    let set = Block {
        number: 0,
        piece: 0,
        responses: responses.0,
        references: references.0,
        nodes,
        pairs: order.iter().map(|&l| pairs[l]).collect(),
        // without products of every block there are no energies of every FRF
        energy: if energy.len() == order.len() {
            order.iter().map(|&l| energy[l]).collect()
        } else {
            Vec::new()
        },
        r0: None,
        sources: Vec::new(),
    };
    Ok((set, order))
}

/// R₀ of all blocks, its columns in this order.
fn in_order(blocks: &[Block], unknowns: usize, order: &[usize]) -> Array2<f64> {
    let columns: Vec<&[f64]> = blocks
        .iter()
        .filter_map(|block| block.r0.as_ref())
        .flat_map(|r0| r0.values.chunks_exact(unknowns.max(1)))
        .collect();
    let mut r0 = Array2::zeros((unknowns, order.len()).f());
    for (mut out, &l) in r0.columns_mut().into_iter().zip(order) {
        out.iter_mut()
            .zip(columns[l])
            .for_each(|(out, value)| *out = *value);
    }
    r0
}

/// The head of all FRFs.
fn with_dofs(head: DataLayout, set: Block) -> DataLayout {
    let Block {
        responses,
        references,
        nodes,
        pairs,
        energy,
        ..
    } = set;
    DataLayout {
        responses,
        references,
        nodes,
        pairs,
        energy,
        ..head
    }
}

/// A merged sketch.
struct Sketch {
    head: DataLayout,
    /// In work units, all columns of one noise level.
    work: Columns,
    /// Energy of each line over all FRFs.
    energy: Array1<f64>,
    /// Outlier lines left out, Hz.
    dropped_hz: Vec<f64>,
}

impl Sketch {
    fn of_sums(
        plan: &Plan,
        set: Block,
        sums: &SketchSums,
        options: &FitOptions,
    ) -> Result<Self, PieceError> {
        let SketchSums {
            columns,
            counts,
            line_energy,
            bad,
        } = sums;
        let (lines, band_hz) = plan.lines()?;
        let kept: Vec<usize> = (0..lines.len())
            .filter(|&k| !bad[k] && line_energy[k] > 0.0)
            .collect();
        if kept.is_empty() {
            return Err(FitError::NoData.into());
        }
        enough(kept.len(), band_hz, options.modes)?;
        let mut head = with_dofs(
            plan.head(kept.iter().map(|&k| lines[k]).collect(), options.effort)?,
            set,
        );
        let energy: Array1<f64> = kept.iter().map(|&k| line_energy[k]).collect();
        head.rms = (energy.sum() / (kept.len() * head.pairs.len()) as f64).sqrt();
        let factor = head.factor();
        let filled: Vec<usize> = (0..counts.len()).filter(|&c| counts[c] > 0).collect();
        let sums = columns.array();
        let scaled = |(k, c): (usize, usize)| {
            sums[[kept[k], filled[c]]] * factor / (counts[filled[c]] as f64).sqrt()
        };
        let b = Array2::from_shape_fn((kept.len(), filled.len()).f(), scaled);
        Ok(Self {
            work: Columns { b, ..head.axis() },
            energy: energy * factor.norm_sqr(),
            head,
            dropped_hz: Vec::new(),
        })
    }

    /// The sketch that poles were found on.
    fn of_poles(poles: &Poles, head: DataLayout) -> Self {
        let work = Columns {
            b: poles.sketch.array(),
            ..head.axis()
        };
        Self {
            work,
            energy: Array1::from(poles.line_energy.clone()),
            head,
            dropped_hz: poles.dropped_hz.clone(),
        }
    }

    fn without(self, places: &[usize]) -> Self {
        let kept: Vec<usize> = (0..self.work.lines())
            .filter(|place| !places.contains(place))
            .collect();
        let mut dropped_hz = self.dropped_hz;
        dropped_hz.extend(places.iter().map(|&place| self.head.line_hz[place]));
        Self {
            head: self.head.select(&kept),
            work: self.work.select(&kept),
            energy: self.energy.select(Axis(0), &kept),
            dropped_hz,
        }
    }

    /// Poles by the fast chain, or by the measured-data path where its residual is not
    /// white.
    fn poles(
        mut self,
        plan: &Plan,
        modes: Option<usize>,
        rounds: usize,
        progress: &dyn Fn(&str),
    ) -> Result<Poles, LinalgError> {
        for left in (0..=OUTLIER_ROUNDS).rev() {
            match of_sketch(&self.head, self.work.clone(), plan.seed, modes, progress)? {
                First::Poles(found) => {
                    return Ok(self.found(
                        plan,
                        modes,
                        rounds,
                        found.refined.lambda,
                        Path::Fast {
                            history: found.history,
                        },
                    ))
                }
                First::Ended(Doubt::Outliers(places)) if left > 0 => self = self.without(&places),
                First::Ended(Doubt::Conjugated) => {
                    return Ok(self.found(plan, modes, rounds, Vec::new(), Path::Conjugated))
                }
                First::Ended(doubt) => {
                    return self.measured(plan, modes, rounds, &doubt.words(), progress)
                }
            }
        }
        unreachable!("the last round ends")
    }

    /// Poles by the measured-data path.
    fn measured(
        self,
        plan: &Plan,
        modes: Option<usize>,
        rounds: usize,
        evidence: &str,
        progress: &dyn Fn(&str),
    ) -> Result<Poles, LinalgError> {
        let found = on_columns(&self.head, strongest(&self.work)?, None, modes, progress)?;
        let path = Path::Measured {
            evidence: evidence.into(),
            spread: found.variance,
            grades: found.grades,
            warnings: found.warnings,
        };
        Ok(self.found(plan, modes, rounds, found.refined.lambda, path))
    }

    fn found(
        self,
        plan: &Plan,
        modes: Option<usize>,
        rounds: usize,
        lambda: Vec<Complex64>,
        path: Path,
    ) -> Poles {
        Poles {
            plan: plan.clone(),
            lines: self.head.lines,
            lambda,
            rms: self.head.rms,
            line_energy: self.energy.to_vec(),
            sketch: Matrix::from(self.work.b.clone()),
            frfs: self.head.pairs.len(),
            modes,
            dropped_hz: self.dropped_hz,
            rounds: rounds + 1,
            path,
        }
    }
}

/// The fit; or poles anew, where these do not do.
fn of_products(
    poles: &Poles,
    mut head: DataLayout,
    products: Products,
    options: &FitOptions,
    progress: &dyn Fn(&str),
) -> Result<Solved, PieceError> {
    if head.pairs.len() != poles.frfs {
        return Err(
            Error::bad_data("the second pass was not run over the FRFs of the first")
                .field("number of FRFs")
                .found(head.pairs.len())
                .expected(format!(
                    "{}, as many as the poles were found on",
                    poles.frfs
                ))
                .help("reduce every block again with the poles, and merge all of them")
                .into(),
        );
    }
    let (lines, _) = poles.plan.lines()?;
    let silent = lines.len() - poles.lines.len() - poles.dropped_hz.len();
    if silent > 0 {
        head.warnings.push(lines_left_out(silent));
    }
    let energy = Array1::from(poles.line_energy.clone());
    progress("projection");
    let projected = Projected::new(&head, products, &energy)?;
    let (found, history) = match &poles.path {
        Path::Conjugated => (conjugated(projected)?, Vec::new()),
        Path::Measured {
            evidence,
            spread,
            grades,
            warnings,
        } => {
            let refined = refine(&projected.work, &poles.lambda, &POWERS, 0, 0.0)?;
            let found = PoleEstimate {
                variance: refined.variance(&projected.work),
                refined,
                work: projected.work,
                back: Some(projected.back),
                spread: spread.clone(),
                measured: true,
                grades: grades.clone(),
                path: format!("measured-data path: {evidence}"),
                warnings: warnings.clone(),
                consistent: true,
            };
            (found, Vec::new())
        }
        Path::Fast { history } => {
            match settled(poles, &head, projected, &energy, history.clone(), progress)? {
                Settled::Chain(chain) => {
                    let history = chain.history.clone();
                    (from_chain(*chain, poles.modes, head.hz()), history)
                }
                Settled::Again(poles) => return Ok(Solved::Poles(poles)),
            }
        }
    };
    let white = !found.measured;
    let again = |found: PoleEstimate, law| {
        let frfs = (!found.measured).then_some(head.pairs.len());
        in_law(found, law, frfs)
    };
    let (mut model, left) = finished(&head, found, options, progress, again, |shaped| {
        shaped.left_by_sums(&head)
    })?;
    if let Some(weights) =
        PairWeights::new(&head, &left, model.quality.relative_error).filter(|_| white)
    {
        let words = weights.spread_in_words();
        model.quality.findings.push(
            Finding::note(
                "weights-refused",
                format!("noise {words}, and a fit in pieces weighs all FRFs alike"),
            )
            .help("fit the whole set in memory"),
        );
    }
    if !poles.dropped_hz.is_empty() {
        model
            .quality
            .findings
            .push(outliers::words(&head, &mut poles.dropped_hz.clone()));
    }
    examine(&head, None, options, white, &mut model);
    model.quality.findings.push(unchecked());
    if let Some(alpha) = options.exponential_window_per_s {
        exponential::undo(&mut model, alpha);
    }
    Ok(Solved::Fit(Box::new(Fit {
        model,
        history,
        stabilization: None,
    })))
}

/// The checks that no fit in pieces can make.
fn unchecked() -> Finding {
    Finding::note(
        "not-checked",
        "fitted in pieces: whether poles move between FRFs, a reference is delayed or not \
         reciprocal, or a window broadens the lines was not looked at",
    )
    .help("fit some blocks by themselves to see")
}

/// What the products come to.
enum Settled {
    Chain(Box<Chain>),
    Again(Box<Poles>),
}

/// The fast chain from the second pass on. Where it shows a mode, or spoilt lines, that
/// the sketch did not, or no white residual, poles are sought again.
fn settled(
    poles: &Poles,
    head: &DataLayout,
    projected: Projected,
    energy: &Array1<f64>,
    mut history: Vec<(usize, f64)>,
    progress: &dyn Fn(&str),
) -> Result<Settled, LinalgError> {
    let (plan, modes, rounds) = (&poles.plan, poles.modes, poles.rounds);
    let sketch = || Sketch::of_poles(poles, head.clone());
    let pass = Pass::of(head, projected, &poles.lambda, &mut history)?;
    if let Some(pole) = pass
        .stands_out(head)
        .filter(|_| modes.is_none() && rounds < ROUNDS)
    {
        let more: Vec<Complex64> = pass.refined.lambda.iter().copied().chain([pole]).collect();
        let sketch = sketch();
        let more = refine(
            &sketch.work,
            &more,
            &POWERS,
            tol::REFINE_ROUGH,
            tol::ROUGH_STEP,
        )?
        .lambda;
        if !same(&more, &poles.lambda) {
            return Ok(Settled::Again(Box::new(sketch.found(
                plan,
                modes,
                rounds,
                more,
                Path::Fast { history },
            ))));
        }
    }
    let again = match of_columns(head, pass, energy, modes, history)? {
        Outcome::White(chain) => return Ok(Settled::Chain(chain)),
        Outcome::Ended(Doubt::Outliers(places)) if rounds < ROUNDS => sketch()
            .without(&places)
            .poles(plan, modes, rounds, progress)?,
        Outcome::Ended(doubt) => {
            sketch().measured(plan, modes, rounds, &doubt.words(), progress)?
        }
    };
    Ok(Settled::Again(Box::new(again)))
}
