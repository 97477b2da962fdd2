//! From poles to the model file: residues of every FRF, shapes, scaling, error bars.

use crate::damping::block_errors::BlockErrors;
use crate::damping::verdict::shifts;
use crate::model::identified::Identified;
use crate::model::limits;
use crate::model::residual_energy::{above_rounding, by_sums, Laid};
use crate::poles::pole::Pole;

use crate::data::layout::DataLayout;
use crate::data::options::FitOptions;
use crate::data::screening::Screened;
use crate::model::modes::{modes, rejected_mode, scale_unknown, scales, unscaled};
use crate::model::residues::{linear, synthesis, Linear};
use crate::poles::pole::Given;
use crate::shapes::error_bars::{shape_bars, Noisy, ShapeBars};
use crate::shapes::influence::Found;
use crate::shapes::line_bars::line_bars;
use crate::shapes::low_rank::low_rank_around;
use crate::shapes::low_rank::Shapes;
use crate::shapes::residues::{most_by_chance, significant_rank, Residues};
use crate::shapes::scale::Scale;
use crate::tolerances as tol;
use chladni_frf::{
    ComplexMatrix, Damping, Finding, ModalModel, Quality, ResidualTerm, ResidualTerms, Scaling,
    Trust, CREATED_BY, MODEL_FORMAT,
};
use chladni_linalg::blocked::blocked_matmul_mixed;
use chladni_linalg::LinalgError;
use ndarray::{Array1, Array2, Axis, ShapeBuilder};
use num_complex::Complex64;
use rayon::prelude::*;

/// Residues of every FRF at identified poles, each by itself.
struct FreeFit {
    /// The poles that the model can hold, rising in frequency.
    poles: Vec<Pole>,
    linear: Linear,
    /// (pole, pair), response by response; zero where missing.
    all: Array2<Complex64>,
    /// False where a pair was not measured.
    present: Array2<bool>,
    /// Noise variance of a value of an FRF, the mean of all, over that of a work value.
    noise: f64,
    /// That of each response over the mean.
    noise_of_response: Array1<f64>,
}

