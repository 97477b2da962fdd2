//! Natural frequencies and shapes of a thin plate by the Rayleigh-Ritz method.
//!
//! With w = Σ q_mn φ_m(ξ) φ_n(η), ξ = 2x/a − 1, η = 2y/b − 1 and orthonormal φ (see
//! `edge_basis`), strain and kinetic energy give K q = ω² M q, divided here by ρh ab/4 on
//! both sides (Leissa, *J. Sound Vib.* 31, 1973, 257-293, doi
//! 10.1016/S0022-460X(73)80371-2, eqs. 1-5, with polynomials in place of beam functions):
//!
//! K = (D/ρh) [ c_x⁴ A₂₂⊗I + c_y⁴ I⊗B₂₂ + ν c_x²c_y² (A₂₀⊗B₀₂ + A₀₂⊗B₂₀) + 2(1−ν)
//! c_x²c_y² A₁₁⊗B₁₁ ],  c_x = 2/a, c_y = 2/b,
//!
//! M = I + Σ_k m_k/(ρh ab/4) φ(x_k) φ(x_k)ᵀ
//!
//! for point masses m_k. Springs k_s at points add k_s/(ρh ab/4) φφᵀ to K, an elastic edge
//! of k N/m per m 2k/(ρh a)·φ_m(∓1)φ_p(∓1)⊗I. Two things keep the lowest frequencies exact
//! although K spans twelve decades:
//!
//! - rigid-body motions are polynomials of the basis with no strain energy; they are
//!   split off exactly (M loses a Schur complement, K is unchanged), so that K is
//!   positive definite;
//! - the inverse problem L⁻¹ M L⁻ᵀ y = ω⁻² y, K = L Lᵀ, is solved, whose largest
//!   eigenvalues are the lowest modes.
//!
//! Springs may leave some rigid-body motions and hold others: with them K + σM takes the
//! place of K, and σ is taken off the eigenvalues.
//!
//! Symmetric edges, masses and springs split the problem into parity classes.

use crate::edge_basis::{EdgeBasis, Integrals};
use crate::edges::Edge;
use crate::plate::Plate;
use crate::point_mass::PointMass;
use crate::point_spring::PointSpring;
use crate::tolerances::{SPRING_SHIFT, STILL_SHARE, SYMMETRY_SLACK};
use chladni_frf::{Error, ErrorKind, Result};
use chladni_linalg::{
    cholesky, eigh, matmul, matmul_h, solve_lower, solve_lower_adjoint, LinalgError,
};
use ndarray::{s, Array1, Array2, Axis};
use rayon::prelude::*;

/// The modes that are kept: all up to a frequency, and at least so many.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ModeRange {
    pub omega_max: f64,
    pub least: usize,
}

/// One mode: ω², and its mass-normalised coefficients over all products, x degree first.
#[derive(Clone)]
pub(crate) struct RitzMode {
    pub omega_squared: f64,
    pub coefficients: Array1<f64>,
}

/// Products φ_m φ_n, as (m, n).
type Products = Vec<(usize, usize)>;

/// Everything that one parity class needs.
struct Problem<'a> {
    plate: &'a Plate,
    x: Integrals,
    y: Integrals,
    terms: [usize; 2],
    /// √(m_k / (ρh ab/4)) φ_m φ_n at each mass; axes (mass, product).
    loads: Array2<f64>,
    /// √(k_s / (ρh ab/4)) φ_m φ_n at each spring, 1/s; axes (spring, product).
    springs: Array2<f64>,
    /// Products of degree along x, along y, that elastic edges add to K, 1/s².
    edges: [Array2<f64>; 2],
    /// σ, 1/s²; 0 without springs.
    shift: f64,
}

