//! Columns over the lines that modes stand for in least squares.

use chladni_frf::{Damping, Mode};
use ndarray::{Array1, Array2};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// The factor of a mode's residue in the receptance.
pub(crate) fn residue_factor(mode: &Mode, damping: Damping, omega: f64) -> Complex64 {
    let omega_n = TAU * mode.frequency_hz;
    match damping {
        Damping::Structural => mode.structural_factor(omega),
        Damping::Viscous => Complex64::new(
            omega_n * omega_n - omega * omega,
            mode.loss_factor * omega_n * omega,
        )
        .inv(),
    }
}

/// The columns side by side, each of unit length.
pub(crate) fn columns_of_unit_length(columns: &[Array1<Complex64>]) -> Array2<Complex64> {
    let mut matrix = Array2::zeros((columns.first().map_or(0, Array1::len), columns.len()));
    for (mut target, column) in matrix.columns_mut().into_iter().zip(columns) {
        let size = column.iter().map(|v| v.norm_sqr()).sum::<f64>().sqrt();
        target.assign(&column.mapv(|v| v / size));
    }
    matrix
}
