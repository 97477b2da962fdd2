//! A thin rectangular plate: sides, material, edges, and the numbers that follow from
//! them.

use crate::edges::Edges;
use crate::tolerances::{MOST_LOSS_FACTOR, THIN_PLATE_WAVELENGTH_PER_THICKNESS};
use chladni_frf::{Error, Result};
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Structural loss factor η: one for all modes, or one per elastic mode in rising order
/// of frequency.
///
/// The last entry holds for the rest where there are more modes than entries.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "expected a number or an array of numbers, one per elastic mode"
)]
pub enum LossFactor {
    /// The same for all modes.
    Common(f64),
    /// One per elastic mode.
    PerMode(Vec<f64>),
}

impl LossFactor {
    /// η of elastic mode `index`, counted from 0.
    pub fn of_mode(&self, index: usize) -> f64 {
        match self {
            Self::Common(eta) => *eta,
            Self::PerMode(list) => list.get(index).or(list.last()).copied().unwrap_or(0.0),
        }
    }
    /// All entries.
    pub fn entries(&self) -> &[f64] {
        match self {
            Self::Common(eta) => std::slice::from_ref(eta),
            Self::PerMode(list) => list,
        }
    }
}

/// A homogeneous isotropic thin plate in the x, y plane with a corner at the origin: the
/// `[plate]` section of a panel file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Plate {
    /// Side along x, m.
    pub length_m: f64,
    /// Side along y, m.
    pub width_m: f64,
    /// Thickness, m.
    pub thickness_m: f64,
    /// Young's modulus E, Pa.
    pub youngs_modulus_pa: f64,
    /// Poisson's ratio ν.
    pub poisson_ratio: f64,
    /// Density ρ, kg/m³.
    pub density_kg_per_m3: f64,
    /// Structural loss factor η.
    pub loss_factor: LossFactor,
    /// Supports of the edges.
    pub edges: Edges,
    /// Stiffness of elastic edges, N/m per m of edge.
    pub stiffness_n_per_m2: f64,
}

impl Default for Plate {
    /// The glass panel of the examples: 268 × 170 × 0.7 mm, free.
    fn default() -> Self {
        Self {
            length_m: 0.268,
            width_m: 0.170,
            thickness_m: 0.0007,
            youngs_modulus_pa: 71.5e9,
            poisson_ratio: 0.21,
            density_kg_per_m3: 2440.0,
            loss_factor: LossFactor::Common(0.010),
            edges: Edges::FREE,
            stiffness_n_per_m2: 0.0,
        }
    }
}

impl Plate {
    /// Bending stiffness D = E h³ / (12 (1 − ν²)), N·m.
    pub fn bending_stiffness(&self) -> f64 {
        self.youngs_modulus_pa * self.thickness_m.powi(3)
            / (12.0 * (1.0 - self.poisson_ratio * self.poisson_ratio))
    }
    /// Mass per area ρh, kg/m².
    pub fn mass_per_area(&self) -> f64 {
        self.density_kg_per_m3 * self.thickness_m
    }
    /// Mass, kg.
    pub fn mass(&self) -> f64 {
        self.mass_per_area() * self.length_m * self.width_m
    }
    /// Bending wavenumber k = (ρh ω²/D)^¼ of the infinite plate, rad/m.
    pub fn wavenumber(&self, omega: f64) -> f64 {
        (self.mass_per_area() / self.bending_stiffness()).powf(0.25) * omega.sqrt()
    }
    /// Half-wave count of Weyl's law, k² S/4π: how many modes lie below `omega`, edges
    /// left out.
    pub fn asymptotic_mode_count(&self, omega: f64) -> f64 {
        self.wavenumber(omega).powi(2) * self.length_m * self.width_m / (4.0 * PI)
    }
    /// True where the bending wave at `omega` is too short for the thin-plate equation.
    pub fn is_thick_at(&self, omega: f64) -> bool {
        2.0 * PI / self.wavenumber(omega) < THIN_PLATE_WAVELENGTH_PER_THICKNESS * self.thickness_m
    }

