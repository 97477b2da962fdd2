//! Modes folded into residual terms, and what exactly that leaves out.
//!
//! In x = ω² a structural mode is ψφᵀ/(s − x), s = ω_n²(1 + jη_n). Above the drive
//! frequency it is expanded in powers of x/s, below in powers of s/x, and the first P of
//! them join the residual terms of the model (powers 0, 2, 4 or −2, −4 of ω). The series
//! is geometric, so that what is left out is known to the last digit (theory.md, eq. 50):
//!
//! ψφᵀ/(s − x) − (first P terms) = q^P · ψφᵀ/(s − x),   q = x/s or s/x.
//!
//! In the viscous law the same holds in jω for each of the two poles, with twice as many
//! terms.

use crate::panel::operator::Operator;
use crate::tolerances;
use chladni_frf::{Damping, FrfKind, ModalModel, Mode, Trust};
use ndarray::Array2;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// The part of the mobility left out where a mode is folded: near·ψφᵀ + far·(ψφᵀ)*,
/// (m/s)/N.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Remainder {
    near: Complex64,
    far: Complex64,
}

/// A mode of the model and what folding it would leave out.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Foldable {
    /// Index among the modes of the model.
    pub(crate) mode: usize,
    pub(crate) remainder: Remainder,
    /// Rms of the remainder over responses and actuators in use, (m/s)/N.
    pub(crate) size: f64,
}

/// Every mode of the model that counts, in band or not, those that can be folded least
/// first.
pub(crate) fn ranked(model: &ModalModel, operator: &Operator) -> Vec<Foldable> {
    let indices = (0..model.modes.len()).filter(|&n| model.modes[n].trust != Trust::Rejected);
    let mut all: Vec<Foldable> = indices
        .map(|n| {
            let mode = &model.modes[n];
            let remainder = Remainder::of(mode, model.damping, operator.frequency_hz);
            let rms = |values: &[Complex64], picked: &[usize]| {
                (picked.iter().map(|&k| values[k].norm_sqr()).sum::<f64>() / picked.len() as f64)
                    .sqrt()
            };
            let size = (remainder.near.norm() + remainder.far.norm())
                * rms(&mode.shape.0, &operator.response_rows)
                * rms(&mode.participation.0, &operator.reference_columns);
            Foldable {
                mode: n,
                remainder,
                size,
            }
        })
        .collect();
    all.sort_by(|a, b| b.size.total_cmp(&a.size).then(a.mode.cmp(&b.mode)));
    all
}

impl Remainder {
    /// The part left out of `mode` at `frequency_hz`.
    pub(crate) fn of(mode: &Mode, damping: Damping, frequency_hz: f64) -> Self {
        let omega = TAU * frequency_hz;
        let mobility = FrfKind::Mobility.from_receptance(omega);
        match damping {
            Damping::Structural => {
                let factor = mode.structural_factor(omega);
                let x = Complex64::from(omega * omega);
                Self {
                    near: mobility
                        * factor
                        * left_out(x, factor.inv() + x, tolerances::FOLDED_TERMS),
                    far: Complex64::ZERO,
                }
            }
            Damping::Viscous => {
                let pole = mode.viscous_pole();
                let (j_omega, scale) = (
                    Complex64::new(0.0, omega),
                    Complex64::new(0.0, 2.0 * pole.im).inv(),
                );
                let terms = tolerances::FOLDED_TERMS.map(|count| 2 * count);
                let half = |scale: Complex64, pole: Complex64| {
                    mobility * scale / (j_omega - pole) * left_out(j_omega, pole, terms)
                };
                Self {
                    near: half(scale, pole),
                    far: half(scale.conj(), pole.conj()),
                }
            }
        }
    }

    /// Subtracts the remainder of `mode` from the mobility of `operator`.
    pub(crate) fn take_from(
        &self,
        mobility: &mut Array2<Complex64>,
        mode: &Mode,
        operator: &Operator,
    ) {
        for (i, &row) in operator.response_rows.iter().enumerate() {
            let sign = operator.responses[i].direction.sign();
            for (j, &column) in operator.reference_columns.iter().enumerate() {
                let product = mode.shape.0[row] * mode.participation.0[column];
                mobility[[i, j]] -= (self.near * product + self.far * product.conj()) * sign;
            }
        }
    }
}

/// q^P of the series of 1/(pole − at) or 1/(at − pole).
fn left_out(at: Complex64, pole: Complex64, [upper, lower]: [i32; 2]) -> Complex64 {
    match at.norm() < pole.norm() {
        true => (at / pole).powi(upper),
        false => (pole / at).powi(lower),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mode(frequency_hz: f64) -> Mode {
        Mode {
            frequency_hz,
            frequency_std_hz: 0.0,
            loss_factor: 0.02,
            loss_factor_std: 0.0,
            damping_ratio: 0.01,
            in_band: true,
            trust: Trust::Sure,
            reasons: Default::default(),
            mpc: 1.0,
            shape: Default::default(),
            shape_std: Vec::new(),
            scale_std: None,
            participation: Default::default(),
        }
    }

    #[test]
    fn the_remainder_is_the_mode_less_its_first_terms() {
        let [upper, lower] = tolerances::FOLDED_TERMS;
        let omega = TAU * 300.0;
        let mobility = Complex64::new(0.0, omega);
        for frequency_hz in [150.0, 290.0, 310.0, 700.0] {
            let mode = mode(frequency_hz);
            let (x, s) = (
                Complex64::from(omega * omega),
                (TAU * frequency_hz).powi(2) * Complex64::new(1.0, 0.02),
            );
            let series: Complex64 = match frequency_hz > 300.0 {
                true => (0..upper).map(|p| x.powi(p) / s.powi(p + 1)).sum(),
                false => (0..lower).map(|p| -s.powi(p) / x.powi(p + 1)).sum(),
            };
            let expected = mobility * ((s - x).inv() - series);
            let found = Remainder::of(&mode, Damping::Structural, 300.0);
            assert!(
                (found.near - expected).norm() < 1e-12 * (mobility / (s - x)).norm(),
                "{frequency_hz} Hz"
            );

            let (z, pole) = (mobility, mode.viscous_pole());
            let scale = Complex64::new(0.0, 2.0 * pole.im).inv();
            let series: Complex64 = match frequency_hz > 300.0 {
                true => (0..2 * upper).map(|p| -z.powi(p) / pole.powi(p + 1)).sum(),
                false => (0..2 * lower).map(|p| pole.powi(p) / z.powi(p + 1)).sum(),
            };
            let expected = mobility * scale * ((z - pole).inv() - series);
            let found = Remainder::of(&mode, Damping::Viscous, 300.0);
            assert!(
                (found.near - expected).norm() < 1e-9 * (mobility * scale / (z - pole)).norm(),
                "{frequency_hz} Hz, viscous"
            );
        }
    }
}
