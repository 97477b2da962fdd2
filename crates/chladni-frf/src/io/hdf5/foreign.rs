//! FRFs in files of others: by `--map`, else by looking for one complex array with an axis as long as a frequency axis.
//!
//! There is no standard layout. What cannot be decided is an error that lists the candidates; what was decided is said in a
//! warning.

use super::arrays::{real_array, reals, wrong_type, ComplexArray};
use super::backend::File;
use super::tree::{Element, Entry, Values};
use crate::io::unit_label::{frequency_unit, frf_unit};
use crate::{Direction, Dof, Error, ErrorKind, FrfSet, FrfValues, Geometry, ReferenceUnit, Result, TimeSign};
use ndarray::{Array1, Zip};
use num_complex::Complex64;

/// Names that a frequency axis goes by.
const FREQUENCY_NAMES: [&str; 10] = ["f", "freq", "frequency", "frequencies", "freqs", "f_axis", "faxis", "freq_hz", "frequency_hz", "x"];
/// Pairs of real arrays that hold one complex array, and whether they are magnitude and phase.
const PART_NAMES: [(&str, &str, bool); 6] = [
    ("re", "im", false),
    ("real", "imag", false),
    ("mag", "phase", true),
    ("magnitude", "phase", true),
    ("abs", "phase", true),
    ("amplitude", "phase", true),
];
const RESPONSE_NAMES: [&str; 5] = ["response", "responses", "response_dof", "response_node", "output"];
const REFERENCE_NAMES: [&str; 5] = ["reference", "references", "reference_dof", "reference_node", "input"];
/// Keys of `--map`.
const MAP_KEYS: [&str; 9] = ["frf", "re", "im", "mag", "phase", "freq", "response", "reference", "axes"];

/// The values, in one dataset or two.
#[derive(Clone, Copy)]
enum Source<'a> {
    Complex(&'a Entry),
    Parts(&'a Entry, &'a Entry),
    Polar(&'a Entry, &'a Entry),
}

impl<'a> Source<'a> {
    fn first(self) -> &'a Entry {
        match self {
            Self::Complex(entry) | Self::Parts(entry, _) | Self::Polar(entry, _) => entry,
        }
    }
    fn describe(self) -> String {
        match self {
            Self::Complex(entry) => describe(entry),
            Self::Parts(a, b) | Self::Polar(a, b) => format!("{} with {}", describe(a), b.path),
        }
    }
}

