//! The eight data layouts of dataset 58, from literal text.

use super::{only_function, options, read_with, text_58, SI_164};
use chladni_io::{Abscissa, Ordinate};
use num_complex::{Complex32, Complex64};

const EVEN: Abscissa = Abscissa::Even {
    start: 1.0,
    step: 0.5,
};

pub fn layout(record_7: &str, data: &str) -> (Abscissa, Ordinate) {
    let document = read_with([SI_164, &text_58(record_7, data)].concat(), &options());
    let function = only_function(&document);
    assert_eq!(function.warnings, Vec::<chladni_frf::Finding>::new());
    assert_eq!(document.datasets[1].values, Some(function.ordinate.len()));
    (function.abscissa.clone(), function.ordinate.clone())
}

#[test]
fn case_1_real_single_even() {
    let data = "  1.00000E+00  2.00000E+00  3.00000E+00 -4.00000E+00  5.00000E+00  6.00000E+00\n  \
                7.00000E-01\n";
    let read = layout(
        "         2         7         1  1.00000E+00  5.00000E-01  0.00000E+00",
        data,
    );
    assert_eq!(
        read,
        (
            EVEN,
            Ordinate::Real32(vec![1.0, 2.0, 3.0, -4.0, 5.0, 6.0, 0.7])
        )
    );
}

#[test]
fn case_2_real_single_uneven() {
    let data = "  1.00000E+00  2.00000E+00  1.50000E+00 -4.00000E+00  3.00000E+00  6.00000E+00\n  \
                7.00000E+00  8.00000E+00\n";
    let read = layout(
        "         2         4         0  0.00000E+00  0.00000E+00  0.00000E+00",
        data,
    );
    assert_eq!(
        read,
        (
            Abscissa::Uneven(vec![1.0, 1.5, 3.0, 7.0]),
            Ordinate::Real32(vec![2.0, -4.0, 6.0, 8.0])
        )
    );
}

#[test]
fn case_3_complex_single_even() {
    let data = "  1.00000E+00  2.00000E+00  3.00000E+00 -4.00000E+00  5.00000E+00  6.00000E+00\n  \
                7.00000E+00  8.00000E+00\n";
    let read = layout(
        "         5         4         1  1.00000E+00  5.00000E-01  0.00000E+00",
        data,
    );
    let c = Complex32::new;
    assert_eq!(
        read,
        (
            EVEN,
            Ordinate::Complex32(vec![c(1.0, 2.0), c(3.0, -4.0), c(5.0, 6.0), c(7.0, 8.0)])
        )
    );
}

#[test]
fn case_4_complex_single_uneven() {
    let data = "  1.00000E+00  2.00000E+00  3.00000E+00  4.00000E+00 -5.00000E+00  6.00000E+00\n  \
                9.00000E+00  8.00000E+00  7.00000E+00\n";
    let read = layout(
        "         5         3         0  0.00000E+00  0.00000E+00  0.00000E+00",
        data,
    );
    let c = Complex32::new;
    assert_eq!(
        read,
        (
            Abscissa::Uneven(vec![1.0, 4.0, 9.0]),
            Ordinate::Complex32(vec![c(2.0, 3.0), c(-5.0, 6.0), c(8.0, 7.0)])
        )
    );
}

#[test]
fn case_5_real_double_even() {
    let data = "  1.234567890123E+00  2.000000000000E+00 -3.000000000000E+00  \
                4.000000000000E+00\n  5.000000000000E+00\n";
    let read = layout(
        "         4         5         1  1.00000E+00  5.00000E-01  0.00000E+00",
        data,
    );
    assert_eq!(
        read,
        (
            EVEN,
            Ordinate::Real64(vec![1.234567890123, 2.0, -3.0, 4.0, 5.0])
        )
    );
}

#[test]
fn case_6_real_double_uneven() {
    let data =
        "  1.00000E+00  1.234567890123E+00  2.00000E+00 -2.000000000000E+00\n  4.00000E+00  \
                3.000000000000E+00\n";
    let read = layout(
        "         4         3         0  0.00000E+00  0.00000E+00  0.00000E+00",
        data,
    );
    assert_eq!(
        read,
        (
            Abscissa::Uneven(vec![1.0, 2.0, 4.0]),
            Ordinate::Real64(vec![1.234567890123, -2.0, 3.0])
        )
    );
}

#[test]
fn case_7_complex_double_even() {
    let data =
        "  1.234567890123E+00 -2.000000000000E+00  3.000000000000E+00  4.000000000000E+00\n  \
         5.000000000000E+00  6.000000000000E+00\n";
    let read = layout(
        "         6         3         1  1.00000E+00  5.00000E-01  0.00000E+00",
        data,
    );
    let c = Complex64::new;
    assert_eq!(
        read,
        (
            EVEN,
            Ordinate::Complex64(vec![c(1.234567890123, -2.0), c(3.0, 4.0), c(5.0, 6.0)])
        )
    );
}

#[test]
fn case_8_complex_double_uneven() {
    let data = "  1.00000E+00  1.234567890123E+00 -2.000000000000E+00\n  3.00000E+00  \
                3.000000000000E+00  4.000000000000E+00\n";
    let read = layout(
        "         6         2         0  0.00000E+00  0.00000E+00  0.00000E+00",
        data,
    );
    let c = Complex64::new;
    assert_eq!(
        read,
        (
            Abscissa::Uneven(vec![1.0, 3.0]),
            Ordinate::Complex64(vec![c(1.234567890123, -2.0), c(3.0, 4.0)])
        )
    );
}
