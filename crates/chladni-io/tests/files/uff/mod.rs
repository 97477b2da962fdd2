//! Universal files through the public door: layouts, traps of real files, damaged files,
//! round trips.

mod binary;
mod container;
mod layouts;
mod round_trip;
mod samples;
mod shapes;
mod text;
mod units;

use chladni_frf::Error;
use chladni_io::uff::read;
use chladni_io::{Document, Function, Ordinate, ReadOptions};
use num_complex::Complex64;
use std::path::Path;

pub(crate) const HEADER_151: &str = "    -1\n   151\nNONE\nNONE\nNONE\n\n\nNONE\n\n    -1\n";
pub(crate) const SI_164: &str = "    -1\n   164\n         1SI                           2\n  \
                                 1.00000000000000000D+00  1.00000000000000000D+00  \
                                 1.00000000000000000D+00\n  2.73149999999999980D+02\n    -1\n";
/// One data line of two complex doubles, or four real ones.
pub(crate) const ONES: &str =
    "  1.000000000000E+00  1.000000000000E+00  1.000000000000E+00  1.000000000000E+00\n";
pub(crate) const ID_LINES: &str = "NONE\nNONE\nNONE\nNONE\nNONE\n";
pub(crate) const RECORD_6: &str =
    "    4         0    0         0 NONE               5   3 NONE             101   3\n";
pub(crate) const MOBILITY_AXES: &str = "        18    0    0    0 Frequency            \
                                        Hz                  \n        11    0    0    0 \
                                        Velocity             m/s                 \n        13    \
                                        0    0    0 Force                N                   \
                                        \n         0    0    0    0 NONE                 \
                                        NONE                \n";

pub(crate) fn options() -> ReadOptions {
    ReadOptions::default()
}
pub(crate) fn lenient() -> ReadOptions {
    ReadOptions {
        lenient: true,
        ..options()
    }
}
pub(crate) fn read_with(bytes: impl AsRef<[u8]>, options: &ReadOptions) -> Document {
    read(bytes.as_ref(), Path::new("test.uff"), options).unwrap()
}
/// A text 58 of mobility with the given record 7 and data lines.
pub(crate) fn text_58(record_7: &str, data: &str) -> String {
    format!("    -1\n    58\n{ID_LINES}{RECORD_6}{record_7}\n{MOBILITY_AXES}{data}    -1\n")
}
/// A binary 58 with the given identifier numbers, record 7 and payload.
pub(crate) fn binary_58(identifier: &str, record_7: &str, payload: &[u8], end: &str) -> Vec<u8> {
    let head = format!(
        "{SI_164}    -1\n    58b{identifier}\n{ID_LINES}{RECORD_6}{record_7}\n{MOBILITY_AXES}"
    );
    [head.as_bytes(), payload, end.as_bytes()].concat()
}
pub(crate) fn identifier(order: usize, bytes: usize) -> String {
    format!("{order:6}     2          11{bytes:12}     0     0           0           0")
}
pub(crate) fn only_function(document: &Document) -> &Function {
    assert_eq!(document.errors, [], "{:?}", document.errors);
    assert_eq!(document.functions.len(), 1);
    &document.functions[0]
}
pub(crate) fn only_error(document: &Document) -> &Error {
    assert_eq!(document.errors.len(), 1, "{:?}", document.errors);
    assert_eq!(document.functions.len(), 0);
    &document.errors[0]
}
pub(crate) fn le64(values: &[f64]) -> Vec<u8> {
    values.iter().flat_map(|v| v.to_le_bytes()).collect()
}

pub(crate) const TWO_COMPLEX: &str =
    "         6         2         1  1.00000E+00  5.00000E-01  0.00000E+00";
pub(crate) const NUMBERS: [f64; 4] = [1.5, -2.25, 1e-300, 3.0];

pub(crate) fn complex_pairs() -> Ordinate {
    Ordinate::Complex64(vec![
        Complex64::new(1.5, -2.25),
        Complex64::new(1e-300, 3.0),
    ])
}
