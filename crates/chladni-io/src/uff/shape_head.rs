//! The head of datasets 55 and 2414, before the values: codes, integers and reals (tables
//! in [`super::shapes`]).

use super::fields::{decode, label, numbers, whole, Column, Record};
use crate::shape::MOST_COMPONENTS;
use crate::{Analysis, Shape, ShapeForm, ShapeNumbers};
use chladni_frf::{Direction, Dof, Error, Finding, Result};
use ndarray::Array2;
use num_complex::Complex64;

const TYPES: [Column; 6] = [
    ("model type", 10),
    ("analysis type", 10),
    ("data characteristic", 10),
    ("quantity", 10),
    ("data type", 10),
    ("values per node", 10),
];
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
pub(super) const SIX_REALS: [Column; 6] = [
    ("value 1", 13),
    ("value 2", 13),
    ("value 3", 13),
    ("value 4", 13),
    ("value 5", 13),
    ("value 6", 13),
];
/// Most integers or reals before the values.
const MOST_HEADER_NUMBERS: i64 = 100;

/// A shape without values.
pub(super) struct ShapeHead {
    pub shape: Shape,
    /// Values per node.
    pub components: usize,
    /// False where the values belong to elements or points.
    pub at_nodes: bool,
}

/// The records of a dataset, one after the other.
pub(super) struct Reader<'w, I> {
    pub records: I,
    /// Line of the record read last.
    pub last_line: u64,
    pub warnings: &'w mut Vec<Finding>,
}

