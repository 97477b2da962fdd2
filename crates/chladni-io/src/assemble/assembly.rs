//! The FRFs and coherence of all documents, before they become one set.

use super::grid::{self, DofList};
use super::record::{self, axis_of, clean_coherence, from_function, from_set, place_of, Record};
use super::{geometry, known_kind, COHERENCE, FRF};
use crate::{Contents, DeclaredDofs, Document, Function, Ordinate, ReadOptions};
use chladni_frf::{Dof, Finding, FrfKind, FrfSet, Geometry, Result, TimeSign};
use chladni_text::file_name;
use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;

/// The records of all documents, and all that belongs to them.
#[derive(Default)]
pub(super) struct Assembly {
    pub(super) records: Vec<Record>,
    pub(super) responses: DofList,
    references: DofList,
    coherence: HashMap<(Dof, Dof), Vec<(Function, String)>>,
    /// Names of the documents, for messages.
    files: Vec<String>,
    /// For each document the number of the first one of the same content.
    pub(super) originals: Vec<usize>,
}

impl Assembly {
    pub(super) fn take(
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

    /// Attaches coherence to the FRF of its pair. Coherence that fits no FRF joins the other
    /// functions.
    pub(super) fn attach_coherence(&mut self, contents: &mut Contents) {
        for record in &mut self.records {
            let Some(found) = self.coherence.get_mut(&(record.response, record.reference)) else {
                continue;
            };
            // of several, the first from the same file
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
    pub(super) fn declare(&mut self, list: &DeclaredDofs) -> Result<()> {
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

    /// Takes the coherence that belongs to no FRF, in a fixed order.
    pub(super) fn left_coherence(&mut self) -> Vec<(Function, String)> {
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

    /// The set of all records, without geometry.
    pub(super) fn into_set(
        self,
        options: &ReadOptions,
        warnings: &mut Vec<Finding>,
    ) -> Result<FrfSet> {
        let Self {
            mut records,
            responses,
            references,
            originals,
            ..
        } = self;
        if options.lenient {
            record::lengthen(&mut records, warnings);
        }
        let duplicates = options.duplicates;
        let mut set = grid::build(
            records, responses, references, duplicates, &originals, warnings,
        )?;
        grid::clean(&mut set, "", warnings);
        Ok(set)
    }

    pub(super) fn apply_kind(&mut self, told: Option<FrfKind>, warnings: &mut Vec<Finding>) {
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

fn real_part(ordinate: &Ordinate) -> Vec<f64> {
    match ordinate {
        Ordinate::Real32(values) => values.iter().map(|&value| value.into()).collect(),
        Ordinate::Real64(values) => values.clone(),
        Ordinate::Complex32(values) => values.iter().map(|value| value.re.into()).collect(),
        Ordinate::Complex64(values) => values.iter().map(|value| value.re).collect(),
    }
}
