//! Screening: which lines and FRFs are used, and their scale (theory.md, eq. 5).

use crate::error::FitError;
use crate::faults::noisy::far_noisier;
use crate::model::Synthesis;
use crate::options::FitOptions;
use crate::tolerances as tol;
use crate::work::Work;
use chladni_frf::{FrfKind, FrfSet, FrfValues};
use ndarray::{Array1, Array2, ShapeBuilder};
use num_complex::Complex64;
use rand::seq::SliceRandom;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::f64::consts::TAU;
use std::ops::Range;

/// The usable part of an FRF set: selected lines and pairs, unit rms, no copy of the data.
#[derive(Debug)]
pub(crate) struct Screened<'a> {
    /// The measurement.
    pub frf: &'a FrfSet,
    /// Its kind.
    pub kind: FrfKind,
    /// Indices of the lines used.
    pub lines: Vec<usize>,
    /// Pairs (response, reference) used, row by row.
    pub pairs: Vec<(usize, usize)>,
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
    /// What was left out, in words.
    pub warnings: Vec<String>,
}

impl<'a> Screened<'a> {
    /// Selects band, lines and pairs.
    ///
    /// # Errors
    /// A band outside the data, too few lines, nothing but zeros.
    pub fn new(frf: &'a FrfSet, options: &FitOptions) -> Result<Self, FitError> {
        let kind = frf.kind.ok_or(FitError::UnknownKind)?;
        let f = &frf.frequency_hz;
        let (first, last) = (f.first().copied().unwrap_or(0.0), f.last().copied().unwrap_or(0.0));
        let [low, high] = options.band_hz.unwrap_or([first, last]);
        let mut lines: Vec<usize> = (0..f.len()).filter(|&k| f[k] >= low && f[k] <= high && f[k] > 0.0).collect();
        if lines.is_empty() {
            return Err(FitError::BandOutsideData { low_hz: low, high_hz: high, data_low_hz: first, data_high_hz: last });
        }
        let mut warnings = Vec::new();
        let (mut pairs, bad) = usable(frf, &lines);
        if pairs.is_empty() {
            return Err(FitError::NoData);
        }
        if pairs.len() < frf.pairs() {
            warnings.push(format!("{} of {} FRFs hold no values in the band and are left out", frf.pairs() - pairs.len(), frf.pairs()));
        }
        if bad.iter().any(|b| *b) {
            let dropped = bad.iter().filter(|b| **b).count();
            lines = lines.into_iter().zip(&bad).filter(|(_, bad)| !**bad).map(|(k, _)| k).collect();
            warnings.push(format!("{dropped} lines hold no finite value in at least one FRF, or zeros in all, and are left out"));
        }
        let noisy: Vec<(usize, usize)> = far_noisier(frf, &pairs, &lines).into_iter().map(|l| pairs[l]).collect();
        if !noisy.is_empty() {
            pairs.retain(|pair| !noisy.contains(pair));
            warnings
                .push(format!("far noisier than the other FRFs and left out, their values follow from the shapes: {}", named(frf, &noisy)));
        }
        let modes = options.modes.unwrap_or(1);
        let needed = modes + 8;
        if lines.len() < needed {
            return Err(FitError::TooFewLines { lines: lines.len(), low_hz: low, high_hz: high, modes, needed });
        }
        let omega_max = TAU * f[lines[lines.len() - 1]];
        let ratio: Vec<f64> = lines.iter().map(|&k| TAU * f[k] / omega_max).collect();
        let mut screened = Self {
            frf,
            kind,
            x: ratio.iter().map(|r| r * r).collect(),
            g: ratio.iter().map(|r| r.powi(kind.omega_power())).collect(),
            band_hz: [f[lines[0]].max(low), f[lines[lines.len() - 1]].min(high)],
            lines,
            pairs,
            omega_max,
            rms: 1.0,
            warnings,
        };
        let sum: Vec<f64> = screened.pairs.par_iter().map(|&pair| screened.energy(pair)).collect();
        screened.rms = (sum.iter().sum::<f64>() / (screened.lines.len() * screened.pairs.len()) as f64).sqrt();
        if screened.rms == 0.0 || !screened.rms.is_finite() {
            return Err(FitError::NoData);
        }
        Ok(screened)
    }

