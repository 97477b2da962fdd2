//! Back end of the C library (feature `system`), for files with filters or layouts that
//! the built-in one refuses.
//!
//! The library converts records by the names of their members and leaves members that it
//! does not find at zero, without an error: an array of `{real, imag}` read as `{r, i}`
//! is all zeros. So the names are compared before anything is read.
//!
//! Avoid it for damaged or hostile files: they can crash or hang the C library (version
//! 1.10 at least); the built-in back end refuses them.

mod write;

pub(super) use write::write;

use crate::arrays::tree::{
    check_nesting, check_size, library_error, Attribute, Attributes, Element, Entry, Values,
};
use crate::Turn;
use chladni_frf::{Direction, Dof, Error, Node, Result};
use chladni_text::door::{place_of, Place};
use hdf5::types::{
    FixedAscii, FixedUnicode, FloatSize, TypeDescriptor, VarLenAscii, VarLenUnicode,
};
use hdf5::{Container, H5Type, Location, LocationType};
use num_complex::{Complex, Complex32, Complex64};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Longest fixed-length text that is read.
const TEXT_BYTES: usize = 4096;

/// Complex numbers as MATLAB writes them.
#[derive(H5Type, Clone, Copy)]
#[repr(C)]
struct RealImag<T: H5Type> {
    real: T,
    imag: T,
}

/// Complex numbers as home-made files have them.
#[derive(H5Type, Clone, Copy)]
#[repr(C)]
struct ReIm<T: H5Type> {
    re: T,
    im: T,
}

#[derive(H5Type, Clone, Copy)]
#[repr(C)]
struct DofRecord {
    node: u64,
    dir: i8,
}

#[derive(H5Type, Clone, Copy)]
#[repr(C)]
struct NodeRecord {
    label: u64,
    x: f64,
    y: f64,
    z: f64,
}

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
        // no lock: it fails on some network shares, and where a process that was started
        // meanwhile still holds the writer's
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

    /// A dataset that cannot be described is listed with the reason.
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

    /// The values of some rows (along the first axis) of a dataset {r, i} with three
    /// axes. The library takes its own memory.
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
        match element_of(&descriptor) {
            Element::Complex { single } if is_own => {
                let window = ndarray::s![rows, .., ..];
                Ok(if single {
                    Values::Complex32(
                        dataset
                            .read_slice::<Complex32, _, ndarray::Ix3>(window)
                            .map_err(fail)?
                            .into_raw_vec_and_offset()
                            .0
                            .into(),
                    )
                } else {
                    Values::Complex64(
                        dataset
                            .read_slice::<Complex64, _, ndarray::Ix3>(window)
                            .map_err(fail)?
                            .into_raw_vec_and_offset()
                            .0
                            .into(),
                    )
                })
            }
            other => Err(Error::bad_data("values of a type that cannot be read")
                .file(&self.path)
                .field(&entry.path)
                .found(other.describe())
                .expected("complex numbers, a compound {r, i}")),
        }
    }
}