    /// Checks that every number is usable.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`] naming the key, as `plate.length_m`.
    pub fn check(&self) -> Result<()> {
        for (key, value) in [
            ("length_m", self.length_m),
            ("width_m", self.width_m),
            ("thickness_m", self.thickness_m),
            ("youngs_modulus_pa", self.youngs_modulus_pa),
            ("density_kg_per_m3", self.density_kg_per_m3),
        ] {
            crate::checks::positive(&format!("plate.{key}"), value)?;
        }
        if !(self.poisson_ratio > -1.0 && self.poisson_ratio < 0.5) {
            return Err(
                Error::bad_data("no isotropic material has this Poisson's ratio")
                    .field("plate.poisson_ratio")
                    .found(self.poisson_ratio)
                    .expected("a number above -1 and below 0.5"),
            );
        }
        if self.loss_factor.entries().is_empty() {
            return Err(Error::bad_data("no loss factor")
                .field("plate.loss_factor")
                .expected("a number, or one per elastic mode"));
        }
        self.loss_factor
            .entries()
            .iter()
            .try_for_each(|&eta| check_loss_factor(eta))?;
        crate::checks::not_negative("plate.stiffness_n_per_m2", self.stiffness_n_per_m2)?;
        if self.edges.is_elastic() && self.stiffness_n_per_m2 == 0.0 {
            return Err(Error::bad_data("an elastic edge has a stiffness")
                .field("plate.stiffness_n_per_m2")
                .found(0.0)
                .expected("N/m per m of edge, above 0")
                .help("call the edge F where nothing holds it"));
        }
        let shortest = self.length_m.min(self.width_m);
        if self.thickness_m > shortest / 10.0 {
            return Err(Error::bad_data(
                "this is no thin plate: its thickness exceeds a tenth of \
                                        its shorter side",
            )
            .field("plate.thickness_m")
            .found(self.thickness_m)
            .expected(format!("at most {}", shortest / 10.0))
            .help(
                "check the units (all lengths are in metres); a thick plate needs shear \
                       deformation, which is not modelled",
            ));
        }
        let scale = self.bending_stiffness() / self.mass_per_area();
        if !(scale.is_normal() && self.mass().is_normal()) {
            return Err(Error::bad_data(
                "the plate's stiffness or mass leaves the range of the computer's numbers",
            )
            .field("plate"));
        }
        Ok(())
    }
}

fn check_loss_factor(eta: f64) -> Result<()> {
    crate::checks::positive("plate.loss_factor", eta)?;
    match eta <= MOST_LOSS_FACTOR {
        true => Ok(()),
        false => Err(Error::bad_data("a plate that does not ring")
            .field("plate.loss_factor")
            .found(eta)
            .expected(format!("a number above 0, at most {MOST_LOSS_FACTOR}"))
            .help("write 0.01 for one per cent")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_glass_panel_has_the_stiffness_mass_and_wavelength_of_its_data_sheet() {
        let plate = Plate::default();
        assert!((plate.bending_stiffness() - 2.138).abs() < 5e-4);
        assert!((plate.mass() - 0.0778).abs() < 5e-5);
        let wavelength = 2.0 * PI / plate.wavenumber(2.0 * PI * 300.0);
        assert!((wavelength - 0.153).abs() < 5e-4, "{wavelength}");
    }

    #[test]
    fn only_free_and_once_hinged_plates_move_as_rigid_bodies() {
        let count = |text: &str| {
            Edges::try_from(text.to_string())
                .unwrap()
                .rigid_products()
                .len()
        };
        assert_eq!(
            ["FFFF", "SFFF", "FFFS", "SSFF", "SFSF", "CFFF"].map(count),
            [3, 1, 1, 0, 0, 0]
        );
    }

    #[test]
    fn the_last_loss_factor_holds_for_all_further_modes() {
        let eta = LossFactor::PerMode(vec![0.01, 0.02]);
        assert_eq!(
            [0, 1, 2, 9].map(|n| eta.of_mode(n)),
            [0.01, 0.02, 0.02, 0.02]
        );
    }

    #[test]
    fn a_thickness_in_millimetres_is_refused_with_advice() {
        let error = Plate {
            thickness_m: 0.7,
            ..Plate::default()
        }
        .check()
        .unwrap_err();
        assert!(error.to_string().contains("metres"), "{error}");
    }
}
