//! Text tables: every layout, every refusal with its words, our own round trip, real
//! samples.
use chladni_frf::{
    Error, ErrorKind, FrfKind, FrfSet, FrfValues, Geometry, ReferenceUnit, TimeSign,
};
use chladni_io::{read_document, read_frf, write_frf, Duplicates, ReadOptions};
use chladni_io::{DeclaredDofs, PhaseUnit};
use ndarray::{Array1, Array3};
use num_complex::Complex64;
use proptest::prelude::*;
use std::path::PathBuf;

fn read_with(
    text: impl AsRef<[u8]>,
    options: &ReadOptions,
) -> Result<(FrfSet, Vec<String>), Error> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.txt");
    std::fs::write(&path, text).unwrap();
    read_frf(&[path], options).map(|(set, _, warnings)| (set, crate::words(&warnings)))
}

fn read(text: impl AsRef<[u8]>) -> Result<(FrfSet, Vec<String>), Error> {
    read_with(text, &ReadOptions::default())
}

#[track_caller]
fn values(text: impl AsRef<[u8]>) -> (Vec<f64>, Vec<Complex64>) {
    let (set, _) = read(text).unwrap();
    (set.frequency_hz.to_vec(), set.values.frf(0, 0).to_vec())
}

fn c(re: f64, im: f64) -> Complex64 {
    Complex64::new(re, im)
}

/// The error of a text, as the user sees it.
#[track_caller]
fn refusal(text: impl AsRef<[u8]>) -> String {
    let error = read(text).unwrap_err();
    assert_eq!(error.kind, ErrorKind::BadData, "{error}");
    error.to_string()
}

#[test]
fn one_frf_in_every_dialect() {
    let expected = (vec![1.5, 2.0], vec![c(0.25, -3.0), c(1.0, 1e-3)]);
    for text in [
        "f,re,im\n1.5,0.25,-3\n2,1,1e-3\n",
        "f;re;im\r\n1,5;0,25;-3\r\n2;1;1e-3\r\n",
        "# measured on a Monday\n# a = b\nf\tRe\tIm\n1.5\t0.25\t-3\n2\t1\t0.001\n",
        "Frequency (Hz)  Real  Imaginary\n  1.5  0.25  -3\n  2.0  1.0  1.0D-03\n",
        "Some analyser\nDate: yesterday\n\nf [kHz],Re(x) [m/s/N],Im(x) \
         [m/s/N]\n0.0015,0.25,-3\n0.002,1,1e-3\n",
        "f, re, im,\n1.5, 0.25, -3,\n2, 1, 0.001,\n",
        "frequency,re,im\nHz,m/s/N,m/s/N\n1.5,0.25,-3\n2,1,1e-3\n",
        "# f re im\n1.5 0.25 -3\n2 1 1e-3\n",
        "f,im,re\n1.5,-3,0.25\n2,0.001,1\n",
    ] {
        assert_eq!(values(text), expected, "{text}");
    }
}

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
fn wide_tables_take_dofs_from_their_headers() {
    let (set, warnings) =
        read("f,1Z:3Z Re,1Z:3Z Im,2:-Z:3:+Z re,2:-Z:3:+Z im\n1,1,2,3,4\n2,5,6,7,8\n").unwrap();
    assert_eq!(
        format!(
            "{:?}",
            set.responses
                .iter()
                .map(ToString::to_string)
                .collect::<Vec<_>>()
        ),
        r#"["1:+Z", "2:-Z"]"#
    );
    assert_eq!(set.references[0].to_string(), "3:+Z");
    assert_eq!(set.values.get(1, 0, 1), c(7.0, 8.0));
    assert_eq!(
        warnings,
        ["no unit in the file; values are taken as SI".to_owned()]
            .map(|words| format!("{}{words}", prefix(&warnings[0])))
    );
}

/// File name in front of a warning.
fn prefix(warning: &str) -> &str {
    warning
        .split_once(": ")
        .map_or("", |(file, _)| &warning[..file.len() + 2])
}

