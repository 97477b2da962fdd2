//! Identification through the public door, judged by known truth and the Cramér–Rao
//! bound.

use crate::common::{easy, fitted};
use chladni_frf::{Damping, FrfKind, FrfSet, FrfValues, ModalModel, Mode, Trust};
use chladni_plate::{cramer_rao, gain_noise, simulate, Panel, Synthetic, SyntheticShapes};
use chladni_rfp::{fit, mac, FitError, FitOptions, Method, ShapeModel};
use ndarray::Array1;

/// Number of modes of `truth` that the model misses, and of those it invents.
fn missed_and_spurious(truth: &ModalModel, model: &ModalModel) -> (usize, usize) {
    let (missed, spurious) = crate::common::missed_and_spurious(truth, model);
    (missed.len(), spurious.len())
}

#[test]
fn every_mode_is_found_and_none_invented_down_to_20_db() {
    for snr_db in [60.0, 40.0, 20.0] {
        for seed in 0..3 {
            let set = easy(snr_db, seed).build().unwrap();
            let model = fitted(&set.frf, &FitOptions::default());
            assert_eq!(
                missed_and_spurious(&set.truth, &model),
                (0, 0),
                "{snr_db} dB, seed {seed}: {:?}",
                model.quality
            );
            assert!(model.quality.trusted);
            assert_eq!(
                model
                    .in_band_modes()
                    .filter(|m| m.trust == Trust::Sure)
                    .count(),
                8
            );
        }
    }
}

/// Lines far coarser than the bandwidths: the resonances stand between them, and their
/// skirts tell where.
#[test]
fn modes_narrower_than_a_line_are_found_by_their_skirts() {
    let mut panel = Panel::default();
    panel.frf.step_hz = 8.0;
    for seed in 1..4 {
        panel.frf.seed = seed;
        let set = simulate(&panel, None, None).unwrap();
        let model = fitted(&set.frf, &FitOptions::default());
        let known: Vec<&Mode> = set.truth.in_band_modes().collect();
        let found: Vec<&Mode> = model.in_band_modes().collect();
        assert_eq!(found.len(), known.len(), "{:?}", model.quality);
        for (known, found) in known.into_iter().zip(found) {
            let off = (found.frequency_hz - known.frequency_hz).abs() / found.frequency_std_hz;
            assert!(
                off < 5.0 && found.trust == Trust::Sure,
                "{} Hz is {off:.1} error bars off",
                known.frequency_hz
            );
        }
    }
}

#[test]
fn errors_stand_at_the_cramer_rao_bound_and_their_bars_are_honest() {
    // 12 seeds x 8 modes: the ratio of a chi-square to its mean with 96 degrees of
    // freedom stays within 0.7..1.4 (5 sigma)
    let (mut frequency, mut loss, mut covered, mut count) = (0.0, 0.0, 0, 0);
    for seed in 0..12 {
        let set = easy(40.0, 100 + seed).build().unwrap();
        let bound = cramer_rao(
            &set.truth,
            &set.frf.frequency_hz,
            set.noise_variance,
            &[-2, 0, 2, 4],
        )
        .unwrap();
        // the bound is that of free residues
        let options = FitOptions {
            damping: Some(Damping::Structural),
            shapes: ShapeModel::Free,
            ..Default::default()
        };
        let model = fitted(&set.frf, &options);
        let modes: Vec<&Mode> = model.in_band_modes().collect();
        for (n, truth) in set.truth.in_band_modes().enumerate() {
            let mode = modes[n];
            frequency +=
                ((mode.frequency_hz - truth.frequency_hz) / bound.frequency_std_hz[n]).powi(2);
            loss += ((mode.loss_factor - truth.loss_factor) / bound.loss_factor_std[n]).powi(2);
            covered += usize::from(
                (mode.frequency_hz - truth.frequency_hz).abs() < 1.96 * mode.frequency_std_hz,
            );
            covered += usize::from(
                (mode.loss_factor - truth.loss_factor).abs() < 1.96 * mode.loss_factor_std,
            );
            count += 1;
        }
    }
    let (frequency, loss) = (
        (frequency / count as f64).sqrt(),
        (loss / count as f64).sqrt(),
    );
    assert!(
        (0.75..1.3).contains(&frequency),
        "frequency error over bound {frequency}"
    );
    assert!(
        (0.75..1.3).contains(&loss),
        "loss factor error over bound {loss}"
    );
    let coverage = covered as f64 / (2 * count) as f64;
    assert!(coverage > 0.88, "95 % bars cover {coverage}");
}

