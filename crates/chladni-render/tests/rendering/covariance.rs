//! The error bar of a drive against the spread over many disturbed models.

use crate::common::{disturbed, truth, Errors};
use chladni_frf::FrfKind;
use chladni_render::{Covariance, Drift, Operator};
use num_complex::Complex64;

/// Models drawn; the rms of a sum over some ten modes is then known to a few percent.
const DRAWS: u64 = 300;

#[test]
fn the_error_bar_is_the_rms_error_over_many_models() {
    let errors = Errors {
        frequency: 2e-4,
        loss_factor: 0.02,
        shape: 0.0,
        residual: 0.0,
    };
    let drift = Drift {
        frequency_relative: errors.frequency,
        loss_factor_relative: errors.loss_factor,
        shape_relative: 0.0,
        isotropic_relative: 0.0,
        drive_relative: Some(0.0),
    };
    let operator = Operator::of_model(truth(), 310.0, None).unwrap();
    let judged: Vec<usize> = (0..77).collect();
    let covariance = Covariance::of_model(truth(), &operator, &judged, &drift);
    let drive: ndarray::Array1<Complex64> = (0..34)
        .map(|i| Complex64::from_polar(1e-3, (7 * i * i % 13) as f64))
        .collect();
    let exact = operator.mobility.dot(&drive);
    let mut sum = 0.0;
    for seed in 0..DRAWS {
        let wrong = disturbed(truth(), errors, seed)
            .frf_matrix(FrfKind::Mobility, 310.0)
            .dot(&drive);
        sum += wrong
            .iter()
            .zip(&exact)
            .map(|(a, b)| (a - b).norm_sqr())
            .sum::<f64>()
            / 77.0;
    }
    let ratio = covariance.deviation(&drive) / (sum / DRAWS as f64).sqrt();
    assert!(
        (0.85..1.15).contains(&ratio),
        "predicted over seen: {ratio}"
    );
}

#[test]
fn the_models_own_error_bars_count_as_drift_does() {
    let none = Drift {
        frequency_relative: 0.0,
        loss_factor_relative: 0.0,
        shape_relative: 0.0,
        isotropic_relative: 0.0,
        drive_relative: Some(0.0),
    };
    let drift = Drift {
        frequency_relative: 1e-3,
        loss_factor_relative: 0.1,
        shape_relative: 0.02,
        ..none
    };
    let mut bare = truth().clone();
    // Poles outside the band have no error bars of their own.
    bare.modes.retain(|mode| mode.in_band);
    let mut stated = bare.clone();
    for mode in &mut stated.modes {
        mode.frequency_std_hz = drift.frequency_relative * mode.frequency_hz;
        mode.loss_factor_std = drift.loss_factor_relative * mode.loss_factor;
        mode.shape_std = mode
            .shape
            .0
            .iter()
            .map(|value| drift.shape_relative * value.norm())
            .collect();
    }
    let judged: Vec<usize> = (0..77).collect();
    let gram = |model, drift: &Drift| {
        let operator = Operator::of_model(model, 300.0, None).unwrap();
        Covariance::of_model(model, &operator, &judged, drift)
            .gram()
            .clone()
    };
    let (own, from_drift) = (gram(&stated, &none), gram(&bare, &drift));
    let largest = |matrix: &ndarray::Array2<Complex64>| {
        matrix.iter().map(|value| value.norm()).fold(0.0, f64::max)
    };
    assert!(largest(&(&own - &from_drift)) < 1e-12 * largest(&own));
}

