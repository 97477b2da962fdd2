//! From poles to the model file: residues of every FRF, shapes, scaling, error bars.

use crate::damping::bars::{in_either_case, turned_in_either_case};
use crate::damping::law::is_rational;
use crate::damping::synthesis::synthesis;
use crate::damping::verdict::{shifts, without_decay};
use crate::data::layout::DataLayout;
use crate::data::noise_levels::UnevenNoise;
use crate::data::noise_weights::is_rounding;
use crate::data::options::{FitOptions, Method};
use crate::data::screening::Screened;
use crate::data::window::block_errors::BlockErrors;
use crate::model::above_noise::above_noise;
use crate::model::free_fit::{expressible, FreeFit};
use crate::model::identified::{Identified, LawOpen};
use crate::model::limits;
use crate::model::modes::{
    modes, no_sure_mode, rejected_mode, scale_error_by_turns, scale_unknown, scales, unscaled,
    widen_scale,
};
use crate::model::residual_energy::{residuals_above_rounding, residuals_by_sums, ModelOnColumns};
use crate::poles::estimate::{fewer_modes, says_fewer_modes};
use crate::poles::pole::Pole;
use crate::shapes::error_bars::{shape_bars, Noisy, ShapeBars};
use crate::shapes::found::FittedPoles;
use crate::shapes::line_bars::line_bars;
use crate::shapes::low_rank::Shapes;
use crate::shapes::scale::Scale;
use crate::shapes::term_noise::{OfFrfs, TermNoise};
use chladni_frf::{
    ComplexMatrix, Finding, ModalModel, Mode, Quality, ResidualTerm, ResidualTerms, Scaling, Trust,
    CREATED_BY, MODEL_FORMAT,
};
use chladni_linalg::LinalgError;
use ndarray::Array2;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Identified poles with shapes, their scale and error bars: all of the model but its residual
/// energy.
pub(crate) struct Shaped {
    identified: Identified,
    /// The poles of the model, rising in frequency.
    poles: Vec<Pole>,
    shapes: Shapes,
    /// False where a pair was not measured, (response, reference).
    present: Array2<bool>,
    /// Noise variance of a value of an FRF, the mean of all.
    variance: f64,
    /// Scale of each term's shape.
    scales: Vec<Scale>,
    scaling: Scaling,
    bars: ShapeBars,
    /// Residual terms, (term, FRF), work units.
    terms: Array2<Complex64>,
    /// χ² per degree of freedom of the model as saved.
    pub chi2_per_dof: f64,
}

impl Shaped {
    /// Finds residues at the poles, shapes of low rank, and the residual terms that go with these.
    ///
    /// * `modes`: the most that the band may have; `None`: as many as the data show
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn new(
        data: &DataLayout,
        mut identified: Identified,
        modes: Option<usize>,
    ) -> Result<Self, LinalgError> {
        let mut free = FreeFit::new(data, &mut identified)?;
        let real_constraints = free.real_constraints(&identified);
        let shapes = free.shapes(data, &identified, real_constraints, modes)?;
        free.doubt_shared_frequencies(&identified.work, &shapes);
        free.refit_terms(data, &shapes);
        let constraints = shapes.constraints + real_constraints;
        let chi2_per_dof = free.chi2_per_dof(&identified, shapes.rise, constraints);
        let (scales, scaling) = scales(data, identified.damping, &free.poles, &shapes);
        let noise = TermNoise::of_responses(&free.noise_of_response, &shapes);
        let mut shaped = Self {
            variance: identified.variance * free.noise,
            identified,
            poles: free.poles,
            present: free.present,
            shapes,
            scales,
            scaling,
            bars: ShapeBars::default(),
            terms: free.linear.terms,
            chi2_per_dof,
        };
        shaped.bars = shaped.shape_bars(&noise);
        if let Some(errors) = &data.errors {
            shaped.set_bars_by_lines(data, errors)?;
        }
        Ok(shaped)
    }

    /// Replaces error bars by those from errors that neighbouring lines share.
    fn set_bars_by_lines(
        &mut self,
        data: &DataLayout,
        errors: &BlockErrors,
    ) -> Result<(), LinalgError> {
        let noise = self.identified.noise_of_frfs();
        let found = FittedPoles {
            data,
            work: &self.identified.work,
            scales_of_frfs: noise.map(|noise| noise.mapv(f64::sqrt).to_vec()),
            powers: &self.identified.powers,
            fitted: self.identified.fitted,
            residual_is_noise: self.identified.residual_is_noise,
            poles: &self.poles,
            shapes: &self.shapes,
            scales: &self.scales,
        };
        let (terms, force_drop) = line_bars(&found, errors)?;
        let finding = force_drop.and_then(|drop| drop.finding(data.hz()));
        self.identified.warnings.extend(finding);
        for term in terms {
            term.put(&mut self.poles, &mut self.bars);
        }
        Ok(())
    }

