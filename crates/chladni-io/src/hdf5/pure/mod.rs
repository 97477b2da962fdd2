//! Back end in pure Rust: no library to install.

mod decode;
mod number;
mod write;

pub(super) use write::write;

use crate::arrays::tree::{
    check_nesting, check_size, library_error, Attribute, Attributes, Element, Entry, Unread, Values,
};
use crate::Turn;
use chladni_frf::{Error, Result};
use chladni_text::door::{place_of, Place};
use decode::{describe_unread, element_of, lies_in_one_stretch, unknown_direction, values_of};
use hdf5_pure::{AttrValue, Dataset, Datatype};
use std::collections::HashMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// An open file.
pub(super) struct File {
    path: PathBuf,
    /// The file that its bytes are read from; for a pipe, a temporary one.
    place: Place,
    bytes: u64,
    file: hdf5_pure::File,
}

impl File {
    pub(super) fn open(path: &Path) -> Result<Self> {
        let place = place_of(path)?;
        let file = hdf5_pure::File::open_streaming(&*place).map_err(|error| match error {
            hdf5_pure::Error::Io(error) => Error::from_read(&error, path),
            error => library_error(error, path),
        })?;
        let (held, said) = (file.file_size(), file.superblock().eof_address);
        if said != u64::MAX && said > held {
            return Err(Error::bad_data("the file is cut off")
                .file(path)
                .at_byte(held)
                .found(format!("{held} bytes"))
                .expected(format!("the {said} bytes that its first lines tell of"))
                .help("copy it again from where it was measured"));
        }
        Ok(Self {
            path: path.to_path_buf(),
            place,
            bytes: file.file_size(),
            file,
        })
    }

    /// Every group and dataset, the root first, sorted by path.
    pub(super) fn entries(&self) -> Result<Vec<Entry>> {
        let mut entries = Vec::new();
        self.walk("", 0, &mut entries)?;
        entries.sort_by(|a: &Entry, b| a.path.cmp(&b.path));
        Ok(entries)
    }

    fn walk(&self, path: &str, depth: usize, entries: &mut Vec<Entry>) -> Result<()> {
        check_nesting(path, depth, entries.len()).map_err(|error| error.file(&self.path))?;
        let fail = |error| {
            library_error(error, &self.path).field(if path.is_empty() { "/" } else { path })
        };
        let group = if path.is_empty() {
            self.file.root()
        } else {
            self.file.group(path).map_err(fail)?
        };
        let types = group.attr_datatypes().map_err(fail)?;
        let (attributes, unread_attributes) = known_attributes(group.attrs().map_err(fail)?, types);
        let shown = if path.is_empty() {
            "/".into()
        } else {
            path.into()
        };
        entries.push(Entry {
            path: shown,
            dataset: None,
            attributes,
            unread_attributes,
        });
        for name in group.datasets().map_err(fail)? {
            entries.push(self.dataset_entry(&format!("{path}/{name}")));
        }
        for name in group.groups().map_err(fail)? {
            self.walk(&format!("{path}/{name}"), depth + 1, entries)?;
        }
        Ok(())
    }

    /// The entry of a dataset; one that cannot be described has the reason.
    fn dataset_entry(&self, path: &str) -> Entry {
        let described = self.file.dataset(path).and_then(|dataset| {
            let shape: Vec<usize> = dataset
                .shape()?
                .iter()
                .map(|&extent| usize::try_from(extent).unwrap_or(usize::MAX))
                .collect();
            let element = element_of(&dataset.datatype()?);
            let (attributes, unread) =
                known_attributes(dataset.attrs()?, dataset.attr_datatypes()?);
            Ok((shape, element, attributes, unread))
        });
        Entry::of_dataset(path, described)
    }

