//! Reads shapes: datasets 55 (data at nodes) and 2414 (analysis data).
//!
//! | | 55 | 2414 |
//! |---|---|---|
//! | before the types | 5 ID lines; line 5 of test data 4I10: reference node and direction, quantity codes | I10 label, name, I10 location, 5 ID lines |
//! | types, 6I10 | model, analysis, characteristic, quantity, data type, values per node | the same; data types 1, 2, 4 real, 5, 6 complex |
//! | integers, 8I10 | count of integers, count of reals, then load case, mode number | ten: ..., load set (5th), mode number (6th), time step, frequency step |
//! | reals, 6E13.5 | as many as stated: see [`numbers_of_55`] | twelve: time, frequency, eigenvalue, mass, ζ, η, Re λ, Im λ, A, B |
//! | per node | I10 node; 6E13.5 values, complex as pairs | the same |
//!
//! A node that is left out is at rest in 55 and has no value in 2414.

use super::fields::{decode, label, numbers, whole, Column, Record};
use super::header::Units;
use super::scaling::{ACCELERATION, DISPLACEMENT, VELOCITY};
use crate::io::shape::MOST_COMPONENTS;
use crate::io::{Analysis, Shape, ShapeForm, ShapeNumbers};
use crate::{Direction, Dof, Error, Result};
use ndarray::Array2;
use num_complex::Complex64;
use std::collections::HashSet;

const TYPES: [Column; 6] =
    [("model type", 10), ("analysis type", 10), ("data characteristic", 10), ("quantity", 10), ("data type", 10), ("values per node", 10)];
const EIGHT_INTEGERS: [Column; 8] = [
    ("integer 1", 10),
    ("integer 2", 10),
    ("integer 3", 10),
    ("integer 4", 10),
    ("integer 5", 10),
    ("integer 6", 10),
    ("integer 7", 10),
    ("integer 8", 10),
];
const SIX_REALS: [Column; 6] = [("value 1", 13), ("value 2", 13), ("value 3", 13), ("value 4", 13), ("value 5", 13), ("value 6", 13)];
/// More integers or reals than this before the values are none.
const MOST_HEADER_NUMBERS: i64 = 100;

/// Reads dataset 55 or 2414; `None` for data of 2414 that do not stand at nodes.
///
/// # Errors
/// A record that is missing, a field that is no number, a node without all its values or that stands twice.
pub(super) fn read<'a>(
    number: u32,
    line: u64,
    records: impl Iterator<Item = Record<'a>>,
    units: Option<Units>,
    warnings: &mut Vec<String>,
) -> Result<Option<Shape>> {
    let mut reader = Reader { records, last_line: line, warnings };
    let Head(shape, components, at_nodes) = if number == 55 { reader.head_of_55()? } else { reader.head_of_2414()? };
    if !at_nodes {
        return Ok(None);
    }
    let mut shape = Shape { line, ..shape };
    reader.values(&mut shape, components)?;
    shape.scale_to_si = scale(&shape, units, reader.warnings);
    shape.warnings = reader.warnings.clone();
    Ok(Some(shape))
}

/// Shapes of modes have a scaling of their own; everything that moves in metres is turned into metres.
fn scale(shape: &Shape, units: Option<Units>, warnings: &mut Vec<String>) -> f64 {
    let moves = [DISPLACEMENT, VELOCITY, ACCELERATION].iter().any(|&code| i64::from(code) == shape.quantity);
    let Some(units) = units.filter(|units| !units.is_si()) else { return 1.0 };
    if shape.analysis.is_mode() {
        warnings.push("the shape of a mode has a scaling of its own: values are kept as in the file, not turned into SI".into());
        return 1.0;
    }
    match moves {
        true if shape.values.ncols() <= 3 => 1.0 / units.factor([1, 0]),
        _ => {
            warnings.push("units of these values are not turned into SI: they are kept as in the file".into());
            1.0
        }
    }
}

/// A shape without values, its values per node, and whether they stand at nodes.
struct Head(Shape, usize, bool);

