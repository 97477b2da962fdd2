//! Lines: missing, wrong, of another scale.

use super::*;
use chladni_plate::{gain_noise, outliers};
use chladni_rfp::FitError;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Eight of eight, none invented, none in doubt.
fn clean(truth: &ModalModel, model: &ModalModel, what: &str) {
    assert_eq!(
        missed_spurious_false(truth, model),
        (0, 0, 0),
        "{what}: {:?}",
        model.quality
    );
    assert!(model.quality.trusted, "{what}: {:?}", model.quality);
}

#[test]
fn scale_does_not_matter() {
    for factor in [1e-150, 1e-9, 1e9] {
        let mut set = easy(40.0, 1).build().unwrap();
        spoil(&mut set.frf, |_, _, _, v| v * factor);
        clean(&set.truth, &fitted(&set.frf), &format!("scale {factor:e}"));
    }
    for factor in [1e-158, 1e150] {
        let mut set = easy(40.0, 1).build().unwrap();
        spoil(&mut set.frf, |_, _, _, v| v * factor);
        let error = fit(&set.frf, &FitOptions::default()).unwrap_err();
        assert!(
            matches!(error, FitError::Scale { .. }),
            "{factor:e}: {error}"
        );
    }
}

#[test]
fn a_band_of_a_few_millihertz_is_refused() {
    let mut set = easy(40.0, 1).build().unwrap();
    set.frf.frequency_hz.mapv_inplace(|hz| 1000.0 + 1e-5 * hz);
    let error = fit(&set.frf, &FitOptions::default()).unwrap_err();
    assert!(matches!(error, FitError::NarrowBand { .. }), "{error}");
}

/// A response that no FRF tells may be anything; the others are as they are.
#[test]
fn a_response_that_was_never_measured_has_the_widest_bar() {
    let mut set = easy(40.0, 1).build().unwrap();
    spoil(&mut set.frf, |i, _, _, v| match i {
        3 => Complex64::new(f64::NAN, f64::NAN),
        _ => v,
    });
    let model = fitted(&set.frf);
    clean(&set.truth, &model, "a response without FRF");
    for mode in model.in_band_modes() {
        let largest = mode.shape.0.iter().map(|v| v.norm()).fold(0.0, f64::max);
        assert_eq!(mode.shape_std[3], largest);
        assert!(mode.shape_std[4] < 0.1 * largest);
    }
}

#[test]
fn what_is_missing_is_left_out() {
    type Spoil = fn(usize, usize, f64, Complex64) -> Complex64;
    let rows: [(&str, Spoil); 5] = [
        ("NaN lines", |_, _, f, v| {
            if (f * 10.0).round() as i64 % 97 == 0 {
                Complex64::new(f64::NAN, f64::NAN)
            } else {
                v
            }
        }),
        ("zero FRFs", |i, j, _, v| {
            if (i, j) == (2, 1) || (i, j) == (4, 0) {
                Complex64::default()
            } else {
                v
            }
        }),
        ("NaN below 60 Hz", |_, _, f, v| {
            if f < 60.0 {
                Complex64::new(f64::NAN, f64::NAN)
            } else {
                v
            }
        }),
        ("zeros below 60 Hz", |_, _, f, v| {
            if f < 60.0 {
                Complex64::default()
            } else {
                v
            }
        }),
        (
            "a reversed sensor",
            |i, _, _, v| if i == 3 { -v } else { v },
        ),
    ];
    for (what, change) in rows {
        let mut set = easy(40.0, 2).build().unwrap();
        spoil(&mut set.frf, change);
        let mut truth = set.truth.clone();
        if what.contains("below 60 Hz") {
            truth.modes.retain(|mode| mode.frequency_hz > 60.0);
        }
        clean(&truth, &fitted(&set.frf), what);
    }
}

#[test]
fn garbage_at_0_hz_and_random_lines_do_no_harm() {
    let axis = Array1::range(0.0, 240.0, 0.1);
    let mut set = Synthetic {
        frequency_hz: axis,
        ..easy(40.0, 3)
    }
    .build()
    .unwrap();
    spoil(&mut set.frf, |_, _, f, v| {
        if f == 0.0 {
            Complex64::new(1e12, -1e12)
        } else {
            v
        }
    });
    clean(&set.truth, &fitted(&set.frf), "garbage at 0 Hz");

    let mut random = ChaCha8Rng::seed_from_u64(4);
    let some: Array1<f64> = easy(40.0, 3)
        .frequency_hz
        .into_iter()
        .filter(|_| random.random::<f64>() < 0.44)
        .collect();
    let set = Synthetic {
        frequency_hz: some,
        ..easy(40.0, 3)
    }
    .build()
    .unwrap();
    clean(&set.truth, &fitted(&set.frf), "44 % of the lines");
}

