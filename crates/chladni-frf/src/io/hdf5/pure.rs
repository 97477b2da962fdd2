//! Back end in pure Rust: no library to install.
//!
//! Everything is decoded from the raw bytes by the type that the file declares, so that a member name or byte order which is
//! not understood is an error and never a row of zeros.

use super::tree::{check_size, library_error, Attribute, Attributes, Element, Entry, Group, Values};
use crate::{Direction, Dof, Error, Node, Result};
use hdf5_pure::{AttrValue, CompoundTypeBuilder, Datatype, DatatypeByteOrder, FileBuilder, LibVer};
use num_complex::{Complex32, Complex64};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Objects in one file; a link that leads back to its own group would otherwise never end.
const MAX_OBJECTS: usize = 100_000;
/// Depth of groups.
const MAX_DEPTH: usize = 32;

/// An open file.
pub(super) struct File {
    path: PathBuf,
    bytes: u64,
    file: hdf5_pure::File,
}

impl File {
    pub(super) fn open(path: &Path) -> Result<Self> {
        let file = hdf5_pure::File::open(path).map_err(|error| match error {
            hdf5_pure::Error::Io(error) => Error::from_read(&error, path),
            error => library_error(error, path),
        })?;
        Ok(Self { path: path.to_path_buf(), bytes: file.file_size(), file })
    }

    /// Every group and dataset, the root first, sorted by path.
    pub(super) fn entries(&self) -> Result<Vec<Entry>> {
        let mut entries = Vec::new();
        self.walk("", 0, &mut entries)?;
        entries.sort_by(|a: &Entry, b| a.path.cmp(&b.path));
        Ok(entries)
    }

    fn walk(&self, path: &str, depth: usize, entries: &mut Vec<Entry>) -> Result<()> {
        if depth > MAX_DEPTH || entries.len() > MAX_OBJECTS {
            return Err(Error::bad_data("groups nested too deeply, or linked in a circle").file(&self.path).field(path));
        }
        let fail = |error| library_error(error, &self.path).field(if path.is_empty() { "/" } else { path });
        let group = if path.is_empty() { self.file.root() } else { self.file.group(path).map_err(fail)? };
        let types = group.attr_datatypes().map_err(fail)?;
        let (attributes, unread_attributes) = known_attributes(group.attrs().map_err(fail)?, types);
        let shown = if path.is_empty() { "/".into() } else { path.into() };
        entries.push(Entry { path: shown, dataset: None, attributes, unread_attributes });
        for name in group.datasets().map_err(fail)? {
            entries.push(self.dataset_entry(&format!("{path}/{name}")));
        }
        for name in group.groups().map_err(fail)? {
            self.walk(&format!("{path}/{name}"), depth + 1, entries)?;
        }
        Ok(())
    }

    /// A dataset that cannot be described is listed with the reason.
    fn dataset_entry(&self, path: &str) -> Entry {
        let described = self.file.dataset(path).and_then(|dataset| {
            let shape: Vec<usize> = dataset.shape()?.iter().map(|&extent| usize::try_from(extent).unwrap_or(usize::MAX)).collect();
            let element = element_of(&dataset.datatype()?);
            let (attributes, unread) = known_attributes(dataset.attrs()?, dataset.attr_datatypes()?);
            Ok((shape, element, attributes, unread))
        });
        let path = path.to_owned();
        match described {
            Ok((shape, element, attributes, unread_attributes)) => {
                Entry { path, dataset: Some((shape, element)), attributes, unread_attributes }
            }
            Err(error) => Entry {
                path,
                dataset: Some((Vec::new(), Element::Other(format!("unreadable ({error})")))),
                attributes: Vec::new(),
                unread_attributes: Vec::new(),
            },
        }
    }

    /// All values of a dataset.
    pub(super) fn read(&self, entry: &Entry) -> Result<Values<'static>> {
        let fail = |error| library_error(error, &self.path).field(&entry.path);
        let dataset = self.file.dataset(&entry.path).map_err(fail)?;
        let datatype = dataset.datatype().map_err(fail)?;
        check_size(&entry.path, entry.shape(), datatype.type_size() as usize, !dataset.filters().is_empty(), self.bytes)
            .map_err(|error| error.file(&self.path))?;
        if matches!(element_of(&datatype), Element::Text) {
            return Ok(Values::Text(dataset.read_string().map_err(fail)?));
        }
        let raw = dataset.read_raw().map_err(fail)?;
        let values = decode(&datatype, &raw)
            .ok_or_else(|| Error::bad_data("values of a type that cannot be read").found(element_of(&datatype).describe()))
            .map_err(|error| error.file(&self.path).field(&entry.path))?;
        Ok(values)
    }
}

