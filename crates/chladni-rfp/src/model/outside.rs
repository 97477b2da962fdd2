//! The world outside the band, settled around the modes of the band as the file has them.
//!
//! Poles outside were found beside free residues, which hide part of what the outside
//! leaves: a real shape cannot. Viscous ones were found with other columns than a file has
//! (see [`crate::damping::pairs`]). Where the model as saved leaves more than noise, they
//! move, and others join them while each takes out more than noise can.

use crate::damping::columns::viscous_pole_of;
use crate::damping::pairs::refined_pairs;
use crate::damping::structural::basis;
use crate::damping::viscous::viscous_basis;
use crate::data::columns::Columns;
use crate::data::information::covariance;
use crate::data::layout::DataLayout;
use crate::model::build::expressible;
use crate::model::identified::{structural_pole, viscous_pole, Identified, Pole};
use crate::poles::estimate::Grade;
use crate::poles::prune::threshold;
use crate::poles::refine::refine;
use crate::poles::scan::usual_loss;
use crate::shapes::residues::beyond_chance;
use crate::tolerances as tol;
use chladni_frf::{Damping, Trust};
use chladni_linalg::blocked::blocked_matmul;
use chladni_linalg::{matmul, LinalgError};
use ndarray::{Array2, ShapeBuilder};
use num_complex::Complex64;

/// Poles that may join.
const MOST_MORE: usize = 4;
/// Natural frequencies at which one is sought, over that of the band's end.
const BELOW: [f64; 3] = [0.95, 0.7, 0.35];
const ABOVE: [f64; 3] = [1.03, 1.12, 1.35];

/// Settles the poles outside the band that have no shapes yet; `free_sse`: what free
/// residues leave of the columns.
///
/// # Errors
/// A kernel that fails.
pub(crate) fn settle_outside(
    data: &DataLayout,
    identified: &mut Identified,
    free_sse: f64,
) -> Result<(), LinalgError> {
    let holds =
        |pole: &Pole| pole.grade.0 != Trust::Rejected && expressible(identified.damping, pole);
    let beyond = |pole: &Pole| {
        holds(pole) && pole.given.is_none() && !identified.work.in_band(pole.lambda())
    };
    let (outside, others): (Vec<Pole>, Vec<Pole>) =
        identified.poles.iter().cloned().partition(beyond);
    let (given, open): (Vec<&Pole>, Vec<&Pole>) = others
        .iter()
        .filter(|pole| holds(pole))
        .partition(|pole| pole.given.is_some());
    if given.is_empty() && identified.damping == Damping::Structural {
        return Ok(());
    }
    let Some(work) = around(data, identified, &given) else {
        return Ok(());
    };
    let world = World {
        work: &work,
        damping: identified.damping,
        powers: &identified.powers,
        inside: open.iter().map(|pole| pole.value).collect(),
        loss: usual_loss(&work, &others.iter().map(Pole::lambda).collect::<Vec<_>>()),
    };
    let constraints = 2 * given.len() * work.columns();
    let too_much = |sse: f64| {
        let rounding = tol::STRUCTURE_ROUNDING * work.energy();
        beyond_chance(sse - free_sse, constraints, identified.variance, rounding)
            > tol::STRUCTURE_SIGMAS
    };
    let start: Vec<Complex64> = outside.iter().map(|pole| pole.value).collect();
    if world.at(&start, 0)?.is_none_or(|here| !too_much(here.sse)) {
        return Ok(());
    }
    let limit = threshold(data.pairs.len(), work.lines()) * identified.variance;
    let Some(settled) = world.settled(&start, limit, too_much)? else {
        return Ok(());
    };
    let poles = settled.poles(identified.damping, identified.variance);
    identified.poles = others.into_iter().chain(poles).collect();
    Ok(())
}

/// The columns without what the modes with `given` shapes explain. `None`: columns that
/// are no orthonormal mixtures of the FRFs.
fn around(data: &DataLayout, identified: &Identified, given: &[&Pole]) -> Option<Columns> {
    let work = &identified.work;
    if given.is_empty() {
        return Some(work.clone());
    }
    if identified
        .noise_of_frfs()
        .is_some_and(|noise| noise.iter().any(|n| *n != 1.0))
    {
        return None;
    }
    let mut residues = Array2::zeros((given.len(), data.pairs.len()).f());
    for (mut row, (shape, participation)) in residues
        .rows_mut()
        .into_iter()
        .zip(given.iter().filter_map(|pole| pole.given.as_ref()))
    {
        for (value, &(i, j)) in row.iter_mut().zip(&data.pairs) {
            *value = shape
                .column(i)
                .iter()
                .zip(participation.column(j))
                .map(|(s, l)| s * l)
                .sum();
        }
    }
    let residues = match &identified.back {
        Some(back) => blocked_matmul(residues.view(), back.t().mapv(Complex64::from).view()),
        None => residues,
    };
    let values: Vec<Complex64> = given.iter().map(|pole| pole.value).collect();
    let explained = match identified.damping {
        Damping::Structural => matmul(basis(work, &values, &[]).view(), residues.view()),
        Damping::Viscous => {
            let parts =
                Array2::from_shape_fn((2 * values.len(), residues.ncols()).f(), |(row, c)| {
                    let value = residues[[row / 2, c]];
                    if row % 2 == 0 {
                        value.re
                    } else {
                        value.im
                    }
                });
            let stacked = matmul(viscous_basis(work, &values, &[]).view(), parts.view());
            let lines = work.lines();
            Array2::from_shape_fn(work.b.dim().f(), |(k, c)| {
                Complex64::new(stacked[[k, c]], stacked[[lines + k, c]])
            })
        }
    };
    Some(work.with_columns(&work.b - &explained))
}

