//! Effect of windowed, finite records on the column of a mode (theory.md, eq. F4).
//!
//! Near a pole s the column of receptance is the sum of a singular part/(jω − s) and a smooth part.
//! Leakage acts on the singular part, in the kind that was measured. With F(z) = z·g(z) of
//! [`WindowKernel`] and z = (jω − s)T the plain column is multiplied by
//!
//! 1 + (F(z) − 1)·κ,  κ = (s/jω)^p·(jω − s̄)/(s − s̄),
//!
//! where p is the power of jω from receptance to the kind, and s̄ the other pole of the column: −s in
//! the structural law, s* in the viscous one. κ is 1 at the pole. Leakage of the other pole is of
//! order 1/(ωT) and left out.

use crate::data::limits;
use crate::data::window::kernel::{Force, WindowKernel};
use crate::data::window::lanes::Lanes;
use num_complex::Complex64;
use std::sync::Arc;

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

/// The lines of a fit whose records leak. Exponentials would take most of the time of a column; they
/// are products of one that depends on the line and one that depends on the pole, and each is computed
/// once.
#[derive(Debug, Clone)]
pub(crate) struct LeakingLines {
    pub leakage: Arc<Leakage>,
    pub lines: Vec<Line>,
}

/// One line in the forward model.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line {
    /// ω/ω_max.
    y: f64,
    /// [`WindowKernel::decays`] of jωT.
    decays: [Complex64; 2],
}

/// One pole in the forward model.
pub(crate) struct PoleLeakage<'a> {
    pub leakage: &'a Leakage,
    s: Complex64,
    /// [`WindowKernel::decays`] of −sT.
    decays: [Complex64; 2],
    /// (s/j)^p.
    in_kind: Complex64,
}

impl LeakingLines {
    /// Lines x = (ω/ω_max)².
    pub fn new(leakage: Arc<Leakage>, x: &[f64]) -> Self {
        let lines = x.iter().map(|x| leakage.line(x.sqrt())).collect();
        Self { leakage, lines }
    }

    /// The lines with these indices.
    pub fn select(&self, lines: impl Iterator<Item = usize>) -> Self {
        Self {
            leakage: self.leakage.clone(),
            lines: lines.map(|k| self.lines[k]).collect(),
        }
    }

    /// Lines of records of which only the first 1/`factor` holds samples, the rest zeros.
    pub fn padded(self, factor: usize) -> Self {
        let leakage = Arc::new(self.leakage.padded(factor));
        let lines = self.lines.iter().map(|line| leakage.line(line.y)).collect();
        Self { leakage, lines }
    }
}

impl PoleLeakage<'_> {
    /// F(z) − 1 and its derivative by s.
    #[inline(always)]
    fn excess<const L: usize>(&self, lines: &[Line; L]) -> [Lanes<L>; 2] {
        let Leakage { kernel, record, .. } = self.leakage;
        let z = Lanes::of(|l| (Complex64::new(0.0, lines[l].y) - self.s) * record);
        let decays = [0, 1].map(|a| Lanes::of(|l| lines[l].decays[a]) * self.decays[a]);
        let [g, slope] = kernel.by_decays(z, decays);
        [z * g - 1.0.into(), (g + z * slope) * -record]
    }

    /// (s/jω)^p.
    #[inline(always)]
    fn in_kind<const L: usize>(&self, lines: &[Line; L]) -> Lanes<L> {
        let power = -self.leakage.omega_power;
        Lanes::from(self.in_kind) * lines.map(|line| line.y.powi(power))
    }

    /// Factor of leakage on 1/(jω − s).
    pub fn factor(&self, line: &Line) -> Complex64 {
        let line = [*line];
        1.0 + (self.excess(&line)[0] * self.in_kind(&line)).get(0)
    }

    /// Factors of leakage on the plain column of the `pole`, whose s this is, and their derivatives by
    /// λ.
    #[inline(always)]
    pub fn factors_of_column<const L: usize>(
        &self,
        pole: &LeakingPole,
        lines: &[Line; L],
    ) -> [Lanes<L>; 2] {
        let LeakingPole { s, other, slope } = *pole;
        let distance = |from: Complex64| Lanes::of(|l| Complex64::new(0.0, lines[l].y) - from);
        let [excess, by_s] = self.excess(lines);
        let over = (s - other).inv();
        let kind = self.in_kind(lines) * over;
        let kappa = kind * distance(other);
        // as s moves by δ, s̄ moves by −δ
        let kappa_by_s = kappa * (f64::from(self.leakage.omega_power) / s)
            - kind * distance(0.5 * (s + other)) * (2.0 * over);
        [
            excess * kappa + 1.0.into(),
            (by_s * kappa + excess * kappa_by_s) * slope,
        ]
    }

    /// The part that leakage adds to the column of receptance, in the kind and in powers of ω_max:
    /// (F(z) − 1)·s^p/((s − s̄)(jω − s)).
    ///
    /// * `other`: s̄
    pub fn added(&self, other: Complex64, line: &Line) -> Complex64 {
        let in_kind = self.s.powi(self.leakage.omega_power);
        let distance = Complex64::new(0.0, line.y) - self.s;
        self.excess(&[*line])[0].get(0) * in_kind / ((self.s - other) * distance)
    }
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

    /// Leakage of records of which only the first 1/`factor` holds samples, the rest zeros.
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

    /// Power of a force in windowed records on the line y near the resonance of s, over that beside
    /// resonances.
    pub fn power_of_force(&self, s: Complex64, y: f64, force: &Force) -> f64 {
        let z = (Complex64::new(0.0, y) - s) * self.record;
        self.kernel.power_of_force(z, -s.re * self.record, force)
    }

    /// The factors that depend on a pole s of receptance.
    pub fn of_pole(&self, s: Complex64) -> PoleLeakage<'_> {
        PoleLeakage {
            leakage: self,
            s,
            decays: self.kernel.decays(-s * self.record),
            in_kind: (s / Complex64::i()).powi(self.omega_power),
        }
    }

    /// The factors that depend on the line y = ω/ω_max.
    pub fn line(&self, y: f64) -> Line {
        Line {
            y,
            decays: self.kernel.decays(Complex64::new(0.0, y * self.record)),
        }
    }

    /// Relative excess of the `decay` (over ω_max) that a fit finds with pure resonances, of the same
    /// height at the resonance: 1/F − 1.
    pub fn broadening(&self, decay: f64) -> f64 {
        let z = decay * self.record;
        let [g, _] = self.kernel.value_and_slope(Complex64::from(z));
        1.0 / (z * g.re) - 1.0
    }

    /// The decay (over ω_max) that [`Self::broadening`] makes appear as `seen`.
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

    /// The start of a refinement from a pole of plain columns, in the structural plane: its decay less
    /// 1/T, which a window usually adds.
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
