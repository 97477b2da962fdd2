//! FRFs that are not equally noisy: weighted, the fit stands at the bound of weighted
//! data, and comes back in measured units.

use crate::common::{easy, fitted, resynthesis_error};
use chladni_frf::{Damping, Finding, FrfSet, FrfValues, ModalModel};
use chladni_plate::{
    add_noise_of_variance, cramer_rao_real, gain_noise, outliers, synthesise_by_products,
    CramerRao, Synthetic, SyntheticSet,
};
use chladni_rfp::FitOptions;
use ndarray::{Array1, Array3};
use num_complex::Complex64;

/// Noise of each response and reference, in units of the quietest.
const RESPONSES: [f64; 6] = [1.0, 4.0, 1.0, 6.0, 5.0, 2.0];
const REFERENCES: [f64; 2] = [2.0, 1.0];

/// The easy set with noise 45 dB below the data, times what the sensor and the exciter
/// make of it; and the bound: that of equal noise on FRFs divided by the same factors.
fn unequal(seed: u64) -> (SyntheticSet, CramerRao) {
    let mut set = easy(f64::INFINITY, seed).build().unwrap();
    let FrfValues::F64(values) = &mut set.frf.values else {
        panic!("synthetic sets are in double precision")
    };
    let variance =
        10f64.powf(-4.5) * values.iter().map(|v| v.norm_sqr()).sum::<f64>() / values.len() as f64;
    let mut noise = Array3::zeros(values.dim());
    add_noise_of_variance(&mut noise, variance, 100 + seed);
    for (((i, j, _), value), noise) in values.indexed_iter_mut().zip(&noise) {
        *value += noise * RESPONSES[i] * REFERENCES[j];
    }
    let mut even = set.truth.clone();
    for mode in &mut even.modes {
        mode.shape
            .0
            .iter_mut()
            .zip(RESPONSES)
            .for_each(|(value, level)| *value /= level);
        mode.participation
            .0
            .iter_mut()
            .zip(REFERENCES)
            .for_each(|(value, level)| *value /= level);
    }
    let bound = cramer_rao_real(&even, &set.frf.frequency_hz, variance, &[-2, 0, 2, 4]).unwrap();
    (set, bound)
}

#[test]
fn variances_that_the_set_gives_are_the_weights_from_the_start() {
    let (set, _) = unequal(3);
    let learnt = fitted(&set.frf, &FitOptions::default());
    let mut given = set.frf.clone();
    let noise = Array3::from_shape_fn(given.values.dim(), |(i, j, _)| {
        (1e-3 * RESPONSES[i] * REFERENCES[j]).powi(2)
    });
    given.variance = Some(noise);
    let model = fitted(&given, &FitOptions::default());
    assert!(
        path(&model).ends_with("as the variances of the set say"),
        "{}",
        path(&model)
    );
    assert!(
        path(&model)
            .contains("differs 6.0 times between responses and 2.0 times between references"),
        "{}",
        path(&model)
    );
    for (mode, other) in model.in_band_modes().zip(learnt.in_band_modes()) {
        assert!((mode.frequency_hz - other.frequency_hz).abs() < 0.2 * other.frequency_std_hz);
        assert!((mode.frequency_std_hz / other.frequency_std_hz - 1.0).abs() < 0.05);
    }
    // equal ones change nothing, and where one is not known the data tell
    given.variance = Some(Array3::from_elem(given.values.dim(), 1e-6));
    let equal = fitted(&given, &FitOptions::default());
    assert!(
        !path(&equal).contains("as the variances of the set say"),
        "{}",
        path(&equal)
    );
    given.variance.as_mut().unwrap()[[0, 0, 700]] = f64::NAN;
    assert_eq!(path(&fitted(&given, &FitOptions::default())), path(&learnt));
}