#[test]
fn noise_free_poles_are_exact() {
    let set = Synthetic {
        snr_db: f64::INFINITY,
        ..easy(0.0, 7)
    }
    .build()
    .unwrap();
    let model = fitted(
        &set.frf,
        &FitOptions {
            damping: Some(Damping::Structural),
            ..Default::default()
        },
    );
    let modes: Vec<&Mode> = model.in_band_modes().collect();
    assert_eq!(modes.len(), 8);
    for (mode, truth) in modes.iter().zip(set.truth.in_band_modes()) {
        assert!(
            (mode.frequency_hz / truth.frequency_hz - 1.0).abs() < 1e-10,
            "{} {}",
            mode.frequency_hz,
            truth.frequency_hz
        );
        assert!((mode.loss_factor / truth.loss_factor - 1.0).abs() < 1e-8);
    }
    assert!(
        model.quality.relative_error < 1e-8,
        "{}",
        model.quality.relative_error
    );
}

#[test]
fn the_model_alone_resynthesises_the_fit() {
    let set = easy(40.0, 5).build().unwrap();
    let model = fitted(&set.frf, &FitOptions::default());
    let text = serde_json::to_string(&model).unwrap();
    let read: ModalModel = serde_json::from_str(&text).unwrap();
    let relative = crate::common::resynthesis_error(&read, &set.frf);
    assert!(
        (relative - model.quality.relative_error).abs() < 1e-12,
        "{relative} {}",
        model.quality.relative_error
    );
    // 40 dB of noise, a few per cent of it fitted away
    assert!((0.0095..0.0101).contains(&relative), "{relative}");
    assert!(
        (0.9..1.1).contains(&model.quality.chi2_per_dof),
        "{}",
        model.quality.chi2_per_dof
    );
}

#[test]
fn shapes_scale_to_unit_modal_mass_through_a_driving_point() {
    let set = easy(50.0, 9).build().unwrap();
    let model = fitted(&set.frf, &FitOptions::default());
    for (mode, truth) in model.in_band_modes().zip(set.truth.in_band_modes()) {
        assert!(mac(&mode.shape.0, &truth.shape.0) > 0.9999);
        let sign = if (mode.shape.0[0] * truth.shape.0[0]).re < 0.0 {
            -1.0
        } else {
            1.0
        };
        for (a, b) in mode.shape.0.iter().zip(&truth.shape.0) {
            let largest = truth.shape.0.iter().map(|v| v.norm()).fold(0.0, f64::max);
            assert!((a * sign - b).norm() < 0.02 * largest, "{a} {b}");
        }
    }
}

#[test]
fn what_the_mass_scale_errs_by_is_stated_apart_from_the_rest_of_the_shape() {
    // 12 seeds x 8 modes; the part of six shape values along the truth is not the scale
    // alone, so that the bounds are wide
    let (mut of_scale, mut of_rest, mut stated_rest, mut count) = (0.0, 0.0, 0.0, 0.0);
    for seed in 0..12 {
        let set = easy(30.0, 300 + seed).build().unwrap();
        let model = fitted(&set.frf, &FitOptions::default());
        for (mode, truth) in model.in_band_modes().zip(set.truth.in_band_modes()) {
            let (found, known) = (&mode.shape.0, &truth.shape.0);
            let size: f64 = known.iter().map(|value| value.norm_sqr()).sum();
            let factor = known
                .iter()
                .zip(found)
                .map(|(known, found)| known.conj() * found)
                .sum::<num_complex::Complex64>()
                / size;
            let scale_std = mode.scale_std.expect("driving points were measured");
            of_scale += ((factor.norm() - 1.0) / scale_std).powi(2);
            let left = known
                .iter()
                .zip(found)
                .map(|(known, found)| (found / factor - known).norm_sqr());
            of_rest += left.sum::<f64>() / size;
            stated_rest += (0..known.len())
                .map(|i| mode.shape_std_at_known_scale(i).powi(2))
                .sum::<f64>()
                / size;
            count += 1.0;
        }
    }
    let (scale, rest) = ((of_scale / count).sqrt(), (of_rest / stated_rest).sqrt());
    assert!(
        (0.5..2.0).contains(&scale),
        "error of the scale over what is stated: {scale}"
    );
    assert!(
        (0.6..1.5).contains(&rest),
        "error of the rest over what is stated: {rest}"
    );
}

