//! Errors that FRFs share, as noise in the record of their force makes them.

use num_complex::Complex64;

/// E|ν|² where the errors of all FRFs H_l of a force hold −H_l·ν with one ν, and beside it
/// noise of their own: in units of `unit`,
///
/// (|Σ_l H̄_l·e_l|² − Σ_l |H̄_l·e_l|²)/([(Σ_l |H_l|²)² − Σ_l |H_l|⁴]·unit)
///
/// summed over errors e that stand side by side (theory.md, eq. F4g). It scatters about its
/// mean, below 0 too. `None` where one FRF alone has power, or `unit` is not above 0.
///
/// * `frfs`: each H_l with its errors, as many for all
pub fn shared_power<'a>(
    frfs: impl IntoIterator<Item = (Complex64, &'a [Complex64])>,
    unit: f64,
) -> Option<f64> {
    let (mut sum, mut alone): (Vec<Complex64>, f64) = (Vec::new(), 0.0);
    let (mut squares, mut fourths) = (0.0, 0.0);
    for (value, errors) in frfs {
        sum.resize(errors.len(), Complex64::default());
        for (sum, error) in sum.iter_mut().zip(errors) {
            let part = value.conj() * error;
            *sum += part;
            alone += part.norm_sqr();
        }
        squares += value.norm_sqr();
        fourths += value.norm_sqr().powi(2);
    }
    let shared = sum.iter().map(|v| v.norm_sqr()).sum::<f64>() - alone;
    let pairs = squares * squares - fourths;
    (pairs > 0.0 && unit > 0.0).then(|| shared / (pairs * unit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_tell_what_they_share_and_nothing_else() {
        let frf = [Complex64::new(2.0, 1.0), Complex64::new(-0.5, 0.3)];
        let noise: Vec<Complex64> = (0..8)
            .map(|r| Complex64::from_polar(0.3, f64::from(r * r)))
            .collect();
        let shared: Vec<Vec<Complex64>> = frf
            .iter()
            .map(|h| noise.iter().map(|n| -h * n).collect())
            .collect();
        let both = |errors: &[Vec<Complex64>]| {
            let errors: Vec<&[Complex64]> = errors.iter().map(Vec::as_slice).collect();
            shared_power(frf.into_iter().zip(errors), 8.0)
        };
        let power = both(&shared).unwrap();
        assert!((power - 0.09).abs() < 1e-12, "{power}");
        let mut own = shared.clone();
        // the other half turned round: errors share nothing
        own[1][4..].iter_mut().for_each(|v| *v = -*v);
        let power = both(&own).unwrap();
        assert!(power.abs() < 1e-12, "{power}");
        assert_eq!(
            shared_power(std::iter::once((frf[0], &shared[0][..])), 8.0),
            None
        );
    }
}
