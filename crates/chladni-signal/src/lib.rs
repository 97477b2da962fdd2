//! FRFs from time records: the estimators H1, H2 and Hv of averaged spectra, local fits to
//! the transform of a whole record, coherence, and the variance of each line.
//!
//! ```
//! use chladni_frf::{Channel, Run, SignalUnit};
//! use chladni_signal::{estimate, EstimateOptions};
//!
//! # let mut state = 1_u64;
//! # let mut noise = || {
//! #     state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
//! #     (state >> 33) as f64 / (1_u64 << 30) as f64 - 1.0
//! # };
//! # let force: Vec<f64> = (0..4096).map(|_| noise()).collect();
//! # let velocity: Vec<f64> = force.iter().map(|force| 0.5 * force).collect();
//! let channel = |dof: &str, unit, is_reference, samples| -> Result<_, Box<dyn std::error::Error>> {
//!     Ok(Channel { dof: dof.parse()?, unit, is_reference, samples })
//! };
//! let run = Run {
//!     file: "run.wav".into(),
//!     line: 0,
//!     sample_rate_hz: 1000.0,
//!     channels: vec![
//!         channel("101:+Z", SignalUnit::Force, true, force)?,
//!         channel("1:+Z", SignalUnit::Velocity, false, velocity)?,
//!     ],
//! };
//! let frf = estimate(&[run], &EstimateOptions::default())?.frf; // with coherence and variance
//! assert!((frf.values.get(0, 0, 100).re - 0.5).abs() < 1e-6);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | you have | you call | you get |
//! |---|---|---|
//! | time records as [`Run`]s | [`estimate()`] with [`EstimateOptions`] | [`Estimate`]: an `FrfSet`, how it was made, findings |
//!
//! Errors are [`chladni_frf::Error`]; the feature `system` computes with LAPACK.
//!
//! The way of the data: channels that were measured together are a [`Run`]; runs with the
//! same references belong together: one reference alone gives one column of the FRF
//! matrix, several at once give theirs together (multi-reference). `setting` decides what
//! the options leave open, for which `excitation` tells continuous random records.
//!
//! * Averages: `spectra` cuts runs into windowed blocks and averages the products of their
//!   transforms; `estimators` makes FRFs of the averages. `takes` keeps the strongest lines of each
//!   block, by which `runs_differ` finds blocks that contradict the others.
//! * Local fits: `whole_record` transforms a record in one piece and gives each frequency the lines
//!   about it; `lpm` and `lrm` fit polynomials and rational functions to them (both on the columns
//!   of `local_basis`), in which leakage is an unknown like others, not an error. `force_noise`
//!   undoes what noise in the record of the force takes from them.
//!
//! J. Bendat, A. Piersol, *Random Data*, 4th ed. (2010), chapters 6, 7 and 9; P. Welch,
//! IEEE Trans. Audio Electroacoustics 15 (1967) 70–73; G. Rocklin, J. Crowley, H. Vold,
//! "A comparison of H1, H2 and Hv", IMAC 3 (1985).

mod blocks;
mod blows;
mod clipped;
mod contradictions;
mod estimators;
mod excitation;
mod force_noise;
mod limits;
mod local;
mod local_basis;
mod lpm;
mod lrm;
mod runs_differ;
mod setting;
mod spectra;
mod still;
mod table;
mod takes;
mod unheard;
mod units;
mod whole_record;
mod window;

use chladni_frf::{
    BlockWindow, Channel, Dof, Error, Estimation, Estimator, Finding, FrfSet, Result, Run,
};
use limits::{SAME_RATE, SAME_SAMPLES};
use setting::{groups, Setting};
use std::collections::{BTreeMap, BTreeSet};
use still::moving;
use table::Table;

