//! The meaning of codes and labels: kinds, units, exact steps.

use super::{only_error, only_function, options, read_with, text_58, ONES, SI_164, TWO_COMPLEX};
use chladni_frf::{FrfKind, Node, ReferenceUnit};
use chladni_io::{uff, Abscissa, Function, ReadOptions};

fn with_axes(numerator: &str, denominator: &str, units: &str) -> Function {
    let text = text_58(TWO_COMPLEX, ONES)
        .replace(
            "        11    0    0    0 Velocity             m/s                 ",
            numerator,
        )
        .replace(
            "        13    0    0    0 Force                N                   ",
            denominator,
        );
    only_function(&read_with([units, &text].concat(), &options())).clone()
}

#[test]
fn a_unit_only_in_the_label_gives_kind_and_factor() {
    let blank = "         0    0    0    0 NONE                 NONE                ";
    for (label, kind, reference, factor) in [
        (
            "(1/N)*(m/s²)",
            FrfKind::Accelerance,
            ReferenceUnit::Newton,
            1.0,
        ),
        ("mm/s/V", FrfKind::Mobility, ReferenceUnit::Volt, 1e-3),
        ("g/N", FrfKind::Accelerance, ReferenceUnit::Newton, 9.80665),
    ] {
        let function = with_axes(
            &format!("         1    0    0    0 NONE                 {label:<20}"),
            blank,
            SI_164,
        );
        assert_eq!(
            (function.kind, function.reference_unit, function.scale_to_si),
            (Some(kind), reference, factor),
            "{label}"
        );
    }
}

#[test]
fn millimetres_are_divided_by_their_factor() {
    let units = SI_164.replacen("         1SI", "        10mm", 1).replacen(
        "1.00000000000000000D+00",
        "1.00000000000000000D+03",
        1,
    );
    let nodes = "    -1\n  2411\n         7         0         0        11\n   \
                 1.7100000000000000D+02   0.0000000000000000D+00  -5.0000000000000000D+00\n    \
                 -1\n";
    let document = read_with([nodes, &units].concat(), &options());
    assert_eq!(
        document.geometry.nodes,
        [Node {
            label: 7,
            xyz_m: [0.171, 0.0, -0.005]
        }],
        "also where 164 comes last"
    );
    assert_eq!(document.datasets[0].nodes, Some(1));
    let volt = "         1    0    0    0 NONE                 V                   ";
    let function = with_axes(
        "        11    0    0    0 NONE                 mm/s                ",
        volt,
        &units,
    );
    assert_eq!(
        (function.scale_to_si, function.reference_unit),
        (1e-3, ReferenceUnit::Volt)
    );
    assert_eq!(function.warnings, Vec::<chladni_frf::Finding>::new());
}

#[test]
fn units_behind_the_nodes_hold_for_them_in_the_list_as_in_the_file() {
    let units = SI_164.replacen("         1SI", "        10mm", 1).replacen(
        "1.00000000000000000D+00",
        "1.00000000000000000D+03",
        1,
    );
    let nodes = "    -1\n  2411\n         7         0         0        11\n   \
                 1.7100000000000000D+02   0.0000000000000000D+00  -5.0000000000000000D+00\n    \
                 -1\n";
    let file = tempfile::NamedTempFile::new().unwrap();
    for text in [[nodes, &units].concat(), [&units, nodes].concat()] {
        std::fs::write(file.path(), &text).unwrap();
        let listed = uff::scan(file.path(), &options()).unwrap().geometry;
        assert_eq!(
            listed.nodes,
            [Node {
                label: 7,
                xyz_m: [0.171, 0.0, -0.005]
            }]
        );
        assert_eq!(listed, read_with(&text, &options()).geometry);
    }
}

#[test]
fn a_motion_with_a_unit_over_a_force_without_is_per_newton() {
    let force = "        13    0    0    0 Force                                    ";
    let function = with_axes(
        "        12    0    0    0 Acceleration         g                   ",
        force,
        "",
    );
    assert_eq!(function.scale_to_si, 9.806_65);
    assert_eq!(function.kind, Some(chladni_frf::FrfKind::Accelerance));
    assert!(function.warnings[0].contains("N is assumed"));
}

