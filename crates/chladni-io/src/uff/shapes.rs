//! Reads shapes: datasets 55 (data at nodes) and 2414 (analysis data).
//!
//! | | 55 | 2414 |
//! |---|---|---|
//! | before the types | 5 ID lines; line 5 of test data 4I10: reference node and direction, quantity codes | I10 label, name, I10 location, 5 ID lines |
//! | types, 6I10 | model, analysis, characteristic, quantity, data type, values per node | the same; data types 1, 2, 4 real, 5, 6 complex |
//! | integers, 8I10 | count of integers, count of reals, then load case, mode number | ten: ..., load set (5th), mode number (6th), time step, frequency step |
//! | reals, 6E13.5 | as many as stated: by analysis | twelve: time, frequency, eigenvalue, mass, ζ, η, Re λ, Im λ, A, B |
//! | per node | I10 node; 6E13.5 values, complex as pairs | the same |
//!
//! A node that is left out is at rest in 55 and has no value in 2414. `shape_head` reads the
//! records before the values.

use super::fields::{numbers, whole, Record};
use super::header::Units;
use super::scaling::{ACCELERATION, DISPLACEMENT, VELOCITY};
use super::shape_head::{Reader, ShapeHead, SIX_REALS};
use crate::Shape;
use chladni_frf::{Error, ErrorKind, Finding, Result};
use ndarray::Array2;
use num_complex::Complex64;
use std::collections::HashSet;

/// Reads dataset 55 or 2414; `None` for data of 2414 that do not belong to nodes.
///
/// # Errors
/// A missing record, a field that is no number, a node without all its values or that occurs
/// twice.
pub(super) fn read<'a>(
    number: u32,
    line: u64,
    records: impl Iterator<Item = Record<'a>>,
    units: Option<Units>,
    warnings: &mut Vec<Finding>,
) -> Result<Option<Shape>> {
    let mut reader = Reader {
        records,
        last_line: line,
        warnings,
    };
    let ShapeHead {
        shape,
        components,
        at_nodes,
    } = if number == 55 {
        reader.head_of_55()?
    } else {
        reader.head_of_2414()?
    };
    if !at_nodes {
        return Ok(None);
    }
    let mut shape = Shape { line, ..shape };
    read_values(&mut reader, &mut shape, components)?;
    shape.scale_to_si = scale(&shape, units, reader.warnings);
    shape.warnings = reader.warnings.clone();
    Ok(Some(shape))
}

/// Factor of the values to SI: 1 for modes, which have a scaling of their own.
fn scale(shape: &Shape, units: Option<Units>, warnings: &mut Vec<Finding>) -> f64 {
    let moves = [DISPLACEMENT, VELOCITY, ACCELERATION]
        .iter()
        .any(|&code| i64::from(code) == shape.quantity);
    let Some(units) = units.filter(|units| !units.is_si()) else {
        return 1.0;
    };
    if shape.analysis.is_mode() {
        warnings.push(Finding::note(
            "unit-kept",
            "the shape of a mode has a scaling of its own: values are kept as in the \
                       file, not turned into SI",
        ));
        return 1.0;
    }
    match moves {
        true if shape.values.ncols() <= 3 => 1.0 / units.factor([1, 0]),
        _ => {
            warnings.push(Finding::note(
                "unit-kept",
                "units of these values are not turned into SI: they are kept as in the file",
            ));
            1.0
        }
    }
}

