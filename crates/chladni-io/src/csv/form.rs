//! The form of the complex values of an FRF in two columns, and their unit.

use super::column_header::{AngleUnit, ColumnHeader};
use super::vocabulary::{is_decibel, words};
use super::TableFacts;
use crate::unit_label::{decibel_reference, frf_unit, is_decibel_label, FrfUnit};
use crate::PhaseUnit;
use chladni_frf::{Error, Finding, Result};
use num_complex::Complex64;

/// One column with its header.
pub(super) struct Column<'a> {
    /// Counted from 0.
    pub(super) number: usize,
    pub(super) name: &'a str,
    pub(super) head: &'a ColumnHeader,
    pub(super) values: &'a [f64],
}

impl Column<'_> {
    fn place(&self) -> String {
        format!("column {}", self.number + 1)
    }
    /// −1 where the header states the negative of a part, else 1.
    fn sign(&self) -> f64 {
        if self.head.is_negative {
            -1.0
        } else {
            1.0
        }
    }
    /// Name and unit as in the file.
    fn label(&self) -> String {
        match (self.name.is_empty(), self.name.contains(&self.head.unit)) {
            (true, _) if self.head.unit.is_empty() => "no name".into(),
            (_, true) => self.name.to_owned(),
            _ => format!("{} {}", self.name, self.head.unit)
                .trim()
                .to_owned(),
        }
    }
}

/// Conversion of the numbers of two columns to a complex value.
pub(super) struct Form {
    polar: Option<Polar>,
    /// Factor of the second column to the unit of the first.
    second_factor: f64,
    pub(super) unit: Option<FrfUnit>,
    pub(super) unit_text: String,
}

struct Polar {
    to_radians: f64,
    /// The value at 0 dB, of a magnitude in decibels.
    decibel: Option<f64>,
}

impl Form {
    /// The form of a real and an imaginary part.
    pub(super) fn rectangular(first: &Column<'_>, second: &Column<'_>) -> Result<Self> {
        for column in [first, second] {
            if column.head.is_decibel() {
                return Err(Error::bad_data("a part of a complex number in decibels")
                    .field(column.place())
                    .found(column.label())
                    .expected("a linear real and imaginary part, or magnitude and phase")
                    .help("export real and imaginary part in linear units"));
            }
        }
        refuse_minus(first)?;
        let (a, b) = (first.head.frf_unit(), second.head.frf_unit());
        let second_factor = match (a, b) {
            (Some(a), Some(b)) if (a.kind, a.reference) != (b.kind, b.reference) => {
                return Err(Error::bad_data(
                    "real and imaginary part have units of different kinds",
                )
                .field(second.place())
                .found(format!("{} beside {}", second.label(), first.label()))
                .expected("one unit for both")
                .help("correct the header: both columns are parts of one FRF"))
            }
            (Some(a), Some(b)) => b.to_si / a.to_si,
            _ => 1.0,
        };
        let second_factor = second_factor * second.sign();
        let from = if first.head.unit.is_empty() || (a.is_none() && b.is_some()) {
            second
        } else {
            first
        };
        Ok(Self {
            polar: None,
            second_factor,
            unit: a.or(b),
            unit_text: from.head.unit.clone(),
        })
    }

    /// The form of a magnitude and a phase. Units that the columns do not state are taken from
    /// `facts`.
    pub(super) fn polar(
        magnitude: &Column<'_>,
        phase: &Column<'_>,
        facts: &TableFacts,
        warnings: &mut Vec<Finding>,
    ) -> Result<Self> {
        refuse_minus(magnitude)?;
        let label = if magnitude.head.unit.is_empty() {
            facts.unit.as_deref().unwrap_or("")
        } else {
            &magnitude.head.unit
        };
        let in_decibels = magnitude.head.is_decibel() || words(label).any(is_decibel);
        let (decibel, label) = if in_decibels {
            let (reference, unit) = decibel_reference(label)
                .filter(|(_, unit)| frf_unit(unit).is_some())
                .ok_or_else(|| decibels_without_reference(magnitude))?;
            (Some(reference), unit)
        } else {
            linear(magnitude, facts)?;
            (None, label)
        };
        Ok(Self {
            polar: Some(Polar {
                to_radians: phase_unit(phase, facts, warnings)?.to_radians() * phase.sign(),
                decibel,
            }),
            second_factor: 1.0,
            unit: frf_unit(label),
            unit_text: label.to_owned(),
        })
    }

    /// The value of one line, in the unit of the first column.
    pub(super) fn value(&self, first: f64, second: f64) -> Complex64 {
        match &self.polar {
            None => Complex64::new(first, second * self.second_factor),
            Some(polar) => {
                let magnitude = match polar.decibel {
                    Some(reference) => reference * 10f64.powf(first / 20.0),
                    None => first,
                };
                Complex64::from_polar(magnitude, second * polar.to_radians)
            }
        }
    }
}

