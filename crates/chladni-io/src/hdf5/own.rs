//! Our own layout (version 1):
//!
//! ```text
//! /                attrs: format="chladni", version=1, created_by, frf_kind, reference_unit, time_sign="+", source_file, source_sha256
//! /freq            f64 [n_line]                                          attr unit="Hz"
//! /frf             complex [n_response, n_reference, n_line], compound {r, i}, attr unit; NaN where nothing was measured
//! /coherence       f32 [n_response, n_reference, n_line], NaN where not given            optional
//! /variance        f64 [n_response, n_reference, n_line], E|δH|², written by `estimate`  optional
//! /estimation      how `estimate` made them, attributes alone: estimator, window, window_rate_per_s, forcing, burst_part, transform_s, gate_s, hop_s, averages_least, averages_most, lines_per_value   optional
//! /response        {node u64, dir i8} [n_response]
//! /reference       {node u64, dir i8} [n_reference]
//! /geometry/nodes  {label u64, x y z f64} [n_node], metres                               optional
//! /geometry/lines  u64 node labels of all polylines one after another, /geometry/lines_start u64 where each begins (faces too)
//! /functions/K     other functions of a source file, K = 1, 2, ...                       optional
//! /shapes/K        mode shapes and fields of a source file                               optional
//! /model           a modal model                                                         optional
//! ```

use super::backend::File;
use super::estimation;
use super::units;
use crate::arrays::foreign::scale;
use crate::arrays::tree::{Entry, Group, Values};
use crate::arrays::values::{checked, dofs, integers, real_array, reals, wrong_type, ComplexArray};
use chladni_frf::{
    Error, FrfKind, FrfSet, FrfValues, Geometry, Node, ReferenceUnit, Result, TimeSign,
};
use ndarray::{Array1, Array3, Ix3};

/// `format` of the root.
pub(super) const FORMAT: &str = "chladni";
/// `version` of the root.
const VERSION: i64 = 1;

/// True for the datasets that [`Own`] reads into a document. A model is none of them.
pub(super) fn is_carried(path: &str) -> bool {
    let known = [
        "/freq",
        "/frf",
        "/coherence",
        "/variance",
        "/response",
        "/reference",
    ];
    known.contains(&path)
        || path.starts_with("/geometry/")
        || path.starts_with("/functions/")
        || path.starts_with("/shapes/")
}

/// An open file of our own layout.
pub(super) struct Own<'a> {
    pub(super) file: &'a File,
    /// Sorted by path.
    pub(super) entries: &'a [Entry],
}

