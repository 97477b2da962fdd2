//! Iterative learning by least squares: the usual remedy, and the baseline.

use chladni_frf::{Error, ErrorKind, FrfKind, MeasuredField, ModalModel, Result};
use chladni_render::Rendering;
use ndarray::Array1;
use num_complex::Complex64;

/// c over the mean eigenvalue of HᴴH: what keeps forces bounded.
const REGULARISATION: f64 = 1e-3;

/// A + (HᴴH + cI)⁻¹Hᴴ(v* − v) with the field v* that the first drive was made for.
///
/// # Errors
/// Those of the factorisation.
pub(super) fn next(
    model: &ModalModel,
    first: &Rendering,
    drive: &Array1<Complex64>,
    seen: &MeasuredField,
) -> Result<Array1<Complex64>> {
    let rows: Vec<usize> = first
        .field
        .responses
        .iter()
        .filter_map(|dof| {
            model
                .responses
                .iter()
                .position(|known| known.same_axis(*dof))
        })
        .collect();
    let mobility = model
        .frf_matrix(FrfKind::Mobility, first.weights.frequency_hz)
        .select(ndarray::Axis(0), &rows);
    let missing: Array1<Complex64> = first
        .field
        .velocity_m_per_s
        .iter()
        .zip(&seen.points)
        .map(|(wanted, point)| wanted - point.velocity_m_per_s)
        .collect();
    let back = mobility.t().mapv(|value| value.conj());
    let mut gram = back.dot(&mobility);
    let mean = gram.diag().iter().map(|value| value.re).sum::<f64>() / gram.nrows() as f64;
    gram.diag_mut()
        .mapv_inplace(|value| value + REGULARISATION * mean);
    let inverse = chladni_linalg::inverse_hermitian(gram.view())
        .map_err(|error| Error::new(ErrorKind::Internal, error.to_string()))?;
    Ok(drive + inverse.dot(&back.dot(&missing)))
}
