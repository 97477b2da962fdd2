//! The datasets of a foreign file that are the FRFs and their frequency axis: those of
//! the caller's map, else the only ones that fit.

use super::super::tree::{Element, Entry};
use super::super::values::{reals, ComplexArray};
use super::{describe, dofs, frequency, length, Reader};
use crate::limits::DATASETS_LISTED;
use crate::paths::shortened;
use chladni_frf::{Error, ErrorKind, Finding, Result};
use ndarray::Axis;
use num_complex::Complex64;

/// Names of two real arrays that hold one complex array together.
struct PartNames {
    first: &'static [&'static str],
    second: &'static [&'static str],
    is_polar: bool,
}

const PART_NAMES: [PartNames; 2] = [
    PartNames {
        first: &["re", "real"],
        second: &["im", "imag"],
        is_polar: false,
    },
    PartNames {
        first: &[
            "mag",
            "magnitude",
            "abs",
            "amplitude",
            "mag_db",
            "magnitude_db",
        ],
        second: &["phase", "phase_deg", "phase_rad", "angle"],
        is_polar: true,
    },
];

/// Names of real arrays beside frequencies that are no FRFs.
const NO_FRFS: [&str; 10] = [
    "coherence",
    "damping",
    "damping_ratio",
    "damping_ratios",
    "loss_factor",
    "loss_factors",
    "loss factor",
    "shape",
    "shapes",
    "mode_shapes",
];

/// A list of numbers that may be the frequency axis.
#[derive(Clone, Copy)]
struct NumberList<'a> {
    entry: &'a Entry,
    rises: bool,
}

/// The values, in one dataset or two.
#[derive(Clone, Copy)]
pub(super) enum Source<'a> {
    Complex(&'a Entry),
    Parts(&'a Entry, &'a Entry),
    Polar(&'a Entry, &'a Entry),
    /// One array whose first row or column holds the frequencies.
    Joined(&'a Entry),
}

impl<'a> Source<'a> {
    /// The dataset that gives the shape, the unit and the folder.
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
    pub(super) fn choose(
        &self,
        warnings: &mut Vec<Finding>,
    ) -> Result<Option<(Source<'a>, &'a Entry)>> {
        let sources = match self.mapped_source()? {
            Some(source) => vec![source],
            None => self.source_candidates()?,
        };
        let axes = match self.mapped("freq")? {
            Some(entry) => vec![entry],
            None => {
                let named = self.lists(frequency::is_name)?;
                let rising = rising(&named);
                if pairs(&sources, &rising).is_empty() {
                    if let &[Source::Complex(entry)] = sources.as_slice() {
                        if self.is_joined(entry)? {
                            return Ok(Some((Source::Joined(entry), entry)));
                        }
                    }
                    self.other_axes(&sources, named)?
                } else {
                    rising
                }
            }
        };
        let pairs = pairs(&sources, &axes);
        // a frequency axis beside the array wins over one elsewhere
        let beside: Vec<_> = pairs
            .iter()
            .filter(|(source, axis)| source.first().folder() == axis.folder())
            .copied()
            .collect();
        match (pairs.as_slice(), beside.as_slice()) {
            (&[pair], _) => Ok(Some(pair)),
            (_, &[pair]) if sources.len() == 1 => Ok(Some(pair)),
            ([], _) if self.map.is_empty() => {
                let nameless = self.nameless_axis(&sources);
                warnings.extend(nameless.or_else(|| other_lengths(&sources, &axes)));
                if sources.is_empty() {
                    warnings.extend(self.real_values()?);
                }
                Ok(None)
            }
            _ => Err(not_clear(&sources, &axes)),
        }
    }

    /// True where the first row or column of the array holds the frequencies.
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
            let name = entry.name();
            let named = frequency::is_name(name) || frequency::is_likely_name(name);
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
        // named `re` and `im`, else `H_re` and `H_im`
        for stem in ["", "H_", "FRF_"] {
            let mut parts = Vec::new();
            for first in self.datasets().filter(of_rank).filter(real) {
                let called = |name: &str| format!("{stem}{name}");
                let is = |name: &&str| first.name().eq_ignore_ascii_case(&called(name));
                for names in PART_NAMES
                    .iter()
                    .filter(|names| names.first.iter().any(&is))
                {
                    let second = names.second.iter().find_map(|partner| {
                        named(&called(partner), first.folder())
                            .filter(|second| second.shape() == first.shape())
                    });
                    match second {
                        Some(second) if names.is_polar => parts.push(Source::Polar(first, second)),
                        Some(second) => parts.push(Source::Parts(first, second)),
                        None => {}
                    }
                }
            }
            if !parts.is_empty() {
                return Ok(parts);
            }
        }
        Ok(Vec::new())
    }

    /// Lists of real numbers with such a name.
    fn lists(&self, is_named: fn(&str) -> bool) -> Result<Vec<NumberList<'a>>> {
        let mut found = Vec::new();
        let named = |entry: &&Entry| is_list(entry) && is_named(entry.name());
        for entry in self.datasets().filter(named) {
            if let Ok(values) = reals(entry, self.file.read(entry)?) {
                let rises = values.windows(2).all(|pair| pair[0] < pair[1]);
                found.push(NumberList { entry, rises });
            }
        }
        Ok(found)
    }

    /// Axes where no rising list has a usual name: lists of less usual names, else lists
    /// that do not rise, so that the error names what is wrong with them. A list called by
    /// one letter, `x` or `f`, may hold positions or forces. It is no candidate where
    /// another rising list may be the axis.
    fn other_axes(
        &self,
        sources: &[Source<'a>],
        named: Vec<NumberList<'a>>,
    ) -> Result<Vec<&'a Entry>> {
        let mut others = self.lists(frequency::is_likely_name)?;
        others.retain(|list| length(list.entry) > 1);
        let rising = rising(&others);
        if !pairs(sources, &rising).is_empty() {
            return Ok(rising);
        }
        let mut all: Vec<&Entry> = (named.into_iter().chain(others))
            .map(|list| list.entry)
            .collect();
        let mut nameless = self::rising(&self.lists(|name| !dofs::is_name(name))?);
        nameless.retain(|entry| length(entry) > 1);
        if !pairs(sources, &nameless).is_empty() {
            all.retain(|entry| entry.name().chars().count() > 1);
        }
        Ok(all)
    }

    /// The finding about real numbers beside a frequency axis, where nothing is complex.
    fn real_values(&self) -> Result<Option<Finding>> {
        // `x` may hold positions
        let named =
            self.lists(|name| frequency::is_name(name) && !name.eq_ignore_ascii_case("x"))?;
        let mut axes = rising(&named);
        axes.retain(|axis| length(axis) > 1);
        let is_other = |name: &str| {
            frequency::is_name(name)
                || frequency::is_likely_name(name)
                || dofs::is_name(name)
                || NO_FRFS.iter().any(|other| name.eq_ignore_ascii_case(other))
        };
        let is_value = |entry: &&Entry| {
            matches!(entry.element(), Some(Element::Real { .. }))
                && (1..=3).contains(&entry.shape().len())
                && !is_other(entry.name())
                && axes
                    .iter()
                    .any(|axis| entry.shape().contains(&length(axis)))
        };
        let found: Vec<String> = self.datasets().filter(is_value).map(describe).collect();
        if found.is_empty() {
            return Ok(None);
        }
        let words = format!(
            "only real numbers beside a frequency axis: {}",
            shortened(&found, DATASETS_LISTED)
        );
        let help = "if they are FRFs: save complex values, or both parts: `map \
                    re=PATH,im=PATH,freq=PATH` or `map mag=PATH,phase=PATH,freq=PATH`";
        Ok(Some(Finding::caution("real-array", words).help(help)))
    }

    /// The finding about complex arrays for which some list may be the axis, though not by its
    /// name.
    fn nameless_axis(&self, sources: &[Source<'a>]) -> Option<Finding> {
        let is_real = |entry: &&Entry| {
            is_list(entry) && !matches!(entry.element(), Some(Element::Complex { .. }))
        };
        let lists: Vec<&Entry> = self.datasets().filter(is_real).collect();
        let pairs = pairs(sources, &lists);
        let (source, _) = pairs.first().filter(|(_, axis)| length(axis) > 1)?;
        let axes: Vec<String> = pairs.iter().map(|(_, axis)| axis.path.clone()).collect();
        let words = format!(
            "{}: no array is its frequency axis by name; as long as one of its axes: {}",
            source.describe(),
            shortened(&axes, DATASETS_LISTED)
        );
        let help = "if one of these is the frequency axis: name both arrays with `map \
                    frf=PATH,freq=PATH`";
        Some(Finding::caution("no-frequency-axis", words).help(help))
    }
}

