//! Values of all FRFs while they are estimated.

use super::clipped::clipped;
use super::contradictions::{self, Contradiction};
use super::force_noise::Correction;
use super::setting::Setting;
use super::still::{self, is_still, moving, still_in_some};
use super::{blows, unheard, units, Estimate, Group};
use chladni_frf::{
    Dof, Error, Estimation, Finding, Forcing, FrfSet, FrfValues, Geometry, Result, Run, SignalUnit,
};
use ndarray::{s, Array3, Axis};
use num_complex::Complex64;
use std::collections::BTreeSet;

/// Axes (response, reference, line); NaN where nothing was measured.
pub(super) struct Table {
    values: Array3<Complex64>,
    variance: Array3<f64>,
    coherence: Array3<f32>,
    responses: Vec<Dof>,
    references: Vec<Dof>,
    averages: [usize; 2],
    warnings: Vec<Finding>,
    /// Lines on which a response got no value.
    masked: BTreeSet<usize>,
    contradictions: Vec<Contradiction>,
    /// Responses with a coherence above chance under some references.
    heard: BTreeSet<Dof>,
    /// Responses without one under some references.
    unheard: BTreeSet<Dof>,
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
            masked: BTreeSet::new(),
            contradictions: Vec::new(),
            heard: BTreeSet::new(),
            unheard: BTreeSet::new(),
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

    /// Notes a line on which a response got no value.
    pub(super) fn mask(&mut self, line: usize) {
        self.masked.insert(line);
    }

    /// Notes blocks that contradict others.
    pub(super) fn contradict(&mut self, contradictions: Vec<Contradiction>) {
        self.contradictions.extend(contradictions);
    }

    /// Notes whether the coherence of a response is above chance.
    pub(super) fn hear(&mut self, response: Dof, is_heard: bool) {
        let responses = match is_heard {
            true => &mut self.heard,
            false => &mut self.unheard,
        };
        responses.insert(response);
    }

    pub(super) fn warn_once(&mut self, warning: Finding) {
        if !self.warnings.contains(&warning) {
            self.warnings.push(warning);
        }
    }

    /// The finding on lines without values.
    ///
    /// # Errors
    /// No line has any.
    fn masked_lines(&self, runs: &[Run]) -> Result<Option<Finding>> {
        if self.masked.is_empty() {
            return Ok(None);
        }
        let dead: BTreeSet<Dof> = runs
            .iter()
            .flat_map(|run| run.references().filter(|channel| is_still(channel)))
            .map(|channel| channel.dof)
            .collect();
        let why = match dead.first() {
            Some(dof) => format!("the reference {dof} is constant"),
            None => "references without power, or that act as one".into(),
        };
        let help = "leave that channel out, or drive the references independently of each other";
        if self.values.iter().all(|value| value.is_nan()) {
            return Err(Error::bad_data("the references tell no FRF")
                .field("references")
                .found(why)
                .expected("references with a signal of their own")
                .help(help));
        }
        let (masked, all) = (self.masked.len(), self.values.len_of(Axis(2)));
        let words = format!("{masked} of {all} lines lack values of some responses: {why}");
        let finding = Finding::caution("lines-without-power", words);
        Ok(Some(finding.dofs(dead).help(help)))
    }

    /// Leaves out responses that are constant in every run: what removing the mean has left of them
    /// is rounding. Returns the finding that names them.
    ///
    /// # Errors
    /// No response moves.
    fn without_still(&mut self, runs: &[Run]) -> Result<Option<Finding>> {
        let moving: BTreeSet<Dof> = runs
            .iter()
            .flat_map(moving)
            .map(|channel| channel.dof)
            .collect();
        self.warnings.extend(still_in_some(runs, &moving));
        let (kept, dofs): (Vec<Dof>, Vec<Dof>) =
            self.responses.iter().partition(|dof| moving.contains(dof));
        let Some(first) = dofs.first() else {
            return Ok(None);
        };
        if moving.is_empty() {
            return Err(Error::bad_data("no response moves")
                .field("responses")
                .found("constant samples in every channel")
                .expected("at least one response with a signal")
                .help(still::HELP));
        }
        let rows: Vec<usize> = kept.iter().map(|&dof| self.row(dof)).collect();
        self.values = self.values.select(Axis(0), &rows);
        self.variance = self.variance.select(Axis(0), &rows);
        self.coherence = self.coherence.select(Axis(0), &rows);
        self.responses = kept;
        let words = match dofs.len() {
            1 => format!("the response {first} is constant, and left out"),
            count => format!("{count} responses are constant, and left out; the first is {first}"),
        };
        let finding = Finding::caution("still-responses", words);
        Ok(Some(finding.dofs(dofs).help(still::HELP)))
    }

