//! The operator Kalman update: the mobility itself is corrected by what a drive was seen
//! to do, whatever the cause.
//!
//! Rows share the covariance C = LᴴL. After a field v of the drive A, with noise σ:
//!
//! g = CA, d = Aᴴg + σ², H ← H + (v − HA)gᴴ/d, C ← C − ggᴴ/d (theory.md, eq. 59)
//!
//! Without noise ‖(H_true − H)·C₀^(−½)‖_F never rises however wrong the model was, and H
//! is exact after as many independent drives as there are actuators.

use ndarray::{Array1, Array2};
use num_complex::Complex64;

/// A mobility and how sure it is.
#[derive(Debug, Clone, PartialEq)]
pub struct KalmanOperator {
    /// Mobility, axes (response, actuator).
    pub mobility: Array2<Complex64>,
    /// Covariance of each row: the mean of δhᴴδh.
    pub covariance: Array2<Complex64>,
}

impl KalmanOperator {
    /// The same behind one factor of all channels.
    pub(super) fn scaled(&self, factor: Complex64) -> Self {
        let square = factor.norm_sqr();
        Self {
            mobility: self.mobility.mapv(|value| value * factor),
            covariance: self.covariance.mapv(|value| value * square),
        }
    }

    /// Takes in what the responses `rows` were seen to do under `drive`, each with the
    /// standard deviation `noise` (mean square over the rows).
    ///
    /// Only a field of all responses makes the shared covariance smaller: those that were
    /// not measured are as unsure as before.
    pub fn update(
        &mut self,
        drive: &Array1<Complex64>,
        rows: &[usize],
        seen: &Array1<Complex64>,
        noise: f64,
    ) {
        let g = self.covariance.dot(drive);
        let own: Complex64 = drive.iter().zip(&g).map(|(a, g)| a.conj() * g).sum();
        let d = own.re + noise * noise;
        if d <= 0.0 {
            return;
        }
        let back = g.mapv(|value| value.conj() / d);
        for (&row, &seen) in rows.iter().zip(seen) {
            let innovation = seen - self.mobility.row(row).dot(drive);
            self.mobility.row_mut(row).scaled_add(innovation, &back);
        }
        if rows.len() == self.mobility.nrows() {
            for (mut row, g) in self.covariance.rows_mut().into_iter().zip(&g) {
                row.scaled_add(-g, &back);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const RESPONSES: usize = 4;
    const ACTUATORS: usize = 3;

    fn matrix(rows: usize, columns: usize) -> impl Strategy<Value = Array2<Complex64>> {
        let parts = proptest::collection::vec(-1.0..1.0f64, 2 * rows * columns);
        parts.prop_map(move |parts| {
            Array2::from_shape_fn((rows, columns), |(i, j)| {
                let at = 2 * (i * columns + j);
                Complex64::new(parts[at], parts[at + 1])
            })
        })
    }

    /// ‖Δ·C₀^(−½)‖_F.
    fn error(
        truth: &Array2<Complex64>,
        operator: &KalmanOperator,
        root: &Array2<Complex64>,
    ) -> f64 {
        // C₀ = RRᴴ: ΔC₀⁻¹Δᴴ is the square of R⁻¹Δᴴ
        let difference = (truth - &operator.mobility).t().mapv(|value| value.conj());
        let white = chladni_linalg::solve_lower(root.view(), difference.view()).unwrap();
        white.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt()
    }

    proptest! {
        #[test]
        fn the_error_never_rises_and_ends_with_as_many_drives_as_actuators(
            truth in matrix(RESPONSES, ACTUATORS),
            model in matrix(RESPONSES, ACTUATORS),
            errors in matrix(ACTUATORS, ACTUATORS),
            drives in matrix(ACTUATORS, 5),
        ) {
            let mut covariance = chladni_linalg::matmul_h(errors.view(), errors.view());
            covariance.diag_mut().mapv_inplace(|value| value + 0.1);
            let root = chladni_linalg::cholesky(covariance.view()).unwrap();
            let mut operator = KalmanOperator { mobility: model, covariance };
            let rows: Vec<usize> = (0..RESPONSES).collect();
            let mut before = error(&truth, &operator, &root);
            let start = before;
            for drive in drives.columns() {
                let drive = drive.to_owned();
                operator.update(&drive, &rows, &truth.dot(&drive), 1e-9);
                let after = error(&truth, &operator, &root);
                prop_assert!(after <= before * (1.0 + 1e-6) + 1e-6 * start, "{after} > {before}");
                before = after;
            }
            let sizes = chladni_linalg::singular_values(drives.view()).unwrap();
            prop_assert!(sizes[2] < 0.05 || before <= 1e-4 * start, "{before} of {start}");
        }
    }
}
