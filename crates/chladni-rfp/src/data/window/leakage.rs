//! Effect of windowed, finite records on the column of a mode (theory.md, eq. F4).
//!
//! Near a pole s the column of receptance is (singular part)/(jω − s) and something
//! smooth. Leakage acts on the singular part, in the kind that was measured: with F(z) =
//! z·g(z) of [`WindowKernel`] and z = (jω − s)T the plain column is multiplied by
//!
//! 1 + (F(z) − 1)·κ,  κ = (s/jω)^p·(jω − s̄)/(s − s̄),
//!
//! p the power of jω that leads from receptance to the kind, s̄ the other pole of the
//! column: −s in the structural law, s* in the viscous one. κ is 1 at the pole. What the
//! other pole leaks is of order 1/(ωT) and left out.

use crate::data::limits;
use crate::data::window::kernel::{Force, WindowKernel};
use num_complex::Complex64;

/// The forward model of one set of FRFs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Leakage {
    kernel: WindowKernel,
    /// Length T of the records times ω_max.
    record: f64,
    /// p: 0 receptance, 1 mobility, 2 accelerance.
    omega_power: i32,
}

/// A pole of receptance and how it moves with λ, in units of ω_max.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LeakingPole {
    /// s, decaying.
    pub s: Complex64,
    /// The other pole of the column.
    pub other: Complex64,
    /// ds/dλ.
    pub slope: Complex64,
}

impl Leakage {
    /// * `record`: T·ω_max
    pub fn new(kernel: WindowKernel, record: f64, omega_power: i32) -> Self {
        Self {
            kernel,
            record,
            omega_power,
        }
    }

    /// Records of which only the first 1/`factor` holds samples, the rest zeros.
    pub fn padded(&self, factor: usize) -> Self {
        Self {
            record: self.record / factor as f64,
            ..self.clone()
        }
    }

    /// The part that a force that is not even adds to the column 1/(jω − s), in powers of ω_max.
    pub fn by_force(&self, s: Complex64, y: f64, force: &Force) -> Complex64 {
        let z = (Complex64::new(0.0, y) - s) * self.record;
        let [even, _] = self.kernel.value_and_slope(z);
        self.record * (self.kernel.under_force(z, -s.re * self.record, force) - even)
    }

    /// Power of a force near the resonance of s, over that beside resonances, as windowed records
    /// show it on the line y.
    pub fn power_of_force(&self, s: Complex64, y: f64, force: &Force) -> f64 {
        let z = (Complex64::new(0.0, y) - s) * self.record;
        self.kernel.power_of_force(z, -s.re * self.record, force)
    }

    /// F(z) − 1 and its derivative by s on the line y = ω/ω_max.
    fn excess(&self, s: Complex64, y: f64) -> [Complex64; 2] {
        let z = (Complex64::new(0.0, y) - s) * self.record;
        let [g, slope] = self.kernel.value_and_slope(z);
        [z * g - 1.0, -(g + z * slope) * self.record]
    }

    /// (s/jω)^p.
    fn in_kind(&self, s: Complex64, y: f64) -> Complex64 {
        (s / Complex64::new(0.0, y)).powi(self.omega_power)
    }

    /// Factor on the plain column of a pole, and its derivative by λ.
    pub fn factor(&self, pole: &LeakingPole, y: f64) -> [Complex64; 2] {
        let LeakingPole { s, other, slope } = *pole;
        let jy = Complex64::new(0.0, y);
        let [excess, by_s] = self.excess(s, y);
        let kind = self.in_kind(s, y);
        let kappa = kind * (jy - other) / (s - other);
        // s̄ moves against s
        let kappa_by_s = f64::from(self.omega_power) * kappa / s
            - kind * (jy - 0.5 * (s + other)) * 2.0 / ((s - other) * (s - other));
        [
            1.0 + excess * kappa,
            (by_s * kappa + excess * kappa_by_s) * slope,
        ]
    }

    /// Factor on 1/(jω − s).
    pub fn factor_of_pole(&self, s: Complex64, y: f64) -> Complex64 {
        1.0 + self.excess(s, y)[0] * self.in_kind(s, y)
    }

    /// The part that leakage adds to the column of receptance in the kind: (F(z) −
    /// 1)·s^p/((s − s̄)(jω − s)), in powers of ω_max.
    pub fn added(&self, pole: &LeakingPole, y: f64) -> Complex64 {
        let LeakingPole { s, other, .. } = *pole;
        let jy = Complex64::new(0.0, y);
        self.excess(s, y)[0] * s.powi(self.omega_power) / ((s - other) * (jy - s))
    }

    /// Relative excess of the decay (over ω_max) that is read where a line is taken for a
    /// pure resonance of the same height: 1/F − 1 at the resonance.
    pub fn broadening(&self, decay: f64) -> f64 {
        let z = decay * self.record;
        let [g, _] = self.kernel.value_and_slope(Complex64::from(z));
        1.0 / (z * g.re) - 1.0
    }

    /// The decay (over ω_max) that is read as `seen`: what [`Self::broadening`] undoes.
    pub fn unbroadened(&self, seen: f64) -> f64 {
        let (mut low, mut high) = (0.0, seen);
        for _ in 0..limits::HALVINGS {
            let middle = 0.5 * (low + high);
            match middle * (1.0 + self.broadening(middle)) < seen {
                true => low = middle,
                false => high = middle,
            }
        }
        0.5 * (low + high)
    }

    /// A pole of plain columns, in the structural plane, less what a window usually adds to
    /// its decay, 1/T: where a refinement starts.
    pub fn narrowed(&self, lambda: Complex64) -> Complex64 {
        if self.kernel == WindowKernel::Transient {
            return lambda;
        }
        let root = lambda.sqrt();
        let decay = (root.im - 1.0 / self.record).max(limits::LEAST_DECAY_LEFT * root.im);
        Complex64::new(root.re, decay).powi(2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::window::kinds::Window;

    /// T·ω_max: lines 1/500 of ω_max apart.
    const RECORD: f64 = 500.0 * std::f64::consts::TAU;

    #[test]
    fn a_broadened_decay_leads_back() {
        let leakage = Leakage::new(Window::Hann.kernel().unwrap(), RECORD, 1);
        // half a line to eight lines per half-power bandwidth
        for lines in [0.5, 1.0, 8.0] {
            let decay = std::f64::consts::PI * lines / RECORD;
            let seen = decay * (1.0 + leakage.broadening(decay));
            assert!(
                seen > (1.0 + 0.04 / lines) * decay,
                "{lines}: {}",
                seen / decay
            );
            let back = leakage.unbroadened(seen);
            assert!((back - decay).abs() < 1e-6 * decay, "{lines}: {back}");
        }
    }

    #[test]
    fn zeros_behind_a_record_cut_it() {
        let of = |record| Leakage::new(Window::Hann.kernel().unwrap(), record, 1);
        assert_eq!(of(RECORD).padded(2), of(RECORD / 2.0));
    }
}
