//! Text datasets: fields, lines, counts, header text.

use super::layouts::layout;
use super::{
    binary_58, identifier, le64, lenient, only_error, only_function, options, read_with, text_58,
    ONES, SI_164, TWO_COMPLEX,
};
use chladni_frf::{FrfKind, ReferenceUnit};
use chladni_io::{read_frf, write_frf, Ordinate, ReadOptions};
use num_complex::Complex64;

#[test]
fn codes_dofs_and_axes_reach_the_function_and_the_listing() {
    let document = read_with([SI_164, &text_58(TWO_COMPLEX, ONES)].concat(), &options());
    let function = only_function(&document);
    assert_eq!(
        (function.kind, function.reference_unit),
        (Some(FrfKind::Mobility), ReferenceUnit::Newton)
    );
    assert_eq!(
        (
            function.response.to_string(),
            function.reference.to_string()
        ),
        ("5:+Z".into(), "101:+Z".into())
    );
    assert_eq!(
        (
            function.axes[1].quantity,
            function.axes[1].label.as_str(),
            function.axes[1].unit.as_str()
        ),
        (11, "Velocity", "m/s")
    );
    assert_eq!(
        (function.line, function.scale_to_si, function.abscissa_to_si),
        (7, 1.0, 1.0)
    );
    let info = &document.datasets[1];
    assert_eq!(
        (
            info.function.as_deref(),
            info.response.as_deref(),
            info.reference.as_deref()
        ),
        (Some("frf"), Some("5:+Z"), Some("101:+Z"))
    );
}

#[test]
fn negative_directions_are_kept() {
    let text = text_58(TWO_COMPLEX, ONES).replace(" 5   3 ", " 5  -3 ");
    assert_eq!(
        only_function(&read_with([SI_164, &text].concat(), &options()))
            .response
            .to_string(),
        "5:-Z"
    );
}

#[test]
fn touching_numbers_and_fortran_exponents_are_read() {
    let data = "-1.234567890123E-101-2.000000000000E-101  1.000000000000D+00    1.000000000000-2\n";
    let document = read_with([SI_164, &text_58(TWO_COMPLEX, data)].concat(), &options());
    let expected = vec![
        Complex64::new(-1.234567890123e-101, -2e-101),
        Complex64::new(1.0, 0.01),
    ];
    assert_eq!(
        only_function(&document).ordinate,
        Ordinate::Complex64(expected)
    );
}

#[test]
fn numbers_outside_their_columns_are_split_on_blanks_with_a_warning() {
    for data in ["1.0 2.0 3.0 4.0\n", "1.0\n2.0\n3.0\n4.0\n"] {
        let document = read_with([SI_164, &text_58(TWO_COMPLEX, data)].concat(), &options());
        let function = only_function(&document);
        assert_eq!(
            function.ordinate,
            Ordinate::Complex64(vec![Complex64::new(1.0, 2.0), Complex64::new(3.0, 4.0)])
        );
        assert!(
            function.warnings[0].contains("split on blanks"),
            "{:?}",
            function.warnings
        );
    }
}

#[test]
fn text_instead_of_a_number_is_refused_with_line_and_field() {
    let data = "  1.000000000000E+00                 abc  1.000000000000E+00  1.000000000000E+00\n";
    let document = read_with([SI_164, &text_58(TWO_COMPLEX, data)].concat(), &options());
    let error = only_error(&document);
    assert_eq!((error.dataset, error.line), (Some(58), Some(20)));
    assert_eq!(error.found.as_deref(), Some("abc"));
    assert!(
        error
            .field
            .as_ref()
            .unwrap()
            .contains("ordinate value 1, imaginary part"),
        "{error}"
    );
    assert!(error.help.is_some() && error.file.is_some());
    assert!(document.datasets[1].warnings[0].contains("line 20"));
    assert_eq!(
        document.datasets[1].response.as_deref(),
        Some("5:+Z"),
        "the header is listed all the same"
    );
}

#[test]
fn stars_nan_and_inf_are_refused_with_line_and_column_and_masked_when_lenient() {
    for word in [
        "********************",
        "                 NaN",
        "                 Inf",
    ] {
        let data = format!("  1.000000000000E+00  2.000000000000E+00{word}  4.000000000000E+00\n");
        let text = [SI_164, &text_58(TWO_COMPLEX, &data)].concat();
        let document = read_with(&text, &options());
        let message = only_error(&document).to_string();
        assert!(
            message.contains("line 20") && message.contains("columns 41 to 60"),
            "{message}"
        );

        let document = read_with(&text, &lenient());
        let function = only_function(&document);
        let Ordinate::Complex64(values) = &function.ordinate else {
            panic!("{:?}", function.ordinate)
        };
        assert_eq!(values[0], Complex64::new(1.0, 2.0));
        assert!(
            values[1].re.is_nan() && values[1].im.is_nan(),
            "the whole value is masked"
        );
        assert!(
            function.warnings.iter().any(|w| w.contains("masked")),
            "{:?}",
            function.warnings
        );
    }
}

