//! FRFs that are far noisier than the others: a loose cable, a point where the laser sees
//! speckle.
//!
//! All FRFs have the same weight in the fit. One that is many times noisier would spoil the others,
//! and adds next to no information (1/ratio² of theirs). So it is left out like a pair that was
//! not measured. Its values follow from the shapes if its response and its reference occur in other
//! FRFs; it stays if they do not.

use crate::data::fourth_difference::FourthDifference;
use crate::data::limits;
use chladni_frf::FrfSet;
use num_complex::Complex64;
use rayon::prelude::*;

/// Positions in `pairs` of FRFs far noisier than the others on `lines`.
pub(crate) fn far_noisier(frf: &FrfSet, pairs: &[(usize, usize)], lines: &[usize]) -> Vec<usize> {
    let stencils = (limits::STENCILS_IN_ALL / pairs.len().max(1))
        .clamp(limits::STENCILS.0, limits::STENCILS.1);
    let stencils = Stencil::spread(frf, lines, stencils);
    let level = |&(i, j): &(usize, usize)| noise(|line| frf.values.get(i, j, line), &stencils);
    // absolute, and relative to the FRF
    let levels: Vec<[f64; 2]> = pairs.par_iter().map(level).collect();
    if levels.is_empty() {
        return Vec::new();
    }
    let median = |which: usize| {
        let mut all: Vec<f64> = levels.iter().map(|level| level[which]).collect();
        let middle = all.len() / 2;
        *all.select_nth_unstable_by(middle, f64::total_cmp).1
    };
    let usual = [median(0), median(1)];
    let noisy: Vec<usize> = (0..pairs.len())
        .filter(|&l| (0..2).all(|which| levels[l][which] > limits::FAR * usual[which]))
        .collect();
    let is_replaceable = |l: usize| {
        let sound = || (0..pairs.len()).filter(|m| !noisy.contains(m));
        let (response, reference) = pairs[l];
        sound().any(|m| pairs[m].0 == response) && sound().any(|m| pairs[m].1 == reference)
    };
    match noisy.len() as f64 <= limits::NOISY_FRFS_SHARE_MOST * pairs.len() as f64 {
        true => noisy
            .iter()
            .copied()
            .filter(|&l| is_replaceable(l))
            .collect(),
        false => Vec::new(),
    }
}

/// Five neighbouring lines with their fourth difference.
struct Stencil {
    lines: [usize; 5],
    difference: FourthDifference,
}

impl Stencil {
    /// About so many stencils, spread evenly over these lines.
    fn spread(frf: &FrfSet, lines: &[usize], stencils: usize) -> Vec<Self> {
        let stride = (lines.len() / stencils).max(1);
        let about = |five: &[usize]| {
            let lines = [0, 1, 2, 3, 4].map(|k| five[k]);
            Self {
                lines,
                difference: FourthDifference::new(lines.map(|line| frf.frequency_hz[line])),
            }
        };
        lines.windows(5).step_by(stride).map(about).collect()
    }
}

/// Noise amplitude of one FRF, absolute and over its rms. It comes from fourth differences, which
/// are next to nothing for smooth curves.
fn noise(value: impl Fn(usize) -> Complex64, stencils: &[Stencil]) -> [f64; 2] {
    let (mut energy, mut differences) = (0.0, Vec::new());
    for stencil in stencils {
        let values = stencil.lines.map(&value);
        energy += values[2].norm_sqr();
        differences.push(stencil.difference.energy(values));
    }
    if differences.is_empty() {
        return [0.0; 2];
    }
    let count = differences.len();
    let (_, median, _) = differences.select_nth_unstable_by(count / 2, f64::total_cmp);
    let noise = FourthDifference::noise_of_median(*median).sqrt();
    let rms = (energy / count as f64).sqrt();
    [noise, noise / rms.max(f64::MIN_POSITIVE)]
}