/// What the poles outside must explain.
struct World<'a> {
    work: &'a Columns,
    damping: Damping,
    powers: &'a [i32],
    /// Poles of the band with free residues, which stay.
    inside: Vec<Complex64>,
    /// Loss factor that a search begins with.
    loss: f64,
}

/// Poles outside as they stand.
struct Outside {
    values: Vec<Complex64>,
    /// Covariances of (Re, Im), for unit noise variance.
    spread: Vec<[[f64; 2]; 2]>,
    sse: f64,
}

impl World<'_> {
    /// The poles after some steps; `None` where one came into the band or the columns cannot
    /// be told apart.
    fn at(&self, start: &[Complex64], steps: usize) -> Result<Option<Outside>, LinalgError> {
        let found = match self.damping {
            Damping::Structural => {
                let all = [start, &self.inside].concat();
                let refined = refine(self.work, &all, self.powers, steps, tol::FINE_STEP)?;
                let spread = match all.is_empty() {
                    true => Array2::zeros((0, 0)),
                    false => covariance(refined.information(self.work).view()),
                };
                let own = |n: usize| 0.5 * spread[[n, n]].re;
                Outside {
                    values: refined.lambda[..start.len()].to_vec(),
                    spread: (0..start.len())
                        .map(|n| [[own(n), 0.0], [0.0, own(n)]])
                        .collect(),
                    sse: refined.projection.sse,
                }
            }
            Damping::Viscous => {
                let all = [start, &self.inside].concat();
                let free: Vec<usize> = (0..start.len()).collect();
                let Some(pairs) = refined_pairs(self.work, &all, self.powers, &free, steps) else {
                    return Ok(None);
                };
                Outside {
                    values: pairs.poles[..start.len()].to_vec(),
                    spread: pairs.spread,
                    sse: pairs.sse,
                }
            }
        };
        let beyond = |value: &Complex64| {
            let square = match self.damping {
                Damping::Structural => *value,
                Damping::Viscous => value.norm_sqr().into(),
            };
            square.re > 0.0 && !self.work.in_band(square)
        };
        Ok(found.values.iter().all(beyond).then_some(found))
    }

    /// Moved, and with others, until no more is left than noise.
    fn settled(
        &self,
        start: &[Complex64],
        limit: f64,
        too_much: impl Fn(f64) -> bool,
    ) -> Result<Option<Outside>, LinalgError> {
        let mut best = match self.at(start, tol::REFINE_FINE)? {
            Some(best) => best,
            None => match self.at(start, 0)? {
                Some(best) => best,
                None => return Ok(None),
            },
        };
        for _ in 0..MOST_MORE {
            if !too_much(best.sse) {
                break;
            }
            let mut better: Option<Outside> = None;
            for place in self.places() {
                let more = [&best.values[..], &[place]].concat();
                if let Some(more) = self.at(&more, tol::REFINE_FINE)? {
                    if better.as_ref().is_none_or(|known| more.sse < known.sse) {
                        better = Some(more);
                    }
                }
            }
            match better.filter(|more| best.sse - more.sse > limit) {
                Some(more) => best = more,
                None => break,
            }
        }
        Ok(Some(best))
    }

    /// Where one more may lie.
    fn places(&self) -> impl Iterator<Item = Complex64> + '_ {
        let (low, high) = self.work.range();
        let squares = BELOW
            .map(|f| low * f * f)
            .into_iter()
            .chain(ABOVE.map(|f| high * f * f));
        squares.map(move |x| {
            let pole = Complex64::new(x, self.loss * x);
            match self.damping {
                Damping::Structural => pole,
                Damping::Viscous => viscous_pole_of(pole),
            }
        })
    }
}

impl Outside {
    /// As the model has them, with noise of this variance.
    fn poles(self, damping: Damping, variance: f64) -> Vec<Pole> {
        let graded = || -> Grade { (Trust::Sure, Vec::new()) };
        self.values
            .into_iter()
            .zip(self.spread)
            .map(|(value, spread)| {
                let spread = spread.map(|row| row.map(|v| v * variance));
                match damping {
                    Damping::Structural => {
                        structural_pole(value, [spread[0][0], spread[1][1]], graded())
                    }
                    Damping::Viscous => viscous_pole(value, spread, graded()),
                }
            })
            .collect()
    }
}
