//! NumPy archives: of others, and our own read back.

use super::npz::Npz;
use super::sets::{set, value};
use chladni_frf::{FrfSet, FrfValues};
use chladni_io::{assemble, read_document, write_frf, PhaseUnit, ReadOptions};
use ndarray::Array3;
use num_complex::{Complex32, Complex64};
use proptest::prelude::*;

fn through_npz(set: &FrfSet) -> FrfSet {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("set.npz");
    write_frf(&path, set, false).unwrap();
    let document = read_document(&path, &ReadOptions::default()).unwrap();
    assert_eq!(document.errors, []);
    assemble(vec![document], &ReadOptions::default())
        .unwrap()
        .frf
        .unwrap()
}

#[test]
fn single_precision_coherence_and_dofs_survive_numpy() {
    let single = set(FrfValues::F32(Array3::from_shape_fn(
        (2, 3, 5),
        |(i, j, k)| Complex32::new(0.1 * (i + j) as f32, k as f32),
    )));
    assert_eq!(through_npz(&single), single);
}

#[test]
fn our_own_archives_read_back_whatever_their_shape() {
    for shape in [
        (3, 2, 1),
        (1, 1, 1),
        (3, 1, 3),
        (2, 3, 2),
        (4, 4, 4),
        (1, 5, 5),
    ] {
        let values = Array3::from_shape_fn(shape, |(i, j, k)| value(i, j, k) + 1.0);
        let set = set(FrfValues::F64(values));
        assert_eq!(through_npz(&set), set, "{shape:?}");
    }
}

#[test]
fn lists_of_dofs_say_which_axis_is_which() {
    let values: Vec<Complex64> = (0..2)
        .flat_map(|j| (0..3).flat_map(move |i| (0..5).map(move |k| value(i, j, k))))
        .collect();
    let npz = Npz(Vec::new())
        .complex("frf", &[2, 3, 5], &values)
        .reals("freq", &[1.0, 2.0, 3.0, 4.0, 5.0])
        .texts("response", &["1:+Z", "2:+Z", "3:+Z"])
        .texts("reference", &["11:+Z", "12:+Z"]);
    let (set, warnings) = npz.read(&ReadOptions::default()).unwrap();
    assert_eq!(set.values.dim(), (3, 2, 5));
    assert_eq!(set.values.get(2, 1, 4), value(2, 1, 4));
    assert_eq!(set.references[1].to_string(), "12:+Z");
    assert!(
        !warnings.join("\n").contains("in the order"),
        "{warnings:?}"
    );

    let nameless = Npz(Vec::new())
        .complex("frf", &[2, 3, 5], &values)
        .reals("freq", &[1.0, 2.0, 3.0, 4.0, 5.0]);
    let (_, warnings) = nameless.read(&ReadOptions::default()).unwrap();
    let text = warnings.join("\n");
    assert!(text.contains("in the order response, reference"), "{text}");

    let wrong = Npz(Vec::new())
        .complex("frf", &[2, 3, 5], &values)
        .reals("freq", &[1.0, 2.0, 3.0, 4.0, 5.0])
        .texts("response", &["1:+Z", "2:+Z", "3:+Z", "4:+Z"]);
    let error = wrong.read(&ReadOptions::default()).unwrap_err().to_string();
    assert!(
        error.contains("4 response DOFs") && error.contains("[2, 3, 5]"),
        "{error}"
    );

    let named = Npz(Vec::new())
        .complex("frf", &[2, 2, 2], &values[..8])
        .reals("freq", &[1.0, 2.0])
        .texts("axes", &["line-reference-response"]);
    let (set, _) = named.read(&ReadOptions::default()).unwrap();
    assert_eq!(set.values.get(1, 0, 0), values[1]);
}

#[test]
fn infinities_are_errors_and_masked_where_asked() {
    let mut values = vec![Complex64::new(1.0, 2.0); 4];
    values[2].im = f64::INFINITY;
    let npz = Npz(Vec::new())
        .complex("frf", &[4], &values)
        .reals("freq", &[1.0, 2.0, 3.0, 4.0]);
    let error = npz.read(&ReadOptions::default()).unwrap_err().to_string();
    for words in ["/frf", "inf", "line 3", "`lenient`"] {
        assert!(error.contains(words), "{words}: {error}");
    }
    let lenient = ReadOptions {
        lenient: true,
        ..ReadOptions::default()
    };
    let (set, warnings) = npz.read(&lenient).unwrap();
    assert!(set.values.get(0, 0, 2).re.is_nan());
    assert!(warnings.join("\n").contains("masked"), "{warnings:?}");
}

