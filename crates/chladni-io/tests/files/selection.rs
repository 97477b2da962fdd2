//! Selections of modes through the public door; the truth is a model whose parts are
//! known in closed form.

use chladni_frf::{
    ComplexVector, Damping, FrfKind, ModalModel, Mode, Quality, ReferenceUnit, ResidualTerms,
    Scaling, Trust, CREATED_BY, MODEL_FORMAT,
};
use ndarray::Array1;
use num_complex::Complex64;

fn mode(frequency_hz: f64, in_band: bool, trust: Trust) -> Mode {
    let one = |_| ComplexVector(vec![Complex64::new(1.0, 0.0)]);
    Mode {
        frequency_hz,
        frequency_std_hz: 0.0,
        loss_factor: 0.01,
        loss_factor_std: 0.0,
        damping_ratio: 0.005,
        in_band,
        trust,
        reasons: Default::default(),
        mpc: 1.0,
        shape: one(()),
        shape_std: vec![0.0],
        scale_std: None,
        participation: one(()),
    }
}

/// One FRF: three modes that count, one rejected candidate between them, one pole above
/// the band.
fn model() -> ModalModel {
    ModalModel {
        format: MODEL_FORMAT.into(),
        version: 1,
        created_by: CREATED_BY.into(),
        source: Vec::new(),
        options: Default::default(),
        frf_kind: FrfKind::Mobility,
        reference_unit: ReferenceUnit::Newton,
        band_hz: [10.0, 200.0],
        damping: Damping::Structural,
        scaling: Scaling::UnitModalMass,
        responses: vec!["1:+Z".parse().unwrap()],
        references: vec!["1:+Z".parse().unwrap()],
        nodes: Vec::new(),
        lines: Vec::new(),
        faces: Vec::new(),
        method: "auto".into(),
        modes: vec![
            mode(40.0, true, Trust::Sure),
            mode(55.0, true, Trust::Rejected),
            mode(80.0, true, Trust::Weak),
            mode(120.0, true, Trust::Sure),
            mode(230.0, false, Trust::Sure),
        ],
        residual_terms: ResidualTerms {
            omega_scale_rad_per_s: 1.0,
            terms: Vec::new(),
        },
        quality: Quality {
            relative_error: 0.01,
            chi2_per_dof: 1.0,
            trusted: true,
            findings: Vec::new(),
            path: None,
        },
    }
}

fn left(selection: &str) -> Vec<f64> {
    let selected = chladni_io::selection_from_toml(selection)
        .unwrap()
        .apply(&model())
        .unwrap();
    selected
        .model
        .in_band_modes()
        .map(|mode| mode.frequency_hz)
        .collect()
}

#[test]
fn modes_are_kept_or_dropped_by_number_and_by_frequency() {
    assert_eq!(left("keep = [1, 3]"), [40.0, 120.0]);
    assert_eq!(left("drop = [2]"), [40.0, 120.0]);
    assert_eq!(left("[[mode]]\nnear_hz = 81.0\nwithin_hz = 2.0"), [80.0]);
    assert_eq!(
        left("drop = [1]\n[[mode]]\nnear_hz = 119\nwithin_hz = 2"),
        [80.0]
    );
    assert_eq!(
        left("drop = []\n[[mode]]\nnear_hz = 119\nwithin_hz = 2"),
        [40.0, 80.0]
    );
}

#[test]
fn what_is_no_mode_in_the_band_stays() {
    let selected = chladni_io::selection_from_toml("keep = [3]")
        .unwrap()
        .apply(&model())
        .unwrap();
    assert_eq!(selected.dropped, [(1, 40.0), (2, 80.0)]);
    let frequencies: Vec<f64> = selected
        .model
        .modes
        .iter()
        .map(|mode| mode.frequency_hz)
        .collect();
    assert_eq!(frequencies, [55.0, 120.0, 230.0]);
    assert_eq!(
        selected.model.options["selections"][0]["keep"],
        serde_json::json!([3])
    );
    assert_eq!(
        selected.model.options["selections"][0]["dropped"][1]["frequency_hz"],
        80.0
    );
}

#[test]
fn all_sure_modes_are_kept_by_one_word() {
    let selected = chladni_io::selection_from_toml("keep = \"sure\"")
        .unwrap()
        .apply(&model())
        .unwrap();
    let left = selected.model.in_band_modes();
    assert!(left.into_iter().all(|mode| mode.trust == Trust::Sure));
    let weak = model()
        .in_band_modes()
        .filter(|mode| mode.trust == Trust::Weak)
        .count();
    assert_eq!((selected.dropped.len(), weak > 0), (weak, true));
    assert_eq!(
        selected.model.options["selections"][0]["keep"],
        serde_json::json!(["sure"])
    );
    let mut doubtful = model();
    doubtful
        .modes
        .iter_mut()
        .for_each(|mode| mode.trust = Trust::Weak);
    let error = chladni_io::selection_from_toml("keep = \"sure\"")
        .unwrap()
        .apply(&doubtful)
        .unwrap_err();
    assert!(error.to_string().contains("no mode is sure"), "{error}");
}

