//! Visible peaks of the mean FRF: they seed poles, and a model should explain the striking ones.

use crate::data::columns::Columns;
use crate::data::fourth_difference::FourthDifference;
use crate::data::limits;
use crate::tolerances as tol;
use ndarray::{Array1, ArrayView2, Axis};
use num_complex::Complex64;
use rayon::prelude::*;

/// A local maximum of the mean |FRF|² above its surroundings.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Peak {
    /// Line (position).
    pub row: usize,
    /// Height over the higher of the two saddles, dB.
    pub prominence_db: f64,
    /// Height over the local noise, dB.
    pub over_noise_db: f64,
    /// Height, dB (relative).
    pub level_db: f64,
    /// Starting pole: position and −3 dB width.
    pub lambda: Complex64,
}

impl Peak {
    /// True for a peak that a person would call a mode: a finding names it if no pole explains it.
    pub fn is_striking(&self) -> bool {
        self.prominence_db >= limits::STRIKING_PROMINENCE_DB
            && self.over_noise_db > limits::STRIKING_OVER_NOISE_DB
    }
}

/// Distinct peaks at the given rows, for tests.
#[cfg(test)]
pub(crate) fn peaks_at(rows: &[usize]) -> Vec<Peak> {
    let peak = |&row| Peak {
        row,
        prominence_db: 20.0,
        over_noise_db: 40.0,
        level_db: 0.0,
        lambda: Complex64::new(0.5, 0.01),
    };
    rows.iter().map(peak).collect()
}

/// Noise variance of each line from fourth differences of neighbouring lines.
pub(crate) fn fourth_difference_noise(work: &Columns, half_window: usize) -> Array1<f64> {
    let (b, n) = (&work.b, work.lines());
    let mut energy = Array1::zeros(n);
    if n < limits::DIFFERENCES_LEAST_LINES {
        return energy;
    }
    let about = |k: usize| [k - 2, k - 1, k, k + 1, k + 2];
    let differences: Vec<FourthDifference> = (2..n - 2)
        .map(|k| FourthDifference::new(about(k).map(|k| work.x[k].sqrt())))
        .collect();
    let of_columns = |columns: ArrayView2<Complex64>| {
        let mut energy = Array1::zeros(n);
        let mut values = vec![Complex64::ZERO; n];
        for column in columns.columns() {
            values
                .iter_mut()
                .zip(column)
                .for_each(|(own, value)| *own = *value);
            let sums = energy.iter_mut().skip(2).zip(&differences);
            for ((sum, difference), five) in sums.zip(values.windows(5)) {
                let five = std::array::from_fn(|k| five[k]);
                *sum += difference.energy(five) / limits::DIFFERENCE_OF_NOISE;
            }
        }
        energy
    };
    let blocks: Vec<_> = b
        .axis_chunks_iter(Axis(1), limits::DIFFERENCES_BLOCK)
        .collect();
    let parts: Vec<Array1<f64>> = blocks.into_par_iter().map(of_columns).collect();
    parts.iter().for_each(|part| energy += part);
    energy /= b.ncols() as f64;
    let raw: Vec<f64> = energy.iter().skip(2).take(n - 4).copied().collect();
    // median of χ²_{2r} over its mean, for the mean over r columns
    let r = b.ncols() as f64;
    let bias = (1.0 - 1.0 / (9.0 * r)).powi(3);
    let smooth = running_median(&raw, half_window);
    Array1::from_shape_fn(n, |k| {
        smooth[k.saturating_sub(2).min(smooth.len() - 1)] / bias
    })
}

/// Median over a sliding window, which is shorter at the ends. For wide windows it is evaluated on a
/// coarse grid, and held in between.
pub(crate) fn running_median(values: &[f64], half_window: usize) -> Vec<f64> {
    let n = values.len();
    let stride = (half_window / limits::MEDIANS_PER_HALF_WINDOW).max(1);
    let mut out = vec![0.0; n];
    let mut buffer = Vec::new();
    let mut k = 0;
    while k < n {
        let window = k.saturating_sub(half_window)..(k + half_window + 1).min(n);
        buffer.clear();
        buffer.extend_from_slice(&values[window]);
        let middle = buffer.len() / 2;
        let (_, median, _) = buffer.select_nth_unstable_by(middle, f64::total_cmp);
        let median = *median;
        for value in out
            .iter_mut()
            .skip(k.saturating_sub(stride / 2))
            .take(stride + stride / 2 + 1)
        {
            *value = median;
        }
        k += stride;
    }
    out
}

