//! Back end of the C library (feature `system`), for files with filters or layouts that
//! the built-in one refuses.
//!
//! The library converts records by the names of their members. A member that it does not
//! find stays zero, without an error: `{real, imag}` read as `{r, i}` gives zeros. Therefore
//! the names are compared before anything is read.
//!
//! Avoid it for damaged or hostile files: they can crash or hang the C library (1.10 and
//! perhaps others). The built-in back end refuses them.

mod values;
mod write;

pub(super) use write::write;

use crate::arrays::tree::{
    check_nesting, check_size, library_error, Attribute, Attributes, Element, Entry, Unread, Values,
};
use crate::Turn;
use chladni_frf::{Error, Result};
use chladni_text::door::{place_of, Place};
use hdf5::types::{FloatSize, TypeDescriptor};
use hdf5::{Location, LocationType};
use ndarray::{Ix3, SliceInfo, SliceInfoElem};
use std::ops::Range;
use std::path::{Path, PathBuf};
use values::read_values;

/// An open file.
pub(super) struct File {
    path: PathBuf,
    bytes: u64,
    file: hdf5::File,
    _place: Place,
}

impl File {
    pub(super) fn open(path: &Path) -> Result<Self> {
        let place = place_of(path)?;
        let metadata =
            std::fs::metadata(&*place).map_err(|error| Error::from_read(&error, path))?;
        // no lock: locking fails on some network shares, and while a child process still holds
        // the lock of the writer
        let unlocked = hdf5::File::with_options()
            .with_fapl(|access| access.file_locking(false))
            .open(&*place);
        let file = unlocked.map_err(|error| library_error(error, path))?;
        Ok(Self {
            path: path.to_path_buf(),
            bytes: metadata.len(),
            file,
            _place: place,
        })
    }

    /// Every group and dataset, sorted by path, the root first.
    pub(super) fn entries(&self) -> Result<Vec<Entry>> {
        let mut entries = Vec::new();
        self.walk("", 0, &mut entries)?;
        entries.sort_by(|a: &Entry, b| a.path.cmp(&b.path));
        Ok(entries)
    }

    fn walk(&self, path: &str, depth: usize, entries: &mut Vec<Entry>) -> Result<()> {
        check_nesting(path, depth, entries.len()).map_err(|error| error.file(&self.path))?;
        let shown = if path.is_empty() { "/" } else { path };
        let fail = |error| library_error(error, &self.path).field(shown);
        let group = self.file.group(shown).map_err(fail)?;
        let (attributes, unread_attributes) = attributes_of(&group).map_err(fail)?;
        entries.push(Entry {
            path: shown.into(),
            dataset: None,
            attributes,
            unread_attributes,
        });
        for name in group.member_names().map_err(fail)? {
            let inner = format!("{path}/{name}");
            match group.loc_type_by_name(&name) {
                Ok(LocationType::Group) => self.walk(&inner, depth + 1, entries)?,
                Ok(LocationType::Dataset) => entries.push(self.dataset_entry(&inner)),
                // a committed type, or a link that leads nowhere
                _ => {}
            }
        }
        Ok(())
    }

    /// The entry of a dataset; one that cannot be described has the reason.
    fn dataset_entry(&self, path: &str) -> Entry {
        let described = self.file.dataset(path).and_then(|dataset| {
            let element = element_of(&dataset.dtype()?.to_descriptor()?);
            let (attributes, unread) = attributes_of(&dataset)?;
            Ok((dataset.get_shape()?, element, attributes, unread))
        });
        Entry::of_dataset(path, described)
    }

    /// All values of a dataset.
    pub(super) fn read(&self, entry: &Entry) -> Result<Values<'static>> {
        let fail = |error| library_error(error, &self.path).field(&entry.path);
        let dataset = self.file.dataset(&entry.path).map_err(fail)?;
        let datatype = dataset.dtype().map_err(fail)?;
        let descriptor = datatype.to_descriptor().map_err(fail)?;
        let filtered = !dataset.filters().is_empty();
        check_size(
            &entry.path,
            entry.shape(),
            datatype.size(),
            filtered,
            self.bytes,
        )
        .map_err(|error| error.file(&self.path))?;
        let values = read_values(&dataset, &descriptor).map_err(fail)?;
        values.ok_or_else(|| {
            Error::bad_data("values of a type that cannot be read")
                .file(&self.path)
                .field(&entry.path)
                .found(element_of(&descriptor).describe())
        })
    }
}

impl File {
    /// False: the library hands over values, not the bytes of the file.
    pub(super) fn lies_in_one_stretch(&self, _: &Entry) -> bool {
        false
    }

