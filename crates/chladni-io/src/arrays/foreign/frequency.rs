//! The frequency axis of a foreign file: its names, its unit, its order.

use super::super::tree::Entry;
use super::super::values::reals;
use super::facts::{attribute, FrfFacts};
use super::Reader;
use crate::limits::SAME_UNIT;
use crate::unit_label::frequency_unit;
use chladni_frf::{Error, Finding, Result};

/// Names of a frequency axis.
const NAMES: [&str; 10] = [
    "f",
    "freq",
    "frequency",
    "frequencies",
    "freqs",
    "f_axis",
    "faxis",
    "freq_hz",
    "frequency_hz",
    "x",
];
/// Words for a frequency that may be in rad/s as well as in Hz.
const ANGULAR: [&str; 5] = ["w", "omega", "ω", "angular", "circular"];

/// True for a name of a frequency axis.
pub(super) fn is_name(name: &str) -> bool {
    NAMES.iter().any(|known| name.eq_ignore_ascii_case(known))
}

/// True for a less usual name of a frequency axis: `omega`, `f_kHz`.
pub(super) fn is_likely_name(name: &str) -> bool {
    let stem = name.split('_').next().unwrap_or_default();
    is_angular(name) || (is_name(stem) && unit_in_name(name).is_some())
}

fn is_angular(name: &str) -> bool {
    name.split(|c: char| !c.is_alphanumeric())
        .any(|word| ANGULAR.contains(&word.to_lowercase().as_str()))
}

/// Factor to Hz of a label in any case. `MHZ` is not understood: it may be milli or mega.
pub(crate) fn factor_of(label: &str) -> Option<f64> {
    frequency_unit(label).or_else(|| frequency_unit(&label.to_lowercase()))
}

/// Factor to Hz by the end of a name: `f_kHz`, `omega_rad_s`.
fn unit_in_name(name: &str) -> Option<f64> {
    name.match_indices('_').find_map(|(at, _)| {
        let label = name[at + 1..].replace("_per_", "/");
        factor_of(&label.replace('_', "/"))
    })
}

impl<'a> Reader<'a> {
    /// Frequencies of the axis, Hz.
    pub(super) fn frequency_hz(
        &self,
        freq: &'a Entry,
        facts: &FrfFacts<'a>,
        warnings: &mut Vec<Finding>,
    ) -> Result<Vec<f64>> {
        let mut values = reals(freq, self.file.read(freq)?)?;
        refuse_disorder(freq, &values)?;
        let to_hz = axis_to_hz(freq, facts, warnings)?;
        values.iter_mut().for_each(|f| *f *= to_hz);
        Ok(values)
    }
}

/// Factor to Hz of an axis in a dataset of its own. All places that state a unit must agree.
fn axis_to_hz(freq: &Entry, facts: &FrfFacts<'_>, warnings: &mut Vec<Finding>) -> Result<f64> {
    let own = attribute(freq, &["unit"]);
    let by_own = own.as_ref().and_then(|fact| factor_of(&fact.text));
    let by_name = unit_in_name(freq.name());
    let stated = stated_to_hz(facts)?;
    let factors = [by_own, by_name, stated];
    let Some(to_hz) = factors.into_iter().flatten().next() else {
        let label = own.map(|fact| fact.text);
        if is_angular(freq.name()) {
            return Err(
                Error::bad_data("the unit of the frequency axis is not known")
                    .field(&freq.path)
                    .found(label.unwrap_or_else(|| "no unit".into()))
                    .expected(
                        "rad/s or Hz, in an attribute `unit` or a text `frequency_unit` beside it",
                    )
                    .help("write the unit into the file, or save the axis in Hz as `freq`"),
            );
        }
        warnings.extend(label.map(|label| {
            let words = format!("{}: unit `{label}` is no frequency; taken as Hz", freq.path);
            Finding::caution("unit-assumed", words)
        }));
        return Ok(1.0);
    };
    let is_same = |factor: f64| (factor / to_hz - 1.0).abs() <= SAME_UNIT;
    if factors.into_iter().flatten().all(is_same) {
        return Ok(to_hz);
    }
    let places = [
        own.filter(|_| by_own.is_some())
            .map(|fact| format!("`{}` in {}", fact.text, fact.field)),
        by_name.map(|_| format!("the name {}", freq.path)),
        (facts.frequency_unit.as_ref()).map(|fact| format!("`{}` in {}", fact.text, fact.field)),
    ];
    let found: Vec<String> = places.into_iter().flatten().collect();
    Err(Error::bad_data("two units of the frequency")
        .field(&freq.path)
        .found(found.join(", "))
        .expected("one unit")
        .help("correct the one that is wrong"))
}

/// Factor to Hz by the unit that the file states for all frequencies.
///
/// # Errors
/// A label that is no unit of a frequency.
pub(super) fn stated_to_hz(facts: &FrfFacts<'_>) -> Result<Option<f64>> {
    let factor = |fact: &super::facts::Fact<'_>| {
        factor_of(&fact.text).ok_or_else(|| {
            fact.not_understood("no unit of a frequency; write Hz, kHz, rad/s or 1/min")
        })
    };
    facts.frequency_unit.as_ref().map(factor).transpose()
}

fn refuse_disorder(freq: &Entry, values: &[f64]) -> Result<()> {
    let Some(pair) = values.windows(2).find(|pair| pair[1] <= pair[0]) else {
        return Ok(());
    };
    let what = if pair[1] == pair[0] {
        "a frequency occurs twice"
    } else {
        "the frequency axis falls"
    };
    Err(Error::bad_data(what)
        .field(&freq.path)
        .found(format!("{} after {}", pair[1], pair[0]))
        .expected("strictly rising frequencies")
        .help("sort the frequencies, and the FRFs with them; remove doubled lines"))
}