#[test]
fn pairs_of_columns_may_stand_apart() {
    let (set, _) =
        read("f,Re(1Z:9Z),Re(2Z:9Z),Im(1Z:9Z),Im(2Z:9Z)\n1,1,2,3,4\n2,1,2,3,4\n").unwrap();
    assert_eq!(set.values.get(0, 0, 0), c(1.0, 3.0));
    assert_eq!(set.values.get(1, 0, 0), c(2.0, 4.0));
}

#[test]
fn spreadsheets_with_keyword_rows() {
    let text = "Measurement Type,FRF,,FRF,\nX Axis Units,Hz\nX Axis Spacing,0.5\nY Axis Type,Magnitude,,Real/Imaginary,\n\
                Y Axis Units,(mm/s)/N,,(mm/s)/N,\nY Axis DOFs,1Z:3Z [1],,2Z:3Z [1],\n1,1000,180,2000,3000\n2,1,0,1,1\n";
    let (set, _) = read(text).unwrap();
    assert_eq!(
        (set.kind, set.responses[1].to_string().as_str()),
        (Some(FrfKind::Mobility), "2:+Z")
    );
    assert!((set.values.get(0, 0, 0) - c(-1.0, 0.0)).norm() < 1e-12);
    assert!((set.values.get(1, 0, 0) - c(2.0, 3.0)).norm() < 1e-12);
}

#[test]
fn long_tables_hold_several_references_and_text_directions() {
    let text = "# frf_kind = mobility\n# unit = mm/s/V\n# time_sign = -\nnode,dir,ref_node,ref_dir,f,re,im\n\
                1,3,101,3,1,1,2\n1,3,101,3,2,3,4\n2,+Z,101,-Z,1,5,6\n2,+Z,101,-Z,2,7,8\n";
    let (set, warnings) = read(text).unwrap();
    assert_eq!(
        (set.kind, set.reference_unit),
        (Some(FrfKind::Mobility), ReferenceUnit::Volt)
    );
    assert_eq!(
        set.references
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>(),
        ["101:+Z", "101:-Z"]
    );
    assert!((set.values.get(1, 1, 1) - c(0.007, -0.008)).norm() < 1e-15);
    assert!(
        warnings[0].contains("2 of 4 pairs are missing") && warnings[0].contains("(1:+Z, 101:-Z)"),
        "{warnings:?}"
    );
    let semicolons =
        "response;reference;freq;real;imag;coherence\n1Z;2Z;1,5;0,5;1;0,9\n1Z;2Z;2,5;0,5;1;\n";
    let (set, _) = read(semicolons).unwrap();
    assert_eq!(set.frequency_hz.to_vec(), [1.5, 2.5]);
    let coherence = set.coherence.unwrap();
    assert_eq!(coherence[[0, 0, 0]], 0.9);
    assert!(coherence[[0, 0, 1]].is_nan());
}

#[test]
fn missing_rows_and_cells_are_masked_and_reported() {
    let long = "node,dir,ref_node,ref_dir,f,re,im\n1,3,9,3,1,1,2\n1,3,9,3,2,3,4\n1,3,9,3,3,3,4\n2,3,9,3,1,5,6\n2,3,9,3,3,7,NaN\n";
    let (set, warnings) = read(long).unwrap();
    assert!(set.values.get(1, 0, 1).re.is_nan() && set.values.get(1, 0, 2).re.is_nan());
    let text = warnings.join("\n");
    assert!(
        text.contains("1 rows (pair and frequency) are missing")
            && text.contains("first in line 6"),
        "{text}"
    );
    let (set, warnings) = read("f,re,im\n1,2,\n2,3,4\n").unwrap();
    assert!(set.values.get(0, 0, 0).re.is_nan() && set.values.get(0, 0, 0).im.is_nan());
    assert!(
        warnings.join("\n").contains("1 cells are empty"),
        "{warnings:?}"
    );
}

#[test]
fn coherence_follows_its_frf_and_is_checked() {
    let (set, warnings) =
        read("freq_hz,re,im,coherence\n0,17,0,1.25\n1,-64,-37,0.7\n2,1,1,1.5\n").unwrap();
    let coherence = set.coherence.unwrap();
    assert!(coherence[[0, 0, 0]].is_nan() && coherence[[0, 0, 2]].is_nan());
    assert_eq!(coherence[[0, 0, 1]], 0.7);
    let text = warnings.join("\n");
    assert!(
        text.contains("at 0 Hz is outside 0 to 1") && text.contains("outside 0 to 1 on 1 lines"),
        "{text}"
    );
}