/// Settings of the estimation of FRFs.
///
/// Averages take each record as one block, or cut it into several. Under continuous random
/// excitation records are cut if each response was measured once. Under a force that ends before
/// its record they are cut if there are fewer runs than references. Under any other force they are
/// cut if every set of references was measured in one run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EstimateOptions {
    /// Estimator; `None`: [`Estimator::Lrm`] for long records of continuous random
    /// excitation where neither window nor overlap is given, else [`Estimator::H1`].
    pub estimator: Option<Estimator>,
    /// Window; `None`: Hann where records are cut into blocks, else none.
    pub window: Option<BlockWindow>,
    /// Samples of a block; `None`: where records are cut, so that about [`BLOCKS`] half-overlapped
    /// blocks fill the shortest, else the whole of it. With a local method the sampling rate over
    /// the distance of lines; `None`: as fine as the shortest record allows.
    pub block: Option<usize>,
    /// Overlap of blocks, 0 to 0.95; `None`: two thirds with a Hann window, else none.
    pub overlap: Option<f64>,
}

/// Half-overlapped blocks that the shortest record is cut into.
pub const BLOCKS: usize = 16;
/// Largest overlap: beyond it the blocks say nothing new.
pub const MOST_OVERLAP: f64 = 0.95;

/// The result of an estimation.
#[derive(Debug, Clone)]
#[must_use]
#[non_exhaustive]
pub struct Estimate {
    /// FRFs with their coherence (the multiple one where several references act at once)
    /// and their variance, NaN where too few blocks were averaged to say; lines from the
    /// first above 0 Hz to the last below half the sampling rate.
    pub frf: FrfSet,
    /// Their estimation; `frf` carries the same.
    pub estimation: Estimation,
    /// Everything the user should know.
    pub findings: Vec<Finding>,
}

/// FRFs of all runs.
///
/// # Errors
/// Runs of different sampling rates, without reference or response, of mixed kinds; samples that are
/// not finite; a DOF of two channels of one side; fewer blocks than references; a block longer than a
/// record; too few lines for a local fit.
pub fn estimate(runs: &[Run], options: &EstimateOptions) -> Result<Estimate> {
    let rate = common_rate(runs)?;
    runs.iter().try_for_each(check_channels)?;
    let groups = groups(runs);
    let groups: Vec<Group> = groups.iter().map(|runs| Group::new(runs)).collect();
    groups.iter().try_for_each(Group::check)?;
    refuse_shared_pairs(&groups)?;
    let setting = Setting::choose(runs, options)?;
    units::kind_of(runs)?;
    let mut table = Table::new(runs, &setting, setting.frequency_hz(rate).len());
    for group in &groups {
        match &setting {
            Setting::Blocks(setting) => blocks::add_group(&mut table, group, setting)?,
            Setting::Local(setting) => local::add_group(&mut table, group, setting),
        }
    }
    table.finished(runs, &setting, rate)
}

/// Refuses samples that are not finite, and a DOF that two channels of one side have.
fn check_channels(run: &Run) -> Result<()> {
    let wrong = |message: &str, dof: Dof| {
        Error::bad_data(message)
            .file(&run.file)
            .field(format!("channel {dof}"))
    };
    let finite = |channel: &&Channel| channel.samples.iter().all(|sample| sample.is_finite());
    let used = || run.references().chain(run.responses());
    if let Some(channel) = used().find(|channel| !finite(channel)) {
        let at = channel
            .samples
            .iter()
            .position(|sample| !sample.is_finite());
        let at = at.unwrap_or_default();
        return Err(wrong("a sample that is not finite", channel.dof)
            .found(format!("{} at sample {}", channel.samples[at], at + 1))
            .expected("finite samples without gaps")
            .help("cut the record, or leave this run or channel out"));
    }
    let twice = |side: Vec<Dof>| {
        let mut seen = BTreeSet::new();
        side.into_iter().find(|dof| !seen.insert(*dof))
    };
    let references = run.references().map(|channel| channel.dof).collect();
    let responses = run.responses().map(|channel| channel.dof).collect();
    match twice(references).or_else(|| twice(responses)) {
        None => Ok(()),
        Some(dof) => Err(wrong("a DOF occurs twice", dof)
            .found("two channels")
            .expected("each DOF once among the references, and once among the responses")
            .help("give the second channel a DOF of its own, or leave it out")),
    }
}

