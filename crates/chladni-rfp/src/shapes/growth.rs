//! Modes that only the common structure shows: a rank-one term added where it takes most
//! out of the residual.
//!
//! Past a modal overlap of about two, free residues explain two modes by one pole;
//! rank-one residues cannot, and what they leave has the missing mode's shape.

use crate::damping::basis::basis;
use crate::poles::scan::resonance_grid;
use crate::shapes::limits;
use crate::shapes::step::State;
use crate::shapes::target::Target;
use chladni_linalg::blocked::blocked_matmul;
use chladni_linalg::{matmul_h, LinalgError};
use ndarray::{Array1, Array2, Axis};
use num_complex::Complex64;

/// Largest singular value squared of a matrix and its right singular vector.
fn strongest(matrix: &Array2<Complex64>) -> (f64, Array1<Complex64>) {
    let energy =
        |row: ndarray::ArrayView1<Complex64>| row.iter().map(|v| v.norm_sqr()).sum::<f64>();
    let start = matrix
        .rows()
        .into_iter()
        .max_by(|a, b| energy(*a).total_cmp(&energy(*b)))
        .expect("a DOF")
        .mapv(|v| v.conj());
    let mut vector = start;
    let mut value = 0.0;
    for _ in 0..limits::GROWTH_POWER_STEPS {
        let norm = energy(vector.view()).sqrt();
        if norm == 0.0 {
            return (0.0, vector);
        }
        vector.mapv_inplace(|v| v / norm);
        let image = matrix.dot(&vector);
        value = energy(image.view());
        vector = matrix.t().mapv(|v| v.conj()).dot(&image);
    }
    (value, vector)
}

/// The pole and participations of the rank-one term that would take most energy out of
/// the residual of `state`, if more than `limit`.
pub(crate) fn candidate(
    target: &Target,
    state: &State,
    limit: f64,
) -> Result<Option<(Complex64, Array1<Complex64>)>, LinalgError> {
    let work = target.work;
    // a second term at a known pole: a repeated one
    let mut grid = state.lambda.clone();
    grid.append(&mut resonance_grid(work, &state.lambda));
    let modes = target.outside(&basis(work, &state.lambda, &[]));
    let residues = state.residues();
    let mut best: Option<(f64, Complex64, Array1<Complex64>)> = None;
    for chunk in grid.chunks(limits::GROWTH_BLOCK) {
        let columns = target.outside(&basis(work, chunk, &[]));
        let left = target.against(&columns)
            - blocked_matmul(
                matmul_h(columns.view(), modes.view()).view(),
                residues.view(),
            );
        for (c, &pole) in chunk.iter().enumerate() {
            let norm: f64 = columns.column(c).iter().map(|v| v.norm_sqr()).sum();
            let matrix = left
                .index_axis(Axis(0), c)
                .to_shape(target.sides)
                .expect("own · other values")
                .to_owned();
            let (value, vector) = strongest(&matrix);
            let gain = value / norm;
            if norm > 0.0 && gain > limit && best.as_ref().is_none_or(|(most, _, _)| gain > *most) {
                best = Some((gain, pole, vector));
            }
        }
    }
    // E ≈ ψ Lᵀ: the right singular vector is conj(L)
    Ok(best.map(|(_, pole, vector)| (pole, vector.mapv(|v| v.conj()))))
}
