//! Arrays that were read as a whole (MATLAB, NumPy), laid out as the tree of an HDF5
//! file.

use super::foreign::{read_foreign, take_frf};
use super::tree::{Attribute, Element, Entry, Values};
use super::ArrayFile;
use crate::{DatasetInfo, Document, FileFormat, ReadOptions};
use chladni_frf::{Error, Finding, Result};
use std::collections::BTreeMap;
use std::path::Path;

/// The attribute of every array that MATLAB writes: its axes are in reverse order.
const MATLAB: &str = "MATLAB_class";

/// Order of the axes of an array in memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum AxisOrder {
    /// That of the program that wrote it.
    Same,
    /// The reverse of that.
    Reversed,
}

/// Arrays by path, with findings about the file.
#[derive(Debug, Default)]
pub(crate) struct MemoryFile {
    arrays: BTreeMap<String, (Entry, Values<'static>)>,
    /// Arrays of types that are not read.
    unread: BTreeMap<String, Entry>,
    /// Findings on what was passed over.
    pub(crate) warnings: Vec<Finding>,
}

impl MemoryFile {
    /// Adds an array in C order. A second array of the same path is left out and reported.
    pub(crate) fn add(
        &mut self,
        path: &str,
        shape: Vec<usize>,
        values: Values<'static>,
        order: AxisOrder,
    ) {
        if let Some(entry) = self.new_entry(path, shape, values.element(), order) {
            self.arrays.insert(path.to_owned(), (entry, values));
        }
    }

    /// Adds an array whose values are not read, with its type in words, and reports it.
    pub(crate) fn add_unread(
        &mut self,
        path: &str,
        shape: Vec<usize>,
        type_in_words: String,
        order: AxisOrder,
    ) {
        let words = format!("{path}: {type_in_words}: a type that is not read");
        let element = Element::Other(type_in_words);
        if let Some(entry) = self.new_entry(path, shape, element, order) {
            self.unread.insert(path.to_owned(), entry);
            self.warnings.push(Finding::note("not-read", words));
        }
    }

    /// The entry of an array; `None`, with a finding, for a second one of the same path.
    fn new_entry(
        &mut self,
        path: &str,
        shape: Vec<usize>,
        element: Element,
        order: AxisOrder,
    ) -> Option<Entry> {
        if self.arrays.contains_key(path) || self.unread.contains_key(path) {
            self.warnings.push(Finding::note(
                "not-read",
                format!("{path} occurs twice; the first is kept"),
            ));
            return None;
        }
        let attributes = if order == AxisOrder::Reversed {
            vec![(MATLAB.to_owned(), Attribute::Text(String::new()))]
        } else {
            Vec::new()
        };
        Some(Entry {
            path: path.to_owned(),
            dataset: Some((shape, element)),
            attributes,
            unread_attributes: Vec::new(),
        })
    }

    /// The error of the largest array that is not read, where there is one: it may hold the FRFs.
    pub(crate) fn largest_unread(&self) -> Option<Error> {
        let size = |entry: &&Entry| entry.shape().iter().map(|&n| n as f64).product::<f64>();
        let largest = (self.unread.values()).max_by(|a, b| size(a).total_cmp(&size(b)));
        largest.map(not_read)
    }

    /// True without arrays.
    pub(crate) fn is_empty(&self) -> bool {
        self.arrays.is_empty()
    }

    /// The document: a list of all arrays, and the FRFs where they can be identified.
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

    /// True for a model that this program wrote for other programs.
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
        let arrays = self.arrays.values().map(|(entry, _)| entry);
        let all = arrays.chain(self.unread.values());
        std::iter::once(root).chain(all.cloned()).collect()
    }
}

impl ArrayFile for MemoryFile {
    fn read(&self, entry: &Entry) -> Result<Values<'static>> {
        if let Some(entry) = self.unread.get(&entry.path) {
            return Err(not_read(entry));
        }
        let found = self.arrays.get(&entry.path);
        found
            .map(|(_, values)| values.clone())
            .ok_or_else(|| Error::bad_data("no such array").field(&entry.path))
    }
}

fn not_read(entry: &Entry) -> Error {
    Error::bad_data("values of a type that cannot be read")
        .field(&entry.path)
        .found(entry.element().map_or_else(String::new, Element::describe))
        .expected("numbers (f4, f8, c8, c16, i, u, b) or text (U, S)")
        .help("save the array as numbers (float64, complex128) or as text, or leave it out")
}

fn info(entry: &Entry) -> DatasetInfo {
    let mut extents: Vec<String> = entry.shape().iter().map(usize::to_string).collect();
    if entry.attribute(MATLAB).is_some() {
        extents.reverse();
    }
    let element = entry.element().map_or_else(String::new, Element::describe);
    let function = if extents.is_empty() {
        element
    } else {
        format!("{element}, {}", extents.join(" x "))
    };
    DatasetInfo {
        name: entry.path.clone(),
        function: Some(function),
        values: entry.shape().iter().copied().max(),
        left_behind: true, // until its content is used
        ..DatasetInfo::default()
    }
}
