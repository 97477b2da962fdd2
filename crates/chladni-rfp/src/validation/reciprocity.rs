//! Reciprocity: what is driven at a and measured at b equals what is driven at b and
//! measured at a (Maxwell–Betti; theory.md, eq. F3).

use chladni_frf::{Dof, FrfSet};
use num_complex::Complex64;

/// Two FRFs that reciprocity makes equal, and how equal they are.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ReciprocalPair {
    /// Response and reference of the first FRF; those of the second change places.
    pub dofs: [Dof; 2],
    /// The factor g that takes the second FRF closest to the first, H_ab ≈ g·H_ba: 1 for
    /// a reciprocal pair. Another real value is a gain error of one channel, a phase a
    /// delay or a wrong filter.
    pub gain: Complex64,
    /// The part that no factor explains, ‖H_ab − g·H_ba‖/‖H_ab‖: noise, or sensors that
    /// do not sit where the drivers do.
    pub misfit: f64,
}

/// Every pair of FRFs (a, b), (b, a) of a set, a before b in the order of the references;
/// lines from `band_hz[0]` to `band_hz[1]` on which both have a value. Empty where no two
/// references are responses as well.
pub fn reciprocity(frf: &FrfSet, band_hz: [f64; 2]) -> Vec<ReciprocalPair> {
    let lines: Vec<usize> = (0..frf.frequency_hz.len())
        .filter(|&k| (band_hz[0]..=band_hz[1]).contains(&frf.frequency_hz[k]))
        .collect();
    // references that are responses too: (reference, response, sign between their
    // directions)
    let shared: Vec<(usize, usize, f64)> = frf
        .references
        .iter()
        .enumerate()
        .filter_map(|(j, reference)| {
            let i = frf
                .responses
                .iter()
                .position(|response| response.same_axis(*reference))?;
            Some((
                j,
                i,
                frf.responses[i].direction.sign() * reference.direction.sign(),
            ))
        })
        .collect();
    let mut pairs = Vec::new();
    for (place, &(ref_a, resp_a, sign_a)) in shared.iter().enumerate() {
        for &(ref_b, resp_b, sign_b) in &shared[place + 1..] {
            let value = |i, j, k| frf.values.get(i, j, k);
            let both = lines.iter().map(|&k| {
                (
                    value(resp_a, ref_b, k),
                    sign_a * sign_b * value(resp_b, ref_a, k),
                )
            });
            let compared =
                compare(both.filter(|(first, second)| first.is_finite() && second.is_finite()));
            pairs.extend(compared.map(|(gain, misfit)| ReciprocalPair {
                dofs: [frf.responses[resp_a], frf.references[ref_b]],
                gain,
                misfit,
            }));
        }
    }
    pairs
}

/// Gain and misfit of the first over the second; `None` where one of them is zero.
fn compare(values: impl Iterator<Item = (Complex64, Complex64)>) -> Option<(Complex64, f64)> {
    let (mut first, mut second, mut cross) = (0.0, 0.0, Complex64::default());
    for (a, b) in values {
        first += a.norm_sqr();
        second += b.norm_sqr();
        cross += a * b.conj();
    }
    (first > 0.0 && second > 0.0).then(|| {
        (
            cross / second,
            (1.0 - cross.norm_sqr() / (first * second)).max(0.0).sqrt(),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use chladni_frf::{FrfKind, FrfValues, Geometry, ReferenceUnit};
    use ndarray::{Array1, Array3};

    /// Two nodes that are responses and references; H_12 = `factor`·H_21.
    fn set(factor: Complex64, second_reference: &str) -> FrfSet {
        let lines = 50;
        let shape = |k: usize| Complex64::new(1.0, 0.1 * k as f64);
        let values = Array3::from_shape_fn((2, 2, lines), |(i, j, k)| {
            if (i, j) == (0, 1) {
                factor * shape(k)
            } else {
                shape(k)
            }
        });
        FrfSet {
            frequency_hz: Array1::range(1.0, 51.0, 1.0),
            values: FrfValues::F64(values),
            responses: vec!["1:+Z".parse().unwrap(), "2:+Z".parse().unwrap()],
            references: vec!["1:+Z".parse().unwrap(), second_reference.parse().unwrap()],
            kind: Some(FrfKind::Mobility),
            reference_unit: ReferenceUnit::Newton,
            coherence: None,
            variance: None,
            estimation: None,
            geometry: Geometry::default(),
        }
    }

    #[test]
    fn a_gain_and_a_phase_of_one_channel_are_read_off() {
        for factor in [Complex64::new(1.0, 0.0), Complex64::from_polar(1.2, 0.3)] {
            let pairs = reciprocity(&set(factor, "2:+Z"), [0.0, 100.0]);
            assert_eq!(pairs.len(), 1);
            assert!((pairs[0].gain - factor).norm() < 1e-12 && pairs[0].misfit < 1e-7);
        }
        // a reference against the response's direction turns both the driving point and
        // the pair
        assert!(
            (reciprocity(&set(Complex64::new(-1.0, 0.0), "2:-Z"), [0.0, 100.0])[0].gain - 1.0)
                .norm()
                < 1e-12
        );
    }

    #[test]
    fn without_two_shared_points_there_is_nothing_to_compare() {
        assert!(reciprocity(&set(Complex64::new(1.0, 0.0), "3:+Z"), [0.0, 100.0]).is_empty());
        assert!(reciprocity(&set(Complex64::new(1.0, 0.0), "2:+X"), [0.0, 100.0]).is_empty());
    }

    #[test]
    fn what_a_factor_cannot_explain_is_misfit() {
        let mut unlike = set(Complex64::new(1.0, 0.0), "2:+Z");
        if let FrfValues::F64(values) = &mut unlike.values {
            // orthogonal: half the lines each
            for k in 0..50 {
                values[[
                    if k % 2 == 0 { 0 } else { 1 },
                    if k % 2 == 0 { 1 } else { 0 },
                    k,
                ]] = Complex64::default();
            }
        }
        let pair = &reciprocity(&unlike, [0.0, 100.0])[0];
        assert!(pair.gain.norm() < 1e-12 && (pair.misfit - 1.0).abs() < 1e-12);
    }
}