    /// The error bars of the shapes under this noise of their terms.
    fn shape_bars(&self, noise: &TermNoise) -> ShapeBars {
        let noisy = Noisy {
            work: &self.identified.work,
            powers: &self.identified.powers,
            poles: &self.poles,
            shapes: &self.shapes,
            present: &self.present,
            variance: self.variance,
            noise,
            real: self.identified.real_shapes,
        };
        shape_bars(&noisy, &self.scales)
    }

    /// Replaces error bars of an even noise where FRFs are not equally noisy.
    ///
    /// * `residual_energy`: as from [`Self::residual_energy`]
    /// * `at_maximum`: false for poles that are not at the maximum of the likelihood: their bars hold
    ///   more than noise, and become no shorter
    fn set_bars_by_frfs(
        &mut self,
        data: &DataLayout,
        residual_energy: &[f64],
        at_maximum: bool,
    ) -> Result<(), LinalgError> {
        let of_pairs = data.pairs.iter().zip(residual_energy);
        let left: Vec<f64> = of_pairs
            .map(|(&pair, left)| left * data.weight_of(pair).powi(2))
            .collect();
        let Identified { work, powers, .. } = &self.identified;
        let unknowns = self.poles.len() + powers.len();
        let Some(uneven) = UnevenNoise::new(&left, data.lines.len(), unknowns) else {
            return Ok(());
        };
        // what shapes leave beside noise lengthens bars, and shortens none
        let misfit = match self.chi2_per_dof > limits::SHAPE_MISFIT {
            true => self.chi2_per_dof,
            false => 1.0,
        };
        let over_mean: Vec<f64> = uneven
            .over_mean
            .iter()
            .map(|noise| noise * misfit)
            .collect();
        let noise = OfFrfs {
            pairs: &data.pairs,
            over_mean: &over_mean,
        };
        let mut of_poles = noise.of_poles((work, powers), &self.poles, &self.shapes)?;
        if !at_maximum {
            of_poles
                .iter_mut()
                .for_each(|noise| *noise = noise.max(1.0));
        }
        for (pole, variance) in self.poles.iter_mut().zip(&of_poles) {
            pole.omega_std *= variance.sqrt();
            pole.loss_factor_std *= variance.sqrt();
            if work.in_band(pole.lambda()) {
                pole.grade_anew();
            }
        }
        self.bars = self.shape_bars(&TermNoise::of_frfs(&noise, &self.shapes, &of_poles));
        Ok(())
    }

    /// Widens error bars of poles by their shift under the other damping law.
    ///
    /// * `decay`: of an exponential window, in units of ω_max
    fn widen_by_other_law(&mut self, decay: f64) {
        for pole in &mut self.poles {
            let [omega, loss, _] = shifts(without_decay(pole.loss_factor, pole.omega, decay));
            pole.omega_std = in_either_case(pole.omega_std, omega * pole.omega);
            pole.loss_factor_std = in_either_case(pole.loss_factor_std, loss);
        }
    }

    /// Widens the error bars of mass-scaled shapes by their turn under the other damping law; if the
    /// residual is noise, also by the error that turned phases suggest.
    ///
    /// * `decay`: of an exponential window, 1/s
    fn widen_by_turns(&self, modes: &mut [Mode], decay: f64) {
        let unexplained = match self.identified.law_open {
            LawOpen::No => return,
            LawOpen::ResidualNotWhite => 0.0,
            LawOpen::BeyondErrorBars => scale_error_by_turns(modes),
        };
        if self.scaling != Scaling::UnitModalMass {
            return;
        }
        for mode in modes.iter_mut() {
            let omega = TAU * mode.frequency_hz;
            let [.., turn] = shifts(without_decay(mode.loss_factor, omega, decay));
            widen_scale(mode, |std, size| {
                let in_both_laws = turned_in_either_case(std, turn * size);
                in_both_laws.max(std.hypot(unexplained * size))
            });
        }
    }

