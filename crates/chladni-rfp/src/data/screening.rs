//! Screening: the choice of lines and FRFs, and their scale (theory.md, eq. 5).

use crate::data::columns::Columns;
use crate::data::error::FitError;
use crate::data::layout::DataLayout;
use crate::data::limits;
use crate::data::line_variance::line_variance;
use crate::data::noisy_frfs::far_noisier;
use crate::data::options::{FitOptions, Method};
use crate::data::reading::{energy, visit, Usable};
use crate::data::sketch::{Mixing, Sums};
use crate::data::window::of_set::record_s;
use chladni_frf::{Dof, Finding, FrfSet};
use ndarray::{Array2, ArrayView1, ShapeBuilder};
use num_complex::Complex64;
use rayon::prelude::*;
use std::ops::{Deref, Range};
use std::sync::{Arc, RwLock};

/// The usable part of an FRF set: selected lines and pairs, unit rms, no copy of the
/// data.
#[derive(Debug, Clone)]
pub(crate) struct Screened<'a> {
    pub layout: DataLayout,
    /// The data as they were measured. Weights are applied as they are read.
    pub frf: &'a FrfSet,
    /// The first pass, if it is made already.
    pub first_pass: FirstPass,
}

/// The first pass over a set, with its seed, until it is freed. Clones share it. If it is needed after
/// that, it is made again.
#[derive(Debug, Clone, Default)]
pub(crate) struct FirstPass(Arc<RwLock<Option<(u64, Sums)>>>);

impl FirstPass {
    pub fn new(made: Option<(u64, Sums)>) -> Self {
        Self(Arc::new(RwLock::new(made)))
    }

    /// The value that `take` makes of the pass with this `seed`; `None` if there is no such pass.
    pub fn of<T>(&self, seed: u64, take: impl FnOnce(&Sums) -> T) -> Option<T> {
        let held = self.0.read().ok()?;
        let (held_seed, sums) = held.as_ref()?;
        (*held_seed == seed).then(|| take(sums))
    }

    /// The pass of the lines `kept` alone.
    pub fn select(&self, kept: &[usize]) -> Self {
        let held = self.0.read().ok();
        let held = held.as_ref().and_then(|held| held.as_ref());
        Self::new(held.map(|(seed, sums)| (*seed, sums.select(kept))))
    }

    /// Frees the memory of the pass.
    pub fn end(&self) {
        if let Ok(mut held) = self.0.write() {
            *held = None;
        }
    }
}

impl Deref for Screened<'_> {
    type Target = DataLayout;
    fn deref(&self) -> &DataLayout {
        &self.layout
    }
}

impl<'a> Screened<'a> {
    /// Selects band, lines and pairs.
    ///
    /// # Errors
    /// An unknown kind, a band outside the data or too narrow, too few lines, nothing but zeros,
    /// an implausible scale, a window whose record length the lines do not tell.
    pub fn new(frf: &'a FrfSet, options: &FitOptions) -> Result<Self, FitError> {
        let kind = frf.kind.ok_or(FitError::UnknownKind)?;
        let (mut lines, [low, high]) = lines_in_band(frf.frequency_hz.view(), options.band_hz)?;
        let mut warnings = Vec::new();
        let all: Vec<(usize, usize)> = frf.all_pairs().collect();
        let sums = first_pass_of_complete_set(frf, &all, &lines, options);
        let Usable {
            mut pairs,
            left_out,
            bad,
            lost,
            energy: sum_of_pair,
        } = match &sums {
            Some(sums) => Usable::all(all, lines.len(), sums.frf_energy.clone()),
            None => {
                let needs_whole_matrix = options.method == Method::Plscf;
                Usable::new(frf, &lines, needs_whole_matrix)
            }
        };
        if pairs.is_empty() {
            return Err(FitError::NoData);
        }
        let empty = frf.pairs() - pairs.len() - left_out.len();
        if empty > 0 {
            warnings.push(without_values(empty, frf.pairs()));
        }
        if !left_out.is_empty() {
            warnings.push(incomplete(frf, &Vec::from_iter(left_out)));
        }
        warnings.extend(drop_bad(&mut lines, &bad, lost));
        warnings.extend(drop_noisy(&mut pairs, frf, &lines));
        check_lines(lines.len(), [low, high], options.modes)?;
        let line_variance = line_variance(frf, &pairs, &lines);
        let mut layout = DataLayout {
            pairs: pairs.into(),
            warnings,
            ..DataLayout::new(frf, kind, lines, [low, high], options.effort)
                .windowed(
                    options.window,
                    options.exponential_window_per_s,
                    record_s(frf, options)?,
                    frf.estimation.as_ref(),
                )
                .with_line_variance(line_variance)
        };
        layout.energy = energies(frf, &layout, bad.contains(&true), &sum_of_pair).into();
        layout.rms = layout.mean_square().sqrt();
        check_scale(layout.rms)?;
        let sums = sums
            .filter(|sums| sums.frf_energy.len() == layout.pairs.len())
            .map(|sums| (options.seed, sums));
        Ok(Self {
            layout,
            frf,
            first_pass: FirstPass::new(sums),
        })
    }

