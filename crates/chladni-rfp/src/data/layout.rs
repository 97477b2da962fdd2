//! The data without their values: lines, FRFs, scale. The steps after the passes over the data need
//! no more.

use crate::data::columns::Columns;
use crate::data::limits;
use crate::data::line_variance::{of_neighbours, LineVariance};
use crate::data::options::{Effort, FitOptions};
use crate::data::pair_weights::{NextWeights, NoiseSource, PairWeights};
use crate::data::window::block_errors::BlockErrors;
use crate::data::window::kinds::Window;
use crate::data::window::leakage::{Leakage, LeakingLines};
use chladni_frf::{
    Damping, Dof, Estimation, Estimator, Finding, FrfKind, FrfSet, Node, ReferenceUnit,
};
use ndarray::{Array2, ArrayView1};
use num_complex::Complex64;
use std::f64::consts::TAU;
use std::sync::Arc;

/// The lines and FRFs used, and their units. Clones share all that grows with the number of
/// FRFs: of a million FRFs each clone took 70 MB.
#[derive(Debug, Clone)]
pub(crate) struct DataLayout {
    /// Response DOFs of the set.
    pub responses: Arc<[Dof]>,
    /// Reference DOFs of the set.
    pub references: Arc<[Dof]>,
    /// Nodes of the set.
    pub nodes: Arc<[Node]>,
    /// Trace lines, node labels.
    pub traced: Vec<Vec<u64>>,
    /// Faces, node labels.
    pub faces: Vec<Vec<u64>>,
    /// Unit of the references.
    pub reference_unit: ReferenceUnit,
    /// Kind of the FRFs.
    pub kind: FrfKind,
    /// Indices of the lines used.
    pub lines: Vec<usize>,
    /// Their frequencies, Hz.
    pub line_hz: Vec<f64>,
    /// Pairs (response, reference) used, row by row.
    pub pairs: Arc<[(usize, usize)]>,
    /// Band, Hz.
    pub band_hz: [f64; 2],
    /// ω of the last line, rad/s.
    pub omega_max: f64,
    /// Root mean square of the data used, in SI units of the kind.
    pub rms: f64,
    /// x_k.
    pub x: Vec<f64>,
    /// g_k.
    pub g: Vec<f64>,
    /// The law that poles are sought in.
    pub law: Damping,
    /// The window of the records, if it is known.
    pub window: Option<Window>,
    /// Length of the records, s, if the set says that they are blows under a Hann window. The fit has
    /// no columns with that line shape.
    pub hann_on_blows_s: Option<f64>,
    /// True if the set says that a local method estimated it from a force that does not suit it.
    pub local_on_smooth_force: bool,
    /// True if the FRFs are means of H2 or Hv.
    pub unlike_h1: bool,
    /// Part of a record that holds samples, s; 0 if it is not known.
    pub record_s: f64,
    /// Effect of the window on the columns of poles; `None` if there is none.
    pub leakage: Option<Arc<Leakage>>,
    /// Errors that neighbouring lines share; `None` if they share none, or this is not known.
    pub errors: Option<Arc<BlockErrors>>,
    /// Variance of lines, if the set gives it and errors of lines are independent; else empty.
    pub line_variance: LineVariance,
    /// Correlation of the errors of neighbouring lines by the way they were estimated.
    pub neighbours: f64,
    /// Findings on data that were left out.
    pub warnings: Vec<Finding>,
    /// Effort spent on finding poles.
    pub effort: Effort,
    /// Sum of squares of each pair on these lines, in SI units of the kind, times the square of its
    /// weight if FRFs are weighted; empty if it is not known.
    pub energy: Arc<[f64]>,
    /// The weighting, if the data used are the measurement weighted by its noise.
    pub weighting: Option<Weighting>,
    /// The weights that may be tried after these.
    pub next_weights: NextWeights,
    /// Outlier lines left out, Hz.
    pub dropped_hz: Vec<f64>,
    /// Number of rounds in which outlier lines were left out.
    pub outlier_rounds: usize,
}

/// Weights of the data, and the scale of the measured data.
#[derive(Debug, Clone)]
pub(crate) struct Weighting {
    /// Factors on the FRFs.
    pub weights: PairWeights,
    /// Root mean square of the FRFs as they were measured.
    pub rms: f64,
    /// Source of the noise; `None`: the residual of a fit without weights.
    pub noise_source: Option<NoiseSource>,
}

impl Weighting {
    /// The weighting in words, for the path.
    pub fn words(&self) -> String {
        let words = self.weights.words();
        match self.noise_source {
            Some(noise_source) => format!("{words}, as {}", noise_source.words()),
            None => words,
        }
    }
}

