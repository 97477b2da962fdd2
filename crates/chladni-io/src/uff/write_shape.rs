//! Writes shapes: dataset 55, or 2414 for shapes read from one. Values in SI, with six digits.

use super::write58::{fortran, id_line};
use super::WriteOptions;
use crate::{Analysis, Shape, ShapeForm};
use chladni_frf::{Error, Result};
use num_complex::Complex64;
use std::io::{self, Write};

/// Characters of the value field 1P6E13.5.
const VALUES_PER_LINE: usize = 6;

/// Checks that the shape can be written.
///
/// # Errors
/// Values that are not finite; numbers that do not fit their columns.
pub(super) fn check(shape: &Shape) -> Result<()> {
    let whose = || format!("shape {}", shape.numbers.number);
    if shape.values.iter().any(|value| !value.is_finite()) {
        return Err(Error::bad_data(
            "a value that is not finite cannot be written to a universal file",
        )
        .field(whose())
        .found("NaN or infinity")
        .expected("finite numbers")
        .help("write HDF5 (.h5), which holds any number"));
    }
    let numbers = &shape.numbers;
    let codes = [
        shape.model_type,
        shape.analysis.code(),
        shape.characteristic,
        shape.quantity,
        numbers.load_case,
        numbers.number,
    ];
    if let Some(wide) = codes
        .into_iter()
        .find(|code| !(-999_999_999..=9_999_999_999).contains(code))
    {
        return Err(Error::bad_data("the number does not fit its columns")
            .field(whose())
            .found(wide)
            .expected("at most ten digits"));
    }
    Ok(())
}

/// Writes the dataset with its markers; with `old_datasets`, always as a 55.
///
/// # Errors
/// Those of `sink`.
pub(super) fn write(
    sink: &mut dyn Write,
    shape: &Shape,
    label: usize,
    options: WriteOptions,
) -> io::Result<()> {
    if options.old_datasets || shape.form == ShapeForm::AtNodes55 {
        head_55(sink, shape)?;
    } else {
        head_2414(sink, shape, label)?;
    }
    for (node, values) in shape.nodes.iter().zip(shape.values.rows()) {
        writeln!(sink, "{node:10}")?;
        let scaled = values.iter().map(|value| value * shape.scale_to_si);
        let parts: Vec<f64> = match shape.complex {
            true => scaled.flat_map(|value| [value.re, value.im]).collect(),
            false => scaled.map(|value| value.re).collect(),
        };
        reals(sink, &parts)?;
    }
    sink.write_all(b"    -1\n")
}

fn head_55(sink: &mut dyn Write, shape: &Shape) -> io::Result<()> {
    sink.write_all(b"    -1\n    55\n")?;
    let [ids @ .., last] = &shape.id_lines;
    ids.iter()
        .try_for_each(|line| writeln!(sink, "{}", id_line(line)))?;
    match shape.reference {
        Some(dof) if last.is_empty() => writeln!(
            sink,
            "{:10}{:10}{:10}{:10}",
            dof.node,
            dof.direction.code(),
            shape.quantity,
            13
        )?,
        _ => writeln!(sink, "{}", id_line(last))?,
    }
    types(sink, shape)?;
    let numbers = &shape.numbers;
    let (integers, values): (&[i64], Vec<f64>) = match shape.analysis {
        Analysis::NormalMode => (
            &[numbers.load_case, numbers.number],
            vec![
                numbers.frequency_hz,
                numbers.modal_mass,
                numbers.viscous,
                numbers.hysteretic,
            ],
        ),
        Analysis::ComplexModeFirstOrder | Analysis::ComplexModeSecondOrder => (
            &[numbers.load_case, numbers.number],
            pairs([numbers.eigenvalue, numbers.modal_a, numbers.modal_b]),
        ),
        Analysis::Transient => (&[numbers.load_case, numbers.number], vec![numbers.time_s]),
        Analysis::FrequencyResponse => (
            &[numbers.load_case, numbers.number],
            vec![numbers.frequency_hz],
        ),
        Analysis::Buckling => (&[numbers.load_case], vec![numbers.eigenvalue.re]),
        Analysis::Static | Analysis::Other(_) => (&[numbers.load_case], vec![0.0]),
    };
    write!(sink, "{:10}{:10}", integers.len(), values.len())?;
    integers
        .iter()
        .try_for_each(|integer| write!(sink, "{integer:10}"))?;
    writeln!(sink)?;
    reals(sink, &values)
}

fn head_2414(sink: &mut dyn Write, shape: &Shape, label: usize) -> io::Result<()> {
    writeln!(
        sink,
        "    -1\n  2414\n{label:10}\n{}\n{:10}",
        id_line(&shape.name),
        1
    )?;
    shape
        .id_lines
        .iter()
        .try_for_each(|line| writeln!(sink, "{}", id_line(line)))?;
    types(sink, shape)?;
    let numbers = &shape.numbers;
    let mut integers = [1, 0, 1, 0, numbers.load_case, 0, 0, 0];
    integers[match shape.analysis {
        Analysis::Transient => 6,
        Analysis::FrequencyResponse => 7,
        _ => 5,
    }] = numbers.number;
    integers
        .iter()
        .try_for_each(|integer| write!(sink, "{integer:10}"))?;
    writeln!(sink, "\n{:10}{:10}", 0, 0)?;
    let buckling = if shape.analysis == Analysis::Buckling {
        numbers.eigenvalue.re
    } else {
        0.0
    };
    reals(
        sink,
        &[
            numbers.time_s,
            numbers.frequency_hz,
            buckling,
            numbers.modal_mass,
            numbers.viscous,
            numbers.hysteretic,
        ],
    )?;
    let eigenvalue = if shape.analysis.is_complex_mode() {
        numbers.eigenvalue
    } else {
        Complex64::default()
    };
    reals(sink, &pairs([eigenvalue, numbers.modal_a, numbers.modal_b]))
}

fn types(sink: &mut dyn Write, shape: &Shape) -> io::Result<()> {
    let (model, analysis, characteristic) = (
        shape.model_type,
        shape.analysis.code(),
        shape.characteristic,
    );
    let (data_type, components) = (if shape.complex { 5 } else { 2 }, shape.values.ncols());
    writeln!(
        sink,
        "{model:10}{analysis:10}{characteristic:10}{:10}{data_type:10}{components:10}",
        shape.quantity
    )
}

fn pairs(values: [Complex64; 3]) -> Vec<f64> {
    values
        .into_iter()
        .flat_map(|value| [value.re, value.im])
        .collect()
}

fn reals(sink: &mut dyn Write, values: &[f64]) -> io::Result<()> {
    for line in values.chunks(VALUES_PER_LINE) {
        line.iter()
            .try_for_each(|&value| sink.write_all(fortran(value, 13, 5, 'E').as_bytes()))?;
        sink.write_all(b"\n")?;
    }
    Ok(())
}
