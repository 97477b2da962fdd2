//! Faults that the data cannot show, and options that speak against the data: said, not
//! kept silent.

use super::*;
use chladni_frf::Damping;

#[test]
fn one_moving_mode_that_looks_like_several_is_weak_and_a_true_pair_is_sure() {
    // one reference; each response was measured with its own pole, a twentieth of a
    // bandwidth around the mean
    let spec = Synthetic {
        natural_frequency_hz: vec![60.0, 120.0],
        loss_factor: vec![0.01],
        references: 1,
        ..easy(40.0, 3)
    };
    let set = spec.build().unwrap();
    let mut moved = set.frf.clone();
    for (i, part) in [0.9, -0.7, 0.2, -1.0, 0.6, -0.3].iter().enumerate() {
        let mut truth = set.truth.clone();
        truth
            .modes
            .iter_mut()
            .for_each(|mode| mode.frequency_hz *= 1.0 + 0.0005 * part);
        let own = truth.synthesise(&set.frf.frequency_hz);
        values(&mut moved)
            .slice_mut(ndarray::s![i, .., ..])
            .assign(&own.slice(ndarray::s![i, .., ..]));
    }
    chladni_plate::add_noise_of_variance(values(&mut moved), set.noise_variance, 28);
    let model = fitted(&moved);
    let (missed, _, sure) = missed_spurious_false(&set.truth, &model);
    assert_eq!((missed, sure), (0, 0), "{:?}", model.quality);
    let near = |f: f64| {
        model
            .in_band_modes()
            .filter(|mode| (mode.frequency_hz - f).abs() < 1.0)
            .collect::<Vec<_>>()
    };
    let several = [60.0, 120.0]
        .map(near)
        .into_iter()
        .filter(|modes| modes.len() > 1)
        .collect::<Vec<_>>();
    assert!(!several.is_empty(), "the set is too easy: one mode each");
    for mode in several.into_iter().flatten() {
        assert!(
            mode.trust == Trust::Weak
                && mode
                    .reasons
                    .iter()
                    .any(|why| why.contains("moves between FRFs")),
            "{mode:?}"
        );
    }
    assert!(says(&model, "frequencies differ between measurements"));

    let pair = Synthetic {
        natural_frequency_hz: vec![60.0, 60.4],
        ..spec
    }
    .build()
    .unwrap();
    let model = fitted(&pair.frf);
    assert_eq!(
        missed_spurious_false(&pair.truth, &model),
        (0, 0, 0),
        "{:?}",
        model.quality
    );
    assert!(
        model.in_band_modes().all(|mode| mode.trust == Trust::Sure),
        "{:?}",
        model.quality
    );
}

#[test]
fn a_damping_law_that_the_data_contradict_is_obeyed_and_named() {
    for (law, asked) in [
        (Damping::Structural, Damping::Viscous),
        (Damping::Viscous, Damping::Structural),
    ] {
        let spec = Synthetic {
            damping: law,
            loss_factor: vec![0.1],
            natural_frequency_hz: vec![40.0, 70.0, 110.0, 160.0],
            ..easy(80.0, 4)
        };
        let set = spec.build().unwrap();
        let model = fitted_with(
            &set.frf,
            &FitOptions {
                damping: Some(asked),
                ..FitOptions::default()
            },
        );
        assert_eq!(model.damping, asked);
        assert!(
            says(&model, "the data contradict the"),
            "{asked:?}: {:?}",
            model.quality
        );
        let right = fitted_with(
            &set.frf,
            &FitOptions {
                damping: Some(law),
                ..FitOptions::default()
            },
        );
        assert!(!says(&right, "contradict"), "{law:?}: {:?}", right.quality);
    }
}

#[test]
fn fewer_modes_asked_for_than_there_are_is_said() {
    let set = easy(40.0, 5).build().unwrap();
    let model = fitted_with(
        &set.frf,
        &FitOptions {
            modes: Some(7),
            ..FitOptions::default()
        },
    );
    assert!(
        says(&model, "7 modes were asked for and the data show more"),
        "{:?}",
        model.quality
    );
    let model = fitted_with(
        &set.frf,
        &FitOptions {
            modes: Some(8),
            ..FitOptions::default()
        },
    );
    assert!(!says(&model, "asked for"), "{:?}", model.quality);
}

#[test]
fn one_frf_says_that_it_does_not_show_all() {
    let set = Synthetic {
        responses: 1,
        references: 1,
        ..easy(60.0, 6)
    }
    .build()
    .unwrap();
    assert!(says(&fitted(&set.frf), "one FRF: a mode with a node"));
    assert!(!says(
        &fitted(&easy(60.0, 6).build().unwrap().frf),
        "one FRF"
    ));
}

#[test]
fn a_gap_in_which_a_mode_could_hide_is_named_and_one_in_which_it_could_not_is_not() {
    // overlap 1: what 20 dB leave open, 80 dB close
    let at = |snr_db: f64| {
        let spec = Synthetic {
            natural_frequency_hz: vec![60.0, 80.0, 100.0, 120.0],
            loss_factor: vec![0.2],
            references: 1,
            ..easy(snr_db, 7)
        };
        fitted_with(
            &spec.build().unwrap().frf,
            &FitOptions {
                damping: Some(Damping::Structural),
                ..FitOptions::default()
            },
        )
    };
    assert!(
        says(&at(20.0), "could hide in this noise"),
        "{:?}",
        at(20.0).quality
    );
    assert!(!says(&at(80.0), "could hide"), "{:?}", at(80.0).quality);
    // and separate modes hide nothing
    assert!(!says(
        &fitted(&easy(20.0, 8).build().unwrap().frf),
        "could hide"
    ));
}
