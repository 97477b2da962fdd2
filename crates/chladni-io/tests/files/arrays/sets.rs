//! Sets to write and values to find.

use chladni_frf::{FrfKind, FrfSet, FrfValues, Geometry, ReferenceUnit};
use ndarray::{Array1, Array3};
use num_complex::Complex64;

pub(super) fn value(response: usize, reference: usize, line: usize) -> Complex64 {
    Complex64::new(
        (100 * response + 10 * reference + line) as f64,
        -0.5 * line as f64,
    )
}

pub(super) fn set(values: FrfValues) -> FrfSet {
    let (responses, references, lines) = values.dim();
    FrfSet {
        frequency_hz: Array1::from_iter((0..lines).map(|k| 1.0 + 0.3 * k as f64)),
        values,
        responses: (1..=responses as u64)
            .map(|node| format!("{node}:-RX").parse().unwrap())
            .collect(),
        references: (9..9 + references as u64)
            .map(|node| format!("{node}:S").parse().unwrap())
            .collect(),
        kind: Some(FrfKind::Accelerance),
        reference_unit: ReferenceUnit::Volt,
        coherence: Some(Array3::from_shape_fn(
            (responses, references, lines),
            |(i, _, k)| 0.5 + 0.1 * i as f32 - 0.01 * k as f32,
        )),
        variance: None,
        estimation: None,
        geometry: Geometry::default(),
    }
}