#[test]
fn one_frf_alone_shows_every_mode_that_it_can_show() {
    for seed in 0..4 {
        let mut set = Synthetic {
            responses: 1,
            references: 1,
            ..easy(40.0, seed)
        }
        .build()
        .unwrap();
        let bound = chladni_plate::cramer_rao(
            &set.truth,
            &set.frf.frequency_hz,
            set.noise_variance,
            &[-2, 0, 2, 4],
        )
        .unwrap();
        // near a node the bound itself exceeds a tenth of a bandwidth: nobody can find it
        let mut bounds = bound.frequency_std_hz.iter();
        set.truth
            .modes
            .retain(|mode| bounds.next().unwrap() < &(0.1 * mode.loss_factor * mode.frequency_hz));
        let model = fitted(&set.frf);
        let (missed, _, false_sure) = missed_spurious_false(&set.truth, &model);
        assert_eq!(
            (missed, false_sure),
            (0, 0),
            "seed {seed}: {:?}",
            model.quality
        );
    }
}

#[test]
fn a_noisy_frf_does_not_drag_the_others_down() {
    let mut set = easy(60.0, 6).build().unwrap();
    let quiet = worst_frequency(&set.truth, &fitted(&set.frf));
    let mut noise = set.frf.clone();
    values(&mut noise).fill(Complex64::default());
    chladni_plate::add_noise_of_variance(values(&mut noise), 400.0 * set.noise_variance, 77);
    let noise = values(&mut noise).clone();
    let axis = set.frf.frequency_hz.clone();
    spoil(&mut set.frf, |i, j, f, v| {
        let k = axis.iter().position(|a| *a == f).unwrap();
        if (i, j) == (1, 0) {
            v + noise[[i, j, k]]
        } else {
            v
        }
    });
    let model = fitted(&set.frf);
    clean(&set.truth, &model, "one FRF 20 times noisier");
    assert!(says(
        &model,
        "far noisier than the other FRFs and left out, their values follow from \
                          the shapes: 2:+Z from 1:+Z"
    ));
    // eleven of twelve FRFs are as good as before
    assert!(
        worst_frequency(&set.truth, &model) < 2.0 * quiet,
        "{} {quiet}",
        worst_frequency(&set.truth, &model)
    );
}

#[test]
fn outlier_lines_are_found_and_left_out() {
    for factor in [3.0, 30.0] {
        let mut set = easy(40.0, 7).build().unwrap();
        let without = worst_frequency(&set.truth, &fitted(&set.frf));
        let mut random = ChaCha8Rng::seed_from_u64(8);
        let wrong: Vec<f64> = set
            .frf
            .frequency_hz
            .iter()
            .copied()
            .filter(|_| random.random::<f64>() < 0.01)
            .collect();
        spoil(&mut set.frf, |_, _, f, v| {
            if wrong.contains(&f) {
                factor * v
            } else {
                v
            }
        });
        let model = fitted(&set.frf);
        clean(
            &set.truth,
            &model,
            &format!("{} lines times {factor}", wrong.len()),
        );
        assert!(
            says(&model, "outlier lines"),
            "{:?}",
            model.quality.findings
        );
        let worst = worst_frequency(&set.truth, &model);
        assert!(
            worst < 2.0 * without,
            "times {factor}: {worst} instead of {without}"
        );
    }
}

#[test]
fn spikes_in_single_frfs_are_found_too() {
    let mut set = easy(40.0, 9).build().unwrap();
    let without = worst_frequency(&set.truth, &fitted(&set.frf));
    outliers(&mut set.frf, 0.003, 30.0, 10);
    let model = fitted(&set.frf);
    clean(&set.truth, &model, "spikes in single FRFs");
    assert!(worst_frequency(&set.truth, &model) < 2.0 * without);
}

#[test]
fn narrow_resonances_are_no_outliers() {
    // half a line per bandwidth at the lowest mode
    let set = Synthetic {
        loss_factor: vec![0.0016],
        ..easy(40.0, 11)
    }
    .build()
    .unwrap();
    let model = fitted(&set.frf);
    assert!(!says(&model, "outlier"), "{:?}", model.quality.findings);
    assert_eq!(
        missed_spurious_false(&set.truth, &model),
        (0, 0, 0),
        "{:?}",
        model.quality
    );
}

#[test]
fn gain_noise_adds_no_mode() {
    for common in [false, true] {
        for fraction in [0.005, 0.02, 0.05] {
            let mut set = easy(40.0, 12).build().unwrap();
            gain_noise(&mut set.frf, fraction, common, 13);
            let model = fitted(&set.frf);
            let what = format!("{:.1} % gain noise, common {common}", 100.0 * fraction);
            let (missed, spurious, false_sure) = missed_spurious_false(&set.truth, &model);
            assert_eq!((missed, false_sure), (0, 0), "{what}: {:?}", model.quality);
            assert!(spurious <= 1, "{what}: {spurious} spurious");
            assert!(model.quality.trusted, "{what}: {:?}", model.quality);
        }
    }
}

#[test]
fn nothing_but_missing_values_is_an_error() {
    let mut set = easy(40.0, 14).build().unwrap();
    spoil(&mut set.frf, |_, _, _, _| {
        Complex64::new(f64::NAN, f64::NAN)
    });
    assert_eq!(
        fit(&set.frf, &FitOptions::default()).unwrap_err(),
        FitError::NoData
    );
}
