//! One set from several documents: functions grouped by (response, reference),
//! single-reference files merged, coherence attached to its FRF.
//!
//! Nothing is guessed and nothing is dropped silently: an unknown kind stays unknown, missing
//! pairs are listed, and functions that are no FRFs are kept in [`Contents::functions`].

mod assembly;
mod axis;
mod copies;
mod geometry;
mod grid;
mod record;
mod side;

pub use copies::same_files;
pub(crate) use geometry::merge as merge_geometry;
pub(crate) use record::clean_coherence;
pub(crate) use side::{node_for, refuse_several, Side};

use super::{Contents, Document, Duplicates, FileFormat, Function, ReadOptions};
use assembly::Assembly;
use chladni_frf::{
    Dof, Error, ErrorKind, Finding, FrfKind, FrfSet, Geometry, ReferenceUnit, Result, Source,
};
use copies::told_copies;
use grid::DofList;
use num_complex::Complex64;
use record::{place_of, Line, Record};
use side::override_node;
use std::path::Path;
use std::rc::Rc;

/// Function types of dataset 58.
pub(crate) const FRF: i32 = 4;
/// Ordinary coherence.
pub(crate) const COHERENCE: i32 = 6;

/// Merges documents into one set of FRFs, and keeps all other content.
///
/// # Errors
/// The first damaged dataset (unless `lenient`); axes that differ by half a line or more;
/// mixed kinds or reference units; duplicated pairs, unless `duplicates` says which to take;
/// nodes at two positions; a reference of the caller that does not fit.
pub fn assemble(documents: Vec<Document>, options: &ReadOptions) -> Result<Contents> {
    if !options.delay_s.is_finite() {
        return Err(Error::new(ErrorKind::Usage, "this delay is no time")
            .field("delay")
            .found(options.delay_s)
            .expected("seconds, as in 0.0012")
            .help("give the delay that a fit of these data names, or none"));
    }
    let mut contents = merged(documents, options)?;
    if let Some(set) = contents.frf.as_mut().filter(|_| options.delay_s != 0.0) {
        set.advance(options.delay_s);
    }
    Ok(contents)
}

/// The content as the files have it, but for the options that concern single ones.
fn merged(documents: Vec<Document>, options: &ReadOptions) -> Result<Contents> {
    let mut contents = Contents::default();
    let mut geometry = Geometry::default();
    let mut assembly = Assembly::default();
    let mut with_frfs: Vec<Source> = Vec::new();
    let documents = without_results(documents, &mut contents.warnings);
    assembly.originals = copies::originals(&documents);
    let count = documents.len();
    let as_in_files = options.dofs.rows.is_empty();
    let is_one_set = as_in_files
        && count == 1
        && documents[0].frf.is_some()
        && !documents[0].functions.iter().any(is_measured);
    for (number, mut document) in documents.into_iter().enumerate() {
        report(&mut document, options.lenient, &mut contents.warnings)?;
        let (responses, references) = (&options.responses, &options.references);
        let node = node_for(Side::Response, responses, number, count)?;
        override_node(&mut document, Side::Response, node)?;
        let node = node_for(Side::Reference, references, number, count)?;
        override_node(&mut document, Side::Reference, node)?;
        if document.frf.is_some() || document.functions.iter().any(is_frf) {
            with_frfs.extend(document.source());
        }
        contents.sources.extend(document.source());
        contents.not_carried.extend(super::not_carried(&document));
        geometry::merge(
            &mut geometry,
            std::mem::take(&mut document.geometry),
            &document.file,
        )?;
        if let Some(set) = document.frf.take_if(|_| is_one_set) {
            // nothing to merge: the array stays where it is
            keep(set, document, geometry, options.frf_kind, &mut contents)?;
            return Ok(contents);
        }
        assembly.take(document, number, options, &mut geometry, &mut contents)?;
    }
    if assembly.records.is_empty() && assembly.responses.dofs.is_empty() {
        let coherence = assembly.left_coherence().into_iter();
        contents
            .functions
            .extend(coherence.map(|(function, _)| function));
        let copies = Source::copies(&with_frfs);
        let told = copies.map(|words| Finding::note("same-files", words));
        contents.warnings.extend(told);
        contents.other_geometry = geometry;
        return Ok(contents);
    }
    assembly.attach_coherence(&mut contents);
    if !as_in_files {
        assembly.declare(&options.dofs)?;
    }
    contents.warnings.extend(told_copies(
        &with_frfs,
        options.duplicates,
        &assembly.records,
        &assembly.originals,
    ));
    assembly.apply_kind(options.frf_kind, &mut contents.warnings);
    let mut set = assembly.into_set(options, &mut contents.warnings)?;
    geometry::note_nodes_without_place(&geometry, &set, &mut contents.warnings);
    set.geometry = geometry;
    contents.frf = Some(set);
    Ok(contents)
}

