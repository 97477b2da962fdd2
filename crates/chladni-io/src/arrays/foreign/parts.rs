//! Complex values from the arrays that hold them: complex ones, two parts, or a column of
//! frequencies with the FRFs beside it.

use super::choose::{joined_axis, Source};
use super::facts::FrfFacts;
use super::frequency::stated_to_hz;
use super::{is_matlab, Reader};
use crate::arrays::tree::Entry;
use crate::arrays::values::{real_array, wrong_type, ComplexArray};
use crate::unit_label::{decibel_reference, is_decibel_label};
use crate::PhaseUnit;
use chladni_frf::{Error, Finding, Result};
use ndarray::{Axis, Zip};
use num_complex::Complex64;

/// The label of the linear values; of decibels, the unit after `dB re 1`.
///
/// # Errors
/// A label in decibels where the values are no magnitude.
pub(super) fn linear_label<'l>(source: Source<'_>, label: &'l str) -> Result<&'l str> {
    if !is_decibel_label(label) {
        return Ok(label);
    }
    match (source, decibel_reference(label)) {
        (Source::Polar(..), Some((_, unit))) => Ok(unit),
        _ => Err(without_reference(source.first(), label)),
    }
}

fn without_reference(entry: &Entry, label: &str) -> Error {
    Error::bad_data("values in dB without a reference value")
        .field(&entry.path)
        .found(format!("unit `{label}`"))
        .expected("linear values, or a magnitude with its reference: `dB re 1 m/s/N`")
        .help("save linear complex values, or write the reference value and unit into `unit`")
}

/// The value at 0 dB of a magnitude in decibels; `None` for a linear one.
fn decibel(
    entry: &Entry,
    facts: &FrfFacts<'_>,
    values: impl Iterator<Item = f64>,
) -> Result<Option<f64>> {
    let label = facts.label().unwrap_or_default();
    let by_name = entry.name().to_lowercase().contains("db");
    if is_decibel_label(label) || by_name {
        return decibel_reference(label)
            .map(|(reference, _)| Some(reference))
            .ok_or_else(|| {
                let label = if label.is_empty() { "none" } else { label };
                without_reference(entry, label)
            });
    }
    match values.into_iter().find(|value| *value < 0.0) {
        None => Ok(None),
        Some(value) => Err(Error::bad_data("a magnitude below zero; is it in dB?")
            .field(&entry.path)
            .found(value)
            .expected("a linear magnitude, or dB with its reference in the attribute `unit`")
            .help("save linear values, or complex ones")),
    }
}

impl<'a> Reader<'a> {
    /// The values, with axes in the order of the program that wrote them.
    pub(super) fn array(
        &self,
        source: Source<'a>,
        facts: &FrfFacts<'a>,
        warnings: &mut Vec<Finding>,
    ) -> Result<ComplexArray> {
        let array = match source {
            Source::Complex(entry) | Source::Joined(entry) => {
                ComplexArray::new(entry, self.file.read(entry)?)?
            }
            Source::Parts(first, second) | Source::Polar(first, second) => {
                let a = real_array(first, self.file.read(first)?)?;
                let b = real_array(second, self.file.read(second)?)?;
                if a.shape() != b.shape() {
                    return Err(wrong_type(second, &format!("the shape of {}", first.path)));
                }
                let mut values = ndarray::ArrayD::zeros(a.raw_dim());
                if matches!(source, Source::Polar(..)) {
                    let decibel = decibel(first, facts, a.iter().copied())?;
                    let to_radians = self
                        .phase_unit(second, facts, b.iter().copied(), warnings)?
                        .to_radians();
                    Zip::from(&mut values)
                        .and(&a)
                        .and(&b)
                        .for_each(|value, &m, &phase| {
                            let magnitude =
                                decibel.map_or(m, |reference| reference * 10f64.powf(m / 20.0));
                            *value = Complex64::from_polar(magnitude, phase * to_radians);
                        });
                } else {
                    Zip::from(&mut values)
                        .and(&a)
                        .and(&b)
                        .for_each(|value, &re, &im| *value = Complex64::new(re, im));
                }
                ComplexArray::Double(values)
            }
        };
        Ok(if is_matlab(source.first()) {
            array.reversed_axes()
        } else {
            array
        })
    }

    fn phase_unit(
        &self,
        entry: &Entry,
        facts: &FrfFacts<'a>,
        values: impl Iterator<Item = f64>,
        warnings: &mut Vec<Finding>,
    ) -> Result<PhaseUnit> {
        let in_name = entry.name().split('_').find_map(PhaseUnit::named);
        if let Some(told) = self.options.phase_unit {
            let (stated, place) = match &facts.phase_unit {
                Some(fact) => (PhaseUnit::named(&fact.text), &fact.field),
                None => (in_name, &entry.path),
            };
            if let Some(stated) = stated.filter(|stated| *stated != told) {
                let (stated, told) = (stated.as_str(), told.as_str());
                let words = format!("{place} says {stated}, you say {told}: taken as {told}");
                warnings.push(Finding::note("option-overrules-file", words));
            }
            return Ok(told);
        }
        let ask = |message: &str, found: &str| {
            Error::bad_data(message)
                .field(&entry.path)
                .found(found)
                .expected("deg or rad")
                .help("say it with `phase_unit deg` or `phase_unit rad`, or in an attribute `unit`")
        };
        if let Some(fact) = &facts.phase_unit {
            return PhaseUnit::named(&fact.text).ok_or_else(|| {
                ask("the unit of the phase is not understood", &fact.text).field(&fact.field)
            });
        }
        if let Some(unit) = in_name {
            return Ok(unit);
        }
        let unit = PhaseUnit::by_size(values).ok_or_else(|| {
            ask(
                "the phase has no unit, and its numbers may be degrees or radians",
                "no attribute `unit`",
            )
        })?;
        warnings.push(Finding::caution(
            "phase-in-degrees",
            format!(
                "{}: no attribute `unit`: the phase is taken as degrees",
                entry.path
            ),
        ));
        Ok(unit)
    }

    /// Splits an array whose first row or column holds the frequencies into frequencies, Hz,
    /// and FRFs.
    pub(super) fn split_joined(
        &self,
        entry: &Entry,
        facts: &FrfFacts<'a>,
        array: ComplexArray,
        warnings: &mut Vec<Finding>,
    ) -> Result<(Vec<f64>, ComplexArray)> {
        let ComplexArray::Double(mut values) = array.widened() else {
            return Err(wrong_type(entry, "complex numbers"));
        };
        let axis = joined_axis(&values.view())
            .ok_or_else(|| wrong_type(entry, "frequencies in the first column"))?;
        let mut frequency_hz: Vec<f64> = values
            .index_axis(Axis(axis), 0)
            .iter()
            .map(|value| value.re)
            .collect();
        values.slice_axis_inplace(Axis(axis), (1..).into());
        let label = facts
            .frequency_unit
            .as_ref()
            .map_or("Hz", |fact| &fact.text);
        warnings.push(Finding::note(
            "layout-guessed",
            format!(
                "{}: its first column is taken as the frequency axis, {label}; name others with \
                 `map`",
                entry.path
            ),
        ));
        let to_hz = stated_to_hz(facts)?.unwrap_or(1.0);
        frequency_hz.iter_mut().for_each(|f| *f *= to_hz);
        Ok((frequency_hz, ComplexArray::Double(values)))
    }
}