/// Rigid-body modes (ω = 0) first, then elastic modes by rising frequency.
pub(crate) fn solve(
    plate: &Plate,
    masses: &[PointMass],
    springs: &[PointSpring],
    bases: [&EdgeBasis; 2],
    range: ModeRange,
) -> Result<(usize, Vec<RitzMode>)> {
    let is_held = plate.edges.is_elastic() || !springs.is_empty();
    let problem = Problem {
        plate,
        x: bases[0].integrals(),
        y: bases[1].integrals(),
        terms: bases.map(EdgeBasis::terms),
        loads: point_loads(plate, &loads_of_masses(masses), bases),
        springs: point_loads(plate, &loads_of_springs(springs), bases),
        edges: edge_springs(plate, bases),
        shift: if is_held { SPRING_SHIFT } else { 0.0 },
    };
    let mirrors =
        |axis, side| masses_mirror(masses, axis, side) && springs_mirror(springs, axis, side);
    let symmetric_x = plate.edges.x[0] == plate.edges.x[1] && mirrors(0, plate.length_m);
    let symmetric_y = plate.edges.y[0] == plate.edges.y[1] && mirrors(1, plate.width_m);
    let blocks: Vec<Products> = parity_classes(problem.terms[0], symmetric_x)
        .iter()
        .flat_map(|m| {
            parity_classes(problem.terms[1], symmetric_y)
                .into_iter()
                .map(move |n| pairs(m, &n))
        })
        .collect();
    let solved: Vec<_> = blocks
        .par_iter()
        .map(|block| problem.solve_block(block, range))
        .collect::<std::result::Result<_, LinalgError>>()
        .map_err(|error| {
            Error::new(
                ErrorKind::Internal,
                format!("the plate's eigenvalue problem failed: {error}"),
            )
            .help("check the panel for extreme numbers")
        })?;
    let (mut rigid, mut elastic) = (Vec::new(), Vec::new());
    for (block_rigid, block_elastic) in solved {
        rigid.extend(block_rigid);
        elastic.extend(block_elastic);
    }
    elastic.sort_by(|a, b| a.omega_squared.total_cmp(&b.omega_squared));
    let kept = elastic
        .iter()
        .filter(|mode| mode.omega_squared <= range.omega_max.powi(2))
        .count()
        .max(range.least);
    elastic.truncate(kept);
    let rigid_count = rigid.len();
    rigid.extend(elastic);
    Ok((rigid_count, rigid))
}