#[test]
fn a_file_without_dofs_names_its_assumption_and_no_driving_point() {
    let (set, warnings) = read("f,re,im\n1,2,3\n2,2,3\n").unwrap();
    assert_eq!(
        (set.responses[0].to_string(), set.references[0].to_string()),
        ("1:+Z".into(), "1:S".into())
    );
    assert!(!set.responses[0].same_axis(set.references[0]));
    let text = warnings.join("\n");
    assert!(
        text.contains("taken as 1:+Z") && text.contains("taken as 1:S; say it with `reference N`"),
        "{text}"
    );
    let options = ReadOptions {
        references: vec![21],
        ..ReadOptions::default()
    };
    assert_eq!(
        read_with("f,re,im\n1,2,3\n2,2,3\n", &options)
            .unwrap()
            .0
            .references[0]
            .to_string(),
        "21:+Z"
    );
    let (set, _) = read("# response = 5:-X\n# reference = 8:+Y\nf,re,im\n1,2,3\n2,2,3\n").unwrap();
    assert_eq!(
        (set.responses[0].to_string(), set.references[0].to_string()),
        ("5:-X".into(), "8:+Y".into())
    );
}

#[test]
fn files_of_one_frf_are_numbered_in_natural_order() {
    let folder = tempfile::tempdir().unwrap();
    for (name, value) in [("point_1.csv", 1), ("point_2.csv", 2), ("point_10.csv", 10)] {
        std::fs::write(
            folder.path().join(name),
            format!("f,re,im\n1,{value},0\n2,{value},1\n"),
        )
        .unwrap();
    }
    let expected = [1.0, 2.0, 10.0];
    for input in [
        folder.path().to_path_buf(),
        folder.path().join("point_*.csv"),
    ] {
        let (set, sources, _) = read_frf(&[input], &ReadOptions::default()).unwrap();
        assert_eq!(
            (0..3)
                .map(|i| set.values.get(i, 0, 0).re)
                .collect::<Vec<_>>(),
            expected
        );
        assert_eq!(set.responses[2].to_string(), "3:+Z");
        assert_eq!(sources.len(), 3);
    }
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
fn every_refusal_names_the_row_and_what_to_do() {
    for (text, words) in [
        ("f,re,im\n1,2,3\n1,2,3\n", &["line 3", "stands twice"][..]),
        ("f,re,im\n2,2,3\n1,2,3\n", &["line 3", "falls", "1 after 2"]),
        (
            "f,re,im\n1,2,3\n2,x,3\n",
            &["line 3", "re", "found x", "`lenient`"],
        ),
        ("f,re,im\n1,2,3\n2,inf,3\n", &["line 3", "found inf"]),
        ("f,re,im\n1,2,3\n2,1e999,3\n", &["line 3", "1e999"]),
        ("f,re,im\n1,2,3\n2,****,3\n", &["line 3", "****"]),
        (
            "f,re,im\n1,2,3\n2,2\n",
            &["line 3", "2 columns", "`lenient`"],
        ),
        (
            "f,re,im\n1,5,0,25,-3,5\n2,5,0,5,1,5\n",
            &["line 2", "decimal comma", "`;`"],
        ),
        ("f,re,im\n\"1,5\",\"0,5\",\"1,5\"\n", &["decimal comma"]),
        ("f,re\n1,2\n2,2\n", &["column 2", "imaginary part"]),
        ("f,mag\n1,2\n2,2\n", &["phase"]),
        (
            "time,re,im\n1,2,3\n2,2,3\n",
            &["no FRF", "a time", "chladni estimate"],
        ),
        ("no numbers\nat all\n", &["line 1", "no row of numbers"]),
        ("# only = remarks\n", &["only comments"]),
        (
            "# frf_kind = velocity\nf,re,im\n1,2,3\n",
            &["line 1", "frf_kind", "receptance, mobility or accelerance"],
        ),
        ("(1.5+2j)\n(2-3.5e-08j)\n", &["line 1", "Python", "f,re,im"]),
        (
            "node,dir,ref_node,ref_dir,f,re,im\n1,3,9,3,1,1,2\n1,3,9,3,1,1,2\n",
            &["line 3", "twice for one pair"],
        ),
        (
            "node,dir,ref_node,ref_dir,f,re,im\n1,7,9,3,1,1,2\n",
            &["line 2", "dir", "found 7"],
        ),
        (
            "node,dir,ref_node,ref_dir,f,re,im\nx,3,9,3,1,1,2\n",
            &["line 2", "node", "found x"],
        ),
        (
            "node,dir,ref_node,ref_dir,f,re,im\n1,3,9,3,1,y,2\n",
            &["line 2", "re", "found y"],
        ),
        (
            "node,dir,ref_node,ref_dir,f,re,im\n1,3,9,3,1\n",
            &["line 2", "5 columns"],
        ),
        ("node,dir,ref_node,ref_dir,f,re,im\n", &["no rows"]),
        (
            "node,dir,ref_node,ref_dir,f,re,im\n1,3,9,3,1,1,2\n1,3,9,3,2,1,2\n2,3,9,3,1.4,1,2\n",
            &["line 4", "1.4 for (2:+Z, 9:+Z)"],
        ),
    ] {
        let message = refusal(text);
        for word in words {
            assert!(message.contains(word), "{word}: {message}");
        }
    }
}

#[test]
fn lenient_masks_cells_and_leaves_rows_out_with_a_word() {
    let options = ReadOptions {
        lenient: true,
        ..ReadOptions::default()
    };
    let (set, warnings) = read_with("f,re,im\n1,2,3\n2,x,3\n3,4\n4,5,6\n", &options).unwrap();
    assert_eq!(set.frequency_hz.to_vec(), [1.0, 2.0, 4.0]);
    assert!(set.values.get(0, 0, 1).re.is_nan());
    let text = warnings.join("\n");
    assert!(
        text.contains("1 cells are no finite numbers; masked (first in line 3)")
            && text.contains("(first in line 4)"),
        "{text}"
    );
    let (set, _) = read_with(
        "node,dir,ref_node,ref_dir,f,re,im\n1,3,9,3,1,y,2\n1,3,9,3,2,1,2\n",
        &options,
    )
    .unwrap();
    assert!(set.values.get(0, 0, 0).im.is_nan());
}

#[test]
fn doubled_pairs_need_a_rule() {
    let text = "f,1Z:3Z re,1Z:3Z im,1Z:3Z re,1Z:3Z im\n1,1,0,3,0\n2,1,0,3,0\n";
    let message = refusal(text);
    assert!(
        message.contains("(1:+Z, 3:+Z) is there 2 times") && message.contains("`duplicates"),
        "{message}"
    );
    for (duplicates, expected) in [
        (Duplicates::First, 1.0),
        (Duplicates::Last, 3.0),
        (Duplicates::Mean, 2.0),
    ] {
        let options = ReadOptions {
            duplicates,
            ..ReadOptions::default()
        };
        assert_eq!(
            read_with(text, &options).unwrap().0.values.get(0, 0, 1),
            c(expected, 0.0)
        );
    }
}

#[test]
fn a_header_is_a_header_whatever_follows_it() {
    for first in ["0,NaN,NaN", "0,,", "0,NA,NA", "0,nan(ind),-nan(ind)"] {
        let text = format!("f [Hz],7:-X/9:+Z re [mm/s/N],7:-X/9:+Z im\n{first}\n1,2,3\n2,4,5\n");
        let (set, warnings) = read(&text).unwrap();
        assert_eq!(set.responses[0].to_string(), "7:-X", "{text}");
        assert_eq!(set.kind, Some(FrfKind::Mobility));
        assert_eq!(set.frequency_hz.to_vec(), [0.0, 1.0, 2.0]);
        assert!((set.values.get(0, 0, 1) - c(2e-3, 3e-3)).norm() < 1e-15);
        assert!(set.values.get(0, 0, 0).re.is_nan());
        assert!(!warnings.join("\n").contains("no unit"), "{warnings:?}");
    }
    let long = "node,dir,ref_node,ref_dir,f,re,im\n1,3,9,3,0,NA,NA\n1,3,9,3,1,2,3\n";
    assert_eq!(read(long).unwrap().0.values.get(0, 0, 1), c(2.0, 3.0));
    // a first row that is damaged is no header either
    let text = refusal("f,re,im\n0,x,y\n1,2,3\n2,3,4\n");
    assert!(
        text.contains("line 2") && text.contains("re") && text.contains('x'),
        "{text}"
    );
    let text = refusal("f,re,im\nNaN,1,2\n1,2,3\n2,3,4\n");
    assert!(text.contains("line 2") && text.contains("NaN"), "{text}");
}

#[test]
fn decimal_commas_between_commas_are_refused_in_every_layout() {
    for text in [
        "node,dir,ref_node,ref_dir,f,re,im\n1,3,101,3,10,5,0,0012,-0,0003\n\
         1,3,101,3,11,5,0,0013,-0,0004\n",
        "response,reference,f,re,im\n1Z,9Z,1,5,0,25,-3,5\n",
        "1,0,5,-0,25\n2,0,6,-0,75\n",
    ] {
        assert!(refusal(text).contains("decimal comma"), "{text}");
    }
}

#[test]
fn a_point_among_decimal_commas_is_no_decimal_sign() {
    // 1.000,5 and 1,000.5 are thousands: neither is 1.0005
    let text = refusal("f;re;im\n1.000,5;0,5;1,5\n2.000,5;0,5;1,5\n");
    assert!(
        text.contains("1.000,5") || text.contains("no row of numbers"),
        "{text}"
    );
    let text = refusal("f;re;im\n1,5;0,5;1,5\n2,5;0.5;1,5\n");
    assert!(text.contains("line 3") && text.contains("0.5"), "{text}");
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
    for header in ["f,mag,phase", "f,mag,phase [mrad]"] {
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
fn commented_rows_are_no_data() {
    for sign in ["#", "%", "// "] {
        let wide = format!("f,re,im\n1,2,3\n{sign}1.5,9,9\n2,4,5\n{sign} end\n");
        let (set, warnings) = read(&wide).unwrap();
        assert_eq!(set.frequency_hz.to_vec(), [1.0, 2.0]);
        assert!(
            warnings
                .join("\n")
                .contains("1 rows of numbers are comments: left out (first in line 3)"),
            "{warnings:?}"
        );
        let long =
            format!("response,reference,f,re,im\n1Z,9Z,1,2,3\n{sign}1Z,9Z,1.5,9,9\n1Z,9Z,2,4,5\n");
        assert_eq!(read(&long).unwrap().0.frequency_hz.to_vec(), [1.0, 2.0]);
        let above = format!("{sign}0.5,9,9\n{sign}f,im,re\n1,2,3\n2,4,5\n");
        assert_eq!(
            values(&above),
            (vec![1.0, 2.0], vec![c(3.0, 2.0), c(5.0, 4.0)])
        );
    }
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
fn columns_that_belong_nowhere_are_named() {
    for (header, words) in [
        ("f,re,im,noise,offset", "column 4"),
        ("f,re,im,mag,phase", "stands twice"),
        ("f,Re(1Z:3Z),Im(2Z:3Z),re(2Z:3Z),im(1Z:3Z)", ""),
        ("f,1Z re,1Z im,2Z real,3Z imag", "column"),
        ("f,re,im,re2,", "column"),
    ] {
        let result = read(format!("{header}\n1,2,3,4,5\n2,3,4,5,6\n"));
        match result {
            Ok((set, _)) => {
                // paired by name, whatever their order
                assert_eq!(words, "", "{header}");
                assert_eq!(set.values.get(0, 0, 0), c(2.0, 5.0));
            }
            Err(error) => {
                let text = error.to_string();
                assert!(
                    !words.is_empty() && text.contains(words),
                    "{header}: {text}"
                );
            }
        }
    }
    let (set, _) =
        read("f,re1,im1,re2,im2,coh1,coh2\n1,2,3,4,5,0.5,0.25\n2,2,3,4,5,0.5,0.25\n").unwrap();
    let coherence = set.coherence.unwrap();
    assert_eq!((coherence[[0, 0, 0]], coherence[[1, 0, 0]]), (0.5, 0.25));
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
fn dofs_may_stand_in_a_row_above_the_names() {
    let (set, _) =
        read(",1:+Z/9:+Z,,2:-Z/9:+Z,\nf,re,im,re,im\nHz,m/s/N,,m/s/N,\n1,1,2,3,4\n2,5,6,7,8\n")
            .unwrap();
    assert_eq!(set.responses[1].to_string(), "2:-Z");
    assert_eq!(set.values.get(1, 0, 1), c(7.0, 8.0));
    assert_eq!(set.kind, Some(FrfKind::Mobility));
}

#[test]
fn a_wide_header_is_read_in_a_moment() {
    let pairs = 100_000;
    let header: String = (1..=pairs)
        .map(|k| format!(",{k}:+Z/9:+Z re,{k}:+Z/9:+Z im"))
        .collect();
    let row = |f: u32| format!("{f}{}\n", ",1.5,-2.5".repeat(pairs));
    let text = format!("f{header}\n{}{}", row(1), row(2));
    let start = cpu_time::ThreadTime::now();
    let (set, _) = read(&text).unwrap();
    assert_eq!(set.responses.len(), pairs);
    let took = start.elapsed();
    assert!(took.as_secs() < 6, "{took:?}");
}

fn small_set(values: Array3<Complex64>, coherence: bool) -> FrfSet {
    let dim = values.dim();
    FrfSet {
        frequency_hz: Array1::from_iter((0..dim.2).map(|k| 0.1 + k as f64 / 3.0)),
        responses: (0..dim.0)
            .map(|i| {
                format!("{}:-RX", 1000 * i as u64 + u64::from(u32::MAX))
                    .parse()
                    .unwrap()
            })
            .collect(),
        references: (0..dim.1)
            .map(|j| format!("{}:S", j + 1).parse().unwrap())
            .collect(),
        kind: Some(FrfKind::Accelerance),
        reference_unit: ReferenceUnit::Volt,
        coherence: coherence.then(|| Array3::from_elem(dim, 1.0 / 3.0)),
        variance: None,
        estimation: None,
        values: FrfValues::F64(values),
        geometry: Geometry::default(),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn own_tables_read_back_to_the_last_bit(
        responses in 1_usize..4, references in 1_usize..3, lines in 1_usize..5, coherence: bool,
        numbers in prop::collection::vec(prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO, 48),
    ) {
        let values = Array3::from_shape_fn((responses, references, lines), |(i, j, k)| {
            let at = 2 * ((i * references + j) * lines + k);
            // never zero on every line, which means missing
            Complex64::new(numbers[at % 48], if k == 0 { 1.0 } else { numbers[(at + 1) % 48] })
        });
        let set = small_set(values, coherence);
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("own.csv");
        write_frf(&path, &set, false).unwrap();
        let (back, _, warnings) = read_frf(&[path], &ReadOptions::default()).unwrap();
    let warnings = crate::words(&warnings);
        prop_assert_eq!(&back, &set);
        prop_assert!(warnings.is_empty(), "{:?}", warnings);
    }

    #[test]
    fn no_text_makes_the_reader_panic(text in "(f,re,im\n)?([0-9eE+.,;# \
                                               =\tnaiZ:\"-]{0,12}\n){0,8}") {
        let _ = read(text);
    }
}

#[test]
fn own_tables_keep_gaps_and_say_what_they_cannot_hold() {
    let mut values = Array3::from_elem((2, 2, 3), c(1.0, 2.0));
    values
        .slice_mut(ndarray::s![0, 1, ..])
        .fill(c(f64::NAN, f64::NAN));
    values[[1, 0, 1]] = c(f64::NAN, f64::NAN);
    let mut set = small_set(values, true);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.csv");
    set.geometry.nodes.push(chladni_frf::Node {
        label: 1,
        xyz_m: [0.0; 3],
    });
    let lost = write_frf(&path, &set, false).unwrap();
    assert!(lost[0].contains("no geometry"), "{lost:?}");
    let text = std::fs::read_to_string(&path).unwrap();
    assert!(
        text.starts_with("# frf_kind = accelerance\n# unit = m/s^2/V\n"),
        "{text}"
    );
    assert!(
        text.contains("\nnode,dir,ref_node,ref_dir,f,re,im,coherence\n"),
        "{text}"
    );
    let (back, _, warnings) = read_frf(&[path], &ReadOptions::default()).unwrap();
    let warnings = crate::words(&warnings);
    set.geometry = Geometry::default();
    let measured = |set: &FrfSet| format!("{:?}", set.values);
    assert_eq!(measured(&back), measured(&set));
    let text = warnings.join("\n");
    assert!(
        text.contains("1 rows hold no finite value") && text.contains("1 of 4 pairs are missing"),
        "{text}"
    );
}

/// A measured file, of the project or beside it.
fn sample(name: &str) -> Option<PathBuf> {
    const PLACES: [&str; 2] = ["../../fixtures/measured", "../../../shared/data"];
    let of = |place: &str| {
        PathBuf::from(env!("CARGO_MANIFEST_DIR"))
            .join(place)
            .join(name)
    };
    let found = PLACES.into_iter().map(of).find(|path| path.exists());
    if found.is_none() {
        crate::skipped(&format!("no sample {name}"));
    }
    found
}

#[test]
fn a_measured_frf_with_coherence() {
    let Some(path) = sample("vtb-case1/case1_frf.csv") else {
        return;
    };
    let (set, _, warnings) =
        read_frf(std::slice::from_ref(&path), &ReadOptions::default()).unwrap();
    let warnings = crate::words(&warnings);
    assert_eq!(
        (set.frequency_hz.len(), set.frequency_hz[1600]),
        (1601, 500.0)
    );
    assert_eq!(set.values.get(0, 0, 1), c(-64.2635574, -37.0582924));
    let coherence = set.coherence.unwrap();
    assert!(coherence[[0, 0, 0]].is_nan() && (coherence[[0, 0, 1]] - 0.704_286_34).abs() < 1e-7);
    let text = warnings.join("\n");
    assert!(text.contains("0 Hz is outside"), "{text}");
    assert_eq!(
        read_document(&path, &ReadOptions::default())
            .unwrap()
            .datasets[0]
            .values,
        Some(1601)
    );
}

#[test]
fn lists_of_python_complex_numbers_are_refused_and_readable_as_columns() {
    let Some(path) = sample("pyuff-measured-beam-txt/meas_point_1.txt") else {
        return;
    };
    let error = read_frf(std::slice::from_ref(&path), &ReadOptions::default()).unwrap_err();
    assert!(
        error.to_string().contains("without a frequency axis"),
        "{error}"
    );
    let mut table = String::from("# frf_kind = accelerance\n# unit = m/s^2/N\nf,re,im\n");
    for (k, line) in std::fs::read_to_string(path).unwrap().lines().enumerate() {
        let inner = line.trim().trim_start_matches('(').trim_end_matches("j)");
        let cut = (1..inner.len())
            .rev()
            .find(|&at| "+-".contains(&inner[at..=at]) && !"eE".contains(&inner[at - 1..at]))
            .unwrap();
        table += &format!("{k},{},{}\n", &inner[..cut], &inner[cut..]);
    }
    let (set, _) = read(table).unwrap();
    assert_eq!(
        (set.frequency_hz.len(), set.kind),
        (1001, Some(FrfKind::Accelerance))
    );
    assert_eq!(
        set.values.get(0, 0, 0),
        c(-0.0774752256830106, 2.6838208936737454e-08)
    );
}

/// Files of one FRF each in a folder of their own, in this order.
fn written(texts: &[&str]) -> (tempfile::TempDir, Vec<PathBuf>) {
    let folder = tempfile::tempdir().unwrap();
    let path = |(k, text): (usize, &&str)| {
        let path = folder.path().join(format!("p{}.csv", k + 1));
        std::fs::write(&path, text).unwrap();
        path
    };
    let paths = texts.iter().enumerate().map(path).collect();
    (folder, paths)
}

const ONE: &str = "f,re,im\n1,2,3\n2,4,5\n";

#[test]
fn a_roving_hammer_is_declared_by_response_and_references() {
    let (_folder, paths) = written(&[ONE; 3]);
    let options = ReadOptions {
        responses: vec![5],
        references: vec![1, 2, 5],
        ..ReadOptions::default()
    };
    let (set, _, warnings) = read_frf(&paths, &options).unwrap();
    let warnings = crate::words(&warnings);
    assert_eq!(set.values.dim(), (1, 3, 2));
    assert_eq!(set.responses[0].to_string(), "5:+Z");
    assert_eq!(set.references[2].to_string(), "5:+Z");
    assert!(
        !warnings.join("\n").contains("response DOF"),
        "{warnings:?}"
    );
}

#[test]
fn a_guessed_response_is_no_driving_point() {
    let (_folder, paths) = written(&[ONE; 3]);
    let options = ReadOptions {
        references: vec![1, 2, 3],
        ..ReadOptions::default()
    };
    let (set, ..) = read_frf(&paths, &options).unwrap();
    for response in &set.responses {
        assert!(set
            .references
            .iter()
            .all(|reference| !response.same_axis(*reference)));
    }
}

#[test]
fn a_list_declares_the_dofs_of_every_frf() {
    let wide = "f,re1,im1,re2,im2\n1,2,3,4,5\n2,2,3,4,5\n";
    let (_folder, paths) = written(&[wide, ONE]);
    let with = |list: &str| ReadOptions {
        dofs: DeclaredDofs::parse(list).unwrap(),
        ..ReadOptions::default()
    };
    let (set, _, warnings) = read_frf(&paths, &with("5Z,101Z\n5Z,102Z\n5Z,103Z\n")).unwrap();
    let warnings = crate::words(&warnings);
    assert_eq!(set.values.dim(), (1, 3, 2));
    assert_eq!(set.values.get(0, 1, 0), c(4.0, 5.0));
    assert_eq!(set.references[2].to_string(), "103:+Z");
    assert!(!warnings.join("\n").contains("DOF"), "{warnings:?}");
    let by_file = "file,response,reference\np2.csv,7X,9Z\np1.csv,5Z,9Z\np1.csv,6Z,9Z\n";
    let (set, ..) = read_frf(&paths, &with(by_file)).unwrap();
    assert_eq!(set.responses[2].to_string(), "7:+X");
    for list in [
        "5Z,101Z\n",
        "5Z,101Z\n5Z,102Z\n5Z,103Z\n5Z,104Z\n",
        "p9.csv,1Z,2Z\n",
    ] {
        let error = read_frf(&paths, &with(list)).unwrap_err().to_string();
        assert!(error.contains("dofs"), "{error}");
    }
}

#[test]
fn hammer_records_need_no_time_column_and_units_may_stand_in_names() {
    let text = "force_N,acc_m_s2,Velocity (mm/s),weight\n1,2,3000,4\n5,6,7000,8\n";
    let (_folder, paths) = written(&[text]);
    let options = ReadOptions {
        sample_rate_hz: Some(48_000.0),
        ..ReadOptions::default()
    };
    let document = read_document(&paths[0], &options).unwrap();
    let channels: Vec<_> = document
        .functions
        .iter()
        .map(|function| {
            (
                function.response.to_string(),
                function.axes[1].unit.clone(),
                function.scale_to_si,
            )
        })
        .collect();
    let expected = [
        ("1:S", "N", 1.0),
        ("2:S", "m/s2", 1.0),
        ("3:S", "mm/s", 1e-3),
        ("4:S", "", 1.0),
    ];
    assert_eq!(channels.len(), expected.len());
    for ((dof, unit, scale), expected) in channels.iter().zip(expected) {
        assert_eq!((dof.as_str(), unit.as_str(), *scale), expected);
    }
    let warnings = crate::words(&document.warnings).join("\n");
    assert!(
        warnings.contains("column 4: no unit") && !warnings.contains("column 3"),
        "{warnings}"
    );
    // without the rate nobody takes the force for a frequency
    let error = read_document(&paths[0], &ReadOptions::default()).unwrap_err();
    assert!(error.to_string().contains("`sample_rate HZ`"), "{error}");
}
