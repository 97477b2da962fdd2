//! Arrays by name, as `numpy.savez` writes them.

use super::npy;
use crate::atomic::{create_atomically, write_error};
use chladni_frf::Result;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// An array to be written.
#[derive(Debug, Clone)]
pub enum NamedArray<'a> {
    /// Numbers with the last axis contiguous, and the extent of each axis.
    Numbers(&'a [f64], Vec<usize>),
    /// Texts, along one axis.
    Texts(Vec<String>),
}

/// Writes arrays into an NPZ file, without time stamps.
///
/// # Errors
/// As [`crate::write_atomically`].
pub fn write_npz(path: &Path, arrays: &[(&str, NamedArray)], force: bool) -> Result<()> {
    create_atomically(path, force, |temporary| {
        let written = File::create(temporary)
            .and_then(|file| write_to(ZipWriter::new(BufWriter::new(file)), arrays));
        written.map_err(|error| write_error(&error, path))
    })
}

fn write_to(
    mut archive: ZipWriter<BufWriter<File>>,
    arrays: &[(&str, NamedArray)],
) -> io::Result<()> {
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .large_file(true);
    for (name, array) in arrays {
        archive
            .start_file(format!("{name}.npy"), options)
            .map_err(io::Error::other)?;
        match array {
            NamedArray::Numbers(values, shape) => {
                archive.write_all(&npy::header("<f8", shape))?;
                for value in *values {
                    archive.write_all(&value.to_le_bytes())?;
                }
            }
            NamedArray::Texts(texts) => write_texts(&mut archive, texts)?,
        }
    }
    archive
        .finish()
        .map_err(io::Error::other)?
        .into_inner()
        .map_err(io::IntoInnerError::into_error)?
        .sync_all()
}

fn write_texts(archive: &mut ZipWriter<BufWriter<File>>, texts: &[String]) -> io::Result<()> {
    let longest = texts.iter().map(|text| text.chars().count()).max();
    let width = longest.unwrap_or(0).max(1);
    archive.write_all(&npy::header(&format!("<U{width}"), &[texts.len()]))?;
    for text in texts {
        let padded = text.chars().map(u32::from).chain(std::iter::repeat(0));
        for unit in padded.take(width) {
            archive.write_all(&unit.to_le_bytes())?;
        }
    }
    Ok(())
}
