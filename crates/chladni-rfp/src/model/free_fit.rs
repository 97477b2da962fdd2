//! Residues of every FRF at identified poles, each by itself, and the shapes that they
//! are brought into.

use crate::damping::law::loss_bound;
use crate::data::columns::Columns;
use crate::data::layout::DataLayout;
use crate::model::identified::Identified;
use crate::model::limits;
use crate::model::residues::{linear, Linear};
use crate::poles::pole::{Given, Pole};
use crate::shapes::low_rank::{low_rank_around, Shapes};
use crate::shapes::residues::{most_by_chance, significant_values, Residues};
use chladni_frf::{Damping, Reason, Trust};
use chladni_linalg::blocked::blocked_matmul_mixed;
use chladni_linalg::LinalgError;
use ndarray::{Array1, Array2, Axis, ShapeBuilder};
use num_complex::Complex64;
use rayon::prelude::*;

/// Residues of every FRF at identified poles, each by itself.
pub(crate) struct FreeFit {
    /// The poles that the model can hold, rising in frequency.
    pub poles: Vec<Pole>,
    pub linear: Linear,
    /// (pole, pair), response by response, zero where missing; `None`: these are the
    /// residues of `linear`.
    all: Option<Array2<Complex64>>,
    /// False where a pair was not measured.
    pub present: Array2<bool>,
    /// Noise variance of a value of an FRF, the mean of all, over that of a work value.
    pub noise: f64,
    /// That of each response over the mean.
    pub noise_of_response: Array1<f64>,
}

