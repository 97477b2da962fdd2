//! All blocks of a partial brought into one: their FRFs row by row, sketch and products.

use crate::data::pair_weights::NoiseSource;
use crate::pieces::partial::{sums, Block, Partial, ProductSums, SketchSums, Sums};
use crate::pieces::plan::Plan;
use crate::pieces::poles::{Matrix, Poles};
use chladni_frf::{Dof, Error, Node};
use chladni_linalg::blocked::blocked_matmul_h;
use ndarray::{Array2, ShapeBuilder};
use std::collections::{HashMap, HashSet};
use std::sync::Arc;

/// Sums of a partial, brought into one.
pub(crate) struct Whole {
    pub plan: Plan,
    pub(super) poles: Option<Arc<Poles>>,
    pub(super) set: Set,
    pub(super) sketch: Option<SketchSums>,
    pub(super) products: Option<WholeProducts>,
}

/// The FRFs of all blocks, row by row.
pub(super) struct Set {
    pub responses: Arc<[Dof]>,
    pub references: Arc<[Dof]>,
    pub nodes: Arc<[Node]>,
    pub pairs: Arc<[(usize, usize)]>,
    pub energy: Arc<[f64]>,
    pub given: Option<(NoiseSource, Vec<f64>)>,
}

/// Products of all blocks. R₀ stays in pieces: of a million FRFs it must not be in memory
/// twice.
#[derive(Debug)]
pub(super) struct WholeProducts {
    pub t: Array2<f64>,
    pub gram: Array2<f64>,
    /// R₀ of each block, (unknown, FRF).
    r0: Vec<Matrix<f64>>,
    /// Column of R₀ of each FRF, one block after another.
    place: Vec<usize>,
}

impl WholeProducts {
    /// XᵀR₀ of an X.
    pub fn turned(&self, x: &Array2<f64>) -> Array2<f64> {
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

pub(super) fn none() -> Error {
    Error::bad_data("nothing to solve")
        .field("blocks")
        .found("none")
        .expected("at least one")
        .help("reduce a block first")
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
    let mut given: Option<(NoiseSource, Vec<f64>)> = None;
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
        if let Some((noise_source, noise)) = &block.given {
            let all = given.get_or_insert((*noise_source, Vec::new()));
            all.1
                .extend(noise.iter().filter(|_| all.0 == *noise_source));
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
        given: given
            .and_then(|(noise_source, noise)| Some((noise_source, in_turn(&noise, &order)?))),
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
