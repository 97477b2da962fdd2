//! Facts that arrays state in texts beside them: units, kind, axes, node numbers.

use super::npz::Npz;
use super::sets::value;
use chladni_frf::{ErrorKind, FrfKind, FrfSet, ReferenceUnit, TimeSign};
use chladni_io::ReadOptions;
use num_complex::Complex64;
use std::f64::consts::TAU;

const HZ: [f64; 5] = [1.0, 2.0, 3.0, 4.0, 5.0];

/// Values of `responses` and two references, the references first.
fn references_first(responses: usize) -> Vec<Complex64> {
    let of = |j| (0..responses).flat_map(move |i| (0..5).map(move |k| value(i, j, k)));
    (0..2).flat_map(of).collect()
}

/// One FRF over `axis`, which goes by `name`.
fn over(name: &str, axis: &[f64]) -> Npz {
    let values: Vec<Complex64> = (0..axis.len()).map(|k| value(0, 0, k)).collect();
    (Npz(Vec::new()).complex("frf", &[1, 1, axis.len()], &values)).reals(name, axis)
}

fn read(npz: &Npz) -> FrfSet {
    npz.read(&ReadOptions::default()).unwrap().0
}

#[track_caller]
fn refused(npz: &Npz, words: &[&str]) {
    let error = npz.read(&ReadOptions::default()).unwrap_err();
    assert_eq!(error.kind, ErrorKind::BadData);
    let error = error.to_string();
    words
        .iter()
        .for_each(|words| assert!(error.contains(words), "{words}: {error}"));
}

#[test]
fn frequencies_have_the_unit_that_is_said() {
    for (axis, key, unit, per_hz) in [
        ("freq", "frequency_unit", "rad/s", TAU),
        ("freq", "Freq_Units", "RAD/S", TAU),
        ("x", "x_unit", "rpm", 60.0),
        ("f", "f_unit", "kHz", 1e-3),
        ("freq", "x_unit", "kHz", 1e-3),
        ("freq", "f_unit", "rad/s", TAU),
        ("omega", "omega_unit", "rad/s", TAU),
        ("omega", "frequency_unit", "Hz", 1.0),
        ("f_Hz", "unit", "m/s/N", 1.0),
        ("omega_rad_s", "unit", "m/s/N", TAU),
        // one unit, rounded
        ("freq_rpm", "frequency_unit", "1/min", 60.0),
        // of positions, forces and something else
        ("freq", "x_unit", "m", 1.0),
        ("freq", "f_unit", "N", 1.0),
        ("freq", "y_unit", "mm/N", 1.0),
    ] {
        let set = read(&over(axis, &HZ.map(|f| f * per_hz)).texts(key, &[unit]));
        for (found, f) in set.frequency_hz.iter().zip(HZ) {
            assert!((found / f - 1.0).abs() < 1e-12, "{axis} {key}: {found}");
        }
    }
    let both = over("freq", &HZ.map(|f| 1e-3 * f)).texts("x_unit", &["m"]);
    let found = read(&both.texts("f_unit", &["kHz"])).frequency_hz;
    assert!((found[0] / HZ[0] - 1.0).abs() < 1e-12, "{found}");
    refused(
        &over("freq", &HZ).texts("frequency_unit", &["V"]),
        &["/frequency_unit", "found V", "rad/s"],
    );
    refused(
        &over("freq_hz", &HZ).texts("frequency_unit", &["rad/s"]),
        &["/freq_hz", "two units of the frequency", "`rad/s`"],
    );
}

#[test]
fn an_angular_frequency_without_a_unit_is_never_hertz() {
    let words = &["/w", "unit of the frequency axis", "frequency_unit"];
    refused(&over("w", &HZ), words);
    let map = vec![("freq".to_owned(), "/w".to_owned())];
    let mapped = ReadOptions {
        map,
        ..ReadOptions::default()
    };
    let error = over("w", &HZ).read(&mapped).unwrap_err().to_string();
    assert!(words.iter().all(|words| error.contains(words)), "{error}");
}

