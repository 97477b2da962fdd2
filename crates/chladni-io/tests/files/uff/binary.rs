//! Binary dataset 58 and the mistakes of its writers.

use super::{
    binary_58, complex_pairs, identifier, le64, lenient, only_error, only_function, options,
    read_with, ID_LINES, NUMBERS, SI_164, TWO_COMPLEX,
};
use chladni_io::{Abscissa, Ordinate};
use num_complex::{Complex32, Complex64};

#[test]
fn both_byte_orders_are_read() {
    let big: Vec<u8> = NUMBERS.iter().flat_map(|v| v.to_be_bytes()).collect();
    for (order, payload) in [(1, le64(&NUMBERS)), (2, big)] {
        let document = read_with(
            binary_58(&identifier(order, 32), TWO_COMPLEX, &payload, "    -1\n"),
            &options(),
        );
        assert_eq!(only_function(&document).ordinate, complex_pairs());
        assert_eq!(
            only_function(&document).warnings,
            Vec::<chladni_frf::Finding>::new()
        );
    }
}

#[test]
fn single_precision_is_kept_single() {
    let payload: Vec<u8> = [1.5f32, -2.25, 0.1, 3.0]
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let record_7 = "         5         2         1  1.00000E+00  5.00000E-01  0.00000E+00";
    let document = read_with(
        binary_58(&identifier(1, 16), record_7, &payload, "    -1\n"),
        &options(),
    );
    assert_eq!(
        only_function(&document).ordinate,
        Ordinate::Complex32(vec![Complex32::new(1.5, -2.25), Complex32::new(0.1, 3.0)])
    );
}

#[test]
fn a_line_end_between_payload_and_marker_is_skipped() {
    for end in [
        "\n    -1\n",
        "\r\n    -1\r\n",
        "    -1",
        "\n\n    -1     \n    -1\n   151\n    -1\n",
    ] {
        let document = read_with(
            binary_58(&identifier(1, 32), TWO_COMPLEX, &le64(&NUMBERS), end),
            &options(),
        );
        assert_eq!(
            only_function(&document).ordinate,
            complex_pairs(),
            "{end:?}"
        );
        assert_eq!(
            document.datasets.len(),
            if end.contains("151") { 3 } else { 2 }
        );
    }
}

#[test]
fn a_header_with_crlf_is_read() {
    let text = String::from_utf8(binary_58(&identifier(1, 32), TWO_COMPLEX, &[], ""))
        .unwrap()
        .replace('\n', "\r\n");
    let bytes = [text.as_bytes(), &le64(&NUMBERS), b"    -1\r\n"].concat();
    assert_eq!(
        only_function(&read_with(bytes, &options())).ordinate,
        complex_pairs()
    );
}

#[test]
fn a_wrong_byte_count_is_reported_and_the_computed_one_used() {
    let document = read_with(
        binary_58(&identifier(1, 16), TWO_COMPLEX, &le64(&NUMBERS), "    -1\n"),
        &options(),
    );
    assert_eq!(only_function(&document).ordinate, complex_pairs());
    assert!(
        only_function(&document).warnings[0].contains("16 bytes"),
        "{:?}",
        only_function(&document).warnings
    );
}

#[test]
fn single_type_with_double_payload_is_diagnosed_and_read_only_when_lenient() {
    let record_7 = "         5         2         1  1.00000E+00  5.00000E-01  0.00000E+00";
    let bytes = binary_58(
        &identifier(1, 16),
        record_7,
        &le64(&NUMBERS),
        "    -1\n    -1\n   151\n    -1\n",
    );
    let document = read_with(&bytes, &options());
    let message = only_error(&document).to_string();
    assert!(
        message.contains("single precision") && message.contains("double precision"),
        "{message}"
    );
    assert_eq!(document.datasets.len(), 3, "what follows is listed");
    let document = read_with(&bytes, &lenient());
    assert_eq!(only_function(&document).ordinate, complex_pairs());
}

#[test]
fn the_bytes_of_a_marker_inside_the_payload_end_nothing() {
    let marker = f64::from_le_bytes(*b"    -1\n ");
    let closing = f64::from_le_bytes(*b"\n    -1\n");
    let values = [1.0, marker, closing, marker];
    let document = read_with(
        binary_58(&identifier(1, 32), TWO_COMPLEX, &le64(&values), "    -1\n"),
        &options(),
    );
    let expected = vec![Complex64::new(1.0, marker), Complex64::new(closing, marker)];
    assert_eq!(
        only_function(&document).ordinate,
        Ordinate::Complex64(expected)
    );
}