impl FreeFit {
    fn new(data: &DataLayout, identified: &Identified) -> Result<Self, LinalgError> {
        let Identified {
            damping,
            powers,
            work,
            back,
            ..
        } = identified;
        let holds = |pole: &&Pole| pole.grade.0 != Trust::Rejected && expressible(*damping, pole);
        let mut poles: Vec<Pole> = identified.poles.iter().filter(holds).cloned().collect();
        poles.sort_by(|a, b| a.omega.total_cmp(&b.omega));
        let values: Vec<Complex64> = poles.iter().map(|p| p.value).collect();
        let mut linear = linear(work, *damping, &values, powers)?;
        if let Some(back) = back {
            linear.residues = blocked_matmul_mixed(&linear.residues, back.view());
            linear.terms = blocked_matmul_mixed(&linear.terms, back.view());
        }
        let (responses, references) = (data.responses.len(), data.references.len());
        let mut all = Array2::zeros((values.len(), responses * references).f());
        let mut present = Array2::from_elem((responses, references), false);
        let noise = identified
            .noise_of_frfs()
            .unwrap_or_else(|| Array1::ones(data.pairs.len()));
        let mean = noise.mean().unwrap_or(1.0);
        let mut of_response = vec![(0.0, 0.0); responses];
        for (l, &(i, j)) in data.pairs.iter().enumerate() {
            present[[i, j]] = true;
            all.column_mut(i * references + j)
                .assign(&linear.residues.column(l));
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
    fn real_constraints(&self, identified: &Identified) -> usize {
        if !identified.real_shapes {
            return 0;
        }
        let given = self.poles.iter().filter_map(|pole| pole.given.as_ref());
        let terms: usize = given.map(|(shape, _)| shape.nrows()).sum();
        let (responses, references) = self.present.dim();
        terms * (responses + references - 1)
    }

    /// Shapes of low rank: one for each mode, of poles outside the band as many as the data
    /// show, and more together where weak directions of single poles explain something.
    fn shapes(
        &self,
        data: &DataLayout,
        identified: &Identified,
        real: usize,
    ) -> Result<Shapes, LinalgError> {
        let work = &identified.work;
        let variance = identified.variance * self.noise;
        let (responses, references) = self.present.dim();
        let free = Residues {
            values: &self.all,
            weight: &self.linear.weight,
            present: &self.present,
        };
        let (low, high) = work.range();
        let given: Vec<Given> = self.poles.iter().map(|pole| pole.given.clone()).collect();
        let outside = |n: usize| !(low..=high).contains(&self.poles[n].omega.powi(2));
        let loose: Vec<usize> = (0..given.len())
            .filter(|&n| outside(n) && given[n].is_none())
            .collect();
        let mut ranks = vec![1; given.len()];
        for &n in &loose {
            ranks[n] = significant_rank(&free, n, variance)?;
        }
        let mut shapes = low_rank_around(&free, &ranks, &given)?;
        let full = responses.min(references);
        let rounding = limits::RISE_ROUNDING * work.energy() * self.noise;
        let misfits = |shapes: &Shapes| {
            let constraints = shapes.constraints + real;
            let held = (work, data.pairs.len());
            shapes.rise > most_by_chance(constraints, variance, rounding, held)
        };
        while misfits(&shapes) && loose.iter().any(|&n| ranks[n] < full) {
            for &n in &loose {
                ranks[n] = (ranks[n] + 1).min(full);
            }
            shapes = low_rank_around(&free, &ranks, &given)?;
        }
        Ok(shapes)
    }

    /// Residual terms that answer the residues of the shapes in place of the free ones.
    fn answer(&mut self, data: &DataLayout, shapes: &Shapes) {
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
            answer,
            ..
        } = &mut self.linear;
        answer.apply(terms, residues);
    }

    /// χ² of the model as saved: free residues leave the noise variance per degree of
    /// freedom, the low-rank form adds its `rise`.
    fn chi2_per_dof(&self, identified: &Identified, rise: f64, constraints: usize) -> f64 {
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

/// Identified poles with the residues of every FRF brought into shapes: all but the
/// scaling.
pub(crate) struct Shaped {
    identified: Identified,
    /// The poles of the model, rising in frequency.
    poles: Vec<Pole>,
    shapes: Shapes,
    /// Scale of each term's shape.
    scales: Vec<Scale>,
    scaling: Scaling,
    bars: ShapeBars,
    /// (term, FRF), work units.
    terms: Array2<Complex64>,
    /// χ² per degree of freedom of the model as saved.
    pub chi2_per_dof: f64,
}

impl Shaped {
    /// Residues at the poles, shapes of low rank, residual terms that answer them.
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn new(data: &DataLayout, identified: Identified) -> Result<Self, LinalgError> {
        let mut free = FreeFit::new(data, &identified)?;
        let real = free.real_constraints(&identified);
        let shapes = free.shapes(data, &identified, real)?;
        free.answer(data, &shapes);
        let chi2_per_dof = free.chi2_per_dof(&identified, shapes.rise, shapes.constraints + real);
        let (scales, scaling) = scales(data, identified.damping, &free.poles, &shapes);
        let bars = shape_bars(
            &Noisy {
                work: &identified.work,
                powers: &identified.powers,
                poles: &free.poles,
                shapes: &shapes,
                present: &free.present,
                variance: identified.variance * free.noise,
                noise_of_response: &free.noise_of_response,
                real: identified.real_shapes,
            },
            &scales,
        );
        let mut shaped = Self {
            identified,
            poles: free.poles,
            shapes,
            scales,
            scaling,
            bars,
            terms: free.linear.terms,
            chi2_per_dof,
        };
        if let Some(errors) = &data.errors {
            shaped.hold_errors_of_lines(data, errors)?;
        }
        if shaped.identified.law_open {
            shaped.hold_both_laws();
        }
        Ok(shaped)
    }

    /// Bars from errors that neighbouring lines share.
    fn hold_errors_of_lines(
        &mut self,
        data: &DataLayout,
        errors: &BlockErrors,
    ) -> Result<(), LinalgError> {
        let noise = self.identified.noise_of_frfs();
        let found = Found {
            data,
            work: &self.identified.work,
            scales_of_frfs: noise.map(|noise| noise.mapv(f64::sqrt).to_vec()),
            powers: &self.identified.powers,
            poles: &self.poles,
            shapes: &self.shapes,
            scales: &self.scales,
        };
        for term in line_bars(&found, errors)? {
            term.put(&mut self.poles, &mut self.bars);
        }
        Ok(())
    }

    /// Widens bars by what the other damping law would shift.
    fn hold_both_laws(&mut self) {
        for pole in &mut self.poles {
            let [omega, loss, _] = shifts(pole.loss_factor);
            pole.omega_std = pole.omega_std.hypot(omega * pole.omega);
            pole.loss_factor_std = pole.loss_factor_std.hypot(loss);
        }
        if self.scaling != Scaling::UnitModalMass {
            return;
        }
        for (term, mut row) in self.bars.shape.rows_mut().into_iter().enumerate() {
            let [.., turn] = shifts(self.poles[self.shapes.owner[term]].loss_factor);
            self.bars.scale[term] = self.bars.scale[term].hypot(turn);
            let size = self.scales[term].factor.norm() * turn;
            row.zip_mut_with(&self.shapes.shape.row(term), |bar, value| {
                *bar = bar.hypot(size * value.norm());
            });
        }
    }

    /// Builds the model; `left` as from [`Self::left`].
    pub fn model(self, data: &DataLayout, options: &FitOptions, left: &[f64]) -> ModalModel {
        let mean_square = left.iter().sum::<f64>() / (data.lines.len() * data.pairs.len()) as f64;
        let relative_error = mean_square.sqrt() / data.measured_over_used();
        let Self {
            identified,
            poles,
            shapes,
            scales,
            scaling,
            bars,
            terms,
            chi2_per_dof,
        } = self;
        let Identified {
            damping,
            poles: all,
            powers,
            path,
            mut warnings,
            consistent,
            ..
        } = identified;
        let (responses, references) = (data.responses.len(), data.references.len());
        if chi2_per_dof > limits::SHAPE_MISFIT {
            warnings.push(
                Finding::caution(
                    "one-shape-worse",
                    format!(
                        "one shape per mode explains the references together worse than free \
                         residues (χ² per degree of freedom {chi2_per_dof:.1}): modes may be \
                         missing, or a reference is delayed or not reciprocal"
                    ),
                )
                .value("chi2_per_dof", chi2_per_dof)
                .help("look for a delay or a gain of one reference, or fit a narrower band"),
            );
        }

        let mut modes = modes(data, damping, &poles, &shapes, &scales, &bars);
        if scaling == Scaling::Unscaled {
            warnings.push(unscaled(data.reference_unit));
        }
        let unknown = (0..scales.len())
            .filter(|&term| scales[term].unknown(bars.scale[term]))
            .map(|term| &poles[shapes.owner[term]]);
        warnings.extend(scale_unknown(data, unknown));
        modes.extend(
            all.iter()
                .filter(|pole| pole.grade.0 == Trust::Rejected && expressible(damping, pole))
                .map(|pole| rejected_mode(data, pole)),
        );
        modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        let scale = data.rms / data.omega_max.powi(data.kind.omega_power());
        let residual_terms = ResidualTerms {
            omega_scale_rad_per_s: data.omega_max,
            terms: powers
                .iter()
                .enumerate()
                .map(|(p, &power)| {
                    let mut matrix = Array2::zeros((responses, references));
                    for (l, &(i, j)) in data.pairs.iter().enumerate() {
                        matrix[[i, j]] = terms[[p, l]] * scale / data.weight_of((i, j));
                    }
                    ResidualTerm {
                        power: 2 * power,
                        matrix: ComplexMatrix(matrix),
                    }
                })
                .collect(),
        };
        let in_band = modes
            .iter()
            .filter(|m| m.in_band && m.trust != Trust::Rejected)
            .count();
        let sure = modes
            .iter()
            .filter(|m| m.in_band && m.trust == Trust::Sure)
            .count();
        if in_band == 0 {
            warnings.push(
                Finding::fault("no-mode", "no mode stands out of the noise in this band")
                    .help("look at the FRFs, and fit a band with visible peaks"),
            );
        } else if sure == 0 {
            warnings.push(
                Finding::fault("none-sure", "no mode is sure")
                    .help("see the reasons given with each mode"),
            );
        }
        let mut all_warnings = data.warnings.clone();
        all_warnings.append(&mut warnings);
        let mut model = ModalModel {
            format: MODEL_FORMAT.into(),
            version: 1,
            created_by: CREATED_BY.into(),
            source: Vec::new(),
            options: serde_json::Map::new(),
            frf_kind: data.kind,
            reference_unit: data.reference_unit,
            band_hz: data.band_hz,
            damping,
            scaling,
            responses: data.responses.clone(),
            references: data.references.clone(),
            nodes: data.nodes.clone(),
            lines: data.traced.clone(),
            faces: data.faces.clone(),
            method: options.method.to_string(),
            modes,
            residual_terms,
            quality: Quality {
                relative_error,
                chi2_per_dof,
                trusted: consistent && sure > 0,
                findings: all_warnings,
                path: Some(path),
            },
        };
        model.number_findings();
        model
    }

    /// Sum of squares, in work units, that the model as saved leaves of each FRF in the
    /// measured kind, over the lines used: from what is known already, or by one more
    /// pass where rounding would decide.
    pub fn left(&self, data: &Screened) -> Vec<f64> {
        let basis = self.synthesis(data);
        let coefficients = |l: usize, factors: &mut [f64]| self.coefficients(data, l, factors);
        match self.identified.damping {
            Damping::Structural => above_rounding(&self.laid(&basis, &coefficients), data),
            Damping::Viscous => None,
        }
        .unwrap_or_else(|| {
            let of_frf = |l: usize, factors: &mut [f64]| {
                let weight = data.weight_of(data.pairs[l]);
                self.coefficients(data, l, factors);
                factors.iter_mut().for_each(|factor| *factor /= weight);
            };
            data.misfit(&basis, of_frf)
        })
    }

    /// The same without another look at the data.
    pub fn left_by_sums(&self, data: &DataLayout) -> Vec<f64> {
        let basis = self.synthesis(data);
        let coefficients = |l: usize, factors: &mut [f64]| self.coefficients(data, l, factors);
        by_sums(&self.laid(&basis, &coefficients), data)
    }

    fn laid<'a>(
        &'a self,
        basis: &'a Array2<f64>,
        coefficients: &'a (dyn Fn(usize, &mut [f64]) + Sync),
    ) -> Laid<'a> {
        Laid {
            basis,
            coefficients,
            columns: &self.identified.work,
            back: self.identified.back.as_ref(),
        }
    }

    /// The columns that the coefficients multiply, over the reals: see [`synthesis`].
    fn synthesis(&self, data: &DataLayout) -> Array2<f64> {
        let values: Vec<Complex64> = self.poles.iter().map(|pole| pole.value).collect();
        synthesis(
            data,
            self.identified.damping,
            &values,
            &self.identified.powers,
        )
    }

    /// Adds the coefficients of one FRF (position among the pairs), real and imaginary
    /// part in turn, poles before residual terms.
    fn coefficients(&self, data: &DataLayout, l: usize, factors: &mut [f64]) {
        let (i, j) = data.pairs[l];
        let Shapes {
            owner,
            shape,
            participation,
            ..
        } = &self.shapes;
        let mut add = |n: usize, value: Complex64| {
            factors[2 * n] += value.re;
            factors[2 * n + 1] += value.im;
        };
        owner
            .iter()
            .enumerate()
            .for_each(|(term, &n)| add(n, shape[[term, i]] * participation[[term, j]]));
        self.terms
            .column(l)
            .iter()
            .enumerate()
            .for_each(|(p, &value)| add(self.poles.len() + p, value));
    }
}

/// True where the model's fields can hold the pole.
fn expressible(damping: Damping, pole: &Pole) -> bool {
    let values = pole.omega > 1e-6 && pole.loss_factor.is_finite() && pole.loss_factor > 0.0;
    values && (damping == Damping::Structural || pole.loss_factor < tol::VISCOUS_LOSS_MOST)
}