/// Refuses a pair that was measured under several sets of references: neither of its FRFs is better.
fn refuse_shared_pairs(groups: &[Group]) -> Result<()> {
    let mut seen: BTreeMap<(Dof, Dof), &Group> = BTreeMap::new();
    for group in groups {
        for &reference in &group.references {
            for &response in &group.responses {
                let Some(other) = seen.insert((response, reference), group) else {
                    continue;
                };
                let all = |group: &Group| {
                    let names: Vec<String> = group.references.iter().map(Dof::to_string).collect();
                    names.join(", ")
                };
                return Err(Error::bad_data("one FRF of different sets of references")
                    .file(&group.runs[0].file)
                    .field(format!("response {response}, reference {reference}"))
                    .found(format!("records under {}", all(group)))
                    .expected(format!(
                        "records under {}, as in {}",
                        all(other),
                        other.runs[0].file.display()
                    ))
                    .help("estimate them apart"));
            }
        }
    }
    Ok(())
}

/// Sampling rate of all runs, Hz.
fn common_rate(runs: &[Run]) -> Result<f64> {
    let first = runs.first().ok_or_else(|| {
        let error =
            Error::bad_data("no time record in the input").found("no function of type 1 (time)");
        error
            .expected("time records of references and responses")
            .help("look at the contents of the file")
    })?;
    let rate = first.sample_rate_hz;
    let differs = |run: &&Run| {
        let samples = run.samples().min(first.samples());
        let most = SAME_RATE.max(SAME_SAMPLES / samples.max(1) as f64);
        (run.sample_rate_hz / rate - 1.0).abs() > most
    };
    match runs.iter().find(differs) {
        None => Ok(rate),
        Some(other) => Err(Error::bad_data("records of different sampling rates")
            .file(&other.file)
            .field("sampling rate")
            .found(format!("{} Hz", other.sample_rate_hz))
            .expected(format!("{rate} Hz as in {}", first.file.display()))
            .help("estimate them apart, or write times with more digits")),
    }
}

/// Runs with the same references.
struct Group<'a> {
    runs: &'a [&'a Run],
    references: Vec<Dof>,
    /// Those that move in at least one run.
    responses: Vec<Dof>,
}

impl<'a> Group<'a> {
    fn new(runs: &'a [&'a Run]) -> Self {
        Self {
            runs,
            references: runs[0].references().map(|channel| channel.dof).collect(),
            responses: unique(runs.iter().flat_map(|run| moving(run)).map(|c| c.dof)),
        }
    }

    fn check(&self) -> Result<()> {
        let responses = self.runs.iter().flat_map(|run| run.responses()).count();
        if !self.references.is_empty() && responses > 0 {
            return Ok(());
        }
        Err(
            Error::bad_data("a run without reference or without response")
                .file(&self.runs[0].file)
                .field("channels")
                .found(format!(
                    "{} references and {responses} responses",
                    self.references.len()
                ))
                .expected("at least one of each")
                .help(match self.references.is_empty() {
                    true => {
                        "name the reference channels with `references DOF,...`; give each channel \
                         of a record a DOF of its own (one that comes again begins another record); \
                         of a file without DOFs and units (WAV) name all channels, in their order, \
                         with `dofs`, `units` and `scales`"
                    }
                    false => {
                        "give the responses of the same take as channels beside the references"
                    }
                }),
        )
    }
}

/// Sorted, each once.
fn unique(dofs: impl Iterator<Item = Dof>) -> Vec<Dof> {
    let mut dofs: Vec<Dof> = dofs.collect();
    dofs.sort_unstable();
    dofs.dedup();
    dofs
}
