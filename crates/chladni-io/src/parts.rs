//! FRFs of files that do not fit into memory, part by part.
//!
//! Our own HDF5 layout is cut between responses, a universal file between functions; any
//! other file is one part. A part is read and checked like a file of its own.

use super::assemble;
use super::{detect_format, hdf5, read_documents, uff, Checksums, FileFormat, ReadOptions, Turn};
use chladni_frf::{Error, Finding, FrfSet, FrfValues, Result};
use chladni_text::door::KeptInputs;
use chladni_text::door::{self, size_of};
use std::io::{Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Files whose FRFs can be read part by part.
#[derive(Debug, Clone)]
pub struct FrfParts {
    files: Vec<Parted>,
    options: ReadOptions,
    kept: KeptInputs,
}

/// A file, and the share of it that belongs to the set.
#[derive(Debug, Clone)]
struct Parted {
    path: PathBuf,
    /// Place among the files given.
    number: usize,
    /// Size of its FRFs in memory, about.
    bytes: u64,
    cut: Cut,
    /// The units of `cut` that belong to the set.
    units: Range<usize>,
}

impl Parted {
    fn open(path: &Path, number: usize, options: &ReadOptions) -> Result<Self> {
        let mut bytes = size_of(path)?;
        let cut = match detect_format(path)? {
            FileFormat::Hdf5 => match hdf5::Rows::open(path)? {
                Some(rows) if options.map.is_empty() => {
                    bytes = rows.bytes();
                    Cut::Responses(Box::new(rows))
                }
                _ => Cut::Nowhere,
            },
            FileFormat::Uff => Cut::between_functions(path, options.lenient)?,
            _ => Cut::Nowhere,
        };
        Ok(Self {
            path: path.to_owned(),
            number,
            bytes,
            units: 0..cut.unit_count(),
            cut,
        })
    }
}

/// Places at which a file can be cut.
#[derive(Debug, Clone)]
enum Cut {
    /// Nowhere.
    Nowhere,
    /// Between the responses of our own layout.
    Responses(Box<hdf5::Rows>),
    /// Between functions: the bytes of each, and those of all other datasets.
    Functions {
        beside: Vec<Range<u64>>,
        functions: Vec<Range<u64>>,
    },
}

impl Cut {
    /// Number of units between which the file can be cut: responses, functions, or the file.
    fn unit_count(&self) -> usize {
        match self {
            Self::Nowhere => 1,
            Self::Responses(rows) => rows.count(),
            Self::Functions { functions, .. } => functions.len(),
        }
    }

    /// The places of a universal file.
    fn between_functions(path: &Path, lenient: bool) -> Result<Self> {
        let places = uff::places(path, lenient)?;
        // units hold for what follows them: with two, the units of a function depend on its place
        let is_units = |place: &&uff::DatasetPlace| place.number == Some(164);
        if places.iter().filter(is_units).count() > 1 {
            return Ok(Self::Nowhere);
        }
        let (mut functions, mut beside) = (Vec::new(), Vec::new());
        for place in places {
            match place.number {
                Some(58) => functions.push(place.bytes),
                _ => beside.push(place.bytes),
            }
        }
        Ok(Self::Functions { beside, functions })
    }
}

/// A part that is read at a time.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    file: usize,
    units: Range<usize>,
}

impl FrfParts {
    /// Finds the places at which the files can be cut. Of a binary file only headers are read.
    ///
    /// # Errors
    /// Those of reading.
    pub fn open(files: &[PathBuf], options: &ReadOptions) -> Result<Self> {
        if !options.dofs.rows.is_empty() {
            return Err(Error::new(
                chladni_frf::ErrorKind::Usage,
                "files that are read in parts cannot take their DOFs from a list",
            )
            .field("dofs")
            .found(format!("{} rows", options.dofs.rows.len()))
            .expected("DOFs in the files")
            .help("convert the files with that list into one first"));
        }
        let kept = KeptInputs::new();
        let files = (files.iter().enumerate())
            .map(|(number, path)| Parted::open(path, number, options))
            .collect::<Result<_>>()?;
        Ok(Self {
            files,
            options: options.clone(),
            kept,
        })
    }

