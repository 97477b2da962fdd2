//! Screening: which lines and FRFs are used, and their scale (theory.md, eq. 5).

use crate::error::FitError;
use crate::faults::noisy::far_noisier;
use crate::options::{Effort, FitOptions};
use crate::reading::{energy, visit, Usable};
use crate::unequal::{PairWeights, Weighting};
use crate::work::Work;
use chladni_frf::{FrfKind, FrfSet};
use ndarray::{Array2, ShapeBuilder};
use num_complex::Complex64;
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
    /// What is spent on finding poles.
    pub effort: Effort,
    /// Where `frf` is not the measurement itself but weighted by its noise.
    pub weighting: Option<Weighting<'a>>,
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
        let Usable { mut pairs, bad, energy: sums } = Usable::new(frf, &lines);
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
            effort: options.effort,
            weighting: None,
        };
        let sum: f64 = if bad.contains(&true) {
            screened.pairs.par_iter().map(|&pair| energy(&frf.values, pair, &screened.lines).0).collect::<Vec<_>>().iter().sum()
        } else {
            screened.pairs.iter().map(|&(i, j)| sums[i * frf.references.len() + j]).sum()
        };
        screened.rms = (sum / (screened.lines.len() * screened.pairs.len()) as f64).sqrt();
        if screened.rms == 0.0 || !screened.rms.is_finite() {
            return Err(FitError::NoData);
        }
        Ok(screened)
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
            effort: self.effort,
            weighting: self.weighting,
        }
    }

    /// The same lines and pairs of `frf`, the data times `weights`.
    pub fn weighted<'b>(&self, frf: &'b FrfSet, weights: &'b PairWeights) -> Screened<'b>
    where
        'a: 'b,
    {
        let mut out: Screened<'b> = self.without(&[]);
        let sums: Vec<f64> = out.pairs.par_iter().map(|&pair| energy(&frf.values, pair, &out.lines).0).collect();
        out.weighting = Some(Weighting { weights, measured: out.frf, rms: out.rms });
        out.rms = (sums.iter().sum::<f64>() / (out.lines.len() * out.pairs.len()) as f64).sqrt();
        out.frf = frf;
        out
    }

    /// What FRFs of response i and of reference j were multiplied by.
    pub fn weight(&self, i: usize, j: usize) -> [f64; 2] {
        self.weighting.map_or([1.0; 2], |weighting| [weighting.weights.response[i], weighting.weights.reference[j]])
    }

    /// Root mean square of the measured data over that of the data used.
    pub fn measured_over_used(&self) -> f64 {
        self.weighting.map_or(1.0, |weighting| weighting.rms / self.rms)
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
            visit(&self.frf.values, pair, lines, column.iter_mut(), |out, value| *out = value * factor);
        }
        out
    }

    /// All columns at once; for sets of few FRFs.
    pub fn work(&self) -> Work {
        Work { x: self.x.clone(), g: self.g.clone(), b: self.block(0..self.pairs.len(), 0..self.lines.len()) }
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
