//! Is the residual white? The question that decides between the fast chain and the measured-data path.
//!
//! Three tests on the residual energy per line, each with its chance spread: around every mode (misfit of the line shape),
//! over tenths of the band (one noise level cannot serve), and correlation of neighbouring lines (leakage, windows,
//! missing modes).

use crate::tolerances as tol;
use crate::work::Work;
use ndarray::{Array1, Array2};
use num_complex::Complex64;

/// Verdict, with the evidence in words.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Whiteness {
    /// True where no test speaks against white noise.
    pub white: bool,
    /// The strongest evidence.
    pub evidence: String,
    /// Part of the in-band poles whose neighbourhood is misfitted.
    pub misfit_share: f64,
}

/// Judges the residual. `line_residual` holds the energy per line summed over `frfs` FRFs; `sample` some residual columns.
pub(crate) fn judge(work: &Work, lambda: &[Complex64], line_residual: &Array1<f64>, frfs: usize, sample: &Array2<Complex64>) -> Whiteness {
    let n = work.lines();
    let mean = line_residual.sum() / n as f64;
    if mean <= 0.0 {
        return Whiteness { white: true, evidence: "the model explains the data to rounding".into(), misfit_share: 0.0 };
    }
    let chance = |lines: usize| tol::WHITE_SIGMAS / ((lines.max(1) * frfs.max(1)) as f64).sqrt();
    let frequency = |x: f64| x.max(0.0).sqrt();

    let mut worst_local = (0.0, 0.0);
    let (mut misfitted, mut looked_at) = (0, 0);
    for &pole in lambda.iter().filter(|p| work.in_band(**p)) {
        let window = work.window(pole, tol::WINDOW_HALF_WIDTHS, tol::WINDOW_LEAST_LINES);
        let lines = window.len();
        let local = line_residual.slice(ndarray::s![window]).sum() / lines.max(1) as f64 / mean;
        let excess = local - chance(lines);
        looked_at += 1;
        misfitted += usize::from(excess > tol::WHITE_LOCAL);
        if excess > worst_local.0 {
            worst_local = (excess, frequency(pole.re));
        }
    }

    let mut segment_ratio: f64 = 1.0;
    let segments = 10.min(n / 16).max(1);
    for s in 0..segments {
        let (a, b) = (s * n / segments, (s + 1) * n / segments);
        let local = line_residual.slice(ndarray::s![a..b]).sum() / (b - a) as f64 / mean;
        let allowed = 1.0 + chance(b - a);
        segment_ratio = segment_ratio.max(local / allowed).max(1.0 / (local * allowed).max(1e-9));
    }

    let (mut along, mut total) = (0.0, 0.0);
    for column in sample.columns() {
        for k in 1..n {
            along += (column[k] * column[k - 1].conj()).re;
            total += column[k].norm_sqr();
        }
    }
    let correlation = if total > 0.0 { along / total } else { 0.0 };
    let correlated = correlation - chance(n * sample.ncols().min(frfs) / frfs.max(1)) / 2f64.sqrt();

    let white = worst_local.0 <= tol::WHITE_LOCAL && segment_ratio <= tol::WHITE_SEGMENT && correlated <= tol::WHITE_CORRELATION;
    let evidence = if white {
        format!("residual white: local level at most {:.2}, over tenths of the band {segment_ratio:.2}, neighbouring lines correlate by {correlation:.3}", worst_local.0)
    } else if worst_local.0 > tol::WHITE_LOCAL {
        format!("residual {:.1} times the average around a mode (at {:.4} of the highest frequency)", worst_local.0, worst_local.1)
    } else if correlated > tol::WHITE_CORRELATION {
        format!("neighbouring residual lines correlate by {correlation:.2}")
    } else {
        format!("residual level differs {segment_ratio:.1} times over the band")
    };
    Whiteness { white, evidence, misfit_share: misfitted as f64 / looked_at.max(1) as f64 }
}
