//! FRFs from time records: averaged spectra, the estimators H1, H2 and Hv, coherence, and
//! the variance of each line.
//!
//! The way of the data: channels that were measured together are a [`Run`]; `spectra` cuts
//! runs into windowed blocks and averages the products of their transforms; `estimators`
//! makes FRFs of the averages. Runs with the same references
//! belong together: one reference alone gives one column of the FRF matrix, several at
//! once give theirs together (multi-reference).
//!
//! J. Bendat, A. Piersol, *Random Data*, 4th ed. (2010), chapters 6, 7 and 9; P. Welch,
//! IEEE Trans. Audio Electroacoustics 15 (1967) 70–73; G. Rocklin, J. Crowley, H. Vold,
//! "A comparison of H1, H2 and Hv", IMAC 3 (1985).

mod estimators;
mod spectra;
mod window;

pub use window::BlockWindow;

use chladni_frf::{
    Dof, Error, FrfKind, FrfSet, FrfValues, Geometry, ReferenceUnit, Result, Run, SignalUnit,
};
use estimators::estimate_line;
use ndarray::{s, Array1, Array3};
use num_complex::Complex64;
use rayon::prelude::*;
use spectra::Averages;

/// Where the noise is thought to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Estimator {
    /// At the responses: least squares, biased low by noise at the references.
    #[default]
    H1,
    /// At the references: biased high by noise at the responses; one reference at a time.
    H2,
    /// At both, in proportion to their power: total least squares.
    Hv,
}

/// How FRFs are estimated.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EstimateOptions {
    /// Estimator.
    pub estimator: Estimator,
    /// Window; `None`: Hann for one long record, none for several short ones.
    pub window: Option<BlockWindow>,
    /// Samples of a block; `None`: the whole record where there are several, else so that
    /// about [`BLOCKS`] are averaged.
    pub block: Option<usize>,
    /// Overlap of blocks, 0 to 0.95; `None`: one half with a Hann window, else none.
    pub overlap: Option<f64>,
}

/// Averages that a single long record is cut into.
pub const BLOCKS: usize = 16;
/// Largest overlap: beyond it the blocks say nothing new.
pub const MOST_OVERLAP: f64 = 0.95;

/// What was estimated.
#[derive(Debug, Clone)]
pub struct Estimate {
    /// FRFs with their coherence (the multiple one where several references act at once)
    /// and their variance, NaN where too few blocks were averaged to say; lines from the
    /// first above 0 Hz to the last below half the sampling rate.
    pub frf: FrfSet,
    /// Blocks averaged, least and most of all FRFs.
    pub averages: [usize; 2],
    /// Window that was used.
    pub window: BlockWindow,
    /// Samples of a block.
    pub block: usize,
    /// Overlap of blocks.
    pub overlap: f64,
    /// What the user must know.
    pub warnings: Vec<String>,
}

/// FRFs of all runs.
///
/// # Errors
/// Runs of different sampling rates, without reference or response, of mixed kinds; fewer
/// blocks than references; a block longer than a record.
pub fn estimate(runs: &[Run], options: &EstimateOptions) -> Result<Estimate> {
    let first = runs.first().ok_or_else(|| {
        let error =
            Error::bad_data("no time record in the input").found("no function of type 1 (time)");
        error
            .expected("time records of references and responses")
            .help("`chladni info` lists what is inside")
    })?;
    let rate = first.sample_rate_hz;
    if let Some(other) = runs
        .iter()
        .find(|run| (run.sample_rate_hz / rate - 1.0).abs() > 1e-6)
    {
        return Err(Error::bad_data("records of different sampling rates")
            .file(&other.file)
            .field("sampling rate")
            .found(format!("{} Hz", other.sample_rate_hz))
            .expected(format!("{rate} Hz as in {}", first.file.display()))
            .help("estimate them apart"));
    }
    let setting = Setting::choose(runs, options)?;
    let step_hz = rate / setting.block as f64;
    let lines = 1..setting.block.div_ceil(2);
    let frequency_hz: Array1<f64> = lines.clone().map(|k| k as f64 * step_hz).collect();
    let (kind, reference_unit) = kind_of(runs)?;
    let unique = |of: fn(&Run) -> Vec<Dof>| {
        let mut dofs: Vec<Dof> = runs.iter().flat_map(of).collect();
        dofs.sort_unstable();
        dofs.dedup();
        dofs
    };
    let responses = unique(|run| run.responses().map(|channel| channel.dof).collect());
    let references = unique(|run| run.references().map(|channel| channel.dof).collect());
    let shape = (responses.len(), references.len(), lines.len());
    let nothing = Complex64::new(f64::NAN, f64::NAN);
    let mut result = Estimate {
        frf: FrfSet {
            frequency_hz,
            values: FrfValues::F64(Array3::from_elem(shape, nothing)),
            responses: responses.clone(),
            references: references.clone(),
            kind,
            reference_unit,
            coherence: Some(Array3::from_elem(shape, f32::NAN)),
            variance: Some(Array3::from_elem(shape, f64::NAN)),
            geometry: Geometry::default(),
        },
        averages: [usize::MAX, 0],
        window: setting.window,
        block: setting.block,
        overlap: setting.overlap,
        warnings: setting.warnings.clone(),
    };
    for group in groups(runs) {
        result.add_group(&group, &setting, options.estimator)?;
    }
    result.frf = result.frf.checked()?;
    Ok(result)
}

