//! Groups, datasets, values and attributes of a file, without the types of any library.

use crate::limits::{BEST_COMPRESSION, MAX_DEPTH, MAX_OBJECTS};
use chladni_frf::{Dof, Error, Node, Result};
use num_complex::{Complex32, Complex64};
use std::borrow::Cow;
use std::fmt::Display;
use std::path::Path;

/// Values of a dataset in C order (last axis fastest). Borrowed when written, owned when
/// read.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Values<'a> {
    Real64(Cow<'a, [f64]>),
    Real32(Cow<'a, [f32]>),
    Complex64(Cow<'a, [Complex64]>),
    Complex32(Cow<'a, [Complex32]>),
    Unsigned(Cow<'a, [u64]>),
    Signed(Cow<'a, [i64]>),
    Text(Vec<String>),
    /// Records `{node u64, dir i8}`.
    Dofs(Vec<Dof>),
    /// Records `{label u64, x y z f64}`.
    Nodes(Vec<Node>),
}

impl Values<'_> {
    /// Their element type.
    pub(crate) fn element(&self) -> Element {
        match self {
            Self::Real64(_) => Element::Real { single: false },
            Self::Real32(_) => Element::Real { single: true },
            Self::Complex64(_) => Element::Complex { single: false },
            Self::Complex32(_) => Element::Complex { single: true },
            Self::Unsigned(_) | Self::Signed(_) => Element::Integer,
            Self::Text(_) => Element::Text,
            Self::Dofs(_) => Element::Dof,
            Self::Nodes(_) => Element::Node,
        }
    }
}

/// Element type of a dataset in a file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Element {
    Real {
        single: bool,
    },
    Complex {
        single: bool,
    },
    Integer,
    Text,
    Dof,
    Node,
    /// Anything else, described for the user.
    Other(String),
}

impl Element {
    /// Words for the user.
    pub(crate) fn describe(&self) -> String {
        match self {
            Self::Real { single: true } => "real, single precision".into(),
            Self::Real { single: false } => "real, double precision".into(),
            Self::Complex { single: true } => "complex, single precision".into(),
            Self::Complex { single: false } => "complex, double precision".into(),
            Self::Integer => "integer".into(),
            Self::Text => "text".into(),
            Self::Dof => "DOF records".into(),
            Self::Node => "node records".into(),
            Self::Other(name) => name.clone(),
        }
    }
}

/// Value of an attribute.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Attribute {
    Text(String),
    /// A text of fixed length. The built-in writer needs 4 KiB for one of variable length.
    /// h5py gives it as bytes. It is read back as [`Self::Text`].
    FixedText(String),
    Real(f64),
    Integer(i64),
}

impl From<&str> for Attribute {
    fn from(text: &str) -> Self {
        Self::Text(text.into())
    }
}

impl From<String> for Attribute {
    fn from(text: String) -> Self {
        Self::Text(text)
    }
}

impl Attribute {
    /// A list of texts as one: their common text, else all of them, joined by commas.
    pub(crate) fn joined(texts: &[String]) -> String {
        match texts {
            [first, rest @ ..] if rest.iter().all(|text| text == first) => first.clone(),
            texts => texts.join(", "),
        }
    }
}

/// Named attributes, in order.
pub(crate) type Attributes = Vec<(String, Attribute)>;

/// Names of attributes that cannot be read, each with the reason.
pub(crate) type Unread = Vec<(String, String)>;

/// A library's description of a dataset: shape, element type, attributes, and those that
/// cannot be read.
pub(crate) type Description = (Vec<usize>, Element, Attributes, Unread);

/// One object of a file: a group, or a dataset with its shape and element type.
#[derive(Debug, Clone)]
pub(crate) struct Entry {
    /// Absolute: `/geometry/nodes`; the root is `/`.
    pub(crate) path: String,
    /// `None` for a group.
    pub(crate) dataset: Option<(Vec<usize>, Element)>,
    pub(crate) attributes: Attributes,
    pub(crate) unread_attributes: Unread,
}

impl Entry {
    /// The dataset at `path`; one that cannot be described is listed with the reason.
    pub(crate) fn of_dataset<E: Display>(
        path: &str,
        described: std::result::Result<Description, E>,
    ) -> Self {
        let (shape, element, attributes, unread_attributes) = described.unwrap_or_else(|error| {
            (
                Vec::new(),
                Element::Other(format!("unreadable ({error})")),
                Attributes::new(),
                Vec::new(),
            )
        });
        Self {
            path: path.to_owned(),
            dataset: Some((shape, element)),
            attributes,
            unread_attributes,
        }
    }
    /// A sentence for each attribute that cannot be read.
    pub(crate) fn unread(&self) -> impl Iterator<Item = String> + '_ {
        let sentence = |(name, why): &(String, String)| format!("attribute {name}: {why}");
        self.unread_attributes.iter().map(sentence)
    }
    pub(crate) fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes
            .iter()
            .find(|(found, _)| found == name)
            .map(|(_, value)| value)
    }
    pub(crate) fn text(&self, name: &str) -> Option<&str> {
        match self.attribute(name) {
            Some(Attribute::Text(text)) => Some(text),
            _ => None,
        }
    }
    pub(crate) fn real(&self, name: &str) -> Option<f64> {
        match self.attribute(name) {
            Some(Attribute::Real(value)) => Some(*value),
            Some(Attribute::Integer(value)) => Some(*value as f64),
            _ => None,
        }
    }
    pub(crate) fn integer(&self, name: &str) -> Option<i64> {
        match self.attribute(name) {
            Some(Attribute::Integer(value)) => Some(*value),
            _ => None,
        }
    }
    /// Last part of the path.
    pub(crate) fn name(&self) -> &str {
        self.path.rsplit('/').next().unwrap_or_default()
    }
    /// The path of its group.
    pub(crate) fn folder(&self) -> &str {
        folder_of(&self.path)
    }
    /// The groups around it, from its own to the root.
    pub(crate) fn groups(&self) -> impl Iterator<Item = &str> {
        std::iter::successors(Some(self.folder()), |path| {
            (*path != "/").then(|| folder_of(path))
        })
    }
    /// Shape, empty for a group or scalar.
    pub(crate) fn shape(&self) -> &[usize] {
        self.dataset.as_ref().map_or(&[], |(shape, _)| shape)
    }
    pub(crate) fn element(&self) -> Option<&Element> {
        self.dataset.as_ref().map(|(_, element)| element)
    }
}

