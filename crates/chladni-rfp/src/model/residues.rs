//! The linear unknowns at given poles: residues, residual terms, and how the one answers
//! a change of the other.

use crate::damping::law::is_rational;
use crate::damping::structural::basis;
use crate::damping::viscous::{halves, viscous_basis};
use crate::data::columns::Columns;
use crate::data::information;
use crate::poles::normal::{Parted, Plain};
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
    /// Response of the residual terms to a change of residues.
    pub answer: Answer,
    /// Sum of squares of the compressed columns at these poles.
    pub sse: f64,
}

/// A response of the residual terms to residues.
pub(crate) enum Answer {
    /// Axes (term, mode).
    Complex(Array2<Complex64>),
    /// The same over the reals, real and imaginary part in turn on both axes.
    Real(Array2<f64>),
}

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
    let Parted {
        coefficients,
        weight,
        answer,
        sse,
    } = match Plain::at(work, work.energy(), poles, powers) {
        Some(plain) => plain.parted(n)?,
        None => on_orthonormal_basis(work, poles, powers)?,
    };
    Ok(Linear {
        residues: coefficients.slice(s![..n, ..]).to_owned(),
        terms: coefficients.slice(s![n.., ..]).to_owned(),
        weight,
        answer: Answer::Complex(answer),
        sse,
    })
}

/// Over residues as pairs of reals.
fn real(work: &Columns, poles: &[Complex64], powers: &[i32]) -> Result<Linear, LinalgError> {
    let (n, p) = (poles.len(), powers.len());
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
    let pairs = |from: usize, count: usize| {
        Array2::from_shape_fn((count, work.columns()), |(i, c)| {
            Complex64::new(solution[[from + 2 * i, c]], solution[[from + 2 * i + 1, c]])
        })
    };
    // near-pole columns weigh the residues: the far pole adds a smooth part of
    // order η
    let near = Array2::from_shape_fn((lines, n).f(), |(k, i)| {
        work.g[k] / (Complex64::new(0.0, work.x[k].sqrt()) - poles[i])
    });
    let others = basis(work, &[], powers);
    Ok(Linear {
        residues: pairs(0, n),
        terms: pairs(2 * n, p),
        weight: schur_weight(&near, &others)?,
        answer: Answer::Real(lstsq(a.slice(s![.., 2 * n..]), a.slice(s![.., ..2 * n]))?),
        sse,
    })
}

/// The solution where the normal equations lose too many digits.
fn on_orthonormal_basis(
    work: &Columns,
    poles: &[Complex64],
    powers: &[i32],
) -> Result<Parted, LinalgError> {
    let projection = Projection::new(work, poles, powers)?;
    let all = basis(work, poles, powers);
    let (modes, others) = (
        all.slice(s![.., ..poles.len()]).to_owned(),
        all.slice(s![.., poles.len()..]).to_owned(),
    );
    Ok(Parted {
        coefficients: projection.coefficients()?,
        weight: schur_weight(&modes, &others)?,
        answer: lstsq(others.view(), modes.view())?,
        sse: projection.sse,
    })
}

impl Answer {
    /// Residual terms after residues changed by `change`: c − answer·δr, both (·, FRF).
    pub fn apply(&self, terms: &mut Array2<Complex64>, change: &Array2<Complex64>) {
        match self {
            Self::Complex(answer) => *terms -= &blocked_matmul(answer.view(), change.view()),
            Self::Real(answer) => {
                let shift = blocked_matmul(answer.view(), interleaved(change).view());
                for ((i, c), value) in terms.indexed_iter_mut() {
                    *value -= Complex64::new(shift[[2 * i, c]], shift[[2 * i + 1, c]]);
                }
            }
        }
    }
}
