//! Dataset 58: one function at a DOF pair, from its header, its numbers and its codes.

use super::container::Block;
use super::header::Units;
use super::header58::{entity_dof, Header};
use super::layout::Record7;
use super::places::PlacedFunction;
use super::scaling::{refuse_orders, scaling};
use super::step::{self, Printed};
use super::values::{read_binary, read_text, Values};
use crate::{Abscissa, Function, Ordinate, ReadOptions};
use chladni_frf::{Error, Finding, Result};

/// Takes DOFs from entity names where the node number is 0, and reports it.
///
/// * `stated`: true where the user states the response, and the reference
fn dofs_from_entities(header: &mut Header, stated: [bool; 2], warnings: &mut Vec<Finding>) {
    let one_sided = !matches!(header.function_type, 3..=6);
    for (k, what) in ["response", "reference"].into_iter().enumerate() {
        let dof = if k == 0 {
            &mut header.response
        } else {
            &mut header.reference
        };
        let name = &header.entity_names[k];
        if dof.node != 0 || (k == 1 && one_sided) {
            continue;
        }
        match entity_dof(name) {
            Some(found) => {
                warnings.push(Finding::caution(
                    "dofs-assumed",
                    format!(
                        "the {what} node is 0; {found} is read from the entity name \
                                       `{name}`"
                    ),
                ));
                *dof = found;
            }
            None if stated[k] => {}
            None if k == 0 => warnings.push(Finding::caution(
                "dofs-assumed",
                format!(
                    "the response node is 0 and the entity name \
                                                     `{name}` names no DOF"
                ),
            )),
            None => warnings.push(Finding::caution(
                "dofs-assumed",
                format!(
                    "the reference node is 0 and the entity name `{name}` names \
                                       no DOF: state it with `reference N`"
                ),
            )),
        }
    }
}

/// A dataset 58 as far as it could be read.
pub(super) struct ReadFunction {
    pub header: Option<Header>,
    pub function: Result<Function>,
    pub warnings: Vec<Finding>,
}

/// Type and DOFs of a function, from its header alone; `None` where that cannot be read.
pub(super) fn placed(block: &Block<'_>) -> Option<PlacedFunction> {
    let (mut header, _) = Header::read(block.records, &mut Vec::new()).ok()?;
    dofs_from_entities(&mut header, [false; 2], &mut Vec::new());
    Some(PlacedFunction {
        function_type: header.function_type,
        response: header.response,
        reference: header.reference,
    })
}

/// Reads a text or binary dataset 58.
pub(super) fn read(block: &Block<'_>, units: Option<Units>, options: &ReadOptions) -> ReadFunction {
    let mut warnings = block.warnings.clone();
    let (mut header, data) = match Header::read(block.records, &mut warnings) {
        Ok(read) => read,
        Err(error) => {
            return ReadFunction {
                header: None,
                function: Err(block.fault.clone().unwrap_or(error)),
                warnings,
            };
        }
    };
    let of_all = !options.dofs.rows.is_empty();
    let stated = [&options.responses, &options.references].map(|nodes| of_all || !nodes.is_empty());
    dofs_from_entities(&mut header, stated, &mut warnings);
    let values = match (&block.fault, &block.payload) {
        (Some(fault), _) => Err(fault.clone()),
        _ if block.passed_over.is_some() => closed(
            block,
            options,
            Values {
                x: Vec::new(),
                ordinate: Ordinate::Real32(Vec::new()),
            },
        ),
        (None, Some(payload)) => read_binary(payload, &mut warnings),
        (None, None) => read_text(data, header.record7.layout, options.lenient, &mut warnings)
            .and_then(|values| closed(block, options, values)),
    };
    let is_read = refuse_orders(header.function_type, &header.axes[0], block.line);
    let function = values
        .and_then(|values| is_read.map(|()| values))
        .map(|values| assemble(&header, values, block, units, options, &mut warnings));
    ReadFunction {
        header: Some(header),
        function,
        warnings,
    }
}

/// Refuses a text dataset without closing -1, unless `lenient`: digits of its last number may
/// be missing.
fn closed(block: &Block<'_>, options: &ReadOptions, values: Values) -> Result<Values> {
    if block.closed || options.lenient {
        return Ok(values);
    }
    Err(not_closed(block))
}

/// The error of a file that ends inside a dataset.
pub(super) fn not_closed(block: &Block<'_>) -> Error {
    Error::bad_data("the file ends inside this dataset")
        .at_line(block.line)
        .found("the end of the file")
        .expected("a closing -1 line")
        .help("the file is cut short: copy or export it again; `lenient` reads what is there")
}