impl Own<'_> {
    /// Refuses versions that are not known here.
    pub(super) fn check_version(&self) -> Result<()> {
        let found = self.root().integer("version");
        if found == Some(VERSION) {
            return Ok(());
        }
        Err(Error::bad_data("a layout of another version")
            .field("version of /")
            .found(found.map_or("nothing".into(), |version| version.to_string()))
            .expected(VERSION)
            .help("read it with the program that wrote it, or a newer one"))
    }

    pub(super) fn root(&self) -> &Entry {
        &self.entries[0]
    }

    pub(super) fn find(&self, path: &str) -> Option<&Entry> {
        self.entries
            .binary_search_by(|entry| entry.path.as_str().cmp(path))
            .ok()
            .map(|at| &self.entries[at])
    }

    /// The dataset at `path`, which must exist.
    pub(super) fn dataset(&self, path: &str) -> Result<(&Entry, Values<'static>)> {
        let entry = self.find(path).ok_or_else(|| missing(path))?;
        Ok((entry, self.file.read(entry)?))
    }

    /// The groups `folder`/1, 2, ..., by rising number.
    pub(super) fn numbered(&self, folder: &str) -> Result<Vec<&Entry>> {
        let mut groups: Vec<(u64, &Entry)> = Vec::new();
        for entry in self
            .entries
            .iter()
            .filter(|entry| entry.folder() == folder && entry.dataset.is_none())
        {
            let number = entry.name().parse().map_err(|_| {
                Error::bad_data("a group without a number")
                    .field(&entry.path)
                    .found(entry.name())
                    .expected(format!("{folder}/1, 2, ..."))
            })?;
            groups.push((number, entry));
        }
        groups.sort_by_key(|(number, _)| *number);
        Ok(groups.into_iter().map(|(_, entry)| entry).collect())
    }

    /// The FRFs, in the time sign of the file; `None` in a file without.
    pub(super) fn frf(&self) -> Result<Option<FrfSet>> {
        if self.find("/frf").is_none() {
            return Ok(None);
        }
        let (entry, values) = self.dataset("/frf")?;
        let to_si = units::of_frf(entry)?.map_or(1.0, |(_, unit)| unit.to_si);
        let set = FrfSet {
            coherence: self.beside_frf("/coherence", |value| value as f32)?,
            variance: self.beside_frf("/variance", |value| value * to_si * to_si)?,
            ..self.set_of(own_array(
                ComplexArray::new(self.frf_entry()?, values)?,
                entry,
            )?)?
        };
        checked(set, &entry.path).map(Some)
    }

    /// The entry of the FRFs, which must have three axes.
    pub(super) fn frf_entry(&self) -> Result<&Entry> {
        let entry = self.find("/frf").ok_or_else(|| missing("/frf"))?;
        match entry.shape().len() {
            3 => Ok(entry),
            _ => Err(wrong_type(entry, "three axes: response, reference, line")),
        }
    }

    /// A set of these values.
    pub(super) fn set_of(&self, values: FrfValues) -> Result<FrfSet> {
        let (freq_entry, freq) = self.dataset("/freq")?;
        let to_hz = units::to_hz(freq_entry)?;
        let (response_entry, responses) = self.dataset("/response")?;
        let (reference_entry, references) = self.dataset("/reference")?;
        let unit = units::of_frf(self.frf_entry()?)?;
        let (kind, reference_unit) = units::agreed(unit, self.kind()?, self.reference_unit()?)?;
        Ok(FrfSet {
            frequency_hz: Array1::from(reals(freq_entry, freq)?) * to_hz,
            values,
            responses: dofs(response_entry, responses)?,
            references: dofs(reference_entry, references)?,
            kind,
            reference_unit,
            coherence: None,
            variance: None,
            estimation: self
                .find(estimation::PATH)
                .map(estimation::read_estimation)
                .transpose()?,
            geometry: self.geometry()?,
        })
    }

    fn attribute<T: std::str::FromStr<Err = String>>(&self, name: &str) -> Result<Option<T>> {
        let Some(text) = self.root().text(name) else {
            return Ok(None);
        };
        text.parse().map(Some).map_err(|message: String| {
            Error::bad_word(&message, text).field(format!("{name} of /"))
        })
    }

    /// Refuses a file whose kind, unit or time sign cannot be read: its values are unknown.
    pub(super) fn check_read(&self) -> Result<()> {
        for name in ["frf_kind", "reference_unit", "time_sign"] {
            let mut unread = self.root().unread_attributes.iter();
            if let Some((_, why)) = unread.find(|(found, _)| found == name) {
                return Err(Error::bad_data("what the values are cannot be read")
                    .field(format!("{name} of /"))
                    .found(why)
                    .expected("an attribute that can be read")
                    .help("the file is damaged: copy it again from where it was made"));
            }
        }
        Ok(())
    }

    fn kind(&self) -> Result<Option<FrfKind>> {
        self.attribute("frf_kind")
    }

    fn reference_unit(&self) -> Result<Option<ReferenceUnit>> {
        match self.root().text("reference_unit") {
            None => Ok(None),
            Some("N") => Ok(Some(ReferenceUnit::Newton)),
            Some("V") => Ok(Some(ReferenceUnit::Volt)),
            Some(other) => Err(Error::bad_data("unknown unit")
                .field("reference_unit of /")
                .found(other)
                .expected("N or V")),
        }
    }

    /// Time sign that the file states.
    pub(super) fn time_sign(&self) -> Result<Option<TimeSign>> {
        self.attribute("time_sign")
    }

    /// Reads an array of the shape of the FRFs, if there is one.
    fn beside_frf<T>(&self, path: &str, convert: impl Fn(f64) -> T) -> Result<Option<Array3<T>>> {
        if self.find(path).is_none() {
            return Ok(None);
        }
        let (entry, values) = self.dataset(path)?;
        let array = real_array(entry, values)?;
        let array = array
            .into_dimensionality::<Ix3>()
            .map_err(|_| wrong_type(entry, "three axes: response, reference, line"))?;
        Ok(Some(array.mapv(convert)))
    }

    pub(super) fn geometry(&self) -> Result<Geometry> {
        let mut geometry = Geometry::default();
        if self.find("/geometry/nodes").is_some() {
            let (entry, values) = self.dataset("/geometry/nodes")?;
            let Values::Nodes(nodes) = values else {
                return Err(wrong_type(entry, "records {label u64, x y z f64}"));
            };
            refuse_nodes_without_place(&nodes)?;
            geometry.nodes = nodes;
        }
        geometry.lines = self.label_lists("/geometry/lines")?;
        geometry.faces = self.label_lists("/geometry/faces")?;
        Ok(geometry)
    }

    /// Node labels of polylines or faces; empty where the file has none.
    pub(super) fn label_lists(&self, path: &str) -> Result<Vec<Vec<u64>>> {
        if self.find(path).is_none() {
            return Ok(Vec::new());
        }
        let (entry, labels) = self.dataset(path)?;
        let labels = integers(entry, labels)?;
        let (entry, starts) = self.dataset(&format!("{path}_start"))?;
        let mut starts: Vec<usize> = integers(entry, starts)?
            .into_iter()
            .map(|start| usize::try_from(start).unwrap_or(usize::MAX))
            .collect();
        starts.push(labels.len());
        let lists = starts
            .windows(2)
            .map(|ends| labels.get(ends[0]..ends[1]).map(<[u64]>::to_vec))
            .collect::<Option<_>>();
        lists.ok_or_else(|| {
            Error::bad_data("list starts must rise and stay inside the list")
                .field(&entry.path)
                .found(format!("{} starts", starts.len() - 1))
                .expected(format!("at most {}", labels.len()))
        })
    }
}

