//! A finger on the panel: a rank-one change of its mobility.
//!
//! With the impedance Z of the fingertip at the place f, and F the force on the finger,
//! v_f = v_f,free − Y_ff·F and F = Z·v_f, so that
//!
//! v = v_free − y_f · (1/Z + Y_ff)⁻¹ · v_f,free
//! (theory.md, eq. 52)
//!
//! with the mobility y_f from f to everywhere. Actuators do not sit under the finger, so
//! that y_f comes from the modes alone: Σ γ_n ψ_n(x) ψ_n(f), which needs mass-scaled
//! shapes. Residual terms are known only for the actuators and are left out of it: on the
//! panel of the study they are below 5 % of 1/Z at 300 Hz.

use crate::panel::field::Field;
use crate::scene::plane::Position;
use crate::scene::zones::Ground;
use crate::tolerances;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// A fingertip: damper, mass and spring to the ground, all at one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Finger {
    /// N·s/m.
    pub damping_n_s_per_m: f64,
    /// kg.
    pub mass_kg: f64,
    /// N/m.
    pub stiffness_n_per_m: f64,
}

impl Default for Finger {
    fn default() -> Self {
        Self::MID
    }
}

/// Fingertips of the order that measurements report (Lundström 1984; Pawluk and Howe 1999;
/// Wiertlewski and Hayward 2012), from memory; none of them was measured here.
impl Finger {
    /// A finger that rests lightly.
    pub const LIGHT: Self = Self {
        damping_n_s_per_m: 0.5,
        mass_kg: 0.10e-3,
        stiffness_n_per_m: 800.0,
    };
    /// The usual touch.
    pub const MID: Self = Self {
        damping_n_s_per_m: 1.5,
        mass_kg: 0.15e-3,
        stiffness_n_per_m: 1500.0,
    };
    /// A finger that presses.
    pub const FIRM: Self = Self {
        damping_n_s_per_m: 4.0,
        mass_kg: 0.30e-3,
        stiffness_n_per_m: 3000.0,
    };

    /// A mass that is glued on.
    pub fn of_mass(mass_kg: f64) -> Self {
        Self {
            damping_n_s_per_m: 0.0,
            mass_kg,
            stiffness_n_per_m: 0.0,
        }
    }

    /// Force over velocity, N·s/m.
    pub fn impedance(&self, frequency_hz: f64) -> Complex64 {
        let omega = TAU * frequency_hz;
        Complex64::new(
            self.damping_n_s_per_m,
            omega * self.mass_kg - self.stiffness_n_per_m / omega,
        )
    }
}

/// Places where fingers are tried: the hot response nearest to the middle of all hot
/// ones, and the two that are farthest from it on either side.
pub fn finger_places(field: &Field) -> Vec<Position> {
    finger_rows(field)
        .into_iter()
        .map(|k| field.positions_m[k])
        .collect()
}

/// The same as rows of the field.
pub(crate) fn finger_rows(field: &Field) -> Vec<usize> {
    finger_rows_of(&field.ground, &field.positions_m)
}

/// The same of places and what is asked of them.
pub(crate) fn finger_rows_of(ground: &[Ground], positions_m: &[Position]) -> Vec<usize> {
    let hot: Vec<usize> = (0..ground.len())
        .filter(|&k| ground[k] == Ground::Hot)
        .collect();
    let middle = [0, 1]
        .map(|axis| hot.iter().map(|&k| positions_m[k][axis]).sum::<f64>() / hot.len() as f64);
    // in steps of the positions' tolerance: rounding must not choose among equal distances
    let distance = |a: Position, b: Position| {
        ((a[0] - b[0]).hypot(a[1] - b[1]) / tolerances::POSITION_M).round()
    };
    let at = |k: usize| positions_m[k];
    let by = |key: &dyn Fn(usize) -> f64| {
        hot.iter()
            .copied()
            .min_by(|&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)))
    };
    let Some(central) = by(&|k| distance(at(k), middle)) else {
        return Vec::new();
    };
    let far = by(&|k| -distance(at(k), middle)).unwrap_or(central);
    let other = by(&|k| -distance(at(k), at(far))).unwrap_or(central);
    let mut rows = vec![central, far, other];
    rows.dedup();
    rows
}