    /// A part of the data, with lines, pairs and scale that were chosen for all.
    pub fn part(frf: &'a FrfSet, layout: DataLayout) -> Self {
        Self {
            layout,
            frf,
            first_pass: FirstPass::default(),
        }
    }

    /// Values of the FRFs `pairs[columns]` on the lines `lines[rows]`, weighted and in work units:
    /// (line, column).
    pub fn block(&self, columns: Range<usize>, rows: Range<usize>) -> Array2<Complex64> {
        let factor = self.factor();
        let lines = &self.lines[rows];
        let mut out = Array2::zeros((lines.len(), columns.len()).f());
        for (mut column, &pair) in out.columns_mut().into_iter().zip(&self.pairs[columns]) {
            let weight = self.weight_of(pair);
            visit(
                &self.frf.values,
                pair,
                lines,
                column.iter_mut(),
                |out, value| *out = value * weight * factor,
            );
        }
        out
    }

    /// All columns at once; for sets of few FRFs.
    pub fn work(&self) -> Columns {
        self.columns(self.block(0..self.pairs.len(), 0..self.lines.len()))
    }
}

/// The first pass over a set without missing values, which is the usual case: it replaces the search
/// for missing values. `None` if some are missing, or for few FRFs.
fn first_pass_of_complete_set(
    frf: &FrfSet,
    all: &[(usize, usize)],
    lines: &[usize],
    options: &FitOptions,
) -> Option<Sums> {
    let width = options.effort.sketch_columns.max(1);
    let sums = (all.len() > width).then(|| {
        let mixing = Mixing::even(all.len(), width, options.seed);
        Sums::new(&frf.values, all, lines, &mixing, None)
    });
    sums.filter(|sums| !sums.flawed)
}

/// Takes `bad` lines out; the finding says how many.
///
/// * `lost`: number of bad lines on which some FRF has a value
fn drop_bad(lines: &mut Vec<usize>, bad: &[bool], lost: usize) -> Option<Finding> {
    let dropped = bad.iter().filter(|bad| **bad).count();
    let mut places = bad.iter();
    lines.retain(|_| places.next() == Some(&false));
    (dropped > 0).then(|| lines_left_out(dropped, lost, bad.len()))
}

/// Takes out FRFs that are far noisier than the others.
fn drop_noisy(pairs: &mut Vec<(usize, usize)>, frf: &FrfSet, lines: &[usize]) -> Option<Finding> {
    let noisy: Vec<(usize, usize)> = far_noisier(frf, pairs, lines)
        .into_iter()
        .map(|l| pairs[l])
        .collect();
    pairs.retain(|pair| !noisy.contains(pair));
    (!noisy.is_empty()).then(|| noisier(frf, &noisy))
}

/// Energy of each FRF used.
///
/// * `sum_of_pair`: that over all lines of the band, which holds unless some are left out
fn energies(
    frf: &FrfSet,
    layout: &DataLayout,
    lines_left_out: bool,
    sum_of_pair: &[f64],
) -> Vec<f64> {
    if lines_left_out {
        layout
            .pairs
            .par_iter()
            .map(|&pair| energy(&frf.values, pair, &layout.lines, 1.0).sum)
            .collect()
    } else {
        layout
            .pairs
            .iter()
            .map(|&(i, j)| sum_of_pair[i * frf.references.len() + j])
            .collect()
    }
}