/// `/data/H (77 x 1 x 801)`.
pub(super) fn describe(entry: &Entry) -> String {
    let extents: Vec<String> = entry.shape().iter().map(usize::to_string).collect();
    format!("{} ({})", entry.path, extents.join(" x "))
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

/// FRFs as they stand in the file, and the time sign that it says.
type SetAndSign = (FrfSet, Option<TimeSign>);

/// Reads the FRFs of a foreign file: `None` where nothing in it looks like FRFs.
pub(super) fn read_foreign(
    file: &File,
    entries: &[Entry],
    map: &[(String, String)],
    warnings: &mut Vec<String>,
) -> Result<Option<SetAndSign>> {
    let reader = Reader { file, entries, map };
    reader.check_map_keys()?;
    let Some((source, freq)) = reader.choose()? else { return Ok(None) };
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
    file: &'a File,
    entries: &'a [Entry],
    map: &'a [(String, String)],
}

impl<'a> Reader<'a> {
    fn check_map_keys(&self) -> Result<()> {
        match self.map.iter().find(|(key, _)| !MAP_KEYS.contains(&key.as_str())) {
            None => Ok(()),
            Some((key, _)) => {
                Err(Error::new(ErrorKind::Usage, "unknown key in --map").field("--map").found(key).expected(MAP_KEYS.join(", ")))
            }
        }
    }

    /// The dataset that `--map` gives for `key`.
    fn mapped(&self, key: &str) -> Result<Option<&'a Entry>> {
        let Some((_, path)) = self.map.iter().find(|(found, _)| found == key) else { return Ok(None) };
        let path = format!("/{}", path.trim_matches('/'));
        let entry = self.datasets().find(|entry| entry.path == path);
        entry.map(Some).ok_or_else(|| {
            let known: Vec<&str> = self.datasets().map(|entry| entry.path.as_str()).take(20).collect();
            Error::bad_data("no such dataset").field(format!("--map {key}")).found(&path).help(format!("the file has {}", known.join(", ")))
        })
    }

    fn datasets(&self) -> impl Iterator<Item = &'a Entry> {
        self.entries.iter().filter(|entry| entry.dataset.is_some())
    }

    fn choose(&self) -> Result<Option<(Source<'a>, &'a Entry)>> {
        let sources = match self.mapped_source()? {
            Some(source) => vec![source],
            None => self.source_candidates(),
        };
        let axes = match self.mapped("freq")? {
            Some(entry) => vec![entry],
            None => self.frequency_candidates()?,
        };
        let mut pairs: Vec<(Source<'a>, &'a Entry)> = Vec::new();
        for &source in &sources {
            let fitting = axes.iter().filter(|axis| source.first().shape().contains(&length(axis)));
            pairs.extend(fitting.map(|&axis| (source, axis)));
        }
        // a frequency axis beside the array wins over one elsewhere
        let beside: Vec<_> = pairs.iter().filter(|(source, axis)| source.first().folder() == axis.folder()).copied().collect();
        match (pairs.as_slice(), beside.as_slice()) {
            (&[pair], _) => Ok(Some(pair)),
            (_, &[pair]) if sources.len() == 1 => Ok(Some(pair)),
            ([], _) if self.map.is_empty() => Ok(None),
            _ => {
                let list = |entries: Vec<String>| if entries.is_empty() { "none".to_owned() } else { entries.join(", ") };
                Err(Error::bad_data("it is not clear which datasets are the FRFs and their frequency axis").help(format!(
                    "name them with --map frf=PATH,freq=PATH; complex arrays: {}; frequency axes: {}",
                    list(sources.iter().map(|source| source.describe()).collect()),
                    list(axes.iter().map(|axis| describe(axis)).collect()),
                )))
            }
        }
    }

    fn mapped_source(&self) -> Result<Option<Source<'a>>> {
        if let Some(entry) = self.mapped("frf")? {
            return Ok(Some(Source::Complex(entry)));
        }
        match (self.mapped("re")?, self.mapped("im")?, self.mapped("mag")?, self.mapped("phase")?) {
            (None, None, None, None) => Ok(None),
            (Some(re), Some(im), None, None) => Ok(Some(Source::Parts(re, im))),
            (None, None, Some(mag), Some(phase)) => Ok(Some(Source::Polar(mag, phase))),
            _ => Err(Error::new(ErrorKind::Usage, "--map needs frf, or re and im, or mag and phase").field("--map")),
        }
    }

    fn source_candidates(&self) -> Vec<Source<'a>> {
        let of_rank = |entry: &&Entry| (1..=3).contains(&entry.shape().len());
        let complex: Vec<_> = self
            .datasets()
            .filter(|entry| matches!(entry.element(), Some(Element::Complex { .. })))
            .filter(of_rank)
            .map(Source::Complex)
            .collect();
        if !complex.is_empty() {
            return complex;
        }
        let real = |entry: &&Entry| matches!(entry.element(), Some(Element::Real { .. }));
        let named =
            |name: &str, folder: &str| self.datasets().find(|entry| entry.folder() == folder && entry.name().eq_ignore_ascii_case(name));
        let mut parts = Vec::new();
        for first in self.datasets().filter(of_rank).filter(real) {
            for (name, partner, polar) in PART_NAMES {
                if !first.name().eq_ignore_ascii_case(name) {
                    continue;
                }
                if let Some(second) = named(partner, first.folder()).filter(|second| second.shape() == first.shape()) {
                    parts.push(if polar { Source::Polar(first, second) } else { Source::Parts(first, second) });
                }
            }
        }
        parts
    }

    /// Rising lists of real numbers with the name of a frequency axis.
    fn frequency_candidates(&self) -> Result<Vec<&'a Entry>> {
        let mut found = Vec::new();
        for entry in self.datasets() {
            let named = FREQUENCY_NAMES.iter().any(|name| entry.name().eq_ignore_ascii_case(name));
            let numbers = matches!(entry.element(), Some(Element::Real { .. } | Element::Integer));
            let list = entry.shape().iter().filter(|&&extent| extent != 1).count() == 1;
            if named && numbers && list {
                let values = reals(entry, self.file.read(entry)?)?;
                if values.windows(2).all(|pair| pair[0] < pair[1]) {
                    found.push(entry);
                }
            }
        }
        Ok(found)
    }

    fn frf_set(&self, source: Source<'a>, freq: &'a Entry, warnings: &mut Vec<String>) -> Result<SetAndSign> {
        let frequency_hz = Array1::from(self.frequency_hz(freq, warnings)?);
        let shape = logical_shape(source.first());
        let [response, reference, line] = self.axes(source, &shape, frequency_hz.len())?;
        let line = line.ok_or_else(|| Error::new(ErrorKind::Internal, "the axis of the lines is not known"))?;
        let mut values = self.array(source)?.into_frf_values(response, reference, line);
        if shape.len() == 3 && line != 2 {
            warnings.push(format!("{}: the other axes are taken in the order response, reference", source.first().path));
        }
        let (kind, reference_unit) = self.units(source.first(), &mut values, warnings);
        let (response_count, reference_count, _) = values.dim();
        let responses = self.dofs("response", &RESPONSE_NAMES, source.first(), response_count, Direction::PLUS_Z, warnings)?;
        let references = self.dofs("reference", &REFERENCE_NAMES, source.first(), reference_count, Direction::SCALAR, warnings)?;
        let set =
            FrfSet { frequency_hz, values, responses, references, kind, reference_unit, coherence: None, geometry: Geometry::default() };
        let said = self.text_near(source.first(), "time_sign").and_then(|sign| sign.parse().ok());
        Ok((set.checked()?, said))
    }

    fn frequency_hz(&self, freq: &Entry, warnings: &mut Vec<String>) -> Result<Vec<f64>> {
        let mut values = reals(freq, self.file.read(freq)?)?;
        if let Some(unit) = freq.text("unit").or(freq.text("units")) {
            match frequency_unit(unit) {
                Some(to_hz) => values.iter_mut().for_each(|f| *f *= to_hz),
                None => warnings.push(format!("{}: unit `{unit}` is no frequency; taken as Hz", freq.path)),
            }
        }
        Ok(values)
    }

    /// Axes of response, reference and line in the logical shape.
    fn axes(&self, source: Source<'_>, shape: &[usize], lines: usize) -> Result<[Option<usize>; 3]> {
        if shape.len() > 3 {
            return Err(wrong_type(source.first(), "at most three axes: response, reference, line").found(format!("shape {shape:?}")));
        }
        if let Some((_, text)) = self.map.iter().find(|(key, _)| key == "axes") {
            return named_axes(text, shape, lines);
        }
        let candidates: Vec<usize> = (0..shape.len()).filter(|&axis| shape[axis] == lines).collect();
        let &[line] = candidates.as_slice() else {
            return Err(Error::bad_data(format!("{} axes are as long as the frequency axis ({lines})", candidates.len()))
                .field(&source.first().path)
                .found(format!("shape {shape:?}"))
                .expected("one axis")
                .help("name the axes in order, like --map frf=PATH,freq=PATH,axes=response-reference-line"));
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
                let to_radians =
                    if matches!(second.text("unit"), Some(unit) if unit.trim().starts_with("rad")) { 1.0 } else { 1f64.to_radians() };
                let mut values = ndarray::ArrayD::zeros(a.raw_dim());
                Zip::from(&mut values).and(&mut a).and(&b).for_each(|value, &mut a, &b| {
                    *value = match source {
                        Source::Polar(..) => Complex64::from_polar(a, b * to_radians),
                        _ => Complex64::new(a, b),
                    }
                });
                ComplexArray::Double(values)
            }
        };
        Ok(if is_matlab(source.first()) { array.reversed_axes() } else { array })
    }

    fn text_near(&self, entry: &'a Entry, name: &str) -> Option<&'a str> {
        let group = self.entries.iter().find(|group| group.dataset.is_none() && group.path == entry.folder());
        entry.text(name).or_else(|| group?.text(name)).or_else(|| self.entries.first()?.text(name))
    }

    /// Kind and reference unit, as far as attributes say them; values are scaled to SI.
    fn units(&self, entry: &'a Entry, values: &mut FrfValues, warnings: &mut Vec<String>) -> (Option<crate::FrfKind>, ReferenceUnit) {
        let said = self.text_near(entry, "frf_kind").and_then(|kind| kind.parse().ok());
        let Some(label) = entry.text("unit").or(entry.text("units")) else {
            warnings.push(format!("{}: no attribute `unit`; values are taken as SI", entry.path));
            return (said, ReferenceUnit::Newton);
        };
        let Some(unit) = frf_unit(label) else {
            warnings.push(format!("{}: unit `{label}` is no motion per force or volt; values are taken as SI", entry.path));
            return (said, ReferenceUnit::Newton);
        };
        scale(values, unit.to_si);
        (said.or(Some(unit.kind)), unit.reference)
    }

    /// DOFs from a dataset beside the FRFs, else numbered by position.
    fn dofs(
        &self,
        key: &str,
        names: &[&str],
        frf: &Entry,
        count: usize,
        direction: Direction,
        warnings: &mut Vec<String>,
    ) -> Result<Vec<Dof>> {
        let beside = |entry: &&Entry| entry.folder() == frf.folder() && names.iter().any(|name| entry.name().eq_ignore_ascii_case(name));
        let entry = match self.mapped(key)? {
            Some(entry) => Some(entry),
            None => self.datasets().filter(beside).find(|entry| length(entry) == count),
        };
        let Some(entry) = entry else {
            let named = if count == 1 { format!("1:{direction}") } else { format!("1:{direction} ... {count}:{direction}") };
            warnings.push(format!("{}: the file names no {key} DOFs; they are numbered {named}", frf.path));
            return Ok((1..=count as u64).map(|node| Dof::new(node, direction)).collect());
        };
        let dofs: Vec<Dof> = match self.file.read(entry)? {
            Values::Dofs(dofs) => dofs,
            Values::Unsigned(nodes) => {
                warnings.push(format!("{}: node numbers without a direction; {direction} is assumed", entry.path));
                nodes.iter().map(|&node| Dof::new(node, direction)).collect()
            }
            Values::Text(texts) => texts
                .iter()
                .map(|text| text.parse().map_err(|message: String| Error::bad_data(message).field(&entry.path)))
                .collect::<Result<_>>()?,
            _ => return Err(wrong_type(entry, "DOF texts like 12:+Z, node numbers or records {node, dir}")),
        };
        if dofs.len() != count {
            return Err(Error::bad_data("sizes disagree")
                .field(&entry.path)
                .found(dofs.len())
                .expected(format!("{count}, the {key} axis of {}", frf.path)));
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
    let find = |name: &str| words.iter().position(|word| word.trim_end_matches('s') == name);
    let axes = [find("response"), find("reference"), find("line")];
    let complete = words.len() == shape.len() && axes.iter().flatten().count() == words.len();
    if complete && axes[2].is_some_and(|axis| shape[axis] == lines) {
        return Ok(axes);
    }
    Err(Error::new(ErrorKind::Usage, "the axes do not fit")
        .field("--map axes")
        .found(format!("{text} for shape {shape:?}"))
        .expected(format!("one of response, reference, line for each axis, joined by '-', with {lines} lines")))
}

fn scale(values: &mut FrfValues, factor: f64) {
    if factor != 1.0 {
        match values {
            FrfValues::F64(values) => values.mapv_inplace(|value| value * factor),
            FrfValues::F32(values) => values.mapv_inplace(|value| value * factor as f32),
        }
    }
}
