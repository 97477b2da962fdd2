//! The panel as a rigid body, from the residual −R/ω² of its receptance.
//!
//! R = U·K·Vᵀ·G with rows u = [1 x y] of the responses, v of the references, gains G of the
//! channels, and K the inverse of the mass matrix [[M, Mx̄, Mȳ], …] about the origin of the
//! panel. U⁺R leaves K·V·G: K up to a factor, and gains up to its inverse. Gains of mean 1
//! make the difference.

use super::places::Places;
use crate::panel::Panel;
use crate::tolerances;
use chladni_frf::{Error, ErrorKind, ModalModel, Result};
use chladni_linalg::lstsq;
use ndarray::{Array1, Array2, Axis};

/// Mass and inertia of a panel, and gains of its channels.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct RigidBody {
    /// Mass, coils included, kg.
    pub mass_kg: f64,
    /// Centre of mass, m.
    pub centre_m: [f64; 2],
    /// Moments about the axes along x and along y through it, kg m².
    pub inertia_kg_m2: [f64; 2],
    /// Gain of each channel relative to their mean.
    pub gains: Vec<f64>,
    /// Mass of each coil: what is more than the plate, kg; 0 where nothing is.
    pub coil_mass_kg: f64,
}

impl RigidBody {
    /// `None` where the residual holds no rigid body: the plate is held, the band begins
    /// above the first mode, or too few places for three motions.
    pub(super) fn of(model: &ModalModel, places: &Places, panel: &Panel) -> Result<Option<Self>> {
        let first_hz = model
            .in_band_modes()
            .map(|mode| mode.frequency_hz)
            .fold(f64::INFINITY, f64::min);
        let is_free = panel.plate.edges.rigid_products().len() == 3
            && panel.references.stiffness_n_per_m == 0.0;
        let begins = model.band_hz[0] <= tolerances::RIGID_BAND * first_hz;
        let [rows, columns] = [&places.responses_m, &places.references_m].map(Vec::len);
        let terms = &model.residual_terms;
        let term = terms.terms.iter().find(|term| term.power == -2);
        let (Some(term), true, true, true) = (term, is_free, begins, rows.min(columns) > 3) else {
            return Ok(None);
        };
        let mut residual = term
            .matrix
            .0
            .mapv(|value| -value.re * terms.omega_scale_rad_per_s.powi(2));
        for (mut row, sign) in residual.rows_mut().into_iter().zip(&places.response_signs) {
            row.mapv_inplace(|value| value * sign);
        }
        for (mut column, sign) in residual
            .columns_mut()
            .into_iter()
            .zip(&places.reference_signs)
        {
            column.mapv_inplace(|value| value * sign);
        }
        let [u, v] = [&places.responses_m, &places.references_m].map(|places| motions(places));
        let seen = lstsq(u.view(), residual.view()).map_err(unsolvable)?;
        let (compliance, gains) = split(&seen, &v)?;
        let mass = chladni_linalg::inverse_hermitian(compliance.view());
        let Ok(mass) = mass else {
            // noise: no mass matrix at all
            return Ok(None);
        };
        let mass_kg = mass[[0, 0]];
        let centre_m = [mass[[0, 1]], mass[[0, 2]]].map(|moment| moment / mass_kg);
        let about = |k: usize| mass[[k + 1, k + 1]] - mass_kg * centre_m[k].powi(2);
        let own = mass_kg - panel.plate.mass();
        Ok(Some(Self {
            mass_kg,
            centre_m,
            inertia_kg_m2: [about(1), about(0)],
            coil_mass_kg: own.max(0.0) / columns as f64,
            gains: gains.to_vec(),
        }))
    }
}

/// Rows [1 x y].
fn motions(places_m: &[[f64; 2]]) -> Array2<f64> {
    Array2::from_shape_fn((places_m.len(), 3), |(k, motion)| match motion {
        0 => 1.0,
        _ => places_m[k][motion - 1],
    })
}

/// K, symmetric, and gains g of mean 1 of `seen` = K·vⱼ·gⱼ, by turns.
fn split(seen: &Array2<f64>, v: &Array2<f64>) -> Result<(Array2<f64>, Array1<f64>)> {
    let mut gains = Array1::<f64>::ones(v.nrows());
    let mut compliance = Array2::zeros((3, 3));
    for _ in 0..tolerances::GAIN_ROUNDS {
        let mut driven = v.clone();
        for (mut row, gain) in driven.rows_mut().into_iter().zip(&gains) {
            row.mapv_inplace(|value| value * gain);
        }
        let k = lstsq(driven.view(), seen.t()).map_err(unsolvable)?;
        compliance = (&k + &k.t()) * 0.5;
        let whole = compliance.dot(&v.t());
        let new: Array1<f64> = whole
            .axis_iter(Axis(1))
            .zip(seen.axis_iter(Axis(1)))
            .map(|(whole, seen)| whole.dot(&seen) / whole.dot(&whole))
            .collect();
        gains = &new / (new.sum() / new.len() as f64);
    }
    Ok((compliance, gains))
}

fn unsolvable(error: chladni_linalg::LinalgError) -> Error {
    Error::new(
        ErrorKind::BadData,
        format!("the rigid-body residual cannot be solved: {error}"),
    )
    .help("are the responses and references spread over the panel?")
}
