//! The correspondence of the DOFs of two sets of shapes.

use crate::validation::limits::{SAME_POINT, SPACING_SAMPLES};
use chladni_frf::{Dof, Node, ShapeSet};
use std::collections::HashMap;

/// The rule by which DOFs find their partners.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum PairDofs {
    /// By name where names are shared and stand for the same places, one offset of all aside;
    /// else by place.
    #[default]
    Auto,
    /// By name: node and axis.
    Name,
    /// By place: the nearest node with that axis.
    Nearest,
}

impl PairDofs {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Auto, Self::Name, Self::Nearest];

    /// As it is written.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Name => "name",
            Self::Nearest => "nearest",
        }
    }
}

impl std::str::FromStr for PairDofs {
    type Err = String;
    fn from_str(text: &str) -> Result<Self, String> {
        let known = Self::ALL.into_iter().find(|way| way.as_str() == text);
        known.ok_or_else(|| format!("`{text}` is no way to pair DOFs; write auto, name or nearest"))
    }
}

/// Partners among the DOFs of two sets.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CommonDofs {
    /// Place in the first set, place in the second, and −1 where they are opposite ends
    /// of one axis, else 1; by rising place in the first.
    pub pairs: Vec<(usize, usize, f64)>,
    /// `name` or `nearest`.
    pub by: PairDofs,
    /// Largest distance between partners, m; `None` where positions are not known.
    pub largest_distance_m: Option<f64>,
    /// The names are shared, yet their places differ.
    pub names_contradicted: bool,
    /// The way from all positions of the first set to those of the second of the same name,
    /// m: another origin. `None` where the names stand for the same places, or no one offset
    /// explains how they differ.
    pub offset_m: Option<[f64; 3]>,
}

impl CommonDofs {
    pub fn new(a: &ShapeSet, b: &ShapeSet, way: PairDofs) -> Self {
        let places = [Places::new(a), Places::new(b)];
        let limit = SAME_POINT * places[0].spacing_m().max(places[1].spacing_m());
        let named = by_name(&a.dofs, &b.dofs);
        let apart: Vec<f64> = distances(a, b, &named, &places);
        let far = apart.iter().filter(|&&distance| distance > limit).count();
        let names_contradicted = limit > 0.0 && 2 * far > apart.len();
        let near = || by_place(a, b, &places, limit);
        let offset = names_contradicted
            .then(|| offset_of(a, b, &named, &places, limit))
            .flatten();
        // points that lie on each other need no names, whatever those say
        let (by, pairs) = match way {
            PairDofs::Auto if named.is_empty() => (PairDofs::Nearest, near()),
            PairDofs::Auto if names_contradicted => {
                let near = near();
                match offset.is_some() && near.len() < named.len() {
                    true => (PairDofs::Name, named),
                    false => (PairDofs::Nearest, near),
                }
            }
            PairDofs::Auto | PairDofs::Name => (PairDofs::Name, named),
            PairDofs::Nearest => (PairDofs::Nearest, near()),
        };
        let largest = distances(a, b, &pairs, &places)
            .into_iter()
            .reduce(f64::max);
        Self {
            pairs,
            by,
            largest_distance_m: largest,
            names_contradicted,
            offset_m: offset,
        }
    }
}

/// The offset that explains where every pair of one name lies, to within `limit_m`: the
/// median along each axis.
fn offset_of(
    a: &ShapeSet,
    b: &ShapeSet,
    named: &[(usize, usize, f64)],
    places: &[Places; 2],
    limit_m: f64,
) -> Option<[f64; 3]> {
    let apart: Vec<[f64; 3]> = (named.iter())
        .map(|&(i, j, _)| {
            let (here, there) = (places[0].of(a.dofs[i])?, places[1].of(b.dofs[j])?);
            Some([0, 1, 2].map(|axis| there[axis] - here[axis]))
        })
        .collect::<Option<_>>()?;
    let median = |axis: usize| {
        let mut along: Vec<f64> = apart.iter().map(|apart| apart[axis]).collect();
        along.sort_unstable_by(f64::total_cmp);
        along.get(along.len() / 2).copied()
    };
    let offset = [median(0)?, median(1)?, median(2)?];
    let explains = |apart: &[f64; 3]| distance(*apart, offset) <= limit_m;
    apart.iter().all(explains).then_some(offset)
}

