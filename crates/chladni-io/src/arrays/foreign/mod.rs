//! FRFs in files of others: by `--map`, else by looking for one complex array with an
//! axis as long as a frequency axis.
//!
//! There is no standard layout. What cannot be decided is an error that lists the
//! candidates; what was decided is said in a warning.

mod choose;

use super::tree::{Entry, Values};
use super::values::{real_array, reals, wrong_type, ComplexArray};
use super::ArrayFile;
use crate::paths::shortened;
use crate::unit_label::{frequency_unit, frf_unit};
use chladni_frf::{
    Direction, Dof, Error, ErrorKind, FrfSet, FrfValues, Geometry, ReferenceUnit, Result, TimeSign,
};
use choose::Source;
use ndarray::{Array1, Array3, Zip};
use num_complex::Complex64;

const RESPONSE_NAMES: [&str; 5] = [
    "response",
    "responses",
    "response_dof",
    "response_node",
    "output",
];
const REFERENCE_NAMES: [&str; 5] = [
    "reference",
    "references",
    "reference_dof",
    "reference_node",
    "input",
];
/// Datasets that an error lists before it only counts.
const DATASETS_LISTED: usize = 20;
/// Keys of `--map`.
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

/// What stands in the file in reverse order, because MATLAB wrote it.
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
    map: &[(String, String)],
    warnings: &mut Vec<String>,
) -> Result<Option<Found>> {
    let reader = Reader { file, entries, map };
    reader.check_map_keys()?;
    let Some((source, freq)) = reader.choose()? else {
        return Ok(None);
    };
    if map.is_empty() {
        warnings.push(format!(
            "took {} as the FRFs and {} as their frequency axis; name others with --map",
            source.describe(),
            describe(freq)
        ));
    }
    reader.frf_set(source, freq, warnings).map(Some)
}

struct Reader<'a> {
    file: &'a dyn ArrayFile,
    entries: &'a [Entry],
    map: &'a [(String, String)],
}

impl<'a> Reader<'a> {
    fn check_map_keys(&self) -> Result<()> {
        match self
            .map
            .iter()
            .find(|(key, _)| !MAP_KEYS.contains(&key.as_str()))
        {
            None => Ok(()),
            Some((key, _)) => Err(Error::new(ErrorKind::Usage, "unknown key in --map")
                .field("--map")
                .found(key)
                .expected(MAP_KEYS.join(", "))),
        }
    }

