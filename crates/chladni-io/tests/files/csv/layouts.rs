//! One FRF in every dialect; wide, long and spreadsheet tables of several.

use super::reading::{c, read, refusal, values};
use chladni_frf::{FrfKind, ReferenceUnit};

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
fn columns_that_belong_nowhere_are_named() {
    for (header, words) in [
        ("f,re,im,noise,offset", "column 4"),
        ("f,re,im,mag,phase", "occurs twice"),
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

/// Responses and references of a set, in its order.
fn dofs(text: &str) -> String {
    let (set, _) = read(text).unwrap();
    let listed = |dofs: &[chladni_frf::Dof]| {
        let texts: Vec<String> = dofs.iter().map(ToString::to_string).collect();
        texts.join(" ")
    };
    format!("{} | {}", listed(&set.responses), listed(&set.references))
}

#[test]
fn words_tell_responses_from_references_in_rows_and_names() {
    let rows = "1,1,2,3,4\n2,5,6,7,8\n";
    let names = "f,Re,Im,Re,Im\n";
    for header in [
        "Reference DOF,101:+Z,101:+Z,101:+Z,101:+Z\nResponse DOF,1:+Z,1:+Z,2:+Z,2:+Z\n",
        "Response DOF,1:+Z,1:+Z,2:+Z,2:+Z\nReference DOF,101:+Z,101:+Z,101:+Z,101:+Z\n",
        "Excitation,101Z,,101Z,\nResponse,1Z,,2Z,\n",
        // without words the response stands first
        ",1:+Z,1:+Z,2:+Z,2:+Z\n,101:+Z,101:+Z,101:+Z,101:+Z\n",
    ] {
        let text = format!("{header}{names}{rows}");
        assert_eq!(dofs(&text), "1:+Z 2:+Z | 101:+Z", "{header}");
    }
    for names in [
        "f,Ref 101:+Z Rsp 1:+Z Re,Ref 101:+Z Rsp 1:+Z Im,Ref 101:+Z Rsp 2:+Z Re,Ref 101:+Z Rsp 2:+Z Im\n",
        "f,Re from 101Z to 1Z,Im from 101Z to 1Z,Re from 101Z to 2Z,Im from 101Z to 2Z\n",
        "f,1Z 101Z Re,1Z 101Z Im,2Z 101Z Re,2Z 101Z Im\n",
    ] {
        assert_eq!(dofs(&format!("{names}{rows}")), "1:+Z 2:+Z | 101:+Z", "{names}");
    }
    let text = "f,Force 1Z Re,Force 1Z Im,Force 2Z Re,Force 2Z Im\n1,1,2,3,4\n2,5,6,7,8\n";
    assert_eq!(dofs(text), "1:S | 1:+Z 2:+Z");
    for name in ["1Z relative to 101Z", "1Z due to 101Z", "1Z ref 101Z"] {
        let text = format!("f,{name} Re,{name} Im\n1,1,2\n2,5,6\n");
        assert_eq!(dofs(&text), "1:+Z | 101:+Z", "{name}");
    }
    for name in ["Ref/Rsp 101Z/1Z", "1Z response 101Z"] {
        let text = refusal(format!("f,{name} Re,{name} Im\n1,1,2\n2,5,6\n"));
        assert!(
            text.contains("column 2") && text.contains("which DOF is the response"),
            "{text}"
        );
    }
}

#[test]
fn lower_case_dofs_along_x_stand_beside_other_words() {
    let one = "\n1,1,2\n2,5,6\n";
    let two = "\n1,1,2,3,4\n2,5,6,7,8\n";
    let three = "\n1,1,2,3,4,5,6\n2,5,6,7,8,9,9\n";
    for (names, rows, responses) in [
        (&["Acc 1x"][..], one, "1:+X"),
        (&["Acc 1x", "Acc 2x"], two, "1:+X 2:+X"),
        (&["Acc 1x", "Acc 1y", "Acc 1z"], three, "1:+X 1:+Y 1:+Z"),
        (&["Acc 10x 1Z", "Acc 10x 2Z"], two, "1:+Z 2:+Z"),
        (&["Acc 5s record 1z", "Acc 5s record 2z"], two, "1:+Z 2:+Z"),
        (&["Left 5s", "Right 5s"], two, "1:+Z 2:+Z"),
        (
            &["Left 10x", "Mid 10x", "Right 10x"],
            three,
            "1:+Z 2:+Z 3:+Z",
        ),
    ] {
        let pairs = names.iter().map(|name| format!(",{name} re,{name} im"));
        let text = format!("f{}{rows}", pairs.collect::<String>());
        assert_eq!(dofs(&text), format!("{responses} | 1:S"), "{text}");
    }
}

#[test]
fn a_row_of_dofs_counts_beside_one_that_holds_its_text() {
    let rows = "f,Re,Im\n1,1,2\n2,5,6\n";
    let text = format!("Response,1:+Z,1:+Z\nReference,101:+Z,101:+Z\n{rows}");
    assert_eq!(dofs(&text), "1:+Z | 101:+Z");
    // a driving point
    let text = format!("Response,1:+Z,1:+Z\nReference,1:+Z,1:+Z\n{rows}");
    assert_eq!(dofs(&text), "1:+Z | 1:+Z");
    // written twice it stays one DOF
    let text = "DOF,1:+Z,1:+Z\nf,1:+Z Re,1:+Z Im\n1,1,2\n2,5,6\n";
    assert_eq!(dofs(text), "1:+Z | 1:S");
    let text = format!("DOF,1:+Z,1:+Z\nDOF,1:+Z,1:+Z\n{rows}");
    assert_eq!(dofs(&text), "1:+Z | 1:S");
}

#[test]
fn the_frequency_of_a_long_table_wins_over_an_index_or_a_position() {
    for (header, more) in [
        ("response,reference,x,f [Hz],re,im", "7"),
        ("response,reference,freq bin,frequency [Hz],re,im", "7"),
        ("response,reference,x,y,f [Hz],re,im", "0.1,0.2"),
        ("response,reference,x [mm],Hz,re,im", "1"),
    ] {
        let text = format!("{header}\n1Z,9Z,{more},10,2,3\n1Z,9Z,{more},20,4,5\n");
        let (set, warnings) = read(&text).unwrap();
        assert_eq!(set.frequency_hz.to_vec(), [10.0, 20.0], "{header}");
        assert!(warnings.join("\n").contains("not used: `"), "{warnings:?}");
    }
    let (set, _) = read("response,reference,x,re,im\n1Z,9Z,10,2,3\n1Z,9Z,20,4,5\n").unwrap();
    assert_eq!(set.frequency_hz.to_vec(), [10.0, 20.0]);
    let text = "output,input,f,re,im\n1Z,9Z,10,2,3\n1Z,9Z,20,4,5\n";
    assert_eq!(dofs(text), "1:+Z | 9:+Z");
}
