//! Cramér-Rao bounds where each mode has one shape, whichever reference drives it: R_n,ij = ψ_ni L_nj.
//!
//! The unknowns θ are the poles λ_n and the participations L_nj (the largest of each mode held: a factor may move to ψ). With the
//! shapes eliminated as free residues were in [`crate::cramer_rao`], now in columns over lines and references together,
//!
//! Cov(θ) = σ² [ (Yᴴ P⊥ Y) ⊙ (Ψ̄ Ψᵀ) ]⁻¹,   y_λn = −g/(λ_n − x)² ⊗ L_n,   y_Lnj = g/(λ_n − x) ⊗ e_j,
//!
//! where P⊥ projects out the columns g/(λ_n − x) ⊗ L_n and g ω^p ⊗ e_j, and the entry of Ψ̄ Ψᵀ for two unknowns is that of their
//! modes. With one reference nothing is left but the poles, and the bound is that of free residues. Derived from the Jacobian of
//! the model in the complex unknowns; checked against it entry by entry in `tests/cramer_rao.rs`.

use crate::cramer_rao::{bound, covariance, gram, outside, CramerRao, Lines};
use chladni_frf::{ModalModel, Mode, Result};
use chladni_linalg::{matmul_h, qr_r, LinalgError};
use ndarray::{concatenate, Array1, Array2, Axis};
use num_complex::Complex64;

/// Bounds for the in-band modes of `model` as [`crate::cramer_rao`] gives them, with one shape per mode for all references.
///
/// Costs about 8(2n·r)(n·r)² flop for n modes and r references (or responses, whichever are fewer).
///
/// # Errors
/// As [`crate::cramer_rao`].
pub fn cramer_rao_rank_one(
    model: &ModalModel,
    frequency_hz: &Array1<f64>,
    noise_variance: f64,
    residual_powers: &[i32],
) -> Result<CramerRao> {
    bound(model, frequency_hz, noise_variance, residual_powers, pole_variance)
}

/// E|δλ_n|²/σ² of the poles in the units of `lines`.
fn pole_variance(lines: &Lines, modes: &[&Mode]) -> std::result::Result<Vec<f64>, LinalgError> {
    let short = |n: usize| long_and_short(modes[n])[1];
    // only scalar products of columns count: R of their QR stands for all lines
    let [modal, slopes] = lines.outside_residual_terms()?;
    let r = qr_r(concatenate![Axis(1), modal, slopes].view())?;
    let (count, references) = (modes.len(), short(0).len());
    let unknowns: Vec<Unknown> = (0..count)
        .map(Unknown::Pole)
        .chain((0..count).flat_map(|n| {
            let held = largest(short(n));
            (0..references).filter(move |&j| j != held).map(move |j| Unknown::Participation(n, j))
        }))
        .collect();
    let height = r.nrows();
    let shapes = Array2::from_shape_fn((height * references, count), |(row, n)| r[[row % height, n]] * short(n)[row / height]);
    let columns = Array2::from_shape_fn((height * references, unknowns.len()), |(row, u)| match unknowns[u] {
        Unknown::Pole(n) => r[[row % height, count + n]] * short(n)[row / height],
        Unknown::Participation(n, j) if row / height == j => r[[row % height, n]],
        Unknown::Participation(..) => Complex64::default(),
    });
    let columns = outside(&shapes, &columns)?;
    let mut information = matmul_h(columns.view(), columns.view());
    let shape_gram = gram(modes, |mode| long_and_short(mode)[0]);
    for ((u, v), value) in information.indexed_iter_mut() {
        *value *= shape_gram[[unknowns[u].mode(), unknowns[v].mode()]];
    }
    covariance(information, count)
}

/// Shape and participation, or the other way round: the law is symmetric, and the longer vectors are the ones to eliminate.
fn long_and_short(mode: &Mode) -> [&[Complex64]; 2] {
    let (shape, participation) = (mode.shape.0.as_slice(), mode.participation.0.as_slice());
    if shape.len() >= participation.len() {
        [shape, participation]
    } else {
        [participation, shape]
    }
}

/// What is left when the shapes are eliminated.
#[derive(Debug, Clone, Copy)]
enum Unknown {
    /// λ_n.
    Pole(usize),
    /// L_nj.
    Participation(usize, usize),
}

impl Unknown {
    fn mode(self) -> usize {
        match self {
            Self::Pole(n) | Self::Participation(n, _) => n,
        }
    }
}

/// Index of the largest entry.
fn largest(values: &[Complex64]) -> usize {
    (0..values.len()).fold(0, |best, j| if values[j].norm_sqr() > values[best].norm_sqr() { j } else { best })
}