#[test]
fn given_weights_hide_no_outlier_line_and_make_no_pole_move() {
    let (mut set, _) = unequal(3);
    gain_noise(&mut set.frf, 0.05, true, 4);
    outliers(&mut set.frf, 2e-3, 30.0, 3);
    let lines = |model: &ModalModel| -> Vec<f64> {
        let found = model.quality.findings.iter();
        let found = found.filter(|finding| finding.code == "outlier-lines");
        found
            .flat_map(|finding| finding.values["lines_hz"].as_slice().to_vec())
            .collect()
    };
    let plain = fitted(&set.frf, &FitOptions::default());
    set.frf.variance = Some(Array3::from_shape_fn(set.frf.values.dim(), |(i, j, _)| {
        (1e-3 * RESPONSES[i] * REFERENCES[j]).powi(2)
    }));
    let model = fitted(&set.frf, &FitOptions::default());
    assert!(path(&model).starts_with("measured-data path"));
    assert!(path(&model).ends_with("as the variances of the set say"));
    let (whole, own) = (lines(&plain), lines(&model));
    let shared = own.iter().filter(|hz| whole.contains(hz)).count();
    assert!(
        !whole.is_empty() && 10 * shared >= 8 * whole.len(),
        "{own:?} against {whole:?}"
    );
    let moving = |finding: &&Finding| finding.code == "moving-poles";
    assert_eq!(model.quality.findings.iter().find(moving), None);
}

/// The coherence of 1/(1 + noise over signal), where the noise of a pair stands 45 dB
/// below the data, times `level`.
fn with_coherence(set: &SyntheticSet, level: impl Fn(usize, usize) -> f64) -> FrfSet {
    let mut frf = set.frf.clone();
    let FrfValues::F64(values) = &frf.values else {
        panic!("synthetic sets are in double precision")
    };
    let variance =
        10f64.powf(-4.5) * values.iter().map(|v| v.norm_sqr()).sum::<f64>() / values.len() as f64;
    let squared = |((i, j, _), value): ((usize, usize, usize), &Complex64)| {
        1.0 / (1.0 + variance * level(i, j).powi(2) / value.norm_sqr())
    };
    let coherence = Array3::from_shape_vec(
        values.dim(),
        values
            .indexed_iter()
            .map(|value| squared(value) as f32)
            .collect(),
    )
    .unwrap();
    frf.coherence = Some(coherence);
    frf
}

#[test]
fn coherence_gives_the_weights_where_the_residual_does_not_contradict_it() {
    let (set, _) = unequal(3);
    let learnt = fitted(&set.frf, &FitOptions::default());
    let told = fitted(
        &with_coherence(&set, |i, j| RESPONSES[i] * REFERENCES[j]),
        &FitOptions::default(),
    );
    assert!(
        path(&told).ends_with("as the coherence of the set says"),
        "{}",
        path(&told)
    );
    for (mode, other) in told.in_band_modes().zip(learnt.in_band_modes()) {
        assert!((mode.frequency_hz - other.frequency_hz).abs() < 0.2 * other.frequency_std_hz);
        assert!((mode.frequency_std_hz / other.frequency_std_hz - 1.0).abs() < 0.05);
    }
    // the noise of other sensors: named, and the fit is the one without coherence
    let wrong = fitted(
        &with_coherence(&set, |i, j| RESPONSES[5 - i] * REFERENCES[j]),
        &FitOptions::default(),
    );
    assert_eq!(path(&wrong), path(&learnt));
    assert!(wrong
        .quality
        .findings
        .iter()
        .any(|warning| warning.contains("coherence of the set does not tell its noise")));
    assert_eq!(wrong.modes, learnt.modes);
    // one that is 1 everywhere tells nothing
    let mut flat = set.frf.clone();
    flat.coherence = Some(Array3::ones(flat.values.dim()));
    assert_eq!(fitted(&flat, &FitOptions::default()), learnt);
}

fn path(model: &ModalModel) -> &str {
    model.quality.path.as_deref().unwrap()
}

