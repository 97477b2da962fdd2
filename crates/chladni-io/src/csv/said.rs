//! The information of a table's remarks about the whole file.

use super::remarks::Remark;
use crate::limits::SAME_UNIT;
use crate::unit_label::{frequency_unit, frf_unit, FrfUnit};
use crate::PhaseUnit;
use chladni_frf::{Dof, Error, Finding, FrfKind, ReferenceUnit, Result, TimeSign};

/// The information in remarks, in other text above the table and in the options.
#[derive(Default)]
pub(super) struct Said {
    pub(super) kind: Option<FrfKind>,
    pub(super) unit: Option<String>,
    pub(super) time_sign: Option<TimeSign>,
    pub(super) reference_unit: Option<ReferenceUnit>,
    pub(super) response: Option<Dof>,
    pub(super) reference: Option<Dof>,
    pub(super) phase_unit: Option<PhaseUnit>,
    /// Label and factor to Hz.
    pub(super) frequency_unit: Option<(String, f64)>,
    /// The caller's unit of phases.
    pub(super) told_phase_unit: Option<PhaseUnit>,
    /// Text above the table.
    pub(super) header_text: String,
}

impl Said {
    /// # Errors
    /// A value that its key does not have.
    pub(super) fn from_remarks(remarks: &[Remark], warnings: &mut Vec<Finding>) -> Result<Self> {
        let mut said = Self::default();
        for remark in remarks {
            let wrong = |message: String| {
                Error::bad_word(&message, &remark.value)
                    .at_line(remark.line)
                    .field(&remark.key)
            };
            match remark.key.as_str() {
                "frf_kind" => said.kind = Some(remark.value.parse().map_err(wrong)?),
                "time_sign" => said.time_sign = Some(remark.value.parse().map_err(wrong)?),
                "unit" => said.unit = Some(remark.value.clone()),
                "response" => said.response = Some(remark.value.parse().map_err(wrong)?),
                "reference" => said.reference = Some(remark.value.parse().map_err(wrong)?),
                "phase_unit" => said.phase_unit = Some(remark.value.parse().map_err(wrong)?),
                "frequency_unit" => {
                    let factor = frequency_unit(&remark.value).ok_or_else(|| {
                        wrong("no unit of a frequency; write Hz, kHz, rad/s or 1/min".into())
                    })?;
                    said.frequency_unit = Some((remark.value.clone(), factor));
                }
                "reference_unit" => {
                    said.reference_unit = Some(match remark.value.as_str() {
                        "N" => ReferenceUnit::Newton,
                        "V" => ReferenceUnit::Volt,
                        _ => {
                            return Err(
                                wrong("unknown unit of the reference".into()).expected("N or V")
                            )
                        }
                    })
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
        Ok(said)
    }

    /// Adds the unit that a column of units states in every row.
    ///
    /// # Errors
    /// A remark with another unit.
    pub(super) fn add_unit(&mut self, label: String) -> Result<()> {
        if let Some(told) = self.unit.as_ref().filter(|told| **told != label) {
            let is_same =
                matches!((frf_unit(told), frf_unit(&label)), (Some(a), Some(b)) if !differ(a, b));
            if !is_same {
                return Err(two_units(told, &label));
            }
        }
        self.unit = Some(label);
        Ok(())
    }

    /// Factor to Hz of a frequency column called `label`: that of a remark where the
    /// label, whose own factor is `own`, says none.
    ///
    /// # Errors
    /// A remark and a label of different units.
    pub(super) fn frequency_factor(&self, own: f64, label: &str) -> Result<f64> {
        let Some((unit, told)) = &self.frequency_unit else {
            return Ok(own);
        };
        let is_named = own != 1.0 || label.to_lowercase().contains("hz");
        if is_named && own != *told {
            return Err(Error::bad_data("two units of the frequency")
                .field("frequency_unit")
                .found(format!("`{unit}` in a remark, `{label}` in the header"))
                .expected("one unit")
                .help("correct the remark or the header"));
        }
        Ok(*told)
    }
}

/// True for units that give other values.
pub(super) fn differ(a: FrfUnit, b: FrfUnit) -> bool {
    (a.kind, a.reference) != (b.kind, b.reference) || (a.to_si / b.to_si - 1.0).abs() > SAME_UNIT
}

/// The error of a file and a column that state different units.
pub(super) fn two_units(of_file: &str, of_column: &str) -> Error {
    Error::bad_data("a remark and a column state different units")
        .field("unit")
        .found(format!(
            "`{of_file}` in the remark, `{of_column}` in the column"
        ))
        .expected("one unit")
        .help("correct the remark or the header, or leave one of them out")
}