/// Refuses a minus before a real part or a magnitude: it may be a dash.
fn refuse_minus(first: &Column<'_>) -> Result<()> {
    if !first.head.is_negative {
        return Ok(());
    }
    Err(
        Error::bad_data("a minus in front of a real part or a magnitude")
            .field(first.place())
            .found(first.label())
            .expected("a minus in front of an imaginary part or a phase, or none")
            .help("correct the header, or export the numbers with their own sign"),
    )
}

fn decibels_without_reference(magnitude: &Column<'_>) -> Error {
    Error::bad_data("a logarithm of a magnitude, or dB without its reference")
        .field(magnitude.place())
        .found(magnitude.label())
        .expected("a header like `Magnitude [dB re 1 m/s/N]`")
        .help("write the reference value and unit into the header, or export linear values")
}

/// Refuses a magnitude that may not be linear: below zero, or without a unit in a file that
/// mentions decibels.
fn linear(magnitude: &Column<'_>, facts: &TableFacts) -> Result<()> {
    if let Some(told) = facts.unit.as_deref().filter(|told| is_decibel_label(told)) {
        return Err(facts.two_units(told, &magnitude.head.unit));
    }
    let below = magnitude.values.iter().find(|value| **value < 0.0);
    let speaks_of_decibels = magnitude.head.unit.is_empty()
        && facts.unit.is_none()
        && words(&facts.header_text).any(is_decibel);
    let (message, found) = match below {
        Some(value) => ("a magnitude below zero; is it in dB?", value.to_string()),
        None if speaks_of_decibels => (
            "the file speaks of dB, and the magnitude has no unit",
            magnitude.label(),
        ),
        None => return Ok(()),
    };
    Err(Error::bad_data(message)
        .field(magnitude.place())
        .found(found)
        .expected("a linear magnitude, or dB with its reference in the header")
        .help(
            "name the unit in the header, as `Magnitude [m/s/N]` or `Magnitude [dB re 1 \
             m/s/N]`, or export real and imaginary part",
        ))
}

/// Unit of a phase: that of the user, else of the column or the file, else by the size of
/// its numbers.
fn phase_unit(
    phase: &Column<'_>,
    facts: &TableFacts,
    warnings: &mut Vec<Finding>,
) -> Result<PhaseUnit> {
    let own = match phase.head.angle() {
        AngleUnit::Unit(unit) => Some(unit),
        _ => None,
    };
    let of_remark = facts.phase_unit.map(|(unit, _)| unit);
    if let Some(told) = facts.caller_phase_unit {
        let stated = [
            (own, phase.label()),
            // without backticks, in which it is an option
            (of_remark, "the remark phase_unit".into()),
        ];
        let other = |(unit, _): &&(Option<PhaseUnit>, String)| unit.is_some_and(|it| it != told);
        if let Some((Some(unit), place)) = stated.iter().find(other) {
            let (unit, told) = (unit.as_str(), told.as_str());
            let words = format!("{place} says {unit}, you say {told}: taken as {told}");
            push_once(warnings, Finding::note("option-overrules-file", words));
        }
        return Ok(told);
    }
    let ask = |message: &str| {
        Error::bad_data(message)
            .field(phase.place())
            .found(phase.label())
            .expected("deg or rad")
            .help(
                "say it with `phase_unit deg` or `phase_unit rad`, or in the header: `phase [rad]`",
            )
    };
    if phase.head.angle() == AngleUnit::NotUnderstood {
        return Err(ask("the unit of the phase is not understood"));
    }
    if let (Some(own), Some((stated, line))) = (own, facts.phase_unit) {
        if own != stated {
            let (stated, label) = (stated.as_str(), phase.label());
            return Err(Error::bad_data("two units of the phase")
                .at_line(line)
                .field("phase_unit")
                .found(format!("`{stated}` in a remark, `{label}` in the header"))
                .expected("one unit")
                .help("correct the remark or the header"));
        }
    }
    if let Some(known) = own.or(of_remark) {
        return Ok(known);
    }
    // whole words: `rad/s` is a frequency
    let by_text = |unit| {
        facts
            .header_text
            .split(|c: char| c.is_whitespace() || "()[],;:=".contains(c))
            .any(|word| PhaseUnit::named(word) == Some(unit))
    };
    if by_text(PhaseUnit::Radian) {
        return Err(ask(
            "the file speaks of radians, and the phase has no unit: is it in degrees or radians?",
        ));
    }
    if by_text(PhaseUnit::Degree) {
        return Ok(PhaseUnit::Degree);
    }
    let unit = PhaseUnit::by_size(phase.values.iter().copied())
        .ok_or_else(|| ask("the phase has no unit, and its numbers may be degrees or radians"))?;
    push_once(
        warnings,
        Finding::caution(
            "phase-in-degrees",
            "the header does not say the unit of the phase: taken as degrees",
        ),
    );
    Ok(unit)
}

/// Adds a warning that is the same for many columns once.
pub(super) fn push_once(warnings: &mut Vec<Finding>, warning: Finding) {
    if !warnings.contains(&warning) {
        warnings.push(warning);
    }
}