/// The documents of measurements. Results are left out and named in `warnings`.
fn without_results(documents: Vec<Document>, warnings: &mut Vec<Finding>) -> Vec<Document> {
    let (results, documents): (Vec<_>, Vec<_>) = documents
        .into_iter()
        .partition(|document| matches!(document.format, FileFormat::Model | FileFormat::Weights));
    warnings.extend(results.iter().map(|document| left_out(&document.file)));
    documents
}

/// The finding about a result among measurements.
pub(crate) fn left_out(file: &Path) -> Finding {
    let words = format!("{}: left out, a result and no measurement", file.display());
    Finding::caution("not-read", words)
}

/// Keeps the set of the only document as it is, and all else in it.
fn keep(
    mut set: FrfSet,
    document: Document,
    mut geometry: Geometry,
    told: Option<FrfKind>,
    contents: &mut Contents,
) -> Result<()> {
    let warnings = &mut contents.warnings;
    let own_geometry = std::mem::take(&mut set.geometry);
    geometry::merge(&mut geometry, own_geometry, &document.file)?;
    let file = document.file.display().to_string();
    set.kind = known_kind(set.kind, told, &file, warnings);
    grid::clean(&mut set, &file, warnings);
    geometry::note_nodes_without_place(&geometry, &set, warnings);
    set.geometry = geometry;
    contents.functions = document.functions;
    contents.shapes = document.shapes;
    contents.frf = Some(set.checked()?);
    Ok(())
}

/// Returns the first error of a damaged dataset, and passes warnings on, equal ones once.
fn report(document: &mut Document, lenient: bool, warnings: &mut Vec<Finding>) -> Result<()> {
    let errors = std::mem::take(&mut document.errors)
        .into_iter()
        .map(|error| error.file(&document.file));
    for error in errors {
        if !lenient {
            return Err(error);
        }
        warnings.push(Finding::caution(
            "damaged-left-out",
            format!("left out: {error}"),
        ));
    }
    let file = document.file.display();
    warnings.extend(document.warnings.iter().map(|warning| warning.about(&file)));
    let mut counted: Vec<(&Finding, u64, usize)> = Vec::new();
    let of_functions = document
        .functions
        .iter()
        .map(|function| (&function.warnings, function.line));
    let of_shapes = document
        .shapes
        .iter()
        .map(|shape| (&shape.warnings, shape.line));
    for (warnings, line) in of_functions.chain(of_shapes) {
        for warning in warnings {
            match counted.iter_mut().find(|(known, ..)| *known == warning) {
                Some((.., count)) => *count += 1,
                None => counted.push((warning, line, 1)),
            }
        }
    }
    for (warning, line, count) in counted {
        let mut warning = warning.about(place_of(document, line));
        if count > 1 {
            warning.text += &format!(" (and {} more datasets)", count - 1);
        }
        warnings.push(warning);
    }
    Ok(())
}

fn is_frf(function: &Function) -> bool {
    function.function_type == FRF
}

fn is_measured(function: &Function) -> bool {
    matches!(function.function_type, FRF | COHERENCE)
}

/// The kind of the FRFs: that of the user wins, and a file that contradicts it is reported.
fn known_kind(
    said: Option<FrfKind>,
    told: Option<FrfKind>,
    file: &str,
    warnings: &mut Vec<Finding>,
) -> Option<FrfKind> {
    if let (Some(said), Some(told)) = (said, told) {
        if said != told {
            warnings.push(Finding::caution(
                "option-overrules-file",
                format!("{file} says {said}, you say {told}: taken as {told}"),
            ));
        }
    }
    told.or(said)
}

/// One FRF of a table, in SI units, with its DOFs.
pub(super) struct TracedFrf {
    pub(super) response: Dof,
    pub(super) reference: Dof,
    pub(super) values: Vec<Complex64>,
    pub(super) coherence: Option<Vec<f32>>,
}

/// A set of the FRFs of one table, all on one axis.
pub(super) fn build_set(
    frequency_hz: Vec<f64>,
    frfs: Vec<TracedFrf>,
    kind: Option<FrfKind>,
    reference_unit: ReferenceUnit,
    duplicates: Duplicates,
    place: &str,
    warnings: &mut Vec<Finding>,
) -> Result<FrfSet> {
    let axis: Rc<[f64]> = frequency_hz.into();
    let record = |frf: TracedFrf| Record {
        response: frf.response,
        reference: frf.reference,
        frequency_hz: axis.clone(),
        line: Line::Double(frf.values),
        coherence: frf.coherence,
        variance: None,
        estimation: None,
        kind,
        reference_unit,
        document: 0,
        place: place.to_owned(),
    };
    let records = frfs.into_iter().map(record).collect();
    grid::build(
        records,
        DofList::default(),
        DofList::default(),
        duplicates,
        &[],
        warnings,
    )
}
