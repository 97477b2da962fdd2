//! Free residues of every FRF at identified poles, and the shapes of low rank that they are
//! brought into.

use crate::damping::law::loss_bound;
use crate::data::columns::Columns;
use crate::data::layout::DataLayout;
use crate::model::identified::Identified;
use crate::model::limits;
use crate::model::residues::{linear, Linear};
use crate::poles::pole::{Given, Pole};
use crate::shapes::low_rank::{AroundGiven, Shapes};
use crate::shapes::residues::{most_by_chance, significant_values, Residues};
use chladni_frf::{Damping, Reason, Trust};
use chladni_linalg::blocked::blocked_matmul_mixed;
use chladni_linalg::LinalgError;
use ndarray::{Array1, Array2, Axis, ShapeBuilder};
use num_complex::Complex64;
use rayon::prelude::*;

/// Free residues of every FRF at identified poles.
pub(crate) struct FreeFit {
    /// The poles that the model can hold, rising in frequency.
    pub poles: Vec<Pole>,
    pub linear: Linear,
    /// Residues in matrix order, (pole, response × references + reference), zero where a pair is
    /// missing; `None`: the residues of `linear` have that order.
    in_matrix_order: Option<Array2<Complex64>>,
    /// False where a pair was not measured.
    pub present: Array2<bool>,
    /// Noise variance of a value of an FRF, the mean of all, over that of a work value.
    pub noise: f64,
    /// Noise variance of each response over the mean.
    pub noise_of_response: Array1<f64>,
}

impl FreeFit {
    /// Fits residues at the poles that the model can hold, which are taken out of `identified`.
    pub fn new(data: &DataLayout, identified: &mut Identified) -> Result<Self, LinalgError> {
        let damping = identified.damping;
        let holds = |pole: &Pole| pole.grade.trust != Trust::Rejected && expressible(damping, pole);
        let found = std::mem::take(&mut identified.poles);
        let (mut poles, others): (Vec<Pole>, Vec<Pole>) = found.into_iter().partition(holds);
        identified.poles = others;
        poles.sort_by(|a, b| a.omega.total_cmp(&b.omega));
        let Identified {
            powers, work, back, ..
        } = &*identified;
        let values: Vec<Complex64> = poles.iter().map(|p| p.value).collect();
        let mut linear = linear(work, damping, &values, powers)?;
        if let Some(back) = back {
            linear.residues = blocked_matmul_mixed(&linear.residues, back.view());
            linear.terms = blocked_matmul_mixed(&linear.terms, back.view());
        }
        let mut present = Array2::from_elem((data.responses.len(), data.references.len()), false);
        data.pairs.iter().for_each(|&pair| present[pair] = true);
        let noise = identified
            .noise_of_frfs()
            .unwrap_or_else(|| Array1::ones(data.pairs.len()));
        let mean_noise = noise.mean().unwrap_or(1.0);
        Ok(Self {
            poles,
            in_matrix_order: in_matrix_order(&linear.residues, data),
            linear,
            present,
            noise: mean_noise,
            noise_of_response: noise_of_responses(&noise, mean_noise, data),
        })
    }

    /// Number of constraints that real shapes set: each fixes one phase per DOF but one.
    pub fn real_constraints(&self, identified: &Identified) -> usize {
        if !identified.real_shapes {
            return 0;
        }
        let given = self.poles.iter().filter_map(|pole| pole.given.as_ref());
        let terms: usize = given.map(|(shape, _)| shape.nrows()).sum();
        let (responses, references) = self.present.dim();
        terms * (responses + references - 1)
    }

    /// Shapes of low rank. Each mode has one. A pole outside the band has as many as its residues
    /// show, and more if weak directions of several such poles together explain something. A pole of
    /// the band has several if one leaves too much and its residues clearly show more, unless these
    /// are more modes than the band may have: what is left is then of modes that are left out.
    ///
    /// * `real_constraints`: as from [`Self::real_constraints`]
    /// * `modes`: the most that the band may have; `None`: as many as the data show
    pub fn shapes(
        &self,
        data: &DataLayout,
        identified: &Identified,
        real_constraints: usize,
        modes: Option<usize>,
    ) -> Result<Shapes, LinalgError> {
        let work = &identified.work;
        let variance = identified.variance * self.noise;
        let free = Residues {
            values: self
                .in_matrix_order
                .as_ref()
                .unwrap_or(&self.linear.residues),
            weight: &self.linear.weight,
            present: &self.present,
        };
        let given: Vec<&Given> = self.poles.iter().map(|pole| &pole.given).collect();
        let (inside, outside): (Vec<usize>, Vec<usize>) = (0..given.len())
            .filter(|&n| given[n].is_none())
            .partition(|&n| work.in_band(self.poles[n].lambda()));
        let mut ranks = vec![1; given.len()];
        for &n in &outside {
            ranks[n] = significant_values(&free, n, variance)?.len().max(1);
        }
        let around = AroundGiven::new(&free, &given)?;
        let mut shapes = around.shapes(&ranks)?;
        let rounding = limits::RISE_ROUNDING * work.energy() * self.noise;
        let misfits = |shapes: &Shapes| {
            let constraints = shapes.constraints + real_constraints;
            let on_columns = (work, data.pairs.len());
            shapes.rise > most_by_chance(constraints, variance, rounding, on_columns)
        };
        let free_sse = variance * (work.lines() * data.pairs.len()) as f64;
        // one shape each adds more than free residues leave of all FRFs: probably several modes
        // share a frequency
        if misfits(&shapes) && shapes.rise > free_sse {
            let shared = shared_ranks(&free, &inside, variance)?;
            let structured = (0..given.len()).filter(|&n| work.in_band(self.poles[n].lambda()));
            let known = structured.filter_map(|n| given[n].as_ref());
            let of_known: usize = known.map(|(shape, _)| shape.nrows()).sum();
            let all = of_known + shared.iter().sum::<usize>();
            let allowed = modes.is_none_or(|most| all <= most);
            if allowed && shared.iter().any(|&rank| rank != 1) {
                inside
                    .iter()
                    .zip(shared)
                    .for_each(|(&n, rank)| ranks[n] = rank);
                shapes = around.shapes(&ranks)?;
            }
        }
        let (responses, references) = self.present.dim();
        let full = responses.min(references);
        let mut rounds = 0;
        while misfits(&shapes) && outside.iter().any(|&n| ranks[n] < full) {
            let more = match rounds < limits::RANK_ROUNDS {
                true => 1,
                false => full,
            };
            for &n in &outside {
                ranks[n] = (ranks[n] + more).min(full);
            }
            shapes = around.shapes(&ranks)?;
            rounds += 1;
        }
        Ok(shapes)
    }