impl DataLayout {
    /// Layout of the lines of `frf` with these indices, without pairs and with scale 1.
    ///
    /// * `band_hz`: as asked for; it is narrowed to the lines
    pub fn new(
        frf: &FrfSet,
        kind: FrfKind,
        lines: Vec<usize>,
        band_hz: [f64; 2],
        effort: Effort,
    ) -> Self {
        Self {
            responses: frf.responses.as_slice().into(),
            references: frf.references.as_slice().into(),
            nodes: frf.geometry.nodes.as_slice().into(),
            traced: frf.geometry.lines.clone(),
            faces: frf.geometry.faces.clone(),
            reference_unit: frf.reference_unit,
            neighbours: of_neighbours(frf),
            ..Self::on_lines(frf.frequency_hz.view(), kind, lines, band_hz, effort)
        }
    }

    /// Layout of the lines of an axis with these indices, without DOFs.
    pub fn on_lines(
        frequency_hz: ArrayView1<f64>,
        kind: FrfKind,
        lines: Vec<usize>,
        band_hz: [f64; 2],
        effort: Effort,
    ) -> Self {
        let line_hz: Vec<f64> = lines.iter().map(|&k| frequency_hz[k]).collect();
        let (first, last) = (
            line_hz.first().copied().unwrap_or(0.0),
            line_hz.last().copied().unwrap_or(0.0),
        );
        let mut layout = Self {
            responses: Arc::default(),
            references: Arc::default(),
            nodes: Arc::default(),
            traced: Vec::new(),
            faces: Vec::new(),
            reference_unit: ReferenceUnit::default(),
            kind,
            lines,
            line_hz,
            pairs: Arc::default(),
            band_hz: [first.max(band_hz[0]), last.min(band_hz[1])],
            omega_max: TAU * last,
            rms: 1.0,
            x: Vec::new(),
            g: Vec::new(),
            law: Damping::Structural,
            window: None,
            hann_on_blows_s: None,
            local_on_smooth_force: false,
            unlike_h1: false,
            record_s: 0.0,
            leakage: None,
            errors: None,
            line_variance: LineVariance::default(),
            neighbours: 0.0,
            warnings: Vec::new(),
            effort,
            energy: Arc::default(),
            weighting: None,
            next_weights: NextWeights::FromSet,
            dropped_hz: Vec::new(),
            outlier_rounds: 0,
        };
        let ratio: Vec<f64> = layout
            .line_hz
            .iter()
            .map(|f| TAU * f / layout.omega_max)
            .collect();
        layout.x = ratio.iter().map(|r| r * r).collect();
        layout.g = ratio.iter().map(|r| r.powi(kind.omega_power())).collect();
        layout
    }

    /// With the window and the length of the records.
    ///
    /// * `decay_per_s`: of an exponential window
    /// * `record_s`: part of a record that holds samples
    /// * `made`: the estimation of the FRFs, if the set describes it
    pub fn windowed(
        self,
        window: Option<Window>,
        decay_per_s: Option<f64>,
        record_s: f64,
        made: Option<&Estimation>,
    ) -> Self {
        let kernel = window.and_then(Window::kernel);
        let record = record_s * self.omega_max;
        let leakage =
            kernel.map(|kernel| Arc::new(Leakage::new(kernel, record, self.kind.omega_power())));
        let decay = decay_per_s.unwrap_or(0.0) * record_s;
        let errors = BlockErrors::new(window, made, decay, record);
        let blows = window.is_none() && made.is_some_and(Estimation::hann_on_blows);
        Self {
            window,
            hann_on_blows_s: blows.then_some(record_s),
            local_on_smooth_force: made.is_some_and(Estimation::local_on_smooth_force),
            unlike_h1: made
                .is_some_and(|made| matches!(made.estimator, Estimator::H2 | Estimator::Hv)),
            record_s,
            leakage,
            errors: errors.map(Arc::new),
            ..self
        }
    }

    /// True if the length of the records differs from the inverse of the line spacing: they were
    /// padded, or lines were thinned.
    pub fn is_padded(&self) -> bool {
        let cycles_per_spacing = self.record_s * self.line_spacing_hz();
        (cycles_per_spacing - 1.0).abs() > limits::OTHER_LENGTH
    }

    /// Only the lines at `kept` (positions among those used); the scale stays.
    pub fn select(&self, kept: &[usize]) -> Self {
        let select = |values: &[f64]| kept.iter().map(|&place| values[place]).collect();
        Self {
            lines: kept.iter().map(|&place| self.lines[place]).collect(),
            line_hz: select(&self.line_hz),
            x: select(&self.x),
            g: select(&self.g),
            line_variance: self.line_variance.map(select),
            energy: Arc::default(),
            ..self.clone()
        }
    }

