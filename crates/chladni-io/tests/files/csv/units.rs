//! Units of values, phases and frequencies: read, asked for, or refused.

use super::reading::{c, read, read_with, refusal, values};
use chladni_frf::{FrfKind, ReferenceUnit, TimeSign};
use chladni_io::{PhaseUnit, ReadOptions};

#[test]
fn magnitude_and_phase_in_degrees_radians_and_decibels() {
    let close = |text: &str| {
        let (_, values) = values(text);
        assert!(
            (values[0] - c(0.0, 10.0)).norm() < 1e-12,
            "{text}: {values:?}"
        );
    };
    close("f,mag,phase\n1,10,90\n2,1,0\n");
    close("f [Hz],Abs(H) [m/s/N],Phi(H) [deg]\n1,10,90\n2,1,0\n");
    close("f,Magnitude,Phase [rad]\n1,10,1.5707963267948966\n2,1,0\n");
    close("f,Magnitude [dB re 1 m/s/N],Phase\n1,20,90\n2,1,0\n");
    close("f,Mag (dB ref 0.1 m/s/N),Phase\n1,40,90\n2,1,0\n");
    let text = refusal("f,Magnitude [dB],Phase\n1,20,90\n");
    assert!(
        text.contains("dB without its reference") && text.contains("column 2"),
        "{text}"
    );
}

#[test]
fn unnamed_columns_are_read_only_where_they_cannot_be_magnitude_and_phase() {
    let (set, warnings) = read("1,0.1,-0.2\n2,-0.3,0.2\n").unwrap();
    assert_eq!(set.values.get(0, 0, 1), c(-0.3, 0.2));
    assert!(warnings
        .join("\n")
        .contains("taken as real and imaginary part"));
    let text = refusal("1,0.1,-90\n2,0.3,45\n");
    assert!(
        text.contains("may be magnitude and phase") && text.contains("f,mag,phase"),
        "{text}"
    );
    assert!(
        refusal("Freq Amplitude of H at point 3\n1,0.1,-0.2\n2,-0.3,0.2\n")
            .contains("may be magnitude")
    );
    // decibels that cross zero, and an unwrapped phase beyond a turn
    let text = refusal("1,-6.5,-94\n2,3,-190\n3,20,-280\n4,-9,-400\n");
    assert!(text.contains("may be magnitude and phase"), "{text}");
    // no unwrapped phase leaps by more than half a turn, no decibels reach 400
    for text in [
        "1,-6.5,-94\n2,3,-900\n3,2,30\n",
        "1,-600.5,-300\n2,30,-400\n",
    ] {
        assert!(read(text).is_ok(), "{text}");
    }
}

#[test]
fn units_decide_kind_and_scale_and_contradictions_are_refused() {
    let (set, _) = read("# unit = mm/s/N\nf,re,im\n1,2000,0\n2,1,0\n").unwrap();
    assert_eq!(
        (set.kind, set.values.get(0, 0, 0)),
        (Some(FrfKind::Mobility), c(2.0, 0.0))
    );
    let contradiction = "# frf_kind = receptance\n# unit = m/s/N\nf,re,im\n1,2,0\n2,1,0\n";
    assert!(refusal(contradiction).contains("`frf_kind`"));
    let options = ReadOptions {
        frf_kind: Some(FrfKind::Mobility),
        ..ReadOptions::default()
    };
    let (set, warnings) = read_with(contradiction, &options).unwrap();
    assert_eq!(set.kind, Some(FrfKind::Mobility));
    assert!(
        warnings
            .join("\n")
            .contains("says receptance, you say mobility"),
        "{warnings:?}"
    );
    let (set, warnings) = read("f,re,im [furlong]\n1,2,0\n2,1,0\n").unwrap();
    assert_eq!(set.kind, None);
    assert!(
        warnings
            .iter()
            .any(|warning| warning.contains("taken as SI")),
        "{warnings:?}"
    );
    assert!(refusal(
        "f,Re(a) [m/N],Im(a) [m/N],Re(b) [m/s/N],Im(b) [m/s/N]\n1,2,0,1,1\n2,1,0,1,1\n"
    )
    .contains("different kinds"));
}

