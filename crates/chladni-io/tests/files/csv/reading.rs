//! Tables read from their text.

use chladni_frf::{Error, ErrorKind, FrfSet};
use chladni_io::{read_frf, ReadOptions};
use num_complex::Complex64;

pub(super) fn read_with(
    text: impl AsRef<[u8]>,
    options: &ReadOptions,
) -> Result<(FrfSet, Vec<String>), Error> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.txt");
    std::fs::write(&path, text).unwrap();
    read_frf(&[path], options).map(|(set, _, warnings)| (set, crate::words(&warnings)))
}

pub(super) fn read(text: impl AsRef<[u8]>) -> Result<(FrfSet, Vec<String>), Error> {
    read_with(text, &ReadOptions::default())
}

#[track_caller]
pub(super) fn values(text: impl AsRef<[u8]>) -> (Vec<f64>, Vec<Complex64>) {
    let (set, _) = read(text).unwrap();
    (set.frequency_hz.to_vec(), set.values.frf(0, 0).to_vec())
}

pub(super) fn c(re: f64, im: f64) -> Complex64 {
    Complex64::new(re, im)
}

/// The error of a text, as the user sees it.
#[track_caller]
pub(super) fn refusal(text: impl AsRef<[u8]>) -> String {
    let error = read(text).unwrap_err();
    assert_eq!(error.kind, ErrorKind::BadData, "{error}");
    error.to_string()
}