impl Problem<'_> {
    /// Rigid and elastic modes within the products `block`.
    fn solve_block(
        &self,
        block: &[(usize, usize)],
        range: ModeRange,
    ) -> std::result::Result<(Vec<RitzMode>, Vec<RitzMode>), LinalgError> {
        let rigid_products = match self.shift > 0.0 {
            true => Vec::new(),
            false => self.plate.edges.rigid_products(),
        };
        let (rigid, elastic): (Vec<_>, Vec<_>) =
            block.iter().partition(|pair| rigid_products.contains(pair));
        let (load_r, load_e) = (self.loads_of(&rigid), self.loads_of(&elastic));

        let mass_re = matmul_h(load_r.view(), load_e.view());
        let (rigid_modes, factor_r) = self.rigid_modes(&rigid, &load_r)?;

        // elastic modes: what the rigid modes leave over
        let coupling = solve_lower(factor_r.view(), mass_re.view())?;
        let mut mass =
            matmul_h(load_e.view(), load_e.view()) - matmul_h(coupling.view(), coupling.view());
        mass.diag_mut().mapv_inplace(|m| m + 1.0);
        let stiffness = self.stiffness(&elastic) + &mass * self.shift;
        let factor = cholesky(stiffness.view())?;
        let half = solve_lower(factor.view(), mass.view())?;
        let inverse = solve_lower(factor.view(), half.t())?;
        let (inverse_omega_squared, vectors) = eigh(inverse.view())?;

        let limit = (range.omega_max.powi(2) + self.shift).recip();
        let kept = inverse_omega_squared
            .iter()
            .filter(|&&value| value >= limit)
            .count()
            .max(range.least)
            .min(elastic.len());
        let first = elastic.len() - kept;
        let shapes = solve_lower_adjoint(factor.view(), vectors.slice(s![.., first..]))?;
        // the rigid part that makes each elastic mode orthogonal to the rigid ones:
        // −M_rr⁻¹ M_re q
        let rigid_part = solve_lower_adjoint(
            factor_r.view(),
            matmul(coupling.view(), shapes.view()).view(),
        )?;
        let modes = (0..kept).rev().map(|k| {
            let value = inverse_omega_squared[first + k];
            let scale = 1.0 / value.sqrt();
            let (q, r) = (
                shapes.column(k).mapv(|v| v * scale),
                rigid_part.column(k).mapv(|v| -v * scale),
            );
            let omega_squared = 1.0 / value - self.shift;
            let moves = omega_squared > STILL_SHARE * self.shift;
            let omega_squared = if moves { omega_squared } else { 0.0 };
            self.mode(omega_squared, &[(&elastic, q), (&rigid, r)])
        });
        let (still, elastic_modes): (Vec<_>, Vec<_>) =
            modes.partition(|mode| mode.omega_squared == 0.0);
        Ok(([rigid_modes, still].concat(), elastic_modes))
    }

    /// Rigid modes of the products `rigid`, orthonormal in the loaded mass M_rr, and the
    /// Cholesky factor of M_rr.
    fn rigid_modes(
        &self,
        rigid: &Products,
        loads: &Array2<f64>,
    ) -> std::result::Result<(Vec<RitzMode>, Array2<f64>), LinalgError> {
        let mass = Array2::eye(rigid.len()) + matmul_h(loads.view(), loads.view());
        let factor = cholesky(mass.view())?;
        let shapes = solve_lower_adjoint(factor.view(), Array2::eye(rigid.len()).view())?;
        let modes = shapes
            .columns()
            .into_iter()
            .map(|q| self.mode(0.0, &[(rigid, q.to_owned())]))
            .collect();
        Ok((modes, factor))
    }

    /// K over the products in `pairs`, 1/s².
    fn stiffness(&self, pairs: &[(usize, usize)]) -> Array2<f64> {
        let (nu, scale) = (
            self.plate.poisson_ratio,
            self.plate.bending_stiffness() / self.plate.mass_per_area(),
        );
        let (cx2, cy2) = (
            (2.0 / self.plate.length_m).powi(2),
            (2.0 / self.plate.width_m).powi(2),
        );
        let (a, b) = (&self.x, &self.y);
        let springs = self.columns(&self.springs, pairs);
        let held = matmul_h(springs.view(), springs.view());
        let [along_x, along_y] = &self.edges;
        let bending = Array2::from_shape_fn((pairs.len(), pairs.len()), |(i, j)| {
            let ((m, n), (p, q)) = (pairs[i], pairs[j]);
            let mut sum = 2.0 * (1.0 - nu) * cx2 * cy2 * a.d11[[m, p]] * b.d11[[n, q]]
                + nu * cx2 * cy2 * (a.d20[[m, p]] * b.d20[[q, n]] + a.d20[[p, m]] * b.d20[[n, q]]);
            if n == q {
                sum += cx2 * cx2 * a.d22[[m, p]] + along_x[[m, p]] / scale;
            }
            if m == p {
                sum += cy2 * cy2 * b.d22[[n, q]] + along_y[[n, q]] / scale;
            }
            scale * sum
        });
        bending + held
    }

    fn loads_of(&self, pairs: &[(usize, usize)]) -> Array2<f64> {
        self.columns(&self.loads, pairs)
    }

    fn columns(&self, loads: &Array2<f64>, pairs: &[(usize, usize)]) -> Array2<f64> {
        let columns: Vec<usize> = pairs.iter().map(|&(m, n)| m * self.terms[1] + n).collect();
        loads.select(Axis(1), &columns)
    }

    /// Spreads the parts over all products, divides by √(ρh ab/4), and makes the largest
    /// coefficient positive.
    fn mode(&self, omega_squared: f64, parts: &[(&Products, Array1<f64>)]) -> RitzMode {
        let mut coefficients = Array1::zeros(self.terms[0] * self.terms[1]);
        for (pairs, values) in parts {
            for (&(m, n), value) in pairs.iter().zip(values) {
                coefficients[m * self.terms[1] + n] = value / (self.plate.mass() / 4.0).sqrt();
            }
        }
        let largest =
            coefficients.iter().fold(
                0.0f64,
                |largest, &c| if c.abs() > largest.abs() { c } else { largest },
            );
        RitzMode {
            omega_squared,
            coefficients: coefficients * largest.signum(),
        }
    }
}

