//! Modes of a plate: natural frequencies, and mass-normalised shapes that can be asked
//! anywhere.

use crate::checks::not_negative;
use crate::edge_basis::EdgeBasis;
use crate::plate::Plate;
use crate::point_mass::PointMass;
use crate::point_spring::PointSpring;
use crate::ritz::{self, ModeRange};
use crate::tolerances::POINTS_AT_ONCE;
use crate::tolerances::{EDGE_SLACK, EXTRA_TERMS, MOST_BLOCK_TERMS};
use chladni_frf::{Error, Result};
use chladni_linalg::matmul;
use ndarray::{s, Array1, Array2};
use std::f64::consts::{PI, TAU};

/// Undamped modes of a plate, rigid-body modes first, then elastic modes by rising
/// frequency.
///
/// Shapes ψ_n are mass-normalised, ∫ ρh ψ_m ψ_n dA + Σ_k m_k ψ_m ψ_n = δ_mn, kg^{-1/2},
/// also within repeated frequencies; their sign makes the largest polynomial coefficient
/// positive.
#[derive(Debug, Clone)]
pub struct PlateModes {
    omega: Array1<f64>,
    rigid_count: usize,
    coefficients: Array2<f64>,
    bases: [EdgeBasis; 2],
    sides_m: [f64; 2],
}

impl PlateModes {
    /// All modes up to `frequency_hz`, and at least `least` elastic ones, with as many
    /// polynomials as they need.
    ///
    /// # Errors
    /// A plate that fails [`Plate::check`], masses off the plate, or more modes than a
    /// dense solution can serve.
    pub fn up_to(
        plate: &Plate,
        masses: &[PointMass],
        frequency_hz: f64,
        least: usize,
    ) -> Result<Self> {
        Self::held(plate, masses, &[], frequency_hz, least)
    }

    /// The same of a plate that springs hold, too.
    ///
    /// # Errors
    /// As [`Self::up_to`]; springs off the plate, or of no usable stiffness.
    pub fn held(
        plate: &Plate,
        masses: &[PointMass],
        springs: &[PointSpring],
        frequency_hz: f64,
        least: usize,
    ) -> Result<Self> {
        plate.check()?;
        let omega_max = TAU * frequency_hz;
        let [x, y] = needed_terms(plate, frequency_hz, least);
        if (x / 2.0).ceil() * (y / 2.0).ceil() > MOST_BLOCK_TERMS as f64 {
            return Err(Error::bad_data(format!(
                "about {:.0} modes lie below {frequency_hz} Hz, more than the plate simulator can \
                 find",
                plate.asymptotic_mode_count(omega_max)
            ))
            .field("frf.stop_hz")
            .found(format!("{frequency_hz} Hz"))
            .expected(format!(
                "a band that needs at most {MOST_BLOCK_TERMS} basis functions per \
                               symmetry"
            ))
            .help("lower stop_hz, or check thickness, stiffness and units of the plate"));
        }
        let terms = [x as usize, y as usize];
        let sides_m = [plate.length_m, plate.width_m];
        for spring in springs {
            natural_coordinates(spring.position_m, sides_m)?;
            not_negative("stiffness_n_per_m", spring.stiffness_n_per_m)?;
        }
        for mass in masses {
            natural_coordinates(mass.position_m, sides_m)?;
            if !(mass.mass_kg >= 0.0 && mass.mass_kg.is_finite()) {
                return Err(
                    Error::bad_data("a point mass must be finite and not negative")
                        .field("mass_kg")
                        .found(mass.mass_kg)
                        .expected("0 kg or more"),
                );
            }
        }
        let bases = [
            EdgeBasis::new(plate.edges.x, terms[0]),
            EdgeBasis::new(plate.edges.y, terms[1]),
        ];
        let loaded: Vec<PointMass> = masses
            .iter()
            .copied()
            .filter(|mass| mass.mass_kg > 0.0)
            .collect();
        let holds = |spring: &PointSpring| spring.stiffness_n_per_m > 0.0;
        let held: Vec<PointSpring> = springs.iter().copied().filter(holds).collect();
        let (rigid_count, modes) = ritz::solve(
            plate,
            &loaded,
            &held,
            [&bases[0], &bases[1]],
            ModeRange { omega_max, least },
        )?;
        let mut coefficients = Array2::zeros((terms[0] * terms[1], modes.len()));
        for (mut column, mode) in coefficients.columns_mut().into_iter().zip(&modes) {
            column.assign(&mode.coefficients);
        }
        let omega = modes.iter().map(|mode| mode.omega_squared.sqrt()).collect();
        Ok(Self {
            omega,
            rigid_count,
            coefficients,
            bases,
            sides_m,
        })
    }

