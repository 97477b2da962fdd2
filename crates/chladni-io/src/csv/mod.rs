//! Text tables in the layouts that programs write, and our own.
//!
//! | layout | columns |
//! |---|---|
//! | one FRF per file | f, Re, Im, or f, magnitude, phase |
//! | wide, named pairs | f, then a pair of columns per FRF, DOFs in the header (`1Z:3Z`) |
//! | long | node, dir, ref_node, ref_dir, f, re, im |
//! | time records | t, then a column per channel, DOF and unit in the header (`101:+Z [N]`) |
//!
//! `# key = value` lines give `frf_kind`, `unit`, `time_sign`, `reference_unit`, and
//! `response` and `reference` of a single FRF. Delimiter and decimal sign are found by
//! trying; a column `coherence` may follow each FRF. The header must say what a column holds
//! and in which unit. Where two readings are possible, the table is refused, and the
//! message says what to write or which option to give.

mod column_header;
mod complex_cells;
mod cut;
mod dofs;
mod factors;
mod facts;
mod form;
mod frequency;
mod groups;
mod header;
mod long;
mod long_header;
mod remarks;
mod table;
mod text;
mod time;
mod vocabulary;
mod wide;
mod write;

use super::assemble::{build_set, clean_coherence, TracedFrf};
use super::limits::{COHERENCE_SLIPS, FIRST_NODE, SIX_DIGITS};
use super::unit_label::{frf_unit, FrfUnit};
use super::{DatasetInfo, Document, FileFormat, ReadOptions};
use chladni_frf::{Direction, Dof, Error, Finding, FrfKind, ReferenceUnit, Result};
use complex_cells::refuse_complex_lists;
use facts::{differ, refuse_contradictions, TableFacts};
use num_complex::Complex64;
use remarks::lines_and_remarks;
pub(crate) use remarks::numbered_lines;
use std::path::Path;
pub(super) use text::decode;
use text::Dialect;
use vocabulary::known_words;
pub(super) use write::write;

/// One FRF of a table, in the units of the table.
struct Trace {
    response: Option<Dof>,
    reference: Option<Dof>,
    values: Vec<Complex64>,
    coherence: Option<Vec<f64>>,
    /// Unit of its header; a remark `unit` holds for the whole file.
    unit: Option<FrfUnit>,
    unit_text: String,
}

/// Reads a table; `sha256` is left empty. FRFs without a DOF become responses at nodes
/// from `next_node` on.
pub(super) fn read(
    bytes: &[u8],
    file: &Path,
    options: &ReadOptions,
    next_node: &mut u64,
) -> Result<Document> {
    read_text(bytes, file, options, next_node).map_err(|error| error.file(file))
}

/// True where the head of a text file holds rows of numbers or the header of a long table,
/// damaged or not.
pub(super) fn is_table(head: &[u8]) -> bool {
    let text = decode(head);
    let (lines, _) = lines_and_remarks(&text);
    long_header::find(&lines).is_some()
        || Dialect::any_finds_rows(&lines)
        || refuse_complex_lists(&lines).is_err()
}

/// True where the first of these lines names the columns of a table: with known words, or
/// right above a row of numbers.
pub(super) fn is_header(first: &str, second: &str) -> bool {
    known_words(first) > 1 || Dialect::any_finds_row(second)
}

fn read_text(
    bytes: &[u8],
    file: &Path,
    options: &ReadOptions,
    next_node: &mut u64,
) -> Result<Document> {
    let text = decode(bytes);
    let (lines, remarks) = lines_and_remarks(&text);
    refuse_complex_lists(&lines)?;
    let mut warnings = Vec::new();
    let mut facts = TableFacts::from_remarks(&remarks, &mut warnings)?;
    facts.caller_phase_unit = options.phase_unit;
    let (first_line, (frequency_hz, traces)) = match long_header::find(&lines) {
        Some(table) => {
            refuse_contradictions(&remarks)?;
            facts.header_text = table.text_above();
            if let Some(label) = table.unit()? {
                facts.add_unit(label)?;
            }
            let traces = table.traces(&facts, options.lenient, &mut warnings)?;
            warnings.extend(cut::last_number(&text, &lines, table.columns.dialect));
            (table.first_line(), traces)
        }
        None => {
            // a header of a long table that lacks a DOF is the cause of most other errors
            let explained = |error| long_header::incomplete(&lines).unwrap_or(error);
            let table = table::Table::read(&lines, options, &mut warnings).map_err(explained)?;
            warnings.extend(cut::last_number(&text, &lines, table.dialect));
            if let Some(times) = time::axis(&table, options.sample_rate_hz) {
                return time::document(&table, &times, warnings, file);
            }
            refuse_contradictions(&remarks)?;
            facts.header_text = table.prose.clone();
            let traces = wide::traces(&table, &facts, &mut warnings).map_err(explained)?;
            (table.lines[0], traces)
        }
    };
    let units = FrfUnits::of(&facts, &traces, options.frf_kind, &mut warnings)?;
    let dofs = name_dofs(&facts, &traces, options, next_node, &mut warnings);
    let (mut datasets, mut records) = (Vec::new(), Vec::new());
    let (line_count, at_zero) = (frequency_hz.len(), frequency_hz.first() == Some(&0.0));
    for (trace, (response, reference)) in traces.into_iter().zip(dofs) {
        datasets.push(dataset_info(first_line, response, reference, line_count));
        let factor = units.factor(&trace);
        let coherence = trace.coherence;
        let coherence = coherence.map(|values| checked_coherence(values, at_zero, &mut warnings));
        records.push(TracedFrf {
            response,
            reference,
            values: trace.values.into_iter().map(|v| v * factor).collect(),
            coherence,
        });
    }
    let mut set = build_set(
        frequency_hz,
        records,
        units.kind,
        units.reference,
        options.duplicates,
        &file.display().to_string(),
        &mut warnings,
    )?;
    super::time_sign::to_plus(&mut set, facts.time_sign, options.time_sign, &mut warnings);
    Ok(Document {
        datasets,
        frf: Some(set),
        warnings,
        ..Document::new(file, FileFormat::Csv)
    })
}