    /// With the variance of lines that the set gives.
    pub fn with_line_variance(self, line_variance: Option<LineVariance>) -> Self {
        let Some(line_variance) = line_variance else {
            return self;
        };
        let record = TAU * self.hz() / self.line_spacing_hz();
        Self {
            errors: Some(Arc::new(BlockErrors::independent(record))),
            line_variance,
            ..self
        }
    }

    /// Variance of the errors of the line at x over that of the median line.
    pub fn variance_at(&self, x: f64) -> f64 {
        self.nearest(&self.line_variance.over_median, x)
            .unwrap_or(1.0)
    }

    /// Variance of the errors of the line at x over the power of its FRFs, if it is known.
    pub fn share_at(&self, x: f64) -> Option<f64> {
        self.nearest(&self.line_variance.over_power, x)
    }

    /// Part of the variance that FRFs share by the way they were estimated.
    ///
    /// * `share`: variance over power of the FRFs on this line
    pub fn shared_part(&self, share: f64) -> f64 {
        self.line_variance.shared_at(share)
    }

    /// The value of the line nearest to x; `None` without values.
    fn nearest(&self, values: &[f64], x: f64) -> Option<f64> {
        let last = values.len().checked_sub(1)?;
        let after = self.x.partition_point(|other| *other < x).min(last);
        let before = after.saturating_sub(1);
        let nearer = (self.x[after] - x).abs() < (self.x[before] - x).abs();
        Some(values[if nearer { after } else { before }])
    }

    /// Without the lines at `places` (among those used), which are outliers; with the places of the
    /// other lines.
    pub fn without(&self, places: &[usize]) -> (Self, Vec<usize>) {
        let kept: Vec<usize> = (0..self.lines.len())
            .filter(|place| !places.contains(place))
            .collect();
        let mut rest = self.select(&kept);
        rest.dropped_hz
            .extend(places.iter().map(|&place| self.line_hz[place]));
        rest.outlier_rounds += 1;
        (rest, kept)
    }

    /// Median distance of neighbouring lines, Hz.
    pub fn line_spacing_hz(&self) -> f64 {
        let mut gaps: Vec<f64> = self
            .line_hz
            .windows(2)
            .map(|pair| pair[1] - pair[0])
            .collect();
        gaps.sort_by(f64::total_cmp);
        gaps.get(gaps.len() / 2).copied().unwrap_or(0.0)
    }

    /// Mean square of the data, if the energies are known.
    pub fn mean_square(&self) -> f64 {
        self.energy.iter().sum::<f64>() / (self.lines.len() * self.pairs.len()) as f64
    }

    /// Decay of the exponential window of the responses, in units of ω_max; 0 without one.
    pub fn decay_of_window(&self, options: &FitOptions) -> f64 {
        options.exponential_window_per_s.unwrap_or(0.0) / self.omega_max
    }

    /// Frequency of x = 1, Hz.
    pub fn hz(&self) -> f64 {
        self.omega_max / TAU
    }

    /// Weights of response i and of reference j.
    pub fn weight(&self, i: usize, j: usize) -> [f64; 2] {
        self.weighting.as_ref().map_or([1.0; 2], |weighting| {
            [
                weighting.weights.response[i],
                weighting.weights.reference[j],
            ]
        })
    }

    /// Weight of an FRF: the product of both.
    pub fn weight_of(&self, (i, j): (usize, usize)) -> f64 {
        self.weight(i, j).iter().product()
    }

    /// Root mean square of the data as they were measured.
    pub fn measured_rms(&self) -> f64 {
        self.weighting
            .as_ref()
            .map_or(self.rms, |weighting| weighting.rms)
    }

    /// Root mean square of the measured data over that of the data used.
    pub fn measured_over_used(&self) -> f64 {
        match self.weighting {
            Some(_) => self.measured_rms() / self.rms,
            None => 1.0,
        }
    }

    /// Factor from a measured value to a work value: it undoes the phase of the kind, and brings the
    /// rms to one.
    pub fn factor(&self) -> Complex64 {
        let phase = self.kind.from_receptance(1.0);
        phase.conj() / (phase.norm() * self.rms)
    }

    /// The lines used, without data.
    pub fn axis(&self) -> Columns {
        self.columns(Array2::zeros((self.x.len(), 0)))
    }

    /// The lines used with data, (line, column).
    pub fn columns(&self, b: Array2<Complex64>) -> Columns {
        let on_lines = |leakage: &Arc<Leakage>| LeakingLines::new(leakage.clone(), &self.x);
        Columns {
            x: self.x.clone(),
            g: self.g.clone(),
            b,
            law: self.law,
            leakage: self.leakage.as_ref().map(on_lines),
            neighbours: self.neighbours,
        }
    }
}
