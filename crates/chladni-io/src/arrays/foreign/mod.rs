//! FRFs in files of others: by the caller's map, else by looking for one complex array
//! with an axis as long as a frequency axis.
//!
//! There is no standard layout. What cannot be decided is an error that lists the
//! candidates; what was decided is said in a warning.

mod axes;
mod choose;
mod dofs;
mod parts;

use super::tree::Entry;
use super::values::{real_array, reals, wrong_type, ComplexArray};
use super::ArrayFile;
use crate::limits::DATASETS_LISTED;
use crate::paths::shortened;
use crate::unit_label::{frequency_unit, frf_unit};
use crate::ReadOptions;
use axes::Lengths;
use chladni_frf::{
    Error, ErrorKind, Finding, FrfSet, FrfValues, Geometry, ReferenceUnit, Result, TimeSign,
};
use choose::Source;
use dofs::{REFERENCE, RESPONSE};
use ndarray::Array3;
use num_complex::Complex64;

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

/// `/data/H (77 x 1 x 801)`.
pub(crate) fn describe(entry: &Entry) -> String {
    let extents: Vec<String> = logical_shape(entry).iter().map(usize::to_string).collect();
    format!("{} ({})", entry.path, extents.join(" x "))
}

/// True for the names that a frequency axis goes by.
pub(crate) fn is_frequency_name(name: &str) -> bool {
    choose::FREQUENCY_NAMES
        .iter()
        .any(|known| name.eq_ignore_ascii_case(known))
}

/// True for what stands in the file in reverse order, because MATLAB wrote it.
fn is_matlab(entry: &Entry) -> bool {
    entry.attribute("MATLAB_class").is_some()
}

/// Extents in the order of the program that wrote them.
fn logical_shape(entry: &Entry) -> Vec<usize> {
    let mut shape = entry.shape().to_vec();
    if is_matlab(entry) {
        shape.reverse();
    }
    shape
}

/// FRFs as they stand in the file.
pub(crate) struct Found {
    pub(crate) set: FrfSet,
    /// Time sign that the file says.
    pub(crate) time_sign: Option<TimeSign>,
    /// Paths of the datasets that the set is made of.
    pub(crate) used: Vec<String>,
}

