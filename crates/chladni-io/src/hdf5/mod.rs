//! HDF5: our own layout ([`own`]) and files of other programs (`arrays::foreign`).
//!
//! Two back ends have the same functions: pure Rust by default, and the C library with the
//! feature `system` (for files with filters or layouts that the built-in one refuses).

mod attributes;
#[cfg(not(feature = "system"))]
#[path = "pure/mod.rs"]
mod backend;
#[cfg(feature = "system")]
#[path = "system/mod.rs"]
mod backend;
mod estimation;
mod functions;
mod model;
mod own;
mod rows;
mod shapes;
mod units;

use super::arrays::foreign::{self, FoundFrf};
use super::arrays::tree::{Element, Entry, Values};
use super::arrays::ArrayFile;
use super::atomic::create_atomically;
use super::{Contents, DatasetInfo, Document, FileFormat, ReadOptions};
use backend::File;
use chladni_frf::{Error, Finding, FrfSet, FrfValues, ModalModel, Result};
use ndarray::Array3;
use num_complex::ComplexFloat;
use own::Own;
pub(super) use rows::Rows;
use std::path::Path;

impl ArrayFile for File {
    fn read(&self, entry: &Entry) -> Result<Values<'static>> {
        self.read(entry)
    }
}

/// Everything in an HDF5 file; the checksum is left out.
pub(super) fn read(path: &Path, options: &ReadOptions) -> Result<Document> {
    let file = File::open(path)?;
    let entries = file.entries()?;
    let mut document = Document::new(path, FileFormat::Hdf5);
    document.datasets = entries
        .iter()
        .filter(|entry| entry.dataset.is_some())
        .map(dataset_info)
        .collect();
    for entry in &entries {
        document.warnings.extend(
            entry
                .unread()
                .map(|words| Finding::note("not-read", format!("{}: {words}", entry.path))),
        );
    }
    let own = Own {
        file: &file,
        entries: &entries,
    };
    let outcome = if own.root().text("format") == Some(own::FORMAT) && options.map.is_empty() {
        read_own(&own, &mut document)
    } else {
        foreign::read_foreign(&file, &entries, options, &mut document.warnings)
    };
    foreign::take_frf(&mut document, outcome, options)?;
    if let Some(set) = &document.frf {
        report_masked(set, &mut document.warnings);
    }
    Ok(document)
}

fn read_own(own: &Own<'_>, document: &mut Document) -> Result<Option<FoundFrf>> {
    own.check_version()?;
    own.check_read()?;
    document.geometry = own.geometry()?;
    document.functions = functions::read_functions(own)?;
    for function in &document.functions {
        document.datasets.push(DatasetInfo {
            number: Some(58),
            name: "function".into(),
            function: Some(super::function_name(function.function_type).into()),
            response: Some(function.response.to_string()),
            reference: Some(function.reference.to_string()),
            values: Some(function.ordinate.len()),
            ..DatasetInfo::default()
        });
    }
    document.shapes = shapes::read_shapes(own)?;
    for shape in &document.shapes {
        document.datasets.push(DatasetInfo {
            number: Some(if shape.form == super::ShapeForm::AtNodes55 {
                55
            } else {
                2414
            }),
            name: "shape".into(),
            function: Some(shape.analysis.name().into()),
            nodes: Some(shape.nodes.len()),
            frequency_hz: shape.frequency_hz(),
            damping_ratio: shape.damping_ratio(),
            ..DatasetInfo::default()
        });
    }
    document
        .datasets
        .iter_mut()
        .for_each(|info| info.left_behind &= !own::is_carried(&info.name));
    let time_sign = own.time_sign()?;
    Ok(own.frf()?.map(|set| FoundFrf {
        set,
        time_sign,
        used: Vec::new(),
    }))
}

/// Reports lines that are NaN in measured pairs. Pairs that are NaN throughout are missing
/// ones, and are listed later.
fn report_masked(set: &FrfSet, warnings: &mut Vec<Finding>) {
    fn masked<C: ComplexFloat>(values: &Array3<C>) -> usize {
        let counts = values
            .rows()
            .into_iter()
            .map(|frf| (frf.iter().filter(|value| value.is_nan()).count(), frf.len()));
        counts
            .map(|(count, lines)| if count < lines { count } else { 0 })
            .sum()
    }
    let masked = match &set.values {
        FrfValues::F64(values) => masked(values),
        FrfValues::F32(values) => masked(values),
    };
    if masked > 0 {
        warnings.push(Finding::note(
            "lines-masked",
            format!("{masked} lines are NaN in the file: masked"),
        ));
    }
}

fn dataset_info(entry: &Entry) -> DatasetInfo {
    let (function, nodes) = match (entry.path.as_str(), entry.element()) {
        ("/frf", _) => ("frf".to_owned(), None),
        ("/coherence", _) => ("coherence".to_owned(), None),
        ("/variance", _) => ("variance".to_owned(), None),
        (_, Some(Element::Node)) => ("nodes".to_owned(), entry.shape().first().copied()),
        (_, element) => (element.map_or_else(String::new, Element::describe), None),
    };
    let extents: Vec<String> = entry.shape().iter().map(usize::to_string).collect();
    let function = if extents.is_empty() {
        function
    } else {
        format!("{function}, {}", extents.join(" x "))
    };
    DatasetInfo {
        name: entry.path.clone(),
        function: Some(function),
        values: entry.shape().last().copied(),
        nodes,
        warnings: entry
            .unread()
            .map(|words| Finding::note("not-read", words))
            .collect(),
        left_behind: true, // until its content is used
        ..DatasetInfo::default()
    }
}

/// Writes FRFs with their geometry, functions and shapes in our own layout, atomically.
pub(super) fn write(
    path: &Path,
    frf: Option<&FrfSet>,
    others: &Contents,
    force: bool,
) -> Result<()> {
    let mut root = own::new_root();
    if let Some(set) = frf {
        own::add_frf(&mut root, set);
    }
    own::add_geometry(
        &mut root,
        frf.map_or(&others.other_geometry, |set| &set.geometry),
    );
    if !others.sources.is_empty() {
        for (name, column) in model::source_columns(&others.sources) {
            root.set(&format!("source_{name}"), column.join("\n"));
        }
    }
    if !others.functions.is_empty() {
        root.groups
            .push(functions::functions_group(&others.functions));
    }
    if !others.shapes.is_empty() {
        root.groups.push(shapes::shapes_group(&others.shapes));
    }
    create_atomically(path, force, |temporary| backend::write(temporary, &root))
}

/// Writes a model under `/model`, atomically.
pub(super) fn write_model(path: &Path, model: &ModalModel, force: bool) -> Result<()> {
    let mut root = own::new_root();
    root.groups.push(model::model_group(model));
    create_atomically(path, force, |temporary| backend::write(temporary, &root))
}

/// Reads the model under `/model`.
pub(super) fn read_model(path: &Path) -> Result<ModalModel> {
    let file = File::open(path)?;
    let entries = file.entries().map_err(|error| error.file(path))?;
    let own = Own {
        file: &file,
        entries: &entries,
    };
    if own.find("/model").is_none() {
        return Err(Error::bad_data("the file holds no model")
            .file(path)
            .field("/model")
            .found("no such group")
            .expected("a model under /model")
            .help("fit a model first"));
    }
    own.check_version()
        .and_then(|()| model::read_model(&own))
        .map_err(|error| error.file(path))
}