    /// Natural frequencies ω_n, rad/s; exactly zero for rigid-body modes.
    pub fn omega(&self) -> &Array1<f64> {
        &self.omega
    }
    /// Natural frequencies ω_n/2π, Hz.
    pub fn frequency_hz(&self) -> Array1<f64> {
        self.omega.mapv(|omega| omega / TAU)
    }
    /// Number of rigid-body modes, which stand first.
    pub fn rigid_count(&self) -> usize {
        self.rigid_count
    }
    /// Number of modes, rigid-body modes included.
    pub fn len(&self) -> usize {
        self.omega.len()
    }
    /// True without modes.
    pub fn is_empty(&self) -> bool {
        self.omega.is_empty()
    }
    /// Polynomials along x and along y.
    pub fn terms(&self) -> [usize; 2] {
        [self.bases[0].terms(), self.bases[1].terms()]
    }

    /// Mass-normalised shapes ψ_n(x, y) at `points_m`, kg^{-1/2}; axes (point, mode).
    ///
    /// # Errors
    /// A point off the plate.
    pub fn evaluate(&self, points_m: &[[f64; 2]]) -> Result<Array2<f64>> {
        let mut shapes = Array2::zeros((points_m.len(), self.len()));
        for (chunk, start) in points_m
            .chunks(POINTS_AT_ONCE)
            .zip((0..).step_by(POINTS_AT_ONCE))
        {
            let mut products = Array2::zeros((chunk.len(), self.coefficients.nrows()));
            for (mut row, &point) in products.rows_mut().into_iter().zip(chunk) {
                let [xi, eta] = natural_coordinates(point, self.sides_m)?;
                let (x, y) = (self.bases[0].evaluate(xi), self.bases[1].evaluate(eta));
                for (value, (u, v)) in row
                    .iter_mut()
                    .zip(x.iter().flat_map(|u| y.iter().map(move |v| (u, v))))
                {
                    *value = u[0] * v[0];
                }
            }
            shapes
                .slice_mut(s![start..start + chunk.len(), ..])
                .assign(&matmul(products.view(), self.coefficients.view()));
        }
        Ok(shapes)
    }
}

/// Polynomials along x and y that resolve all modes up to `frequency_hz` and the first
/// `least`: one per half wave along the side, k·L/π, would be the least; Legendre
/// polynomials need π/2 of them, k·L/2, and a margin.
pub(crate) fn needed_terms(plate: &Plate, frequency_hz: f64, least: usize) -> [f64; 2] {
    let area = plate.length_m * plate.width_m;
    // Weyl's law without its edge term overestimates this frequency for free plates and
    // underestimates it for held ones
    let least_wavenumber =
        (4.0 * PI * least as f64 / area).sqrt() + PI * (1.0 / plate.length_m + 1.0 / plate.width_m);
    let wavenumber = plate.wavenumber(TAU * frequency_hz).max(least_wavenumber);
    [plate.length_m, plate.width_m]
        .map(|side| (wavenumber * side / 2.0).ceil() + EXTRA_TERMS as f64)
}

/// (ξ, η) of a point, −1..=1; points within a rounding of the edge are on it.
fn natural_coordinates(point_m: [f64; 2], sides_m: [f64; 2]) -> Result<[f64; 2]> {
    let natural = [0, 1].map(|d| 2.0 * point_m[d] / sides_m[d] - 1.0);
    match natural.iter().all(|c| c.abs() <= 1.0 + EDGE_SLACK) {
        true => Ok(natural.map(|c| c.clamp(-1.0, 1.0))),
        false => Err(Error::bad_data("the point does not lie on the plate")
            .found(format!("x = {} m, y = {} m", point_m[0], point_m[1]))
            .expected(format!("0 to {} m and 0 to {} m", sides_m[0], sides_m[1]))),
    }
}
