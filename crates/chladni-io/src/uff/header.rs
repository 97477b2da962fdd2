//! Dataset 164 (units) and the names of the datasets.
//!
//! | record of 164 | format | fields |
//! |---|---|---|
//! | 1 | I10,20A1,I10 | code, description, temperature mode |
//! | 2 | 3D25.17 (4th value on the next line) | length, force, temperature factors, temperature offset |
//!
//! Values in the file are **divided** by the factor to get SI (feet: 3.2808...).
//! Some programs multiply instead, by mistake. Dataset 151 (header) holds nothing but text;
//! it is listed and not read.

use super::fields::{numbers, whole, Record};
use chladni_frf::{Error, Finding, Result};

/// Factors of dataset 164: a value in the file divided by its factor is in SI.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Units {
    pub length: f64,
    pub force: f64,
}

impl Units {
    /// m and N.
    pub(super) const SI: Self = Self {
        length: 1.0,
        force: 1.0,
    };

    /// Factor of length^a·force^b; dividing by it gives SI. Time is always seconds.
    pub(super) fn factor(&self, [length, force]: [i32; 2]) -> f64 {
        self.length.powi(length) * self.force.powi(force)
    }
    /// True where factors change nothing.
    pub(super) fn is_si(&self) -> bool {
        *self == Self::SI
    }
}

/// Unit codes with the factors that belong to them: code, name, length, force.
const KNOWN_CODES: [(i64, &str, f64, f64); 9] = [
    (1, "m, N", 1.0, 1.0),
    (2, "ft, lbf", 3.280_839_895_013_12, 0.224_808_943_099_711),
    (3, "m, kgf", 1.0, 0.101_971_621_297_793),
    (4, "ft, pdl", 3.280_839_895_013_12, 7.233_013_851_209_89),
    (5, "mm, mN", 1e3, 1e3),
    (6, "cm, cN", 1e2, 1e2),
    (7, "in, lbf", 39.370_078_740_157_5, 0.224_808_943_099_711),
    (8, "mm, kgf", 1e3, 0.101_971_621_297_793),
    (10, "mm, N", 1e3, 1.0),
];
/// Relative rounding of printed factors; wrong ones differ by far more.
const FACTOR_TOLERANCE: f64 = 1e-3;

/// Reads dataset 164.
///
/// # Errors
/// A factor that is missing, not positive, or no number.
pub(super) fn read_units<'a>(
    mut records: impl Iterator<Item = Record<'a>>,
    warnings: &mut Vec<Finding>,
) -> Result<Units> {
    let missing = |what: &str| {
        Error::bad_data("the units dataset is too short")
            .field(what)
            .found("no such record")
            .expected("a record with unit factors")
    };
    let first = records.next().ok_or_else(|| missing("record 1"))?;
    // only the code is read: the description may have any length, and the temperature mode
    // may be missing
    let code_field = Record {
        text: &first.text[..first.text.len().min(10)],
        ..first
    };
    let [code] = numbers(code_field, [("record 1: units code", 10)], warnings)?;
    let code = whole(first, "record 1: units code", code)?;
    let second = records.next().ok_or_else(|| missing("record 2"))?;
    let names = [
        ("record 2: length factor", 25),
        ("record 2: force factor", 25),
        ("record 2: temperature factor", 25),
    ];
    let [length, force, _] = numbers(second, names, warnings)?;
    for (field, factor) in [("length factor", length), ("force factor", force)] {
        if factor <= 0.0 {
            return Err(Error::bad_data("a unit factor must be positive")
                .at_line(second.line)
                .field(format!("record 2: {field}"))
                .found(factor)
                .expected("units per SI unit, such as 1000 for mm"));
        }
    }
    if let Some((_, name, known_length, known_force)) =
        KNOWN_CODES.iter().find(|known| known.0 == code)
    {
        for (what, factor, known) in [
            ("length", length, known_length),
            ("force", force, known_force),
        ] {
            if (factor / known - 1.0).abs() > FACTOR_TOLERANCE {
                warnings.push(Finding::note(
                    "unit-contradicted",
                    format!(
                    "line {}: units code {code} ({name}) has the {what} factor {known}, the file \
                     says {factor}; {factor} is used",
                    second.line
                ),
                ));
            }
        }
    }
    Ok(Units { length, force })
}

/// The name of a dataset.
pub(super) fn dataset_name(number: u32) -> String {
    match number {
        15 | 2411 => "nodes",
        18 | 2420 => "coordinate systems",
        55 => "data at nodes",
        58 => "function",
        82 => "trace lines",
        151 => "header",
        164 => "units",
        2412 => "elements",
        2414 => "analysis data",
        _ => return format!("unknown dataset {number}"),
    }
    .to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> (Result<Units>, Vec<Finding>) {
        let mut warnings = Vec::new();
        let records = text.lines().zip(1..).map(|(text, line)| Record {
            line,
            text: text.as_bytes(),
        });
        (read_units(records, &mut warnings), warnings)
    }

    #[test]
    fn a_length_in_millimetres_is_divided_by_a_thousand() {
        let (units, warnings) = read(
            "         5mm (milli-newton)            2\n  \
                                      1.000000000000000E+03    1.0D+03   1.0\n  0.0",
        );
        assert_eq!(171.0 / units.unwrap().factor([1, 0]), 0.171);
        assert_eq!(warnings.len(), 1, "split on blanks: {warnings:?}");
    }

    #[test]
    fn a_missing_temperature_mode_and_a_long_description_are_accepted() {
        let (units, warnings) = read(
            "         1SI with a description of any length, far beyond its field\n  \
                  1.00000000000000000D+00  1.00000000000000000D+00",
        );
        assert!(units.unwrap().is_si());
        assert!(warnings.is_empty(), "{warnings:?}");
    }

    #[test]
    fn factors_that_contradict_their_code_are_reported() {
        let (units, warnings) = read(
            "         5                    \n  1.00000000000000000D-03  1.00000000000000000D-03\n",
        );
        assert_eq!(units.unwrap().length, 1e-3);
        assert_eq!(warnings.len(), 2);
    }

    #[test]
    fn factors_that_are_no_factors_are_refused() {
        for text in [
            "",
            "         1",
            "         1\n  0.0 0.0 0.0",
            "         1\n  abc",
            "         1\n -1.0 1.0 1.0",
        ] {
            assert!(read(text).0.is_err(), "{text:?}");
        }
    }
}