fn folder_of(path: &str) -> &str {
    match path.rfind('/') {
        Some(0) | None => "/",
        Some(end) => &path[..end],
    }
}

/// A dataset to be written.
#[derive(Debug, Clone)]
pub(crate) struct Dataset<'a> {
    pub(crate) name: String,
    pub(crate) shape: Vec<usize>,
    pub(crate) values: Values<'a>,
    pub(crate) attributes: Attributes,
}

/// A group to be written, with everything in it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Group<'a> {
    pub(crate) name: String,
    pub(crate) attributes: Attributes,
    pub(crate) datasets: Vec<Dataset<'a>>,
    pub(crate) groups: Vec<Group<'a>>,
}

impl<'a> Group<'a> {
    pub(crate) fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            ..Self::default()
        }
    }
    pub(crate) fn set(&mut self, name: &str, value: impl Into<Attribute>) {
        self.attributes.push((name.into(), value.into()));
    }
    pub(crate) fn add(&mut self, name: &str, shape: &[usize], values: Values<'a>) {
        self.datasets.push(Dataset {
            name: name.into(),
            shape: shape.to_vec(),
            values,
            attributes: Vec::new(),
        });
    }
    pub(crate) fn add_reals(&mut self, name: &str, shape: &[usize], values: Vec<f64>) {
        self.add(name, shape, Values::Real64(values.into()));
    }
    pub(crate) fn add_texts(&mut self, name: &str, texts: Vec<String>) {
        self.add(name, &[texts.len()], Values::Text(texts));
    }
}

/// Refuses groups nested too deeply, and too many objects, which a link in a circle makes.
pub(crate) fn check_nesting(path: &str, depth: usize, objects: usize) -> Result<()> {
    if depth <= MAX_DEPTH && objects <= MAX_OBJECTS {
        return Ok(());
    }
    Err(
        Error::bad_data("groups nested too deeply, or linked in a circle")
            .field(path)
            .found(format!("depth {depth}, {objects} objects"))
            .expected(format!(
                "at most depth {MAX_DEPTH} and {MAX_OBJECTS} objects"
            )),
    )
}

/// Refuses a shape of more values than the file can hold, before anything is allocated.
pub(crate) fn check_size(
    path: &str,
    shape: &[usize],
    element_bytes: usize,
    filtered: bool,
    file_bytes: u64,
) -> Result<()> {
    // an extent of 0 counts as 1: memory is allocated for the other axes
    let claimed = shape
        .iter()
        .try_fold(element_bytes as u64, |product, &extent| {
            product.checked_mul(extent.max(1) as u64)
        });
    let room = if filtered {
        file_bytes.saturating_mul(BEST_COMPRESSION)
    } else {
        file_bytes
    };
    if claimed.is_some_and(|bytes| bytes <= room) {
        return Ok(());
    }
    Err(Error::bad_data("the dataset claims more values than the file can hold")
        .field(path)
        .found(format!("shape {shape:?} of {element_bytes}-byte elements"))
        .expected(format!("at most {room} bytes, the file has {file_bytes}"))
        .help("the file is damaged, or the dataset was created and never written; copy or write it \
               again"))
}

/// A failure of an HDF5 library on `file`.
pub(crate) fn library_error(error: impl Display, file: &Path) -> Error {
    let said = error.to_string();
    let error = Error::bad_data("the HDF5 library cannot read this")
        .file(file)
        .found(said.trim_start_matches("HDF5 format error: "));
    error.expected("a file of HDF5 1.14 or older, unfiltered or with gzip, shuffle or lzf").help(
        "if other programs read the file, re-save it: in h5py with libver='earliest' and no filters but gzip, shuffle or lzf, \
         or with `h5repack -f NONE`; complex numbers as compound {r, i}",
    )
}
