//! The datasets of a foreign file that are the FRFs and their frequency axis: those of
//! the caller's map, else the only ones that fit.

use super::super::tree::{Element, Entry};
use super::super::values::{reals, ComplexArray};
use super::{describe, length, Reader};
use chladni_frf::{Error, ErrorKind, Result};
use ndarray::Axis;
use num_complex::Complex64;

/// Names that a frequency axis goes by.
pub(super) const FREQUENCY_NAMES: [&str; 10] = [
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
/// Pairs of real arrays that hold one complex array, and whether they are magnitude and
/// phase.
const PART_NAMES: [(&[&str], &[&str], bool); 2] = [
    (&["re", "real"], &["im", "imag"], false),
    (
        &[
            "mag",
            "magnitude",
            "abs",
            "amplitude",
            "mag_db",
            "magnitude_db",
        ],
        &["phase", "phase_deg", "phase_rad", "angle"],
        true,
    ),
];

/// The values, in one dataset or two.
#[derive(Clone, Copy)]
pub(super) enum Source<'a> {
    Complex(&'a Entry),
    Parts(&'a Entry, &'a Entry),
    Polar(&'a Entry, &'a Entry),
    /// Frequencies and FRFs beside each other in one array.
    Joined(&'a Entry),
}

impl<'a> Source<'a> {
    /// The dataset that gives shape, unit and place.
    pub(super) fn first(self) -> &'a Entry {
        match self {
            Self::Complex(entry)
            | Self::Parts(entry, _)
            | Self::Polar(entry, _)
            | Self::Joined(entry) => entry,
        }
    }
    /// All its datasets.
    pub(super) fn datasets(self) -> impl Iterator<Item = &'a Entry> {
        let second = match self {
            Self::Complex(_) | Self::Joined(_) => None,
            Self::Parts(_, second) | Self::Polar(_, second) => Some(second),
        };
        std::iter::once(self.first()).chain(second)
    }
    pub(super) fn describe(self) -> String {
        match self {
            Self::Complex(entry) | Self::Joined(entry) => describe(entry),
            Self::Parts(a, b) | Self::Polar(a, b) => format!("{} with {}", describe(a), b.path),
        }
    }
}

