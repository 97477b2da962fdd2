//! Where a pole may be missing: places at which a resonance of the usual width would explain what is left.

use crate::refine::Refined;
use crate::work::{basis, Work};
use chladni_linalg::{matmul, matmul_h, LinalgError};
use ndarray::{s, Array1};
use num_complex::Complex64;
use rayon::prelude::*;

/// Places per block of products.
const BLOCK: usize = 64;
/// Loss factor where no pole of the band tells the usual one.
const UNKNOWN_LOSS: f64 = 0.01;

/// Median loss factor of the poles of the band.
fn usual_loss(work: &Work, lambda: &[Complex64]) -> f64 {
    let mut losses: Vec<f64> = lambda.iter().filter(|p| work.in_band(**p)).map(|p| p.im / p.re.max(1e-12)).collect();
    losses.sort_by(f64::total_cmp);
    losses.get(losses.len() / 2).copied().unwrap_or(UNKNOWN_LOSS)
}

/// Resonances of the usual loss factor over the band, half a bandwidth apart, at least one line.
pub(crate) fn resonance_grid(work: &Work, lambda: &[Complex64]) -> Vec<Complex64> {
    let loss = usual_loss(work, lambda);
    let (low, high) = work.range();
    let mut grid = Vec::new();
    let mut x = low;
    while x <= high && grid.len() < 4 * work.lines() {
        let width = (loss * x).max(work.spacing(x));
        grid.push(Complex64::new(x, width));
        x += width;
    }
    grid
}

/// The place where one more pole would take most energy out of the residual, if that is more than `limit`.
pub(crate) fn scan(work: &Work, refined: &Refined, limit: f64, tried: &[Complex64]) -> Result<Option<Complex64>, LinalgError> {
    let grid = resonance_grid(work, &refined.lambda);
    let best = |chunk: &[Complex64]| -> Option<(f64, Complex64)> {
        let columns = basis(work, chunk, &[]);
        let q = refined.projection.q.view();
        let outside = &columns - &matmul(q, matmul_h(q, columns.view()).view());
        let matched = matmul_h(outside.view(), refined.projection.residual.view());
        let mut best: Option<(f64, Complex64)> = None;
        for (i, &pole) in chunk.iter().enumerate() {
            let norm = outside.column(i).iter().map(|v| v.norm_sqr()).sum::<f64>();
            let whole = columns.column(i).iter().map(|v| v.norm_sqr()).sum::<f64>();
            if norm < 1e-6 * whole || tried.iter().any(|t| (t - pole).norm() < pole.im) {
                continue;
            }
            let gain = matched.row(i).iter().map(|v| v.norm_sqr()).sum::<f64>() / norm;
            if gain > limit && best.is_none_or(|(g, _)| gain > g) {
                best = Some((gain, pole));
            }
        }
        best
    };
    let found: Vec<Option<(f64, Complex64)>> = grid.par_chunks(BLOCK).map(best).collect();
    let first_best = |best: Option<(f64, Complex64)>, next: (f64, Complex64)| best.filter(|b| b.0 >= next.0).or(Some(next));
    Ok(found.into_iter().flatten().fold(None, first_best).map(|(_, pole)| pole))
}

/// A stretch of lines, about a bandwidth wide, whose residual energy over all FRFs stands out of the rest.
pub(crate) fn residual_peak(work: &Work, line_residual: &Array1<f64>, frfs: usize, lambda: &[Complex64]) -> Option<Complex64> {
    let n = work.lines();
    let mean = line_residual.sum() / n as f64;
    let loss = usual_loss(work, lambda);
    let looks = 2.0 * (n as f64).ln();
    let mut best: Option<(f64, usize)> = None;
    for k in 2..n.saturating_sub(2) {
        let pole = Complex64::new(work.x[k], (loss * work.x[k]).max(work.spacing(work.x[k])));
        let window = work.window(pole, 1.0, 1);
        let lines = window.len() as f64;
        let local = line_residual.slice(s![window]).sum() / lines / mean;
        let score = (local - 1.0) * (lines * frfs as f64).sqrt();
        // what is near a known pole is misfit of that pole, not another mode
        let near = lambda.iter().any(|p| (p.re - pole.re).abs() < 3.0 * p.im.max(pole.im));
        if !near && score > looks.sqrt() + 6.0 && best.is_none_or(|(s, _)| score > s) {
            best = Some((score, k));
        }
    }
    best.map(|(_, k)| Complex64::new(work.x[k], (loss * work.x[k]).max(work.spacing(work.x[k]))))
}
