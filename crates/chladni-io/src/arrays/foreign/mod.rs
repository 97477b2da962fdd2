//! FRFs in files of other programs: by the caller's map, else by a search for one complex
//! array with an axis as long as a frequency axis.
//!
//! There is no standard layout. Where several datasets may be meant, the error lists them;
//! where the search has chosen, a warning names its choice.

mod axes;
mod choose;
mod dofs;
mod facts;
mod frequency;
mod parts;

use super::tree::{Element, Entry};
use super::values::{checked, real_array, wrong_type, ComplexArray};
use super::ArrayFile;
use crate::limits::DATASETS_LISTED;
use crate::paths::shortened;
use crate::time_sign::to_plus;
use crate::unit_label::frf_unit;
use crate::{Document, ReadOptions};
use axes::Lengths;
use chladni_frf::{
    Error, ErrorKind, Finding, FrfKind, FrfSet, FrfValues, Geometry, ReferenceUnit, Result,
    TimeSign,
};
use choose::Source;
use dofs::{REFERENCE, RESPONSE};
use facts::FrfFacts;
pub(crate) use frequency::factor_of as factor_to_hz;
use ndarray::Array3;
use num_complex::{Complex64, ComplexFloat};
use std::fmt::Display;

/// Keys of the caller's map.
const MAP_KEYS: [&str; 9] = [
    "frf",
    "re",
    "im",
    "mag",
    "phase",
    "freq",
    "response",
    "reference",
    "axes",
];

/// Path and shape of a dataset: `/data/H (77 x 1 x 801)`.
pub(crate) fn describe(entry: &Entry) -> String {
    let extents: Vec<String> = logical_shape(entry).iter().map(usize::to_string).collect();
    format!("{} ({})", entry.path, extents.join(" x "))
}

/// True for a dataset whose axes are in reverse order, because MATLAB wrote it.
fn is_matlab(entry: &Entry) -> bool {
    entry.attribute("MATLAB_class").is_some()
}

/// True for texts of MATLAB 7.3, which are stored as numbers.
fn is_characters(entry: &Entry) -> bool {
    entry.text("MATLAB_class") == Some("char") && entry.element() == Some(&Element::Integer)
}

/// Extents in the order of the program that wrote them.
fn logical_shape(entry: &Entry) -> Vec<usize> {
    let mut shape = entry.shape().to_vec();
    if is_matlab(entry) {
        shape.reverse();
    }
    shape
}

/// The FRFs of a file, in its own time sign.
pub(crate) struct FoundFrf {
    pub(crate) set: FrfSet,
    /// Time sign that the file states.
    pub(crate) time_sign: Option<TimeSign>,
    /// Paths of the datasets that the set is made of.
    pub(crate) used: Vec<String>,
}

/// Puts the outcome of looking for FRFs into `document`, in the time sign e^{+jωt}; damaged
/// data go to its `errors`.
///
/// # Errors
/// Those of `outcome` that are not about the data, such as an unknown key of the map.
pub(crate) fn take_frf(
    document: &mut Document,
    outcome: Result<Option<FoundFrf>>,
    options: &ReadOptions,
) -> Result<()> {
    match outcome.map_err(|error| error.file(&document.file)) {
        Ok(None) => {}
        Ok(Some(mut found)) => {
            for info in &mut document.datasets {
                info.left_behind &= !found.used.contains(&info.name);
            }
            to_plus(
                &mut found.set,
                found.time_sign,
                options.time_sign,
                &mut document.warnings,
            );
            document.frf = Some(found.set);
        }
        Err(error) if error.kind == ErrorKind::BadData => document.errors.push(error),
        Err(error) => return Err(error),
    }
    Ok(())
}

/// Reads the FRFs of a foreign file; `None` where nothing in it looks like FRFs.
pub(crate) fn read_foreign(
    file: &dyn ArrayFile,
    entries: &[Entry],
    options: &ReadOptions,
    warnings: &mut Vec<Finding>,
) -> Result<Option<FoundFrf>> {
    let map = &options.map;
    let reader = Reader {
        file,
        entries,
        map,
        options,
    };
    reader.check_map_keys()?;
    let Some((source, freq)) = reader.choose(warnings)? else {
        return Ok(None);
    };
    if map.is_empty() {
        warnings.push(Finding::note(
            "layout-guessed",
            format!(
                "took {} as the FRFs and {} as their frequency axis; name others with `map`",
                source.describe(),
                describe(freq)
            ),
        ));
    }
    reader.frf_set(source, freq, warnings).map(Some)
}

