//! Values of all FRFs while they are estimated.

use super::force_noise::Correction;
use super::setting::Setting;
use super::{units, Estimate, Group};
use chladni_frf::{Dof, Estimation, Finding, FrfSet, FrfValues, Geometry, Result, Run};
use ndarray::{s, Array3};
use num_complex::Complex64;

/// Axes (response, reference, line); NaN where nothing was measured.
pub(super) struct Table {
    values: Array3<Complex64>,
    variance: Array3<f64>,
    coherence: Array3<f32>,
    responses: Vec<Dof>,
    references: Vec<Dof>,
    averages: [usize; 2],
    warnings: Vec<Finding>,
    /// Lines that got no value.
    masked: usize,
}

impl Table {
    pub(super) fn new(runs: &[Run], setting: &Setting, lines: usize) -> Self {
        let responses = super::unique(runs.iter().flat_map(Run::responses).map(|c| c.dof));
        let references = super::unique(runs.iter().flat_map(Run::references).map(|c| c.dof));
        let shape = (responses.len(), references.len(), lines);
        let nothing = Complex64::new(f64::NAN, f64::NAN);
        Self {
            values: Array3::from_elem(shape, nothing),
            variance: Array3::from_elem(shape, f64::NAN),
            coherence: Array3::from_elem(shape, f32::NAN),
            responses,
            references,
            averages: [usize::MAX, 0],
            warnings: setting.warnings().to_vec(),
            masked: 0,
        }
    }

    /// Place of a response.
    pub(super) fn row(&self, response: Dof) -> usize {
        self.responses.binary_search(&response).unwrap_or_default()
    }

    /// Places of the references of a group.
    pub(super) fn columns(&self, group: &Group) -> Vec<usize> {
        let column = |dof| self.references.binary_search(dof).unwrap_or_default();
        group.references.iter().map(column).collect()
    }

    /// Sets one value.
    pub(super) fn set(
        &mut self,
        at: [usize; 3],
        (value, variance): (Complex64, f64),
        coherence: f64,
    ) {
        self.values[at] = value;
        self.variance[at] = variance;
        self.coherence[at] = coherence as f32;
    }

    /// Adds one record to a mean, which [`Self::start_mean`] began.
    pub(super) fn add(
        &mut self,
        at: [usize; 3],
        (value, variance): (Complex64, f64),
        coherence: f64,
        share: f64,
    ) {
        self.values[at] += share * value;
        self.variance[at] += share * share * variance;
        self.coherence[at] += (share * coherence) as f32;
    }

    /// Undoes the bias that noise of the force leaves; the variance is at least what it adds.
    pub(super) fn correct(&mut self, at: [usize; 3], correction: Correction) {
        let Correction { factor, variance } = correction;
        self.values[at] *= factor;
        let least = variance * self.values[at].norm_sqr();
        self.variance[at] = (factor * factor * self.variance[at]).max(least);
    }

    /// Zero on all lines of a pair.
    pub(super) fn start_mean(&mut self, row: usize, column: usize) {
        let at = s![row, column, ..];
        self.values.slice_mut(at).fill(Complex64::default());
        self.variance.slice_mut(at).fill(0.0);
        self.coherence.slice_mut(at).fill(0.0);
    }

    /// Counts the averages of one response.
    pub(super) fn count(&mut self, averages: usize) {
        let [least, most] = self.averages;
        self.averages = [least.min(averages), most.max(averages)];
    }

    /// Counts a line of one response that got no value.
    pub(super) fn mask(&mut self) {
        self.masked += 1;
    }

    pub(super) fn warn_once(&mut self, warning: Finding) {
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }

    /// The FRFs, and how they were made.
    pub(super) fn finished(
        mut self,
        runs: &[Run],
        setting: &Setting,
        rate_hz: f64,
    ) -> Result<Estimate> {
        if self.masked > 0 {
            let words = format!(
                "{} lines have no power at a reference, or references that act as one: masked",
                self.masked
            );
            self.warnings
                .push(Finding::caution("lines-without-power", words));
        }
        let (kind, reference_unit) = units::kind_of(runs)?;
        let estimation = Estimation {
            averages: self.averages,
            forcing: setting.forcing(runs),
            ..setting.estimation(rate_hz)
        };
        let frf = FrfSet {
            frequency_hz: setting.frequency_hz(rate_hz),
            values: FrfValues::F64(self.values),
            responses: self.responses,
            references: self.references,
            kind,
            reference_unit,
            coherence: Some(self.coherence),
            variance: Some(self.variance),
            estimation: Some(estimation),
            geometry: Geometry::default(),
        };
        Ok(Estimate {
            frf: frf.checked()?,
            estimation,
            findings: self.warnings,
        })
    }
}