fn known_attributes(values: HashMap<String, AttrValue>, types: HashMap<String, Datatype>) -> (Attributes, Vec<String>) {
    let mut known = Attributes::new();
    let mut unread = Vec::new();
    // complex and other attributes are left out of `values` without an error; their types are still listed
    let mut names: Vec<_> = types.into_iter().collect();
    names.sort_by(|a, b| a.0.cmp(&b.0));
    for (name, datatype) in names {
        let value = values.get(&name);
        let attribute = value.and_then(|value| {
            let text = value.as_str().map(|text| Attribute::Text(text.into()));
            text.or_else(|| value.as_i64().map(Attribute::Integer)).or_else(|| value.as_f64().map(Attribute::Real))
        });
        match attribute {
            Some(attribute) => known.push((name, attribute)),
            None if value.is_some() => {} // an array of numbers or texts: nothing here asks for one
            None => unread.push(format!("attribute `{name}` ({}) cannot be read", element_of(&datatype).describe())),
        }
    }
    (known, unread)
}

fn element_of(datatype: &Datatype) -> Element {
    match datatype {
        Datatype::FloatingPoint { size: 8, .. } => Element::Real { single: false },
        Datatype::FloatingPoint { size: 4, .. } => Element::Real { single: true },
        Datatype::FixedPoint { size: 1 | 2 | 4 | 8, .. } | Datatype::Enumeration { size: 1 | 2 | 4 | 8, .. } => Element::Integer,
        Datatype::String { .. } | Datatype::VariableLength { is_string: true, .. } => Element::Text,
        Datatype::Compound { members, .. } => {
            let names: Vec<&str> = members.iter().map(|member| member.name.as_str()).collect();
            match names.as_slice() {
                [first, second] if is_complex_pair(first, second) => {
                    Element::Complex { single: members.iter().all(|member| element_of(&member.datatype) == Element::Real { single: true }) }
                }
                ["node", "dir"] => Element::Dof,
                ["label", "x", "y", "z"] => Element::Node,
                _ => Element::Other(format!("records {{{}}}", names.join(", "))),
            }
        }
        Datatype::Reference { .. } => Element::Other("object references (a MATLAB cell array?)".into()),
        _ => Element::Other("a type of its own".into()),
    }
}

/// The two spellings of complex numbers, and what home-made files use; MATLAB writes `real`, `imag`, h5py `r`, `i`.
fn is_complex_pair(first: &str, second: &str) -> bool {
    let (first, second) = (first.to_ascii_lowercase(), second.to_ascii_lowercase());
    [("r", "i"), ("real", "imag"), ("re", "im")].contains(&(first.as_str(), second.as_str()))
}

/// A number of a file: width, kind and byte order.
#[derive(Clone, Copy)]
enum Number {
    Float32 { big: bool },
    Float64 { big: bool },
    Integer { size: usize, signed: bool, big: bool },
}

impl Number {
    fn of(datatype: &Datatype) -> Option<Self> {
        let is_big = |order: &DatatypeByteOrder| match order {
            DatatypeByteOrder::LittleEndian => Some(false),
            DatatypeByteOrder::BigEndian => Some(true),
            DatatypeByteOrder::Vax => None,
        };
        match datatype {
            Datatype::FloatingPoint { size: 4, byte_order, layout } if *layout == hdf5_pure::FloatingPointLayout::IEEE754_BINARY32 => {
                Some(Self::Float32 { big: is_big(byte_order)? })
            }
            Datatype::FloatingPoint { size: 8, byte_order, layout } if *layout == hdf5_pure::FloatingPointLayout::IEEE754_BINARY64 => {
                Some(Self::Float64 { big: is_big(byte_order)? })
            }
            Datatype::FixedPoint { size, byte_order, layout }
                if layout.bit_offset == 0 && u32::from(layout.bit_precision) == 8 * size && matches!(size, 1 | 2 | 4 | 8) =>
            {
                Some(Self::Integer { size: *size as usize, signed: layout.signed, big: is_big(byte_order)? })
            }
            Datatype::Enumeration { base_type, .. } => Self::of(base_type),
            _ => None,
        }
    }

    fn integer(self, bytes: &[u8]) -> Option<i128> {
        let Self::Integer { size, signed, big } = self else { return None };
        let mut word = [0_u8; 8];
        for (k, &byte) in bytes.get(..size)?.iter().enumerate() {
            word[if big { size - 1 - k } else { k }] = byte;
        }
        let unused = 64 - 8 * size as u32;
        let value = u64::from_le_bytes(word);
        Some(if signed { i128::from(((value << unused) as i64) >> unused) } else { i128::from(value) })
    }

