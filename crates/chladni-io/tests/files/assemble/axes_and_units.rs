//! Axes, kinds and units that must agree, and values in SI.

use super::documents::{document, frf, function, merge};
use chladni_frf::{FrfKind, FrfValues, ReferenceUnit, Severity, TimeSign};
use chladni_io::{assemble, Abscissa, Function, Ordinate, ReadOptions};
use num_complex::{Complex32, Complex64};

#[test]
fn axes_agree_within_half_a_line_or_both_records_are_named() {
    let near = Function {
        abscissa: Abscissa::Uneven(vec![1.0, 1.51, 2.0]),
        line: 40,
        ..frf("2:+Z", "9:+Z", 1.0)
    };
    let (set, warnings) = merge(
        vec![document("a.uff", vec![frf("1:+Z", "9:+Z", 1.0), near])],
        &ReadOptions::default(),
    )
    .unwrap();
    assert_eq!(set.frequency_hz[1], 1.5);
    assert!(
        warnings[0]
            .contains("differ by up to 0.020 of a line (a.uff line 40 against a.uff line 12)"),
        "{warnings:?}"
    );
    for abscissa in [
        Abscissa::Even {
            start: 1.3,
            step: 0.5,
        },
        Abscissa::Uneven(vec![1.0, 1.5]),
        Abscissa::Uneven(vec![1.0, f64::NAN, 2.0]),
    ] {
        let count = if let Abscissa::Uneven(values) = &abscissa {
            values.len()
        } else {
            3
        };
        let far = Function {
            abscissa,
            line: 40,
            ordinate: Ordinate::Complex64(vec![Complex64::new(1.0, 1.0); count]),
            ..frf("2:+Z", "9:+Z", 1.0)
        };
        let text = merge(
            vec![document("a.uff", vec![frf("1:+Z", "9:+Z", 1.0), far])],
            &ReadOptions::default(),
        )
        .unwrap_err()
        .to_string();
        assert!(
            text.contains("a.uff line 40")
                && text.contains("a.uff line 12")
                && text.contains("half a line"),
            "{text}"
        );
    }
}

#[test]
fn axes_that_differ_by_more_than_printed_digits_are_a_caution() {
    let told = |start: f64, off: f64| {
        let axis = |first: f64| Abscissa::Uneven((0..3).map(|k| first + 0.5 * k as f64).collect());
        let one = |response: &str, first: f64| Function {
            abscissa: axis(first),
            ..frf(response, "9:+Z", 1.0)
        };
        let functions = vec![one("1:+Z", start), one("2:+Z", start + off)];
        let documents = vec![document("a.uff", functions)];
        let mut told = assemble(documents, &ReadOptions::default())
            .unwrap()
            .warnings;
        told.retain(|finding| finding.code == "axes-differ");
        told.pop()
    };
    assert!(told(10.0, 1e-6).is_none());
    let severity = |start, off| told(start, off).map(|finding| finding.severity);
    // a hundredth of a line; six digits of 5000 Hz
    assert_eq!(severity(10.0, 5e-3), Some(Severity::Note));
    assert_eq!(severity(5000.0, 0.04), Some(Severity::Note));
    assert_eq!(severity(10.0, 0.04), Some(Severity::Caution));
    let far = told(10.0, 0.05).unwrap();
    assert!(
        far.contains("0.100 of a line") && far.contains("up to 0.05 Hz"),
        "{far}"
    );
    assert!((far.values["off_hz"].as_slice()[0] - 0.05).abs() < 1e-9);
}

