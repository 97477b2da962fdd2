//! Places of missing poles: a resonance of the usual width there would explain part of the
//! residual.

use crate::damping::basis::basis;
use crate::data::columns::Columns;
use crate::poles::limits;
use crate::poles::refine::Refined;
use chladni_linalg::matmul_h;
use ndarray::{s, Array1, ArrayView1};
use num_complex::Complex64;
use rayon::prelude::*;

/// Median loss factor of the poles of the band.
pub(crate) fn usual_loss(work: &Columns, lambda: &[Complex64]) -> f64 {
    let mut losses: Vec<f64> = lambda
        .iter()
        .filter(|p| work.in_band(**p))
        .map(|p| p.im / p.re.max(limits::PLACE_LEAST))
        .collect();
    losses.sort_by(f64::total_cmp);
    losses
        .get(losses.len() / 2)
        .copied()
        .unwrap_or(limits::UNKNOWN_LOSS)
}

/// Resonances of the usual loss factor over the band, half a bandwidth apart, and one line spacing
/// at least.
pub(crate) fn resonance_grid(work: &Columns, lambda: &[Complex64]) -> Vec<Complex64> {
    let loss = usual_loss(work, lambda);
    let (low, high) = work.range();
    let mut grid = Vec::new();
    let mut x = low;
    while x <= high && grid.len() < limits::PLACES_PER_LINE * work.lines() {
        let width = (loss * x).max(work.spacing(x));
        grid.push(Complex64::new(x, width));
        x += width;
    }
    grid
}

/// Starting poles of modes outside the band.
pub(crate) fn places_beyond(work: &Columns) -> impl Iterator<Item = Complex64> {
    let (low, high) = work.range();
    let places = limits::BELOW
        .map(|f| low * f * f)
        .into_iter()
        .chain(limits::ABOVE.map(|f| high * f * f));
    places.map(|x| Complex64::new(x, limits::OUTSIDE_LOSS * x))
}

/// A place of the grid.
struct Place {
    pole: Complex64,
    /// Residual energy that one more pole there would take out.
    gain: f64,
}

/// All places of a grid, the largest gain first.
pub(crate) struct Scan(Vec<Place>);

/// Computes the gain at all places of the grid.
pub(crate) fn scan(work: &Columns, refined: &Refined) -> Scan {
    let grid = resonance_grid(work, &refined.lambda);
    let gains = |chunk: &[Complex64]| -> Vec<Place> {
        // a resonance is taken for zero where it is small
        let [first, last] =
            [chunk[0], chunk[chunk.len() - 1]].map(|pole| work.window(pole, limits::SCAN_REACH, 1));
        let rows = first.start..last.end;
        let columns = basis(&work.axis_on(rows.clone()), chunk, &[]);
        // the residual has no part inside the model: of the part of a column outside the model
        // only the norm is needed
        let rows = s![rows, ..];
        let inside = matmul_h(refined.projection.q.slice(rows), columns.view());
        let matched = matmul_h(columns.view(), refined.projection.residual.slice(rows));
        let place = |(i, &pole): (usize, &Complex64)| {
            let squares = |of: ArrayView1<Complex64>| of.iter().map(|v| v.norm_sqr()).sum::<f64>();
            let whole = squares(columns.column(i));
            let norm = whole - squares(inside.column(i));
            let gain = squares(matched.row(i)) / norm;
            (norm >= limits::OUTSIDE_LEAST * whole).then_some(Place { pole, gain })
        };
        chunk.iter().enumerate().filter_map(place).collect()
    };
    let blocks: Vec<Vec<Place>> = grid.par_chunks(limits::BLOCK).map(gains).collect();
    let mut places: Vec<Place> = blocks.into_iter().flatten().collect();
    places.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    Scan(places)
}

impl Scan {
    /// Poles at the places with a gain above `least_gain`, half a bandwidth apart from each other
    /// and from those `tried`.
    pub fn beyond(&self, least_gain: f64, tried: &[Complex64]) -> Vec<Complex64> {
        let mut places: Vec<Complex64> = Vec::new();
        let significant = |place: &&Place| place.gain > least_gain;
        for &Place { pole, .. } in self.0.iter().take_while(significant) {
            if !tried
                .iter()
                .chain(&places)
                .any(|known| (known - pole).norm() < pole.im)
            {
                places.push(pole);
            }
        }
        places
    }
}

/// A starting pole in the middle of the stretch of lines, about a bandwidth wide, whose residual
/// energy over all FRFs stands out most. `None` if none stands out.
pub(crate) fn residual_peak(
    work: &Columns,
    line_residual: &Array1<f64>,
    frfs: usize,
    lambda: &[Complex64],
) -> Option<Complex64> {
    let n = work.lines();
    let mean = line_residual.sum() / n as f64;
    let loss = usual_loss(work, lambda);
    // the largest of n standard normal values
    let by_chance = (2.0 * (n as f64).ln()).sqrt();
    let mut best: Option<(f64, Complex64)> = None;
    for k in 2..n.saturating_sub(2) {
        let pole = Complex64::new(work.x[k], (loss * work.x[k]).max(work.spacing(work.x[k])));
        let window = work.window(pole, 1.0, 1);
        let lines = window.len() as f64;
        let local = line_residual.slice(s![window]).sum() / lines / mean;
        let score = (local - 1.0) * (lines * frfs as f64).sqrt();
        // a peak near a known pole is misfit of that pole, not another mode
        let near = lambda
            .iter()
            .any(|p| (p.re - pole.re).abs() < limits::MISFIT_REACH * p.im.max(pole.im));
        if !near
            && score > by_chance + limits::PEAK_BEYOND_CHANCE
            && best.is_none_or(|(highest, _)| score > highest)
        {
            best = Some((score, pole));
        }
    }
    best.map(|(_, pole)| pole)
}