/// A place, m, and the mass or stiffness there.
type PointLoad = ([f64; 2], f64);

fn loads_of_masses(masses: &[PointMass]) -> Vec<PointLoad> {
    masses
        .iter()
        .map(|mass| (mass.position_m, mass.mass_kg))
        .collect()
}

fn loads_of_springs(springs: &[PointSpring]) -> Vec<PointLoad> {
    springs
        .iter()
        .map(|spring| (spring.position_m, spring.stiffness_n_per_m))
        .collect()
}

/// Part of springs along the edges at x = ∓ and y = ∓ in the products of one degree.
fn edge_springs(plate: &Plate, bases: [&EdgeBasis; 2]) -> [Array2<f64>; 2] {
    let along = |edges: [Edge; 2], basis: &EdgeBasis, side: f64| {
        let scale = 2.0 * plate.stiffness_n_per_m2 / (plate.mass_per_area() * side);
        let mut sum = Array2::zeros((basis.terms(), basis.terms()));
        for (edge, xi) in edges.into_iter().zip([-1.0, 1.0]) {
            if edge == Edge::Elastic {
                let values = basis.evaluate(xi);
                sum +=
                    &Array2::from_shape_fn(sum.dim(), |(m, p)| scale * values[m][0] * values[p][0]);
            }
        }
        sum
    };
    [
        along(plate.edges.x, bases[0], plate.length_m),
        along(plate.edges.y, bases[1], plate.width_m),
    ]
}

fn point_loads(plate: &Plate, points: &[PointLoad], bases: [&EdgeBasis; 2]) -> Array2<f64> {
    let mut loads = Array2::zeros((points.len(), bases[0].terms() * bases[1].terms()));
    for (mut row, (position_m, load)) in loads.rows_mut().into_iter().zip(points) {
        let scale = (load / (plate.mass() / 4.0)).sqrt();
        let x = bases[0].evaluate(2.0 * position_m[0] / plate.length_m - 1.0);
        let y = bases[1].evaluate(2.0 * position_m[1] / plate.width_m - 1.0);
        for (value, (u, v)) in row
            .iter_mut()
            .zip(x.iter().flat_map(|u| y.iter().map(move |v| (u, v))))
        {
            *value = scale * u[0] * v[0];
        }
    }
    loads
}

/// The same of springs.
fn springs_mirror(springs: &[PointSpring], axis: usize, side: f64) -> bool {
    let as_masses = springs.iter().map(|spring| PointMass {
        position_m: spring.position_m,
        mass_kg: spring.stiffness_n_per_m,
    });
    masses_mirror(&as_masses.collect::<Vec<_>>(), axis, side)
}

/// True where every mass has a twin of the same weight mirrored along `axis`.
fn masses_mirror(masses: &[PointMass], axis: usize, side: f64) -> bool {
    masses.iter().all(|mass| {
        let mut mirrored = mass.position_m;
        mirrored[axis] = side - mirrored[axis];
        let near = |other: &PointMass| {
            (0..2).all(|d| (other.position_m[d] - mirrored[d]).abs() <= SYMMETRY_SLACK * side)
        };
        let weight = |at: &dyn Fn(&PointMass) -> bool| {
            masses
                .iter()
                .filter(|m| at(m))
                .map(|m| m.mass_kg)
                .sum::<f64>()
        };
        let here = |other: &PointMass| {
            (0..2)
                .all(|d| (other.position_m[d] - mass.position_m[d]).abs() <= SYMMETRY_SLACK * side)
        };
        (weight(&near) - weight(&here)).abs() <= SYMMETRY_SLACK * mass.mass_kg
    })
}

/// Degrees by parity where the problem is symmetric, all of them otherwise.
fn parity_classes(terms: usize, symmetric: bool) -> Vec<Vec<usize>> {
    match symmetric {
        true => (0..2)
            .map(|parity| (parity..terms).step_by(2).collect())
            .collect(),
        false => vec![(0..terms).collect()],
    }
}

fn pairs(m: &[usize], n: &[usize]) -> Products {
    m.iter()
        .flat_map(|&m| n.iter().map(move |&n| (m, n)))
        .collect()
}