    fn energy(&self, pair: (usize, usize)) -> f64 {
        let mut energy = 0.0;
        visit(&self.frf.values, pair, &self.lines, |_, value| energy += value.norm_sqr());
        energy
    }

    /// Sum of squares of all data less their synthesis, in one pass.
    pub fn misfit(&self, synthesis: &Synthesis) -> f64 {
        let starts: Vec<usize> = (0..self.pairs.len()).step_by(tol::BLOCK_FRFS).collect();
        let parts: Vec<f64> = starts
            .par_iter()
            .map(|&a| {
                let columns = a..(a + tol::BLOCK_FRFS).min(self.pairs.len());
                synthesis.misfit(&self.block(columns.clone(), 0..self.lines.len()), columns)
            })
            .collect();
        parts.iter().sum()
    }

    /// Usual distance of neighbouring lines, Hz: the median, which gaps do not move.
    pub fn line_spacing_hz(&self) -> f64 {
        let mut gaps: Vec<f64> =
            self.lines.windows(2).map(|pair| self.frf.frequency_hz[pair[1]] - self.frf.frequency_hz[pair[0]]).collect();
        gaps.sort_by(f64::total_cmp);
        gaps.get(gaps.len() / 2).copied().unwrap_or(0.0)
    }

    /// The same data without the lines at `places` (among the lines used); the scale stays.
    pub fn without(&self, places: &[usize]) -> Self {
        let kept: Vec<usize> = (0..self.lines.len()).filter(|place| !places.contains(place)).collect();
        Self {
            frf: self.frf,
            kind: self.kind,
            lines: kept.iter().map(|&place| self.lines[place]).collect(),
            pairs: self.pairs.clone(),
            band_hz: self.band_hz,
            omega_max: self.omega_max,
            rms: self.rms,
            x: kept.iter().map(|&place| self.x[place]).collect(),
            g: kept.iter().map(|&place| self.g[place]).collect(),
            warnings: self.warnings.clone(),
        }
    }

    /// Factor that takes a measured value to a work value: the kind's phase undone, unit rms.
    pub fn factor(&self) -> Complex64 {
        let phase = self.kind.from_receptance(1.0);
        phase.conj() / (phase.norm() * self.rms)
    }

    /// Writes the values of `pairs[range]` on lines `lines[rows]` into a (line, column) array.
    pub fn block(&self, columns: Range<usize>, rows: Range<usize>) -> Array2<Complex64> {
        let factor = self.factor();
        let lines = &self.lines[rows];
        let mut out = Array2::zeros((lines.len(), columns.len()).f());
        for (mut column, &pair) in out.columns_mut().into_iter().zip(&self.pairs[columns]) {
            visit(&self.frf.values, pair, lines, |row, value| column[row] = value * factor);
        }
        out
    }

    /// All columns at once; for sets of few FRFs.
    pub fn work(&self) -> Work {
        Work { x: self.x.clone(), g: self.g.clone(), b: self.block(0..self.pairs.len(), 0..self.lines.len()) }
    }

