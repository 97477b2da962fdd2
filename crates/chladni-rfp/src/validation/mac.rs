//! Modal assurance criterion: R. Allemang, D. Brown, IMAC 1 (1982) 110.

use chladni_frf::ModalModel;
use ndarray::Array2;
use num_complex::Complex64;

/// Modal assurance criterion of two shapes, 0..=1: |aᴴb|²/((aᴴa)(bᴴb)); 0 where one of
/// them is zero.
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

/// MAC of the in-band modes of a model with each other: (mode, mode), 1 on the diagonal.
/// High values beside it mean that the responses cannot tell these shapes apart (too few
/// points, or one mode taken for two).
pub fn auto_mac(model: &ModalModel) -> Array2<f64> {
    let shapes: Vec<&[Complex64]> = model
        .in_band_modes()
        .map(|mode| mode.shape.0.as_slice())
        .collect();
    mac_matrix(&shapes, &shapes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_up_to_a_factor_agree_fully_and_orthogonal_ones_not_at_all() {
        let real = |values: [f64; 3]| values.map(|v| Complex64::new(v, 0.0)).to_vec();
        let (a, orthogonal) = (real([1.0, 2.0, -1.0]), real([1.0, 0.0, 1.0]));
        let turned: Vec<Complex64> = a
            .iter()
            .map(|v| v * Complex64::from_polar(3.0, 1.0))
            .collect();
        assert!((mac(&a, &turned) - 1.0).abs() < 1e-14);
        assert!(mac(&a, &orthogonal) < 1e-30);
        // cos² of 45°
        assert!((mac(&real([1.0, 0.0, 0.0]), &real([1.0, 1.0, 0.0])) - 0.5).abs() < 1e-14);
        assert_eq!(mac(&a, &real([0.0; 3])), 0.0);
    }
}
