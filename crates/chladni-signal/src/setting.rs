//! Decisions on what the options leave open.

use super::excitation::{against_local_fits, forcing, is_continuous_random, misses_period};
use super::local_basis::wanted_lines;
use super::whole_record::{least_step, smooth_length, Grid};
use super::{EstimateOptions, BLOCKS, MOST_OVERLAP};
use crate::limits::{BURST_MOST, HANN_OVERLAP, LEAST_BLOCK};
use chladni_frf::{
    BlockWindow, Dof, Error, ErrorKind, Estimation, Estimator, Finding, Forcing, Result, Run,
};
use ndarray::Array1;
use std::collections::BTreeSet;

/// Setting of the estimation of FRFs.
pub(super) enum Setting {
    /// By averaged blocks.
    Blocks(BlockSetting),
    /// By local fits to the transform of whole records.
    Local(LocalSetting),
}

/// Averages of blocks.
pub(super) struct BlockSetting {
    pub estimator: Estimator,
    pub window: BlockWindow,
    pub block: usize,
    pub overlap: f64,
    pub warnings: Vec<Finding>,
}

/// Local fits.
pub(super) struct LocalSetting {
    pub estimator: Estimator,
    pub grid: Grid,
    /// Samples of the shortest transform.
    pub samples: usize,
    pub warnings: Vec<Finding>,
}

impl Setting {
    /// Decides, for records of one sampling rate.
    pub(super) fn choose(runs: &[Run], options: &EstimateOptions) -> Result<Self> {
        let for_blocks = options.window.is_some() || options.overlap.is_some();
        let estimator = match options.estimator {
            Some(estimator) => estimator,
            None if !for_blocks && is_for_lrm(runs, options.block) => Estimator::Lrm,
            None => Estimator::H1,
        };
        if !estimator.is_local() {
            return BlockSetting::choose(runs, options, estimator).map(Self::Blocks);
        }
        if for_blocks {
            return Err(Error::new(
                ErrorKind::Usage,
                format!("{estimator} takes neither window nor overlap"),
            )
            .field("estimator")
            .found(format!(
                "`estimator {estimator}` with `window` or `overlap`"
            ))
            .expected("one transform of the whole record")
            .help("leave them out, or take `estimator h1`"));
        }
        LocalSetting::choose(runs, options, estimator).map(Self::Local)
    }

    /// Frequencies of the FRFs, Hz.
    pub(super) fn frequency_hz(&self, sample_rate_hz: f64) -> Array1<f64> {
        match self {
            Self::Blocks(setting) => {
                let step_hz = sample_rate_hz / setting.block as f64;
                let lines = 1..setting.block.div_ceil(2);
                lines.map(|k| k as f64 * step_hz).collect()
            }
            Self::Local(setting) => (0..setting.grid.count)
                .map(|k| setting.grid.frequency_hz(k))
                .collect(),
        }
    }

    /// The estimation of the FRFs, before anything is averaged.
    pub(super) fn estimation(&self, sample_rate_hz: f64) -> Estimation {
        let averages = [0; 2];
        match self {
            Self::Blocks(setting) => {
                let block_s = setting.block as f64 / sample_rate_hz;
                Estimation {
                    estimator: setting.estimator,
                    window: setting.window,
                    forcing: None,
                    transform_s: block_s,
                    gate_s: block_s,
                    hop_s: setting.hop() as f64 / sample_rate_hz,
                    averages,
                    lines_per_value: 1,
                }
            }
            Self::Local(setting) => {
                let record_s = setting.samples as f64 / sample_rate_hz;
                Estimation {
                    estimator: setting.estimator,
                    window: BlockWindow::Rectangular,
                    forcing: None,
                    transform_s: record_s,
                    gate_s: record_s,
                    hop_s: record_s,
                    averages,
                    lines_per_value: setting.grid.lines_per_value(record_s),
                }
            }
        }
    }

