//! Arrays that were read as a whole (MATLAB, NumPy), laid out as the tree of an HDF5
//! file.

use super::foreign::{read_foreign, take_frf};
use super::tree::{Attribute, Entry, Values};
use super::ArrayFile;
use crate::{DatasetInfo, Document, FileFormat, ReadOptions};
use chladni_frf::{Error, Finding, Result};
use std::collections::BTreeMap;
use std::path::Path;

/// The attribute that MATLAB's own writer marks every array with: it stands in reverse
/// order.
const MATLAB: &str = "MATLAB_class";

/// Arrays by path, with what is odd about the file.
#[derive(Debug, Default)]
pub(crate) struct MemoryFile {
    arrays: BTreeMap<String, (Entry, Values<'static>)>,
    /// Findings on what was passed over.
    pub(crate) warnings: Vec<Finding>,
}

impl MemoryFile {
    /// Adds an array in C order; `reversed` says that its program calls the axes the
    /// other way round. A name that is there already is kept and the new one reported.
    pub(crate) fn add(
        &mut self,
        path: &str,
        shape: Vec<usize>,
        values: Values<'static>,
        reversed: bool,
    ) {
        if self.arrays.contains_key(path) {
            self.warnings.push(Finding::note(
                "not-read",
                format!("{path} occurs twice; the first is kept"),
            ));
            return;
        }
        let attributes = if reversed {
            vec![(MATLAB.to_owned(), Attribute::Text(String::new()))]
        } else {
            Vec::new()
        };
        let entry = Entry {
            path: path.to_owned(),
            dataset: Some((shape, values.element())),
            attributes,
            unread_attributes: Vec::new(),
        };
        self.arrays.insert(path.to_owned(), (entry, values));
    }

    /// True without arrays.
    pub(crate) fn is_empty(&self) -> bool {
        self.arrays.is_empty()
    }

    /// The document: every array listed, FRFs where they can be told.
    pub(crate) fn document(
        mut self,
        path: &Path,
        format: FileFormat,
        options: &ReadOptions,
    ) -> Result<Document> {
        let mut document = Document {
            warnings: std::mem::take(&mut self.warnings),
            ..Document::new(path, format)
        };
        let entries = self.entries();
        document.datasets = entries
            .iter()
            .filter(|entry| entry.dataset.is_some())
            .map(info)
            .collect();
        if self.is_model() {
            document.warnings.push(Finding::caution(
                "not-read",
                "a model for other programs: read it from JSON or HDF5 here",
            ));
            return Ok(document);
        }
        let outcome = read_foreign(&self, &entries, options, &mut document.warnings);
        take_frf(&mut document, outcome, options)?;
        Ok(document)
    }

    /// True for the model that this program writes for others.
    fn is_model(&self) -> bool {
        let format = self.arrays.get("/format").map(|(_, values)| values);
        matches!(format, Some(Values::Text(texts)) if texts.first().is_some_and(|text| text == chladni_frf::MODEL_FORMAT))
    }

    /// The root, then all arrays.
    fn entries(&self) -> Vec<Entry> {
        let root = Entry {
            path: "/".into(),
            dataset: None,
            attributes: Vec::new(),
            unread_attributes: Vec::new(),
        };
        let arrays = self.arrays.values().map(|(entry, _)| entry.clone());
        std::iter::once(root).chain(arrays).collect()
    }
}

impl ArrayFile for MemoryFile {
    fn read(&self, entry: &Entry) -> Result<Values<'static>> {
        let found = self.arrays.get(&entry.path);
        found
            .map(|(_, values)| values.clone())
            .ok_or_else(|| Error::bad_data("no such array").field(&entry.path))
    }
}

fn info(entry: &Entry) -> DatasetInfo {
    let mut extents: Vec<String> = entry.shape().iter().map(usize::to_string).collect();
    if entry.attribute(MATLAB).is_some() {
        extents.reverse();
    }
    let element = entry
        .element()
        .map_or_else(String::new, super::tree::Element::describe);
    let function = if extents.is_empty() {
        element
    } else {
        format!("{element}, {}", extents.join(" x "))
    };
    DatasetInfo {
        name: entry.path.clone(),
        function: Some(function),
        values: entry.shape().iter().copied().max(),
        left_behind: true, // until something of the document is made of it
        ..DatasetInfo::default()
    }
}