    /// The dataset that `--map` gives for `key`.
    fn mapped(&self, key: &str) -> Result<Option<&'a Entry>> {
        let Some((_, path)) = self.map.iter().find(|(found, _)| found == key) else {
            return Ok(None);
        };
        let path = format!("/{}", path.trim_matches('/'));
        let entry = self.datasets().find(|entry| entry.path == path);
        entry.map(Some).ok_or_else(|| {
            let known: Vec<String> = self.datasets().map(|entry| entry.path.clone()).collect();
            let error = Error::bad_data("no such dataset")
                .field(format!("--map {key}"))
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
        warnings: &mut Vec<String>,
    ) -> Result<Found> {
        let frequency_hz = Array1::from(self.frequency_hz(freq, warnings)?);
        let shape = logical_shape(source.first());
        let [response, reference, line] = self.axes(source, &shape, frequency_hz.len())?;
        let line = line
            .ok_or_else(|| Error::new(ErrorKind::Internal, "the axis of the lines is not known"))?;
        let mut values = self
            .array(source)?
            .into_frf_values(response, reference, line);
        if shape.len() == 3 && line != 2 {
            warnings.push(format!(
                "{}: the other axes are taken in the order response, reference",
                source.first().path
            ));
        }
        let (kind, reference_unit) = self.units(source.first(), &mut values, warnings);
        let (response_count, reference_count, _) = values.dim();
        let frf = source.first();
        let response_entry = self.dof_entry("response", &RESPONSE_NAMES, frf, response_count)?;
        let reference_entry =
            self.dof_entry("reference", &REFERENCE_NAMES, frf, reference_count)?;
        let responses = self.dofs(
            response_entry,
            "response",
            Direction::PLUS_Z,
            response_count,
            warnings,
        )?;
        let references = self.dofs(
            reference_entry,
            "reference",
            Direction::SCALAR,
            reference_count,
            warnings,
        )?;
        let coherence = self.coherence_entry(frf);
        let set = FrfSet {
            frequency_hz,
            values,
            responses,
            references,
            kind,
            reference_unit,
            coherence: coherence
                .map(|entry| self.coherence(entry, [response, reference, Some(line)]))
                .transpose()?,
            variance: None,
            estimation: None,
            geometry: Geometry::default(),
        };
        let time_sign = self
            .text_near(frf, "time_sign")
            .and_then(|sign| sign.parse().ok());
        let used = source
            .datasets()
            .chain([freq])
            .chain(response_entry)
            .chain(reference_entry)
            .chain(coherence)
            .map(|entry| entry.path.clone());
        Ok(Found {
            set: set.checked()?,
            time_sign,
            used: used.collect(),
        })
    }

    fn frequency_hz(&self, freq: &Entry, warnings: &mut Vec<String>) -> Result<Vec<f64>> {
        let mut values = reals(freq, self.file.read(freq)?)?;
        if let Some(unit) = freq.text("unit").or(freq.text("units")) {
            match frequency_unit(unit) {
                Some(to_hz) => values.iter_mut().for_each(|f| *f *= to_hz),
                None => warnings.push(format!(
                    "{}: unit `{unit}` is no frequency; taken as Hz",
                    freq.path
                )),
            }
        }
        Ok(values)
    }

    /// Axes of response, reference and line in the logical shape.
    fn axes(
        &self,
        source: Source<'_>,
        shape: &[usize],
        lines: usize,
    ) -> Result<[Option<usize>; 3]> {
        if shape.len() > 3 {
            return Err(wrong_type(
                source.first(),
                "at most three axes: response, reference, line",
            )
            .found(format!("shape {shape:?}")));
        }
        if let Some((_, text)) = self.map.iter().find(|(key, _)| key == "axes") {
            return named_axes(text, shape, lines);
        }
        let candidates: Vec<usize> = (0..shape.len())
            .filter(|&axis| shape[axis] == lines)
            .collect();
        let &[line] = candidates.as_slice() else {
            return Err(Error::bad_data(format!(
                "{} axes are as long as the frequency axis \
                                                ({lines})",
                candidates.len()
            ))
            .field(&source.first().path)
            .found(format!("shape {shape:?}"))
            .expected("one axis")
            .help(
                "name the axes in order, like --map \
                       frf=PATH,freq=PATH,axes=response-reference-line",
            ));
        };
        let mut others = (0..shape.len()).filter(|&axis| axis != line);
        Ok([others.next(), others.next(), Some(line)])
    }

    fn array(&self, source: Source<'_>) -> Result<ComplexArray> {
        let array = match source {
            Source::Complex(entry) => ComplexArray::new(entry, self.file.read(entry)?)?,
            Source::Parts(first, second) | Source::Polar(first, second) => {
                let mut a = real_array(first, self.file.read(first)?)?;
                let b = real_array(second, self.file.read(second)?)?;
                if a.shape() != b.shape() {
                    return Err(wrong_type(second, &format!("the shape of {}", first.path)));
                }
                let to_radians = if matches!(second.text("unit"), Some(unit) if unit.trim().starts_with("rad"))
                {
                    1.0
                } else {
                    1f64.to_radians()
                };
                let mut values = ndarray::ArrayD::zeros(a.raw_dim());
                Zip::from(&mut values)
                    .and(&mut a)
                    .and(&b)
                    .for_each(|value, &mut a, &b| {
                        *value = match source {
                            Source::Polar(..) => Complex64::from_polar(a, b * to_radians),
                            _ => Complex64::new(a, b),
                        }
                    });
                ComplexArray::Double(values)
            }
        };
        Ok(if is_matlab(source.first()) {
            array.reversed_axes()
        } else {
            array
        })
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
        entry: &'a Entry,
        values: &mut FrfValues,
        warnings: &mut Vec<String>,
    ) -> (Option<chladni_frf::FrfKind>, ReferenceUnit) {
        let said = self
            .text_near(entry, "frf_kind")
            .and_then(|kind| kind.parse().ok());
        let Some(label) = entry.text("unit").or(entry.text("units")) else {
            warnings.push(format!(
                "{}: no attribute `unit`; values are taken as SI",
                entry.path
            ));
            return (said, ReferenceUnit::Newton);
        };
        let Some(unit) = frf_unit(label) else {
            warnings.push(format!(
                "{}: unit `{label}` is no motion per force or volt; values are taken as SI",
                entry.path
            ));
            return (said, ReferenceUnit::Newton);
        };
        scale(values, unit.to_si);
        (said.or(Some(unit.kind)), unit.reference)
    }

    /// The dataset of DOFs: the mapped one, else one of that name and length beside the
    /// FRFs.
    fn dof_entry(
        &self,
        key: &str,
        names: &[&str],
        frf: &Entry,
        count: usize,
    ) -> Result<Option<&'a Entry>> {
        let beside = |entry: &&Entry| {
            entry.folder() == frf.folder()
                && names
                    .iter()
                    .any(|name| entry.name().eq_ignore_ascii_case(name))
        };
        let mapped = self.mapped(key)?;
        Ok(mapped.or_else(|| {
            self.datasets()
                .filter(beside)
                .find(|entry| length(entry) == count)
        }))
    }

