//! Cramér-Rao bounds where each mode has one shape, whichever reference drives it: R_n,ij
//! = ψ_ni L_nj.
//!
//! The unknowns θ are the poles λ_n and the participations L_nj (the largest of each mode
//! held: a factor may move to ψ). With the shapes eliminated as free residues were in
//! [`crate::cramer_rao`], now in columns over lines and references together,
//!
//! Cov(θ) = σ² [ (Yᴴ P⊥ Y) ⊙ (Ψ̄ Ψᵀ) ]⁻¹,   y_λn = −g/(λ_n − x)² ⊗ L_n,   y_Lnj = g/(λ_n
//! − x) ⊗ e_j,
//!
//! where P⊥ projects out the columns g/(λ_n − x) ⊗ L_n and g ω^p ⊗ e_j, and the entry of
//! Ψ̄ Ψᵀ for two unknowns is that of their modes. With one reference nothing is left but
//! the poles, and the bound is that of free residues. Where ψ and L are known to be real,
//! Re λ_n and Im λ_n are unknowns of their own, with the columns y_λn and jy_λn, real
//! parts are taken of all products, and Cov(θ) = σ²/2 [...]⁻¹ (theory.md, eq. 34 and 35).
//! Derived from the Jacobian of the model; checked against it in `tests/panel/cramer_rao.rs`.

use crate::cramer_rao::{bound, gram, inverse_root, outside, CramerRao, Lines, PoleVariance};
use chladni_frf::{Error, ModalModel, Mode, Result};
use chladni_linalg::{matmul_h, qr_r, LinalgError};
use ndarray::{concatenate, Array1, Array2, Axis};
use num_complex::Complex64;

/// Bounds for the in-band modes of `model` as [`crate::cramer_rao`] gives them, with one
/// shape per mode for all references.
///
/// Costs about 8(2n·r)(n·r)² flop for n modes and r references (or responses, whichever
/// are fewer).
///
/// # Errors
/// As [`crate::cramer_rao`].
pub fn cramer_rao_rank_one(
    model: &ModalModel,
    frequency_hz: &Array1<f64>,
    noise_variance: f64,
    residual_powers: &[i32],
) -> Result<CramerRao> {
    bound(
        model,
        frequency_hz,
        noise_variance,
        residual_powers,
        |lines, modes| {
            let root = Structure::new(lines, modes)?.inverse_root(modes.len())?;
            Ok(PoleVariance::circular(&root))
        },
    )
}

/// The same where the shapes are known to be real, too.
///
/// Costs about twice as much in memory and time.
///
/// # Errors
/// As [`crate::cramer_rao`]; shapes or participations that are not real.
pub fn cramer_rao_real(
    model: &ModalModel,
    frequency_hz: &Array1<f64>,
    noise_variance: f64,
    residual_powers: &[i32],
) -> Result<CramerRao> {
    if model.in_band_modes().any(|mode| {
        mode.shape
            .0
            .iter()
            .chain(&mode.participation.0)
            .any(|value| value.im != 0.0)
    }) {
        return Err(
            Error::bad_data("the bound of real shapes needs real shapes")
                .field("shape")
                .found("a complex value"),
        );
    }
    bound(
        model,
        frequency_hz,
        noise_variance,
        residual_powers,
        |lines, modes| {
            let root = Structure::new(lines, modes)?
                .real()
                .inverse_root(2 * modes.len())?;
            let product = |a: usize, b: usize| {
                root.column(a)
                    .iter()
                    .zip(root.column(b))
                    .map(|(a, b)| (a.conj() * b).re)
                    .sum()
            };
            let variance = |n: usize| PoleVariance {
                re: product(n, n),
                im: product(n + modes.len(), n + modes.len()),
                cross: product(n, n + modes.len()),
            };
            Ok((0..modes.len()).map(variance).collect())
        },
    )
}

/// Columns over lines and references together, and the modes that they belong to.
struct Structure {
    /// g/(λ_n − x) ⊗ L_n.
    shapes: Array2<Complex64>,
    /// Those of the poles, then of the free participations.
    unknowns: Array2<Complex64>,
    /// Mode of each unknown.
    owner: Vec<usize>,
    /// Ψ̄ Ψᵀ over the modes.
    gram: Array2<Complex64>,
}

impl Structure {
    fn new(lines: &Lines, modes: &[&Mode]) -> std::result::Result<Self, LinalgError> {
        let short = |n: usize| long_and_short(modes[n])[1];
        // only scalar products of columns count: R of their QR stands for all lines
        let [modal, slopes] = lines.outside_residual_terms()?;
        let r = qr_r(concatenate![Axis(1), modal, slopes].view())?;
        let (height, count, references) = (r.nrows(), modes.len(), short(0).len());
        let free = |n: usize| {
            let held = largest(short(n));
            (0..references)
                .filter(move |&j| j != held)
                .map(move |j| (n, j))
        };
        let participations: Vec<(usize, usize)> = (0..count).flat_map(free).collect();
        let unknowns = Array2::from_shape_fn(
            (height * references, count + participations.len()),
            |(row, u)| {
                let (k, reference) = (row % height, row / height);
                match u.checked_sub(count).map(|p| participations[p]) {
                    None => r[[k, count + u]] * short(u)[reference],
                    Some((n, j)) if j == reference => r[[k, n]],
                    Some(_) => Complex64::default(),
                }
            },
        );
        Ok(Self {
            shapes: Array2::from_shape_fn((height * references, count), |(row, n)| {
                r[[row % height, n]] * short(n)[row / height]
            }),
            unknowns,
            owner: (0..count)
                .chain(participations.iter().map(|&(n, _)| n))
                .collect(),
            gram: gram(modes, |mode| long_and_short(mode)[0]),
        })
    }

    /// The same over the reals: the poles' columns times 1, then times j, then the
    /// participations; real and imaginary parts stacked.
    fn real(self) -> Self {
        let count = self.shapes.ncols();
        let (poles, participations) = self.unknowns.view().split_at(Axis(1), count);
        let turned = poles.mapv(|v| v * Complex64::i());
        let stacked = |columns: Array2<Complex64>| {
            concatenate![
                Axis(0),
                columns.mapv(|v| v.re.into()),
                columns.mapv(|v| v.im.into())
            ]
        };
        Self {
            unknowns: stacked(concatenate![Axis(1), poles, turned, participations]),
            shapes: stacked(self.shapes),
            owner: (0..count).chain(self.owner).collect(),
            gram: self.gram,
        }
    }

    /// The first `count` columns of a root of the inverse information, see
    /// [`inverse_root`].
    fn inverse_root(&self, count: usize) -> std::result::Result<Array2<Complex64>, LinalgError> {
        let columns = outside(&self.shapes, &self.unknowns)?;
        let mut information = matmul_h(columns.view(), columns.view());
        for ((u, v), value) in information.indexed_iter_mut() {
            *value *= self.gram[[self.owner[u], self.owner[v]]];
        }
        inverse_root(information, count)
    }
}

/// Shape and participation, or the other way round: the law is symmetric, and the longer
/// vectors are the ones to eliminate.
fn long_and_short(mode: &Mode) -> [&[Complex64]; 2] {
    let (shape, participation) = (mode.shape.0.as_slice(), mode.participation.0.as_slice());
    if shape.len() >= participation.len() {
        [shape, participation]
    } else {
        [participation, shape]
    }
}

/// Index of the largest entry.
fn largest(values: &[Complex64]) -> usize {
    (0..values.len()).fold(0, |best, j| {
        if values[j].norm_sqr() > values[best].norm_sqr() {
            j
        } else {
            best
        }
    })
}