fn attributes_of(location: &Location) -> hdf5::Result<(Attributes, Vec<String>)> {
    let (mut known, mut unread) = (Attributes::new(), Vec::new());
    let mut names = location.attr_names()?;
    names.sort();
    for name in names {
        let described = location
            .attr(&name)
            .and_then(|attribute| Ok((attribute.dtype()?.to_descriptor()?, attribute)));
        let Ok((descriptor, attribute)) = described else {
            unread.push(format!("attribute `{name}` cannot be read"));
            continue;
        };
        match (element_of(&descriptor), attribute.size()) {
            (Element::Text | Element::Integer | Element::Real { .. }, 1) => {
                match read_values(&attribute, &descriptor)? {
                    Some(Values::Text(texts)) => known.extend(
                        texts
                            .into_iter()
                            .next()
                            .map(|text| (name, Attribute::Text(text))),
                    ),
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
                    _ => unread.push(format!("attribute `{name}` cannot be read")),
                }
            }
            (Element::Text | Element::Integer | Element::Real { .. }, _) => {} // a list: nothing here asks for one
            (element, _) => unread.push(format!(
                "attribute `{name}` ({}) cannot be read",
                element.describe()
            )),
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

/// Values by their type in the file; `None` for types that are not understood.
fn read_values(
    container: &Container,
    descriptor: &TypeDescriptor,
) -> hdf5::Result<Option<Values<'static>>> {
    Ok(Some(match element_of(descriptor) {
        Element::Real { single: true } => Values::Real32(container.read_raw::<f32>()?.into()),
        Element::Real { single: false } => Values::Real64(container.read_raw::<f64>()?.into()),
        Element::Integer => match descriptor {
            TypeDescriptor::Integer(_) => {
                let values = container.read_raw::<i64>()?;
                match values
                    .iter()
                    .map(|&value| u64::try_from(value).ok())
                    .collect::<Option<Vec<u64>>>()
                {
                    Some(unsigned) => Values::Unsigned(unsigned.into()),
                    None => Values::Signed(values.into()),
                }
            }
            TypeDescriptor::Unsigned(_) => Values::Unsigned(container.read_raw::<u64>()?.into()),
            TypeDescriptor::Boolean => Values::Unsigned(
                container
                    .read_raw::<bool>()?
                    .into_iter()
                    .map(u64::from)
                    .collect(),
            ),
            _ => return Ok(None),
        },
        Element::Text => return texts(container, descriptor),
        Element::Complex { single: true } => {
            Values::Complex32(complex::<f32>(container, descriptor)?.into())
        }
        Element::Complex { single: false } => {
            Values::Complex64(complex::<f64>(container, descriptor)?.into())
        }
        Element::Dof => {
            let dof = |record: DofRecord| {
                Some(Dof::new(
                    record.node,
                    Direction::from_code(record.dir.into())?,
                ))
            };
            match container
                .read_raw::<DofRecord>()?
                .into_iter()
                .map(dof)
                .collect()
            {
                Some(dofs) => Values::Dofs(dofs),
                None => return Ok(None),
            }
        }
        Element::Node => {
            let node = |record: NodeRecord| Node {
                label: record.label,
                xyz_m: [record.x, record.y, record.z],
            };
            Values::Nodes(
                container
                    .read_raw::<NodeRecord>()?
                    .into_iter()
                    .map(node)
                    .collect(),
            )
        }
        Element::Other(_) => return Ok(None),
    }))
}

fn complex<T: H5Type + Copy>(
    container: &Container,
    descriptor: &TypeDescriptor,
) -> hdf5::Result<Vec<Complex<T>>> {
    let TypeDescriptor::Compound(compound) = descriptor else {
        return Ok(Vec::new());
    };
    match compound.fields.first().map(|field| field.name.as_str()) {
        Some("real") => Ok(container
            .read_raw::<RealImag<T>>()?
            .into_iter()
            .map(|value| Complex {
                re: value.real,
                im: value.imag,
            })
            .collect()),
        Some("re") => Ok(container
            .read_raw::<ReIm<T>>()?
            .into_iter()
            .map(|value| Complex {
                re: value.re,
                im: value.im,
            })
            .collect()),
        _ => container.read_raw::<Complex<T>>(),
    }
}

fn texts(
    container: &Container,
    descriptor: &TypeDescriptor,
) -> hdf5::Result<Option<Values<'static>>> {
    fn all<T: H5Type + std::fmt::Display>(container: &Container) -> hdf5::Result<Vec<String>> {
        Ok(container
            .read_raw::<T>()?
            .iter()
            .map(T::to_string)
            .collect())
    }
    let texts = match *descriptor {
        TypeDescriptor::VarLenUnicode => all::<VarLenUnicode>(container)?,
        TypeDescriptor::VarLenAscii => all::<VarLenAscii>(container)?,
        TypeDescriptor::FixedUnicode(size) if size <= TEXT_BYTES => {
            all::<FixedUnicode<TEXT_BYTES>>(container)?
        }
        TypeDescriptor::FixedAscii(size) if size <= TEXT_BYTES => {
            all::<FixedAscii<TEXT_BYTES>>(container)?
        }
        _ => return Ok(None),
    };
    Ok(Some(Values::Text(texts)))
}