impl FreeFit {
    /// On the lines and FRFs of `data`; takes the poles that the model can hold.
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
        let (responses, references) = (data.responses.len(), data.references.len());
        let in_turn = (0..responses * references).map(|l| (l / references, l % references));
        let by_column = linear.residues.t().is_standard_layout();
        let mut all = match by_column && in_turn.eq(data.pairs.iter().copied()) {
            true => None,
            false => Some(Array2::zeros((values.len(), responses * references).f())),
        };
        let mut present = Array2::from_elem((responses, references), false);
        let noise = identified
            .noise_of_frfs()
            .unwrap_or_else(|| Array1::ones(data.pairs.len()));
        let mean = noise.mean().unwrap_or(1.0);
        let mut of_response = vec![(0.0, 0.0); responses];
        for (l, &(i, j)) in data.pairs.iter().enumerate() {
            present[[i, j]] = true;
            if let Some(all) = &mut all {
                all.column_mut(i * references + j)
                    .assign(&linear.residues.column(l));
            }
            of_response[i] = (of_response[i].0 + noise[l] / mean, of_response[i].1 + 1.0);
        }
        let noise_of_response = of_response
            .into_iter()
            .map(|(sum, count)| if count > 0.0 { sum / count } else { 1.0 })
            .collect();
        Ok(Self {
            poles,
            linear,
            all,
            present,
            noise: mean,
            noise_of_response,
        })
    }

    /// Constraints of the poles whose shapes are real: a real term fixes one phase per DOF
    /// but one.
    pub fn real_constraints(&self, identified: &Identified) -> usize {
        if !identified.real_shapes {
            return 0;
        }
        let given = self.poles.iter().filter_map(|pole| pole.given.as_ref());
        let terms: usize = given.map(|(shape, _)| shape.nrows()).sum();
        let (responses, references) = self.present.dim();
        terms * (responses + references - 1)
    }

    /// Shapes of low rank: one for each mode, of poles outside the band as many as the data
    /// show, and more together where weak directions of single poles explain something. A pole of
    /// the band has several where one leaves too much and its residues clearly have more.
    pub fn shapes(
        &self,
        data: &DataLayout,
        identified: &Identified,
        real: usize,
    ) -> Result<Shapes, LinalgError> {
        let work = &identified.work;
        let variance = identified.variance * self.noise;
        let (responses, references) = self.present.dim();
        let free = Residues {
            values: self.all.as_ref().unwrap_or(&self.linear.residues),
            weight: &self.linear.weight,
            present: &self.present,
        };
        let (low, high) = work.range();
        let given: Vec<&Given> = self.poles.iter().map(|pole| &pole.given).collect();
        let outside = |n: usize| !(low..=high).contains(&self.poles[n].omega.powi(2));
        let loose: Vec<usize> = (0..given.len())
            .filter(|&n| outside(n) && given[n].is_none())
            .collect();
        let mut ranks = vec![1; given.len()];
        for &n in &loose {
            ranks[n] = significant_values(&free, n, variance)?.len().max(1);
        }
        let mut shapes = low_rank_around(&free, &ranks, &given)?;
        let full = responses.min(references);
        let rounding = limits::RISE_ROUNDING * work.energy() * self.noise;
        let misfits = |shapes: &Shapes| {
            let constraints = shapes.constraints + real;
            let held = (work, data.pairs.len());
            shapes.rise > most_by_chance(constraints, variance, rounding, held)
        };
        let ranks_of_one = ranks.clone();
        // what free residues leave of all FRFs
        let left = variance * (work.lines() * data.pairs.len()) as f64;
        // one shape each leaves more than that again: probably several modes at one frequency
        if misfits(&shapes) && shapes.rise > left {
            for n in (0..given.len()).filter(|&n| !outside(n) && given[n].is_none()) {
                let values = significant_values(&free, n, variance)?;
                let clear = |value: &&f64| **value > limits::SECOND_SHAPE * values[0];
                ranks[n] = values.iter().filter(clear).count().max(1);
            }
            if ranks != ranks_of_one {
                shapes = low_rank_around(&free, &ranks, &given)?;
            }
        }
        let mut rounds = 0;
        while misfits(&shapes) && loose.iter().any(|&n| ranks[n] < full) {
            let more = if rounds < limits::RANK_ROUNDS {
                1
            } else {
                full
            };
            for &n in &loose {
                ranks[n] = (ranks[n] + more).min(full);
            }
            shapes = low_rank_around(&free, &ranks, &given)?;
            rounds += 1;
        }
        Ok(shapes)
    }

    /// Grades poles of the band with several shapes as weak.
    pub fn doubt_shared(&mut self, work: &Columns, shapes: &Shapes) {
        for (n, pole) in self.poles.iter_mut().enumerate() {
            let terms = shapes.owner.iter().filter(|&&owner| owner == n).count();
            if terms > 1 && pole.given.is_none() && work.in_band((pole.omega * pole.omega).into()) {
                pole.grade.trust = pole.grade.trust.min(Trust::Weak);
                pole.grade.reasons.push(shared_frequency(terms));
            }
        }
    }

    /// Residual terms that answer the residues of the shapes in place of the free ones.
    pub fn answer(&mut self, data: &DataLayout, shapes: &Shapes) {
        let change = &mut self.linear.residues;
        let blocks: Vec<_> = change
            .axis_chunks_iter_mut(Axis(1), limits::BUILD_BLOCK)
            .zip(data.pairs.chunks(limits::BUILD_BLOCK))
            .collect();
        blocks.into_par_iter().for_each(|(mut change, pairs)| {
            change.mapv_inplace(|v| -v);
            for (mut change, &(i, j)) in change.columns_mut().into_iter().zip(pairs) {
                for (term, &n) in shapes.owner.iter().enumerate() {
                    change[n] += shapes.shape[[term, i]] * shapes.participation[[term, j]];
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

    /// χ² of the model as saved: free residues leave the noise variance per degree of
    /// freedom, the low-rank form adds its `rise`.
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

/// The reason of modes that share one pole.
fn shared_frequency(modes: usize) -> Reason {
    Reason::new(
        "shared-frequency",
        "several modes share this frequency: their shapes may be mixed with one another",
    )
    .detail(format!("{modes} shapes"))
}

/// True where the model's fields can hold the pole.
pub(crate) fn expressible(damping: Damping, pole: &Pole) -> bool {
    let values =
        pole.omega > limits::NO_FREQUENCY && pole.loss_factor.is_finite() && pole.loss_factor > 0.0;
    values && pole.loss_factor < loss_bound(damping)
}
