//! NumPy files: NPZ (a zip archive of arrays) and NPY (one array).
//!
//! The format: NumPy enhancement proposal 1. Arrays of numbers, complex numbers and texts
//! are read in either byte order and either order of axes. Arrays of other types, such as
//! pickled objects, are named and not read.
//! Written are `freq`, `frf` [response, reference, line], `response` and `reference`
//! (DOFs as text), `frf_kind`, `reference_unit`, `unit`, `time_sign`, `axes`, and
//! `coherence` where there is one.

mod archive;
mod named;
mod npy;

pub(super) use archive::write;
pub use named::{write_npz, NamedArray};

use super::arrays::memory::MemoryFile;
use super::{Document, FileFormat, ReadOptions};
use chladni_frf::{Finding, Result};
use std::path::Path;

/// Reads one array. It is only listed: alone it has no frequency axis.
pub(super) fn read_npy(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<Document> {
    let mut arrays = MemoryFile::default();
    npy::read_array(bytes, "/array", &mut arrays).map_err(|error| error.file(path))?;
    if let Some(error) = arrays.largest_unread() {
        return Err(error.file(path));
    }
    let mut document = arrays.document(path, FileFormat::Numpy, options)?;
    if document.frf.is_none() {
        document.warnings.push(Finding::caution(
            "no-frequency-axis",
            "one array has no frequency axis beside it: save both with \
                                numpy.savez(file, frf=..., freq=...)",
        ));
    }
    Ok(document)
}

/// Reads an archive of arrays. One that is not read is an error only where no FRF is found.
pub(super) fn read_npz(bytes: &[u8], path: &Path, options: &ReadOptions) -> Result<Document> {
    let arrays = archive::read(bytes).map_err(|error| error.file(path))?;
    let unread = arrays.largest_unread().map(|error| error.file(path));
    let mut document = arrays.document(path, FileFormat::Numpy, options)?;
    if document.frf.is_none() && document.errors.is_empty() {
        document.errors.extend(unread);
    }
    Ok(document)
}