    /// Share `index` of `count` shares of about the same number of responses, functions
    /// or files.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::Usage`] where there are fewer of these than shares.
    pub fn share(&self, index: usize, count: usize) -> Result<Self> {
        let all: usize = self.files.iter().map(|file| file.units.len()).sum();
        if count > all {
            return Err(Error::new(
                chladni_frf::ErrorKind::Usage,
                "the data cannot be cut into so many \
                                                            blocks",
            )
            .field("blocks")
            .found(count)
            .expected(format!(
                "at most {all}: responses of our own HDF5 layout, functions of a \
                                   universal file, other files"
            ))
            .help("give fewer blocks, or convert the files to .h5 first"));
        }
        let share = all * index / count..all * (index + 1) / count;
        let mut before = 0;
        let mut files = Vec::new();
        for file in &self.files {
            let within =
                |at: usize| file.units.start + at.clamp(before, before + file.units.len()) - before;
            let units = within(share.start)..within(share.end);
            before += file.units.len();
            if !units.is_empty() {
                files.push(Parted {
                    units,
                    ..file.clone()
                });
            }
        }
        Ok(Self {
            files,
            options: self.options.clone(),
            kept: self.kept.clone(),
        })
    }

    /// Parts of at most `most` bytes in memory, in order.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`] naming a file that is larger and cannot be cut.
    pub fn parts(&self, most: u64) -> Result<Vec<Part>> {
        let mut parts = Vec::new();
        for (number, file) in self.files.iter().enumerate() {
            if matches!(file.cut, Cut::Nowhere) && file.bytes > most {
                return Err(Error::bad_data(
                    "the file is too large to be held, and cannot be read \
                                            in parts",
                )
                .file(&file.path)
                .found(size_in_words(file.bytes, u64::div_ceil))
                .expected(format!(
                    "at most {}, or the HDF5 layout of this program, or a universal file \
                         with one set of units",
                    size_in_words(most, |bytes, unit| bytes / unit)
                ))
                .help(
                    "raise `memory`, or convert the file to .h5 where there is memory \
                           enough",
                ));
            }
            let whole = file.cut.unit_count().max(1) as u64;
            let units = usize::try_from(most.saturating_mul(whole) / file.bytes.max(1))
                .unwrap_or(usize::MAX)
                .max(1);
            for start in file.units.clone().step_by(units) {
                parts.push(Part {
                    file: number,
                    units: start..start.saturating_add(units).min(file.units.end),
                });
            }
        }
        Ok(parts)
    }

    /// Checksums of `files`, computed while their parts are read. `None` where some file has
    /// no part here, or where the values do not lie in the files as they do in memory.
    pub fn checksums(&self, files: &[PathBuf]) -> Option<Checksums> {
        let in_stretches =
            |file: &Parted| matches!(&file.cut, Cut::Responses(rows) if rows.lie_in_one_stretch());
        let all = self.files.iter().map(|file| &file.path).eq(files)
            && self.files.iter().all(in_stretches);
        all.then(|| Checksums::new(files))
    }

