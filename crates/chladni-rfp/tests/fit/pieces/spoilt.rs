//! Unequal noise, outliers, gaps and noise alone: treated as in memory.

use super::blocks::{agree, blocks, difference, in_passes, in_pieces, set};
use crate::common::{easy, fitted};
use chladni_frf::{FrfSet, FrfValues, ModalModel, Trust};
use chladni_plate::{add_noise_of_variance, gain_noise, outliers};
use chladni_rfp::FitOptions;
use ndarray::{s, Array3};
use num_complex::Complex64;

/// The set with noise 45 dB below the data, times a factor of each response and reference.
fn unequal() -> FrfSet {
    let mut set = easy(f64::INFINITY, 3);
    (set.responses, set.references) = (64, 3);
    let mut frf = set.build().unwrap().frf;
    let values = values(&mut frf);
    let variance =
        10f64.powf(-4.5) * values.iter().map(|v| v.norm_sqr()).sum::<f64>() / values.len() as f64;
    let mut noise = Array3::zeros(values.dim());
    add_noise_of_variance(&mut noise, variance, 103);
    for (((i, j, _), value), noise) in values.indexed_iter_mut().zip(&noise) {
        *value += noise * level(i, j);
    }
    frf
}

fn values(frf: &mut FrfSet) -> &mut Array3<Complex64> {
    match &mut frf.values {
        FrfValues::F64(values) => values,
        FrfValues::F32(_) => panic!("synthetic sets are in double precision"),
    }
}

fn level(i: usize, j: usize) -> f64 {
    [1.0, 4.0, 1.0, 6.0, 5.0, 2.0][i % 6] * [2.0, 1.0, 3.0][j % 3]
}

#[test]
fn frfs_of_unequal_noise_are_weighted_as_in_memory() {
    let frf = unequal();
    let (model, _, passes) = in_passes(&blocks(&frf, 5));
    let memory = fitted(&frf, &FitOptions::default());
    agree(&model, &memory, 0.1, 0.02);
    let weights = |model: &ModalModel| {
        let path = model.quality.path.clone().unwrap();
        path.split_once("FRFs weighted").unwrap().1.to_owned()
    };
    assert!(weights(&model).starts_with(" by their noise") && !weights(&memory).is_empty());
    assert!(
        passes <= 4,
        "{passes}: sketch, products, and both once more with weights"
    );
    // as the data themselves tell it: from the start
    let mut given = frf;
    given.variance = Some(Array3::from_shape_fn(given.values.dim(), |(i, j, _)| {
        (1e-3 * level(i, j)).powi(2)
    }));
    let cut = |count: usize| -> Vec<(u64, FrfSet)> {
        let variance = given.variance.as_ref().unwrap();
        let of = |b: usize| b * 64 / count;
        let with = |(b, block): (u64, FrfSet)| {
            let rows = of(b as usize)..of(b as usize + 1);
            let variance = Some(variance.slice(s![rows, .., ..]).to_owned());
            (b, FrfSet { variance, ..block })
        };
        blocks(&given, count).into_iter().map(with).collect()
    };
    let (model, _, passes) = in_passes(&cut(5));
    let memory = fitted(&given, &FitOptions::default());
    agree(&model, &memory, 0.1, 0.02);
    assert_eq!(weights(&model), weights(&memory));
    assert!(weights(&model).ends_with("as the variances of the set say"));
    assert!(passes <= 4, "{passes}");
}

#[test]
fn outlier_lines_of_measured_data_are_left_out_as_in_memory() {
    let mut noisy = set();
    gain_noise(&mut noisy.frf, 0.05, true, 4);
    outliers(&mut noisy.frf, 1e-4, 30.0, 3);
    let (model, _) = in_pieces(&blocks(&noisy.frf, 5));
    let memory = fitted(&noisy.frf, &FitOptions::default());
    let lines = |model: &ModalModel| -> Vec<f64> {
        let found = model.quality.findings.iter();
        let found = found.filter(|finding| finding.code == "outlier-lines");
        found
            .flat_map(|finding| finding.values["lines_hz"].as_slice().to_vec())
            .collect()
    };
    let (own, whole) = (lines(&model), lines(&memory));
    assert!(!whole.is_empty());
    let shared = own.iter().filter(|hz| whole.contains(hz)).count();
    assert!(
        10 * shared >= 8 * whole.len() && 10 * shared >= 8 * own.len(),
        "{own:?} against {whole:?}"
    );
    let sure = |model: &ModalModel| {
        let modes = model.in_band_modes();
        modes.filter(|mode| mode.trust == Trust::Sure).count()
    };
    assert_eq!((sure(&model), sure(&memory)), (8, 8));
}

