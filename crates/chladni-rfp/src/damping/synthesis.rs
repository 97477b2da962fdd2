//! The columns of a saved model over the reals.

use crate::damping::basis::basis;
use crate::damping::viscous::viscous_basis;
use crate::data::layout::DataLayout;
use crate::data::products::real_basis;
use chladni_frf::Damping;
use ndarray::{Array2, ShapeBuilder};
use num_complex::Complex64;

/// The columns that the complex coefficients of poles and residual terms multiply, over
/// the reals: (real and imaginary part of each line, real and imaginary part of each
/// coefficient), both in turn, in work units.
pub(crate) fn synthesis(
    data: &DataLayout,
    damping: Damping,
    poles: &[Complex64],
    powers: &[i32],
) -> Array2<f64> {
    let axis = data.axis();
    match damping {
        Damping::Structural => real_basis(&basis(&axis, poles, powers)),
        Damping::Viscous => {
            let halves = viscous_basis(&axis, poles, powers);
            let lines = axis.lines();
            Array2::from_shape_fn(halves.dim().f(), |(row, c)| {
                halves[[row / 2 + lines * (row % 2), c]]
            })
        }
    }
}
