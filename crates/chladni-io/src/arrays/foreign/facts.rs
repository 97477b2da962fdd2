//! Facts that a foreign file states in words: attributes of an array and of the groups
//! around it, and texts beside it or further up.

use super::super::tree::{Attribute, Element, Entry, Values};
use super::super::values::reals;
use super::choose::Source;
use super::frequency::factor_of;
use super::{is_characters, length, Reader};
use crate::unit_label::{parse, Unit};
use chladni_frf::{Error, FrfKind, ReferenceUnit, Result, TimeSign};
use std::str::FromStr;

const UNIT: [&str; 2] = ["unit", "frf_unit"];
const FREQUENCY_UNIT: [&str; 2] = ["frequency_unit", "freq_unit"];
/// Names of arrays that may be the frequency axis, or positions (`x`) and forces (`f`); each
/// with the name of the text that states its unit.
const MAYBE_FREQUENCY_UNIT: [(&str, &str); 2] = [("x", "x_unit"), ("f", "f_unit")];
const PHASE_UNIT: [&str; 2] = ["phase_unit", "angle_unit"];

/// A fact in words, and the field that states it.
pub(super) struct Fact<'a> {
    pub(super) text: String,
    pub(super) field: String,
    /// The dataset that states it; `None` for an attribute.
    dataset: Option<&'a Entry>,
}

impl<'a> Fact<'a> {
    /// `None` for a blank text.
    fn new(text: &str, field: String, dataset: Option<&'a Entry>) -> Option<Self> {
        let text = text.trim().to_owned();
        (!text.is_empty()).then_some(Self {
            text,
            field,
            dataset,
        })
    }

    /// The fact as a word of `T`, in any case.
    fn word<T: FromStr<Err = String>>(&self) -> Result<T> {
        let word = self.text.to_lowercase().parse();
        word.map_err(|message: String| self.not_understood(&message))
    }

    /// The error of a fact that is not understood.
    pub(super) fn not_understood(&self, message: &str) -> Error {
        Error::bad_word(message, &self.text)
            .field(&self.field)
            .help("correct it in the file, or leave it out")
    }
}

/// The facts that a file states about its FRFs.
pub(super) struct FrfFacts<'a> {
    pub(super) kind: Option<FrfKind>,
    pub(super) reference_unit: Option<ReferenceUnit>,
    pub(super) time_sign: Option<TimeSign>,
    pub(super) unit: Option<Fact<'a>>,
    pub(super) frequency_unit: Option<Fact<'a>>,
    pub(super) phase_unit: Option<Fact<'a>>,
    pub(super) axes: Option<Fact<'a>>,
    /// Datasets that state a fact.
    pub(super) used: Vec<&'a Entry>,
}

impl FrfFacts<'_> {
    /// The label of the values' unit.
    pub(super) fn label(&self) -> Option<&str> {
        self.unit.as_ref().map(|fact| fact.text.as_str())
    }
}

/// A name in lower case with `_` between its words.
fn key_of(name: &str) -> String {
    name.trim().to_lowercase().replace([' ', '-'], "_")
}

/// True for one of `names` or its plural.
fn is_one_of(name: &str, names: &[&str]) -> bool {
    let key = key_of(name);
    names.contains(&key.as_str())
        || key
            .strip_suffix('s')
            .is_some_and(|key| names.contains(&key))
}

/// The attribute of `entry` under one of `names`.
pub(super) fn attribute<'a>(entry: &Entry, names: &[&str]) -> Option<Fact<'a>> {
    entry
        .attributes
        .iter()
        .filter(|(name, _)| is_one_of(name, names))
        .find_map(|(name, value)| {
            let field = format!("{name} of {}", entry.path);
            match value {
                Attribute::Text(text) | Attribute::FixedText(text) => Fact::new(text, field, None),
                Attribute::Real(value) => Fact::new(&value.to_string(), field, None),
                Attribute::Integer(value) => Fact::new(&value.to_string(), field, None),
            }
        })
}