/// Kind, reference unit and scale of a file.
struct FrfUnits {
    kind: Option<FrfKind>,
    reference: ReferenceUnit,
    file: Option<FrfUnit>,
}

impl FrfUnits {
    fn of(
        facts: &TableFacts,
        traces: &[Trace],
        caller_kind: Option<FrfKind>,
        warnings: &mut Vec<Finding>,
    ) -> Result<Self> {
        let file = facts.unit.as_deref().and_then(frf_unit);
        let mut found: Option<(FrfUnit, &str)> =
            file.map(|unit| (unit, facts.unit.as_deref().unwrap_or_default()));
        // decibels were converted to the unit of their reference
        let file_unit = facts.linear_unit();
        let is_used = file_unit.is_some() && traces.iter().all(|trace| trace.unit.is_some());
        let mut unknown = (facts.unit.clone()).filter(|_| file.is_none() && !is_used);
        let mut unlabelled = file.is_none();
        for trace in traces {
            let Some(unit) = trace.unit else {
                if !trace.unit_text.is_empty() && file.is_none() {
                    unknown.get_or_insert_with(|| trace.unit_text.clone());
                }
                continue;
            };
            unlabelled = false;
            let (known, label) = *found.get_or_insert((unit, &trace.unit_text));
            if (known.kind, known.reference) != (unit.kind, unit.reference) {
                return Err(Error::bad_data("units of different kinds in one file")
                    .field("unit")
                    .found(format!(
                        "{} ({}) and {label} ({})",
                        trace.unit_text, unit.kind, known.kind
                    ))
                    .expected("FRFs of one kind")
                    .help("split the file by kind"));
            }
            if let (Some(file_unit), Some(label)) = (file_unit, &facts.unit) {
                if differ(file_unit, unit) {
                    return Err(facts.two_units(label, &trace.unit_text));
                }
            }
        }
        let assumed = match unknown {
            Some(label) => Some(format!(
                "unit `{label}` is no motion per force or volt; values are taken as SI"
            )),
            None => unlabelled.then(|| "no unit in the file; values are taken as SI".into()),
        };
        warnings.extend(assumed.map(|words| Finding::caution("unit-assumed", words)));
        if let (Some(kind), Some((unit, label)), None) = (facts.kind, found, caller_kind) {
            unit.check_kind(kind, label)?;
        }
        if let (Some((stated, line)), Some((unit, label))) = (facts.reference_unit, found) {
            unit.check_reference(stated, label)
                .map_err(|error| error.at_line(line))?;
        }
        let stated = facts.reference_unit.map(|(unit, _)| unit);
        let reference = stated
            .or(found.map(|(unit, _)| unit.reference))
            .unwrap_or_default();
        Ok(Self {
            kind: facts.kind.or(found.map(|(unit, _)| unit.kind)),
            reference,
            file,
        })
    }

    fn factor(&self, trace: &Trace) -> f64 {
        trace.unit.or(self.file).map_or(1.0, |unit| unit.to_si)
    }
}

/// DOFs of every trace: those of the file, else numbered, with a warning that names the
/// assumption.
///
/// An unknown reference, or the unknown response of references that stand alone, gets no
/// direction (`1:S`), so that it is never a driving point. A reference that the caller names
/// is N:+Z.
fn name_dofs(
    facts: &TableFacts,
    traces: &[Trace],
    options: &ReadOptions,
    next_node: &mut u64,
    warnings: &mut Vec<Finding>,
) -> Vec<(Dof, Dof)> {
    let fallback = match options.references.as_slice() {
        [] => UNKNOWN_DOF,
        nodes => Dof::new(nodes[0], Direction::PLUS_Z),
    };
    let single = traces.len() == 1;
    let caller_response = match options.responses.as_slice() {
        &[node] if single => Some(Dof::new(node, Direction::PLUS_Z)),
        _ => None,
    };
    let mut assumed = AssumedDofs::default();
    let dofs = traces
        .iter()
        .map(|trace| {
            let response = trace
                .response
                .or(facts.response.filter(|_| single).map(|(dof, _)| dof))
                .or(caller_response)
                .unwrap_or_else(|| match trace.reference {
                    Some(_) => {
                        assumed.lacks_response = true;
                        UNKNOWN_DOF
                    }
                    None => assumed.number(next_node, options),
                });
            let stated = facts.reference.map(|(dof, _)| dof);
            let reference = trace.reference.or(stated).unwrap_or_else(|| {
                assumed.lacks_reference = true;
                fallback
            });
            (response, reference)
        })
        .collect();
    // else the caller's list gives the DOFs later
    if options.dofs.rows.is_empty() {
        assumed.report(options, fallback, warnings);
        warnings.extend(unused_dof("response", facts.response, traces, |t| {
            t.response
        }));
        warnings.extend(unused_dof("reference", facts.reference, traces, |t| {
            t.reference
        }));
    }
    dofs
}