/// Indices of the lines above 0 Hz in a band (`None`: that of all lines), and the band.
///
/// # Errors
/// [`FitError::BandOutsideData`].
pub(crate) fn lines_in_band(
    frequency_hz: ArrayView1<f64>,
    band_hz: Option<[f64; 2]>,
) -> Result<(Vec<usize>, [f64; 2]), FitError> {
    let f = frequency_hz;
    let (first, last) = (
        f.first().copied().unwrap_or(0.0),
        f.last().copied().unwrap_or(0.0),
    );
    let [low, high] = band_hz.unwrap_or([first, last]);
    let lines: Vec<usize> = (0..f.len())
        .filter(|&k| f[k] >= low && f[k] <= high && f[k] > 0.0)
        .collect();
    match lines.is_empty() {
        true => Err(FitError::BandOutsideData {
            low_hz: low,
            high_hz: high,
            data_low_hz: first,
            data_high_hz: last,
        }),
        false => Ok((lines, [low, high])),
    }
}

/// The finding that `dropped` of `all` lines lack values: a caution if many are `lost`, on which some
/// FRF has values.
pub(crate) fn lines_left_out(dropped: usize, lost: usize, all: usize) -> Finding {
    let words = format!(
        "{dropped} of {all} lines hold no finite value in at least one FRF, or zeros in all, and \
         are left out"
    );
    let finding = match lost as f64 > limits::LINES_LOST * all as f64 {
        true => Finding::caution("lines-without-values", words)
            .help("leave out the FRFs with gaps, or measure them again"),
        false => Finding::note("lines-without-values", words),
    };
    finding.value("lines_left_out", dropped as f64)
}

/// Checks that there are enough lines for the modes asked for (`None`: for one), and that powers of
/// ω differ over the band.
///
/// # Errors
/// [`FitError::TooFewLines`], [`FitError::NarrowBand`].
pub(crate) fn check_lines(
    lines: usize,
    [low_hz, high_hz]: [f64; 2],
    modes: Option<usize>,
) -> Result<(), FitError> {
    let modes = modes.unwrap_or(1);
    let needed = modes.saturating_add(limits::LINES_TO_SPARE);
    if lines < needed {
        return Err(FitError::TooFewLines {
            lines,
            low_hz,
            high_hz,
            modes,
            needed,
        });
    }
    if high_hz - low_hz < limits::NARROWEST_BAND * high_hz {
        return Err(FitError::NarrowBand { low_hz, high_hz });
    }
    Ok(())
}

/// Checks the root mean square of the FRFs.
///
/// # Errors
/// [`FitError::NoData`], [`FitError::Scale`].
pub(crate) fn check_scale(rms: f64) -> Result<(), FitError> {
    let [least, most] = limits::SENSIBLE_RMS;
    if rms == 0.0 || rms.is_nan() {
        return Err(FitError::NoData);
    }
    match (least..=most).contains(&rms) {
        true => Ok(()),
        false => Err(FitError::Scale { rms }),
    }
}

fn without_values(without: usize, of: usize) -> Finding {
    let words = format!("{without} of {of} FRFs hold no values in the band and are left out");
    Finding::note("frfs-without-values", words).value("frfs_left_out", without as f64)
}

fn incomplete(frf: &FrfSet, pairs: &[(usize, usize)]) -> Finding {
    let words = format!(
        "without values on so many lines that they are left out, their values follow from the \
         shapes: {}",
        named(frf, pairs)
    );
    Finding::caution("frfs-incomplete", words)
        .value("frfs_left_out", pairs.len() as f64)
        .dofs(dofs_of(frf, pairs))
        .help("measure these points again, or fit a band in which they have values")
}

fn dofs_of<'a>(frf: &'a FrfSet, pairs: &'a [(usize, usize)]) -> impl Iterator<Item = Dof> + 'a {
    let both = |&(i, j): &(usize, usize)| [frf.responses[i], frf.references[j]];
    pairs.iter().flat_map(both)
}

fn noisier(frf: &FrfSet, pairs: &[(usize, usize)]) -> Finding {
    let words = format!(
        "far noisier than the other FRFs and left out, their values follow from the shapes: {}",
        named(frf, pairs)
    );
    Finding::caution("far-noisier", words)
        .dofs(dofs_of(frf, pairs))
        .help("measure these points again")
}

/// The first of a list of pairs, in words.
fn named(frf: &FrfSet, pairs: &[(usize, usize)]) -> String {
    let mut names: Vec<String> = pairs
        .iter()
        .take(limits::PAIRS_SHOWN)
        .map(|&(i, j)| format!("{} from {}", frf.responses[i], frf.references[j]))
        .collect();
    if pairs.len() > limits::PAIRS_SHOWN {
        names.push(format!("and {} more", pairs.len() - limits::PAIRS_SHOWN));
    }
    names.join(", ")
}
