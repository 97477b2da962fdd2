//! Documents into one set: functions grouped by (response, reference), single-reference
//! files merged, coherence beside its FRF.
//!
//! Nothing is guessed and nothing disappears without a word: an unknown kind stays
//! unknown, missing pairs are listed, what is no FRF goes along in
//! [`Contents::functions`].

mod geometry;
mod grid;
mod record;
mod side;

pub(crate) use record::clean_coherence;

use super::{
    Contents, DeclaredDofs, Document, Duplicates, FileFormat, Function, Ordinate, ReadOptions,
};
use chladni_frf::{Dof, Finding, FrfKind, FrfSet, Geometry, ReferenceUnit, Result, TimeSign};
use chladni_text::file_name;
use grid::DofList;
use num_complex::Complex64;
use record::{axis_of, from_function, from_set, place_of, Line, Record};
use side::{node_for, override_node, Side};
use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;

/// Function types of dataset 58.
const FRF: i32 = 4;
/// Ordinary coherence.
const COHERENCE: i32 = 6;

/// Merges documents into one set of FRFs, and keeps what else they hold.
///
/// # Errors
/// The first damaged dataset (unless `lenient`); axes that differ by half a line or more;
/// mixed kinds or reference units; duplicated pairs (unless told what to do); nodes at
/// two places; a reference of the caller that does not fit.
pub fn assemble(documents: Vec<Document>, options: &ReadOptions) -> Result<Contents> {
    let mut contents = Contents::default();
    let mut geometry = Geometry::default();
    let mut assembly = Assembly::default();
    let (results, documents): (Vec<_>, Vec<_>) = documents
        .into_iter()
        .partition(|document| matches!(document.format, FileFormat::Model | FileFormat::Weights));
    let left_out = |document: Document| {
        let words = format!(
            "{}: left out, a result and no measurement",
            document.file.display()
        );
        Finding::caution("not-read", words)
    };
    contents.warnings.extend(results.into_iter().map(left_out));
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
        contents.sources.extend(document.source());
        contents.not_carried.extend(super::not_carried(&document));
        geometry::merge(
            &mut geometry,
            std::mem::take(&mut document.geometry),
            &document.file,
        )?;
        if let Some(mut set) = document.frf.take_if(|_| is_one_set) {
            // nothing to merge: the array stays where it is
            geometry::merge(
                &mut geometry,
                std::mem::take(&mut set.geometry),
                &document.file,
            )?;
            let file = document.file.display().to_string();
            set.kind = known_kind(set.kind, options.frf_kind, &file, &mut contents.warnings);
            grid::clean(&mut set, &file, &mut contents.warnings);
            geometry::note_nodes_without_place(&geometry, &set, &mut contents.warnings);
            set.geometry = geometry;
            contents.functions = document.functions;
            contents.shapes = document.shapes;
            contents.frf = Some(set.checked()?);
            return Ok(contents);
        }
        assembly.take(document, number, options, &mut geometry, &mut contents)?;
    }
    if assembly.records.is_empty() && assembly.responses.dofs.is_empty() {
        contents.functions.extend(
            assembly
                .left_coherence()
                .into_iter()
                .map(|(function, _)| function),
        );
        contents.other_geometry = geometry;
        return Ok(contents);
    }
    assembly.attach_coherence(&mut contents);
    if !as_in_files {
        assembly.declare(&options.dofs)?;
    }
    assembly.apply_kind(options.frf_kind, &mut contents.warnings);
    let Assembly {
        mut records,
        responses,
        references,
        ..
    } = assembly;
    if options.lenient {
        record::lengthen(&mut records, &mut contents.warnings);
    }
    let mut set = grid::build(
        records,
        responses,
        references,
        options.duplicates,
        &mut contents.warnings,
    )?;
    grid::clean(&mut set, "", &mut contents.warnings);
    geometry::note_nodes_without_place(&geometry, &set, &mut contents.warnings);
    set.geometry = geometry;
    contents.frf = Some(set);
    Ok(contents)
}

/// Errors of damaged datasets stop here; warnings are passed on, equal ones once.
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

fn is_measured(function: &Function) -> bool {
    matches!(function.function_type, FRF | COHERENCE)
}

/// The user's word on the FRF kind wins; a file that says otherwise is named.
fn known_kind(
    said: Option<FrfKind>,
    told: Option<FrfKind>,
    file: &str,
    warnings: &mut Vec<Finding>,
) -> Option<FrfKind> {
    if let (Some(said), Some(told)) = (said, told) {
        if said != told {
            warnings.push(Finding::note(
                "option-overrules-file",
                format!("{file} says {said}, you say {told}: taken as {told}"),
            ));
        }
    }
    told.or(said)
}

/// Everything on its way into the set.
#[derive(Default)]
struct Assembly {
    records: Vec<Record>,
    responses: DofList,
    references: DofList,
    coherence: HashMap<(Dof, Dof), Vec<(Function, String)>>,
    /// Names of the documents, for messages.
    files: Vec<String>,
}