    /// The values of some rows (along the first axis) of a dataset {r, i} or of real numbers
    /// with three axes. The library takes its own memory.
    pub(super) fn read_rows(
        &self,
        entry: &Entry,
        rows: Range<usize>,
        _turn: Option<Turn>,
        _spare: Option<Values<'static>>,
    ) -> Result<Values<'static>> {
        let fail = |error| library_error(error, &self.path).field(&entry.path);
        let dataset = self.file.dataset(&entry.path).map_err(fail)?;
        let datatype = dataset.dtype().map_err(fail)?;
        let descriptor = datatype.to_descriptor().map_err(fail)?;
        check_size(
            &entry.path,
            entry.shape(),
            datatype.size(),
            !dataset.filters().is_empty(),
            self.bytes,
        )
        .map_err(|error| error.file(&self.path))?;
        let is_own = matches!(&descriptor, TypeDescriptor::Compound(compound) if compound.fields.iter().map(|field| field.name.as_str()).eq(["r", "i"]));
        let window = ndarray::s![rows, .., ..];
        Ok(match element_of(&descriptor) {
            Element::Complex { single: true } if is_own => {
                Values::Complex32(slice_of(&dataset, window).map_err(fail)?.into())
            }
            Element::Complex { single: false } if is_own => {
                Values::Complex64(slice_of(&dataset, window).map_err(fail)?.into())
            }
            Element::Real { single: true } => {
                Values::Real32(slice_of(&dataset, window).map_err(fail)?.into())
            }
            Element::Real { single: false } => {
                Values::Real64(slice_of(&dataset, window).map_err(fail)?.into())
            }
            other => {
                return Err(Error::bad_data("values of a type that cannot be read")
                    .file(&self.path)
                    .field(&entry.path)
                    .found(other.describe())
                    .expected("complex numbers, a compound {r, i}, or real numbers"))
            }
        })
    }
}

/// The values in a window of a dataset.
fn slice_of<T: hdf5::H5Type>(
    dataset: &hdf5::Dataset,
    window: SliceInfo<[SliceInfoElem; 3], Ix3, Ix3>,
) -> hdf5::Result<Vec<T>> {
    let values = dataset.read_slice::<T, _, Ix3>(window)?;
    Ok(values.into_raw_vec_and_offset().0)
}

fn attributes_of(location: &Location) -> hdf5::Result<(Attributes, Unread)> {
    let (mut known, mut unread) = (Attributes::new(), Unread::new());
    let mut names = location.attr_names()?;
    names.sort();
    for name in names {
        let described = location
            .attr(&name)
            .and_then(|attribute| Ok((attribute.dtype()?.to_descriptor()?, attribute)));
        let Ok((descriptor, attribute)) = described else {
            unread.push((name, "it cannot be read".into()));
            continue;
        };
        match (element_of(&descriptor), attribute.size()) {
            (Element::Text, 1..) | (Element::Integer | Element::Real { .. }, 1) => {
                match read_values(&attribute, &descriptor)? {
                    Some(Values::Text(texts)) => {
                        known.push((name, Attribute::Text(Attribute::joined(&texts))))
                    }
                    Some(Values::Real64(values)) => known.push((name, Attribute::Real(values[0]))),
                    Some(Values::Real32(values)) => {
                        known.push((name, Attribute::Real(values[0].into())))
                    }
                    Some(Values::Signed(values)) => {
                        known.push((name, Attribute::Integer(values[0])))
                    }
                    Some(Values::Unsigned(values)) => match i64::try_from(values[0]) {
                        Ok(value) => known.push((name, Attribute::Integer(value))),
                        Err(_) => known.push((name, Attribute::Real(values[0] as f64))),
                    },
                    _ => unread.push((name, "it cannot be read".into())),
                }
            }
            (Element::Text | Element::Integer | Element::Real { .. }, _) => {} // a list of numbers: not needed here
            (element, _) => {
                unread.push((name, format!("{} cannot be read", element.describe())));
            }
        }
    }
    Ok((known, unread))
}

fn element_of(descriptor: &TypeDescriptor) -> Element {
    match descriptor {
        TypeDescriptor::Float(FloatSize::U8) => Element::Real { single: false },
        TypeDescriptor::Float(FloatSize::U4) => Element::Real { single: true },
        TypeDescriptor::Integer(_)
        | TypeDescriptor::Unsigned(_)
        | TypeDescriptor::Boolean
        | TypeDescriptor::Enum(_) => Element::Integer,
        TypeDescriptor::FixedAscii(_)
        | TypeDescriptor::FixedUnicode(_)
        | TypeDescriptor::VarLenAscii
        | TypeDescriptor::VarLenUnicode => Element::Text,
        TypeDescriptor::Compound(compound) => {
            let names: Vec<&str> = compound
                .fields
                .iter()
                .map(|field| field.name.as_str())
                .collect();
            match names.as_slice() {
                ["r", "i"] | ["real", "imag"] | ["re", "im"] => {
                    let single = compound
                        .fields
                        .iter()
                        .all(|field| field.ty == TypeDescriptor::Float(FloatSize::U4));
                    Element::Complex { single }
                }
                ["node", "dir"] => Element::Dof,
                ["label", "x", "y", "z"] => Element::Node,
                _ => Element::Other(format!("records {{{}}}", names.join(", "))),
            }
        }
        TypeDescriptor::Reference(_) => {
            Element::Other("object references (a MATLAB cell array?)".into())
        }
        _ => Element::Other("a type of its own".into()),
    }
}