impl<'a, I: Iterator<Item = Record<'a>>> Reader<'_, I> {
    /// The next record, which must exist.
    pub fn next(&mut self, what: &str) -> Result<Record<'a>> {
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

    /// Reads dataset 55 up to its values.
    pub fn head_of_55(&mut self) -> Result<ShapeHead> {
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
        let mut shape = Shape {
            id_lines,
            reference,
            ..shape
        };
        let mut integers = self.integers()?;
        let counts = [integers[0], integers[1]];
        if counts
            .iter()
            .any(|count| !(0..=MOST_HEADER_NUMBERS).contains(count))
        {
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
        let stated = |k: usize| {
            if (k as i64) < counts[0] {
                integers.get(2 + k).copied().unwrap_or(0)
            } else {
                0
            }
        };
        let mut reals = self.reals((counts[1] + 5) / 6)?;
        reals.truncate(counts[1] as usize);
        shape.numbers = numbers_of_55(shape.analysis, [stated(0), stated(1)], &reals);
        Ok(ShapeHead {
            shape,
            components,
            at_nodes: true,
        })
    }

    /// Reads dataset 2414 up to its values.
    pub fn head_of_2414(&mut self) -> Result<ShapeHead> {
        self.next("analysis dataset label")?;
        let name = label(&decode(self.next("name")?.text));
        let record = self.next("dataset location")?;
        let [location] = numbers(record, [("dataset location", 10)], self.warnings)?;
        let location = whole(record, "dataset location", location)?;
        if !matches!(location, 1 | 2 | 3 | 5) {
            let error = Error::bad_data("unknown code")
                .at_line(record.line)
                .field("dataset location")
                .found(location);
            return Err(error.expected("1 nodes, 2 elements, 3 nodes on elements or 5 points"));
        }
        let mut id_lines: [String; 5] = Default::default();
        for line in &mut id_lines {
            *line = label(&decode(self.next("ID lines")?.text));
        }
        let (shape, components) = self.types(ShapeForm::Analysis2414)?;
        let mut shape = Shape {
            name,
            id_lines,
            ..shape
        };
        let mut integers = self.integers()?;
        integers.extend(self.integers()?);
        let reals = self.reals(2)?;
        shape.numbers = numbers_of_2414(shape.analysis, &integers, &reals);
        if location != 1 {
            self.warnings.push(Finding::caution(
                "not-read",
                "the values do not stand at nodes (location 2, 3 or 5): they are \
                                listed and not read",
            ));
        }
        Ok(ShapeHead {
            shape,
            components,
            at_nodes: location == 1,
        })
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
            Error::bad_data("unknown code")
                .at_line(record.line)
                .field(field)
                .found(found)
                .expected(expected)
        };
        let complex = match (form, data_type) {
            (_, 2) | (ShapeForm::Analysis2414, 1 | 4) => false,
            (_, 5) | (ShapeForm::Analysis2414, 6) => true,
            // not in the definition of 55, but written by some programs
            (ShapeForm::AtNodes55, 4 | 6) => {
                let read_as = if data_type == 4 { 2 } else { 5 };
                let words =
                    format!("data type {data_type} is not of dataset 55; read as {read_as}");
                self.warnings.push(Finding::note("loosely-written", words));
                data_type == 6
            }
            (form, _) => {
                let expected = match form {
                    ShapeForm::AtNodes55 => "2 real or 5 complex",
                    ShapeForm::Analysis2414 => "1 integer, 2 or 4 real, 5 or 6 complex",
                };
                return Err(unknown("data type", data_type, expected));
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

    /// The reals of `lines` records.
    fn reals(&mut self, lines: i64) -> Result<Vec<f64>> {
        let mut reals = Vec::new();
        for _ in 0..lines {
            let record = self.next("reals before the values")?;
            reals.extend(numbers(record, SIX_REALS, self.warnings)?);
        }
        Ok(reals)
    }

    fn integers(&mut self) -> Result<Vec<i64>> {
        let record = self.next("integers before the values")?;
        let values = numbers(record, EIGHT_INTEGERS, self.warnings)?;
        values
            .into_iter()
            .zip(EIGHT_INTEGERS)
            .map(|(value, (name, _))| whole(record, name, value))
            .collect()
    }
}

/// Reference of test data, in ID line 5: node, direction, numerator code, denominator
/// code.
fn reference_of(line: &str) -> Option<Dof> {
    let words: Vec<i64> = line
        .split_whitespace()
        .map(|word| word.parse().ok())
        .collect::<Option<_>>()?;
    let &[node, direction, _, _] = words.as_slice() else {
        return None;
    };
    Some(Dof {
        node: u64::try_from(node).ok().filter(|&node| node > 0)?,
        direction: Direction::from_code(direction)?,
    })
}

/// Integers and reals of dataset 2414, sixteen and twelve.
fn numbers_of_2414(analysis: Analysis, integers: &[i64], reals: &[f64]) -> ShapeNumbers {
    let step = match analysis {
        Analysis::Transient => 6,
        Analysis::FrequencyResponse => 7,
        _ => 5,
    };
    let pair = |k: usize| Complex64::new(reals[k], reals[k + 1]);
    ShapeNumbers {
        load_case: integers[4],
        number: integers[step],
        time_s: reals[0],
        frequency_hz: reals[1],
        modal_mass: reals[3],
        viscous: reals[4],
        hysteretic: reals[5],
        eigenvalue: match analysis {
            Analysis::Buckling => Complex64::from(reals[2]),
            _ => pair(6),
        },
        modal_a: pair(8),
        modal_b: pair(10),
    }
}

/// Reals of dataset 55: analysis 2 frequency, mass, ζ, η; 3 and 7 λ, A, B as pairs; 4
/// time; 5 frequency; 6 eigenvalue.
fn numbers_of_55(analysis: Analysis, [load_case, number]: [i64; 2], reals: &[f64]) -> ShapeNumbers {
    let real = |k: usize| reals.get(k).copied().unwrap_or(0.0);
    let pair = |k: usize| Complex64::new(real(k), real(k + 1));
    let numbers = ShapeNumbers {
        load_case,
        number,
        ..ShapeNumbers::default()
    };
    match analysis {
        Analysis::NormalMode => ShapeNumbers {
            frequency_hz: real(0),
            modal_mass: real(1),
            viscous: real(2),
            hysteretic: real(3),
            ..numbers
        },
        Analysis::ComplexModeFirstOrder | Analysis::ComplexModeSecondOrder => ShapeNumbers {
            eigenvalue: pair(0),
            modal_a: pair(2),
            modal_b: pair(4),
            ..numbers
        },
        Analysis::Transient => ShapeNumbers {
            time_s: real(0),
            ..numbers
        },
        Analysis::FrequencyResponse => ShapeNumbers {
            frequency_hz: real(0),
            ..numbers
        },
        Analysis::Buckling => ShapeNumbers {
            eigenvalue: Complex64::from(real(0)),
            ..numbers
        },
        Analysis::Static | Analysis::Other(_) => numbers,
    }
}
