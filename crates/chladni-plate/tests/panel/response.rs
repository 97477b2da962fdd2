//! FRFs: what every passive structure must show, and the modal sum against its slow twin.

use chladni_frf::{Damping, FrfKind, FrfValues};
use chladni_plate::{
    simulate, synthesise_by_products, DampedPlate, LossFactor, Panel, Plate, PointMass, Simulation,
    Synthetic, SyntheticShapes,
};
use ndarray::{Array1, Array3};
use num_complex::Complex64;
use std::f64::consts::TAU;

const POINTS: [[f64; 2]; 4] = [[0.005, 0.02], [0.134, 0.085], [0.2, 0.165], [0.05, 0.1]];

/// The default panel with few points and lines, so that slow twins stay quick.
fn small_panel() -> Panel {
    let mut panel = Panel::default();
    panel.responses.grid = [3, 2];
    panel.responses.at_references = true;
    panel.references.edge_count = [2, 1];
    (panel.frf.start_hz, panel.frf.stop_hz, panel.frf.step_hz) = (5.0, 600.0, 1.7);
    panel
}

fn values(simulation: &Simulation) -> &Array3<Complex64> {
    match &simulation.frf.values {
        FrfValues::F64(values) => values,
        FrfValues::F32(_) => panic!("simulations are in double precision"),
    }
}

fn largest(values: &Array3<Complex64>) -> f64 {
    values.iter().fold(0.0, |largest, v| largest.max(v.norm()))
}

#[test]
fn mobility_is_reciprocal_and_every_driving_point_takes_power() {
    let masses = [PointMass {
        position_m: [0.2, 0.165],
        mass_kg: 0.003,
    }];
    for masses in [&masses[..0], &masses[..]] {
        let plate = DampedPlate::new(&Plate::default(), masses, 500.0).unwrap();
        for frequency_hz in [3.0, 54.35, 55.3, 299.4, 480.0] {
            let mobility = plate
                .mobility_matrix(&POINTS, &POINTS, frequency_hz)
                .unwrap();
            for i in 0..POINTS.len() {
                assert!(mobility[[i, i]].re >= 0.0);
                for j in 0..i {
                    assert!(
                        (mobility[[i, j]] - mobility[[j, i]]).norm()
                            <= 1e-12 * mobility[[i, i]].norm()
                    );
                }
            }
        }
    }
}

#[test]
fn far_below_the_first_mode_a_free_plate_moves_as_a_rigid_body() {
    let plate = Plate::default();
    let damped = DampedPlate::new(&plate, &[], 100.0).unwrap();
    let (frequency_hz, at) = (0.01, [0.2, 0.03]);
    let mobility = damped.mobility_matrix(&[at], &[at], frequency_hz).unwrap()[[0, 0]];
    let (arm_x, arm_y) = (at[0] - plate.length_m / 2.0, at[1] - plate.width_m / 2.0);
    let inertia = |side: f64| plate.mass() * side * side / 12.0;
    let accelerance = 1.0 / plate.mass()
        + arm_x.powi(2) / inertia(plate.length_m)
        + arm_y.powi(2) / inertia(plate.width_m);
    let expected = Complex64::new(0.0, -accelerance / (TAU * frequency_hz));
    assert!(
        (mobility - expected).norm() < 1e-6 * expected.norm(),
        "{mobility} instead of {expected}"
    );
}

#[test]
fn frfs_agree_with_the_modal_sum_written_out() {
    let plate = DampedPlate::new(
        &Plate {
            loss_factor: LossFactor::PerMode(vec![0.02, 0.03, 0.01]),
            ..Plate::default()
        },
        &[],
        300.0,
    )
    .unwrap();
    let axis = Array1::from(vec![10.0, 54.3, 120.0, 299.0]);
    let shapes = plate.modes.evaluate(&POINTS).unwrap();
    for kind in [FrfKind::Receptance, FrfKind::Mobility, FrfKind::Accelerance] {
        let frf = plate.frfs(kind, &POINTS, &POINTS[1..3], &axis).unwrap();
        for ((i, j, k), value) in frf.indexed_iter() {
            let omega = TAU * axis[k];
            let sum: Complex64 = (0..plate.modes.len())
                .map(|n| {
                    let eta = if n < 3 {
                        0.0
                    } else {
                        [0.02, 0.03, 0.01][(n - 3).min(2)]
                    };
                    let omega_n2 = plate.modes.omega()[n].powi(2);
                    shapes[[i, n]] * shapes[[j + 1, n]]
                        / Complex64::new(omega_n2 - omega * omega, eta * omega_n2)
                })
                .sum();
            let factor = [
                Complex64::new(1.0, 0.0),
                Complex64::new(0.0, omega),
                Complex64::new(-omega * omega, 0.0),
            ][kind.omega_power() as usize];
            assert!(
                (value - factor * sum).norm() < 1e-12 * (factor * sum).norm().max(value.norm())
            );
        }
    }
}

