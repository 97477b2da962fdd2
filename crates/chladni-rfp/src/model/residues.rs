//! The linear unknowns at given poles: residues, residual terms, and the change of the terms that
//! a change of the residues brings.

use crate::damping::basis::basis;
use crate::damping::law::is_rational;
use crate::damping::viscous::{halves, viscous_basis};
use crate::data::columns::Columns;
use crate::data::information;
use crate::poles::normal::{NormalFit, Partitioned};
use crate::poles::refine::Projection;
use crate::shapes::residues::schur_weight;
use chladni_frf::Damping;
use chladni_linalg::blocked::{blocked_matmul, interleaved};
use chladni_linalg::{lstsq, matmul, matmul_h, LinalgError};
use ndarray::{s, Array2, ShapeBuilder};
use num_complex::Complex64;

/// Residues (mode, FRF) and residual coefficients (term, FRF) in work units.
pub(crate) struct Linear {
    pub residues: Array2<Complex64>,
    pub terms: Array2<Complex64>,
    /// Weight of residues with the residual terms eliminated, (mode, mode).
    pub weight: Array2<Complex64>,
    /// Change of the residual terms with the residues.
    pub terms_per_residue: TermsPerResidue,
    /// Residual sum of squares of the compressed columns.
    pub sse: f64,
}

/// Residual terms per unit of residue that they give way to in the least-squares fit.
pub(crate) enum TermsPerResidue {
    /// Axes (term, mode).
    Complex(Array2<Complex64>),
    /// The same over the reals, real and imaginary part in turn on both axes.
    Real(Array2<f64>),
}

/// The linear fit at the poles: over complex residues where the law is rational in x, else over
/// pairs of reals.
pub(crate) fn linear(
    work: &Columns,
    damping: Damping,
    poles: &[Complex64],
    powers: &[i32],
) -> Result<Linear, LinalgError> {
    match is_rational(damping) {
        true => complex(work, poles, powers),
        false => real(work, poles, powers),
    }
}

/// Over complex residues.
fn complex(work: &Columns, poles: &[Complex64], powers: &[i32]) -> Result<Linear, LinalgError> {
    let n = poles.len();
    let Partitioned {
        coefficients,
        weight,
        terms_per_residue,
        sse,
    } = match NormalFit::at(work, poles, powers) {
        Some(fit) => fit.partitioned(n)?,
        None => on_orthonormal_basis(work, poles, powers)?,
    };
    Ok(Linear {
        residues: coefficients.slice(s![..n, ..]).to_owned(),
        terms: coefficients.slice(s![n.., ..]).to_owned(),
        weight,
        terms_per_residue: TermsPerResidue::Complex(terms_per_residue),
        sse,
    })
}

/// Over residues as pairs of reals.
fn real(work: &Columns, poles: &[Complex64], powers: &[i32]) -> Result<Linear, LinalgError> {
    let (n, terms) = (poles.len(), powers.len());
    let a = viscous_basis(work, poles, powers);
    let lines = work.lines();
    let b = halves(&work.b);
    // poles outside the band that have fused share their residue
    let solution = lstsq(a.view(), b.view()).or_else(|_| {
        let gram = matmul_h(a.view(), a.view());
        information::answer(gram.view(), matmul_h(a.view(), b.view()).view())
    })?;
    let sse = (&b - &matmul(a.view(), solution.view()))
        .iter()
        .map(|v| v * v)
        .sum();
    let complex_rows = |from: usize, count: usize| {
        Array2::from_shape_fn((count, work.columns()), |(i, c)| {
            Complex64::new(solution[[from + 2 * i, c]], solution[[from + 2 * i + 1, c]])
        })
    };
    // the weight of residues comes from the near pole alone: the far one adds a smooth part of
    // order η
    let near_pole = Array2::from_shape_fn((lines, n).f(), |(k, i)| {
        work.g[k] / (Complex64::new(0.0, work.x[k].sqrt()) - poles[i])
    });
    let residual_terms = basis(work, &[], powers);
    Ok(Linear {
        residues: complex_rows(0, n),
        terms: complex_rows(2 * n, terms),
        weight: schur_weight(&near_pole, &residual_terms)?,
        terms_per_residue: TermsPerResidue::Real(lstsq(
            a.slice(s![.., 2 * n..]),
            a.slice(s![.., ..2 * n]),
        )?),
        sse,
    })
}

/// The linear fit where normal equations lose too many digits.
fn on_orthonormal_basis(
    work: &Columns,
    poles: &[Complex64],
    powers: &[i32],
) -> Result<Partitioned, LinalgError> {
    let projection = Projection::new(work, poles, powers)?;
    let all = basis(work, poles, powers);
    let modes = all.slice(s![.., ..poles.len()]).to_owned();
    let terms = all.slice(s![.., poles.len()..]).to_owned();
    Ok(Partitioned {
        coefficients: projection.coefficients()?,
        weight: schur_weight(&modes, &terms)?,
        terms_per_residue: lstsq(terms.view(), modes.view())?,
        sse: projection.sse,
    })
}

impl TermsPerResidue {
    /// Changes the residual terms c after a `change` δr of the residues: c − (terms per residue)·δr,
    /// both (·, FRF).
    pub fn apply(&self, terms: &mut Array2<Complex64>, change: &Array2<Complex64>) {
        match self {
            Self::Complex(ratio) => *terms -= &blocked_matmul(ratio.view(), change.view()),
            Self::Real(ratio) => {
                let shift = blocked_matmul(ratio.view(), interleaved(change).view());
                for ((i, c), value) in terms.indexed_iter_mut() {
                    *value -= Complex64::new(shift[[2 * i, c]], shift[[2 * i + 1, c]]);
                }
            }
        }
    }
}
