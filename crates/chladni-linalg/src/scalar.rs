//! The two element types, and the little arithmetic that both back ends need of them.

use num_complex::Complex64;

/// f64 or Complex64; closed.
pub trait Scalar:
    crate::doors::Doors
    + crate::backend::Element
    + ndarray::LinalgScalar
    + Send
    + Sync
    + std::fmt::Debug
{
    /// A real value as this type.
    fn of_real(value: f64) -> Self;
    /// |value|.
    fn modulus(self) -> f64;
    /// value / divisor.
    fn divided_by(self, divisor: f64) -> Self;
    /// Neither NaN nor infinite, in both parts.
    fn is_finite_value(&self) -> bool;
}

impl Scalar for f64 {
    fn of_real(value: f64) -> Self {
        value
    }
    fn modulus(self) -> f64 {
        self.abs()
    }
    fn divided_by(self, divisor: f64) -> Self {
        self / divisor
    }
    fn is_finite_value(&self) -> bool {
        self.is_finite()
    }
}

impl Scalar for Complex64 {
    fn of_real(value: f64) -> Self {
        Complex64::new(value, 0.0)
    }
    fn modulus(self) -> f64 {
        self.norm()
    }
    fn divided_by(self, divisor: f64) -> Self {
        self / divisor
    }
    fn is_finite_value(&self) -> bool {
        self.re.is_finite() && self.im.is_finite()
    }
}