    /// The FRFs, and how they were made.
    pub(super) fn finished(
        mut self,
        runs: &[Run],
        setting: &Setting,
        rate_hz: f64,
    ) -> Result<Estimate> {
        self.warnings.extend(self.masked_lines(runs)?);
        let still = self.without_still(runs)?;
        self.warnings.extend(still);
        self.warnings.extend(idle(runs));
        self.warnings.extend(setting.block_not_a_period(runs));
        self.warnings.extend(clipped(runs));
        let differ = contradictions::finding(&self.contradictions);
        self.warnings.extend(differ);
        let unheard = &self.unheard - &self.heard;
        self.warnings.extend(unheard::finding(&unheard));
        let (kind, reference_unit) = units::kind_of(runs)?;
        let estimation = Estimation {
            averages: self.averages,
            forcing: setting.forcing(runs),
            ..setting.estimation(rate_hz)
        };
        if let (Setting::Blocks(setting), Some(Forcing::Transient)) = (setting, estimation.forcing)
        {
            self.warnings.extend(blows::cut_off(runs, setting.block));
        }
        if estimation.hann_on_blows() {
            self.warnings.push(hann_on_blows());
        }
        if estimation.local_on_smooth_force() {
            self.warnings.push(local_on_smooth_force());
        }
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

/// The finding that names drives which neither excite nor answer.
fn idle(runs: &[Run]) -> Option<Finding> {
    let channels = || runs.iter().flat_map(Run::idle);
    let first = channels().next()?;
    let dofs: BTreeSet<Dof> = channels().map(|channel| channel.dof).collect();
    let (what, at) = (first.unit.name(), first.dof);
    let words = match dofs.len() {
        1 => format!("the {what} at {at} is no reference, and left out"),
        count => {
            format!("{count} drives are no reference, and left out; the first is {what} at {at}")
        }
    };
    // a force that acts without being counted is in the responses all the same, and a voltage
    // elsewhere may be a sensor without a unit
    let of_references: BTreeSet<Dof> = runs
        .iter()
        .flat_map(Run::references)
        .map(|channel| channel.dof)
        .collect();
    let acts = channels().any(|channel| {
        let is_beside = channel.unit == SignalUnit::Volt && of_references.contains(&channel.dof);
        !is_beside && !is_still(channel)
    });
    let finding = match acts {
        true => Finding::caution("drives-left-out", words).help(
            "name each force that acts in `references`: what the others move counts as noise; say \
                 the unit of a sensor in `units`",
        ),
        false => Finding::note("drives-left-out", words),
    };
    Some(finding.dofs(dofs))
}

/// The finding of blows, or sweeps, under a Hann window.
fn hann_on_blows() -> Finding {
    let words =
        "a Hann window on blows or sweeps weighs early and late parts of a response unlike: \
                 it broadens every line and sets others beside it, so that one mode looks like \
                 several";
    Finding::caution("hann-on-blows", words).help(
        "say `window rectangular`, or exponential where responses do not die out, with a record of \
         its own for each blow",
    )
}

/// The finding of local fits to a force that they cannot bear.
fn local_on_smooth_force() -> Finding {
    let words = "local fits need a force that is noise through the whole record: with blows, sweeps \
                 and short bursts neighbouring lines of the force are alike, and leakage looks like \
                 the response; of a force that repeats most lines have none";
    Finding::caution("local-on-smooth-force", words)
        .help("say `estimator h1`, with a record of its own for each blow, sweep or period")
}
