//! Refusals with their words, and what is masked or left out instead.

use super::reading::{c, read, read_with, refusal};
use chladni_io::{read_document, Duplicates, ReadOptions};

#[test]
fn every_refusal_names_the_row_and_what_to_do() {
    for (text, words) in [
        ("f,re,im\n1,2,3\n1,2,3\n", &["line 3", "occurs twice"][..]),
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
            &["no FRF", "a time", "estimate FRFs first"],
        ),
        ("no numbers\nat all\n", &["line 1", "no row of numbers"]),
        ("# only = remarks\n", &["only comments"]),
        (
            "f [Hz],re [m/N],im [m/N]\n10.0,np.float64(1.0),np.float64(2.0)\n",
            &["line 2", "found 10.0,np.float64", "write plain numbers"],
        ),
        (
            "f,re,im\n\"1,000.5\",1,2\n\"1,001.5\",1,2\n",
            &["line 2", "no row of numbers", "separators of thousands"],
        ),
        ("f,re,im\nx,y,z\n", &["line 2", "rows like 10.5,0.1,-0.2"]),
        (
            "f,re,im\n-2,2,3\n-1,2,3\n",
            &["not negative", "expected frequencies of 0 or more"],
        ),
        (
            "# frf_kind = velocity\nf,re,im\n1,2,3\n",
            &["line 1", "frf_kind", "receptance, mobility or accelerance"],
        ),
        ("(1.5+2j)\n(2-3.5e-08j)\n", &["line 1", "Python", "f,re,im"]),
        (
            "f,H\n10.0,(2.9e-05+1.4e-03j)\n11.0,(3e-05+1e-03j)\n",
            &["line 2", "a complex number in one cell", "f,re,im"],
        ),
        (
            "10.0\t2.9e-05-1.4e-03i\n11.0\t3e-05+1e-03i\n",
            &["line 1", "a complex number in one cell"],
        ),
        (
            "f;re;im\n1.000;1,5;2,1\n1.001;1,7;3,1\n",
            &["line 2", "1.000;1,5;2,1", "one decimal sign"],
        ),
        (
            "node,ref,f,re,im\n1,101,10,1,2\n1,101,11,1,2\n",
            &["line 1", "without the column dir;", "node,dir,ref_node"],
        ),
        (
            "ref_node,node,f,re,im\n101,1,10,1,2\n101,1,11,1,2\n",
            &["line 1", "columns dir and ref_dir;"],
        ),
        (
            "from,to,f,re,im\n101Z,1Z,10,1,2\n101Z,1Z,11,1,2\n",
            &[
                "line 1",
                "columns response and reference;",
                "not understood: `from`, `to`;",
            ],
        ),
        (
            "point,x,y,f,re,im\n1,0.1,0.2,10,1,2\n1,0.1,0.2,11,1,2\n",
            &[
                "line 1",
                "response and reference;",
                "not understood: `point`, `x`, `y`;",
            ],
        ),
        (
            "Point,Frequency [Hz],Real,Imag\n1,10,1,2\n2,11,1,2\n",
            &["line 1", "leave the column `Point` out", "counts the rows"],
        ),
        (
            "response,reference,f,re,im\n1Z,9Z,2,1,2\n1Z,9Z,1,1,2\n",
            &["line 3", "falls", "sort the rows"],
        ),
        (
            "response,reference,f,re,im\n1Z,9Z,2,1,2\n1Z,9Z,2,1,2\n",
            &["line 3", "twice", "leave one of the two rows out"],
        ),
        (
            "Time (s)\tForce (lbf)\n0\t1\t2\n0.1\t1\t2\n",
            &["line 1", "begins with a time", "3 names"],
        ),
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
        (
            "Frequenza;Real;Imaginario\n1;2;3\n2;3;4\n",
            &["column 3", "Imaginario", "does not say what it holds"],
        ),
        (
            "f1,re1,im1,f2,re2,im2\n1,2,3,1,2,3\n2,2,3,2,2,3\n",
            &["column 4", "f2", "second frequency column"],
        ),
        (
            "response,reference,w,re,im\n1Z,9Z,1,2,3\n1Z,9Z,2,2,3\n",
            &["column 3", "unit of the frequency", "`f [Hz]`"],
        ),
        (
            "f;re;im\n990;1;2\n1,000.00;1;2\n",
            &["line 3", "1,000.00", "separators of thousands"],
        ),
        (
            "f;re;im\n1;1;2\nx;1;2\n",
            &["line 3", "found x", "each needs its frequency"],
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
        text.contains("masked, since no finite number: 1 cell (first in line 3)")
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
fn missing_rows_and_cells_are_masked_and_reported() {
    let long = "node,dir,ref_node,ref_dir,f,re,im\n1,3,9,3,1,1,2\n1,3,9,3,2,3,4\n1,3,9,3,3,3,4\n2,3,9,3,1,5,6\n2,3,9,3,3,7,NaN\n";
    let (set, warnings) = read(long).unwrap();
    assert!(set.values.get(1, 0, 1).re.is_nan() && set.values.get(1, 0, 2).re.is_nan());
    let text = warnings.join("\n");
    assert!(
        text.contains("masked, since missing: 1 row (pair and frequency)")
            && text.contains("first in line 6"),
        "{text}"
    );
    let (set, warnings) = read("f,re,im\n1,2,\n2,3,4\n").unwrap();
    assert!(set.values.get(0, 0, 0).re.is_nan() && set.values.get(0, 0, 0).im.is_nan());
    assert!(
        warnings
            .join("\n")
            .contains("masked, since empty or NaN: 1 cell (first in line 2)"),
        "{warnings:?}"
    );
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
fn lenient_is_no_advice_for_the_frequency() {
    for text in [
        "f;re;im\n990;1;2\n1,000.00;1;2\n",
        "response;reference;f;re;im\n1Z;2Z;990;1;2\n1Z;2Z;1'000;1;2\n",
        "f;re;im\n1;1;2\nx;1;2\n",
    ] {
        let message = refusal(text);
        assert!(!message.contains("lenient"), "{message}");
    }
}

/// The findings about a text that is no FRF, or the error.
fn record_findings(text: &str) -> Result<(usize, Vec<String>), String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("record.csv");
    std::fs::write(&path, text).unwrap();
    let document = read_document(&path, &ReadOptions::default());
    let document = document.map_err(|error| error.to_string())?;
    assert!(document.frf.is_none(), "{text}");
    Ok((document.functions.len(), crate::words(&document.warnings)))
}

#[test]
fn a_header_that_begins_with_a_time_makes_a_record_between_any_delimiters() {
    let columns = ["Time (s)", "Force (lbf)", "Velocity (in/s)"];
    for delimiter in ["\t", ",", ";"] {
        let rows = ["0", "1e-3", "2e-3"].map(|t| [t, "7.5e-2", "6.25e-3"].join(delimiter));
        let header = columns.join(delimiter);
        let (functions, findings) =
            record_findings(&format!("{header}\n{}\n", rows.join("\n"))).unwrap();
        assert_eq!(functions, 2, "{header}");
        let text = findings.join("\n");
        assert!(!text.contains("unit"), "{header}: {text}");
    }
    let units = "a\tb\tc\ns\tN\tm/s\n0\t1\t2\n1e-3\t1\t3\n";
    assert_eq!(record_findings(units).unwrap().0, 2);
}

#[test]
fn errors_about_records_say_the_next_step() {
    for (text, words) in [
        ("t [s],1:+Z [N],2:+Z [m/s]\n0,1,2\n0,1,2\n", "more digits"),
        ("t [s],1:+Z [N],2:+Z [m/s]\n0,1,2\n1,NaN,2\n", "gap"),
    ] {
        let error = record_findings(text).unwrap_err();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn a_delimiter_at_the_end_of_each_row_masks_nothing() {
    let (set, findings) = read("f,re,im,\n1,2,3,\n2,4,5,\n").unwrap();
    assert_eq!(set.values.get(0, 0, 1), c(4.0, 5.0));
    assert!(!findings.join("\n").contains("masked"), "{findings:?}");
    let (_, findings) = read("f,re,im,\n1,2,3,\n2,4,,\n").unwrap();
    let text = findings.join("\n");
    assert!(
        text.contains("masked, since empty or NaN: 1 cell"),
        "{text}"
    );
}

#[test]
fn a_table_cut_within_its_last_number_is_named() {
    let rows: String = (10..21).map(|f| format!("{f},1.5e-3,2.5e-4\n")).collect();
    let long = |row: &str| format!("1Z,9Z,{row}\n");
    let long_rows: String = rows.lines().map(long).collect();
    for whole in [
        format!("f,re,im\n{rows}21,1.5e-3,2.5"),
        format!("response,reference,f,re,im\n{long_rows}1Z,9Z,21,1.5e-3,2.5"),
    ] {
        let (_, findings) = read(&whole).unwrap();
        let text = findings.join("\n");
        assert!(
            text.contains("ends with `2.5`") && text.contains("may be cut"),
            "{text}"
        );
        let (_, findings) = read(whole + "e-4").unwrap();
        assert!(!findings.join("\n").contains("cut"), "{findings:?}");
    }
}

#[test]
fn remarks_beside_a_header_leave_a_good_table_as_it_is() {
    let rows = "50,-40.5,8.5\n51,-38.5,3.5\n";
    for above in [
        "# Input: force at 101:+Z, output: velocity, freq 0-100 Hz, Re, Im\nf,re,im",
        "# Input force, frequency axis in Hz, Real part, Imaginary part\nf,re,im",
        "Columns: frequency, real, imag, of the input at node 3\nf,re,im",
        "# one row per line, frequency, real part, imaginary part, input 101:+Z\nf,re,im",
        "# reference, frequency, real, imag\nf,re,im",
        "f,re,im\n# Time zone: CET",
        "f,re,im\n# Time, place, name",
        "Time window: Hann\nf,re,im",
    ] {
        for delimiter in [",", "\t"] {
            let table = format!("{above}\n{}", rows.replace(',', delimiter));
            let (set, _) = read(&table).unwrap_or_else(|error| panic!("{above}: {error}"));
            assert_eq!(set.values.get(0, 0, 1), c(-38.5, 3.5), "{above}");
        }
    }
}

#[test]
fn prose_that_begins_with_a_time_is_no_header() {
    let rows = |delimiter: &str| {
        let row = |k: usize| [format!("{k}"), "1327.5".into(), format!("{k}88.5")].join(delimiter);
        (50..70).map(row).collect::<Vec<_>>().join("\n")
    };
    for prose in [
        "Time averaged",
        "Measurement\nTime: morning",
        "Time:\tmorning",
        "Time window Hann",
        "Time Stamp May",
        "Time in s",
        "Min (s) averaged",
    ] {
        for delimiter in ["\t", " "] {
            let table = format!("{prose}\n{}\n", rows(delimiter));
            let told = match read(&table) {
                Ok((set, _)) => {
                    assert_eq!(set.values.get(0, 0, 0), c(1327.5, 5088.5), "{prose}");
                    continue;
                }
                Err(error) => error,
            };
            assert!(
                told.message.contains("magnitude and phase"),
                "{prose}: {told}"
            );
        }
    }
}

#[test]
fn prose_above_a_record_of_a_given_rate_is_no_header() {
    let options = ReadOptions {
        sample_rate_hz: Some(1000.0),
        ..ReadOptions::default()
    };
    for prose in ["Time domain data", "Time data", "Time (s) of the record"] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("record.txt");
        std::fs::write(&path, format!("{prose}\n2.5\t-0.5\n0.5\t0.25\n1\t2\n")).unwrap();
        let document = read_document(&path, &options).unwrap();
        assert_eq!(document.functions.len(), 2, "{prose}");
    }
}

#[test]
fn complete_last_numbers_are_no_cut() {
    for (above, last) in [
        ("8.1083e-10", "0.0000e+0"),
        ("0.998", "1"),
        ("\"8.442\"", "\"2\""),
        ("2.0749E-10", "1.1234E-9"),
    ] {
        let rows: String = (10..30).map(|f| format!("{f},1.5e-3,{above}\n")).collect();
        let (_, findings) = read(format!("f,re,im\n{rows}31,1.5e-3,{last}")).unwrap();
        assert!(!findings.join("\n").contains("cut"), "{findings:?}");
    }
}