impl<'a> Reader<'a> {
    /// Every fact about the FRFs.
    ///
    /// # Errors
    /// A word that is not understood.
    pub(super) fn facts(&self, source: Source<'a>, freq: &'a Entry) -> Result<FrfFacts<'a>> {
        let frf = source.first();
        let own = |entry: &Entry| format!("{}_unit", key_of(entry.name()));
        let (own_unit, mut own_frequency_unit) = (own(frf), own(freq));
        if matches!(source, Source::Joined(_)) {
            own_frequency_unit.clear(); // here it is the unit of the FRFs
        }
        let phase = match source {
            Source::Polar(_, phase) => Some((phase, own(phase))),
            _ => None,
        };
        let frequency_names = [&[own_frequency_unit.as_str()], &FREQUENCY_UNIT[..]].concat();
        let kind = self.near(frf, &["frf_kind"])?;
        let sign = self.near(frf, &["time_sign"])?;
        let reference = self.near(frf, &["reference_unit"])?;
        let unit = self.near(frf, &[&[own_unit.as_str()], &UNIT[..]].concat())?;
        let mut frequency_unit = self.near(freq, &frequency_names)?;
        if frequency_unit.is_none() {
            frequency_unit = self.near(frf, &frequency_names)?;
        }
        let is_axis = |name: &str| key_of(freq.name()) == name;
        for (own, name) in MAYBE_FREQUENCY_UNIT {
            let of_another = self.datasets().any(|entry| key_of(entry.name()) == own);
            if frequency_unit.is_none() && (is_axis(own) || !of_another) {
                let is_frequency = |fact: &Fact<'_>| factor_of(&fact.text).is_some();
                frequency_unit = self.near(freq, &[name])?.filter(is_frequency);
            }
        }
        let phase_unit = match &phase {
            None => None,
            Some((phase, name)) => match attribute(phase, &["unit"]) {
                None => self.near(phase, &[&[name.as_str()], &PHASE_UNIT[..]].concat())?,
                found => found,
            },
        };
        let axes = self.near(frf, &["axes"])?;
        let facts = [
            &kind,
            &sign,
            &reference,
            &unit,
            &frequency_unit,
            &phase_unit,
            &axes,
        ];
        Ok(FrfFacts {
            used: (facts.into_iter().flatten())
                .filter_map(|fact| fact.dataset)
                .collect(),
            kind: kind.map_or(Ok(None), |fact| self.kind(&fact))?,
            time_sign: sign.map_or(Ok(None), |fact| self.time_sign(&fact))?,
            reference_unit: reference.map(|fact| reference_unit(&fact)).transpose()?,
            unit,
            frequency_unit,
            phase_unit,
            axes,
        })
    }

    /// The kind that the file states. A word that is not understood is an error only where
    /// the caller gives no kind.
    fn kind(&self, fact: &Fact<'_>) -> Result<Option<FrfKind>> {
        match (fact.word(), self.options.frf_kind) {
            (Ok(kind), _) => Ok(Some(kind)),
            (Err(_), Some(_)) => Ok(None),
            (Err(error), None) => Err(error.help("correct it, or say the kind with `frf_kind`")),
        }
    }

    /// The time sign that the file states. A word that is not understood is an error only
    /// where the caller does not give minus.
    fn time_sign(&self, fact: &Fact<'_>) -> Result<Option<TimeSign>> {
        let sign = match fact.text.to_lowercase().as_str() {
            "1" | "+1" | "plus" => Ok(TimeSign::Plus),
            "-1" | "minus" => Ok(TimeSign::Minus),
            _ => fact.word(),
        };
        match (sign, self.options.time_sign) {
            (Ok(sign), _) => Ok(Some(sign)),
            (Err(_), TimeSign::Minus) => Ok(None),
            (Err(error), TimeSign::Plus) => {
                Err(error.help("correct it, or say minus with `time_sign`"))
            }
        }
    }

    /// The nearest fact under one of `names`: an attribute of `entry`, else an attribute of
    /// its group or a text in it, else of the groups around.
    fn near(&self, entry: &'a Entry, names: &[&str]) -> Result<Option<Fact<'a>>> {
        let mut fact = attribute(entry, names);
        for group in entry.groups() {
            if fact.is_some() {
                break;
            }
            let is_here = |entry: &&Entry| entry.dataset.is_none() && entry.path == group;
            let here = self.entries.iter().find(is_here);
            fact = here.and_then(|here| attribute(here, names));
            let is_beside = |text: &&Entry| text.folder() == group && is_one_of(text.name(), names);
            for text in self.datasets().filter(is_beside) {
                if fact.is_none() {
                    fact = self.statement(text)?;
                }
            }
        }
        Ok(fact)
    }

    /// The fact that a dataset of texts or of a single number states.
    fn statement(&self, entry: &'a Entry) -> Result<Option<Fact<'a>>> {
        let text = match entry.element() {
            _ if is_characters(entry) => self.texts(entry)?,
            Some(Element::Text) => self.texts(entry)?,
            Some(Element::Real { .. } | Element::Integer) if length(entry) == 1 => {
                let numbers = reals(entry, self.file.read(entry)?)?;
                numbers.iter().map(f64::to_string).collect()
            }
            _ => return Ok(None),
        };
        let path = entry.path.clone();
        Ok(Fact::new(&Attribute::joined(&text), path, Some(entry)))
    }

    /// Texts of a dataset. MATLAB 7.3 stores the codes of their characters, one row for each
    /// text.
    pub(super) fn texts(&self, entry: &Entry) -> Result<Vec<String>> {
        match self.file.read(entry)? {
            Values::Unsigned(codes) if is_characters(entry) => {
                let rows = length(entry).min(codes.len());
                let row = |row: usize| -> String {
                    let units: Vec<u16> = (codes.iter().skip(row).step_by(rows.max(1)))
                        .map(|&code| u16::try_from(code).unwrap_or(0xfffd))
                        .collect();
                    let text = String::from_utf16_lossy(&units);
                    text.trim_end_matches(['\0', ' ']).to_owned()
                };
                Ok((0..rows).map(row).collect())
            }
            values => super::super::values::texts(entry, values),
        }
    }
}

fn reference_unit(fact: &Fact<'_>) -> Result<ReferenceUnit> {
    let word = fact.text.to_lowercase();
    let singular = word.strip_suffix('s').unwrap_or(&word);
    let unit = parse(&fact.text)
        .or_else(|| parse(singular))
        .or_else(|| parse(&word.to_uppercase()));
    unit.and_then(Unit::reference)
        .ok_or_else(|| fact.not_understood("unknown unit of the reference; write N or V"))
}
