//! Reading of FRFs in our own layout, some responses at a time.

use super::backend::File;
use super::own::{own_array, Own, FORMAT};
use crate::arrays::tree::{Element, Entry, Values};
use crate::arrays::values::{checked, ComplexArray};
use crate::time_sign::to_plus;
use crate::{Document, FileFormat, ReadOptions, Turn};
use chladni_frf::{Error, FrfSet, FrfValues, Geometry, Result, TimeSign};
use ndarray::Array3;
use std::collections::HashSet;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A file whose FRFs are read in rows, without their values.
#[derive(Debug, Clone)]
pub(crate) struct Rows {
    path: PathBuf,
    entry: Entry,
    /// All DOFs, no values.
    head: FrfSet,
    time_sign: Option<TimeSign>,
}

impl Rows {
    /// Reads the headers; `None` for a file in another layout or without FRFs.
    pub fn open(path: &Path) -> Result<Option<Self>> {
        let file = File::open(path)?;
        let entries = file.entries()?;
        let own = Own {
            file: &file,
            entries: &entries,
        };
        if own.root().text("format") != Some(FORMAT) || own.find("/frf").is_none() {
            return Ok(None);
        }
        let read = own.check_version().and_then(|()| {
            own.check_read()?;
            let entry = own.frf_entry()?;
            let head = own.set_of(FrfValues::F64(Array3::zeros((0, 0, 0))))?;
            if head.responses.len() != entry.shape()[0] {
                let error = Error::bad_data("sizes disagree")
                    .field("/response")
                    .found(head.responses.len());
                return Err(error.expected(format!(
                    "{}, as many as the FRF array has",
                    entry.shape()[0]
                )));
            }
            Ok((entry.clone(), head, own.time_sign()?))
        });
        let (entry, head, time_sign) = read.map_err(|error| error.file(path))?;
        Ok(Some(Self {
            path: path.to_path_buf(),
            entry,
            head,
            time_sign,
        }))
    }

    /// True where the values lie in the file as they do in memory, one after the other.
    pub fn lie_in_one_stretch(&self) -> bool {
        File::open(&self.path).is_ok_and(|file| file.lies_in_one_stretch(&self.entry))
    }

    /// Number of responses.
    pub fn count(&self) -> usize {
        self.entry.shape()[0]
    }

    /// Bytes of all FRFs in memory.
    pub fn bytes(&self) -> u64 {
        let value = if self.entry.element() == Some(&Element::Complex { single: true }) {
            8
        } else {
            16
        };
        self.entry
            .shape()
            .iter()
            .fold(value, |bytes: u64, &extent| {
                bytes.saturating_mul(extent as u64)
            })
    }

    /// The FRFs of some responses, without coherence, variance and checksum. The memory of
    /// `spare` is used again if possible.
    pub fn read(
        &self,
        options: &ReadOptions,
        rows: Range<usize>,
        turn: Option<Turn>,
        spare: Option<FrfValues>,
    ) -> Result<Document> {
        let mut document = Document::new(&self.path, FileFormat::Hdf5);
        let mut set = self
            .set(rows, turn, spare)
            .map_err(|error| error.file(&self.path))?;
        to_plus(
            &mut set,
            self.time_sign,
            options.time_sign,
            &mut document.warnings,
        );
        document.frf = Some(set);
        Ok(document)
    }

    fn set(
        &self,
        rows: Range<usize>,
        turn: Option<Turn>,
        spare: Option<FrfValues>,
    ) -> Result<FrfSet> {
        let spare = spare.map(|spare| match spare {
            FrfValues::F64(spare) => Values::Complex64(spare.into_raw_vec_and_offset().0.into()),
            FrfValues::F32(spare) => Values::Complex32(spare.into_raw_vec_and_offset().0.into()),
        });
        let values = File::open(&self.path)?.read_rows(&self.entry, rows.clone(), turn, spare)?;
        let mut entry = self.entry.clone();
        if let Some((shape, _)) = &mut entry.dataset {
            shape[0] = rows.len();
        }
        let responses = self.head.responses[rows].to_vec();
        let labels: HashSet<u64> = responses
            .iter()
            .chain(&self.head.references)
            .map(|dof| dof.node)
            .collect();
        let nodes = self
            .head
            .geometry
            .nodes
            .iter()
            .filter(|node| labels.contains(&node.label))
            .copied()
            .collect();
        let set = FrfSet {
            frequency_hz: self.head.frequency_hz.clone(),
            values: own_array(ComplexArray::new(&entry, values)?, &entry)?,
            responses,
            references: self.head.references.clone(),
            kind: self.head.kind,
            reference_unit: self.head.reference_unit,
            coherence: None,
            variance: None,
            estimation: self.head.estimation,
            geometry: Geometry {
                nodes,
                ..Geometry::default()
            },
        };
        checked(set, &self.entry.path)
    }
}