/// Diagonal of the box around the positions of the DOFs of a set, m.
pub(super) fn extent_m(set: &ShapeSet) -> f64 {
    let places = Places::new(set);
    let side = |axis: usize| {
        let along = || places.0.values().map(|place| place[axis]);
        let most = along().fold(f64::NEG_INFINITY, f64::max);
        most - along().fold(f64::INFINITY, f64::min)
    };
    match places.0.is_empty() {
        true => 0.0,
        false => distance([side(0), side(1), side(2)], [0.0; 3]),
    }
}

/// Positions by node label.
struct Places(HashMap<u64, [f64; 3]>);

impl Places {
    /// Positions of the nodes that have a DOF.
    fn new(set: &ShapeSet) -> Self {
        let all: HashMap<u64, [f64; 3]> = set
            .nodes
            .iter()
            .map(|Node { label, xyz_m }| (*label, *xyz_m))
            .collect();
        let used = |dof: &Dof| Some((dof.node, *all.get(&dof.node)?));
        Self(set.dofs.iter().filter_map(used).collect())
    }

    fn of(&self, dof: Dof) -> Option<[f64; 3]> {
        self.0.get(&dof.node).copied()
    }

    /// Median distance of a node to its nearest neighbour, m; 0 without two nodes.
    fn spacing_m(&self) -> f64 {
        let mut points: Vec<(u64, [f64; 3])> = self.0.iter().map(|(&n, &p)| (n, p)).collect();
        points.sort_unstable_by_key(|(label, _)| *label);
        let step = points.len().div_ceil(SPACING_SAMPLES).max(1);
        let mut nearest: Vec<f64> = points
            .iter()
            .step_by(step)
            .filter_map(|(label, here)| {
                let others = points.iter().filter(|(other, _)| other != label);
                others
                    .map(|(_, there)| distance(*here, *there))
                    .filter(|&distance| distance > 0.0)
                    .reduce(f64::min)
            })
            .collect();
        nearest.sort_unstable_by(f64::total_cmp);
        nearest.get(nearest.len() / 2).copied().unwrap_or(0.0)
    }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

fn distances(
    a: &ShapeSet,
    b: &ShapeSet,
    pairs: &[(usize, usize, f64)],
    places: &[Places; 2],
) -> Vec<f64> {
    let of = |&(i, j, _): &(usize, usize, f64)| {
        Some(distance(places[0].of(a.dofs[i])?, places[1].of(b.dofs[j])?))
    };
    pairs.iter().filter_map(of).collect()
}

fn sign(a: Dof, b: Dof) -> f64 {
    a.direction.sign() * b.direction.sign()
}

fn by_name(a: &[Dof], b: &[Dof]) -> Vec<(usize, usize, f64)> {
    let mut names = HashMap::new();
    for (j, dof) in b.iter().enumerate() {
        names.entry((dof.node, dof.direction.axis())).or_insert(j);
    }
    let mut free = vec![true; b.len()];
    let partner = |(i, dof): (usize, &Dof)| {
        let j = *names.get(&(dof.node, dof.direction.axis()))?;
        std::mem::take(&mut free[j]).then(|| (i, j, sign(*dof, b[j])))
    };
    a.iter().enumerate().filter_map(partner).collect()
}

/// Nearest partners first; each DOF has one.
fn by_place(
    a: &ShapeSet,
    b: &ShapeSet,
    places: &[Places; 2],
    limit_m: f64,
) -> Vec<(usize, usize, f64)> {
    let there: Vec<(usize, Dof, [f64; 3])> = (b.dofs.iter().enumerate())
        .filter_map(|(j, &dof)| Some((j, dof, places[1].of(dof)?)))
        .collect();
    let nearest = |(i, dof): (usize, &Dof)| {
        let here = places[0].of(*dof)?;
        there
            .iter()
            .filter(|(_, other, _)| other.direction.axis() == dof.direction.axis())
            .map(|(j, _, there)| (distance(here, *there), i, *j))
            .min_by(|x, y| x.0.total_cmp(&y.0))
    };
    let mut candidates: Vec<(f64, usize, usize)> = (a.dofs.iter().enumerate())
        .filter_map(nearest)
        .filter(|(distance, ..)| *distance <= limit_m)
        .collect();
    candidates.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
    let mut free = vec![true; b.dofs.len()];
    let mut pairs: Vec<(usize, usize, f64)> = candidates
        .into_iter()
        .filter(|&(_, _, j)| std::mem::take(&mut free[j]))
        .map(|(_, i, j)| (i, j, sign(a.dofs[i], b.dofs[j])))
        .collect();
    pairs.sort_unstable_by_key(|&(i, ..)| i);
    pairs
}