    fn real(self, bytes: &[u8]) -> Option<f64> {
        match self {
            Self::Float32 { .. } => self.single(bytes).map(f64::from),
            Self::Float64 { big } => {
                let word = bytes.get(..8)?.try_into().ok()?;
                Some(if big { f64::from_be_bytes(word) } else { f64::from_le_bytes(word) })
            }
            Self::Integer { .. } => self.integer(bytes).map(|value| value as f64),
        }
    }

    fn single(self, bytes: &[u8]) -> Option<f32> {
        let Self::Float32 { big } = self else { return None };
        let word = bytes.get(..4)?.try_into().ok()?;
        Some(if big { f32::from_be_bytes(word) } else { f32::from_le_bytes(word) })
    }
}

/// The values behind `raw`; `None` for types that are not understood.
fn decode(datatype: &Datatype, raw: &[u8]) -> Option<Values<'static>> {
    let size = datatype.type_size() as usize;
    if size == 0 || !raw.len().is_multiple_of(size) {
        return None;
    }
    let elements = raw.chunks_exact(size);
    match element_of(datatype) {
        Element::Real { single: true } => {
            let number = Number::of(datatype)?;
            Some(Values::Real32(elements.map(|bytes| number.single(bytes)).collect::<Option<Vec<_>>>()?.into()))
        }
        Element::Real { single: false } => {
            let number = Number::of(datatype)?;
            Some(Values::Real64(elements.map(|bytes| number.real(bytes)).collect::<Option<Vec<_>>>()?.into()))
        }
        Element::Integer => {
            let number = Number::of(datatype)?;
            let values: Vec<i128> = elements.map(|bytes| number.integer(bytes)).collect::<Option<_>>()?;
            match values.iter().map(|&value| u64::try_from(value).ok()).collect::<Option<Vec<_>>>() {
                Some(unsigned) => Some(Values::Unsigned(unsigned.into())),
                None => Some(Values::Signed(values.iter().map(|&value| i64::try_from(value).ok()).collect::<Option<Vec<_>>>()?.into())),
            }
        }
        Element::Complex { single } => {
            let (re, im) = (Member::of(datatype, 0)?, Member::of(datatype, 1)?);
            if single {
                let value = |bytes| Some(Complex32::new(re.number.single(re.cut(bytes)?)?, im.number.single(im.cut(bytes)?)?));
                return Some(Values::Complex32(elements.map(value).collect::<Option<Vec<_>>>()?.into()));
            }
            let value = |bytes| Some(Complex64::new(re.real(bytes)?, im.real(bytes)?));
            Some(Values::Complex64(elements.map(value).collect::<Option<Vec<_>>>()?.into()))
        }
        Element::Dof => {
            let (node, direction) = (Member::of(datatype, 0)?, Member::of(datatype, 1)?);
            let dof = |bytes| {
                let code = i64::try_from(direction.integer(bytes)?).ok()?;
                Some(Dof::new(u64::try_from(node.integer(bytes)?).ok()?, Direction::from_code(code)?))
            };
            Some(Values::Dofs(elements.map(dof).collect::<Option<_>>()?))
        }
        Element::Node => {
            let members: Vec<Member> = (0..4).map(|k| Member::of(datatype, k)).collect::<Option<_>>()?;
            let node = |bytes| {
                let label = u64::try_from(members[0].integer(bytes)?).ok()?;
                Some(Node { label, xyz_m: [members[1].real(bytes)?, members[2].real(bytes)?, members[3].real(bytes)?] })
            };
            Some(Values::Nodes(elements.map(node).collect::<Option<_>>()?))
        }
        Element::Text | Element::Other(_) => None,
    }
}

/// A number inside a record.
#[derive(Clone, Copy)]
struct Member {
    offset: usize,
    number: Number,
}

impl Member {
    fn of(datatype: &Datatype, index: usize) -> Option<Self> {
        let Datatype::Compound { members, .. } = datatype else { return None };
        let member = members.get(index)?;
        Some(Self { offset: usize::try_from(member.byte_offset).ok()?, number: Number::of(&member.datatype)? })
    }
    fn cut(self, bytes: &[u8]) -> Option<&[u8]> {
        bytes.get(self.offset..)
    }
    fn real(self, bytes: &[u8]) -> Option<f64> {
        self.number.real(self.cut(bytes)?)
    }
    fn integer(self, bytes: &[u8]) -> Option<i128> {
        self.number.integer(self.cut(bytes)?)
    }
}