#[test]
fn weighted_frfs_reach_the_bound_of_weighted_data_and_their_bars_are_honest() {
    let (mut squares, mut count) = ([0.0; 2], 0);
    let (mut poles_covered, mut shapes_covered, mut entries) = (0, 0, 0);
    for seed in 0..10 {
        let (set, bound) = unequal(seed);
        let model = fitted(&set.frf, &FitOptions::default());
        assert!(
            path(&model).contains("weighted by their noise"),
            "{}",
            path(&model)
        );
        assert_eq!(model.in_band_modes().count(), 8);
        for (n, (mode, truth)) in model
            .in_band_modes()
            .zip(set.truth.in_band_modes())
            .enumerate()
        {
            let error = [
                mode.frequency_hz - truth.frequency_hz,
                mode.loss_factor - truth.loss_factor,
            ];
            let over = [
                error[0] / bound.frequency_std_hz[n],
                error[1] / bound.loss_factor_std[n],
            ];
            (0..2).for_each(|e| squares[e] += over[e] * over[e]);
            count += 1;
            poles_covered += usize::from(error[0].abs() < 1.96 * mode.frequency_std_hz);
            poles_covered += usize::from(error[1].abs() < 1.96 * mode.loss_factor_std);
            let sign = (mode.shape.0[0] * truth.shape.0[0]).re.signum();
            for ((a, b), std) in mode.shape.0.iter().zip(&truth.shape.0).zip(&mode.shape_std) {
                shapes_covered += usize::from((a * sign - b).norm() < 1.96 * std);
                entries += 1;
            }
        }
    }
    for (what, sum) in ["frequency", "loss factor"].into_iter().zip(squares) {
        let over = (sum / f64::from(count)).sqrt();
        assert!(
            (0.8..1.2).contains(&over),
            "{what}: error over bound {over}"
        );
    }
    let share = f64::from(u32::try_from(poles_covered).unwrap()) / f64::from(2 * count);
    assert!(
        (0.88..0.995).contains(&share),
        "95 % bars of poles hold {share}"
    );
    let share = shapes_covered as f64 / entries as f64;
    assert!(
        (0.9..0.99).contains(&share),
        "95 % bars of shapes hold {share}"
    );
}

#[test]
fn a_weighted_model_is_in_measured_units_and_equal_noise_is_not_weighted() {
    let (set, _) = unequal(3);
    let model = fitted(&set.frf, &FitOptions::default());
    let relative = resynthesis_error(&model, &set.frf);
    // the model takes it from sums over the data: its digits are those of the square of
    // the residual
    let told = model.quality.relative_error;
    assert!((relative / told - 1.0).abs() < 1e-9, "{relative} {told}");
    let even = easy(40.0, 3).build().unwrap();
    assert!(!path(&fitted(&even.frf, &FitOptions::default())).contains("weighted"));
}

/// Three modes over eight responses and two driving points, and noise that no weights of responses
/// and references make equal: the first two modes move mostly in one loud FRF each, the third in
/// those that are quieter than the mean.
fn beyond_weights(seed: u64) -> SyntheticSet {
    let synthetic = Synthetic {
        natural_frequency_hz: vec![40.0, 80.0, 120.0],
        loss_factor: vec![0.02, 0.01, 0.015],
        responses: 8,
        references: 2,
        frequency_hz: Array1::range(20.0, 150.0, 0.2),
        snr_db: f64::INFINITY,
        ..Synthetic::default()
    };
    let mut set = synthetic.build().unwrap();
    for (n, mode) in set.truth.modes.iter_mut().enumerate() {
        let moves = |i: usize| if n == 2 { i >= 2 } else { i == n };
        let values = (0..8).map(|i| Complex64::from(if moves(i) { 1.0 } else { 0.1 }));
        mode.shape.0 = values.collect();
        mode.participation.0 = mode.shape.0[..2].to_vec();
    }
    let mut values = synthesise_by_products(&set.truth, &synthetic.frequency_hz);
    let mean = values.iter().map(|v| v.norm_sqr()).sum::<f64>() / values.len() as f64;
    let mut noise = Array3::zeros(values.dim());
    add_noise_of_variance(&mut noise, 1e-6 * mean, 200 + seed);
    for (((i, j, _), value), noise) in values.indexed_iter_mut().zip(&noise) {
        *value += match (i, i == j) {
            (0 | 1, true) => 6.0 * noise,
            (0 | 1, false) => noise / 6.0,
            _ => *noise,
        };
    }
    set.frf.values = FrfValues::F64(values);
    set
}

