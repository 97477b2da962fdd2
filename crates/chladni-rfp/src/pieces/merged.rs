//! Merged partials as the source of a fit: what they were made for they answer, the next
//! pass they ask for.

use crate::damping::structural::basis;
use crate::data::columns::Columns;
use crate::data::error::FitError;
use crate::data::layout::DataLayout;
use crate::data::options::FitOptions;
use crate::data::pair_weights::{Giver, PairWeights, Weights};
use crate::data::products::Projected;
use crate::data::screening::{enough, lines_left_out, Screened};
use crate::data::source::{Source, Way};
use crate::pieces::error::PieceError;
use crate::pieces::limits;
use crate::pieces::partial::{sums, Block, Partial, ProductSums, SketchSums, Sums};
use crate::pieces::plan::Plan;
use crate::pieces::poles::{DofWeights, Matrix, Pass, Poles};
use crate::poles::passes::on_all_lines;
use chladni_frf::{Damping, Dof, Error, Finding, Node};
use chladni_linalg::blocked::{blocked_matmul_h, projected};
use chladni_linalg::LinalgError;
use ndarray::{Array1, Array2, ArrayView1, Axis, ShapeBuilder};
use num_complex::Complex64;
use std::collections::{HashMap, HashSet};
use std::ops::Deref;
use std::sync::Arc;

/// The reason that a fit of merged partials does not go on.
#[derive(Debug)]
pub(crate) enum Stop {
    /// For good.
    Error(PieceError),
    /// Until the blocks have been reduced with these.
    Pass(Box<Poles>),
}

impl From<FitError> for Stop {
    fn from(error: FitError) -> Self {
        Self::Error(error.into())
    }
}

impl From<LinalgError> for Stop {
    fn from(error: LinalgError) -> Self {
        Self::Error(error.into())
    }
}

/// Merged partials of all blocks.
#[derive(Debug, Clone)]
pub(crate) struct Merged<'a> {
    head: DataLayout,
    plan: &'a Plan,
    modes: Option<usize>,
    /// In work units, all columns of one noise level: (line, column).
    sketch: Array2<Complex64>,
    /// Energy of each line over all FRFs, in work units.
    energy: Array1<f64>,
    /// Noise energy of each FRF as the data tell it.
    given: Option<(Vec<f64>, Giver)>,
    made: Option<Made<'a>>,
    /// The point where the walk stopped for the pass that these partials are of.
    way: Option<Way>,
}

/// Products, and the poles that they were made with.
#[derive(Debug, Clone)]
struct Made<'a> {
    poles: &'a Poles,
    way: &'a Way,
    products: &'a WholeProducts,
}

impl Deref for Merged<'_> {
    type Target = DataLayout;
    fn deref(&self) -> &DataLayout {
        &self.head
    }
}

/// Sums of a partial, brought into one.
pub(crate) struct Whole {
    pub plan: Plan,
    poles: Option<Arc<Poles>>,
    set: Set,
    sketch: Option<SketchSums>,
    products: Option<WholeProducts>,
}

/// The FRFs of all blocks, row by row.
struct Set {
    responses: Arc<[Dof]>,
    references: Arc<[Dof]>,
    nodes: Arc<[Node]>,
    pairs: Arc<[(usize, usize)]>,
    energy: Arc<[f64]>,
    given: Option<(Giver, Vec<f64>)>,
}

/// Products of all blocks. R₀ stays in pieces: of a million FRFs it must not be in memory
/// twice.
#[derive(Debug)]
struct WholeProducts {
    t: Array2<f64>,
    gram: Array2<f64>,
    /// R₀ of each block, (unknown, FRF).
    r0: Vec<Matrix<f64>>,
    /// Column of R₀ of each FRF, one block after another.
    place: Vec<usize>,
}

impl WholeProducts {
    /// XᵀR₀ of an X.
    fn turned(&self, x: &Array2<f64>) -> Array2<f64> {
        let mut all = Array2::zeros((x.ncols(), self.place.len()).f());
        let mut place = self.place.iter();
        for r0 in &self.r0 {
            let part = blocked_matmul_h(x.view(), r0.view());
            for (values, &column) in part.columns().into_iter().zip(&mut place) {
                all.column_mut(column).assign(&values);
            }
        }
        all
    }
}

impl Whole {
    /// Of all blocks of `partial`.
    ///
    /// # Errors
    /// No block, no sums, an FRF that stands in two.
    pub fn new(partial: Partial) -> Result<Self, Error> {
        let Partial {
            plan,
            poles,
            blocks,
            runs,
        } = partial;
        let (set, order) = whole(&blocks)?;
        let Sums { sketch, products } = sums(runs).ok_or_else(none)?;
        let of_sums = |ProductSums { t, gram }: ProductSums| WholeProducts {
            t: t.array(),
            gram: gram.array(),
            r0: blocks.into_iter().filter_map(|block| block.r0).collect(),
            place: places(&order),
        };
        Ok(Self {
            plan,
            poles,
            set,
            sketch,
            products: products.map(of_sums),
        })
    }
}