#[test]
fn uneven_doubles_are_read_with_a_single_or_a_double_abscissa() {
    let record_7 = "         6         2         0  0.00000E+00  0.00000E+00  0.00000E+00";
    let double = le64(&[1.0, 1.5, -2.25, 4.0, 1e-300, 3.0]);
    let mut single = Vec::new();
    for (x, y) in [(1.0f32, [1.5, -2.25]), (4.0, [1e-300, 3.0])] {
        single.extend(x.to_le_bytes());
        single.extend(le64(&y));
    }
    for (payload, declared) in [(&double, 48), (&single, 40), (&double, 0), (&single, 0)] {
        let document = read_with(
            binary_58(&identifier(1, declared), record_7, payload, "    -1\n"),
            &options(),
        );
        let function = only_function(&document);
        assert_eq!(
            (&function.abscissa, &function.ordinate),
            (&Abscissa::Uneven(vec![1.0, 4.0]), &complex_pairs())
        );
    }
    let record_7 = record_7.replacen('6', "4", 1);
    let real = [
        1.0f32.to_le_bytes().to_vec(),
        le64(&[7.5]),
        4.0f32.to_le_bytes().to_vec(),
        le64(&[8.5]),
    ]
    .concat();
    let document = read_with(
        binary_58(&identifier(1, 24), &record_7, &real, "    -1\n"),
        &options(),
    );
    assert_eq!(
        only_function(&document).ordinate,
        Ordinate::Real64(vec![7.5, 8.5])
    );
}

#[test]
fn a_binary_count_that_disagrees_with_the_data_is_refused_with_both_numbers() {
    let record_7 = "         6   2508876         1  1.00000E+00  5.00000E-01  0.00000E+00";
    let bytes = binary_58(&identifier(1, 32), record_7, &le64(&NUMBERS), "    -1\n");
    let message = only_error(&read_with(&bytes, &options())).to_string();
    assert!(message.contains("2508876 declared, 2 present"), "{message}");
    assert_eq!(
        only_function(&read_with(&bytes, &lenient())).ordinate,
        complex_pairs()
    );
}

#[test]
fn a_binary_dataset_cut_short_is_refused_and_sound_ones_stand_beside_it() {
    let bytes = [
        SI_164.as_bytes(),
        &binary_58(&identifier(1, 32), TWO_COMPLEX, &le64(&NUMBERS[..3]), ""),
    ]
    .concat();
    let document = read_with(bytes, &options());
    let error = only_error(&document);
    assert!(
        error.byte.is_some() && error.to_string().contains("24 bytes left"),
        "{error}"
    );
    assert_eq!(document.datasets.len(), 3);
    assert!(!document.datasets[2].warnings.is_empty());
}

#[test]
fn a_binary_file_without_its_last_marker_is_refused_unless_lenient() {
    let bytes = binary_58(&identifier(1, 32), TWO_COMPLEX, &le64(&NUMBERS), "");
    assert!(only_error(&read_with(&bytes, &options())).help.is_some());
    assert_eq!(
        only_function(&read_with(&bytes, &lenient())).ordinate,
        complex_pairs()
    );
}

#[test]
fn a_binary_header_that_ends_early_hides_nothing_behind_it() {
    let cut = format!("{SI_164}    -1\n    58b{}\n{ID_LINES}", identifier(1, 32));
    let whole = binary_58(&identifier(1, 32), TWO_COMPLEX, &le64(&NUMBERS), "    -1\n");
    let document = read_with(
        [cut.as_bytes(), &whole[SI_164.len()..]].concat(),
        &options(),
    );
    assert_eq!((document.errors.len(), document.functions.len()), (1, 1));
    assert!(
        document.errors[0].to_string().contains("record 6"),
        "{}",
        document.errors[0]
    );
}

#[test]
fn nan_and_infinity_in_binary_data_are_masked_and_reported() {
    let payload = le64(&[1.0, 2.0, f64::NAN, 4.0]);
    let document = read_with(
        binary_58(&identifier(1, 32), TWO_COMPLEX, &payload, "    -1\n"),
        &options(),
    );
    let function = only_function(&document);
    let Ordinate::Complex64(values) = &function.ordinate else {
        panic!()
    };
    assert!(values[0].is_finite() && values[1].re.is_nan() && values[1].im.is_nan());
    assert!(
        function.warnings[0].contains("masked"),
        "{:?}",
        function.warnings
    );
}

#[test]
fn dec_and_ibm_floats_are_refused_by_name() {
    for (format, name) in [(1, "DEC VMS"), (3, "IBM 370")] {
        let identifier = identifier(1, 32).replacen("     2 ", &format!("     {format} "), 1);
        let document = read_with(
            binary_58(&identifier, TWO_COMPLEX, &le64(&NUMBERS), "    -1\n"),
            &options(),
        );
        assert!(only_error(&document).to_string().contains(name));
    }
}