#[test]
fn bars_hold_where_noise_of_frfs_is_beyond_weights() {
    let (mut squares, mut shapes) = ([[0.0; 2]; 3], [(0, 0); 3]);
    let seeds = 40;
    for seed in 0..seeds {
        let set = beyond_weights(seed);
        let options = FitOptions {
            damping: Some(Damping::Structural),
            ..FitOptions::default()
        };
        let model = fitted(&set.frf, &options);
        assert_eq!(model.in_band_modes().count(), 3, "{:?}", model.quality);
        for (n, (mode, truth)) in model
            .in_band_modes()
            .zip(set.truth.in_band_modes())
            .enumerate()
        {
            let over = [
                (mode.frequency_hz - truth.frequency_hz) / mode.frequency_std_hz,
                (mode.loss_factor - truth.loss_factor) / mode.loss_factor_std,
            ];
            (0..2).for_each(|e| squares[n][e] += over[e] * over[e]);
            let sign = mode.shape.0[2].re.signum();
            for ((a, b), std) in mode.shape.0.iter().zip(&truth.shape.0).zip(&mode.shape_std) {
                shapes[n].0 += usize::from((a * sign - b).norm() < 1.96 * std);
                shapes[n].1 += 1;
            }
        }
    }
    for (n, (of_mode, (held, values))) in squares.into_iter().zip(shapes).enumerate() {
        for sum in of_mode {
            let over = (sum / seeds as f64).sqrt();
            assert!(
                (0.75..1.3).contains(&over),
                "mode {n}: error over bar {over}"
            );
        }
        let share = held as f64 / values as f64;
        assert!(
            (0.9..0.99).contains(&share),
            "mode {n}: shapes hold {share}"
        );
    }
}

/// The residual of the first fit holds the errors of poles that loud FRFs moved: it told the noise
/// of the quiet one up to 13 times too loud.
#[test]
fn a_sensor_a_hundred_times_quieter_has_its_weight() {
    for seed in 0..4 {
        let set = Synthetic {
            natural_frequency_hz: vec![40.0, 80.0, 120.0],
            loss_factor: vec![0.02, 0.01, 0.015],
            responses: 4,
            references: 1,
            frequency_hz: Array1::range(20.0, 150.0, 0.2),
            snr_db: f64::INFINITY,
            seed,
            ..Synthetic::default()
        };
        let mut frf = set.build().unwrap().frf;
        let FrfValues::F64(values) = &mut frf.values else {
            panic!("synthetic sets are in double precision")
        };
        let mean = values.iter().map(|v| v.norm_sqr()).sum::<f64>() / values.len() as f64;
        let mut noise = Array3::zeros(values.dim());
        add_noise_of_variance(&mut noise, 1e-5 * mean, 300 + seed);
        for (((i, _, _), value), noise) in values.indexed_iter_mut().zip(&noise) {
            *value += noise * if i == 2 { 0.01 } else { 1.0 };
        }
        let model = fitted(&frf, &FitOptions::default());
        let told = path(&model).split("differs ").nth(1).unwrap();
        let ratio: f64 = told.split(' ').next().unwrap().parse().unwrap();
        assert!((85.0..115.0).contains(&ratio), "seed {seed}: {told}");
    }
}
