//! Units that our own layout states in the attributes `unit` of `/frf` and `/freq`.

use crate::arrays::foreign::factor_to_hz;
use crate::arrays::tree::{Attribute, Entry};
use crate::unit_label::{frf_unit, FrfUnit};
use chladni_frf::{Error, FrfKind, ReferenceUnit, Result};

/// Name of the attribute.
const UNIT: &str = "unit";

/// Label and meaning of the unit of an array of FRFs; `None` where the file states none.
///
/// # Errors
/// A unit that is no motion per force or volt.
pub(super) fn of_frf(entry: &Entry) -> Result<Option<(&str, FrfUnit)>> {
    let Some(label) = label(entry)? else {
        return Ok(None);
    };
    match frf_unit(label) {
        Some(unit) => Ok(Some((label, unit))),
        None => Err(not_understood(entry, label)
            .expected("a motion per force or volt, as m/N, m/s/N, mm/s/N or m/s^2/V")),
    }
}

/// Factor from the numbers of a frequency axis to Hz; 1 where the file states no unit.
///
/// # Errors
/// A unit that is no frequency.
pub(super) fn to_hz(entry: &Entry) -> Result<f64> {
    let Some(label) = label(entry)? else {
        return Ok(1.0);
    };
    factor_to_hz(label)
        .ok_or_else(|| not_understood(entry, label).expected("Hz, kHz, MHz, rad/s or rpm"))
}

/// Kind and unit of the reference, of which the root states some and `unit` states both.
///
/// # Errors
/// Statements that contradict each other.
pub(super) fn agreed(
    unit: Option<(&str, FrfUnit)>,
    kind: Option<FrfKind>,
    reference: Option<ReferenceUnit>,
) -> Result<(Option<FrfKind>, ReferenceUnit)> {
    let Some((label, unit)) = unit else {
        return Ok((kind, reference.unwrap_or_default()));
    };
    unit.check_kind(kind.unwrap_or(unit.kind), label)
        .and_then(|()| unit.check_reference(reference.unwrap_or(unit.reference), label))
        .map_err(|error| error.help("correct the attribute that is wrong, of / or of /frf"))?;
    Ok((Some(unit.kind), unit.reference))
}

/// Texts that state no unit.
const NO_UNIT: [&str; 4] = ["", "-", "1", "none"];

/// The text of the attribute; `None` where there is none or it says that there is no unit.
fn label(entry: &Entry) -> Result<Option<&str>> {
    let mut unread = entry.unread_attributes.iter();
    if let Some((_, why)) = unread.find(|(name, _)| name == UNIT) {
        return Err(not_understood(entry, why).expected("a text"));
    }
    match entry.attribute(UNIT) {
        None => Ok(None),
        Some(Attribute::Text(text) | Attribute::FixedText(text)) => {
            Ok(Some(text.trim()).filter(|text| !NO_UNIT.contains(text)))
        }
        Some(Attribute::Real(number)) => {
            Err(not_understood(entry, &number.to_string()).expected("a text"))
        }
        Some(Attribute::Integer(number)) => {
            Err(not_understood(entry, &number.to_string()).expected("a text"))
        }
    }
}

fn not_understood(entry: &Entry, found: &str) -> Error {
    Error::bad_data("the unit is not understood")
        .field(format!("{UNIT} of {}", entry.path))
        .found(found)
        .help("correct the attribute, or delete it where the numbers are in SI")
}