#[test]
fn the_truth_reproduces_the_frfs_without_noise_to_rounding() {
    for (mass_kg, kind) in [(0.0, FrfKind::Mobility), (1e-4, FrfKind::Accelerance)] {
        let mut panel = small_panel();
        (panel.references.mass_kg, panel.frf.kind) = (mass_kg, kind);
        let simulation = simulate(&panel, None, Some(f64::INFINITY)).unwrap();
        assert_eq!(simulation.noise_variance, 0.0);
        let synthesis = simulation.truth.synthesise(&simulation.frf.frequency_hz);
        let worst = largest(&(&synthesis - values(&simulation)));
        assert!(worst < 1e-10 * largest(&synthesis), "{worst:e}");
        let fast = synthesise_by_products(&simulation.truth, &simulation.frf.frequency_hz);
        assert!(largest(&(fast - &synthesis)) < 1e-12 * largest(&synthesis));
    }
}

#[test]
fn the_truth_marks_modes_in_and_out_of_band_and_is_mass_normalised() {
    let simulation = simulate(&small_panel(), None, None).unwrap();
    let truth = &simulation.truth;
    assert_eq!(truth.in_band_modes().count(), 17);
    assert!(truth.modes.len() >= 60 && truth.modes.last().unwrap().frequency_hz > 2000.0);
    assert!(truth
        .modes
        .windows(2)
        .all(|pair| pair[0].frequency_hz <= pair[1].frequency_hz));
    assert_eq!(truth.residual_terms.terms[0].power, -2);
    // driving points: the same DOF twice, the same shape value twice
    let mode = &truth.modes[4];
    assert_eq!(truth.responses[6..], truth.references[..]);
    assert_eq!(mode.shape.0[6..], mode.participation.0[..]);
    assert_eq!(truth.nodes.len(), 6 + 6);
    assert_eq!(truth.options["panel"]["frf"]["stop_hz"], 600.0);
}

#[test]
fn noise_has_the_asked_level_and_the_same_seed_gives_the_same_bits() {
    let panel = small_panel();
    let clean = simulate(&panel, None, Some(f64::INFINITY)).unwrap();
    let noisy = simulate(&panel, Some(5), Some(30.0)).unwrap();
    let power = |values: &Array3<Complex64>| {
        values.iter().map(|v| v.norm_sqr()).sum::<f64>() / values.len() as f64
    };
    let noise = power(&(values(&noisy) - values(&clean)));
    let count = values(&clean).len() as f64;
    let snr_db = 10.0 * (power(values(&clean)) / noise).log10();
    // the variance of `count` values scatters by 1/√count; 4.34 dB per unit of relative
    // change, four sigma
    assert!(
        (snr_db - 30.0).abs() < 4.0 * 4.35 / count.sqrt(),
        "{snr_db}"
    );
    assert!((noise / noisy.noise_variance - 1.0).abs() < 4.0 / count.sqrt());

    let again = simulate(&panel, Some(5), Some(30.0)).unwrap();
    assert_eq!(values(&noisy), values(&again));
    assert_ne!(
        values(&noisy),
        values(&simulate(&panel, Some(6), Some(30.0)).unwrap())
    );
    let mut named = panel.clone();
    (named.frf.seed, named.frf.snr_db) = (5, 30.0);
    assert_eq!(
        values(&noisy),
        values(&simulate(&named, None, None).unwrap()),
        "overrides stand for the panel's own keys"
    );
}

#[test]
fn frfs_have_the_same_bits_at_any_number_of_threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| simulate(&small_panel(), None, None).unwrap())
    };
    let (one, three) = (run(1), run(3));
    assert_eq!(values(&one), values(&three));
    assert_eq!(one.truth, three.truth);
}