#[test]
fn a_label_that_contradicts_164_is_reported() {
    let force = "        13    0    0    0 Force                N                   ";
    let function = with_axes(
        "        11    0    0    0 Velocity             mm/s                ",
        force,
        SI_164,
    );
    assert_eq!(function.scale_to_si, 1.0, "164 is used");
    assert!(
        function.warnings[0].contains("mm/s") && function.warnings[0].contains("164"),
        "{:?}",
        function.warnings
    );
}

#[test]
fn codes_and_labels_that_say_nothing_leave_the_kind_open() {
    let blank = "         0    0    0    0 NONE                 NONE                ";
    assert_eq!(with_axes(blank, blank, SI_164).kind, None);
}

#[test]
fn a_node_with_an_undefined_coordinate_system_is_named() {
    let nodes = "    -1\n  2411\n         7         0         3        11\n   1.0D+00   0.0D+00   \
                 0.0D+00\n    -1\n";
    let document = read_with([SI_164, nodes].concat(), &options());
    assert!(
        document
            .warnings
            .iter()
            .any(|w| w.contains("nodes 7 ") && w.contains("no dataset 18 or 2420 defines")),
        "{:?}",
        document.warnings
    );
}

#[test]
fn the_exact_step_behind_six_digits_is_named_and_taken_with_snap_df() {
    let text = [
        SI_164,
        &text_58(
            "         6         2         1  4.88281E+00  2.44141E+00  0.00000E+00",
            ONES,
        ),
    ]
    .concat();
    let document = read_with(&text, &options());
    let function = only_function(&document);
    assert_eq!(
        function.abscissa,
        Abscissa::Even {
            start: 4.88281,
            step: 2.44141
        }
    );
    assert!(
        function.warnings[0].contains("2.44140625") && function.warnings[0].contains("`snap_df`"),
        "{:?}",
        function.warnings
    );
    let document = read_with(
        &text,
        &ReadOptions {
            snap_df: true,
            ..options()
        },
    );
    assert_eq!(
        only_function(&document).abscissa,
        Abscissa::Even {
            start: 4.8828125,
            step: 2.44140625
        }
    );
    assert_eq!(
        only_function(&document).warnings,
        Vec::<chladni_frf::Finding>::new()
    );
}

#[test]
fn the_exact_step_in_id_line_4_is_taken_where_it_agrees() {
    let text = |df: &str| {
        text_58(
            "         6         2         1  0.00000E+00  2.44141E+00  0.00000E+00",
            ONES,
        )
        .replacen(
            "NONE\nNONE\nNONE\nNONE",
            &format!("NONE\nNONE\nNONE\n{df}"),
            1,
        )
    };
    let document = read_with([SI_164, &text("df=2.44140625")].concat(), &options());
    assert_eq!(
        only_function(&document).abscissa,
        Abscissa::Even {
            start: 0.0,
            step: 2.44140625
        }
    );
    assert_eq!(
        only_function(&document).warnings,
        Vec::<chladni_frf::Finding>::new()
    );
    let document = read_with([SI_164, &text("df=2.5")].concat(), &options());
    assert_eq!(
        only_function(&document).abscissa,
        Abscissa::Even {
            start: 0.0,
            step: 2.44141
        }
    );
    assert!(only_function(&document).warnings[0].contains("contradicts"));
}

#[test]
fn frfs_over_orders_are_refused_and_those_over_rpm_are_read() {
    let over = |code: &str, unit: &str| {
        let axis = format!("        {code}    0    0    0 Speed                {unit:<20}");
        let text = text_58(TWO_COMPLEX, ONES);
        let frequency = "        18    0    0    0 Frequency            Hz                  ";
        assert!(text.contains(frequency));
        read_with(
            [SI_164, &text.replace(frequency, &axis)].concat(),
            &options(),
        )
    };
    let orders = over("20", "");
    let told = only_error(&orders).to_string();
    for words in ["orders", "record 8", "18 (frequency)"] {
        assert!(told.contains(words), "{words}: {told}");
    }
    let labelled = over("20", "kHz");
    assert_eq!(only_function(&labelled).abscissa_to_si, 1e3);
    let turns = over("19", "");
    assert_eq!(only_function(&turns).abscissa_to_si, 1.0 / 60.0);
}