struct Reader<'a> {
    file: &'a dyn ArrayFile,
    entries: &'a [Entry],
    map: &'a [(String, String)],
    options: &'a ReadOptions,
}

impl<'a> Reader<'a> {
    fn check_map_keys(&self) -> Result<()> {
        match self
            .map
            .iter()
            .find(|(key, _)| !MAP_KEYS.contains(&key.as_str()))
        {
            None => Ok(()),
            Some((key, _)) => Err(Error::new(ErrorKind::Usage, "unknown key in `map`")
                .field("map")
                .found(key)
                .expected(MAP_KEYS.join(", "))
                .help("write pairs of key and path: `map frf=PATH,freq=PATH`")),
        }
    }

    /// The dataset that the caller's map gives for `key`.
    fn mapped(&self, key: &str) -> Result<Option<&'a Entry>> {
        let Some((_, path)) = self.map.iter().find(|(found, _)| found == key) else {
            return Ok(None);
        };
        let path = format!("/{}", path.trim_matches('/'));
        let entry = self.datasets().find(|entry| entry.path == path);
        entry.map(Some).ok_or_else(|| {
            let known: Vec<String> = self.datasets().map(|entry| entry.path.clone()).collect();
            let error = Error::bad_data("no such dataset")
                .field(format!("map {key}"))
                .found(&path);
            error.expected("the path of a dataset").help(format!(
                "the file has {}",
                shortened(&known, DATASETS_LISTED)
            ))
        })
    }

    fn datasets(&self) -> impl Iterator<Item = &'a Entry> {
        self.entries.iter().filter(|entry| entry.dataset.is_some())
    }

    fn frf_set(
        &self,
        source: Source<'a>,
        freq: &'a Entry,
        warnings: &mut Vec<Finding>,
    ) -> Result<FoundFrf> {
        let facts = self.facts(source, freq)?;
        let array = self.array(source, &facts, warnings)?;
        let (frequency_hz, array) = match source {
            Source::Joined(_) => self.split_joined(freq, &facts, array, warnings)?,
            _ => (self.frequency_hz(freq, &facts, warnings)?, array),
        };
        let (shape, frf) = (array.shape().to_vec(), source.first());
        let lengths = Lengths {
            response: self.dof_list(&RESPONSE, frf, frequency_hz.len())?,
            reference: self.dof_list(&REFERENCE, frf, frequency_hz.len())?,
            lines: frequency_hz.len(),
        };
        let named = self.axes(frf, &facts, &shape, &lengths)?;
        let [response, reference, line] = named.axes;
        let line = line
            .ok_or_else(|| Error::new(ErrorKind::Internal, "the axis of the lines is not known"))?;
        let mut values = array.into_frf_values(response, reference, line);
        self.refuse_infinities(frf, &values)?;
        // with one reference, the number of responses would show swapped axes
        if shape.len() == 3 && values.dim().1 > 1 && !named.are_named {
            warnings.push(axes_guessed(frf));
        }
        let (kind, reference_unit) = self.units(source, &facts, &mut values, warnings)?;
        let (response_count, reference_count, _) = values.dim();
        let response_entry = self.dof_entry(&RESPONSE, frf, response_count)?;
        let reference_entry = self.dof_entry(&REFERENCE, frf, reference_count)?;
        let responses = self.dofs(&RESPONSE, response_entry, response_count, warnings)?;
        let references = self.dofs(&REFERENCE, reference_entry, reference_count, warnings)?;
        let coherence_entry = self.coherence_entry(frf);
        let coherence = coherence_entry
            .map(|entry| self.coherence(entry, response, reference, line))
            .transpose()?;
        let set = FrfSet {
            frequency_hz: frequency_hz.into(),
            values,
            responses,
            references,
            kind,
            reference_unit,
            coherence,
            variance: None,
            estimation: None,
            geometry: Geometry::default(),
        };
        let used = (source.datasets().chain([freq]))
            .chain(response_entry)
            .chain(reference_entry)
            .chain(coherence_entry)
            .chain(facts.used)
            .map(|entry| entry.path.clone());
        Ok(FoundFrf {
            set: checked(set, &frf.path)?,
            time_sign: facts.time_sign,
            used: used.collect(),
        })
    }

    /// Real numbers named `coherence` beside the FRFs and of their shape.
    fn coherence_entry(&self, frf: &Entry) -> Option<&'a Entry> {
        let fits = |entry: &&Entry| {
            entry.folder() == frf.folder()
                && entry.shape() == frf.shape()
                && is_matlab(entry) == is_matlab(frf)
        };
        let real = |entry: &&Entry| matches!(entry.element(), Some(Element::Real { .. }));
        self.datasets()
            .filter(fits)
            .filter(real)
            .find(|entry| entry.name().eq_ignore_ascii_case("coherence"))
    }

    fn coherence(
        &self,
        entry: &Entry,
        response: Option<usize>,
        reference: Option<usize>,
        line: usize,
    ) -> Result<Array3<f32>> {
        let array = real_array(entry, self.file.read(entry)?)?.mapv(Complex64::from);
        let array = ComplexArray::Double(if is_matlab(entry) {
            array.reversed_axes()
        } else {
            array
        });
        match array.into_frf_values(response, reference, line) {
            FrfValues::F64(values) => Ok(values.mapv(|value| value.re as f32)),
            FrfValues::F32(values) => Ok(values.mapv(|value| value.re)),
        }
    }

    /// Kind and reference unit, as far as the file states them; scales the values to SI.
    fn units(
        &self,
        source: Source<'a>,
        facts: &FrfFacts<'a>,
        values: &mut FrfValues,
        warnings: &mut Vec<Finding>,
    ) -> Result<(Option<FrfKind>, ReferenceUnit)> {
        let entry = source.first();
        let unscaled = (facts.kind, facts.reference_unit.unwrap_or_default());
        let Some(label) = facts.label() else {
            warnings.push(Finding::caution(
                "unit-assumed",
                format!(
                    "{}: no attribute `unit`; values are taken as SI",
                    entry.path
                ),
            ));
            return Ok(unscaled);
        };
        let label = parts::linear_label(source, label)?;
        let Some(unit) = frf_unit(label) else {
            warnings.push(Finding::caution(
                "unit-assumed",
                format!(
                    "{}: unit `{label}` is no motion per force or volt; values are taken as SI",
                    entry.path
                ),
            ));
            return Ok(unscaled);
        };
        if let (Some(kind), None) = (facts.kind, self.options.frf_kind) {
            unit.check_kind(kind, label)?;
        }
        if let Some(reference) = facts.reference_unit {
            unit.check_reference(reference, label)?;
        }
        scale(values, unit.to_si);
        Ok((facts.kind.or(Some(unit.kind)), unit.reference))
    }

    /// Refuses infinite values, unless `lenient`.
    fn refuse_infinities(&self, frf: &Entry, values: &FrfValues) -> Result<()> {
        fn first_infinite<C: ComplexFloat + Display>(
            values: &Array3<C>,
        ) -> Option<((usize, usize, usize), String)> {
            let mut values = values.indexed_iter();
            let found = values.find(|(_, v)| v.re().is_infinite() || v.im().is_infinite());
            found.map(|(at, value)| (at, value.to_string()))
        }
        let found = match values {
            FrfValues::F64(values) => first_infinite(values),
            FrfValues::F32(values) => first_infinite(values),
        };
        match found.filter(|_| !self.options.lenient) {
            None => Ok(()),
            Some(((i, j, k), value)) => Err(Error::bad_data("an infinite value")
                .field(&frf.path)
                .found(format!(
                    "{value} at response {}, reference {}, line {}",
                    i + 1,
                    j + 1,
                    k + 1
                ))
                .expected("finite numbers, or NaN where nothing was measured")
                .help("export the data again, or read the file with `lenient`, which masks it")),
        }
    }
}

fn axes_guessed(frf: &Entry) -> Finding {
    let words = format!(
        "{}: the other axes are taken in the order response, reference",
        frf.path
    );
    Finding::note("layout-guessed", words)
}

/// Number of values, or of texts.
fn length(entry: &Entry) -> usize {
    let shape = entry.shape();
    if is_characters(entry) {
        return shape.last().copied().unwrap_or(1);
    }
    shape.iter().product()
}

/// Multiplies all values by a factor to SI.
pub(crate) fn scale(values: &mut FrfValues, factor: f64) {
    if factor != 1.0 {
        match values {
            FrfValues::F64(values) => values.mapv_inplace(|value| value * factor),
            FrfValues::F32(values) => values.mapv_inplace(|value| value * factor as f32),
        }
    }
}