#[test]
fn a_count_above_the_data_is_refused_with_both_numbers() {
    let text = text_58(
        "         6   2508876         1  1.00000E+00  5.00000E-01  0.00000E+00",
        ONES,
    );
    let message = only_error(&read_with(&text, &options())).to_string();
    assert!(message.contains("2508876 declared, 2 present"), "{message}");
    assert_eq!(
        only_function(&read_with(&text, &lenient())).ordinate.len(),
        2
    );
}

#[test]
fn a_count_that_no_memory_holds_is_refused() {
    let text = text_58(
        "         69007199254         1  1.00000E+00  5.00000E-01  0.00000E+00",
        "  1.0\n",
    );
    assert!(only_error(&read_with(&text, &options()))
        .to_string()
        .contains("9007199254 declared, 0 present"));
    let bytes = binary_58(
        &identifier(1, 16),
        "         69999999999         1  1.00000E+00  5.00000E-01  0.00000E+00",
        &le64(&[1.0, 2.0]),
        "    -1\n",
    );
    assert_eq!(read_with(bytes, &options()).errors.len(), 1);
}

#[test]
fn a_count_below_the_data_is_refused_with_both_numbers() {
    let data = ONES.repeat(2);
    let message = only_error(&read_with(text_58(TWO_COMPLEX, &data), &options())).to_string();
    assert!(message.contains("2 declared, 4 present"), "{message}");
}

#[test]
fn a_last_line_may_be_short_or_padded_with_blanks() {
    let record_7 = "         4         5         1  1.00000E+00  5.00000E-01  0.00000E+00";
    let first = "  1.000000000000E+00".repeat(4);
    for last in [
        "  5.000000000000E+00".to_string(),
        format!("  5.000000000000E+00{:60}", ""),
        "   5.0000000000E+00\n\n".to_string(),
    ] {
        let (_, ordinate) = layout(record_7, &format!("{first}\n{last}\n"));
        assert_eq!(ordinate, Ordinate::Real64(vec![1.0, 1.0, 1.0, 1.0, 5.0]));
    }
}

#[test]
fn a_line_in_the_middle_that_is_short_is_refused() {
    let data = "  1.000000000000E+00  1.000000000000E+00\n".repeat(2) + "  1.0\n";
    let text = text_58(
        "         4         9         1  1.00000E+00  5.00000E-01  0.00000E+00",
        &data,
    );
    let message = only_error(&read_with(text, &options())).to_string();
    assert!(
        message.contains("line 14") && message.contains("2 numbers"),
        "{message}"
    );
}

#[test]
fn a_blank_field_between_numbers_is_zero() {
    let (_, ordinate) = layout(
        "         4         3         1  1.00000E+00  5.00000E-01  0.00000E+00",
        "  1.000000000000E+00                      3.000000000000E+00\n",
    );
    assert_eq!(ordinate, Ordinate::Real64(vec![1.0, 0.0, 3.0]));
}

#[test]
fn line_ends_may_be_mixed() {
    let text = [SI_164, &text_58(TWO_COMPLEX, ONES)].concat();
    for mixed in [
        text.replace('\n', "\r\n"),
        text.replacen('\n', "\r\n", 9),
        text.replace("    -1\n", "    -1                    \r\n"),
    ] {
        assert_eq!(
            only_function(&read_with(&mixed, &options())).ordinate.len(),
            2
        );
    }
}

#[test]
fn header_text_may_be_latin_1_or_utf_8() {
    let text = text_58(TWO_COMPLEX, ONES)
        .replace("NONE\nNONE\nNONE\nNONE", "Übertragung\nNONE\nNONE\nNONE")
        .replace(
            "        11    0    0    0 Velocity             m/s    ",
            "        12    0    0    0 Acceleration         m/s²   ",
        );
    let utf_8 = [SI_164, &text].concat();
    let latin_1: Vec<u8> = utf_8.chars().map(|c| c as u8).collect();
    for bytes in [utf_8.into_bytes(), latin_1] {
        let document = read_with(bytes, &options());
        let function = only_function(&document);
        assert_eq!(
            (
                function.id_lines[0].as_str(),
                function.axes[1].unit.as_str()
            ),
            ("Übertragung", "m/s²")
        );
        assert_eq!(function.kind, Some(FrfKind::Accelerance));
    }
}