/// What the options leave open, decided.
struct Setting {
    window: BlockWindow,
    block: usize,
    overlap: f64,
    warnings: Vec<String>,
}

impl Setting {
    fn choose(runs: &[Run], options: &EstimateOptions) -> Result<Self> {
        let shortest = runs.iter().map(Run::samples).min().unwrap_or(0);
        let alone = groups(runs).iter().all(|group| group.len() == 1);
        let mut warnings = Vec::new();
        let window = options.window.unwrap_or(if alone {
            BlockWindow::Hann
        } else {
            BlockWindow::Rectangular
        });
        let overlap = options.overlap.unwrap_or(if window == BlockWindow::Hann {
            0.5
        } else {
            0.0
        });
        if !(0.0..=MOST_OVERLAP).contains(&overlap) {
            return Err(
                Error::new(chladni_frf::ErrorKind::Usage, "no possible overlap")
                    .field("--overlap")
                    .found(overlap)
                    .expected(format!("0 to {MOST_OVERLAP}")),
            );
        }
        let block = options.block.unwrap_or_else(|| {
            if !alone {
                return shortest;
            }
            let blocks = 1.0 + (BLOCKS as f64 - 1.0) * (1.0 - overlap);
            // even, so that half the sampling rate is a line
            (shortest as f64 / blocks) as usize / 2 * 2
        });
        if options.window.is_none() || options.block.is_none() {
            warnings.push(format!(
                "blocks of {block} samples, {} window, overlap {overlap}: --block, --window and \
                 --overlap choose others",
                window.name()
            ));
        }
        if block < 4 || block > shortest {
            return Err(Error::bad_data("no possible block")
                .field("--block")
                .found(format!("{block} samples"))
                .expected(format!(
                    "4 to {shortest}, the samples of the shortest record"
                ))
                .help("choose a shorter block"));
        }
        if let BlockWindow::Exponential { rate_per_s } = window {
            warnings.push(format!(
                "the exponential window adds {rate_per_s} 1/s to the decay of every mode: fit with \
                 --exponential-window {rate_per_s}, which takes it off"
            ));
        }
        Ok(Self {
            window,
            block,
            overlap,
            warnings,
        })
    }
}

/// Runs with the same references.
fn groups(runs: &[Run]) -> Vec<Vec<&Run>> {
    let mut groups: Vec<(Vec<Dof>, Vec<&Run>)> = Vec::new();
    for run in runs {
        let mut key: Vec<Dof> = run.references().map(|channel| channel.dof).collect();
        key.sort_unstable();
        match groups.iter_mut().find(|(known, _)| *known == key) {
            Some((_, group)) => group.push(run),
            None => groups.push((key, vec![run])),
        }
    }
    groups.into_iter().map(|(_, group)| group).collect()
}

/// Kind and unit of the reference, which all channels must agree on; `None` where units
/// are not known.
fn kind_of(runs: &[Run]) -> Result<(Option<FrfKind>, ReferenceUnit)> {
    let disagree = |what: &str, a: SignalUnit, b: SignalUnit, run: &Run| {
        Err(Error::bad_data(format!("{what} of different quantities"))
            .file(&run.file)
            .field("units")
            .found(b.name())
            .expected(a.name())
            .help("estimate them apart"))
    };
    let mut seen: [Option<SignalUnit>; 2] = [None, None];
    for run in runs {
        for channel in &run.channels {
            let slot = &mut seen[usize::from(channel.is_reference)];
            match *slot {
                Some(known) if known != channel.unit => {
                    return disagree(
                        if channel.is_reference {
                            "references"
                        } else {
                            "responses"
                        },
                        known,
                        channel.unit,
                        run,
                    )
                }
                _ => *slot = Some(channel.unit),
            }
        }
    }
    let unit = if seen[1] == Some(SignalUnit::Volt) {
        ReferenceUnit::Volt
    } else {
        ReferenceUnit::Newton
    };
    let kind = match (seen[0], seen[1]) {
        (Some(response), Some(SignalUnit::Force | SignalUnit::Volt)) => response.frf_kind(),
        _ => None,
    };
    Ok((kind, unit))
}