    /// Course of the force over a block; of a local method only one that it cannot bear.
    pub(super) fn forcing(&self, runs: &[Run]) -> Option<Forcing> {
        match self {
            Self::Blocks(setting) => forcing(runs, setting.block),
            Self::Local(_) => against_local_fits(runs),
        }
    }

    /// The finding of blocks that do not hold whole periods of a force that repeats.
    pub(super) fn block_not_a_period(&self, runs: &[Run]) -> Option<Finding> {
        let Self::Blocks(setting) = self else {
            return None;
        };
        let dof = misses_period(runs, setting.block)?;
        let words = format!(
            "the force at {dof} repeats, but not after a block of {} samples: its lines leak into \
             each other, and damping comes out wrong",
            setting.block
        );
        let finding = Finding::caution("block-not-a-period", words).dofs([dof]);
        Some(finding.help("set `block` to the period of the force in samples, or a multiple of it"))
    }

    pub(super) fn warnings(&self) -> &[Finding] {
        match self {
            Self::Blocks(setting) => &setting.warnings,
            Self::Local(setting) => &setting.warnings,
        }
    }
}

/// True where every response was measured once, in a record long enough, under continuous
/// random excitation.
fn is_for_lrm(runs: &[Run], block: Option<usize>) -> bool {
    let (samples, wanted) = for_local_fits(runs);
    let is_long = block.is_none_or(|block| block <= samples / least_step(wanted));
    let is_random = |run: &Run| {
        run.references().count() > 0
            && run
                .references()
                .all(|channel| is_continuous_random(&channel.samples))
    };
    is_long && measured_once(runs) && runs.iter().all(is_random)
}

/// Samples of the shortest transform, and the lines that a local fit wants.
fn for_local_fits(runs: &[Run]) -> (usize, usize) {
    let samples = runs.iter().map(|run| smooth_length(run.samples())).min();
    let wanted = |run: &Run| wanted_lines(run.references().count());
    let wanted = runs.iter().map(wanted).max();
    (samples.unwrap_or(0), wanted.unwrap_or(0))
}

/// True where each response was measured once under each of its references.
fn measured_once(runs: &[Run]) -> bool {
    groups(runs).iter().all(|group| {
        let mut seen = BTreeSet::new();
        let responses = group.iter().flat_map(|run| run.responses());
        responses
            .map(|channel| channel.dof)
            .all(|dof| seen.insert(dof))
    })
}

/// True where records are cut into blocks rather than averaged as they are. `block`: samples of the
/// shortest record, or those asked for.
fn is_cut(runs: &[Run], block: usize) -> bool {
    let groups = groups(runs);
    let can_be_whole = groups
        .iter()
        .all(|group| group.len() >= group[0].references().count());
    match forcing(runs, block) {
        Some(Forcing::Continuous) => measured_once(runs),
        // a blow or a burst ends before its record
        Some(Forcing::Transient) => !can_be_whole,
        Some(Forcing::Burst { part }) if part < BURST_MOST => !can_be_whole,
        _ => groups.iter().all(|group| group.len() == 1),
    }
}

impl LocalSetting {
    fn choose(runs: &[Run], options: &EstimateOptions, estimator: Estimator) -> Result<Self> {
        let (samples, wanted) = for_local_fits(runs);
        let rate = runs[0].sample_rate_hz;
        if let Some(block) = options.block.filter(|block| *block < LEAST_BLOCK) {
            return Err(no_block(block, samples));
        }
        let least = 2 * least_step(wanted) + wanted;
        if samples < least {
            return Err(Error::bad_data("no record for local fits")
                .field("samples")
                .found(format!("{samples} samples in the shortest record"))
                .expected(format!("at least {least} samples"))
                .help("measure a longer record, or take `estimator h1`"));
        }
        let grid = match options.block {
            Some(block) => Grid::new(rate / block as f64, wanted, samples, rate)?,
            None => Grid::finest(wanted, samples, rate)?,
        };
        let mut warnings = Vec::new();
        if options.estimator.is_none() {
            let words = format!(
                "continuous random excitation: estimated by {estimator}, lines {:.4} Hz apart",
                grid.step_hz
            );
            warnings.push(
                Finding::note("estimator-chosen", words)
                    .help("`estimator h1` averages blocks instead"),
            );
        }
        Ok(Self {
            estimator,
            grid,
            samples,
            warnings,
        })
    }
}