#[test]
fn a_dropped_mode_counts_as_unexplained() {
    let whole = model();
    let selected = chladni_io::selection_from_toml("drop = [2]")
        .unwrap()
        .apply(&whole)
        .unwrap()
        .model;
    // the slow way: both models on an even grid, 50 lines per bandwidth
    let lines = Array1::range(10.0, 200.0, 0.008);
    let (all, part) = (whole.synthesise(&lines), selected.synthesise(&lines));
    let square = |v: &ndarray::Array3<Complex64>| v.iter().map(|x| x.norm_sqr()).sum::<f64>();
    let expected = (1e-4 + (1.0 - 1e-4) * square(&(&all - &part)) / square(&all)).sqrt();
    assert!(
        (selected.quality.relative_error / expected - 1.0).abs() < 0.02,
        "{} {expected}",
        selected.quality.relative_error
    );
    assert!((selected.quality.chi2_per_dof / (expected / 0.01).powi(2) - 1.0).abs() < 0.04);
    assert!(selected.quality.trusted && selected.quality.findings[0].contains("dropped by hand"));
    // nothing dropped, nothing said
    assert_eq!(
        chladni_io::selection_from_toml("keep = [1, 2, 3]")
            .unwrap()
            .apply(&whole)
            .unwrap()
            .model
            .quality,
        whole.quality
    );
    let weak_only = chladni_io::selection_from_toml("keep = [2]")
        .unwrap()
        .apply(&whole)
        .unwrap()
        .model;
    assert!(!weak_only.quality.trusted);
}

#[test]
fn a_repeated_pole_goes_whole_and_several_modes_are_never_guessed() {
    let mut twice = model();
    twice.modes.insert(2, mode(80.0, true, Trust::Sure));
    let near_80 = "drop = []\n[[mode]]\nnear_hz = 80\nwithin_hz = 1";
    assert_eq!(
        chladni_io::selection_from_toml(near_80)
            .unwrap()
            .apply(&twice)
            .unwrap()
            .dropped
            .len(),
        2
    );
    let wide = chladni_io::selection_from_toml("[[mode]]\nnear_hz = 60\nwithin_hz = 30")
        .unwrap()
        .apply(&model())
        .unwrap_err();
    assert!(
        wide.to_string()
            .contains("mode 1 at 40.000 Hz, mode 2 at 80.000 Hz"),
        "{wide}"
    );
}

#[test]
fn wrong_selections_say_line_and_key() {
    let message = |selection: &str| match chladni_io::selection_from_toml(selection) {
        Err(error) => error.to_string(),
        Ok(selection) => selection.apply(&model()).unwrap_err().to_string(),
    };
    for (selection, words) in [
        (
            "keep = [1, 4]",
            &[
                "line 1",
                "keep[2]",
                "found 4",
                "1 to 3",
                "mode 3 at 120.000 Hz",
            ][..],
        ),
        (
            "\n[[mode]]\nnear_hz = 70\nwithin_hz = 1",
            &["line 2", "mode[1]", "mode 2 at 80.000 Hz", "10.000 Hz away"],
        ),
        ("kept = [1]", &["line 1", "kept", "did you mean `keep`"]),
        ("[[mode]]\nnear = 3", &["line 2", "near", "near_hz"]),
        (
            "keep = [1]\ndrop = [2]",
            &["line 2", "either keeps or drops"],
        ),
        ("near_hz = 3", &["belongs under [[mode]]"]),
        ("frequency_hz = 3", &["belongs under [[add]]"]),
        ("[add]\nfrequency_hz = 3", &["write [[add]]"]),
        ("drop = []", &["names no mode"]),
        ("", &["names no mode"]),
        ("keep = [0]", &["keep[1]", "found 0"]),
        ("keep = 3", &["keep", "a list"]),
        ("keep = \"all\"", &["line 1", "keep", "sure"]),
        ("mode = 3", &["mode", "a list"]),
        ("[[mode]]\nnear_hz = 40.0", &["within_hz", "missing"]),
    ] {
        let message = message(selection);
        for word in words {
            assert!(
                message.contains(word),
                "{selection:?}: no {word:?} in {message}"
            );
        }
    }
}

#[test]
fn what_came_of_an_added_mode_lies_near_it() {
    let mut model = model();
    let places = [(100.0, 0.1), (1000.0, 1e-4)];
    model.modes.truncate(2);
    for (mode, (hz, loss_factor)) in model.modes.iter_mut().zip(places) {
        (mode.frequency_hz, mode.loss_factor, mode.in_band) = (hz, loss_factor, true);
    }
    model.modes[1].trust = Trust::Rejected;
    let seen = |hz: f64| model.mode_seen_at(hz).map(|mode| mode.frequency_hz);
    // four half-bandwidths, or half a per cent
    for (hz, of) in [
        (81.0, Some(100.0)),
        (121.0, None),
        (1004.0, Some(1000.0)),
        (950.0, None),
    ] {
        assert_eq!(seen(hz), of, "{hz}");
    }
}