fn none() -> Error {
    Error::bad_data("nothing to solve")
        .field("blocks")
        .found("none")
        .expected("at least one")
        .help("reduce a block first")
}

impl<'a> Merged<'a> {
    /// The source that `whole` is.
    ///
    /// # Errors
    /// Too few lines or none with values; a pass over other FRFs than the one before.
    pub fn new(whole: &'a Whole, options: &FitOptions) -> Result<Self, PieceError> {
        let Whole {
            plan,
            poles,
            set,
            sketch,
            products,
        } = whole;
        let asked = poles.as_deref().filter(|poles| !poles.is_of_pilot());
        // the number of modes is settled with the poles
        let modes = asked.map_or(options.modes, |poles| poles.modes);
        let options = &FitOptions {
            modes,
            ..options.clone()
        };
        let source = match (sketch, asked) {
            (Some(sums), asked) => Self::of_sketch(plan, asked, set, sums, options)?,
            (None, Some(poles)) => Self::of_poles(plan, poles, set, options)?,
            (None, None) => return Err(none().into()),
        };
        let made = poles.as_deref().zip(products.as_ref());
        Ok(Self {
            made: made.and_then(|(poles, products)| {
                let way = poles.way.as_ref()?;
                Some(Made {
                    poles,
                    way,
                    products,
                })
            }),
            ..source
        })
    }

    /// The number of modes asked for.
    pub fn modes(&self) -> Option<usize> {
        self.modes
    }

    /// Of a pass that made a sketch; `asked`: what it was run with, where it was not the
    /// first.
    fn of_sketch(
        plan: &'a Plan,
        asked: Option<&Poles>,
        set: &Set,
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
        let good: Vec<usize> = (0..lines.len())
            .filter(|&k| !bad[k] && line_energy[k] > 0.0)
            .collect();
        let used =
            |k: &usize| asked.is_none_or(|poles| poles.lines.binary_search(&lines[*k]).is_ok());
        let kept: Vec<usize> = good.iter().copied().filter(used).collect();
        if kept.is_empty() {
            return Err(FitError::NoData.into());
        }
        enough(kept.len(), band_hz, options.modes)?;
        let used = kept.iter().map(|&k| lines[k]).collect();
        let mut head = with_dofs(plan.head(used, options.effort)?, set);
        match asked {
            Some(poles) => poles.tell(&mut head),
            None if good.len() < lines.len() => {
                head.warnings.push(lines_left_out(lines.len() - good.len()));
            }
            None => {}
        }
        let energy: Array1<f64> = kept.iter().map(|&k| line_energy[k]).collect();
        head.rms = (energy.sum() / (kept.len() * head.pairs.len()) as f64).sqrt();
        let factor = head.factor();
        let filled: Vec<usize> = (0..counts.len()).filter(|&c| counts[c] > 0).collect();
        let sums = columns.array();
        let scaled = |(k, c): (usize, usize)| {
            sums[[kept[k], filled[c]]] * factor / (counts[filled[c]] as f64).sqrt()
        };
        Ok(Self {
            sketch: Array2::from_shape_fn((kept.len(), filled.len()).f(), scaled),
            energy: energy * factor.norm_sqr(),
            given: set.given.clone().map(|(giver, noise)| (noise, giver)),
            head,
            plan,
            modes: options.modes,
            made: None,
            way: None,
        })
    }

    /// Of a pass that made products alone.
    fn of_poles(
        plan: &'a Plan,
        poles: &Poles,
        set: &Set,
        options: &FitOptions,
    ) -> Result<Self, PieceError> {
        let mut head = with_dofs(poles.head(options.effort)?, set);
        poles.tell(&mut head);
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
        Ok(Self {
            head,
            plan,
            modes: poles.modes,
            sketch: poles.sketch.array(),
            energy: Array1::from(poles.line_energy.clone()),
            given: None,
            made: None,
            way: poles.way.clone(),
        })
    }

    /// A pass that others must make.
    fn asked(&self, pass: Pass, way: Option<Way>) -> Poles {
        let sketch = match pass {
            Pass::Anew => Array2::zeros((self.lines.len(), 0)),
            Pass::Products | Pass::Pilot => self.sketch.clone(),
        };
        let weighting = self.head.weighting.as_ref();
        Poles {
            plan: self.plan.clone(),
            pass,
            lines: self.lines.clone(),
            rms: self.rms,
            line_energy: self.energy.to_vec(),
            sketch: Matrix::from(sketch),
            frfs: self.pairs.len(),
            modes: self.modes,
            weighting: weighting.map(|weighting| {
                let rms = weighting.rms;
                DofWeights::new(self, &weighting.weights, weighting.giver, rms)
            }),
            weights_left: self.weights_left,
            dropped_hz: self.dropped_hz.clone(),
            outlier_rounds: self.outlier_rounds,
            warnings: self.warnings.clone(),
            way,
        }
    }