fn not_clear(sources: &[Source<'_>], axes: &[&Entry]) -> Error {
    let list = |entries: Vec<String>| match entries.as_slice() {
        [] => "none".to_owned(),
        entries => entries.join(", "),
    };
    Error::bad_data("it is not clear which datasets are the FRFs and their frequency axis")
        .field("FRFs and frequency axis")
        .found(format!(
            "{} complex arrays and {} frequency axes that may belong together",
            sources.len(),
            axes.len()
        ))
        .expected("one of each")
        .help(format!(
            "name them with `map frf=PATH,freq=PATH`; complex arrays: {}; frequency axes: {}",
            list(sources.iter().map(|source| source.describe()).collect()),
            list(axes.iter().map(|axis| describe(axis)).collect()),
        ))
}

impl<'a> Reader<'a> {
    /// The FRFs and their frequency axis; `None` where nothing looks like them.
    pub(super) fn choose(&self) -> Result<Option<(Source<'a>, &'a Entry)>> {
        let sources = match self.mapped_source()? {
            Some(source) => vec![source],
            None => self.source_candidates()?,
        };
        let axes = match self.mapped("freq")? {
            Some(entry) => vec![entry],
            None => self.frequency_candidates()?,
        };
        let mut pairs: Vec<(Source<'a>, &'a Entry)> = Vec::new();
        for &source in &sources {
            let fitting = axes
                .iter()
                .filter(|axis| source.first().shape().contains(&length(axis)));
            pairs.extend(fitting.map(|&axis| (source, axis)));
        }
        // a single number may be an axis of one line, but not beside a real axis
        if pairs.iter().any(|(_, axis)| length(axis) > 1) {
            pairs.retain(|(_, axis)| length(axis) > 1);
        }
        if pairs.is_empty() && self.mapped("freq")?.is_none() {
            if let &[Source::Complex(entry)] = sources.as_slice() {
                if self.is_joined(entry)? {
                    return Ok(Some((Source::Joined(entry), entry)));
                }
            }
        }
        // a frequency axis beside the array wins over one elsewhere
        let beside: Vec<_> = pairs
            .iter()
            .filter(|(source, axis)| source.first().folder() == axis.folder())
            .copied()
            .collect();
        match (pairs.as_slice(), beside.as_slice()) {
            (&[pair], _) => Ok(Some(pair)),
            (_, &[pair]) if sources.len() == 1 => Ok(Some(pair)),
            ([], _) if self.map.is_empty() => Ok(None),
            _ => Err(not_clear(&sources, &axes)),
        }
    }

    /// True where frequencies stand in the array's own first row or column.
    fn is_joined(&self, entry: &Entry) -> Result<bool> {
        if entry.shape().len() != 2 {
            return Ok(false);
        }
        let array = ComplexArray::new(entry, self.file.read(entry)?)?.widened();
        let ComplexArray::Double(values) = array else {
            return Ok(false);
        };
        Ok(joined_axis(&values.view()).is_some())
    }

    fn mapped_source(&self) -> Result<Option<Source<'a>>> {
        if let Some(entry) = self.mapped("frf")? {
            return Ok(Some(Source::Complex(entry)));
        }
        match (
            self.mapped("re")?,
            self.mapped("im")?,
            self.mapped("mag")?,
            self.mapped("phase")?,
        ) {
            (None, None, None, None) => Ok(None),
            (Some(re), Some(im), None, None) => Ok(Some(Source::Parts(re, im))),
            (None, None, Some(mag), Some(phase)) => Ok(Some(Source::Polar(mag, phase))),
            _ => Err(
                Error::new(ErrorKind::Usage, "the values of `map` are not complete")
                    .field("map")
                    .found("one part of two, or parts of two kinds")
                    .expected("frf, or re and im, or mag and phase"),
            ),
        }
    }

    fn source_candidates(&self) -> Result<Vec<Source<'a>>> {
        let of_rank = |entry: &&Entry| (1..=3).contains(&entry.shape().len());
        let mut complex = Vec::new();
        for entry in self.datasets().filter(of_rank) {
            let is_axis = || {
                let values = self.file.read(entry);
                values.map(|values| reals(entry, values).is_ok())
            };
            let named = super::is_frequency_name(entry.name());
            if matches!(entry.element(), Some(Element::Complex { .. })) && !(named && is_axis()?) {
                complex.push(Source::Complex(entry));
            }
        }
        if !complex.is_empty() {
            return Ok(complex);
        }
        let real = |entry: &&Entry| matches!(entry.element(), Some(Element::Real { .. }));
        let named = |name: &str, folder: &str| {
            self.datasets()
                .find(|entry| entry.folder() == folder && entry.name().eq_ignore_ascii_case(name))
        };
        let mut parts = Vec::new();
        for first in self.datasets().filter(of_rank).filter(real) {
            let is = |name: &&str| first.name().eq_ignore_ascii_case(name);
            for (names, partners, polar) in PART_NAMES {
                let second =
                    partners
                        .iter()
                        .filter(|_| names.iter().any(&is))
                        .find_map(|partner| {
                            named(partner, first.folder())
                                .filter(|second| second.shape() == first.shape())
                        });
                match second {
                    Some(second) if polar => parts.push(Source::Polar(first, second)),
                    Some(second) => parts.push(Source::Parts(first, second)),
                    None => {}
                }
            }
        }
        Ok(parts)
    }

    /// Rising lists of real numbers with the name of a frequency axis.
    fn frequency_candidates(&self) -> Result<Vec<&'a Entry>> {
        let mut found = Vec::new();
        for entry in self.datasets() {
            let named = super::is_frequency_name(entry.name());
            let numbers = matches!(
                entry.element(),
                Some(Element::Real { .. } | Element::Integer | Element::Complex { .. })
            );
            let long = entry.shape().iter().filter(|&&extent| extent != 1).count();
            let list = !entry.shape().is_empty() && long <= 1;
            if named && numbers && list {
                let Ok(values) = reals(entry, self.file.read(entry)?) else {
                    continue; // complex, and no axis
                };
                if values.windows(2).all(|pair| pair[0] < pair[1]) {
                    found.push(entry);
                }
            }
        }
        Ok(found)
    }
}

/// The axis along which a frequency axis and the FRFs stand beside each other: its first
/// slice is real, not negative and rises, and the others are not all real.
pub(super) fn joined_axis(values: &ndarray::ArrayViewD<'_, Complex64>) -> Option<usize> {
    let is_axis = |axis: &usize| {
        let (first, others) = values.view().split_at(Axis(*axis), 1);
        let frequencies: Vec<f64> = first.iter().map(|value| value.re).collect();
        !others.is_empty()
            && frequencies.len() > 1
            && first.iter().all(|value| value.im == 0.0)
            && frequencies[0] >= 0.0
            && frequencies.windows(2).all(|pair| pair[0] < pair[1])
            && others.iter().any(|value| value.im != 0.0)
    };
    (values.ndim() == 2)
        .then(|| [1, 0].into_iter().find(is_axis))
        .flatten()
}