#[test]
fn an_axis_out_of_order_or_without_a_name_says_so() {
    refused(
        &over("freq", &[3.0, 2.0, 1.0]),
        &["/freq", "the frequency axis falls", "2 after 3"],
    );
    refused(
        &over("freq", &[1.0, 2.0, 2.0]),
        &["/freq", "a frequency occurs twice", "2 after 2"],
    );
    // another axis that rises is the right one
    let two = over("freq", &HZ).reals("x", &[5.0, 4.0, 3.0, 2.0, 1.0]);
    assert_eq!(read(&two).frequency_hz.to_vec(), HZ);
    let nameless = over("abscissa", &HZ).document(&ReadOptions::default());
    let text = crate::words(&nameless.warnings).join("\n");
    assert!(
        text.contains("/abscissa") && text.contains("`map frf=PATH,freq=PATH`"),
        "{text}"
    );
    // positions are not blamed where another list may be the axis
    let document = over("abscissa", &HZ)
        .reals("x", &[0.1, 0.1, 0.2, 0.2, 0.3])
        .document(&ReadOptions::default());
    let text = crate::words(&document.warnings).join("\n");
    assert!(
        document.errors.is_empty() && text.contains("/abscissa"),
        "{text}"
    );
    let beside = over("freq", &[3.0, 2.0, 1.0]).reals("response", &[1.0, 2.0, 3.0]);
    refused(&beside, &["/freq", "the frequency axis falls"]);
    refused(
        &over("freq", &[3.0, 2.0, 1.0]).reals("z", &[1.0, 2.0, 3.0]),
        &["/freq", "the frequency axis falls"],
    );
    let stem = Npz(Vec::new())
        .reals("H_re", &[1.0, 2.0])
        .reals("H_im", &[3.0, 4.0])
        .reals("freq", &[1.0, 2.0]);
    assert_eq!(read(&stem).values.get(0, 0, 1), Complex64::new(2.0, 4.0));
}

#[test]
fn kind_and_unit_that_contradict_each_other_are_refused() {
    let npz = over("freq", &HZ)
        .texts("unit", &["mm/N"])
        .texts("frf_kind", &["mobility"]);
    refused(&npz, &["frf_kind", "mobility with unit mm/N", "receptance"]);
    let told = ReadOptions {
        frf_kind: Some(FrfKind::Receptance),
        ..ReadOptions::default()
    };
    assert_eq!(npz.read(&told).unwrap().0.kind, Some(FrfKind::Receptance));
    let npz = over("freq", &HZ)
        .texts("unit", &["m/N"])
        .texts("reference_unit", &["V"]);
    refused(&npz, &["reference_unit", "V with unit m/N"]);
}

#[test]
fn words_in_any_case_are_understood_and_others_refused() {
    let npz = over("freq", &HZ)
        .texts("FRF_kind", &["Mobility"])
        .texts("reference_unit", &["v"])
        .texts("time_sign", &["-"]);
    let set = read(&npz);
    assert_eq!(
        (set.kind, set.reference_unit),
        (Some(FrfKind::Mobility), ReferenceUnit::Volt)
    );
    assert_eq!(set.values.get(0, 0, 1), value(0, 0, 1).conj());
    for (key, word) in [
        ("time_sign", "negative"),
        ("reference_unit", "lbf"),
        ("frf_kind", "impedance"),
    ] {
        refused(&over("freq", &HZ).texts(key, &[word]), &[key, word]);
    }
    let number = over("freq", &HZ).reals("time_sign", &[-1.0]);
    assert_eq!(read(&number).values.get(0, 0, 1), value(0, 0, 1).conj());
    for (word, is_minus) in [("Minus", true), ("plus", false), ("+1", false)] {
        let set = read(&over("freq", &HZ).texts("time_sign", &[word]));
        assert_eq!(set.values.get(0, 0, 1) == value(0, 0, 1).conj(), is_minus);
    }
    let told = ReadOptions {
        time_sign: TimeSign::Minus,
        ..ReadOptions::default()
    };
    let unknown = over("freq", &HZ).texts("time_sign", &["negative"]);
    let (set, _) = unknown.read(&told).unwrap();
    assert_eq!(set.values.get(0, 0, 1), value(0, 0, 1).conj());
    refused(&unknown, &["`time_sign`"]);
    for (word, unit) in [
        ("newtons", ReferenceUnit::Newton),
        ("n", ReferenceUnit::Newton),
        ("kg m/s^2", ReferenceUnit::Newton),
        ("Volts", ReferenceUnit::Volt),
    ] {
        let set = read(&over("freq", &HZ).texts("reference_unit", &[word]));
        assert_eq!(set.reference_unit, unit, "{word}");
    }
    for word in ["kN", "mV", "m"] {
        let npz = over("freq", &HZ).texts("reference_unit", &[word]);
        refused(&npz, &["/reference_unit", word, "N or V"]);
    }
    let blank = over("freq", &HZ).texts("frf_kind", &[" "]);
    assert_eq!(read(&blank).kind, None);
}

