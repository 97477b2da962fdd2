//! The scale of saved shapes, and how well the driving points tell it.

use crate::shapes::limits;
use num_complex::Complex64;

/// Response of a saved shape ψ = t·x to errors of x and L: δt/t = Σ a_d δx_d + Σ c_j
/// δL_j.
pub(crate) struct Scale {
    /// t.
    pub factor: Complex64,
    /// (response d, a_d).
    pub response: Vec<(usize, Complex64)>,
    /// (reference j, c_j).
    pub reference: Vec<(usize, Complex64)>,
}

impl Scale {
    /// A mass scale is the root of a driving-point residue: with u its relative 95 %
    /// half-width, the interval of what it divides grows as 1/(1 − u²) over that of first
    /// order, and holds infinity from u = 1 on.
    ///
    /// Fieller, J. R. Stat. Soc. B 16 (1954) 175.
    pub(super) fn second_order(&self, variance: f64) -> f64 {
        if self.reference.is_empty() {
            return 0.0;
        }
        let u2 = (self.half_width(variance.sqrt()))
            .powi(2)
            .min(limits::SCALE_KNOWN);
        u2 / (1.0 - u2)
    }

    /// The relative standard deviation of a mass scale as it enters error bars of shapes;
    /// `None` for other scales, and where it is not known.
    pub fn stated(&self, deviation: f64) -> Option<f64> {
        let stated = deviation * (1.0 + self.second_order(deviation.powi(2))).sqrt();
        Some(stated).filter(|value| !self.reference.is_empty() && value.is_finite())
    }

    /// Relative 95 % half-width of what a mass scale is the root of, from the relative
    /// standard deviation of the scale.
    fn half_width(&self, deviation: f64) -> f64 {
        2.0 * limits::SIGMAS_95 * deviation
    }

    /// True where the driving points do not tell the mass scale from any other.
    pub fn unknown(&self, deviation: f64) -> bool {
        !self.reference.is_empty() && self.half_width(deviation) >= 1.0
    }
}