    /// Builds the model; `residual_energy` as from [`Self::residual_energy`].
    ///
    /// # Errors
    /// A kernel that fails.
    pub fn model(
        mut self,
        data: &DataLayout,
        options: &FitOptions,
        residual_energy: &[f64],
    ) -> Result<ModalModel, LinalgError> {
        let values = (data.lines.len() * data.pairs.len()) as f64;
        let mean_square = residual_energy.iter().sum::<f64>() / values;
        let relative_error = mean_square.sqrt() / data.measured_over_used();
        let Identified {
            residual_is_noise,
            fitted,
            ..
        } = self.identified;
        // bars that come from the residual itself, or from errors of lines, stay
        let by_even_noise = fitted && residual_is_noise && data.errors.is_none();
        if by_even_noise && !is_rounding(relative_error) {
            let at_maximum = matches!(options.method, Method::Auto | Method::Lean);
            self.set_bars_by_frfs(data, residual_energy, at_maximum)?;
        }
        if self.identified.law_open != LawOpen::No {
            self.widen_by_other_law(data.decay_of_window(options));
        }
        let mut modes = self.modes(data);
        self.widen_by_turns(&mut modes, options.exponential_window_per_s.unwrap_or(0.0));
        let mut findings = data.warnings.clone();
        findings.append(&mut self.identified.warnings);
        findings.extend(self.findings(data, &modes));
        if !findings.iter().any(says_fewer_modes) {
            let found = modes.iter().filter(|mode| mode.counts()).count();
            let asked = options.modes.filter(|asked| found < *asked);
            findings.extend(asked.map(|asked| fewer_modes(asked, found, "")));
        }
        let sure = modes.iter().any(|m| m.in_band && m.trust == Trust::Sure);
        let mut model = ModalModel {
            format: MODEL_FORMAT.into(),
            version: 1,
            created_by: CREATED_BY.into(),
            source: Vec::new(),
            options: serde_json::Map::new(),
            frf_kind: data.kind,
            reference_unit: data.reference_unit,
            band_hz: data.band_hz,
            damping: self.identified.damping,
            scaling: self.scaling,
            responses: data.responses.to_vec(),
            references: data.references.to_vec(),
            nodes: data.nodes.to_vec(),
            lines: data.traced.clone(),
            faces: data.faces.clone(),
            method: options.method.to_string(),
            modes,
            residual_terms: self.residual_terms(data),
            quality: Quality {
                relative_error,
                chi2_per_dof: self.chi2_per_dof,
                trusted: self.identified.consistent && sure,
                findings,
                path: Some(self.identified.path),
            },
        };
        model.number_findings();
        Ok(model)
    }

    /// All modes, rejected ones included, rising in frequency.
    fn modes(&self, data: &DataLayout) -> Vec<Mode> {
        let Identified { damping, poles, .. } = &self.identified;
        let mut modes = modes(
            data,
            *damping,
            &self.poles,
            &self.shapes,
            &self.scales,
            &self.bars,
        );
        modes.extend(
            poles
                .iter()
                .filter(|pole| pole.grade.trust == Trust::Rejected && expressible(*damping, pole))
                .map(|pole| rejected_mode(data, pole)),
        );
        modes.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
        modes
    }

    /// The findings on shapes, their scale and the number of modes.
    fn findings(&self, data: &DataLayout, modes: &[Mode]) -> Vec<Finding> {
        let mut findings = Vec::new();
        if self.chi2_per_dof > limits::SHAPE_MISFIT {
            findings.push(one_shape_worse(self.chi2_per_dof, data.references.len()));
        }
        if self.identified.residual_is_noise {
            let Identified { work, .. } = &self.identified;
            findings.extend(above_noise(
                self.chi2_per_dof,
                work.lines() * work.columns(),
            ));
        }
        if self.scaling == Scaling::Unscaled {
            findings.push(unscaled(data.reference_unit));
        }
        let unknown = (0..self.scales.len())
            .filter(|&term| self.scales[term].unknown(self.bars.scale[term]))
            .map(|term| &self.poles[self.shapes.owner[term]]);
        findings.extend(scale_unknown(data, unknown));
        findings.extend(no_sure_mode(modes));
        findings
    }