/// The finding about complex arrays and frequency axes of another length.
fn other_lengths(sources: &[Source<'_>], axes: &[&Entry]) -> Option<Finding> {
    let axes = axes.iter().filter(|axis| length(axis) > 1);
    let axes: Vec<String> = axes.map(|axis| describe(axis)).collect();
    let source = sources.first().filter(|_| !axes.is_empty())?;
    let words = format!(
        "{}: no axis of it is as long as the frequency axis {}",
        source.describe(),
        shortened(&axes, DATASETS_LISTED)
    );
    Some(
        Finding::caution("no-frequency-axis", words)
            .help("save one frequency for each line of the FRFs"),
    )
}

/// True for numbers along one axis.
fn is_list(entry: &Entry) -> bool {
    let numbers = matches!(
        entry.element(),
        Some(Element::Real { .. } | Element::Integer | Element::Complex { .. })
    );
    let long = entry.shape().iter().filter(|&&extent| extent != 1).count();
    numbers && !entry.shape().is_empty() && long <= 1
}

fn rising<'a>(lists: &[NumberList<'a>]) -> Vec<&'a Entry> {
    let rising = lists.iter().filter(|list| list.rises);
    rising.map(|list| list.entry).collect()
}

/// FRFs, each with the lists that are as long as one of its axes.
fn pairs<'a>(sources: &[Source<'a>], axes: &[&'a Entry]) -> Vec<(Source<'a>, &'a Entry)> {
    let mut pairs = Vec::new();
    for &source in sources {
        let fitting = axes
            .iter()
            .filter(|axis| source.first().shape().contains(&length(axis)));
        pairs.extend(fitting.map(|&axis| (source, axis)));
    }
    // a single number may be an axis of one line, but not beside a real axis
    if pairs.iter().any(|(_, axis)| length(axis) > 1) {
        pairs.retain(|(_, axis)| length(axis) > 1);
    }
    pairs
}

/// The axis along which the frequencies come first and the FRFs follow: its first slice is
/// real, not negative and rises, and the others are not all real.
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
    (values.ndim() == 2 && !values.is_empty())
        .then(|| [1, 0].into_iter().find(is_axis))
        .flatten()
}
