//! The plane in which a damping law makes a rational fraction simple.
//!
//! | law | variable t | coefficients | degree of n modes |
//! |---|---|---|---|
//! | structural | x = ω²/ω_max², mapped to [−1, 1] | complex | n |
//! | viscous | y = ω/ω_max, even weights, p_k times jᵏ | real | 2n |
//!
//! In both a damped mode has its root in the upper half plane of t. Poles come and go as λ
//! of their law (theory.md, eq. 5 and 16).

use crate::damping::limits::RESIDUAL_TERMS;
use crate::damping::places::s_of_lambda;
use crate::damping::places::viscous_pole_of;
use chladni_frf::Damping;
use num_complex::Complex64;

/// Variable, field of the coefficients, and the way back to poles.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plane {
    law: Damping,
    /// t = (x − centre)/scale, or √x/scale.
    centre: f64,
    scale: f64,
}

impl Plane {
    /// For the lines `x`, rising.
    pub fn new(law: Damping, x: &[f64]) -> Self {
        let (low, high) = (x[0], x[x.len() - 1]);
        let (centre, scale) = match law {
            Damping::Structural => (0.5 * (low + high), 0.5 * (high - low)),
            Damping::Viscous => (0.0, high.sqrt()),
        };
        Self {
            law,
            centre,
            scale: scale.max(f64::MIN_POSITIVE),
        }
    }

    /// t of a line.
    pub fn node(&self, x: f64) -> f64 {
        match self.law {
            Damping::Structural => (x - self.centre) / self.scale,
            Damping::Viscous => x.sqrt() / self.scale,
        }
    }

    /// True where weights are even in t.
    pub fn is_even(&self) -> bool {
        self.law == Damping::Viscous
    }

    /// Degree of the denominator of so many modes.
    pub fn denominator(&self, modes: usize) -> usize {
        modes * self.roots_per_mode()
    }

    /// Degree of the numerators over x.
    pub fn numerator(&self, modes: usize) -> usize {
        (modes + RESIDUAL_TERMS) * self.roots_per_mode()
    }

    fn roots_per_mode(&self) -> usize {
        match self.law {
            Damping::Structural => 1,
            Damping::Viscous => 2,
        }
    }

    /// Factor of p_k.
    pub fn turn(&self, k: usize) -> Complex64 {
        match self.law {
            Damping::Structural => Complex64::new(1.0, 0.0),
            Damping::Viscous => Complex64::i().powu((k % 4) as u32),
        }
    }

    /// Product of polynomials i* and k, of which `sum` is that of the real factors alone,
    /// in the field of the coefficients.
    pub fn product(&self, i: usize, k: usize, sum: Complex64) -> Complex64 {
        self.in_field(self.turn(i).conj() * self.turn(k) * sum)
    }

    /// The part of a value that coefficients can have.
    pub fn in_field(&self, value: Complex64) -> Complex64 {
        match self.law {
            Damping::Structural => value,
            Damping::Viscous => Complex64::new(value.re, 0.0),
        }
    }

    /// All roots in t of the denominator with these poles λ.
    pub fn roots(&self, lambda: &[Complex64]) -> Vec<Complex64> {
        match self.law {
            Damping::Structural => lambda
                .iter()
                .map(|pole| (pole - self.centre) / self.scale)
                .collect(),
            Damping::Viscous => lambda
                .iter()
                .map(|pole| viscous_pole_of(*pole) / (Complex64::i() * self.scale))
                .flat_map(|root| [root, -root.conj()])
                .collect(),
        }
    }

    /// Poles λ of damped roots in t. In the viscous law mirror images and roots of ζ > 0.71, which
    /// are background, are left out.
    pub fn poles(&self, roots: &[Complex64]) -> Vec<Complex64> {
        match self.law {
            Damping::Structural => roots
                .iter()
                .map(|root| root * self.scale + self.centre)
                .collect(),
            Damping::Viscous => roots
                .iter()
                .filter(|root| root.re > root.im.abs())
                .map(|root| {
                    let (modulus, loss) = (root.norm(), 2.0 * root.im / root.norm());
                    (self.scale * modulus).powi(2) * Complex64::new(1.0, loss)
                })
                .collect(),
        }
    }

    /// s/ω_max of a pole λ.
    pub fn in_s(&self, lambda: Complex64) -> Complex64 {
        s_of_lambda(self.law, lambda)
    }
}