    /// Grades poles of the band with several shapes as weak.
    pub fn doubt_shared_frequencies(&mut self, work: &Columns, shapes: &Shapes) {
        for (n, pole) in self.poles.iter_mut().enumerate() {
            let terms = shapes.owner.iter().filter(|&&owner| owner == n).count();
            if terms > 1 && pole.given.is_none() && work.in_band(pole.lambda()) {
                pole.grade.trust = pole.grade.trust.min(Trust::Weak);
                pole.grade.reasons.push(shared_frequency(terms));
            }
        }
    }

    /// Fits the residual terms anew to the residues of the shapes in place of the free ones. The
    /// residues of `linear` become their change.
    pub fn refit_terms(&mut self, data: &DataLayout, shapes: &Shapes) {
        let change = &mut self.linear.residues;
        let blocks: Vec<_> = change
            .axis_chunks_iter_mut(Axis(1), limits::BUILD_BLOCK)
            .zip(data.pairs.chunks(limits::BUILD_BLOCK))
            .collect();
        blocks.into_par_iter().for_each(|(mut change, pairs)| {
            change.mapv_inplace(|v| -v);
            for (mut of_frf, &(i, j)) in change.columns_mut().into_iter().zip(pairs) {
                for (term, &n) in shapes.owner.iter().enumerate() {
                    of_frf[n] += shapes.shape[[term, i]] * shapes.participation[[term, j]];
                }
            }
        });
        let Linear {
            residues,
            terms,
            terms_per_residue,
            ..
        } = &mut self.linear;
        terms_per_residue.apply(terms, residues);
    }

    /// χ² per degree of freedom of the model as saved: the low-rank form adds its `rise` of the sum of
    /// squares to the residual of the free fit.
    pub fn chi2_per_dof(&self, identified: &Identified, rise: f64, constraints: usize) -> f64 {
        let Identified { work, powers, .. } = identified;
        let variance = identified.variance * self.noise;
        if variance <= 0.0 {
            return 1.0;
        }
        let unknowns = (self.poles.len() + powers.len()) * work.columns();
        let free = ((work.lines() * work.columns()) as f64 - unknowns as f64).max(1.0);
        (self.linear.sse * self.noise + rise) / (variance * (free + 0.5 * constraints as f64))
    }
}

/// Residues in matrix order, zero where a pair is missing; `None` if they have that order.
fn in_matrix_order(residues: &Array2<Complex64>, data: &DataLayout) -> Option<Array2<Complex64>> {
    let (responses, references) = (data.responses.len(), data.references.len());
    let in_turn = (0..responses * references).map(|l| (l / references, l % references));
    let by_column = residues.t().is_standard_layout();
    if by_column && in_turn.eq(data.pairs.iter().copied()) {
        return None;
    }
    let mut all = Array2::zeros((residues.nrows(), responses * references).f());
    for (&(i, j), column) in data.pairs.iter().zip(residues.columns()) {
        all.column_mut(i * references + j).assign(&column);
    }
    Some(all)
}

/// Noise of each response over the mean of all FRFs; 1 for a response without FRF.
fn noise_of_responses(noise: &Array1<f64>, mean: f64, data: &DataLayout) -> Array1<f64> {
    let mut sums = vec![(0.0, 0.0); data.responses.len()];
    for (&(response, _), noise) in data.pairs.iter().zip(noise) {
        sums[response].0 += noise / mean;
        sums[response].1 += 1.0;
    }
    sums.into_iter()
        .map(|(sum, count)| if count > 0.0 { sum / count } else { 1.0 })
        .collect()
}

/// Number of shapes that the residues of each of these `poles` clearly show.
fn shared_ranks(
    free: &Residues,
    poles: &[usize],
    variance: f64,
) -> Result<Vec<usize>, LinalgError> {
    let rank = |&n: &usize| {
        let values = significant_values(free, n, variance)?;
        let clear = |value: &&f64| **value > limits::SECOND_SHAPE * values[0];
        Ok(values.iter().filter(clear).count().max(1))
    };
    poles.iter().map(rank).collect()
}

/// Reason for a doubt: several modes share one pole.
fn shared_frequency(modes: usize) -> Reason {
    Reason::new(
        "shared-frequency",
        "several modes share this frequency: their shapes may be mixed with one another",
    )
    .detail(format!("{modes} shapes"))
}

/// True if the model's fields can hold the pole.
pub(crate) fn expressible(damping: Damping, pole: &Pole) -> bool {
    let values =
        pole.omega > limits::NO_FREQUENCY && pole.loss_factor.is_finite() && pole.loss_factor > 0.0;
    values && pole.loss_factor < loss_bound(damping)
}
