//! Set-valued adaptive Antoulas–Anderson (AAA) in the plane x = ω².
//!
//! All columns share one barycentric form
//!
//! ```text
//! Z_l(x) ≈ Σ_j w_j Z_l(x_j)/(x − x_j)  /  Σ_j w_j/(x − x_j)
//! ```
//!
//! that interpolates at support lines x_j. Each step adds the line with the largest error
//! over all columns, and takes as weights the singular vector that minimises the
//! linearised error (theory.md, eq. 41) on the other lines, Σ_lk g_k² |Σ_j w_j (Z_l(x_k)
//! − Z_l(x_j))/(x_k − x_j)|². Poles are the zeros of the denominator; the residues decide
//! which of them are modes ([`super::selection`]).
//!
//! No start, no basis and no order of magnitude is needed, and clean data are reproduced
//! to rounding. Cost: 8·N·r·n³/3 flop for N lines, r mixtures and n support lines (a QR
//! of the Loewner matrix in each step).
//!
//! Avoid it on noisy data for the last digits. Interpolation takes over the noise of the
//! support lines, and the equation error is weighted by the denominator: five to ten
//! times as noisy as vector fitting.
//!
//! Y. Nakatsukasa, O. Sète, L. N. Trefethen, SIAM J. Sci. Comput. 40 (2018) A1494–A1522.
//! P. Lietaert, K. Meerbergen, J. Pérez, B. Vandereycken, IMA J. Numer. Anal. 42 (2022)
//! 1087–1115 (set-valued).

use super::limits::{POLISHING_STEP, POLISHING_STEPS, REPRODUCED};
use crate::data::columns::Columns;
use crate::data::error::FitError;
use crate::data::options::FitOptions;
use crate::methods::found::MethodPoles;
use crate::methods::selection::modes_of;
use crate::methods::survey::{Compressed, Survey};
use crate::poles::pool::mixtures;
use crate::poles::zeros::zeros;
use crate::tolerances as tol;
use chladni_linalg::{matmul, qr_r, svd_thin, LinalgError};
use ndarray::{concatenate, Array1, Array2, Axis, ShapeBuilder};
use num_complex::Complex64;
use rayon::prelude::*;

/// Poles by set-valued AAA.
///
/// # Errors
/// A decomposition that fails.
pub(crate) fn aaa(
    survey: &Survey,
    columns: &Compressed,
    options: &FitOptions,
) -> Result<MethodPoles, FitError> {
    let mixed = mixtures(&columns.work, tol::POOL_MIXTURES, options.seed);
    let rows = survey.rows();
    let mixed = if rows.len() < mixed.lines() {
        mixed.select(&rows)
    } else {
        mixed
    };
    let most = survey.pool_size(survey.expected(columns, options)) + 1;
    let poles = Barycentric::greedy(&mixed, most)?.poles()?;
    Ok(modes_of(
        survey,
        &poles,
        options,
        "barycentric interpolation in ω², poles chosen by their residues",
    )?)
}

/// Denominator Σ w_j/(x − x_j).
#[derive(Debug)]
struct Barycentric {
    support: Vec<f64>,
    weights: Vec<Complex64>,
}

impl Barycentric {
    /// Adds support lines until the data are reproduced, or `most` are used.
    fn greedy(work: &Columns, most: usize) -> Result<Self, LinalgError> {
        let mut f = work.b.clone();
        f.rows_mut()
            .into_iter()
            .zip(&work.g)
            .for_each(|(mut row, g)| row.mapv_inplace(|v| v / *g));
        let mut approximation = Array2::zeros(f.raw_dim());
        approximation += &(f.sum_axis(Axis(0)) / Complex64::new(f.nrows() as f64, 0.0));
        let size = |row: ndarray::ArrayView1<Complex64>, g: f64| {
            g * g * row.iter().map(|v| v.norm_sqr()).sum::<f64>()
        };
        let scale = f
            .rows()
            .into_iter()
            .zip(&work.g)
            .map(|(row, g)| size(row, *g))
            .fold(0.0, f64::max);
        let mut support: Vec<usize> = Vec::new();
        let mut rest: Vec<usize> = (0..work.lines()).collect();
        let mut weights = Vec::new();
        while support.len() < most && rest.len() > support.len() + 1 {
            let error = &f - &approximation;
            let errors = rest.iter().map(|&k| (k, size(error.row(k), work.g[k])));
            let Some((worst, largest)) = errors.max_by(|a, b| a.1.total_cmp(&b.1)) else {
                break;
            };
            if largest <= (REPRODUCED * REPRODUCED) * scale {
                break;
            }
            support.push(worst);
            rest.retain(|&k| k != worst);
            weights = loewner_weights(work, &f, &support, &rest)?;
            let wf = Array2::from_shape_fn((support.len(), f.ncols()), |(j, l)| {
                weights[j] * f[[support[j], l]]
            });
            let cauchy = Array2::from_shape_fn((rest.len(), support.len()).f(), |(k, j)| {
                Complex64::new(1.0 / (work.x[rest[k]] - work.x[support[j]]), 0.0)
            });
            let denominator = cauchy.dot(&Array1::from(weights.clone()));
            approximation.assign(&f);
            for ((&k, row), d) in rest
                .iter()
                .zip(matmul(cauchy.view(), wf.view()).rows())
                .zip(&denominator)
            {
                approximation.row_mut(k).assign(&row.mapv(|v| v / d));
            }
        }
        Ok(Self {
            support: support.iter().map(|&k| work.x[k]).collect(),
            weights,
        })
    }