/// The note about a remark that states another DOF than a column or row does.
fn unused_dof(
    key: &str,
    stated: Option<(Dof, u64)>,
    traces: &[Trace],
    of: fn(&Trace) -> Option<Dof>,
) -> Option<Finding> {
    let (stated, line) = stated?;
    let other = traces.iter().filter_map(of).find(|dof| *dof != stated)?;
    // without backticks, in which the key is an option
    Some(Finding::note(
        "remark-not-used",
        format!(
            "line {line}: the remark {key} says {stated}, the table {other}: that of the table is \
             taken"
        ),
    ))
}

/// The DOF of a response or reference that nothing names.
const UNKNOWN_DOF: Dof = Dof {
    node: FIRST_NODE,
    direction: Direction::SCALAR,
};

/// The DOFs that a table does not give.
#[derive(Default)]
struct AssumedDofs {
    /// Responses with a number for a node, in their order.
    numbered: Vec<Dof>,
    lacks_response: bool,
    lacks_reference: bool,
}

impl AssumedDofs {
    /// The next response DOF. It is no driving point, whatever references the caller names.
    fn number(&mut self, next_node: &mut u64, options: &ReadOptions) -> Dof {
        let direction = match options.references.contains(next_node) {
            true => Direction::SCALAR,
            false => Direction::PLUS_Z,
        };
        let dof = Dof::new(*next_node, direction);
        self.numbered.push(dof);
        *next_node += 1;
        dof
    }

    fn report(&self, options: &ReadOptions, reference: Dof, warnings: &mut Vec<Finding>) {
        warnings.extend(numbered_responses(&self.numbered));
        if self.lacks_response {
            warnings.push(Finding::caution(
                "dofs-assumed",
                format!("names give references alone: their response is taken as {UNKNOWN_DOF}"),
            ));
        }
        if self.lacks_reference {
            let advice = match options.references.as_slice() {
                [] => "; say it with `reference N`",
                _ => "",
            };
            warnings.push(Finding::caution(
                "reference-assumed",
                format!("the file names no reference DOF: taken as {reference}{advice}"),
            ));
        }
    }
}

/// The warning about responses whose DOFs are numbers by position.
fn numbered_responses(numbered: &[Dof]) -> Option<Finding> {
    Some(match numbered {
        [] => return None,
        // the only FRF so far: it cannot be mistaken for another
        [one] if one.node == FIRST_NODE => Finding::note(
            "dofs-assumed",
            format!("the file names no response DOF: taken as {one}"),
        ),
        [one] => Finding::caution(
            "dofs-assumed",
            format!("the file names no response DOF: taken as {one}, by its place among the files"),
        ),
        [first, .., last] => Finding::caution(
            "dofs-assumed",
            format!(
                "the columns name no response DOFs: taken as {first} to {last}, in their order"
            ),
        ),
    })
}

/// Coherence with NaN where it is impossible; at 0 Hz that is normal.
fn checked_coherence(values: Vec<f64>, at_zero: bool, warnings: &mut Vec<Finding>) -> Vec<f32> {
    let zero_is_outside = at_zero
        && values
            .first()
            .is_some_and(|value| !(-SIX_DIGITS..=1.0 + SIX_DIGITS).contains(value));
    let (cleaned, outside) = clean_coherence(values);
    let others = outside - usize::from(zero_is_outside);
    if zero_is_outside {
        warnings.push(Finding::note(
            "coherence-invalid",
            "coherence at 0 Hz is outside 0 to 1: taken as not given there",
        ));
    }
    if others > 0 {
        let text =
            format!("coherence is outside 0 to 1 on {others} lines: taken as not given there");
        let finding = match others as f64 <= COHERENCE_SLIPS * cleaned.len() as f64 {
            true => Finding::note("coherence-invalid", text),
            false => Finding::caution("coherence-invalid", text),
        };
        warnings.push(finding);
    }
    cleaned
}

fn dataset_info(line: u64, response: Dof, reference: Dof, values: usize) -> DatasetInfo {
    DatasetInfo {
        line: Some(line),
        name: "frf".into(),
        function: Some("frf".into()),
        response: Some(response.to_string()),
        reference: Some(reference.to_string()),
        values: Some(values),
        ..DatasetInfo::default()
    }
}