impl Assembly {
    fn take(
        &mut self,
        mut document: Document,
        number: usize,
        options: &ReadOptions,
        geometry: &mut Geometry,
        contents: &mut Contents,
    ) -> Result<()> {
        self.files.push(document.file.display().to_string());
        contents.shapes.append(&mut document.shapes);
        if let Some(mut set) = document.frf.take() {
            geometry::merge(geometry, std::mem::take(&mut set.geometry), &document.file)?;
            set.responses
                .iter()
                .for_each(|&dof| _ = self.responses.index_of(dof));
            set.references
                .iter()
                .for_each(|&dof| _ = self.references.index_of(dof));
            let place = document.file.display().to_string();
            self.records
                .extend(from_set(&set, number, &place, &mut contents.warnings));
        }
        let mut axis: Option<Rc<[f64]>> = None;
        for function in std::mem::take(&mut document.functions) {
            let place = place_of(&document, function.line);
            match function.function_type {
                FRF => {
                    let axis = axis_of(&function, &mut axis);
                    let conjugate = options.time_sign == TimeSign::Minus;
                    self.responses.index_of(function.response);
                    self.references.index_of(function.reference);
                    self.records.push(from_function(
                        function,
                        axis,
                        number,
                        place,
                        conjugate,
                        &mut contents.warnings,
                    )?);
                }
                COHERENCE => {
                    self.coherence
                        .entry((function.response, function.reference))
                        .or_default()
                        .push((function, place));
                }
                _ => contents.functions.push(function),
            }
        }
        Ok(())
    }

    /// Coherence beside the FRF of its pair; what fits no FRF goes along with the other
    /// functions.
    fn attach_coherence(&mut self, contents: &mut Contents) {
        for record in &mut self.records {
            let Some(found) = self.coherence.get_mut(&(record.response, record.reference)) else {
                continue;
            };
            // of several, the one from the same file, in the order of the file
            let same_file = |(_, place): &(Function, String)| {
                place.starts_with(self.files[record.document].as_str())
            };
            let at = found.iter().position(same_file).unwrap_or(0);
            let fits = found.get(at).is_some_and(|(function, _)| {
                let axis = axis_of(function, &mut None);
                axis.len() == record.frequency_hz.len()
                    && axis
                        .iter()
                        .zip(&*record.frequency_hz)
                        .all(|(a, b)| (a - b).abs() <= 1e-3 * b.abs())
            });
            if !fits {
                continue;
            }
            let (function, place) = found.remove(at);
            let (values, outside) = clean_coherence(real_part(&function.ordinate));
            if outside > 0 {
                contents.warnings.push(Finding::caution(
                    "coherence-invalid",
                    format!(
                        "{place}: coherence outside 0 to 1 on {outside} \
                                                lines; taken as not given there"
                    ),
                ));
            }
            record.coherence = Some(values);
        }
        let unmatched = self.left_coherence();
        if let Some((function, place)) = unmatched.first() {
            contents.warnings.push(Finding::note(
                "coherence-unmatched",
                format!(
                "{} coherence functions belong to no FRF, the first is ({}, {}) in {place}; not \
                 used as weights",
                unmatched.len(),
                function.response,
                function.reference
            ),
            ));
        }
        contents
            .functions
            .extend(unmatched.into_iter().map(|(function, _)| function));
    }

    /// Gives every FRF the DOFs of a list.
    fn declare(&mut self, list: &DeclaredDofs) -> Result<()> {
        let (mut at, mut names) = (0, Vec::new());
        (self.responses, self.references) = Default::default();
        for records in self.records.chunk_by_mut(|a, b| a.document == b.document) {
            let file = &self.files[records[0].document];
            let name = file_name(Path::new(file));
            let dofs = list.of_file(&name, records.len(), &mut at)?;
            names.push(name);
            for (record, (response, reference)) in records.iter_mut().zip(dofs) {
                (record.response, record.reference) = (response, reference);
                self.responses.index_of(response);
                self.references.index_of(reference);
            }
        }
        list.refuse_rest(&names, at)
    }

    /// Takes the coherence that belongs to no FRF, in an order that does not depend on
    /// hashing.
    fn left_coherence(&mut self) -> Vec<(Function, String)> {
        let mut left: Vec<(Function, String)> = std::mem::take(&mut self.coherence)
            .into_values()
            .flatten()
            .collect();
        left.sort_by(|(a, a_place), (b, b_place)| {
            (a_place, a.line, a.response, a.reference).cmp(&(
                b_place,
                b.line,
                b.response,
                b.reference,
            ))
        });
        left
    }

    fn apply_kind(&mut self, told: Option<FrfKind>, warnings: &mut Vec<Finding>) {
        let mut named = None;
        for record in &mut self.records {
            let mut unheard = Vec::new();
            // one warning for each file
            let said_already = named == Some(record.document);
            let heard = if said_already {
                &mut unheard
            } else {
                &mut *warnings
            };
            let before = heard.len();
            record.kind = known_kind(record.kind, told, &self.files[record.document], heard);
            if !said_already && heard.len() > before {
                named = Some(record.document);
            }
        }
    }
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
        warnings,
    )
}

fn real_part(ordinate: &Ordinate) -> Vec<f64> {
    match ordinate {
        Ordinate::Real32(values) => values.iter().map(|&value| value.into()).collect(),
        Ordinate::Real64(values) => values.clone(),
        Ordinate::Complex32(values) => values.iter().map(|value| value.re.into()).collect(),
        Ordinate::Complex64(values) => values.iter().map(|value| value.re).collect(),
    }
}