#[test]
fn axes_may_be_a_list_or_have_commas() {
    let npz = |axes: &[&str]| {
        Npz(Vec::new())
            .complex("frf", &[2, 3, 5], &references_first(3))
            .reals("freq", &HZ)
            .texts("axes", axes)
    };
    for axes in [
        &["reference", "response", "line"][..],
        &["reference,response,line"],
        &["Input, Output, Freq"],
    ] {
        let set = read(&npz(axes));
        assert_eq!(set.values.dim(), (3, 2, 5), "{axes:?}");
        assert_eq!(set.values.get(2, 1, 4), value(2, 1, 4));
    }
    for axes in ["response-line", "line-response-reference", "a, line, b"] {
        refused(&npz(&[axes]), &["/axes", axes, "[2, 3, 5]"]);
    }
    // names of somebody's own say nothing
    for axes in ["a, b, line", "a, b", "x, y, z", "freq", "0"] {
        let (set, warnings) = npz(&[axes]).read(&ReadOptions::default()).unwrap();
        assert_eq!(set.values.dim(), (2, 3, 5), "{axes}");
        let said = warnings.iter().any(|words| words.contains("in the order"));
        assert!(said, "{axes}: {warnings:?}");
    }
    // one known word is enough
    let set = read(&npz(&["reference, point, line"]));
    assert_eq!(set.values.dim(), (3, 2, 5));
}

#[test]
fn node_numbers_of_any_type_are_dofs_and_tell_the_axes() {
    let integers = |values: &[i64]| values.iter().flat_map(|v| v.to_le_bytes()).collect();
    let npz = || {
        Npz(Vec::new())
            .complex("frf", &[2, 3, 5], &references_first(3))
            .reals("freq", &HZ)
    };
    let whole = npz()
        .add("response", "<i8", &[3], integers(&[7, 8, 9]))
        .add("reference", "<i8", &[2], integers(&[101, 102]));
    let real = npz()
        .reals("response", &[7.0, 8.0, 9.0])
        .reals("reference", &[101.0, 102.0]);
    for npz in [whole, real] {
        let set = read(&npz);
        assert_eq!(set.values.dim(), (3, 2, 5));
        assert_eq!(set.responses[2].to_string(), "9:+Z");
        assert_eq!(set.references[1].to_string(), "102:S");
    }
    let frf = || over("freq", &HZ);
    refused(
        &frf().reals("response", &[1.5]),
        &["/response", "whole node numbers"],
    );
    // a time record
    let record = frf().reals("output", &[0.0, 1.0, 2.0]);
    assert_eq!(read(&record).responses[0].to_string(), "1:+Z");
}

#[test]
fn arrays_that_are_no_frfs_are_named_with_the_reason() {
    let values: Vec<Complex64> = (0..5).map(|k| value(0, 0, k)).collect();
    let short = Npz(Vec::new())
        .complex("H", &[1, 1, 5], &values)
        .reals("f", &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    refused(
        &short,
        &[
            "no FRF in the input",
            "/H (1 x 1 x 5)",
            "as long as",
            "/f (6)",
            "one frequency for each",
        ],
    );
    let text = crate::words(&short.document(&ReadOptions::default()).warnings).join("\n");
    assert!(text.contains("/H (1 x 1 x 5)"), "{text}");
    let real = Npz(Vec::new()).reals("H", &HZ).reals("f", &HZ);
    refused(
        &real,
        &[
            "no FRF in the input",
            "only real numbers beside a frequency axis: /H (5)",
            "if they are FRFs: save complex values",
            "`map re=PATH,im=PATH,freq=PATH`",
        ],
    );
    // neither are the results of a modal analysis
    let modes = Npz(Vec::new())
        .reals("damping", &HZ)
        .reals("shapes", &HZ)
        .reals("frequency_hz", &HZ);
    let found = modes.document(&ReadOptions::default()).warnings;
    assert!(found.is_empty(), "{found:?}");
    // positions beside heights are no measurement
    let places = Npz(Vec::new()).reals("height", &HZ).reals("x", &HZ);
    let found = places.document(&ReadOptions::default()).warnings;
    assert!(found.is_empty(), "{found:?}");
}