/// Reads the values of all nodes, to the end of the dataset.
fn read_values<'a>(
    reader: &mut Reader<'_, impl Iterator<Item = Record<'a>>>,
    shape: &mut Shape,
    components: usize,
) -> Result<()> {
    let per_node = components * if shape.complex { 2 } else { 1 };
    let mut flat = Vec::new();
    let mut seen = HashSet::new();
    while let Some(record) = reader.records.next() {
        if record.text.trim_ascii().is_empty() {
            continue;
        }
        reader.last_line = record.line;
        let node = node_label(record, reader.warnings)?;
        if !seen.insert(node) {
            return Err(Error::bad_data("a node occurs twice")
                .at_line(record.line)
                .field("node")
                .found(node)
                .expected("one set of values per node")
                .help("export the file again, or remove one of the two"));
        }
        let start = flat.len();
        while flat.len() - start < per_node {
            let record = reader.next(&format!("values of node {node}"))?;
            let left = per_node - (flat.len() - start);
            flat.extend_from_slice(
                &numbers(record, SIX_REALS, reader.warnings)?[..left.min(SIX_REALS.len())],
            );
        }
        shape.nodes.push(node);
    }
    let values: Vec<Complex64> = match shape.complex {
        true => flat
            .chunks_exact(2)
            .map(|pair| Complex64::new(pair[0], pair[1]))
            .collect(),
        false => flat.into_iter().map(Complex64::from).collect(),
    };
    shape.values = Array2::from_shape_vec((shape.nodes.len(), components), values)
        .map_err(|_| Error::new(ErrorKind::Internal, "a node without all its values"))?;
    Ok(())
}