    /// The turn of a part that is read as number `number`, for its bytes to be added to
    /// `checksums`.
    pub fn turn<'a>(&self, checksums: &'a Checksums, number: usize, part: &Part) -> Turn<'a> {
        checksums.turn(number, part.file)
    }

    /// Bytes of a part in memory, about.
    pub fn part_bytes(&self, part: &Part) -> u64 {
        let file = &self.files[part.file];
        file.bytes * part.units.len() as u64 / file.cut.unit_count().max(1) as u64
    }

    /// The file that a part belongs to.
    pub fn file(&self, part: &Part) -> &Path {
        &self.files[part.file].path
    }

    /// The FRFs of a part, and the findings about them.
    ///
    /// * `turn`: the turn of the part, where checksums are computed while parts are read; the
    ///   file is then read past the system's cache
    /// * `spare`: values of an earlier part that are no longer needed; their memory is used
    ///   again where possible
    ///
    /// # Errors
    /// Those of reading; [`chladni_frf::ErrorKind::BadData`] where it holds no FRF.
    pub fn read(
        &self,
        part: &Part,
        turn: Option<Turn>,
        spare: Option<FrfValues>,
    ) -> Result<(FrfSet, Vec<Finding>)> {
        let file = &self.files[part.file];
        let mut options = self.options.clone();
        if options.references.len() > 1 {
            options.references = options
                .references
                .get(file.number)
                .copied()
                .into_iter()
                .collect();
        }
        Self::read_of(file, &options, &part.units, turn, spare).map_err(|mut error| {
            // lines of a part are not those of the file
            if let Cut::Functions { functions, .. } = &file.cut {
                error.line = None;
                error.byte.get_or_insert(functions[part.units.start].start);
            }
            error
        })
    }

    fn read_of(
        file: &Parted,
        options: &ReadOptions,
        units: &Range<usize>,
        turn: Option<Turn>,
        spare: Option<FrfValues>,
    ) -> Result<(FrfSet, Vec<Finding>)> {
        let documents = match &file.cut {
            Cut::Nowhere => read_documents(std::slice::from_ref(&file.path), options)?,
            Cut::Responses(rows) => vec![rows.read(options, units.clone(), turn, spare)?],
            Cut::Functions { beside, functions } => {
                let wanted: Vec<&Range<u64>> =
                    beside.iter().chain(&functions[units.clone()]).collect();
                let bytes = stretches(&file.path, wanted)?;
                vec![uff::read(&bytes, &file.path, options)?]
            }
        };
        let mut contents = assemble(documents, options)?;
        let nothing = || {
            Error::bad_data("no FRF in this part of the file")
                .file(&file.path)
                .found("other functions")
                .expected("FRFs")
        };
        Ok((contents.frf.take().ok_or_else(nothing)?, contents.warnings))
    }
}

/// A size for people, in whole units as `count` rounds them.
fn size_in_words(bytes: u64, count: fn(u64, u64) -> u64) -> String {
    match bytes {
        0..0x400 => format!("{bytes} bytes"),
        0x400..0x10_0000 => format!("{} KiB", count(bytes, 0x400)),
        _ => format!("{} MiB", count(bytes, 0x10_0000)),
    }
}

/// Bytes that the FRFs of files take in memory, about: by the headers of the files, else
/// by their sizes. Damaged headers are no error here; reading reports them.
///
/// # Errors
/// Those of reading.
pub fn frf_bytes(files: &[PathBuf]) -> Result<u64> {
    let of = |path: &PathBuf| match detect_format(path)? {
        FileFormat::Hdf5 => hdf5::Rows::open(path)
            .ok()
            .flatten()
            .map_or_else(|| size_of(path), |rows| Ok(rows.bytes())),
        _ => size_of(path),
    };
    files
        .iter()
        .map(of)
        .try_fold(0_u64, |sum, bytes| Ok(sum.saturating_add(bytes?)))
}

/// The bytes of some stretches of a file, one after the other; neighbours are read at once.
fn stretches(path: &Path, wanted: Vec<&Range<u64>>) -> Result<Vec<u8>> {
    let on_read = |error: std::io::Error| Error::from_read(&error, path);
    let mut joined: Vec<Range<u64>> = Vec::new();
    for range in wanted {
        match joined.last_mut() {
            Some(last) if last.end == range.start => last.end = range.end,
            _ => joined.push(range.clone()),
        }
    }
    let mut file = door::open(path)?;
    let mut bytes = Vec::new();
    for range in joined {
        file.seek(SeekFrom::Start(range.start)).map_err(on_read)?;
        (&mut file)
            .take(range.end - range.start)
            .read_to_end(&mut bytes)
            .map_err(on_read)?;
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_sizes_are_no_zeros() {
        let up = |bytes| size_in_words(bytes, u64::div_ceil);
        assert_eq!(up(1000), "1000 bytes");
        assert_eq!(up(1025), "2 KiB");
        assert_eq!(up(3 << 19), "2 MiB");
        assert_eq!(size_in_words(3 << 19, |bytes, unit| bytes / unit), "1 MiB");
    }
}