/// Peaks of the mean |data|² in the measured kind, most prominent first.
pub(crate) fn peaks(work: &Columns, energy: &Array1<f64>, noise: &Array1<f64>) -> Vec<Peak> {
    let n = work.lines();
    if n < limits::PEAKS_LEAST_LINES {
        return Vec::new();
    }
    let level: Vec<f64> = energy
        .iter()
        .map(|e| 10.0 * e.max(tol::TINY).log10())
        .collect();
    // bound of the largest of n lines of pure noise, averaged over the columns (Laurent &
    // Massart 2000)
    let t = (n as f64).ln() / work.columns() as f64;
    let chance_db = 10.0 * (1.0 + 2.0 * t.sqrt() + t).log10();
    let over_noise_least = limits::SEED_OVER_NOISE_DB.max(chance_db);
    let mut found = Vec::new();
    for k in 1..n - 1 {
        if !(level[k] > level[k - 1] && level[k] >= level[k + 1]) {
            continue;
        }
        let prominence_db = prominence(&level, k);
        let over_noise_db = level[k] - 10.0 * noise[k].max(tol::TINY).log10();
        if prominence_db < limits::SEED_PROMINENCE_DB || over_noise_db < over_noise_least {
            continue;
        }
        let half_width = half_width(work, &level, k, prominence_db);
        let half_line = 0.5 * work.spacing(work.x[k]);
        found.push(Peak {
            row: k,
            prominence_db,
            over_noise_db,
            level_db: level[k],
            lambda: Complex64::new(
                work.x[k],
                (limits::START_OF_WIDTH * half_width).max(half_line),
            ),
        });
    }
    found.sort_by(|a, b| b.prominence_db.total_cmp(&a.prominence_db));
    found.truncate(limits::SEEDS_MOST);
    found
}

/// Half of the −3 dB width of peak k, in x; of a less prominent peak half of the visible width.
fn half_width(work: &Columns, level: &[f64], k: usize, prominence_db: f64) -> f64 {
    let foot = (level[k] - limits::WIDTH_DROP_DB).max(level[k] - prominence_db);
    let belongs = |i: &usize| level[*i] > foot && level[*i] < level[k];
    let left = (0..k).rev().take_while(belongs).last().unwrap_or(k);
    let right = (k + 1..level.len()).take_while(belongs).last().unwrap_or(k);
    0.5 * (work.x[(right + 1).min(level.len() - 1)] - work.x[left.saturating_sub(1)])
}

/// Height of peak k over its saddle: on each side the lowest point before the level exceeds the
/// peak; the higher of both counts.
fn prominence(level: &[f64], k: usize) -> f64 {
    let walk = |indices: &mut dyn Iterator<Item = usize>| {
        let mut lowest = level[k];
        for i in indices {
            if level[i] > level[k] {
                return (lowest, true);
            }
            lowest = lowest.min(level[i]);
        }
        (lowest, false)
    };
    let (left, left_higher) = walk(&mut (0..k).rev());
    let (right, right_higher) = walk(&mut (k + 1..level.len()));
    let saddle = match (left_higher, right_higher) {
        (true, false) => left,
        (false, true) => right,
        _ => left.max(right),
    };
    level[k] - saddle
}

/// Rows of a long record to keep: all near the peaks, the rest thinned out evenly.
pub(crate) fn thinned(work: &Columns, peaks: &[Peak]) -> Vec<usize> {
    let n = work.lines();
    if n <= limits::DECIMATE_ABOVE_LINES {
        return (0..n).collect();
    }
    let mut keep = vec![false; n];
    for &Peak { row, lambda, .. } in peaks {
        let half_width = (lambda.im / work.spacing(lambda.re)).max(limits::KEPT_LEAST_HALF_WIDTH);
        let reach = (limits::KEPT_AROUND.0 * half_width).max(limits::KEPT_AROUND.1) as usize;
        for flag in &mut keep[row.saturating_sub(reach)..(row + reach + 1).min(n)] {
            *flag = true;
        }
    }
    let near = keep.iter().filter(|k| **k).count();
    let stride = (n - near) / (limits::DECIMATE_ABOVE_LINES / 2) + 1;
    for flag in keep.iter_mut().step_by(stride) {
        *flag = true;
    }
    (0..n).filter(|&k| keep[k]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_frf::Damping;
    use ndarray::Array2;

    /// Noise 80 dB below a resonance of ten lines per half-bandwidth, every sixth line left out.
    #[test]
    fn lines_left_out_of_a_resonance_are_no_noise() {
        let sigma = 1e-4;
        let value = |place: f64| {
            let phase = 4e4 * (12.9898 * place).sin();
            let resonance = Complex64::new(0.0, 10.0) / Complex64::new(place - 200.3, -10.0);
            resonance + Complex64::from_polar(sigma, phase)
        };
        let about_mode = |kept: &dyn Fn(usize) -> bool| {
            let places = (1..400).filter(|&k| kept(k)).map(|k| k as f64);
            let places: Vec<f64> = places.collect();
            let work = Columns {
                g: vec![1.0; places.len()],
                b: Array2::from_shape_fn((places.len(), 1), |(k, _)| value(places[k])),
                x: places.iter().map(|place| (place / 400.0).powi(2)).collect(),
                law: Damping::Structural,
                leakage: None,
                neighbours: 0.0,
            };
            let noise = fourth_difference_noise(&work, 40);
            noise[places.len() / 2] / (sigma * sigma)
        };
        let (whole, thinned) = (about_mode(&|_| true), about_mode(&|k| k % 6 != 0));
        assert!((0.5..2.0).contains(&whole), "{whole}");
        assert!((0.5..3.0).contains(&thinned), "{thinned}");
    }
}