#[test]
fn single_lines_must_be_the_same_and_a_falling_axis_is_named() {
    let one_line = |response: &str, f: f64| Function {
        abscissa: Abscissa::Uneven(vec![f]),
        ordinate: Ordinate::Complex64(vec![Complex64::new(1.0, 1.0)]),
        ..frf(response, "9:+Z", 1.0)
    };
    let pair = |f: f64| {
        vec![document(
            "a.uff",
            vec![one_line("1:+Z", 300.0), one_line("2:+Z", f)],
        )]
    };
    assert!(merge(pair(300.0), &ReadOptions::default()).is_ok());
    assert!(merge(pair(301.0), &ReadOptions::default())
        .unwrap_err()
        .to_string()
        .contains("one line at 301 Hz"));
    let falling = Function {
        abscissa: Abscissa::Even {
            start: 5.0,
            step: -1.0,
        },
        ..frf("1:+Z", "9:+Z", 1.0)
    };
    let text = merge(
        vec![document("a.uff", vec![falling])],
        &ReadOptions::default(),
    )
    .unwrap_err()
    .to_string();
    assert!(
        text.contains("a.uff line 12") && text.contains("3 lines 5..3 Hz"),
        "{text}"
    );
}

#[test]
fn kinds_and_reference_units_must_agree_unless_the_user_says_the_kind() {
    let other = Function {
        kind: None,
        ..frf("2:+Z", "9:+Z", 1.0)
    };
    let documents = || {
        vec![
            document("a.uff", vec![frf("1:+Z", "9:+Z", 1.0)]),
            document("b.uff", vec![other.clone()]),
        ]
    };
    let text = merge(documents(), &ReadOptions::default())
        .unwrap_err()
        .to_string();
    assert!(
        text.contains("not said in b.uff") && text.contains("mobility as in a.uff"),
        "{text}"
    );
    let options = ReadOptions {
        frf_kind: Some(FrfKind::Receptance),
        ..ReadOptions::default()
    };
    let (set, warnings) = merge(documents(), &options).unwrap();
    assert_eq!(set.kind, Some(FrfKind::Receptance));
    assert_eq!(
        warnings,
        ["a.uff says mobility, you say receptance: taken as receptance"]
    );
    let unknown = vec![document("b.uff", vec![other.clone()])];
    assert_eq!(
        merge(unknown, &ReadOptions::default()).unwrap().0.kind,
        None
    );
    let volts = Function {
        reference_unit: ReferenceUnit::Volt,
        ..frf("2:+Z", "9:+Z", 1.0)
    };
    let mixed = vec![document("a.uff", vec![frf("1:+Z", "9:+Z", 1.0), volts])];
    assert!(merge(mixed, &ReadOptions::default())
        .unwrap_err()
        .to_string()
        .contains("found V"));
}

#[test]
fn values_come_out_in_si_with_the_right_sign_and_precision() {
    let single = Function {
        scale_to_si: 1e-3,
        abscissa_to_si: 1000.0,
        ..function(
            4,
            "1:+Z",
            "9:+Z",
            Ordinate::Complex32(vec![Complex32::new(2.0, 3.0); 3]),
        )
    };
    let options = ReadOptions {
        time_sign: TimeSign::Minus,
        ..ReadOptions::default()
    };
    let (set, _) = merge(vec![document("a.uff", vec![single.clone()])], &options).unwrap();
    assert_eq!(set.frequency_hz[1], 1500.0);
    let FrfValues::F32(values) = &set.values else {
        panic!("single precision must stay")
    };
    assert_eq!(values[[0, 0, 0]], Complex32::new(0.002, -0.003));
    let double = Function {
        abscissa_to_si: 1000.0,
        ..frf("2:+Z", "9:+Z", 1.0)
    };
    let (set, _) = merge(
        vec![document("a.uff", vec![single, double])],
        &ReadOptions::default(),
    )
    .unwrap();
    assert!(matches!(set.values, FrfValues::F64(_)));
    let real = function(
        4,
        "1:+Z",
        "9:+Z",
        Ordinate::Real64(vec![1.0, f64::INFINITY, 2.0]),
    );
    let (set, warnings) =
        merge(vec![document("a.uff", vec![real])], &ReadOptions::default()).unwrap();
    assert!(set.values.get(0, 0, 1).im.is_nan());
    let text = warnings.join("\n");
    assert!(
        text.contains("real values") && text.contains("1 values are not finite"),
        "{text}"
    );
}