    /// All values of a dataset.
    pub(super) fn read(&self, entry: &Entry) -> Result<Values<'static>> {
        self.read_rows(entry, 0..usize::MAX, None, None)
    }

    /// The values of some rows (along the first axis) of a dataset; of texts, all.
    ///
    /// * `turn`: takes the bytes for a checksum
    /// * `spare`: its memory is used again where its type fits
    pub(super) fn read_rows(
        &self,
        entry: &Entry,
        rows: Range<usize>,
        turn: Option<Turn>,
        spare: Option<Values<'static>>,
    ) -> Result<Values<'static>> {
        let fail = |error| library_error(error, &self.path).field(&entry.path);
        let dataset = self.file.dataset(&entry.path).map_err(fail)?;
        let datatype = dataset.datatype().map_err(fail)?;
        check_size(
            &entry.path,
            entry.shape(),
            datatype.type_size() as usize,
            !dataset.filters().is_empty(),
            self.bytes,
        )
        .and_then(|()| self.check_chunks(&dataset))
        .map_err(|error| error.field(&entry.path).file(&self.path))?;
        if matches!(element_of(&datatype), Element::Text) {
            return Ok(Values::Text(dataset.read_string().map_err(fail)?));
        }
        values_of(self, &dataset, &datatype, rows, turn, spare)
            .map_err(fail)?
            .ok_or_else(|| {
                not_understood(&dataset, &datatype)
                    .file(&self.path)
                    .field(&entry.path)
            })
    }

    /// True where a dataset of complex numbers lies in the file as it does in memory, one
    /// value after the other.
    pub(super) fn lies_in_one_stretch(&self, entry: &Entry) -> bool {
        self.file
            .dataset(&entry.path)
            .and_then(|dataset| lies_in_one_stretch(self, &dataset))
            .unwrap_or(false)
    }

    /// Refuses a dataset with a chunk that ends beyond the file: the library allocates memory
    /// for neighbouring chunks before it reads them.
    fn check_chunks(&self, dataset: &Dataset) -> Result<()> {
        if !dataset.is_chunked() {
            return Ok(());
        }
        let chunks = dataset
            .chunks()
            .map_err(|error| library_error(error, &self.path))?;
        match chunks.iter().find(|chunk| {
            chunk
                .address
                .checked_add(chunk.storage_size)
                .is_none_or(|end| end > self.bytes)
        }) {
            None => Ok(()),
            Some(chunk) => Err(
                Error::bad_data("a piece of the dataset ends beyond the file")
                    .found(format!(
                        "{} bytes from byte {} on",
                        chunk.storage_size, chunk.address
                    ))
                    .expected(format!(
                        "an end within the file, which has {} bytes",
                        self.bytes
                    ))
                    .help("the file is cut or damaged; copy or write it again"),
            ),
        }
    }
}

/// The error for values of such a type, or with such a direction.
fn not_understood(dataset: &Dataset, datatype: &Datatype) -> Error {
    let is_dof = element_of(datatype) == Element::Dof;
    let unknown = is_dof
        .then(|| unknown_direction(dataset, datatype))
        .flatten();
    if let Some([node, code]) = unknown {
        return unknown_direction_code(node, code);
    }
    let error =
        Error::bad_data("values of a type that cannot be read").found(describe_unread(datatype));
    error
        .expected("numbers of single or double precision, text, or records of this program")
        .help("save the array again as float32, float64, complex64 or complex128")
}

/// The error of a DOF record whose direction code is none.
fn unknown_direction_code(node: i128, code: i128) -> Error {
    Error::bad_data("an unknown direction code")
        .found(format!("direction code {code} of node {node}"))
        .expected("0 for a scalar, ±1 X, ±2 Y, ±3 Z, or ±4 to ±6 for rotations")
        .help("correct it in the program that wrote the file")
}

fn known_attributes(
    values: HashMap<String, AttrValue>,
    types: HashMap<String, Datatype>,
) -> (Attributes, Unread) {
    let mut known = Attributes::new();
    let mut unread = Vec::new();
    // complex and other attributes are left out of `values` without an error; their types
    // are still listed
    let mut names: Vec<_> = types.into_iter().collect();
    names.sort_by(|a, b| a.0.cmp(&b.0));
    for (name, datatype) in names {
        let value = values.get(&name);
        let attribute = value.and_then(|value| {
            let texts = value.as_strings().filter(|texts| !texts.is_empty());
            let text = texts.map(|texts| Attribute::Text(Attribute::joined(texts)));
            text.or_else(|| value.as_i64().map(Attribute::Integer))
                .or_else(|| value.as_f64().map(Attribute::Real))
        });
        match attribute {
            Some(attribute) => known.push((name, attribute)),
            None if value.is_some() => {} // an array of numbers: not needed here
            None => {
                let why = format!("{} cannot be read", element_of(&datatype).describe());
                unread.push((name, why));
            }
        }
    }
    (known, unread)
}