/// Reads the FRFs of a foreign file: `None` where nothing in it looks like FRFs.
pub(crate) fn read_foreign(
    file: &dyn ArrayFile,
    entries: &[Entry],
    options: &ReadOptions,
    warnings: &mut Vec<Finding>,
) -> Result<Option<Found>> {
    let map = &options.map;
    let reader = Reader {
        file,
        entries,
        map,
        options,
    };
    reader.check_map_keys()?;
    let Some((source, freq)) = reader.choose()? else {
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
                .expected(MAP_KEYS.join(", "))),
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
    ) -> Result<Found> {
        let array = self.array(source, warnings)?;
        let (frequency_hz, array) = match source {
            Source::Joined(_) => self.split_joined(freq, array, warnings)?,
            _ => (self.frequency_hz(freq, warnings)?, array),
        };
        let (shape, frf) = (array.shape().to_vec(), source.first());
        let lengths = Lengths {
            response: self.dof_list(&RESPONSE, frf)?,
            reference: self.dof_list(&REFERENCE, frf)?,
            lines: frequency_hz.len(),
        };
        let ([response, reference, line], told) = self.axes(source, &shape, &lengths)?;
        let line = line
            .ok_or_else(|| Error::new(ErrorKind::Internal, "the axis of the lines is not known"))?;
        let mut values = array.into_frf_values(response, reference, line);
        self.refuse_infinities(frf, &values)?;
        // with one reference a swap would show in the number of responses
        if shape.len() == 3 && values.dim().1 > 1 && !told {
            warnings.push(axes_guessed(frf));
        }
        let (kind, reference_unit) = self.units(source, &mut values, warnings)?;
        let (response_count, reference_count, _) = values.dim();
        let response_entry = self.dof_entry(&RESPONSE, frf, response_count)?;
        let reference_entry = self.dof_entry(&REFERENCE, frf, reference_count)?;
        let responses = self.dofs(&RESPONSE, response_entry, response_count, warnings)?;
        let references = self.dofs(&REFERENCE, reference_entry, reference_count, warnings)?;
        let coherence_entry = self.coherence_entry(frf);
        let coherence = coherence_entry
            .map(|entry| self.coherence(entry, [response, reference, Some(line)]))
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
            .map(|entry| entry.path.clone());
        Ok(Found {
            set: set.checked()?,
            time_sign: (self.text_near(frf, "time_sign")).and_then(|sign| sign.parse().ok()),
            used: used.collect(),
        })
    }

    fn frequency_hz(&self, freq: &Entry, warnings: &mut Vec<Finding>) -> Result<Vec<f64>> {
        let mut values = reals(freq, self.file.read(freq)?)?;
        if let Some(unit) = unit_of(freq) {
            match frequency_unit(unit) {
                Some(to_hz) => values.iter_mut().for_each(|f| *f *= to_hz),
                None => warnings.push(Finding::caution(
                    "unit-assumed",
                    format!("{}: unit `{unit}` is no frequency; taken as Hz", freq.path),
                )),
            }
        }
        Ok(values)
    }

    /// Real numbers named `coherence` beside the FRFs and of their shape.
    fn coherence_entry(&self, frf: &Entry) -> Option<&'a Entry> {
        let fits = |entry: &&Entry| {
            entry.folder() == frf.folder()
                && entry.shape() == frf.shape()
                && is_matlab(entry) == is_matlab(frf)
        };
        let real =
            |entry: &&Entry| matches!(entry.element(), Some(super::tree::Element::Real { .. }));
        self.datasets()
            .filter(fits)
            .filter(real)
            .find(|entry| entry.name().eq_ignore_ascii_case("coherence"))
    }

    fn coherence(
        &self,
        entry: &Entry,
        [response, reference, line]: [Option<usize>; 3],
    ) -> Result<Array3<f32>> {
        let array = real_array(entry, self.file.read(entry)?)?.mapv(Complex64::from);
        let array = ComplexArray::Double(if is_matlab(entry) {
            array.reversed_axes()
        } else {
            array
        });
        match array.into_frf_values(response, reference, line.unwrap_or_default()) {
            FrfValues::F64(values) => Ok(values.mapv(|value| value.re as f32)),
            FrfValues::F32(values) => Ok(values.mapv(|value| value.re)),
        }
    }

    fn text_near(&self, entry: &'a Entry, name: &str) -> Option<&'a str> {
        let group = self
            .entries
            .iter()
            .find(|group| group.dataset.is_none() && group.path == entry.folder());
        entry
            .text(name)
            .or_else(|| group?.text(name))
            .or_else(|| self.entries.first()?.text(name))
    }

    /// Kind and reference unit, as far as attributes say them; values are scaled to SI.
    fn units(
        &self,
        source: Source<'a>,
        values: &mut FrfValues,
        warnings: &mut Vec<Finding>,
    ) -> Result<(Option<chladni_frf::FrfKind>, ReferenceUnit)> {
        let entry = source.first();
        let said = self
            .text_near(entry, "frf_kind")
            .and_then(|kind| kind.parse().ok());
        let Some(label) = unit_of(entry) else {
            warnings.push(Finding::caution(
                "unit-assumed",
                format!(
                    "{}: no attribute `unit`; values are taken as SI",
                    entry.path
                ),
            ));
            return Ok((said, ReferenceUnit::Newton));
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
            return Ok((said, ReferenceUnit::Newton));
        };
        scale(values, unit.to_si);
        Ok((said.or(Some(unit.kind)), unit.reference))
    }

    /// Infinities are errors, as in every format.
    fn refuse_infinities(&self, frf: &Entry, values: &FrfValues) -> Result<()> {
        let found = match values {
            FrfValues::F64(values) => values
                .indexed_iter()
                .find(|(_, v)| v.re.is_infinite() || v.im.is_infinite())
                .map(|(at, v)| (at, v.to_string())),
            FrfValues::F32(values) => values
                .indexed_iter()
                .find(|(_, v)| v.re.is_infinite() || v.im.is_infinite())
                .map(|(at, v)| (at, v.to_string())),
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

fn length(entry: &Entry) -> usize {
    entry.shape().iter().product()
}

/// The unit that an array carries.
fn unit_of(entry: &Entry) -> Option<&str> {
    entry.text("unit").or(entry.text("units"))
}

fn scale(values: &mut FrfValues, factor: f64) {
    if factor != 1.0 {
        match values {
            FrfValues::F64(values) => values.mapv_inplace(|value| value * factor),
            FrfValues::F32(values) => values.mapv_inplace(|value| value * factor as f32),
        }
    }
}