#[test]
fn missing_lines_and_frfs_are_left_out_as_in_memory() {
    let mut set = set();
    let values = values(&mut set.frf);
    let nothing = Complex64::new(f64::NAN, f64::NAN);
    values.slice_mut(s![40, 1, ..]).fill(nothing);
    values
        .slice_mut(s![.., .., 700..703])
        .fill(Complex64::default());
    values[[3, 0, 100]] = nothing;
    let model = in_pieces(&blocks(&set.frf, 5)).0;
    let memory = fitted(&set.frf, &FitOptions::default());
    assert!(difference(&model, &memory) < 1e-6);
    assert!(
        model
            .quality
            .findings
            .iter()
            .any(|w| w.code == "lines-without-values" && w.text.starts_with("4 of ")),
        "{:?}",
        model.quality.findings
    );
}

#[test]
fn an_frf_with_a_long_gap_costs_its_lines_in_pieces() {
    let mut set = set();
    let values = values(&mut set.frf);
    let nothing = Complex64::new(f64::NAN, f64::NAN);
    let lines = values.len_of(ndarray::Axis(2));
    values.slice_mut(s![3, 1, ..lines / 2]).fill(nothing);
    let model = in_pieces(&blocks(&set.frf, 5)).0;
    let mut findings = model.quality.findings.iter();
    let lost = findings.find(|finding| finding.code == "lines-without-values");
    assert_eq!(
        lost.unwrap().values["lines_left_out"].as_slice(),
        [(lines / 2) as f64]
    );
}

/// Scattered light spoils a whole corner of a scan: its block adds nothing.
#[test]
fn a_block_without_a_value_is_left_out_as_in_memory() {
    let set = set();
    let first = blocks(&set.frf, 5)[0].1.responses.len();
    let FrfValues::F64(mut values) = set.frf.values.clone() else {
        panic!("double precision")
    };
    for nothing in [Complex64::new(f64::NAN, f64::NAN), Complex64::default()] {
        values.slice_mut(s![..first, .., ..]).fill(nothing);
        let frf = FrfSet {
            values: FrfValues::F64(values.clone()),
            ..set.frf.clone()
        };
        let memory = fitted(&frf, &FitOptions::default());
        assert!(difference(&in_pieces(&blocks(&frf, 5)).0, &memory) < 1e-6);
    }
}

#[test]
fn outlier_lines_gain_noise_and_the_wrong_time_sign_take_their_paths() {
    let mut spoilt = set();
    outliers(&mut spoilt.frf, 1e-4, 30.0, 3);
    let (model, _) = in_pieces(&blocks(&spoilt.frf, 5));
    assert_eq!(
        model
            .in_band_modes()
            .filter(|mode| mode.trust == Trust::Sure)
            .count(),
        8
    );
    assert!(
        model
            .quality
            .findings
            .iter()
            .any(|w| w.contains("outlier lines")),
        "{:?}",
        model.quality.findings
    );

    let mut noisy = set();
    gain_noise(&mut noisy.frf, 0.05, true, 4);
    let (model, _) = in_pieces(&blocks(&noisy.frf, 5));
    assert!(
        model
            .quality
            .path
            .as_deref()
            .unwrap()
            .starts_with("measured-data path"),
        "{:?}",
        model.quality.path
    );
    assert_eq!(
        model
            .in_band_modes()
            .filter(|mode| mode.trust == Trust::Sure)
            .count(),
        8
    );

    let mut turned = set();
    turned.frf.conjugate();
    let (model, _) = in_pieces(&blocks(&turned.frf, 5));
    assert!(
        !model.quality.trusted
            && model
                .quality
                .findings
                .iter()
                .any(|w| w.contains("the other time sign")),
        "{:?}",
        model.quality.findings
    );
}

#[test]
fn noise_alone_gives_no_mode() {
    let mut set = set();
    let values = values(&mut set.frf);
    *values = Array3::zeros(values.dim());
    add_noise_of_variance(values, 1e-6, 9);
    let (model, _) = in_pieces(&blocks(&set.frf, 3));
    assert_eq!(model.in_band_modes().count(), 0);
    assert!(!model.quality.trusted);
}