#[test]
fn a_reference_unit_other_than_that_of_the_unit_is_refused_with_its_line() {
    let of_remark = "# unit = m/s/N\n# reference_unit = V\nf,re,im\n1,2,0\n2,1,0\n";
    let of_column = "# frf_kind = mobility\n# reference_unit = V\nf,Re(a) [m/s/N],Im(a) [m/s/N]\n1,2,0\n2,1,0\n";
    for text in [of_remark, of_column] {
        let said = refusal(text);
        for words in [
            "line 2",
            "reference_unit and unit contradict",
            "V with unit m/s/N",
            "N for that unit",
            "correct the one that is wrong",
        ] {
            assert!(said.contains(words), "{words}: {said}");
        }
    }
    let agreed = of_remark.replace("m/s/N", "m/s/V");
    let (set, _) = read(&agreed).unwrap();
    assert_eq!(set.reference_unit, ReferenceUnit::Volt);
    assert_eq!(set.kind, Some(FrfKind::Mobility));
}

#[test]
fn remarks_that_contradict_each_other_are_refused_with_both_lines() {
    let rows = "f,mag,phase\n1,2,90\n2,1,0\n";
    for (key, one, other) in [
        ("frf_kind", "mobility", "receptance"),
        ("time_sign", "+", "-"),
        ("unit", "mm/s/N", "m/s/N"),
        ("response", "1:+Z", "2:+Z"),
        ("reference", "1:+Z", "2:+Z"),
        ("phase_unit", "deg", "rad"),
        ("frequency_unit", "Hz", "kHz"),
        ("reference_unit", "N", "V"),
    ] {
        let text = |second: &str| format!("# {key} = {one}\n# {key} = {second}\n{rows}");
        let said = refusal(text(other));
        let found = format!("found `{one}` in line 1, `{other}` in line 2");
        for words in ["line 2", key, "different values", &found, "one value"] {
            assert!(said.contains(words), "{words}: {said}");
        }
        assert!(read(text(one)).is_ok(), "{key}");
    }
    // one value in two spellings, and free text
    for (one, other) in [
        ("unit = mm/s/N", "unit = (mm/s)/N"),
        ("phase unit = deg", "angle_unit = degrees"),
        ("note = first", "note = second"),
    ] {
        let text = format!("# {one}\n# {other}\n{rows}");
        assert!(read(&text).is_ok(), "{text}");
    }
    // the unit of the frequency axis before or behind that of the FRFs
    for (one, other) in [("Hz", "mm/s/N"), ("mm/s/N", "Hz")] {
        let text = format!("# unit = {one}\n# unit = {other}\nf,re,im\n1,2,0\n2,1,0\n");
        let (set, _) = read(text).unwrap();
        assert!((set.values.get(0, 0, 0).re - 2e-3).abs() < 1e-12, "{one}");
    }
    let long = "response,reference,f,re,im\n1Z,9Z,1,2,3\n1Z,9Z,2,4,5\n";
    let said = refusal(format!("# time_sign = +\n# time_sign = -\n{long}"));
    assert!(said.contains("different values"), "{said}");
    let milli = refusal(format!("# reference_unit = mN\n{rows}"));
    assert!(milli.contains("scale the values to N or V"), "{milli}");
}