struct Reader<'w, I> {
    records: I,
    last_line: u64,
    warnings: &'w mut Vec<String>,
}

impl<'a, I: Iterator<Item = Record<'a>>> Reader<'_, I> {
    fn next(&mut self, what: &str) -> Result<Record<'a>> {
        let record = self.records.next().ok_or_else(|| {
            Error::bad_data("the dataset is too short")
                .at_line(self.last_line)
                .field(what)
                .found("the end of the dataset")
                .expected("the records of its definition")
                .help("the file is cut short; copy or export it again")
        })?;
        self.last_line = record.line;
        Ok(record)
    }

    fn head_of_55(&mut self) -> Result<Head> {
        let mut id_lines: [String; 5] = Default::default();
        let mut reference = None;
        for (k, line) in id_lines.iter_mut().enumerate() {
            let record = self.next("ID lines")?;
            *line = label(&decode(record.text));
            if k == 4 {
                reference = reference_of(line);
            }
        }
        let (shape, components) = self.types(ShapeForm::AtNodes55)?;
        let mut shape = Shape { id_lines, reference, ..shape };
        let mut integers = self.integers()?;
        let counts = [integers[0], integers[1]];
        if counts.iter().any(|count| !(0..=MOST_HEADER_NUMBERS).contains(count)) {
            return Err(Error::bad_data("impossible counts before the values")
                .at_line(self.last_line)
                .field("counts of integers and reals")
                .found(format!("{} and {}", counts[0], counts[1]))
                .expected(format!("0 to {MOST_HEADER_NUMBERS}")));
        }
        // the first line holds six of them
        for _ in 0..(counts[0] - 6 + 7).max(0) / 8 {
            integers.extend(self.integers()?);
        }
        let stated = |k: usize| if (k as i64) < counts[0] { integers.get(2 + k).copied().unwrap_or(0) } else { 0 };
        let mut reals = Vec::new();
        for _ in 0..(counts[1] + 5) / 6 {
            let record = self.next("reals before the values")?;
            reals.extend(numbers(record, SIX_REALS, self.warnings)?);
        }
        reals.truncate(counts[1] as usize);
        shape.numbers = numbers_of_55(shape.analysis, [stated(0), stated(1)], &reals);
        Ok(Head(shape, components, true))
    }

    fn head_of_2414(&mut self) -> Result<Head> {
        self.next("analysis dataset label")?;
        let name = label(&decode(self.next("name")?.text));
        let record = self.next("dataset location")?;
        let [location] = numbers(record, [("dataset location", 10)], self.warnings)?;
        let location = whole(record, "dataset location", location)?;
        if !matches!(location, 1 | 2 | 3 | 5) {
            let error = Error::bad_data("unknown code").at_line(record.line).field("dataset location").found(location);
            return Err(error.expected("1 nodes, 2 elements, 3 nodes on elements or 5 points"));
        }
        let mut id_lines: [String; 5] = Default::default();
        for line in &mut id_lines {
            *line = label(&decode(self.next("ID lines")?.text));
        }
        let (shape, components) = self.types(ShapeForm::Analysis2414)?;
        let mut shape = Shape { name, id_lines, ..shape };
        let mut integers = self.integers()?;
        integers.extend(self.integers()?);
        let mut reals = Vec::new();
        for _ in 0..2 {
            let record = self.next("reals before the values")?;
            reals.extend(numbers(record, SIX_REALS, self.warnings)?);
        }
        let step = match shape.analysis {
            Analysis::Transient => 6,
            Analysis::FrequencyResponse => 7,
            _ => 5,
        };
        let pair = |k: usize| Complex64::new(reals[k], reals[k + 1]);
        shape.numbers = ShapeNumbers {
            load_case: integers[4],
            number: integers[step],
            time_s: reals[0],
            frequency_hz: reals[1],
            modal_mass: reals[3],
            viscous: reals[4],
            hysteretic: reals[5],
            eigenvalue: if shape.analysis == Analysis::Buckling { Complex64::from(reals[2]) } else { pair(6) },
            modal_a: pair(8),
            modal_b: pair(10),
        };
        if location != 1 {
            self.warnings.push("the values do not stand at nodes (location 2, 3 or 5): they are listed and not read".into());
        }
        Ok(Head(shape, components, location == 1))
    }

    fn types(&mut self, form: ShapeForm) -> Result<(Shape, usize)> {
        let record = self.next("types")?;
        let values = numbers(record, TYPES, self.warnings)?;
        let mut codes = [0; 6];
        for ((code, value), (name, _)) in codes.iter_mut().zip(values).zip(TYPES) {
            *code = whole(record, name, value)?;
        }
        let [model_type, analysis, characteristic, quantity, data_type, components] = codes;
        let unknown = |field: &str, found: i64, expected: &str| {
            Error::bad_data("unknown code").at_line(record.line).field(field).found(found).expected(expected)
        };
        let complex = match (form, data_type) {
            (_, 2) | (ShapeForm::Analysis2414, 1 | 4) => false,
            (_, 5) | (ShapeForm::Analysis2414, 6) => true,
            // outside of the definition of 55, and written all the same
            (ShapeForm::AtNodes55, 4 | 6) => {
                self.warnings.push(format!("data type {data_type} is not of dataset 55; read as {}", if data_type == 4 { 2 } else { 5 }));
                data_type == 6
            }
            (ShapeForm::AtNodes55, _) => return Err(unknown("data type", data_type, "2 real or 5 complex")),
            (ShapeForm::Analysis2414, _) => {
                return Err(unknown("data type", data_type, "1 integer, 2 or 4 real, 5 or 6 complex"));
            }
        };
        let components = usize::try_from(components)
            .ok()
            .filter(|count| (1..=MOST_COMPONENTS).contains(count))
            .ok_or_else(|| unknown("values per node", components, "1 to 64"))?;
        let shape = Shape {
            form,
            name: String::new(),
            id_lines: Default::default(),
            model_type,
            analysis: Analysis::from_code(analysis),
            characteristic,
            quantity,
            reference: None,
            numbers: ShapeNumbers::default(),
            complex,
            nodes: Vec::new(),
            values: Array2::zeros((0, components)),
            scale_to_si: 1.0,
            line: 0,
            warnings: Vec::new(),
        };
        Ok((shape, components))
    }

    fn integers(&mut self) -> Result<Vec<i64>> {
        let record = self.next("integers before the values")?;
        let values = numbers(record, EIGHT_INTEGERS, self.warnings)?;
        values.into_iter().zip(EIGHT_INTEGERS).map(|(value, (name, _))| whole(record, name, value)).collect()
    }

    fn values(&mut self, shape: &mut Shape, components: usize) -> Result<()> {
        let per_node = components * if shape.complex { 2 } else { 1 };
        let mut flat = Vec::new();
        let mut seen = HashSet::new();
        while let Some(record) = self.records.next() {
            if record.text.trim_ascii().is_empty() {
                continue;
            }
            self.last_line = record.line;
            let node = node_label(record, self.warnings)?;
            if !seen.insert(node) {
                return Err(Error::bad_data("a node stands twice")
                    .at_line(record.line)
                    .field("node")
                    .found(node)
                    .expected("one set of values per node")
                    .help("export the file again, or remove one of the two"));
            }
            let start = flat.len();
            while flat.len() - start < per_node {
                let record = self.next(&format!("values of node {node}"))?;
                let left = per_node - (flat.len() - start);
                flat.extend_from_slice(&numbers(record, SIX_REALS, self.warnings)?[..left.min(SIX_REALS.len())]);
            }
            shape.nodes.push(node);
        }
        let values: Vec<Complex64> = match shape.complex {
            true => flat.chunks_exact(2).map(|pair| Complex64::new(pair[0], pair[1])).collect(),
            false => flat.into_iter().map(Complex64::from).collect(),
        };
        shape.values = Array2::from_shape_vec((shape.nodes.len(), components), values).expect("every node has all its values");
        Ok(())
    }
}