impl BlockSetting {
    /// Samples from the start of one block to that of the next.
    pub(super) fn hop(&self) -> usize {
        ((self.block as f64 * (1.0 - self.overlap)).round() as usize).max(1)
    }

    fn choose(runs: &[Run], options: &EstimateOptions, estimator: Estimator) -> Result<Self> {
        let shortest = runs.iter().map(Run::samples).min().unwrap_or(0);
        let cut = is_cut(runs, options.block.unwrap_or(shortest).max(1));
        let mut warnings = Vec::new();
        let window = options.window.unwrap_or(if cut {
            BlockWindow::Hann
        } else {
            BlockWindow::Rectangular
        });
        let overlap = options.overlap.unwrap_or(if window == BlockWindow::Hann {
            HANN_OVERLAP
        } else {
            0.0
        });
        if !(0.0..=MOST_OVERLAP).contains(&overlap) {
            return Err(Error::new(ErrorKind::Usage, "no possible overlap")
                .field("overlap")
                .found(overlap)
                .expected(format!("0 to {MOST_OVERLAP}"))
                .help("write a part of the block within that: 0.5 is half of it"));
        }
        let block = options.block.unwrap_or_else(|| {
            if !cut {
                return shortest;
            }
            // more overlap than a half gives more blocks, not longer ones
            let blocks = 1.0 + (BLOCKS as f64 - 1.0) * (1.0 - overlap.min(0.5));
            // even, so that half the sampling rate is a line
            (shortest as f64 / blocks) as usize / 2 * 2
        });
        if options.window.is_none() || options.block.is_none() {
            let words = format!(
                "blocks of {block} samples, {} window, overlap {overlap:.2}",
                window.name()
            );
            warnings.push(
                Finding::note("blocks-chosen", words)
                    .help("`block`, `window` and `overlap` choose others"),
            );
        }
        if block < LEAST_BLOCK || block > shortest {
            return Err(no_block(block, shortest));
        }
        if let BlockWindow::Exponential { rate_per_s } = window {
            warnings.push(adds_damping(rate_per_s));
        }
        Ok(Self {
            estimator,
            window,
            block,
            overlap,
            warnings,
        })
    }
}

fn no_block(block: usize, shortest: usize) -> Error {
    // a block that is too long may fit another record; one that is too short fits none
    let kind = match block < LEAST_BLOCK && shortest >= LEAST_BLOCK {
        true => ErrorKind::Usage,
        false => ErrorKind::BadData,
    };
    let error = Error::new(kind, "no possible block");
    match shortest < LEAST_BLOCK {
        true => error
            .field("record")
            .found(format!("{shortest} samples in the shortest record"))
            .expected(format!("records of {LEAST_BLOCK} samples or more"))
            .help("measure a longer record"),
        false => error
            .field("block")
            .found(format!("{block} samples"))
            .expected(format!(
                "{LEAST_BLOCK} to {shortest}, the samples of the shortest record"
            ))
            .help("choose a block within that"),
    }
}

/// The warning about an exponential window.
fn adds_damping(rate_per_s: f64) -> Finding {
    let words = format!("the exponential window adds {rate_per_s} 1/s to the decay of every mode");
    Finding::caution("window-adds-damping", words)
        .value("decay_per_s", rate_per_s)
        .help(format!(
            "a fit of the set takes it off; where a file does not carry it, say \
             `exponential_window {rate_per_s}`"
        ))
}

/// Runs with the same references.
pub(super) fn groups(runs: &[Run]) -> Vec<Vec<&Run>> {
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