    /// First pass: count sketch (each FRF added with a random sign to one of a few columns, scaled so that the noise
    /// keeps its variance) and the energy of each line over all FRFs (theory.md, eq. 6).
    pub fn sketch(&self, seed: u64) -> (Work, Array1<f64>) {
        let total = self.pairs.len();
        if total <= tol::SKETCH_COLUMNS {
            let work = self.work();
            let energy = crate::work::line_energy(&work.b) * total as f64;
            return (work, energy);
        }
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut order: Vec<usize> = (0..total).collect();
        order.shuffle(&mut rng);
        let mut bucket = vec![0; total];
        for (position, &l) in order.iter().enumerate() {
            bucket[l] = position % tol::SKETCH_COLUMNS;
        }
        let sign: Vec<f64> = (0..total).map(|_| if rng.random::<bool>() { 1.0 } else { -1.0 }).collect();
        let chunks: Vec<Range<usize>> =
            (0..self.lines.len()).step_by(tol::BLOCK_LINES).map(|a| a..(a + tol::BLOCK_LINES).min(self.lines.len())).collect();
        let parts: Vec<(Array2<Complex64>, Array1<f64>)> = chunks
            .par_iter()
            .map(|rows| {
                let mut part = Array2::zeros((rows.len(), tol::SKETCH_COLUMNS).f());
                let mut energy = Array1::zeros(rows.len());
                for l in 0..total {
                    let column = self.block(l..l + 1, rows.clone());
                    let mut target = part.column_mut(bucket[l]);
                    for ((t, e), v) in target.iter_mut().zip(energy.iter_mut()).zip(column.iter()) {
                        *t += v * sign[l];
                        *e += v.norm_sqr();
                    }
                }
                (part, energy)
            })
            .collect();
        let scale = (tol::SKETCH_COLUMNS as f64 / total as f64).sqrt();
        let mut b = Array2::zeros((self.lines.len(), tol::SKETCH_COLUMNS).f());
        let mut energy = Array1::zeros(self.lines.len());
        for (rows, (part, e)) in chunks.into_iter().zip(parts) {
            b.slice_mut(ndarray::s![rows.clone(), ..]).assign(&(part * Complex64::new(scale, 0.0)));
            energy.slice_mut(ndarray::s![rows]).assign(&e);
        }
        (Work { x: self.x.clone(), g: self.g.clone(), b }, energy)
    }
}

/// Calls `see` with position and value of each of `lines` of one pair.
fn visit(values: &FrfValues, (i, j): (usize, usize), lines: &[usize], mut see: impl FnMut(usize, Complex64)) {
    match values {
        FrfValues::F64(values) => {
            let of_pair = values.slice(ndarray::s![i, j, ..]);
            lines.iter().enumerate().for_each(|(row, &k)| see(row, of_pair[k]));
        }
        FrfValues::F32(values) => {
            let of_pair = values.slice(ndarray::s![i, j, ..]);
            lines.iter().enumerate().for_each(|(row, &k)| see(row, Complex64::new(of_pair[k].re.into(), of_pair[k].im.into())));
        }
    }
}

/// The first of a list of pairs, in words.
fn named(frf: &FrfSet, pairs: &[(usize, usize)]) -> String {
    const SHOWN: usize = 6;
    let mut names: Vec<String> =
        pairs.iter().take(SHOWN).map(|&(i, j)| format!("{} from {}", frf.responses[i], frf.references[j])).collect();
    if pairs.len() > SHOWN {
        names.push(format!("and {} more", pairs.len() - SHOWN));
    }
    names.join(", ")
}

/// Pairs with at least one finite non-zero value on `lines`, and the lines on which one of them is not finite or all are zero.
fn usable(frf: &FrfSet, lines: &[usize]) -> (Vec<(usize, usize)>, Vec<bool>) {
    let (responses, references, _) = frf.values.dim();
    let all: Vec<(usize, usize)> = (0..responses).flat_map(|i| (0..references).map(move |j| (i, j))).collect();
    // per pair: is there anything, which lines are not finite, and which are zero
    let seen: Vec<(bool, Vec<usize>, Vec<usize>)> = all
        .par_iter()
        .map(|&pair| {
            let mut any = false;
            let (mut bad, mut zero) = (Vec::new(), Vec::new());
            visit(&frf.values, pair, lines, |row, value| {
                if !value.is_finite() {
                    bad.push(row);
                } else if value == Complex64::default() {
                    zero.push(row);
                } else {
                    any = true;
                }
            });
            (any, bad, zero)
        })
        .collect();
    let mut bad = vec![false; lines.len()];
    let mut zeros = vec![0; lines.len()];
    let mut pairs = Vec::new();
    for (pair, (any, not_finite, zero)) in all.into_iter().zip(seen) {
        if any {
            pairs.push(pair);
            not_finite.into_iter().for_each(|row| bad[row] = true);
            zero.into_iter().for_each(|row| zeros[row] += 1);
        }
    }
    bad.iter_mut().zip(&zeros).for_each(|(bad, zeros)| *bad |= *zeros == pairs.len() && !pairs.is_empty());
    (pairs, bad)
}
