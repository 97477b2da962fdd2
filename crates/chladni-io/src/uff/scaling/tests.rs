//! Kinds, units and factors of dataset 58.

use super::*;

const MM_N: Units = Units {
    length: 1000.0,
    force: 1.0,
};

fn axis(quantity: i32, unit: &str) -> Axis {
    Axis {
        quantity,
        unit: unit.into(),
        ..Axis::default()
    }
}

fn read(numerator: Axis, denominator: Axis, units: Option<Units>) -> (Scaling, Vec<Finding>) {
    let mut warnings = Vec::new();
    let axes = [
        axis(FREQUENCY, "Hz"),
        numerator,
        denominator,
        Axis::default(),
    ];
    (
        scaling(FRF, &axes, [Direction::PLUS_Z; 2], units, &mut warnings),
        warnings,
    )
}

#[test]
fn an_frf_over_time_is_said() {
    for (quantity, unit, factor, said) in [
        (FREQUENCY, "kHz", 1e3, false),
        (TIME, "s", 1.0, true),
        (TIME, "kHz", 1e3, true),
    ] {
        let mut warnings = Vec::new();
        assert_eq!(abscissa(&axis(quantity, unit), FRF, &mut warnings), factor);
        let told = |found: &Finding| found.code == "frequency-over-time";
        assert_eq!(warnings.iter().any(told), said, "{warnings:?}");
    }
}

#[test]
fn revolutions_are_divided_by_60_and_orders_are_refused() {
    for (unit, factor, code) in [
        ("", 1.0 / 60.0, None),
        ("rpm", 1.0 / 60.0, None),
        ("Hz", 1.0, Some("unit-contradicted")),
        ("furlong", 1.0 / 60.0, Some("unit-assumed")),
    ] {
        let mut warnings = Vec::new();
        assert_eq!(abscissa(&axis(RPM, unit), FRF, &mut warnings), factor);
        let codes: Vec<&str> = warnings.iter().map(|found| &*found.code).collect();
        assert_eq!(codes, Vec::from_iter(code), "{unit}");
    }
    let told = refuse_orders(FRF, &axis(ORDER, ""), 3).unwrap_err();
    assert!(told.to_string().contains("found 20, an order"), "{told}");
    assert!(refuse_orders(FRF, &axis(ORDER, "furlong"), 3).is_err());
    let mut warnings = Vec::new();
    let by_label = axis(ORDER, "kHz");
    assert!(refuse_orders(FRF, &by_label, 3).is_ok());
    assert_eq!(abscissa(&by_label, FRF, &mut warnings), 1e3);
    assert_eq!(warnings[0].code, "unit-contradicted");
    // an order spectrum is kept as it is
    assert!(refuse_orders(27, &axis(ORDER, ""), 3).is_ok());
    assert!(refuse_orders(FRF, &axis(RPM, ""), 3).is_ok());
}

#[test]
fn codes_give_the_kind() {
    for (quantity, kind) in [
        (8, FrfKind::Receptance),
        (11, FrfKind::Mobility),
        (12, FrfKind::Accelerance),
    ] {
        let (scaling, warnings) = read(axis(quantity, ""), axis(13, ""), Some(Units::SI));
        assert_eq!((scaling.kind, scaling.scale_to_si), (Some(kind), 1.0));
        assert!(warnings.is_empty(), "{warnings:?}");
    }
}

#[test]
fn velocity_over_a_volt_label_is_mobility_per_volt() {
    for quantity in [0, 1] {
        let (scaling, warnings) = read(axis(11, "mm/s"), axis(quantity, "mV"), Some(MM_N));
        assert_eq!(
            (scaling.kind, scaling.reference_unit),
            (Some(FrfKind::Mobility), ReferenceUnit::Volt)
        );
        assert!(
            (scaling.scale_to_si - 1.0).abs() < 1e-12,
            "mm/s per mV is m/s per V"
        );
        assert!(warnings.is_empty(), "{warnings:?}");
    }
}

#[test]
fn values_are_divided_by_the_factors_of_164() {
    assert_eq!(
        read(axis(11, ""), axis(13, ""), Some(MM_N)).0.scale_to_si,
        1e-3
    );
    let mm_mn = Units {
        length: 1000.0,
        force: 1000.0,
    };
    assert_eq!(
        read(axis(11, ""), axis(13, ""), Some(mm_mn)).0.scale_to_si,
        1.0
    );
}