#[test]
fn a_dof_is_taken_from_the_entity_name_when_the_node_is_0() {
    let text = text_58(TWO_COMPLEX, ONES).replace(
        " NONE               5   3 NONE             101   3",
        " 12-X               0   0 Force              0   0",
    );
    let document = read_with([SI_164, &text].concat(), &options());
    let function = only_function(&document);
    assert_eq!(function.response.to_string(), "12:-X");
    assert!(
        function
            .warnings
            .iter()
            .any(|w| w.contains("12:-X is read from the entity name")),
        "{:?}",
        function.warnings
    );
    assert!(
        function
            .warnings
            .iter()
            .any(|w| w.contains("`reference N`")),
        "the reference is asked for: {:?}",
        function.warnings
    );
    let stated = ReadOptions {
        references: vec![101],
        ..options()
    };
    let document = read_with([SI_164, &text].concat(), &stated);
    let warnings = &only_function(&document).warnings;
    let asks = warnings
        .iter()
        .any(|w| w.contains("the reference node is 0"));
    assert!(!asks, "{warnings:?}");
}

#[test]
fn a_complex_spectrum_with_zero_imaginary_part_is_accepted() {
    let data = "  1.000000000000E+00  0.000000000000E+00  2.000000000000E+00  0.000000000000E+00\n";
    let text = text_58(TWO_COMPLEX, data).replacen("    4         0", "    9         0", 1);
    let document = read_with([SI_164, &text].concat(), &options());
    assert_eq!(only_function(&document).function_type, 9);
    assert_eq!(
        document.datasets[1].function.as_deref(),
        Some("power spectral density")
    );
}

/// Two functions of four lines; the second is cut behind its second line.
fn cut_short() -> String {
    let record_7 = TWO_COMPLEX.replace("         2         1", "         4         1");
    let second = text_58(&record_7, ONES).replace("               5   3 ", "               6   3 ");
    let whole = second.replace(&format!("{ONES}    -1\n"), ONES);
    assert_ne!(second, whole);
    [SI_164, &text_58(&record_7, &ONES.repeat(2)), &whole].concat()
}

#[test]
fn the_sound_part_of_a_function_that_is_cut_short_is_kept_where_asked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.unv");
    std::fs::write(&path, cut_short()).unwrap();
    assert!(read_frf(std::slice::from_ref(&path), &options()).is_err());
    let (set, _, warnings) = read_frf(&[path], &lenient()).unwrap();
    let warnings = crate::words(&warnings);
    assert_eq!(set.values.dim(), (2, 1, 4));
    let one = Complex64::new(1.0, 1.0);
    assert_eq!(set.values.frf(0, 0).to_vec(), [one; 4]);
    assert_eq!(set.values.get(1, 0, 1), one);
    assert!(set.values.get(1, 0, 2).re.is_nan());
    let text = warnings.join("\n");
    assert!(text.contains("ends after 2 of 4 lines"), "{text}");
}

#[test]
fn a_mark_of_utf_8_is_passed_over() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("marked.unv");
    let text = [SI_164, &text_58(TWO_COMPLEX, ONES)].concat();
    std::fs::write(&path, [b"\xef\xbb\xbf", text.as_bytes()].concat()).unwrap();
    let (set, ..) = read_frf(std::slice::from_ref(&path), &options()).unwrap();
    assert_eq!(set.values.dim(), (1, 1, 2));
    let wide: Vec<u8> = [0xfeff]
        .into_iter()
        .chain(text.encode_utf16())
        .flat_map(u16::to_le_bytes)
        .collect();
    std::fs::write(&path, wide).unwrap();
    let error = read_frf(&[path], &options()).unwrap_err().to_string();
    assert!(error.contains("universal file in UTF-16"), "{error}");
}

#[test]
fn six_digits_of_a_text_file_stay_six_in_a_table() {
    let folder = tempfile::tempdir().unwrap();
    let (path, table) = (folder.path().join("six.unv"), folder.path().join("six.csv"));
    let record_7 = TWO_COMPLEX.replacen("         6", "         5", 1);
    let data = "  1.23457E-03 -2.34568E+01  3.45679E-10  1.00000E-01\n";
    std::fs::write(&path, [SI_164, &text_58(&record_7, data)].concat()).unwrap();
    let (set, ..) = read_frf(&[path], &options()).unwrap();
    write_frf(&table, &set, false).unwrap();
    let text = std::fs::read_to_string(&table).unwrap();
    for row in [",1.0,0.00123457,-23.4568\n", ",1.5,3.45679e-10,0.1\n"] {
        assert!(text.contains(row), "{row}{text}");
    }
}

#[test]
fn a_reference_that_is_none_is_no_error() {
    for none in ["        -1   0\n", "         0   0\n"] {
        let text = text_58(TWO_COMPLEX, ONES).replace("       101   3\n", none);
        let document = read_with([SI_164, &text].concat(), &options());
        assert_eq!(only_function(&document).reference.to_string(), "0:S");
    }
}