/// Refuses a node with a coordinate that is no finite number.
fn refuse_nodes_without_place(nodes: &[Node]) -> Result<()> {
    let bad = nodes.iter().find_map(|node| {
        let axes = "xyz".chars().zip(node.xyz_m);
        let (axis, value) = axes.into_iter().find(|(_, value)| !value.is_finite())?;
        Some((node.label, axis, value))
    });
    let Some((label, axis, value)) = bad else {
        return Ok(());
    };
    Err(Error::bad_data("a coordinate is not a finite number")
        .field(format!("{axis} of node {label} in /geometry/nodes"))
        .found(value)
        .expected("a coordinate in metres")
        .help("correct the coordinate, or leave the node out of /geometry/nodes"))
}

fn missing(path: &str) -> Error {
    Error::bad_data("a dataset is missing")
        .field(path)
        .found("nothing")
        .expected("a dataset of this layout")
}

/// An array of three axes as FRF values in SI, without copying. `entry` states its unit.
pub(super) fn own_array(array: ComplexArray, entry: &Entry) -> Result<FrfValues> {
    let wrong = || wrong_type(entry, "three axes: response, reference, line");
    let mut values = match array {
        ComplexArray::Double(array) => {
            FrfValues::F64(array.into_dimensionality().map_err(|_| wrong())?)
        }
        ComplexArray::Single(array) => {
            FrfValues::F32(array.into_dimensionality().map_err(|_| wrong())?)
        }
    };
    if let Some((_, unit)) = units::of_frf(entry)? {
        scale(&mut values, unit.to_si);
    }
    Ok(values)
}