#[test]
fn a_remark_and_a_column_of_different_phase_units_are_refused() {
    let text = "# phase_unit = rad\nf,mag,phase [deg]\n1,10,1\n2,1,3\n";
    let said = refusal(text);
    for words in [
        "line 1: phase_unit",
        "two units of the phase",
        "`rad`",
        "[deg]",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let said =
        refusal("# frf_kind = mobility\n# frequency_unit = kHz\nf [Hz],re,im\n1,2,3\n2,1,3\n");
    for words in ["line 2: frequency_unit", "two units of the frequency"] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let told = |phase_unit| ReadOptions {
        phase_unit: Some(phase_unit),
        ..ReadOptions::default()
    };
    for unit in [PhaseUnit::Degree, PhaseUnit::Radian] {
        let warnings = read_with(text, &told(unit)).unwrap().1.join("\n");
        let words = format!("you say {}", unit.as_str());
        assert!(warnings.contains(&words), "{warnings}");
    }
    let of_remark = "# phase_unit = rad\nf,mag,phase\n1,10,1\n2,1,3\n";
    let (_, warnings) = read_with(of_remark, &told(PhaseUnit::Degree)).unwrap();
    let words = "the remark phase_unit says rad, you say deg";
    assert!(warnings.join("\n").contains(words), "{warnings:?}");
}

#[test]
fn two_minus_signs_conjugate_once() {
    let text = "# time_sign = -\nf,re,im\n1,2,3\n2,1,0\n";
    let told = |time_sign| ReadOptions {
        time_sign,
        ..ReadOptions::default()
    };
    for sign in [TimeSign::Plus, TimeSign::Minus] {
        assert_eq!(
            read_with(text, &told(sign)).unwrap().0.values.get(0, 0, 0),
            c(2.0, -3.0)
        );
    }
    let (set, warnings) = read_with(text.replace("= -", "= +"), &told(TimeSign::Minus)).unwrap();
    assert_eq!(set.values.get(0, 0, 0), c(2.0, -3.0));
    assert!(warnings.join("\n").contains("you say -"));
}

#[test]
fn decibels_are_never_taken_for_linear_values() {
    for header in [
        "f,mag_db,phase",
        "f,H dB,phase",
        "f,dB(H),phase(H)",
        "f,20log10(|H|),phase",
        "f,Log Mag,Phase",
        "# unit = dB\nf,mag,phase",
    ] {
        let text = refusal(format!("{header}\n1,-20,90\n2,-30,-90\n"));
        assert!(text.contains("dB") && text.contains("column 2"), "{text}");
    }
    let text = refusal("f,mag,phase\n1,-20,90\n2,-30,-90\n");
    assert!(
        text.contains("below zero") && text.contains("-20"),
        "{text}"
    );
    let (_, values) = values("f,mag_dB re 1 mm/s/N,phase_deg\n1,20,90\n2,0,0\n");
    assert!((values[0] - c(0.0, 1e-2)).norm() < 1e-15);
}

#[test]
fn radians_are_recognised_or_asked_for() {
    let quarter = std::f64::consts::FRAC_PI_2;
    let rows = format!("1,10,{quarter}\n2,1,-3.1\n");
    for header in [
        "f,mag,phase_rad",
        "f,Magnitude,Phase (radians)",
        "f,mag,phase/rad",
        "Hz,m/s/N,radians\nf,mag,phase",
        "# phase_unit = rad\nf,mag,phase",
    ] {
        let (_, values) = values(format!("{header}\n{rows}"));
        assert!(
            (values[0] - c(0.0, 10.0)).norm() < 1e-12,
            "{header}: {values:?}"
        );
    }
    for header in ["f,mag,phase", "f,mag,phase [angle]"] {
        let text = refusal(format!("{header}\n{rows}"));
        assert!(
            text.contains("column 3") && text.contains("`phase_unit rad`"),
            "{text}"
        );
    }
    let told = |phase_unit| ReadOptions {
        phase_unit: Some(phase_unit),
        ..ReadOptions::default()
    };
    let text = format!("f,mag,phase\n{rows}");
    let (set, _) = read_with(&text, &told(PhaseUnit::Radian)).unwrap();
    assert!((set.values.get(0, 0, 0) - c(0.0, 10.0)).norm() < 1e-12);
    let (set, _) = read_with(&text, &told(PhaseUnit::Degree)).unwrap();
    assert!(set.values.get(0, 0, 0).im < 0.3);
    let said = "f,mag,phase [deg]\n1,10,1\n2,1,3\n";
    let (_, warnings) = read_with(said, &told(PhaseUnit::Radian)).unwrap();
    assert!(warnings.join("\n").contains("you say rad"), "{warnings:?}");
    let (_, warnings) = read("f,mag,phase\n1,10,90\n2,1,0\n").unwrap();
    assert!(
        warnings.join("\n").contains("taken as degrees"),
        "{warnings:?}"
    );
}

#[test]
fn frequencies_in_every_unit_and_none_that_is_not_understood() {
    for (header, factor) in [
        ("f_MHz,re,im", 1e6),
        ("f [rpm],re,im", 1.0 / 60.0),
        ("f/kHz,re,im", 1e3),
        ("# frequency unit = kHz\nf,re,im", 1e3),
        ("response,reference,f [kHz],re,im", 1e3),
    ] {
        let row = |f: u32| match header.starts_with("response") {
            true => format!("1Z,2Z,{f},2,3\n"),
            false => format!("{f},2,3\n"),
        };
        let (axis, _) = values(format!("{header}\n{}{}", row(1), row(2)));
        assert!(
            (axis[1] / (2.0 * factor) - 1.0).abs() < 1e-12,
            "{header}: {axis:?}"
        );
    }
    for header in [
        "f_mhz,re,im",
        "omega,re,im",
        "index,re,im",
        "angular frequency,re,im",
    ] {
        assert!(
            refusal(format!("{header}\n1,2,3\n2,3,4\n")).contains("column 1"),
            "{header}"
        );
    }
    let rows = refusal(",re,im\n0,2,3\n1,3,4\n2,4,5\n");
    assert!(rows.contains("may count the rows"), "{rows}");
}

#[test]
fn the_unit_of_an_imaginary_part_counts() {
    let (_, second) = values("f,re,im [mm/s/N]\n1,2000,3000\n2,1,1\n");
    assert!((second[0] - c(2.0, 3.0)).norm() < 1e-12);
    let (_, both) = values("f,re [m/s/N],im [mm/s/N]\n1,2,3000\n2,1,1\n");
    assert!((both[0] - c(2.0, 3.0)).norm() < 1e-12);
    let text = refusal("f,re [m/s/N],im [m/N]\n1,2,3\n2,1,1\n");
    assert!(
        text.contains("column 3") && text.contains("different kinds"),
        "{text}"
    );
}

#[test]
fn a_row_of_units_that_does_not_fit_is_refused() {
    let text = refusal("f mag phase\nMHz mm/s/N\n1 2 90\n2 3 -90\n");
    assert!(
        text.contains("line 2") && text.contains("row of units"),
        "{text}"
    );
}

#[test]
fn a_remark_and_a_column_of_different_units_are_refused() {
    let rows = "1,2,3\n2,1,1\n";
    let text = refusal(format!("# unit = mm/s/N\nf,re [m/s/N],im [m/s/N]\n{rows}"));
    assert!(
        text.contains("`mm/s/N` in the remark, `m/s/N` in the column"),
        "{text}"
    );
    let (_, same) = values(format!("# unit = mm/s/N\nf,re [(mm/s)/N],im\n{rows}"));
    assert!((same[0] - c(0.002, 0.003)).norm() < 1e-15);
}

#[test]
fn a_column_of_units_counts_where_all_rows_agree() {
    let table = |units: [&str; 2]| {
        format!(
            "response,reference,f,re,im,unit\n1Z,9Z,1,2,3,{}\n1Z,9Z,2,4,5,{}\n",
            units[0], units[1]
        )
    };
    let (set, warnings) = read(table(["mm/s/N", "mm/s/N"])).unwrap();
    assert_eq!(set.kind, Some(FrfKind::Mobility));
    assert!((set.values.get(0, 0, 0) - c(0.002, 0.003)).norm() < 1e-15);
    assert!(!warnings.join("\n").contains("unit"), "{warnings:?}");
    let text = refusal(table(["mm/s/N", "m/s/N"]));
    assert!(
        text.contains("line 3") && text.contains("`m/s/N` after `mm/s/N` in line 2"),
        "{text}"
    );
    let text = refusal(format!("# unit = m/s/N\n{}", table(["mm/s/N", "mm/s/N"])));
    assert!(text.contains("different units"), "{text}");
    let (set, _) = read(table(["mm/s/N", "(mm/s)/N"])).unwrap();
    assert!((set.values.get(0, 0, 1) - c(0.004, 0.005)).norm() < 1e-15);
    // the name of a column beside it
    let text = table(["mm/s/N", "mm/s/N"]).replace("re,im", "re [m/s/N],im");
    let text = refusal(text);
    assert!(
        text.contains("`mm/s/N` in the column of units, `m/s/N` in the name"),
        "{text}"
    );
    // a row of another length is refused by its length
    let text = refusal(format!(
        "{}1Z,9Z,3,4,5,6,m/s/N\n",
        table(["mm/s/N", "mm/s/N"])
    ));
    assert!(text.contains("another length"), "{text}");
}

#[test]
fn the_unit_of_decibels_for_the_whole_file_is_that_of_their_reference() {
    let long = |units: [&str; 2]| {
        format!(
            "response,reference,f,mag,phase [deg],unit\n1Z,9Z,1,20,0,{}\n1Z,9Z,2,40,0,{}\n",
            units[0], units[1]
        )
    };
    for text in [
        "# unit = dB re 1 m/s/N\nf,mag,phase [deg]\n1,20,0\n2,40,0\n".to_owned(),
        long(["dB re 1 m/s/N", "dB re 1 (m/s)/N"]),
    ] {
        let (set, warnings) = read(&text).unwrap();
        assert_eq!(set.kind, Some(FrfKind::Mobility));
        assert!((set.values.get(0, 0, 0) - c(10.0, 0.0)).norm() < 1e-12);
        assert!(!warnings.join("\n").contains("taken as SI"), "{warnings:?}");
    }
    let text = refusal(long(["dB re 1 m/s/N", "dB re 1e-6 m/s/N"]));
    assert!(text.contains("differ from row to row"), "{text}");
    let text = refusal("# unit = dB re 1 m/s/N\nf,mag [m/s/N],phase [deg]\n1,2,3\n2,1,1\n");
    assert!(text.contains("different units"), "{text}");
    // no decibels: what they are is not known
    let (_, warnings) = read("# unit = dB re 1 m/s/N\nf,re,im\n1,2,3\n2,1,1\n").unwrap();
    assert!(warnings.join("\n").contains("taken as SI"), "{warnings:?}");
}

#[test]
fn a_minus_in_a_name_turns_the_numbers() {
    for text in [
        "f,Re,-Im\n1,0,-10\n2,1,1\n",
        "f,mag,phase lag [deg]\n1,10,-90\n2,1,1\n",
        "f,mag,-phase [deg]\n1,10,-90\n2,1,1\n",
        "response,reference,f,re,-im\n1Z,9Z,1,0,-10\n1Z,9Z,2,1,1\n",
    ] {
        let (_, values) = values(text);
        assert!(
            (values[0] - c(0.0, 10.0)).norm() < 1e-12,
            "{text}: {values:?}"
        );
    }
    for header in ["f,-Re,-Im", "f,-mag [m/s/N],phase [deg]"] {
        let text = refusal(format!("{header}\n1,2,3\n2,1,1\n"));
        assert!(
            text.contains("column 2") && text.contains("a minus"),
            "{text}"
        );
    }
    let text = refusal("f,ln|H|,phase [deg]\n1,2,3\n2,1,1\n");
    assert!(
        text.contains("column 2") && text.contains("logarithm"),
        "{text}"
    );
}

#[test]
fn units_with_a_factor_and_foreign_units_of_a_phase_are_refused_in_any_brackets() {
    let told = ReadOptions {
        phase_unit: Some(PhaseUnit::Radian),
        ..ReadOptions::default()
    };
    for phase in ["(pi rad)", "[pi rad]", "(mrad)", "(deg x10)", "(gon)"] {
        for text in [
            format!("f,mag,phase {phase}\n1,10,100\n2,1,200\n"),
            format!("f,1Z mag,2Z mag,1Z phase {phase},2Z phase {phase}\n1,1,1,9,9\n2,1,2,9,9\n"),
            format!("response,reference,f,mag,phase {phase}\n1Z,9Z,1,2,3\n1Z,9Z,2,4,5\n"),
        ] {
            let said = refusal(&text);
            assert!(said.contains("than degrees or radians"), "{text}: {said}");
            assert!(said.contains(phase) && said.contains("column"), "{said}");
        }
        let text = format!("f,mag,phase {phase}\n1,10,100\n2,1,200\n");
        assert!(read_with(&text, &told).is_ok(), "{text}");
    }
    for part in ["re x1e3 [m/s/N]", "re *1000 (m/s/N)", "re [10 m/s/N]"] {
        for text in [
            format!("f,{part},im [m/s/N]\n1,2,3\n2,1,1\n"),
            format!("response,reference,f,im,{part}\n1Z,9Z,1,2,3\n1Z,9Z,2,4,5\n"),
        ] {
            let said = refusal(&text);
            assert!(said.contains("holds a factor"), "{text}: {said}");
        }
    }
    for phase in [
        "phase [deg] (rev B)",
        "phase (deg) (cycle 2)",
        "phase (deg) x10",
        "phase (±180 deg)",
    ] {
        let (_, values) = values(format!("f,mag,{phase}\n1,10,90\n2,1,0\n"));
        assert!((values[0] - c(0.0, 10.0)).norm() < 1e-12, "{phase}");
    }
    let row_of_units = "f re im\nHz 10*m/s/N m/s/N\n1 2 3\n2 1 1\n";
    assert!(refusal(row_of_units).contains("holds a factor"));
    let counted = "f,re x9,im x9,re x10,im x10\n1,1,2,3,4\n2,1,2,3,5\n";
    assert_eq!(read(counted).unwrap().0.responses.len(), 2);
}
