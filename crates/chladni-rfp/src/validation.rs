//! Yardsticks of modal testing: MAC, MPC, CMIF.

use chladni_frf::FrfSet;
use chladni_linalg::{svd_thin, LinalgError};
use ndarray::{Array2, ArrayView1};
use num_complex::Complex64;

/// Modal assurance criterion of two shapes, 0..=1: |aᴴb|²/((aᴴa)(bᴴb)). Allemang & Brown, IMAC 1 (1982) 110.
pub fn mac(a: &[Complex64], b: &[Complex64]) -> f64 {
    let dot: Complex64 = a.iter().zip(b).map(|(x, y)| x.conj() * y).sum();
    let norm = |v: &[Complex64]| v.iter().map(|c| c.norm_sqr()).sum::<f64>();
    let scale = norm(a) * norm(b);
    if scale > 0.0 {
        dot.norm_sqr() / scale
    } else {
        0.0
    }
}

/// MAC of every shape of `a` with every shape of `b`: (a, b).
pub fn mac_matrix(a: &[&[Complex64]], b: &[&[Complex64]]) -> Array2<f64> {
    Array2::from_shape_fn((a.len(), b.len()), |(i, j)| mac(a[i], b[j]))
}

/// Modal phase collinearity, 0..=1; 1 for a shape that is real up to one common phase. Pappa, Elliott & Schenk (1993):
/// with S_xx, S_yy, S_xy of real and imaginary parts, ((S_xx − S_yy)² + 4S_xy²)/(S_xx + S_yy)².
pub fn mpc(shape: &[Complex64]) -> f64 {
    let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
    for value in shape {
        xx += value.re * value.re;
        yy += value.im * value.im;
        xy += value.re * value.im;
    }
    let sum = xx + yy;
    if sum > 0.0 {
        ((xx - yy).powi(2) + 4.0 * xy * xy) / (sum * sum)
    } else {
        0.0
    }
}

/// Complex mode indicator function: singular values of the FRF matrix per line, falling; axes (line, singular value),
/// in units of the FRFs. Shih et al., Mech. Syst. Signal Process. 2 (1988) 367. Lines with missing values are NaN.
///
/// # Errors
/// A singular value decomposition that does not converge.
pub fn cmif(frf: &FrfSet) -> Result<Array2<f64>, LinalgError> {
    use rayon::prelude::*;
    let (responses, references, lines) = frf.values.dim();
    let count = responses.min(references);
    let rows: Vec<Result<Vec<f64>, LinalgError>> = (0..lines)
        .into_par_iter()
        .map(|k| {
            let matrix = Array2::from_shape_fn((responses, references), |(i, j)| frf.values.get(i, j, k));
            if matrix.iter().any(|v| !v.is_finite()) {
                return Ok(vec![f64::NAN; count]);
            }
            Ok(svd_thin(matrix.view())?.1.to_vec())
        })
        .collect();
    let mut out = Array2::zeros((lines, count));
    for (k, row) in rows.into_iter().enumerate() {
        out.row_mut(k).assign(&ArrayView1::from(&row?));
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_up_to_a_factor_agree_fully_and_orthogonal_ones_not_at_all() {
        let a: Vec<Complex64> = [1.0, 2.0, -1.0].map(|v| Complex64::new(v, 0.0)).to_vec();
        let turned: Vec<Complex64> = a.iter().map(|v| v * Complex64::from_polar(3.0, 1.0)).collect();
        let orthogonal: Vec<Complex64> = [1.0, 0.0, 1.0].map(|v| Complex64::new(v, 0.0)).to_vec();
        assert!((mac(&a, &turned) - 1.0).abs() < 1e-14);
        assert!(mac(&a, &orthogonal) < 1e-30);
        assert!((mpc(&turned) - 1.0).abs() < 1e-14);
        let travelling: Vec<Complex64> = (0..4).map(|k| Complex64::from_polar(1.0, k as f64 * std::f64::consts::FRAC_PI_2)).collect();
        assert!(mpc(&travelling) < 1e-30);
    }
}