#[test]
fn receptance_and_accelerance_of_the_same_structure_give_the_same_modes() {
    for kind in [FrfKind::Receptance, FrfKind::Accelerance] {
        let set = Synthetic {
            kind,
            ..easy(50.0, 3)
        }
        .build()
        .unwrap();
        let model = fitted(&set.frf, &FitOptions::default());
        assert_eq!(
            missed_and_spurious(&set.truth, &model),
            (0, 0),
            "{kind}: {:?}",
            model.quality
        );
    }
}

#[test]
fn single_precision_and_missing_pairs_change_nothing_but_digits() {
    let set = easy(40.0, 11).build().unwrap();
    let whole = fitted(&set.frf, &FitOptions::default());
    let mut narrow = set.frf.clone();
    if let FrfValues::F64(values) = &set.frf.values {
        let mut values = values.mapv(|v| num_complex::Complex32::new(v.re as f32, v.im as f32));
        values
            .slice_mut(ndarray::s![2, 1, ..])
            .fill(num_complex::Complex32::new(f32::NAN, f32::NAN));
        narrow.values = FrfValues::F32(values);
    }
    let model = fitted(&narrow, &FitOptions::default());
    assert!(
        model
            .quality
            .findings
            .iter()
            .any(|w| w.contains("1 of 12 FRFs")),
        "{:?}",
        model.quality.findings
    );
    for (a, b) in model.in_band_modes().zip(whole.in_band_modes()) {
        assert!((a.frequency_hz - b.frequency_hz).abs() < 3.0 * b.frequency_std_hz);
    }
}

#[test]
fn the_damping_law_is_decided_where_the_data_can_and_named_undecidable_where_not() {
    // equal loss factors, and a phase of all FRFs that lies half-way between the laws
    let mut light = Synthetic {
        loss_factor: vec![0.01],
        ..easy(50.0, 2)
    }
    .build()
    .unwrap();
    if let FrfValues::F64(values) = &mut light.frf.values {
        values.mapv_inplace(|v| v * num_complex::Complex64::from_polar(1.0, 0.0025));
    }
    let model = fitted(&light.frf, &FitOptions::default());
    assert!(
        model
            .quality
            .findings
            .iter()
            .any(|w| w.contains("undecidable")),
        "{:?}",
        model.quality.findings
    );
    let heavy = Synthetic {
        damping: Damping::Viscous,
        loss_factor: vec![0.08],
        snr_db: 100.0,
        ..easy(100.0, 2)
    };
    let set = heavy.build().unwrap();
    let model = fitted(&set.frf, &FitOptions::default());
    assert_eq!(model.damping, Damping::Viscous);
    assert_eq!(missed_and_spurious(&set.truth, &model), (0, 0));
    for (mode, truth) in model.in_band_modes().zip(set.truth.in_band_modes()) {
        // √Re λ as frequency would be wrong by ζ² = 1.6e-3
        assert!(
            (mode.frequency_hz / truth.frequency_hz - 1.0).abs() < 2e-4,
            "{} {}",
            mode.frequency_hz,
            truth.frequency_hz
        );
    }
}

#[test]
fn gain_noise_adds_no_mode() {
    for common in [false, true] {
        let mut set = easy(40.0, 4).build().unwrap();
        gain_noise(&mut set.frf, 0.05, common, 21);
        let model = fitted(&set.frf, &FitOptions::default());
        assert_eq!(
            missed_and_spurious(&set.truth, &model).0,
            0,
            "common {common}"
        );
        let sure_but_false = model
            .in_band_modes()
            .filter(|m| m.trust == Trust::Sure)
            .filter(|m| {
                !set.truth.in_band_modes().any(|t| {
                    (m.frequency_hz - t.frequency_hz).abs() < t.frequency_hz * t.loss_factor
                })
            })
            .count();
        assert_eq!(
            sure_but_false,
            0,
            "common {common}: {:?}",
            model
                .in_band_modes()
                .map(|m| m.frequency_hz)
                .collect::<Vec<_>>()
        );
    }
}