impl Estimate {
    fn add_group(&mut self, runs: &[&Run], setting: &Setting, estimator: Estimator) -> Result<()> {
        let references: Vec<Dof> = runs[0].references().map(|channel| channel.dof).collect();
        let file = &runs[0].file;
        let mut responses: Vec<Dof> = runs
            .iter()
            .flat_map(|run| run.responses().map(|channel| channel.dof))
            .collect();
        responses.sort_unstable();
        responses.dedup();
        if references.is_empty() || responses.is_empty() {
            return Err(
                Error::bad_data("a run without reference or without response")
                    .file(file)
                    .field("channels")
                    .found(format!(
                        "{} references and {} responses",
                        references.len(),
                        responses.len()
                    ))
                    .expected("at least one of each")
                    .help("name the reference channels with --references DOF,..."),
            );
        }
        if estimator == Estimator::H2 && references.len() > 1 {
            return Err(Error::new(
                chladni_frf::ErrorKind::Usage,
                "H2 is defined for one reference at a time",
            )
            .field("--estimator")
            .found(format!("{} references at once", references.len()))
            .expected("one")
            .help("use h1 or hv"));
        }
        let columns: Vec<usize> = references
            .iter()
            .filter_map(|dof| self.frf.references.iter().position(|known| known == dof))
            .collect();
        let done: Vec<(usize, Averages, Vec<estimators::LineEstimate>)> = responses
            .par_iter()
            .map(|response| {
                let averages = Averages::of(
                    runs,
                    &references,
                    *response,
                    setting.window,
                    setting.block,
                    setting.overlap,
                )?;
                if averages.blocks < references.len() {
                    return Err(Error::bad_data(
                        "fewer blocks than references: their FRFs cannot be told apart",
                    )
                    .file(file)
                    .field("--block")
                    .found(format!(
                        "{} blocks for {} references",
                        averages.blocks,
                        references.len()
                    ))
                    .expected("at least as many blocks as references, better ten times as many")
                    .help("choose a shorter --block, or measure more records"));
                }
                let lines = (0..averages.lines())
                    .map(|k| estimate_line(&averages, k, estimator))
                    .collect();
                let row = self
                    .frf
                    .responses
                    .iter()
                    .position(|known| known == response)
                    .unwrap_or_default();
                Ok((row, averages, lines))
            })
            .collect::<Result<_>>()?;
        let FrfValues::F64(values) = &mut self.frf.values else {
            return Ok(());
        };
        let (Some(coherence), Some(variance)) = (&mut self.frf.coherence, &mut self.frf.variance)
        else {
            return Ok(());
        };
        let mut dead = 0;
        for (row, averages, lines) in done {
            self.averages = [
                self.averages[0].min(averages.blocks),
                self.averages[1].max(averages.blocks),
            ];
            for (k, line) in lines.iter().enumerate() {
                dead += usize::from(line.frf.iter().any(|value| value.re.is_nan()));
                // one block is coherent with itself, whatever it holds
                let gamma = if averages.blocks > references.len() {
                    line.coherence as f32
                } else {
                    f32::NAN
                };
                for (j, &column) in columns.iter().enumerate() {
                    values[[row, column, k]] = line.frf[j];
                    variance[[row, column, k]] = line.variance[j];
                    coherence[[row, column, k]] = gamma;
                }
            }
            let all_missing = coherence
                .slice(s![row, .., ..])
                .iter()
                .all(|value| value.is_nan());
            if all_missing && averages.blocks <= references.len() {
                let warning =
                    "too few blocks were averaged for a coherence and a variance".to_owned();
                if !self.warnings.contains(&warning) {
                    self.warnings.push(warning);
                }
            }
        }
        if dead > 0 {
            self.warnings.push(format!(
                "{dead} lines have no power at a reference, or references that act as one: masked"
            ));
        }
        Ok(())
    }
}