#[test]
fn warnings_name_bands_without_modes_and_lines_too_far_apart() {
    let mut panel = small_panel();
    (panel.frf.start_hz, panel.frf.stop_hz) = (2.0, 40.0);
    let warnings = simulate(&panel, None, None).unwrap().findings;
    assert!(
        warnings[0].contains("no elastic mode") && warnings[0].contains("54.3"),
        "{warnings:?}"
    );
    panel.frf.stop_hz = 100.0;
    let warnings = simulate(&panel, None, None).unwrap().findings;
    assert!(
        warnings[0].contains("2 modes") && warnings[0].contains("step_hz"),
        "{warnings:?}"
    );
    assert!(simulate(&Panel::default(), None, None)
        .unwrap()
        .findings
        .is_empty());
}

#[test]
fn a_supported_plate_may_be_measured_from_zero_hertz() {
    let mut panel = small_panel();
    panel.plate.edges = "SSSS".to_string().try_into().unwrap();
    (panel.frf.start_hz, panel.frf.kind) = (0.0, FrfKind::Receptance);
    let simulation = simulate(&panel, None, Some(f64::INFINITY)).unwrap();
    assert!(simulation.truth.residual_terms.terms.is_empty());
    assert!(values(&simulation).iter().all(|v| v.is_finite()));
}

#[test]
fn synthetic_sets_follow_their_model_for_every_law_shape_and_kind() {
    for damping in [Damping::Structural, Damping::Viscous] {
        for shapes in [
            SyntheticShapes::Real,
            SyntheticShapes::Turned { phase_deg: 10.0 },
            SyntheticShapes::Complex,
        ] {
            for kind in [FrfKind::Receptance, FrfKind::Mobility, FrfKind::Accelerance] {
                let spec = Synthetic {
                    natural_frequency_hz: vec![70.0, 40.0, 40.0, 300.0],
                    loss_factor: vec![0.01, 0.02, 0.03, 0.04],
                    responses: 3,
                    references: 4,
                    damping,
                    shapes,
                    kind,
                    frequency_hz: Array1::range(10.0, 100.0, 3.0),
                    residual_powers: vec![-2, 0, 2],
                    snr_db: f64::INFINITY,
                    ..Synthetic::default()
                };
                let set = spec.build().unwrap();
                let slow = set.truth.synthesise(&spec.frequency_hz);
                let FrfValues::F64(fast) = &set.frf.values else {
                    panic!()
                };
                assert!(largest(&(&slow - fast)) < 1e-12 * largest(&slow));
                assert_eq!(
                    set.truth
                        .modes
                        .iter()
                        .map(|m| m.loss_factor)
                        .collect::<Vec<_>>(),
                    [0.02, 0.03, 0.01, 0.04]
                );
                assert_eq!(set.truth.in_band_modes().count(), 3);
                // reciprocity: references are the first nodes
                assert!((fast[[0, 1, 7]] - fast[[1, 0, 7]]).norm() < 1e-12 * largest(fast));
            }
        }
    }
}

#[test]
fn gain_noise_and_outliers_are_what_they_say() {
    let spec = Synthetic {
        snr_db: f64::INFINITY,
        ..Synthetic::default()
    };
    let clean = spec.build().unwrap().frf;
    let ratio = |set: &chladni_frf::FrfSet, i, j, k| {
        set.values.get(i, j, k) / clean.values.get(i, j, k) - 1.0
    };
    let lines = clean.frequency_hz.len();

    let mut common = clean.clone();
    chladni_plate::gain_noise(&mut common, 0.05, true, 3);
    assert!((0..lines).all(|k| (ratio(&common, 0, 0, k) - ratio(&common, 4, 1, k)).norm() < 1e-12));
    let mut own = clean.clone();
    chladni_plate::gain_noise(&mut own, 0.05, false, 3);
    let all: Vec<f64> = (0..5)
        .flat_map(|i| (0..2).flat_map(move |j| (0..lines).map(move |k| (i, j, k))))
        .map(|(i, j, k)| ratio(&own, i, j, k).norm_sqr())
        .collect();
    let size = (all.iter().sum::<f64>() / all.len() as f64).sqrt();
    // 14 000 values: 0.4 % of the root mean square
    assert!((size / 0.05 - 1.0).abs() < 0.02, "{size}");

    let mut spiked = clean.clone();
    chladni_plate::outliers(&mut spiked, 0.01, 5.0, 3);
    let changed = (0..5)
        .flat_map(|i| (0..2).flat_map(move |j| (0..lines).map(move |k| (i, j, k))))
        .filter(|&(i, j, k)| ratio(&spiked, i, j, k).norm() > 0.0)
        .count();
    assert!((100..180).contains(&changed), "{changed} of 14000");
}