#[test]
fn pure_noise_has_no_sure_mode_and_is_not_trusted() {
    for seed in 0..3 {
        let mut set = Synthetic {
            frequency_hz: Array1::range(20.0, 100.0, 0.1),
            ..easy(0.0, seed)
        }
        .build()
        .unwrap();
        if let FrfValues::F64(values) = &mut set.frf.values {
            values.fill(num_complex::Complex64::default());
            chladni_plate::add_noise_of_variance(values, 1.0, seed);
        }
        let model = fitted(&set.frf, &FitOptions::default());
        assert_eq!(
            model
                .in_band_modes()
                .filter(|m| m.trust == Trust::Sure)
                .count(),
            0,
            "seed {seed}"
        );
        assert!(!model.quality.trusted);
    }
}

#[test]
fn the_wrong_time_sign_is_named_and_not_trusted() {
    let mut set = easy(40.0, 6).build().unwrap();
    set.frf.conjugate();
    let model = fitted(&set.frf, &FitOptions::default());
    assert!(!model.quality.trusted);
    assert!(
        model
            .quality
            .findings
            .iter()
            .any(|w| w.contains("the other time sign")),
        "{:?}",
        model.quality.findings
    );
}

#[test]
fn complex_shapes_keep_their_phases() {
    let set = Synthetic {
        shapes: SyntheticShapes::Complex,
        ..easy(50.0, 8)
    }
    .build()
    .unwrap();
    let model = fitted(&set.frf, &FitOptions::default());
    for (mode, truth) in model.in_band_modes().zip(set.truth.in_band_modes()) {
        assert!(mac(&mode.shape.0, &truth.shape.0) > 0.999);
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let set = easy(40.0, 12).build().unwrap();
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        serde_json::to_string(&pool.install(|| fitted(&set.frf, &FitOptions::default()))).unwrap()
    };
    assert_eq!(run(1), run(2));
}

#[test]
fn an_order_given_is_kept() {
    let set = easy(40.0, 13).build().unwrap();
    let model = fitted(
        &set.frf,
        &FitOptions {
            modes: Some(5),
            ..Default::default()
        },
    );
    assert_eq!(model.in_band_modes().count(), 5);
}

#[test]
fn classic_methods_find_separate_modes_on_clean_data() {
    for method in [Method::Rfp, Method::Grfp] {
        let set = easy(60.0, 14).build().unwrap();
        let model = fitted(
            &set.frf,
            &FitOptions {
                method,
                ..Default::default()
            },
        );
        let (missed, _) = missed_and_spurious(&set.truth, &model);
        assert_eq!(missed, 0, "{method}");
        assert_eq!(model.method, method.as_str());
    }
}

#[test]
fn what_cannot_be_fitted_says_why() {
    let set = easy(40.0, 1).build().unwrap();
    let error = |options: &FitOptions, frf: &FrfSet| fit(frf, options).unwrap_err();
    let outside = FitOptions {
        band_hz: Some([500.0, 600.0]),
        ..Default::default()
    };
    assert!(matches!(
        error(&outside, &set.frf),
        FitError::BandOutsideData { .. }
    ));
    let narrow = FitOptions {
        band_hz: Some([50.0, 50.5]),
        ..Default::default()
    };
    let few = error(&narrow, &set.frf);
    assert!(matches!(few, FitError::TooFewLines { .. }));
    let words = few.to_string();
    assert!(
        words.contains("lines for 1 mode")
            && !words.contains("1 modes")
            && !words.contains(" 1 lines"),
        "{words}"
    );
    let unknown = FrfSet {
        kind: None,
        ..set.frf.clone()
    };
    assert_eq!(
        error(&FitOptions::default(), &unknown),
        FitError::UnknownKind
    );
    let mut zero = set.frf.clone();
    if let FrfValues::F64(values) = &mut zero.values {
        values.fill(num_complex::Complex64::default());
    }
    assert_eq!(error(&FitOptions::default(), &zero), FitError::NoData);
}