/// The root group of a new file, without content.
pub(super) fn new_root<'a>() -> Group<'a> {
    let mut root = Group::new("/");
    root.set("format", FORMAT);
    root.set("version", crate::arrays::tree::Attribute::Integer(VERSION));
    root.set("created_by", chladni_frf::CREATED_BY);
    root
}

/// Adds an FRF set to the root.
pub(super) fn add_frf<'a>(root: &mut Group<'a>, set: &'a FrfSet) {
    if let Some(kind) = set.kind {
        root.set("frf_kind", kind.as_str());
    }
    root.set("reference_unit", set.reference_unit.to_string());
    root.set("time_sign", "+");
    let (responses, references, lines) = set.values.dim();
    let shape = [responses, references, lines];
    root.add_reals("freq", &[lines], set.frequency_hz.to_vec());
    last(root).push(("unit".into(), "Hz".into()));
    root.add("frf", &shape, borrowed(&set.values));
    if let Some(kind) = set.kind {
        last(root).push(("unit".into(), kind.unit(set.reference_unit).into()));
    }
    if let Some(coherence) = &set.coherence {
        root.add("coherence", &shape, Values::Real32(contiguous(coherence)));
    }
    if let Some(variance) = &set.variance {
        root.add("variance", &shape, Values::Real64(contiguous(variance)));
    }
    if let Some(made) = &set.estimation {
        root.groups.push(estimation::estimation_group(made));
    }
    root.add(
        "response",
        &[responses],
        Values::Dofs(set.responses.clone()),
    );
    root.add(
        "reference",
        &[references],
        Values::Dofs(set.references.clone()),
    );
}

/// Adds nodes, lines and faces to the root, where there are any.
pub(super) fn add_geometry(root: &mut Group<'_>, geometry: &Geometry) {
    let mut group = Group::new("geometry");
    if !geometry.nodes.is_empty() {
        group.add(
            "nodes",
            &[geometry.nodes.len()],
            Values::Nodes(geometry.nodes.clone()),
        );
    }
    add_label_lists(&mut group, &geometry.lines, &geometry.faces);
    if !group.datasets.is_empty() {
        root.groups.push(group);
    }
}

/// Adds lines and faces to a group, where there are any.
pub(super) fn add_label_lists(group: &mut Group<'_>, lines: &[Vec<u64>], faces: &[Vec<u64>]) {
    for (name, lists) in [("lines", lines), ("faces", faces)] {
        if lists.is_empty() {
            continue;
        }
        let labels = lists.concat();
        let starts = lists.iter().scan(0, |at, list| {
            let start = *at;
            *at += list.len() as u64;
            Some(start)
        });
        let starts: Vec<u64> = starts.collect();
        group.add(
            &format!("{name}_start"),
            &[starts.len()],
            Values::Unsigned(starts.into()),
        );
        group.add(name, &[labels.len()], Values::Unsigned(labels.into()));
    }
}

fn last<'b>(group: &'b mut Group<'_>) -> &'b mut crate::arrays::tree::Attributes {
    let dataset = group.datasets.last_mut().expect("a dataset was just added");
    &mut dataset.attributes
}

fn borrowed(values: &FrfValues) -> Values<'_> {
    match values {
        FrfValues::F64(values) => Values::Complex64(contiguous(values)),
        FrfValues::F32(values) => Values::Complex32(contiguous(values)),
    }
}

fn contiguous<T: Clone>(array: &Array3<T>) -> std::borrow::Cow<'_, [T]> {
    match array.as_slice() {
        Some(slice) => slice.into(),
        None => array.iter().cloned().collect::<Vec<_>>().into(),
    }
}