#[test]
fn an_error_of_the_modal_masses_is_none_of_the_mobility() {
    let none = Drift {
        frequency_relative: 0.0,
        loss_factor_relative: 0.0,
        shape_relative: 0.0,
        isotropic_relative: 0.0,
        drive_relative: Some(0.0),
    };
    let judged: Vec<usize> = (0..77).collect();
    let gram = |model: &chladni_frf::ModalModel| {
        let operator = Operator::of_model(model, 300.0, None).unwrap();
        (
            Covariance::of_model(model, &operator, &judged, &none)
                .gram()
                .clone(),
            operator.mobility,
        )
    };
    let with = |shape: f64, scale: f64, stated: Option<f64>| {
        let mut model = truth().clone();
        for mode in &mut model.modes {
            // the scale is off by as much as is stated: the participation has its inverse
            mode.shape
                .0
                .iter_mut()
                .for_each(|value| *value *= 1.0 + scale);
            mode.participation
                .0
                .iter_mut()
                .for_each(|value| *value /= 1.0 + scale);
            mode.shape_std = mode
                .shape
                .0
                .iter()
                .map(|value| shape.hypot(scale) * value.norm())
                .collect();
            mode.scale_std = stated;
        }
        gram(&model)
    };
    let norm = |matrix: &ndarray::Array2<Complex64>| {
        matrix.iter().map(Complex64::norm_sqr).sum::<f64>().sqrt()
    };
    let ((right, mobility), (off, other_mobility)) =
        (with(1e-3, 0.0, Some(0.0)), with(1e-3, 0.05, Some(0.05)));
    assert!(
        norm(&(&mobility - &other_mobility)) < 1e-12 * norm(&mobility),
        "the scale cancels in FRFs"
    );
    assert!(
        norm(&(&right - &off)) < 1e-8 * norm(&right),
        "{} {}",
        norm(&right),
        norm(&off)
    );
    let (as_shape, _) = with(1e-3, 0.05, None);
    assert!(
        norm(&as_shape) > 1e3 * norm(&right),
        "taken for an error of the shape it would drown the others"
    );
}

#[test]
fn the_isotropic_part_is_an_error_of_each_entry() {
    let drift = Drift {
        frequency_relative: 0.0,
        loss_factor_relative: 0.0,
        shape_relative: 0.0,
        isotropic_relative: 0.01,
        drive_relative: Some(0.0),
    };
    let operator = Operator::of_model(truth(), 300.0, None).unwrap();
    let covariance = Covariance::of_model(truth(), &operator, &[0, 1], &drift);
    let rms = (operator
        .mobility
        .iter()
        .map(Complex64::norm_sqr)
        .sum::<f64>()
        / operator.mobility.len() as f64)
        .sqrt();
    let drive = ndarray::Array1::from_elem(34, Complex64::new(0.0, 2.0));
    assert!((covariance.deviation(&drive) / (0.01 * rms * 2.0 * 34f64.sqrt()) - 1.0).abs() < 1e-12);
}

#[test]
fn errors_of_the_drives_are_those_of_many_wrong_drives() {
    let none = Drift {
        frequency_relative: 0.0,
        loss_factor_relative: 0.0,
        shape_relative: 0.0,
        isotropic_relative: 0.0,
        drive_relative: Some(0.0),
    };
    let operator = Operator::of_model(truth(), 310.0, None).unwrap();
    let judged: Vec<usize> = (0..77).collect();
    let covariance = Covariance::of_model(
        truth(),
        &operator,
        &judged,
        &Drift {
            drive_relative: Some(0.03),
            ..none
        },
    );
    let drive: ndarray::Array1<Complex64> = (0..34)
        .map(|i| Complex64::from_polar(1e-3 * (1 + i % 3) as f64, i as f64))
        .collect();
    // E|Σ_i h_ki A_i δ_i|² = 0.03² Σ_i |h_ki|²|A_i|², averaged over k
    let squares = operator.mobility.rows().into_iter().map(|row| {
        row.iter()
            .zip(&drive)
            .map(|(h, a)| (h * a).norm_sqr())
            .sum::<f64>()
    });
    let expected = 0.03 * (squares.sum::<f64>() / 77.0).sqrt();
    assert!((covariance.deviation(&drive) / expected - 1.0).abs() < 1e-12);
}