#[test]
fn magnitudes_and_phases_say_their_unit_or_are_asked_for() {
    let polar = |phase: &str, phases: &[f64]| {
        Npz(Vec::new())
            .reals("mag", &[1.0, 2.0])
            .reals(phase, phases)
            .reals("freq", &[1.0, 2.0])
    };
    let degrees = polar("phase", &[0.0, 90.0]).read(&ReadOptions::default());
    assert!((degrees.unwrap().0.values.get(0, 0, 1).im - 2.0).abs() < 1e-12);
    let quarter = std::f64::consts::FRAC_PI_2;
    let radians = polar("phase_rad", &[0.0, quarter]).read(&ReadOptions::default());
    assert!((radians.unwrap().0.values.get(0, 0, 1).im - 2.0).abs() < 1e-12);
    let unsaid = polar("phase", &[0.0, quarter]);
    let error = unsaid
        .read(&ReadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("/phase") && error.contains("`phase_unit rad`"),
        "{error}"
    );
    let told = ReadOptions {
        phase_unit: Some(PhaseUnit::Radian),
        ..ReadOptions::default()
    };
    assert!((unsaid.read(&told).unwrap().0.values.get(0, 0, 1).im - 2.0).abs() < 1e-12);
    for name in ["mag_db", "mag"] {
        let decibels = Npz(Vec::new())
            .reals(name, &[-60.0, -40.0])
            .reals("phase", &[0.0, 90.0])
            .reals("freq", &[1.0, 2.0]);
        let error = decibels
            .read(&ReadOptions::default())
            .unwrap_err()
            .to_string();
        assert!(error.contains("dB"), "{error}");
    }
    let complex = Npz(Vec::new())
        .complex("frf", &[2], &[Complex64::new(1.0, 2.0); 2])
        .reals("freq", &[1.0, 2.0])
        .texts("unit", &["dB"]);
    let error = complex
        .read(&ReadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(error.contains("dB") && error.contains("/frf"), "{error}");
}

#[test]
fn frequencies_may_be_complex_and_stand_beside_the_frfs() {
    let frequencies = [1.0, 2.0, 3.0].map(Complex64::from);
    let frf = [value(0, 0, 1), value(0, 0, 2), value(0, 0, 3)];
    let apart = Npz(Vec::new())
        .complex("freq", &[3], &frequencies)
        .complex("H", &[3], &frf);
    let joined: Vec<Complex64> = frequencies
        .iter()
        .zip(&frf)
        .flat_map(|(f, h)| [*f, *h])
        .collect();
    let joined = Npz(Vec::new()).complex("FRF", &[3, 2], &joined);
    for npz in [apart, joined] {
        let (set, warnings) = npz.read(&ReadOptions::default()).unwrap();
        assert_eq!(set.frequency_hz.to_vec(), [1.0, 2.0, 3.0]);
        assert_eq!(set.values.frf(0, 0).to_vec(), frf);
        assert!(warnings.join("\n").contains("`map"), "{warnings:?}");
    }
}

#[test]
fn arrays_of_other_types_are_named_and_block_nothing() {
    let frf = || {
        Npz(Vec::new())
            .complex("frf", &[2], &[value(0, 0, 1), value(0, 0, 2)])
            .reals("freq", &[1.0, 2.0])
    };
    let meta = frf()
        .add("meta", "|O", &[], vec![1; 30])
        .add("saved", "<M8[ns]", &[1], vec![0; 8])
        .add("weights", "<f2", &[2], vec![0; 4]);
    let (set, warnings) = meta.read(&ReadOptions::default()).unwrap();
    assert_eq!(set.values.dim(), (1, 1, 2));
    let said = warnings.join("\n");
    for words in ["/meta: pickled objects", "/saved: dates", "/weights: f2"] {
        assert!(said.contains(words), "{words}: {said}");
    }
    // needed, or all there is
    let nodes = frf().add("response", "|O", &[1], vec![1; 30]);
    let half = Npz(Vec::new())
        .add("frf", "<c32", &[2], vec![0; 64])
        .reals("freq", &[1.0, 2.0]);
    for (npz, field) in [(nodes, "/response"), (half, "/frf")] {
        let error = npz.read(&ReadOptions::default()).unwrap_err().to_string();
        for words in [field, "a type that cannot be read", "(float64, complex128)"] {
            assert!(error.contains(words), "{words}: {error}");
        }
    }
}

#[test]
fn arrays_without_values_are_refused() {
    for (shape, found) in [([2, 1, 0], "0 lines"), ([0, 1, 2], "0 responses")] {
        let axis: Vec<f64> = (0..shape[2]).map(|k| k as f64).collect();
        let npz = Npz(Vec::new())
            .complex("frf", &shape, &[])
            .reals("freq", &axis);
        let error = npz.read(&ReadOptions::default()).unwrap_err().to_string();
        assert!(error.contains(&format!("found {found}")), "{error}");
    }
    // two axes, none of which is the frequencies
    for shape in [[3, 0], [0, 3]] {
        let npz = Npz(Vec::new()).complex("frf", &shape, &[]);
        let npz = npz.reals("freq", &[1.0, 2.0]);
        let error = npz.read(&ReadOptions::default()).unwrap_err().to_string();
        assert!(error.contains("no FRF in the input"), "{error}");
    }
}

#[test]
fn the_phase_unit_of_the_caller_overrules_that_of_the_file_aloud() {
    let told = ReadOptions {
        phase_unit: Some(PhaseUnit::Radian),
        ..ReadOptions::default()
    };
    let polar = |phase: &str| {
        Npz(Vec::new())
            .reals("mag", &[1.0, 2.0])
            .reals(phase, &[0.0, 1.0])
            .reals("freq", &[1.0, 2.0])
    };
    let by_fact = polar("phase").texts("phase_unit", &["deg"]);
    for (npz, place) in [(by_fact, "/phase_unit"), (polar("phase_deg"), "/phase_deg")] {
        let (_, warnings) = npz.read(&told).unwrap();
        let words = format!("{place} says deg, you say rad");
        assert!(warnings.join("\n").contains(&words), "{warnings:?}");
    }
    let (_, warnings) = polar("phase_rad").read(&told).unwrap();
    assert!(!warnings.join("\n").contains("you say"), "{warnings:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_double_survives_numpy(values in prop::collection::vec(any::<f64>().prop_filter("finite", |v| v.is_finite()), 24)) {
        let values = Array3::from_shape_fn((2, 1, 6), |(i, _, k)| Complex64::new(values[12 * i + k], values[12 * i + 6 + k]));
        let set = set(FrfValues::F64(values));
        prop_assert_eq!(through_npz(&set), set);
    }
}