    /// DOFs of a dataset, else numbered by position; `direction` where nothing says it.
    fn dofs(
        &self,
        entry: Option<&Entry>,
        key: &str,
        direction: Direction,
        count: usize,
        warnings: &mut Vec<String>,
    ) -> Result<Vec<Dof>> {
        let Some(entry) = entry else {
            let named = if count == 1 {
                format!("1:{direction}")
            } else {
                format!("1:{direction} ... {count}:{direction}")
            };
            warnings.push(format!(
                "the file names no {key} DOFs; they are numbered {named}"
            ));
            return Ok((1..=count as u64)
                .map(|node| Dof::new(node, direction))
                .collect());
        };
        let dofs: Vec<Dof> = match self.file.read(entry)? {
            Values::Dofs(dofs) => dofs,
            Values::Unsigned(nodes) => {
                warnings.push(format!(
                    "{}: node numbers without a direction; {direction} is assumed",
                    entry.path
                ));
                nodes
                    .iter()
                    .map(|&node| Dof::new(node, direction))
                    .collect()
            }
            Values::Text(texts) => texts
                .iter()
                .map(|text| {
                    text.parse().map_err(|message: String| {
                        Error::bad_word(&message, text).field(&entry.path)
                    })
                })
                .collect::<Result<_>>()?,
            _ => {
                return Err(wrong_type(
                    entry,
                    "DOF texts like 12:+Z, node numbers or records {node, dir}",
                ))
            }
        };
        if dofs.len() != count {
            return Err(Error::bad_data("sizes disagree")
                .field(&entry.path)
                .found(dofs.len())
                .expected(format!("{count}, as long as the {key} axis of the FRFs")));
        }
        Ok(dofs)
    }
}

fn length(entry: &Entry) -> usize {
    entry.shape().iter().product()
}

/// `response-reference-line` in any order, two or three words.
fn named_axes(text: &str, shape: &[usize], lines: usize) -> Result<[Option<usize>; 3]> {
    let words: Vec<&str> = text.split(['-', ':', '/', ' ']).collect();
    let find = |name: &str| {
        words
            .iter()
            .position(|word| word.trim_end_matches('s') == name)
    };
    let axes = [find("response"), find("reference"), find("line")];
    let complete = words.len() == shape.len() && axes.iter().flatten().count() == words.len();
    if complete && axes[2].is_some_and(|axis| shape[axis] == lines) {
        return Ok(axes);
    }
    Err(Error::new(ErrorKind::Usage, "the axes do not fit")
        .field("--map axes")
        .found(format!("{text} for shape {shape:?}"))
        .expected(format!(
            "one of response, reference, line for each axis, joined by '-', with {lines} lines"
        )))
}

fn scale(values: &mut FrfValues, factor: f64) {
    if factor != 1.0 {
        match values {
            FrfValues::F64(values) => values.mapv_inplace(|value| value * factor),
            FrfValues::F32(values) => values.mapv_inplace(|value| value * factor as f32),
        }
    }
}