/// A positive node label in the first ten columns.
fn node_label(record: Record<'_>, warnings: &mut Vec<Finding>) -> Result<u64> {
    let [value] = numbers(record, [("node", 10)], warnings)?;
    let number = whole(record, "node", value)?;
    u64::try_from(number)
        .ok()
        .filter(|&node| node > 0)
        .ok_or_else(|| {
            Error::bad_data("a node label must be positive")
                .at_line(record.line)
                .field("node")
                .found(number)
                .expected("1 or more")
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn read_text(number: u32, text: &str) -> Result<Option<Shape>> {
        read(
            number,
            1,
            text.lines().zip(1..).map(|(text, line)| Record {
                line,
                text: text.as_bytes(),
            }),
            None,
            &mut Vec::new(),
        )
    }

    const IDS: &str = "NONE\nNONE\nNONE\nNONE\n";
    const ZEROS: &str =
        "  0.00000E+00  0.00000E+00  0.00000E+00  0.00000E+00  0.00000E+00  0.00000E+00\n";

    #[test]
    fn a_normal_mode_of_55_has_frequency_damping_and_values() {
        let types = "         1         2         2         8         2         3\n         \
                     2         4         1         7\n";
        let reals = "  1.00000e+01  2.00000e+00  5.00000e-03  0.00000e+00\n";
        let values = "         5\n  1.00000E+00 -2.00000E+00  3.00000E+00\n        12\n  \
                      0.00000E+00  0.00000E+00 -1.50000E+00\n";
        let shape = read_text(
            55,
            &format!("{IDS}       101         3        11        13\n{types}{reals}{values}"),
        )
        .unwrap()
        .unwrap();
        assert_eq!(
            (shape.frequency_hz(), shape.damping_ratio()),
            (Some(10.0), Some(0.005))
        );
        assert_eq!(
            (
                shape.numbers.modal_mass,
                shape.numbers.load_case,
                shape.numbers.number
            ),
            (2.0, 1, 7)
        );
        assert_eq!(shape.reference.unwrap().to_string(), "101:+Z");
        assert_eq!(shape.nodes, [5, 12]);
        assert_eq!(
            shape.values,
            ndarray::array![[1.0, -2.0, 3.0], [0.0, 0.0, -1.5]].mapv(Complex64::from)
        );
    }

    #[test]
    fn a_complex_mode_of_55_gives_the_undamped_frequency() {
        let types = "         1         3         2         8         5         3\n         \
                     2         6         1         1\n";
        let reals =
            " -3.00000e+00  4.00000e+00  0.00000e+00  0.00000e+00  0.00000e+00  0.00000e+00\n";
        let node =
            "         1\n  1.00000E+00  2.00000E+00  3.00000E+00  4.00000E+00  5.00000E+00  \
                    6.00000E+00\n";
        let shape = read_text(55, &format!("{IDS}NONE\n{types}{reals}{node}"))
            .unwrap()
            .unwrap();
        assert_eq!(
            (shape.frequency_hz(), shape.damping_ratio()),
            (Some(5.0 / TAU), Some(0.6))
        );
        assert_eq!(shape.values[[0, 2]], Complex64::new(5.0, 6.0));
    }

    #[test]
    fn modes_of_2414_are_read() {
        let head = format!("         1\nMode 1\n         1\n{IDS}NONE\n");
        let integers = "         1         0         1         0         2         3         \
                        0         0\n         0         0\n";
        let normal =
            "  0.00000E+00  2.50000E+01  0.00000E+00  1.00000E+00  0.00000E+00  2.00000E-02\n";
        let types = |analysis: i32| {
            format!("         1{analysis:10}         3         8         2         6\n")
        };
        let node =
            "         9\n  1.00000E+00  2.00000E+00  3.00000E+00  4.00000E+00  5.00000E+00  \
                    6.00000E+00\n";
        let shape = read_text(
            2414,
            &format!("{head}{}{integers}{normal}{ZEROS}{node}", types(2)),
        )
        .unwrap()
        .unwrap();
        assert_eq!(
            (shape.frequency_hz(), shape.damping_ratio()),
            (Some(25.0), Some(0.01))
        );
        assert_eq!(
            (
                shape.numbers.load_case,
                shape.numbers.number,
                shape.values[[0, 5]].re
            ),
            (2, 3, 6.0)
        );
        let lambda = " -6.00000E+00  8.00000E+00\n";
        let shape = read_text(
            2414,
            &format!("{head}{}{integers}{ZEROS}{lambda}", types(3)),
        )
        .unwrap()
        .unwrap();
        assert_eq!(
            (shape.frequency_hz(), shape.damping_ratio()),
            (Some(10.0 / TAU), Some(0.6))
        );
    }

    #[test]
    fn data_at_elements_are_listed_and_not_read() {
        let head = format!("         1\nStress\n         2\n{IDS}NONE\n");
        let types = "         1         1         4         2         2         6\n";
        let integers = "         1\n         0\n";
        let element = "         7         2         6\n  1.0 1.0 1.0 1.0 1.0 1.0\n";
        assert_eq!(
            read_text(
                2414,
                &format!("{head}{types}{integers}{ZEROS}{ZEROS}{element}")
            )
            .unwrap(),
            None
        );
    }

    #[test]
    fn a_shape_that_ends_early_or_names_a_node_twice_is_refused() {
        assert!(read_text(55, "NONE\nNONE\n").is_err());
        assert!(read_text(2414, "").is_err());
        let head = format!(
            "{IDS}NONE\n         1         2         2         8         2         3\n         \
             2         4         1         7\n{ZEROS}"
        );
        let values = "  1.00000E+00 -2.00000E+00  3.00000E+00\n";
        assert!(read_text(55, &format!("{head}         5\n"))
            .unwrap_err()
            .to_string()
            .contains("values of node 5"));
        let twice = read_text(
            55,
            &format!("{head}         5\n{values}         5\n{values}"),
        )
        .unwrap_err()
        .to_string();
        assert!(
            twice.contains("occurs twice") && twice.contains("line 11"),
            "{twice}"
        );
    }

    #[test]
    fn impossible_counts_are_refused_and_never_allocated() {
        for types in [
            "         1         2         2         8         2 999999999",
            "         1         2         2         8         9         3",
        ] {
            assert!(read_text(55, &format!("{IDS}NONE\n{types}\n")).is_err());
        }
        let types = "         1         2         2         8         2         3\n";
        assert!(read_text(55, &format!("{IDS}NONE\n{types}999999999999999999\n")).is_err());
    }
}