    /// The residual terms in SI units, for FRFs as they were measured.
    fn residual_terms(&self, data: &DataLayout) -> ResidualTerms {
        let scale = data.rms / data.omega_max.powi(data.kind.omega_power());
        let powers = self.identified.powers.iter().enumerate();
        ResidualTerms {
            omega_scale_rad_per_s: data.omega_max,
            terms: powers
                .map(|(p, &power)| {
                    let mut matrix = Array2::zeros((data.responses.len(), data.references.len()));
                    for (l, &(i, j)) in data.pairs.iter().enumerate() {
                        matrix[[i, j]] = self.terms[[p, l]] * scale / data.weight_of((i, j));
                    }
                    ResidualTerm {
                        power: 2 * power,
                        matrix: ComplexMatrix(matrix),
                    }
                })
                .collect(),
        }
    }

    /// Residual sum of squares of each FRF under the model as saved, over the lines used, in work
    /// units of the measured data. It is computed from known sums, or by one more pass if rounding
    /// would decide.
    pub fn residual_energy(&self, data: &Screened) -> Vec<f64> {
        let basis = self.synthesis(data);
        let coefficients = |l: usize, factors: &mut [f64]| self.coefficients(data, l, factors);
        let known = match is_rational(self.identified.damping) {
            true => residuals_above_rounding(&self.on_columns(&basis, &coefficients), data),
            false => None,
        };
        known.unwrap_or_else(|| {
            let of_frf = |l: usize, factors: &mut [f64]| {
                let weight = data.weight_of(data.pairs[l]);
                self.coefficients(data, l, factors);
                factors.iter_mut().for_each(|factor| *factor /= weight);
            };
            data.misfit(&basis, of_frf)
        })
    }

    /// Residual sum of squares of each FRF without another pass over the data.
    pub fn residual_energy_by_sums(&self, data: &DataLayout) -> Vec<f64> {
        let basis = self.synthesis(data);
        let coefficients = |l: usize, factors: &mut [f64]| self.coefficients(data, l, factors);
        residuals_by_sums(&self.on_columns(&basis, &coefficients), data)
    }

    fn on_columns<'a>(
        &'a self,
        basis: &'a Array2<f64>,
        coefficients: &'a (dyn Fn(usize, &mut [f64]) + Sync),
    ) -> ModelOnColumns<'a> {
        ModelOnColumns {
            basis,
            coefficients,
            columns: &self.identified.work,
            back: self.identified.back.as_ref(),
        }
    }

    /// Basis of the model over the reals: see [`synthesis`].
    fn synthesis(&self, data: &DataLayout) -> Array2<f64> {
        let values: Vec<Complex64> = self.poles.iter().map(|pole| pole.value).collect();
        synthesis(
            data,
            self.identified.damping,
            &values,
            &self.identified.powers,
        )
    }

    /// Adds the coefficients of one FRF (position among the pairs) to `sums`: real and imaginary
    /// part in turn, poles before residual terms.
    fn coefficients(&self, data: &DataLayout, l: usize, sums: &mut [f64]) {
        let (i, j) = data.pairs[l];
        let Shapes {
            owner,
            shape,
            participation,
            ..
        } = &self.shapes;
        let mut add = |n: usize, value: Complex64| {
            sums[2 * n] += value.re;
            sums[2 * n + 1] += value.im;
        };
        for (term, &n) in owner.iter().enumerate() {
            add(n, shape[[term, i]] * participation[[term, j]]);
        }
        for (p, &value) in self.terms.column(l).iter().enumerate() {
            add(self.poles.len() + p, value);
        }
    }
}

/// The finding that shapes of low rank explain the data worse than free residues.
fn one_shape_worse(chi2_per_dof: f64, references: usize) -> Finding {
    let (what, why, help) = match references {
        1 => (
            "the model explains the data",
            "modes may be missing, or the data are no response of a structure",
            "fit a narrower band",
        ),
        _ => (
            "one shape per mode explains the references together",
            "modes may be missing, or a reference is delayed or not reciprocal",
            "look for a delay or a gain of one reference, or fit a narrower band",
        ),
    };
    let words = format!(
        "{what} worse than free residues (χ² per degree of freedom {chi2_per_dof:.1}): {why}"
    );
    Finding::caution("one-shape-worse", words)
        .value("chi2_per_dof", chi2_per_dof)
        .help(help)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_reference_is_blamed_where_there_is_one() {
        let told = |references| {
            let finding = one_shape_worse(9.0, references);
            format!("{}; {}", finding.text, finding.help)
        };
        assert!(!told(1).contains("reference"), "{}", told(1));
        assert!(told(2).contains("a delay or a gain of one reference"));
    }
}
