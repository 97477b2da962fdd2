//! FRFs of a modal model.

use crate::{Damping, FrfKind, ModalModel, Mode, Trust};
use ndarray::{Array1, Array2, Array3, ArrayView2};
use num_complex::Complex64;
use std::f64::consts::TAU;

impl Mode {
    /// The factor of shape·participation in the receptance at `omega` rad/s, for a
    /// structural mode (theory.md, eq. 3): 1/(ω_n²(1+jη_n) − ω²).
    pub fn structural_factor(&self, omega: f64) -> Complex64 {
        let omega_n = TAU * self.frequency_hz;
        Complex64::new(1.0, 0.0)
            / Complex64::new(
                omega_n * omega_n - omega * omega,
                omega_n * omega_n * self.loss_factor,
            )
    }

    /// The factors of shape·participation, and of the product of their conjugates, in the
    /// receptance at `omega` rad/s (theory.md, eqs. 3 and 4).
    pub fn receptance_factors(&self, law: Damping, omega: f64) -> [Complex64; 2] {
        match law {
            Damping::Structural => [self.structural_factor(omega), Complex64::ZERO],
            Damping::Viscous => {
                let pole = self.viscous_pole();
                let j_omega = Complex64::new(0.0, omega);
                let scale = Complex64::new(0.0, 2.0 * pole.im).inv();
                [
                    scale / (j_omega - pole),
                    scale.conj() / (j_omega - pole.conj()),
                ]
            }
        }
    }

    /// The pole s_n = −ζ_nω_n + jω_n√(1−ζ_n²), rad/s, of the viscous law (ζ_n = η_n/2).
    pub fn viscous_pole(&self) -> Complex64 {
        let (omega_n, zeta) = (TAU * self.frequency_hz, self.loss_factor / 2.0);
        Complex64::new(
            -zeta * omega_n,
            omega_n * (1.0 - zeta * zeta).max(0.0).sqrt(),
        )
    }
}

impl ModalModel {
    /// Receptance of every pair at `frequency_hz`, m per unit of the reference; axes
    /// (response, reference).
    pub fn receptance(&self, frequency_hz: f64) -> Array2<Complex64> {
        self.receptance_by(|a, b| a.dot(&b), frequency_hz)
    }

    /// As [`Self::receptance`], with a `product` of matrices that the caller has.
    pub fn receptance_by(
        &self,
        product: impl FnOnce(ArrayView2<Complex64>, ArrayView2<Complex64>) -> Array2<Complex64>,
        frequency_hz: f64,
    ) -> Array2<Complex64> {
        let [shapes, participations] = self.halves(TAU * frequency_hz);
        let alpha = product(shapes.t(), participations.view());
        // in the order of the residual terms
        let mut alpha = alpha.as_standard_layout().into_owned();
        let rest = &self.residual_terms;
        let over_scale = TAU * frequency_hz / rest.omega_scale_rad_per_s;
        for term in &rest.terms {
            alpha.scaled_add(over_scale.powi(term.power).into(), &term.matrix.0);
        }
        alpha
    }

    /// The receptance of the modes at `omega` rad/s as a product: shapes times factors, axes
    /// (half, response), and participations, axes (half, reference). A mode is one half
    /// where its damping is structural, two of conjugates where it is viscous.
    fn halves(&self, omega: f64) -> [Array2<Complex64>; 2] {
        let counts = |mode: &&Mode| mode.trust != Trust::Rejected;
        let modes: Vec<&Mode> = self.modes.iter().filter(counts).collect();
        let each = match self.damping {
            Damping::Structural => 1,
            Damping::Viscous => 2,
        };
        let zeros = |columns| Array2::zeros((each * modes.len(), columns));
        let [mut shapes, mut participations] =
            [&self.responses, &self.references].map(|dofs| zeros(dofs.len()));
        for (n, mode) in modes.iter().enumerate() {
            let factors = mode.receptance_factors(self.damping, omega);
            for (half, factor) in factors.into_iter().take(each).enumerate() {
                let turned = |value: &Complex64| if half == 0 { *value } else { value.conj() };
                let row = each * n + half;
                let shape = shapes.row_mut(row).into_iter().zip(&mode.shape.0);
                shape.for_each(|(place, value)| *place = factor * turned(value));
                let row = participations.row_mut(row).into_iter();
                row.zip(&mode.participation.0)
                    .for_each(|(place, value)| *place = turned(value));
            }
        }
        [shapes, participations]
    }

    /// The matrix of `kind` at one frequency: [`Self::receptance`] times 1, jω or −ω².
    pub fn frf_matrix(&self, kind: FrfKind, frequency_hz: f64) -> Array2<Complex64> {
        let factor = kind.from_receptance(TAU * frequency_hz);
        self.receptance(frequency_hz).mapv(|alpha| factor * alpha)
    }

    /// FRFs in the measured kind on a frequency axis; axes (response, reference, line).
    pub fn synthesise(&self, frequency_hz: &Array1<f64>) -> Array3<Complex64> {
        let mut frf = Array3::zeros((
            self.responses.len(),
            self.references.len(),
            frequency_hz.len(),
        ));
        for (k, &f) in frequency_hz.iter().enumerate() {
            frf.slice_mut(ndarray::s![.., .., k])
                .assign(&self.frf_matrix(self.frf_kind, f));
        }
        frf
    }
}
