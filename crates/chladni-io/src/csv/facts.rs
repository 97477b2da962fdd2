//! Facts about a whole table: its remarks, and the options of the caller.

use super::remarks::Remark;
use crate::limits::SAME_UNIT;
use crate::unit_label::{decibel_reference, frequency_unit, frf_unit, FrfUnit};
use crate::PhaseUnit;
use chladni_frf::{Dof, Error, Finding, FrfKind, ReferenceUnit, Result, TimeSign};
use std::collections::BTreeMap;
use std::str::FromStr;

/// Facts about a whole table, from remarks, a column of units and the options.
#[derive(Default)]
pub(super) struct TableFacts {
    pub(super) kind: Option<FrfKind>,
    pub(super) unit: Option<String>,
    /// True where a column states `unit`, not a remark.
    pub(super) is_unit_of_column: bool,
    pub(super) time_sign: Option<TimeSign>,
    /// Unit of the reference, and the line of its remark.
    pub(super) reference_unit: Option<(ReferenceUnit, u64)>,
    /// DOF of the response, and the line of its remark.
    pub(super) response: Option<(Dof, u64)>,
    /// DOF of the reference, and the line of its remark.
    pub(super) reference: Option<(Dof, u64)>,
    /// Unit of phases, and the line of its remark.
    pub(super) phase_unit: Option<(PhaseUnit, u64)>,
    /// Label, factor to Hz, and the line of its remark.
    pub(super) frequency_unit: Option<(String, f64, u64)>,
    /// The caller's unit of phases.
    pub(super) caller_phase_unit: Option<PhaseUnit>,
    /// Text above the table.
    pub(super) header_text: String,
}

impl TableFacts {
    /// Reads remarks; keys that look like units and are not known are reported.
    ///
    /// # Errors
    /// A value that its key does not have.
    pub(super) fn from_remarks(remarks: &[Remark], warnings: &mut Vec<Finding>) -> Result<Self> {
        let mut facts = Self::default();
        for remark in remarks {
            let wrong = |message: String| {
                Error::bad_word(&message, &remark.value)
                    .at_line(remark.line)
                    .field(&remark.key)
                    .help("correct the remark, or leave it out")
            };
            match remark.key.as_str() {
                "frf_kind" => facts.kind = Some(remark.value.parse().map_err(wrong)?),
                "time_sign" => facts.time_sign = Some(remark.value.parse().map_err(wrong)?),
                // a header may state the unit of the other axis, too
                "unit" if facts.unit.is_none() || unit_value(&remark.value).is_some() => {
                    facts.unit = Some(remark.value.clone())
                }
                "unit" => {}
                "response" => {
                    facts.response = Some((remark.value.parse().map_err(wrong)?, remark.line))
                }
                "reference" => {
                    facts.reference = Some((remark.value.parse().map_err(wrong)?, remark.line))
                }
                "phase_unit" => {
                    facts.phase_unit = Some((remark.value.parse().map_err(wrong)?, remark.line))
                }
                "frequency_unit" => {
                    let factor = frequency_unit(&remark.value).ok_or_else(|| {
                        wrong("no unit of a frequency; write Hz, kHz, rad/s or 1/min".into())
                    })?;
                    facts.frequency_unit = Some((remark.value.clone(), factor, remark.line));
                }
                "reference_unit" => {
                    let unit = match remark.value.as_str() {
                        "N" => ReferenceUnit::Newton,
                        "V" => ReferenceUnit::Volt,
                        _ => {
                            return Err(wrong("unknown unit of the reference".into())
                                .expected("N or V")
                                .help("scale the values to N or V, and write that unit"))
                        }
                    };
                    facts.reference_unit = Some((unit, remark.line));
                }
                key if key.ends_with("unit") || key.ends_with("units") => {
                    warnings.push(Finding::note(
                        "remark-not-used",
                        format!(
                            "line {}: `{key}` is no remark that is understood; not used",
                            remark.line
                        ),
                    ))
                }
                _ => {} // free text such as a date or an operator
            }
        }
        Ok(facts)
    }

    /// Adds the unit that a column of units states in every row.
    ///
    /// # Errors
    /// A remark with another unit.
    pub(super) fn add_unit(&mut self, label: String) -> Result<()> {
        if let Some(told) = self
            .unit
            .as_ref()
            .filter(|told| !is_same_unit(told, &label))
        {
            return Err(self.two_units(told, &label));
        }
        self.unit = Some(label);
        self.is_unit_of_column = true;
        Ok(())
    }

