//! A zip archive of arrays, as `numpy.savez` and `savez_compressed` write it.

use super::npy;
use crate::arrays::memory::MemoryFile;
use crate::arrays::tree::check_nesting;
use crate::atomic::{create_atomically, write_error};
use crate::limits::{ARCHIVE_LEAST_ROOM, ARCHIVE_MOST_EXPANSION};
use chladni_frf::{Error, Finding, FrfSet, FrfValues, Result};
use std::fs::File;
use std::io::{self, BufWriter, Cursor, Read, Write};
use std::path::Path;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

fn damaged(error: impl std::fmt::Display) -> Error {
    let error = Error::bad_data("the archive is damaged")
        .field("zip archive")
        .found(error)
        .expected("arrays saved by numpy.savez");
    error.help(
        "the file is cut short or was changed by a text transfer; copy it again in binary mode",
    )
}

/// All arrays of an archive.
///
/// # Errors
/// A damaged archive or array; a larger unpacked size than plausible.
pub(super) fn read(bytes: &[u8]) -> Result<MemoryFile> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(damaged)?;
    let mut arrays = MemoryFile::default();
    let limit = (bytes.len() as u64)
        .saturating_mul(ARCHIVE_MOST_EXPANSION)
        .max(ARCHIVE_LEAST_ROOM);
    let mut left = limit;
    check_nesting("/", 0, archive.len())?;
    for k in 0..archive.len() {
        let mut member = archive.by_index(k).map_err(damaged)?;
        let name = member.name().map_err(damaged)?.into_owned();
        let Some(stem) = name.strip_suffix(".npy") else {
            arrays.warnings.push(Finding::note(
                "not-read",
                format!("{name}: no array, not read"),
            ));
            continue;
        };
        let mut content = Vec::new();
        member
            .by_ref()
            .take(left + 1)
            .read_to_end(&mut content)
            .map_err(|error| damaged(error).field(&name))?;
        let unfolded = content.len() as u64;
        if unfolded > left {
            return Err(
                Error::bad_data("the archive unfolds to more than is plausible")
                    .field(&name)
                    .found(format!("more than {limit} bytes"))
                    .expected(format!(
                        "at most {ARCHIVE_MOST_EXPANSION} times the file's size"
                    ))
                    .help(
                        "save it with numpy.savez (not compressed) if it really holds that many \
                       equal values",
                    ),
            );
        }
        left -= unfolded;
        let path: String = stem
            .chars()
            .map(|c| if c.is_control() { '_' } else { c })
            .collect();
        npy::read_array(
            &content,
            &format!("/{}", path.trim_start_matches('/')),
            &mut arrays,
        )
        .map_err(|error| error.field(&name))?;
    }
    Ok(arrays)
}

/// Writes a set, atomically, with exact values and without geometry.
///
/// # Errors
/// As [`create_atomically`].
pub(crate) fn write(path: &Path, set: &FrfSet, force: bool) -> Result<()> {
    create_atomically(path, force, |temporary| {
        let written = File::create(temporary)
            .and_then(|file| write_to(ZipWriter::new(BufWriter::new(file)), set));
        written.map_err(|error| write_error(&error, path))
    })
}

fn write_to(zip: ZipWriter<BufWriter<File>>, set: &FrfSet) -> io::Result<()> {
    let (responses, references, lines) = set.values.dim();
    let shape = [responses, references, lines];
    let mut archive = Archive { zip };
    let frequencies = set.frequency_hz.iter();
    archive.numbers(
        "freq",
        "<f8",
        &[lines],
        frequencies.map(|f| f.to_le_bytes()),
    )?;
    match &set.values {
        FrfValues::F64(values) => {
            let parts = values.iter().flat_map(|v| [v.re, v.im]);
            archive.numbers("frf", "<c16", &shape, parts.map(f64::to_le_bytes))?;
        }
        FrfValues::F32(values) => {
            let parts = values.iter().flat_map(|v| [v.re, v.im]);
            archive.numbers("frf", "<c8", &shape, parts.map(f32::to_le_bytes))?;
        }
    }
    if let Some(coherence) = &set.coherence {
        let values = coherence.iter().map(|v| v.to_le_bytes());
        archive.numbers("coherence", "<f4", &shape, values)?;
    }
    let dofs = |dofs: &[chladni_frf::Dof]| dofs.iter().map(ToString::to_string).collect::<Vec<_>>();
    archive.texts("response", &dofs(&set.responses), &[responses])?;
    archive.texts("reference", &dofs(&set.references), &[references])?;
    archive.texts("reference_unit", &[set.reference_unit.to_string()], &[])?;
    archive.texts("time_sign", &["+".to_owned()], &[])?;
    archive.texts("axes", &["response-reference-line".to_owned()], &[])?;
    if let Some(kind) = set.kind {
        archive.texts("frf_kind", &[kind.to_string()], &[])?;
        archive.texts("unit", &[kind.unit(set.reference_unit)], &[])?;
    }
    archive
        .zip
        .finish()
        .map_err(io::Error::other)?
        .into_inner()
        .map_err(io::IntoInnerError::into_error)?
        .sync_all()
}

/// An archive that is being written.
struct Archive {
    zip: ZipWriter<BufWriter<File>>,
}

impl Archive {
    /// An array of numbers, as their bytes.
    fn numbers<const N: usize>(
        &mut self,
        name: &str,
        code: &str,
        shape: &[usize],
        mut numbers: impl Iterator<Item = [u8; N]>,
    ) -> io::Result<()> {
        // no time stamp: the same data give the same bytes
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .large_file(true);
        self.zip
            .start_file(format!("{name}.npy"), options)
            .map_err(io::Error::other)?;
        self.zip.write_all(&npy::header(code, shape))?;
        numbers.try_for_each(|bytes| self.zip.write_all(&bytes))
    }

    /// An array of texts, each as long as the longest.
    fn texts(&mut self, name: &str, texts: &[String], shape: &[usize]) -> io::Result<()> {
        let lengths = texts.iter().map(|text| text.chars().count());
        let width = lengths.max().unwrap_or(0).max(1);
        let units = texts.iter().flat_map(|text| {
            let padding = std::iter::repeat(0);
            text.chars().map(u32::from).chain(padding).take(width)
        });
        let code = format!("<U{width}");
        self.numbers(name, &code, shape, units.map(u32::to_le_bytes))
    }
}