/// Writes a file of the 1.8 format (read by everything), contiguous and uncompressed, without time stamps.
pub(super) fn write(path: &Path, root: &Group<'_>) -> Result<()> {
    let fail = |error: hdf5_pure::Error| match error {
        hdf5_pure::Error::Io(error) => crate::io::atomic::write_error(&error, path),
        error => Error::new(crate::ErrorKind::Internal, format!("HDF5: {error}")).file(path),
    };
    let mut file = FileBuilder::new();
    file.with_libver_bounds(LibVer::Earliest, LibVer::V18);
    for (name, value) in &root.attributes {
        file.set_attr(name, attribute_value(value));
    }
    for dataset in &root.datasets {
        fill(file.create_dataset(&dataset.name), dataset).map_err(fail)?;
    }
    for group in &root.groups {
        let built = build_group(file.create_group(&group.name), group).map_err(fail)?;
        file.add_group(built);
    }
    file.write(path).map_err(fail)
}

fn build_group(mut builder: hdf5_pure::GroupBuilder, group: &Group<'_>) -> std::result::Result<hdf5_pure::FinishedGroup, hdf5_pure::Error> {
    for (name, value) in &group.attributes {
        builder.set_attr(name, attribute_value(value));
    }
    for dataset in &group.datasets {
        fill(builder.create_dataset(&dataset.name), dataset)?;
    }
    for inner in &group.groups {
        let built = build_group(builder.create_group(&inner.name), inner)?;
        builder.add_group(built);
    }
    Ok(builder.finish())
}

fn attribute_value(value: &Attribute) -> AttrValue {
    match value {
        Attribute::Text(text) => AttrValue::VarLenString(text.clone()),
        Attribute::Real(value) => AttrValue::F64(*value),
        Attribute::Integer(value) => AttrValue::I64(*value),
    }
}

fn fill(builder: &mut hdf5_pure::DatasetBuilder, dataset: &super::tree::Dataset<'_>) -> std::result::Result<(), hdf5_pure::Error> {
    let shape: Vec<u64> = dataset.shape.iter().map(|&extent| extent as u64).collect();
    let count = shape.iter().product();
    builder.with_shape(&shape);
    match &dataset.values {
        Values::Real64(values) => builder.with_f64_data(values),
        Values::Real32(values) => builder.with_f32_data(values),
        Values::Unsigned(values) => builder.with_u64_data(values),
        Values::Signed(values) => builder.with_i64_data(values),
        Values::Complex64(values) => {
            let mut bytes = Vec::with_capacity(size_of_val(&values[..]));
            for value in values.iter() {
                bytes.extend_from_slice(&value.re.to_le_bytes());
                bytes.extend_from_slice(&value.im.to_le_bytes());
            }
            builder.with_compound_data(CompoundTypeBuilder::new().f64_field("r").f64_field("i").build()?, bytes, count)
        }
        Values::Complex32(values) => {
            let mut bytes = Vec::with_capacity(size_of_val(&values[..]));
            for value in values.iter() {
                bytes.extend_from_slice(&value.re.to_le_bytes());
                bytes.extend_from_slice(&value.im.to_le_bytes());
            }
            builder.with_compound_data(CompoundTypeBuilder::new().f32_field("r").f32_field("i").build()?, bytes, count)
        }
        Values::Text(texts) => builder.with_vlen_strings(&texts.iter().map(String::as_str).collect::<Vec<_>>()),
        Values::Dofs(dofs) => {
            let record = |dof: &Dof| [&dof.node.to_le_bytes()[..], &dof.direction.code().to_le_bytes()].concat();
            let datatype = CompoundTypeBuilder::new().u64_field("node").i8_field("dir").build()?;
            builder.with_compound_data(datatype, dofs.iter().flat_map(record).collect(), count)
        }
        Values::Nodes(nodes) => {
            let record = |node: &Node| {
                [node.label.to_le_bytes(), node.xyz_m[0].to_le_bytes(), node.xyz_m[1].to_le_bytes(), node.xyz_m[2].to_le_bytes()].concat()
            };
            let datatype = CompoundTypeBuilder::new().u64_field("label").f64_field("x").f64_field("y").f64_field("z").build()?;
            builder.with_compound_data(datatype, nodes.iter().flat_map(record).collect(), count)
        }
    };
    for (name, value) in &dataset.attributes {
        builder.set_attr(name, attribute_value(value));
    }
    Ok(())
}