/// A positive node label in the first ten columns.
pub(super) fn node_label(record: Record<'_>, warnings: &mut Vec<String>) -> Result<u64> {
    let [value] = numbers(record, [("node", 10)], warnings)?;
    let number = whole(record, "node", value)?;
    u64::try_from(number).ok().filter(|&node| node > 0).ok_or_else(|| {
        Error::bad_data("a node label must be positive").at_line(record.line).field("node").found(number).expected("1 or more")
    })
}

/// Reference of test data, in ID line 5: node, direction, numerator code, denominator code.
fn reference_of(line: &str) -> Option<Dof> {
    let words: Vec<i64> = line.split_whitespace().map(|word| word.parse().ok()).collect::<Option<_>>()?;
    let &[node, direction, _, _] = words.as_slice() else { return None };
    Some(Dof { node: u64::try_from(node).ok().filter(|&node| node > 0)?, direction: Direction::from_code(direction)? })
}

/// Reals of dataset 55: analysis 2 frequency, mass, ζ, η; 3 and 7 λ, A, B as pairs; 4 time; 5 frequency; 6 eigenvalue.
fn numbers_of_55(analysis: Analysis, [load_case, number]: [i64; 2], reals: &[f64]) -> ShapeNumbers {
    let real = |k: usize| reals.get(k).copied().unwrap_or(0.0);
    let pair = |k: usize| Complex64::new(real(k), real(k + 1));
    let numbers = ShapeNumbers { load_case, number, ..ShapeNumbers::default() };
    match analysis {
        Analysis::NormalMode => {
            ShapeNumbers { frequency_hz: real(0), modal_mass: real(1), viscous: real(2), hysteretic: real(3), ..numbers }
        }
        Analysis::ComplexModeFirstOrder | Analysis::ComplexModeSecondOrder => {
            ShapeNumbers { eigenvalue: pair(0), modal_a: pair(2), modal_b: pair(4), ..numbers }
        }
        Analysis::Transient => ShapeNumbers { time_s: real(0), ..numbers },
        Analysis::FrequencyResponse => ShapeNumbers { frequency_hz: real(0), ..numbers },
        Analysis::Buckling => ShapeNumbers { eigenvalue: Complex64::from(real(0)), ..numbers },
        Analysis::Static | Analysis::Other(_) => numbers,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn read_text(number: u32, text: &str) -> Result<Option<Shape>> {
        read(number, 1, text.lines().zip(1..).map(|(text, line)| Record { line, text: text.as_bytes() }), None, &mut Vec::new())
    }

    const IDS: &str = "NONE\nNONE\nNONE\nNONE\n";
    const ZEROS: &str = "  0.00000E+00  0.00000E+00  0.00000E+00  0.00000E+00  0.00000E+00  0.00000E+00\n";

    #[test]
    fn a_normal_mode_of_55_has_frequency_damping_and_values() {
        let types = "         1         2         2         8         2         3\n         2         4         1         7\n";
        let reals = "  1.00000e+01  2.00000e+00  5.00000e-03  0.00000e+00\n";
        let values = "         5\n  1.00000E+00 -2.00000E+00  3.00000E+00\n        12\n  0.00000E+00  0.00000E+00 -1.50000E+00\n";
        let shape = read_text(55, &format!("{IDS}       101         3        11        13\n{types}{reals}{values}")).unwrap().unwrap();
        assert_eq!((shape.frequency_hz(), shape.damping_ratio()), (Some(10.0), Some(0.005)));
        assert_eq!((shape.numbers.modal_mass, shape.numbers.load_case, shape.numbers.number), (2.0, 1, 7));
        assert_eq!(shape.reference.unwrap().to_string(), "101:+Z");
        assert_eq!(shape.nodes, [5, 12]);
        assert_eq!(shape.values, ndarray::array![[1.0, -2.0, 3.0], [0.0, 0.0, -1.5]].mapv(Complex64::from));
    }

    #[test]
    fn a_complex_mode_of_55_gives_the_undamped_frequency() {
        let types = "         1         3         2         8         5         3\n         2         6         1         1\n";
        let reals = " -3.00000e+00  4.00000e+00  0.00000e+00  0.00000e+00  0.00000e+00  0.00000e+00\n";
        let node = "         1\n  1.00000E+00  2.00000E+00  3.00000E+00  4.00000E+00  5.00000E+00  6.00000E+00\n";
        let shape = read_text(55, &format!("{IDS}NONE\n{types}{reals}{node}")).unwrap().unwrap();
        assert_eq!((shape.frequency_hz(), shape.damping_ratio()), (Some(5.0 / TAU), Some(0.6)));
        assert_eq!(shape.values[[0, 2]], Complex64::new(5.0, 6.0));
    }

    #[test]
    fn modes_of_2414_are_read() {
        let head = format!("         1\nMode 1\n         1\n{IDS}NONE\n");
        let integers = "         1         0         1         0         2         3         0         0\n         0         0\n";
        let normal = "  0.00000E+00  2.50000E+01  0.00000E+00  1.00000E+00  0.00000E+00  2.00000E-02\n";
        let types = |analysis: i32| format!("         1{analysis:10}         3         8         2         6\n");
        let node = "         9\n  1.00000E+00  2.00000E+00  3.00000E+00  4.00000E+00  5.00000E+00  6.00000E+00\n";
        let shape = read_text(2414, &format!("{head}{}{integers}{normal}{ZEROS}{node}", types(2))).unwrap().unwrap();
        assert_eq!((shape.frequency_hz(), shape.damping_ratio()), (Some(25.0), Some(0.01)));
        assert_eq!((shape.numbers.load_case, shape.numbers.number, shape.values[[0, 5]].re), (2, 3, 6.0));
        let lambda = " -6.00000E+00  8.00000E+00\n";
        let shape = read_text(2414, &format!("{head}{}{integers}{ZEROS}{lambda}", types(3))).unwrap().unwrap();
        assert_eq!((shape.frequency_hz(), shape.damping_ratio()), (Some(10.0 / TAU), Some(0.6)));
    }

    #[test]
    fn data_at_elements_are_listed_and_not_read() {
        let head = format!("         1\nStress\n         2\n{IDS}NONE\n");
        let types = "         1         1         4         2         2         6\n";
        let integers = "         1\n         0\n";
        let element = "         7         2         6\n  1.0 1.0 1.0 1.0 1.0 1.0\n";
        assert_eq!(read_text(2414, &format!("{head}{types}{integers}{ZEROS}{ZEROS}{element}")).unwrap(), None);
    }

    #[test]
    fn a_shape_that_ends_early_or_names_a_node_twice_is_refused() {
        assert!(read_text(55, "NONE\nNONE\n").is_err());
        assert!(read_text(2414, "").is_err());
        let head = format!(
            "{IDS}NONE\n         1         2         2         8         2         3\n         2         4         1         7\n{ZEROS}"
        );
        let values = "  1.00000E+00 -2.00000E+00  3.00000E+00\n";
        assert!(read_text(55, &format!("{head}         5\n")).unwrap_err().to_string().contains("values of node 5"));
        let twice = read_text(55, &format!("{head}         5\n{values}         5\n{values}")).unwrap_err().to_string();
        assert!(twice.contains("stands twice") && twice.contains("line 11"), "{twice}");
    }

    #[test]
    fn impossible_counts_are_refused_and_never_allocated() {
        for types in
            ["         1         2         2         8         2 999999999", "         1         2         2         8         9         3"]
        {
            assert!(read_text(55, &format!("{IDS}NONE\n{types}\n")).is_err());
        }
        let types = "         1         2         2         8         2         3\n";
        assert!(read_text(55, &format!("{IDS}NONE\n{types}999999999999999999\n")).is_err());
    }
}
