//! FRFs of files that do not fit into memory, part by part.
//!
//! Our own HDF5 layout is cut between responses, a universal file between the FRFs of
//! different pairs; any other file is one part. A part is read and checked like a file of its
//! own, under the options that hold for its file.

mod cut;
mod functions;
mod node_lists;
mod stretches;
mod tables;

use super::assemble::{assemble, left_out, merge_geometry};
use super::{detect_format, hdf5, Checksums, FileFormat, ReadOptions, Turn};
use chladni_frf::{Error, Finding, FrfSet, FrfValues, Geometry, Result};
use chladni_text::door::{size_of, KeptInputs};
use cut::{Cut, Parted};
use node_lists::NodeLists;
use std::collections::HashSet;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tables::Tables;

/// Files whose FRFs can be read part by part.
#[derive(Debug, Clone)]
pub struct FrfParts {
    files: Vec<Parted>,
    options: ReadOptions,
    lists: NodeLists,
    /// The tables of all shares.
    tables: Arc<Tables>,
    /// Places of nodes from universal files without FRFs.
    nodes: Arc<Vec<PlacedNodes>>,
    findings: Vec<Finding>,
    /// Keeps what came through pipes until the files are read.
    _kept: KeptInputs,
}

/// The geometry of a file.
#[derive(Debug)]
struct PlacedNodes {
    file: PathBuf,
    geometry: Geometry,
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
    /// Those of reading; nodes of the caller that do not fit the files.
    pub fn open(files: &[PathBuf], options: &ReadOptions) -> Result<Self> {
        refuse_declared_dofs(options)?;
        let kept = KeptInputs::new();
        let (mut measured, mut findings) = (Vec::new(), Vec::new());
        for path in files {
            match detect_format(path)? {
                FileFormat::Model | FileFormat::Weights => findings.push(left_out(path)),
                format => measured.push((path, format)),
            }
        }
        let lists = NodeLists::new(options, measured.len())?;
        let tables = Arc::new(Tables::among(&measured));
        let (mut files, mut nodes) = (Vec::new(), Vec::new());
        for (number, (path, format)) in measured.into_iter().enumerate() {
            let own = lists.of_file(options, number);
            let file = Parted::open(path, format, number, &own)?;
            file.check_nodes(&own)?;
            findings.extend(file.finding());
            if let Some(document) = file.beside_no_frf(&own)? {
                let contents = assemble(vec![document], &own)?;
                findings.extend(contents.warnings);
                nodes.push(PlacedNodes {
                    file: path.clone(),
                    geometry: contents.other_geometry,
                });
            }
            files.push(file);
        }
        Ok(Self {
            files,
            options: options.clone(),
            lists,
            tables,
            nodes: Arc::new(nodes),
            findings,
            _kept: kept,
        })
    }

    /// Findings about the files as wholes, which no part repeats.
    pub fn findings(&self) -> &[Finding] {
        &self.findings
    }

