//! FRFs, coherence and variance of one line from its averaged products.
//!
//! With z = (x, y) of references x and response y, and G = Σ z·z^H:
//!
//! * H1 = G_yx·G_xx⁻¹, least squares with the error at y
//! * H2 = G_yy/G_xy, the error at x (one reference)
//! * Hv: the a with a^H·z = 0 that fits best in the sense of total least squares, each
//!   channel divided by its rms (so that its unit does not matter): the eigenvector of
//!   the least eigenvalue of G, H = −a_x*/a_y*. For one reference its magnitude is the
//!   geometric mean of H1 and H2, and its phase theirs.
//! * γ² = G_yx·G_xx⁻¹·G_xy/G_yy, the multiple coherence
//! * E|δH_j|² = G_yy(1 − γ²)·(G_xx⁻¹)_jj/(n − q): least squares with n independent blocks
//!   and q references (Bendat & Piersol, section 9.2; where blocks overlap, n is what
//!   they are worth)

use super::spectra::Averages;
use super::Estimator;
use crate::limits::SINGULAR;
use ndarray::{s, Array1, Array2};
use num_complex::Complex64;

/// One line.
#[derive(Debug, Clone)]
pub(super) struct LineEstimate {
    /// One per reference; NaN where it cannot be told.
    pub frf: Vec<Complex64>,
    /// E|δH|², one per reference; NaN where too few blocks were averaged.
    pub variance: Vec<f64>,
    /// Multiple coherence γ².
    pub coherence: f64,
}

impl LineEstimate {
    fn unknown(references: usize) -> Self {
        let nothing = Complex64::new(f64::NAN, f64::NAN);
        Self {
            frf: vec![nothing; references],
            variance: vec![f64::NAN; references],
            coherence: f64::NAN,
        }
    }
}

/// The line `k` of the averages.
pub(super) fn estimate_line(averages: &Averages, k: usize, estimator: Estimator) -> LineEstimate {
    let g = averages.products.slice(s![k, .., ..]);
    let references = g.nrows() - 1;
    // each channel by its rms: units and gains drop out
    let rms: Vec<f64> = (0..=references).map(|j| g[[j, j]].re.sqrt()).collect();
    if rms[..references]
        .iter()
        .any(|&rms| rms.is_nan() || rms <= 0.0)
    {
        return LineEstimate::unknown(references);
    }
    if rms[references] == 0.0 {
        // a response at rest
        return LineEstimate {
            frf: vec![Complex64::default(); references],
            variance: vec![0.0; references],
            coherence: f64::NAN,
        };
    }
    let scaled = Array2::from_shape_fn(g.dim(), |(i, j)| g[[i, j]] / (rms[i] * rms[j]));
    let Some((inverse, row)) = inverse_and_h1(&scaled) else {
        return LineEstimate::unknown(references);
    };
    let cross = scaled.slice(s![..references, references]);
    let coherence = row
        .iter()
        .zip(cross)
        .map(|(h, c)| (h * c).re)
        .sum::<f64>()
        .clamp(0.0, 1.0);
    let frf: Array1<Complex64> = match estimator {
        Estimator::H1 | Estimator::Lpm | Estimator::Lrm => row,
        Estimator::H2 if cross[0].norm() == 0.0 => return LineEstimate::unknown(references),
        Estimator::H2 => Array1::from_elem(1, cross[0].inv()),
        Estimator::Hv => match total_least_squares(&scaled) {
            Some(row) => row,
            None => return LineEstimate::unknown(references),
        },
    };
    let freedom = averages.independent - references as f64;
    let unit = |j: usize| rms[references] / rms[j];
    let variance = |j: usize| (1.0 - coherence) * inverse[[j, j]].re * unit(j).powi(2) / freedom;
    let variance = (0..references)
        .map(|j| if freedom > 0.0 { variance(j) } else { f64::NAN })
        .collect();
    let frf = frf.iter().enumerate().map(|(j, h)| h * unit(j)).collect();
    LineEstimate {
        frf,
        variance,
        coherence,
    }
}

/// G_xx⁻¹ and H1, of scaled products; `None` where references act as one.
fn inverse_and_h1(scaled: &Array2<Complex64>) -> Option<(Array2<Complex64>, Array1<Complex64>)> {
    let references = scaled.nrows() - 1;
    let inner = scaled.slice(s![..references, ..references]);
    if references == 1 {
        return Some((
            Array2::from_elem((1, 1), Complex64::from(1.0)),
            Array1::from_elem(1, scaled[[1, 0]]),
        ));
    }
    let (powers, _) = chladni_linalg::eigh(inner).ok()?;
    if powers
        .iter()
        .any(|&power| power.is_nan() || power < SINGULAR)
    {
        return None;
    }
    let inverse = chladni_linalg::inverse_hermitian(inner).ok()?;
    let row = scaled.slice(s![references, ..references]).dot(&inverse);
    Some((inverse, row))
}

/// −a_x*/a_y* of the eigenvector a of the least eigenvalue.
fn total_least_squares(scaled: &Array2<Complex64>) -> Option<Array1<Complex64>> {
    let references = scaled.nrows() - 1;
    if references == 1 {
        // the magnitude is one, in units of the rms values
        let cross = scaled[[1, 0]];
        return (cross.norm() > 0.0).then(|| Array1::from_elem(1, cross / cross.norm()));
    }
    let (_, vectors) = chladni_linalg::eigh(scaled.view()).ok()?;
    let least = vectors.column(0);
    let last = least[references];
    (last.norm() > 0.0).then(|| least.slice(s![..references]).mapv(|a| -(a / last).conj()))
}