    /// Zeros of the denominator. Times (x − x_m) it reads d + Σ_{j<m} c_j/(x_j − x) with
    /// d = Σ w and c_j = −w_j(x_j − x_m).
    fn poles(&self) -> Result<Vec<Complex64>, LinalgError> {
        let Some((&last, others)) = self.support.split_last() else {
            return Ok(Vec::new());
        };
        let at: Vec<Complex64> = others.iter().map(|&x| Complex64::new(x, 0.0)).collect();
        let c: Vec<Complex64> = others
            .iter()
            .zip(&self.weights)
            .map(|(x, w)| -w * (x - last))
            .collect();
        let sum: Complex64 = self.weights.iter().sum();
        let largest = self.weights.iter().map(|w| w.norm()).fold(0.0, f64::max);
        // a sum of rounding is a pole at infinity, which may as well lie very far out
        let d = if sum.norm() > f64::EPSILON * largest {
            sum
        } else {
            Complex64::new(f64::EPSILON * largest, 0.0)
        };
        Ok(zeros(&at, &c, d)?
            .into_iter()
            .map(|pole| self.polished(pole))
            .filter(|pole| pole.is_finite())
            .collect())
    }

    fn polished(&self, mut pole: Complex64) -> Complex64 {
        for _ in 0..POLISHING_STEPS {
            let (mut value, mut slope) = (Complex64::default(), Complex64::default());
            for (x, w) in self.support.iter().zip(&self.weights) {
                let inverse = 1.0 / (pole - x);
                value += w * inverse;
                slope -= w * inverse * inverse;
            }
            let step = value / slope;
            // a long step would leave for another zero
            if !step.is_finite() || step.norm() > POLISHING_STEP * pole.im.abs() {
                break;
            }
            pole -= step;
        }
        pole
    }
}

/// Right singular vector of the stacked weighted Loewner matrices for their smallest
/// singular value.
fn loewner_weights(
    work: &Columns,
    f: &Array2<Complex64>,
    support: &[usize],
    rest: &[usize],
) -> Result<Vec<Complex64>, LinalgError> {
    let blocks: Vec<Array2<Complex64>> = (0..f.ncols())
        .into_par_iter()
        .map(|l| {
            let loewner = Array2::from_shape_fn((rest.len(), support.len()).f(), |(k, j)| {
                let (row, at) = (rest[k], support[j]);
                (f[[row, l]] - f[[at, l]]) * (work.g[row] / (work.x[row] - work.x[at]))
            });
            qr_r(loewner.view())
        })
        .collect::<Result<_, _>>()?;
    let stacked = concatenate(
        Axis(0),
        &blocks.iter().map(|block| block.view()).collect::<Vec<_>>(),
    )
    .expect("equal widths");
    let (_, _, vh) = svd_thin(qr_r(stacked.view())?.view())?;
    Ok(vh.row(vh.nrows() - 1).iter().map(|v| v.conj()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Σ R_l/(λ − x) of two poles on even lines, residues of no pattern.
    fn two_poles() -> (Columns, [Complex64; 2]) {
        let poles = [Complex64::new(0.3, 0.004), Complex64::new(0.55, 0.01)];
        let x: Vec<f64> = (1..=200).map(|k| k as f64 / 200.0).collect();
        let residues = [[1.0, -0.7], [0.4, 1.3], [-1.1, 0.2]];
        let b = Array2::from_shape_fn((200, 3).f(), |(k, l)| {
            poles
                .iter()
                .zip(residues[l])
                .map(|(pole, r)| Complex64::new(r, 0.1 * r * r) / (pole - x[k]))
                .sum::<Complex64>()
        });
        (
            Columns {
                g: vec![1.0; x.len()],
                x,
                b,
                law: chladni_frf::Damping::Structural,
                leakage: None,
                neighbours: 0.0,
            },
            poles,
        )
    }

    #[test]
    fn a_rational_function_is_recognised_with_one_support_line_more_than_poles() {
        let (work, poles) = two_poles();
        let found = Barycentric::greedy(&work, 20).unwrap();
        assert_eq!(found.support.len(), 3);
        let zeros = found.poles().unwrap();
        for pole in poles {
            let nearest = zeros
                .iter()
                .map(|z| (z - pole).norm())
                .fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-13, "{pole}: {zeros:?}");
        }
    }

    #[test]
    fn zeros_of_a_known_denominator() {
        // 1/(x − 0) + 1/(x − 1) vanishes at 1/2; 1/x − 1/(x − 1) has its zero at infinity
        let one = Complex64::new(1.0, 0.0);
        let half = Barycentric {
            support: vec![0.0, 1.0],
            weights: vec![one, one],
        };
        assert!((half.poles().unwrap()[0] - 0.5).norm() < 1e-15);
        let infinite = Barycentric {
            support: vec![0.0, 1.0],
            weights: vec![one, -one],
        };
        assert!(infinite
            .poles()
            .unwrap()
            .iter()
            .all(|pole| pole.norm() > 1e12));
    }
}