fn assemble(
    header: &Header,
    values: Values,
    block: &Block<'_>,
    units: Option<Units>,
    options: &ReadOptions,
    warnings: &mut Vec<Finding>,
) -> Function {
    let directions = [header.response.direction, header.reference.direction];
    let scaling = scaling(
        header.function_type,
        &header.axes,
        directions,
        units,
        warnings,
    );
    let is_text = block.payload.is_none();
    let count = block.passed_over.map_or(values.ordinate.len(), |count| {
        usize::try_from(count).unwrap_or(usize::MAX)
    });
    let abscissa = abscissa(header, values.x, count, is_text, options.snap_df, warnings);
    Function {
        function_type: header.function_type,
        id_lines: header.id_lines.clone(),
        ids: header.ids,
        entity_names: header.entity_names.clone(),
        response: header.response,
        reference: header.reference,
        abscissa,
        z: header.record7.z,
        axes: header.axes.clone(),
        ordinate: values.ordinate,
        kind: scaling.kind,
        reference_unit: scaling.reference_unit,
        scale_to_si: scaling.scale_to_si,
        abscissa_to_si: scaling.abscissa_to_si,
        line: block.line,
        warnings: warnings.clone(),
    }
}

/// The abscissa, with the exact step where the file states it (`df=` in ID line 4) or the
/// user asks for it.
fn abscissa(
    header: &Header,
    x: Vec<f64>,
    count: usize,
    is_text: bool,
    snap: bool,
    warnings: &mut Vec<Finding>,
) -> Abscissa {
    let Record7 {
        layout,
        start,
        step,
        ..
    } = header.record7;
    let tagged_step = step::tagged(&header.id_lines[3], "df=").filter(|&step| step > 0.0);
    if !layout.even {
        // the abscissa of binary data has all its digits
        let exact = is_text
            .then(|| step::even_behind(&x, tagged_step))
            .flatten();
        return match exact {
            Some((start, step)) if snap || tagged_step.is_some() => Abscissa::Even { start, step },
            Some((_, step)) => {
                let printed = "the abscissa is printed with 6 digits";
                warnings.push(candidate_warning(step, printed));
                Abscissa::Uneven(x)
            }
            None => Abscissa::Uneven(x),
        };
    }
    if step.value <= 0.0 && count > 1 {
        warnings.push(Finding::caution(
            "axis-does-not-rise",
            format!(
                "the abscissa step is {}: the axis does not rise",
                step.value
            ),
        ));
    }
    let exact_start = step::tagged(&header.id_lines[3], "start=")
        .filter(|&tagged| tagged_step.is_some() && start.agrees(tagged));
    match exact_step(step, tagged_step, count, snap, warnings) {
        Some(exact) => Abscissa::Even {
            start: exact_start
                .unwrap_or_else(|| step::multiple_near(start.value, exact, start.half_unit)),
            step: exact,
        },
        None => Abscissa::Even {
            start: start.value,
            step: step.value,
        },
    }
}

/// The exact step in place of that of record 7: that of ID line 4, or with `snap` the only
/// step that is printed with these digits.
fn exact_step(
    step: Printed,
    tagged: Option<f64>,
    count: usize,
    snap: bool,
    warnings: &mut Vec<Finding>,
) -> Option<f64> {
    match tagged {
        Some(tagged) if step.agrees(tagged) => Some(tagged),
        Some(tagged) => {
            warnings.push(Finding::caution(
                "step-contradicted",
                format!(
                    "df={tagged} in ID line 4 contradicts the step {} of record 7, which is used",
                    step.value
                ),
            ));
            None
        }
        None => match step.candidate() {
            Some(candidate) if snap => Some(candidate),
            Some(candidate) => {
                let drift = (candidate - step.value).abs() * count.saturating_sub(1) as f64;
                let printed = format!(
                    "the step {} is printed with {} digits, the last line may be off by \
                             {drift:.2e}",
                    step.value, step.digits
                );
                warnings.push(candidate_warning(candidate, &printed));
                None
            }
            None => None,
        },
    }
}

fn candidate_warning(step: f64, what: &str) -> Finding {
    let words = format!("{what}; the exact step is probably {step}");
    Finding::note("step-rounded", words)
        .value("step_hz", step)
        .help("take it with `snap_df`")
}

/// Number of values of a function, for the listing.
pub(super) fn value_count(block: &Block<'_>, function: &Result<Function>) -> Option<usize> {
    let function = function.as_ref().ok()?;
    block
        .passed_over
        .map_or(Some(function.ordinate.len()), |count| {
            usize::try_from(count).ok()
        })
}