    /// The error of different units of the file and of a column.
    pub(super) fn two_units(&self, of_file: &str, of_column: &str) -> Error {
        let (what, place) = match self.is_unit_of_column {
            true => (
                "a column of units and the name of a column",
                "column of units",
            ),
            false => ("a remark and a column", "remark"),
        };
        let other = if self.is_unit_of_column {
            "name"
        } else {
            "column"
        };
        Error::bad_data(format!("{what} state different units"))
            .field("unit")
            .found(format!(
                "`{of_file}` in the {place}, `{of_column}` in the {other}"
            ))
            .expected("one unit")
            .help(format!(
                "correct the {place} or the header, or leave one of them out"
            ))
    }

    /// The unit of the file; for decibels, that of their reference.
    pub(super) fn linear_unit(&self) -> Option<FrfUnit> {
        let label = self.unit.as_deref()?;
        frf_unit(label).or_else(|| frf_unit(decibel_reference(label)?.1))
    }

    /// Factor to Hz of the frequency column: that of a remark, else `own`, the factor of the
    /// column's name or unit `label`.
    ///
    /// # Errors
    /// A remark and a label of different units.
    pub(super) fn frequency_factor(&self, own: f64, label: &str) -> Result<f64> {
        let Some((unit, told, line)) = &self.frequency_unit else {
            return Ok(own);
        };
        let is_named = own != 1.0 || label.to_lowercase().contains("hz");
        if is_named && own != *told {
            return Err(Error::bad_data("two units of the frequency")
                .at_line(*line)
                .field("frequency_unit")
                .found(format!("`{unit}` in a remark, `{label}` in the header"))
                .expected("one unit")
                .help("correct the remark or the header"));
        }
        Ok(*told)
    }
}

/// Refuses remarks of one key that state different values.
///
/// # Errors
/// The second of two such remarks.
pub(super) fn refuse_contradictions(remarks: &[Remark]) -> Result<()> {
    let mut firsts: BTreeMap<&str, &Remark> = BTreeMap::new();
    for second in remarks {
        let first = *firsts.entry(&second.key).or_insert(second);
        if !agree(first, second) {
            return Err(Error::bad_data("two remarks state different values")
                .at_line(second.line)
                .field(&second.key)
                .found(format!(
                    "`{}` in line {}, `{}` in line {}",
                    first.value, first.line, second.value, second.line
                ))
                .expected("one value")
                .help("correct one of them, or leave it out"));
        }
    }
    Ok(())
}

/// True for two remarks of one key that state the same, or state no fact.
fn agree(first: &Remark, second: &Remark) -> bool {
    fn same<T: FromStr + PartialEq>(one: &str, other: &str) -> bool {
        let values = (one.parse::<T>().ok(), other.parse::<T>().ok());
        one == other || values.0.is_some() && values.0 == values.1
    }
    let (one, other) = (first.value.as_str(), second.value.as_str());
    match first.key.as_str() {
        "frf_kind" => same::<FrfKind>(one, other),
        "time_sign" => same::<TimeSign>(one, other),
        "response" | "reference" => same::<Dof>(one, other),
        "phase_unit" => same::<PhaseUnit>(one, other),
        // one that no FRF has is that of another axis
        "unit" => {
            [one, other].iter().any(|it| unit_value(it).is_none()) || is_same_unit(one, other)
        }
        "frequency_unit" => frequency_unit(one) == frequency_unit(other),
        "reference_unit" => one == other,
        _ => true, // free text
    }
}

/// True for units of different kind, reference or factor.
pub(super) fn differ(a: FrfUnit, b: FrfUnit) -> bool {
    (a.kind, a.reference) != (b.kind, b.reference) || (a.to_si / b.to_si - 1.0).abs() > SAME_UNIT
}

/// The unit of FRFs that a label names, and true for decibels; `None` for another label.
fn unit_value(label: &str) -> Option<(bool, FrfUnit)> {
    let Some((reference, unit)) = decibel_reference(label) else {
        return Some((false, frf_unit(label)?));
    };
    let unit = frf_unit(unit)?;
    let to_si = unit.to_si * reference;
    Some((true, FrfUnit { to_si, ..unit }))
}

/// True for labels of one unit in any spelling; for decibels, also of one reference.
pub(super) fn is_same_unit(one: &str, other: &str) -> bool {
    one == other
        || matches!(
            (unit_value(one), unit_value(other)),
            (Some((a_db, a)), Some((b_db, b))) if a_db == b_db && !differ(a, b)
        )
}