#[test]
fn a_unit_only_in_the_label_decides_kind_and_factor() {
    let (scaling, _) = read(axis(1, "(1/N)*(m/s²)"), axis(0, ""), None);
    assert_eq!(
        (scaling.kind, scaling.scale_to_si),
        (Some(FrfKind::Accelerance), 1.0)
    );
    let (scaling, _) = read(axis(0, "mm/s/V"), axis(0, ""), None);
    assert_eq!(
        (scaling.kind, scaling.reference_unit, scaling.scale_to_si),
        (Some(FrfKind::Mobility), ReferenceUnit::Volt, 1e-3)
    );
    let (scaling, _) = read(axis(0, "g"), axis(0, "N"), None);
    assert_eq!(
        (scaling.kind, scaling.scale_to_si),
        (Some(FrfKind::Accelerance), 9.80665)
    );
}

#[test]
fn a_label_that_contradicts_164_is_reported_and_164_is_used() {
    for (unit, below) in [("mm/s", "N"), ("mm/s", ""), ("mm/s/N", "")] {
        let (scaling, warnings) = read(axis(11, unit), axis(13, below), Some(Units::SI));
        assert_eq!(scaling.scale_to_si, 1.0);
        assert!(
            warnings.len() == 1 && warnings[0].contains("contradicts"),
            "{unit}: {warnings:?}"
        );
    }
}

#[test]
fn a_label_that_contradicts_the_codes_is_reported() {
    let (scaling, warnings) = read(axis(12, "m/s"), axis(13, "N"), Some(Units::SI));
    assert_eq!(scaling.kind, Some(FrfKind::Accelerance));
    assert!(warnings[0].contains("says mobility"), "{warnings:?}");
}

#[test]
fn codes_and_labels_that_say_nothing_give_no_kind() {
    let (scaling, warnings) = read(axis(0, ""), axis(0, ""), None);
    assert_eq!((scaling.kind, scaling.scale_to_si), (None, 1.0));
    assert!(warnings[0].contains("SI is assumed"));
    let (scaling, warnings) = read(axis(12, ""), axis(11, ""), Some(Units::SI));
    assert_eq!(scaling.kind, None);
    assert!(warnings[0].contains("12 over 11"), "{warnings:?}");
}

#[test]
fn force_over_motion_is_named() {
    let (scaling, warnings) = read(axis(13, ""), axis(12, ""), Some(Units::SI));
    assert_eq!(scaling.kind, None);
    assert!(warnings[0].contains("swapped"), "{warnings:?}");
}

#[test]
fn exponents_count_for_general_quantities_and_scalars() {
    let general = Axis {
        quantity: 1,
        exponents: [1, 0, 0],
        ..Axis::default()
    };
    let mut warnings = Vec::new();
    let axes = [axis(TIME, "s"), general, Axis::default(), Axis::default()];
    let time = scaling(1, &axes, [Direction::PLUS_Z; 2], Some(MM_N), &mut warnings);
    assert_eq!(time.scale_to_si, 1e-3);
    let absurd = Axis {
        quantity: 1,
        exponents: [i32::MAX, i32::MIN, 0],
        ..Axis::default()
    };
    let axes = [axis(TIME, "s"), absurd, Axis::default(), Axis::default()];
    assert_eq!(
        scaling(1, &axes, [Direction::PLUS_Z; 2], Some(MM_N), &mut warnings).scale_to_si,
        1.0
    );
}

#[test]
fn abscissas_in_kilohertz_and_radians_are_scaled_when_the_unit_says_so() {
    let scale = |unit: &str| {
        let axes = [
            axis(FREQUENCY, unit),
            axis(11, ""),
            axis(13, ""),
            Axis::default(),
        ];
        scaling(
            FRF,
            &axes,
            [Direction::PLUS_Z; 2],
            Some(Units::SI),
            &mut Vec::new(),
        )
        .abscissa_to_si
    };
    assert_eq!(
        [scale(""), scale("Hz"), scale("kHz"), scale("rad/s")],
        [1.0, 1.0, 1000.0, 1.0 / std::f64::consts::TAU]
    );
}