    /// True where the products at hand compress the data for the poles of `way` as well:
    /// on the same lines, as many poles, each within their basis but for a small share.
    /// The part outside costs a share of the information, and no bias: compressed columns
    /// are mixtures of whole FRFs, and the basis only says how they are mixed.
    fn serves(&self, made: &Made, way: &Way) -> Result<bool, LinalgError> {
        if made.poles.lines != self.lines || made.way.lambda.len() != way.lambda.len() {
            return Ok(false);
        }
        if made.way == way {
            return Ok(true);
        }
        let columns = basis(&self.axis().in_law(way.law), &way.lambda, &[]);
        let in_law = self.in_law(made.way.law);
        let q = on_all_lines(&in_law, &made.way.lambda)?;
        let (_, outside) = projected(q.view(), columns.view());
        let energy = |column: ArrayView1<Complex64>| {
            column.iter().map(|value| value.norm_sqr()).sum::<f64>()
        };
        Ok(outside
            .columns()
            .into_iter()
            .zip(columns.columns())
            .all(|(outside, all)| energy(outside) < limits::PILOT_SHARE * energy(all)))
    }
}

impl Source for Merged<'_> {
    type Stop = Stop;

    fn sketch(&self, _: u64) -> (Columns, Array1<f64>) {
        let work = self.axis().with_columns(self.sketch.clone());
        (work, self.energy.clone())
    }

    fn projected(
        &self,
        way: &Way,
        _: &Array2<Complex64>,
        energy: &Array1<f64>,
    ) -> Result<Projected, Stop> {
        if let Some(made) = &self.made {
            if self.serves(made, way)? {
                let WholeProducts { t, gram, .. } = made.products;
                let turned = |x: &Array2<f64>| made.products.turned(x);
                return Ok(Projected::new(&self.head, [t, gram], turned, energy)?);
            }
        }
        Err(Stop::Pass(Box::new(
            self.asked(Pass::Products, Some(way.clone())),
        )))
    }

    fn way(&self) -> Option<&Way> {
        self.way.as_ref()
    }

    fn without(&self, places: &[usize]) -> Self {
        let (head, kept) = self.head.without(places);
        Self {
            head,
            sketch: self.sketch.select(Axis(0), &kept),
            energy: self.energy.select(Axis(0), &kept),
            way: None,
            ..self.clone()
        }
    }

    fn in_law(&self, law: Damping) -> Self {
        let mut other = self.clone();
        other.head.law = law;
        other
    }

    fn given_noise(&self) -> Option<(Vec<f64>, Giver)> {
        self.given.clone()
    }

    fn weighted(
        &self,
        weights: Option<(PairWeights, Option<Giver>)>,
        left: Weights,
    ) -> Result<Self, Stop> {
        let mut other = self.clone();
        other.head.weights_left = left;
        if weights.is_none() && self.weighting.is_none() {
            return Ok(other);
        }
        let mut asked = other.asked(Pass::Anew, self.made.as_ref().map(|made| made.way.clone()));
        asked.weighting = weights
            .map(|(weights, giver)| DofWeights::new(self, &weights, giver, self.measured_rms()));
        Err(Stop::Pass(Box::new(asked)))
    }

    fn noted(&self, finding: Option<Finding>) -> Self {
        let mut other = self.clone();
        other.head.warnings.extend(finding);
        other
    }

    fn values(&self) -> Option<&Screened<'_>> {
        None
    }
}

/// The head of all FRFs.
fn with_dofs(head: DataLayout, set: &Set) -> DataLayout {
    DataLayout {
        responses: set.responses.clone(),
        references: set.references.clone(),
        nodes: set.nodes.clone(),
        pairs: set.pairs.clone(),
        energy: set.energy.clone(),
        ..head
    }
}

/// DOFs and FRFs of all blocks, row by row; for each FRF its place among those of the
/// blocks one after another.
fn whole(blocks: &[Block]) -> Result<(Set, Vec<usize>), Error> {
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
    let mut given: Option<(Giver, Vec<f64>)> = None;
    for block in blocks {
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
        if let Some((giver, noise)) = &block.given {
            let all = given.get_or_insert((*giver, Vec::new()));
            all.1.extend(noise.iter().filter(|_| all.0 == *giver));
        }
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
    let set = Set {
        responses: responses.0.into(),
        references: references.0.into(),
        nodes: nodes.into(),
        pairs: order.iter().map(|&l| pairs[l]).collect(),
        // without products of every block there are no energies of every FRF
        energy: in_turn(&energy, &order).unwrap_or_default().into(),
        given: given.and_then(|(giver, noise)| Some((giver, in_turn(&noise, &order)?))),
    };
    Ok((set, order))
}

/// Values of all FRFs in this order; `None` where some have none.
fn in_turn(values: &[f64], order: &[usize]) -> Option<Vec<f64>> {
    (values.len() == order.len()).then(|| order.iter().map(|&l| values[l]).collect())
}

/// For each FRF its place in this order.
fn places(order: &[usize]) -> Vec<usize> {
    let mut places = vec![0; order.len()];
    for (place, &l) in order.iter().enumerate() {
        places[l] = place;
    }
    places
}
