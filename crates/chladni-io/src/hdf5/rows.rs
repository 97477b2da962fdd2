//! Reading of FRFs in our own layout, some responses at a time.

use super::backend::File;
use super::own::{own_array, Own, FORMAT};
use super::units;
use crate::arrays::tree::{Element, Entry, Values};
use crate::arrays::values::{checked, real_array, wrong_type, ComplexArray};
use crate::time_sign::to_plus;
use crate::{Document, FileFormat, ReadOptions, Turn};
use chladni_frf::{Dof, Error, FrfSet, FrfValues, Geometry, Result, TimeSign};
use ndarray::{Array3, Ix3};
use num_complex::{Complex32, Complex64};
use std::collections::HashSet;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A file whose FRFs are read in rows, without their values.
#[derive(Debug, Clone)]
pub(crate) struct Rows {
    path: PathBuf,
    entry: Entry,
    /// The arrays of the shape of the FRFs, where there are any.
    coherence: Option<Entry>,
    variance: Option<Entry>,
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
            Ok(Self {
                path: path.to_path_buf(),
                coherence: beside(&own, "/coherence", entry)?,
                variance: beside(&own, "/variance", entry)?,
                entry: entry.clone(),
                head,
                time_sign: own.time_sign()?,
            })
        });
        read.map(Some).map_err(|error| error.file(path))
    }

    /// All responses, and all references.
    pub fn dofs(&self) -> [&[Dof]; 2] {
        [&self.head.responses, &self.head.references]
    }

    /// True where the values lie in the file as they do in memory, one after the other.
    pub fn lie_in_one_stretch(&self) -> bool {
        File::open(&self.path).is_ok_and(|file| file.lies_in_one_stretch(&self.entry))
    }

    /// Number of responses.
    pub fn count(&self) -> usize {
        self.entry.shape()[0]
    }

    /// Bytes of all FRFs in memory, with coherence and variance.
    pub fn bytes(&self) -> u64 {
        let value = match self.entry.element() {
            Some(&Element::Complex { single: true }) => size_of::<Complex32>(),
            _ => size_of::<Complex64>(),
        };
        let coherence = self.coherence.as_ref().map_or(0, |_| size_of::<f32>());
        let variance = self.variance.as_ref().map_or(0, |_| size_of::<f64>());
        let shape = self.entry.shape().iter();
        shape.fold((value + coherence + variance) as u64, |bytes, &extent| {
            bytes.saturating_mul(extent as u64)
        })
    }

    /// The FRFs of some responses with their coherence and variance, without checksum. The
    /// memory of `spare` is used again if possible.
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
        let file = File::open(&self.path)?;
        let values = file.read_rows(&self.entry, rows.clone(), turn, spare)?;
        let coherence = real_rows(&file, self.coherence.as_ref(), &rows)?;
        let variance = real_rows(&file, self.variance.as_ref(), &rows)?;
        let to_si = units::of_frf(&self.entry)?.map_or(1.0, |(_, unit)| unit.to_si);
        let entry = with_rows(&self.entry, rows.len());
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
            coherence: coherence.map(|values| values.mapv(|value| value as f32)),
            variance: variance.map(|values| values * (to_si * to_si)),
            estimation: self.head.estimation,
            geometry: Geometry {
                nodes,
                ..Geometry::default()
            },
        };
        checked(set, &self.entry.path)
    }
}

/// The entry of an array beside that of the FRFs, which must have its shape.
fn beside(own: &Own<'_>, path: &str, frf: &Entry) -> Result<Option<Entry>> {
    let extents = |entry: &Entry| {
        let words: Vec<String> = entry.shape().iter().map(usize::to_string).collect();
        words.join(" x ")
    };
    match own.find(path) {
        Some(entry) if entry.dataset.is_some() && entry.shape() != frf.shape() => {
            Err(Error::bad_data("sizes disagree")
                .field(path)
                .found(extents(entry))
                .expected(format!("{}, as the FRF array has", extents(frf))))
        }
        found => Ok(found.cloned()),
    }
}

/// Some rows of an array of real numbers.
fn real_rows(
    file: &File,
    entry: Option<&Entry>,
    rows: &Range<usize>,
) -> Result<Option<Array3<f64>>> {
    let Some(entry) = entry else {
        return Ok(None);
    };
    let values = file.read_rows(entry, rows.clone(), None, None)?;
    let array = real_array(&with_rows(entry, rows.len()), values)?;
    let array = array.into_dimensionality::<Ix3>();
    let wrong = |_| wrong_type(entry, "three axes: response, reference, line");
    array.map(Some).map_err(wrong)
}

/// An entry of the same array with `count` rows.
fn with_rows(entry: &Entry, count: usize) -> Entry {
    let mut entry = entry.clone();
    if let Some((shape, _)) = &mut entry.dataset {
        shape[0] = count;
    }
    entry
}