    /// Share `index` of `count` shares of about the same number of responses, pairs of DOFs
    /// or files.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::Usage`] where there are fewer of these than shares.
    pub fn share(&self, index: usize, count: usize) -> Result<Self> {
        let all: usize = self.files.iter().map(|file| file.units.len()).sum();
        if count > all {
            return Err(Error::new(
                chladni_frf::ErrorKind::Usage,
                "the data cannot be cut into so many blocks",
            )
            .field("blocks")
            .found(count)
            .expected(format!(
                "at most {all}: responses of our own HDF5 layout, pairs of DOFs of a universal \
                 file, other files"
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
            ..self.clone()
        })
    }

    /// Parts of at most `most` bytes in memory, in order.
    ///
    /// # Errors
    /// [`chladni_frf::ErrorKind::BadData`] naming a file that is larger and cannot be cut, and
    /// where no file holds an FRF.
    pub fn parts(&self, most: u64) -> Result<Vec<Part>> {
        let mut parts = Vec::new();
        for (number, file) in self.files.iter().enumerate() {
            if matches!(file.cut, Cut::Nowhere) && file.bytes > most {
                return Err(too_large(file, most));
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
        if parts.is_empty() {
            return Err(self.nothing());
        }
        Ok(parts)
    }

    /// The error of files without an FRF.
    fn nothing(&self) -> Error {
        let others: usize = self.files.iter().map(Parted::others).sum();
        let error = Error::bad_data("no FRF in the input")
            .found(match (self.files.len(), others) {
                (0, _) => "results, no measurement".to_owned(),
                (_, 0) => "no function".to_owned(),
                (_, others) => format!("{others} other functions"),
            })
            .expected("functions of type 4 (58)")
            .help(
                "look at the contents of the file; where they are time records, estimate FRFs \
                 first",
            );
        match self.files.as_slice() {
            [one] => error.file(&one.path),
            _ => error,
        }
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

    /// The FRFs of a part, and the findings about them; `None` where a file without places to
    /// cut it holds no FRF, or where all FRFs are damaged and left out.
    ///
    /// * `turn`: the turn of the part, where checksums are computed while parts are read; the
    ///   file is then read past the system's cache
    /// * `spare`: values of an earlier part that are no longer needed; their memory is used
    ///   again where possible
    ///
    /// # Errors
    /// Those of reading.
    pub fn read(
        &self,
        part: &Part,
        turn: Option<Turn>,
        spare: Option<FrfValues>,
    ) -> Result<(Option<FrfSet>, Vec<Finding>)> {
        let file = &self.files[part.file];
        let options = self.lists.of_file(&self.options, file.number);
        let units = part.units.clone();
        let document = match &file.cut {
            Cut::Responses(rows) => rows.read(&options, units, turn, spare)?,
            Cut::Functions(groups) => file.read_groups(groups, units, &options)?,
            Cut::Nowhere => {
                let number = file.number;
                let first = self.tables.first_node(number, &self.options, &self.lists)?;
                file.read_whole(&options, first)?
            }
        };
        let mut contents = assemble(vec![document], &options)?;
        if let Some(set) = &mut contents.frf {
            self.place_nodes(set)?;
        }
        Ok((contents.frf, contents.warnings))
    }

    /// Adds the nodes of a set that files without FRFs place.
    fn place_nodes(&self, set: &mut FrfSet) -> Result<()> {
        if self.nodes.is_empty() {
            return Ok(());
        }
        let dofs = set.responses.iter().chain(&set.references);
        let labels: HashSet<u64> = dofs.map(|dof| dof.node).collect();
        for placed in self.nodes.iter() {
            let nodes = placed.geometry.nodes.iter();
            let own = nodes.filter(|node| labels.contains(&node.label)).copied();
            let geometry = Geometry {
                nodes: own.collect(),
                ..Geometry::default()
            };
            merge_geometry(&mut set.geometry, geometry, &placed.file)?;
        }
        Ok(())
    }
}

fn refuse_declared_dofs(options: &ReadOptions) -> Result<()> {
    if options.dofs.rows.is_empty() {
        return Ok(());
    }
    Err(Error::new(
        chladni_frf::ErrorKind::Usage,
        "files that are read in parts cannot take their DOFs from a list",
    )
    .field("dofs")
    .found(format!("{} rows", options.dofs.rows.len()))
    .expected("DOFs in the files")
    .help("convert the files with that list into one first"))
}

/// The error of a file that cannot be cut.
fn too_large(file: &Parted, most: u64) -> Error {
    Error::bad_data("the file is too large to be held, and cannot be read in parts")
        .file(&file.path)
        .found(size_in_words(file.bytes, u64::div_ceil))
        .expected(format!(
            "at most {}, or the HDF5 layout of this program, or a universal file with one set \
             of units",
            size_in_words(most, |bytes, unit| bytes / unit)
        ))
        .help("raise `memory`, or convert the file to .h5 where there is memory enough")
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
