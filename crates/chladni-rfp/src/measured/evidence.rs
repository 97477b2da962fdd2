//! Evidence about one pole: what the residual, the neighbourhood and the other runs say
//! of it.

use super::limits::{FEWEST, MISFIT_WINDOW, PEAK_WINDOW, SURROUNDINGS};
use crate::damping::basis::basis;
use crate::data::columns::Columns;
use crate::measured::candidates::Origin;
use crate::measured::record::Record;
use crate::poles::refine::Refined;
use crate::tolerances as tol;
use ndarray::{s, Array1, Array2};
use num_complex::Complex64;

/// Evidence about one pole.
#[derive(Debug, Clone)]
pub(crate) struct Evidence {
    /// Pole.
    pub lambda: Complex64,
    /// The origin of the pole.
    pub origin: Origin,
    /// Relative rise of the local sum of squares without it.
    pub gain: f64,
    /// The same without the two nearest lines.
    pub gain_without_nearest: f64,
    /// The same without the four nearest lines.
    pub gain_of_skirts: f64,
    /// The part it explains over the part that noise of correlated lines lets a pole explain; `None`
    /// where lines are not correlated.
    pub over_noise: Option<f64>,
    /// Standard deviation over the half-width.
    pub deviation: f64,
    /// Scatter of its own poles over the FRFs, over the half-width; `None` where there is
    /// one FRF.
    pub scatter: Option<f64>,
    /// Rms residual over rms modal part within 1.5 half-widths.
    pub misfit: f64,
    /// Modal part over the whole response at its peak (amplitudes).
    pub part: f64,
    /// Half-width in lines.
    pub half_width_lines: f64,
    /// Height of the response over the median of its surroundings, dB.
    pub stands_out_db: f64,
    /// Distance to the nearer band edge in half-widths; negative outside.
    pub edge: f64,
    /// Highest response within its half-width, dB.
    pub level_db: f64,
    /// Largest residue over the next, dB; `None` where they are too few to say, or of
    /// mixtures.
    pub alone_db: Option<f64>,
    /// Σr²/Σ|r|² of its residues r: the angle is twice their mean phase, the modulus the root
    /// of their modal phase collinearity. `None` where they do not belong to one shape.
    pub mean_phase: Option<Complex64>,
}

impl Evidence {
    /// Distance of its positions on odd and even lines over the half-width.
    pub fn odd_even(&self) -> Option<f64> {
        match self.origin {
            Origin::Agreed { odd_even, .. } => odd_even.map(|d| d / self.lambda.im),
            _ => None,
        }
    }

    /// True where it may be a mode: inside the band.
    pub fn in_band(&self) -> bool {
        self.edge >= 0.0
    }
}

/// Collects what the residual and the neighbourhood show, both without line weights
/// (these would flatten the peaks); the fields that need other runs are filled by the
/// caller. `plain` and `residual` are a section's, `record` is the whole.
pub(crate) fn look(
    record: &Record,
    plain: &Columns,
    residual: &Array2<Complex64>,
    refined: &Refined,
    q: usize,
) -> Evidence {
    let lambda = refined.lambda[q];
    let window = plain.window(lambda, MISFIT_WINDOW.0, MISFIT_WINDOW.1);
    let local = plain.rows(window.clone());
    let strength = squares(refined.coefficients.row(q).iter());
    let modal = squares(basis(&local, &[lambda], &[]).iter()) * strength;
    let misfit = squares(residual.slice(s![window, ..]).iter());
    let response = squares(local.b.iter());
    let (low, high) = record.work.range();
    let unscaled = |scales: &Array1<f64>| {
        refined
            .coefficients
            .row(q)
            .iter()
            .zip(scales)
            .map(|(x, scale)| x * scale)
            .collect()
    };
    let residues: Option<Vec<Complex64>> = record
        .scales
        .as_ref()
        .filter(|scales| scales.len() >= FEWEST)
        .map(unscaled);
    let (level_db, stands_out_db) = height(record.work, lambda);
    Evidence {
        lambda,
        origin: Origin::Nuisance,
        gain: f64::MAX,
        gain_without_nearest: f64::MAX,
        gain_of_skirts: f64::MAX,
        over_noise: None,
        deviation: 0.0,
        scatter: None,
        misfit: (misfit / modal.max(tol::TINY)).sqrt(),
        part: (modal / response.max(tol::TINY)).sqrt(),
        half_width_lines: lambda.im / record.work.spacing(lambda.re),
        stands_out_db,
        edge: (lambda.re - low).min(high - lambda.re) / lambda.im,
        level_db,
        alone_db: residues.as_deref().map(alone_db),
        mean_phase: residues
            .filter(|_| record.one_reference)
            .map(|residues| mean_phase(&residues)),
    }
}

fn squares<'v>(values: impl Iterator<Item = &'v Complex64>) -> f64 {
    values.map(|v| v.norm_sqr()).sum()
}

fn alone_db(residues: &[Complex64]) -> f64 {
    let mut squares: Vec<f64> = residues.iter().map(|r| r.norm_sqr()).collect();
    squares.sort_by(|a, b| b.total_cmp(a));
    10.0 * (squares[0] / squares[1].max(tol::TINY)).log10()
}

fn mean_phase(residues: &[Complex64]) -> Complex64 {
    residues.iter().map(|r| r * r).sum::<Complex64>() / squares(residues.iter()).max(tol::TINY)
}

/// Response at the pole, dB, and the same over the median of the lines within 30 widths
/// (at least 30 lines).
fn height(work: &Columns, lambda: Complex64) -> (f64, f64) {
    let at = |k: usize| squares(work.b.row(k).iter()).max(tol::TINY);
    let near = work
        .window(lambda, PEAK_WINDOW.0, PEAK_WINDOW.1)
        .map(at)
        .fold(tol::TINY, f64::max);
    let mut around: Vec<f64> = work
        .window(lambda, SURROUNDINGS.0, SURROUNDINGS.1)
        .map(at)
        .collect();
    around.sort_by(f64::total_cmp);
    let median = around.get(around.len() / 2).copied().unwrap_or(near);
    (10.0 * near.log10(), 10.0 * (near / median).log10())
}
