//! The axes of an array that are the response, the reference, the line.

use super::super::tree::Entry;
use super::facts::FrfFacts;
use super::Reader;
use chladni_frf::{Error, ErrorKind, Result};

/// Lengths that lists beside the array give its axes.
pub(super) struct Lengths {
    pub(super) response: Option<usize>,
    pub(super) reference: Option<usize>,
    pub(super) lines: usize,
}

/// The axes of an array, and whether the file or the user names them.
pub(super) struct NamedAxes {
    pub(super) axes: Axes,
    pub(super) are_named: bool,
}

/// Axes of response, reference and line; `None` where the array has none.
pub(super) type Axes = [Option<usize>; 3];

impl Lengths {
    fn fits(&self, shape: &[usize], axes: &Axes) -> bool {
        let extent = |axis: Option<usize>| axis.map_or(1, |axis| shape[axis]);
        extent(axes[2]) == self.lines
            && self.response.is_none_or(|count| extent(axes[0]) == count)
            && self.reference.is_none_or(|count| extent(axes[1]) == count)
    }
}

/// All assignments of response, reference and line to the axes of an array of that rank.
/// Those with the response before the reference, and the line after both, come first.
fn ways(rank: usize) -> &'static [Axes] {
    match rank {
        1 => &[[None, None, Some(0)]],
        2 => &[
            [Some(0), None, Some(1)],
            [Some(1), None, Some(0)],
            [None, Some(0), Some(1)],
            [None, Some(1), Some(0)],
        ],
        _ => &[
            [Some(0), Some(1), Some(2)],
            [Some(0), Some(2), Some(1)],
            [Some(1), Some(2), Some(0)],
            [Some(1), Some(0), Some(2)],
            [Some(2), Some(0), Some(1)],
            [Some(2), Some(1), Some(0)],
        ],
    }
}

/// The names that the file gives the axes, as far as they are known.
struct AxisNames {
    text: String,
    roles: Vec<Option<usize>>,
    field: String,
}

impl AxisNames {
    /// The names in a fact called `axes` and in `DIMENSION_LABELS`.
    fn in_file(frf: &Entry, facts: &FrfFacts<'_>) -> impl Iterator<Item = Self> {
        let fact = facts.axes.as_ref().map(|fact| Self {
            text: fact.text.clone(),
            roles: roles(&fact.text),
            field: fact.field.clone(),
        });
        let labels = frf.text("DIMENSION_LABELS").map(|labels| Self {
            text: labels.to_owned(),
            roles: labels.split(',').map(role).collect(),
            field: format!("DIMENSION_LABELS of {}", frf.path),
        });
        [fact, labels].into_iter().flatten()
    }
}

impl<'a> Reader<'a> {
    /// The axes of response, reference and line in the logical shape.
    pub(super) fn axes(
        &self,
        frf: &Entry,
        facts: &FrfFacts<'a>,
        shape: &[usize],
        lengths: &Lengths,
    ) -> Result<NamedAxes> {
        if !(1..=3).contains(&shape.len()) {
            return Err(
                super::wrong_type(frf, "at most three axes: response, reference, line")
                    .found(format!("shape {shape:?}")),
            );
        }
        if let Some(axes) = self.complete_names(facts, shape, lengths.lines)? {
            return Ok(NamedAxes {
                axes,
                are_named: true,
            });
        }
        let mut fitting: Vec<Axes> = ways(shape.len())
            .iter()
            .filter(|axes| lengths.fits(shape, axes))
            .copied()
            .collect();
        if fitting.is_empty() {
            return Err(no_way(frf.path.as_str(), shape, lengths));
        }
        let mut by_names = false;
        for names in AxisNames::in_file(frf, facts) {
            // a single axis is the line, and a single word the name of a dataset
            if shape.len() == 1 || names.roles.len() == 1 {
                continue;
            }
            by_names |= names.roles.iter().any(Option::is_some);
            fitting.retain(|axes| agrees(axes, &names.roles));
            if fitting.is_empty() {
                let error = Error::bad_data("the axes do not fit").field(names.field);
                return Err(misfit(error, &names.text, shape, lengths.lines)
                    .help("correct them, or name the axes with `map axes=...`"));
            }
        }
        let first = fitting[0];
        // axes of one value may change places
        let differs = |a: Option<usize>, b: Option<usize>| {
            a != b && a.or(b).is_some_and(|axis| shape[axis] > 1)
        };
        let other_line = fitting
            .iter()
            .any(|axes| axes[2] != first[2] && (lengths.lines > 1 || differs(axes[0], first[0])));
        if other_line {
            return Err(several_lines(&frf.path, shape, lengths.lines));
        }
        let by_lists = lengths.response.is_some() || lengths.reference.is_some();
        let same = fitting
            .iter()
            .all(|axes| !differs(axes[0], first[0]) && !differs(axes[1], first[1]));
        Ok(NamedAxes {
            axes: first,
            are_named: (by_lists || by_names) && same,
        })
    }

    /// The axes where the caller's map, else a fact of the file, names all of them.
    fn complete_names(
        &self,
        facts: &FrfFacts<'a>,
        shape: &[usize],
        lines: usize,
    ) -> Result<Option<Axes>> {
        if let Some((_, text)) = self.map.iter().find(|(key, _)| key == "axes") {
            let axes = named_axes(text, shape, lines).ok_or_else(|| {
                let error = Error::new(ErrorKind::Usage, "the axes do not fit");
                misfit(error.field("map axes"), text, shape, lines)
            })?;
            return Ok(Some(axes));
        }
        let fact = facts.axes.as_ref();
        Ok(fact.and_then(|fact| named_axes(&fact.text, shape, lines)))
    }
}

/// The error of a shape in which several axes may be that of the lines.
fn several_lines(path: &str, shape: &[usize], lines: usize) -> Error {
    let count = shape.iter().filter(|extent| **extent == lines).count();
    Error::bad_data(format!(
        "{count} axes are as long as the frequency axis ({lines})"
    ))
    .field(path)
    .found(format!("shape {shape:?}"))
    .expected("one axis")
    .help(
        "name the axes in order, like `map \
         frf=PATH,freq=PATH,axes=response-reference-line`",
    )
}

fn no_way(path: &str, shape: &[usize], lengths: &Lengths) -> Error {
    let list = |name: &str, count: Option<usize>| {
        count.map_or(String::new(), |count| format!(", {count} {name} DOFs"))
    };
    Error::bad_data("no axes of the array are as long as the lists beside it")
        .field(path)
        .found(format!("shape {shape:?}"))
        .expected(format!(
            "{} lines{}{}",
            lengths.lines,
            list("response", lengths.response),
            list("reference", lengths.reference)
        ))
        .help("correct the lists, or name others with `map response=PATH,reference=PATH`")
}

/// Words for the axes of response, reference and line.
const AXIS_WORDS: [&[&str]; 3] = [
    &["response", "resp", "rsp", "output"],
    &["reference", "ref", "input"],
    &["line", "frequency", "frequencies", "freq", "f"],
];

/// The place in [`Axes`] of the axis that a word names.
fn role(word: &str) -> Option<usize> {
    let word = word.trim().to_lowercase();
    let singular = word.strip_suffix('s').unwrap_or(&word);
    (AXIS_WORDS.iter())
        .position(|words| words.contains(&word.as_str()) || words.contains(&singular))
}

/// The roles of the words of a text, whatever separates them.
fn roles(text: &str) -> Vec<Option<usize>> {
    let words = text.split(|c: char| !c.is_alphanumeric());
    words.filter(|word| !word.is_empty()).map(role).collect()
}

/// True where every axis with a role has that role.
fn agrees(axes: &Axes, roles: &[Option<usize>]) -> bool {
    let mut told = roles.iter().enumerate();
    told.all(|(axis, role)| role.is_none_or(|role| axes[role] == Some(axis)))
}

/// `response-reference-line` in any order, two or three words; `None` where they do not
/// name every axis, or another as the line.
fn named_axes(text: &str, shape: &[usize], lines: usize) -> Option<Axes> {
    let roles = roles(text);
    let axes = ways(shape.len()).iter().find(|axes| agrees(axes, &roles))?;
    let complete = roles.len() == shape.len() && roles.iter().all(Option::is_some);
    (complete && axes[2].is_some_and(|axis| shape[axis] == lines)).then_some(*axes)
}

fn misfit(error: Error, text: &str, shape: &[usize], lines: usize) -> Error {
    error
        .found(format!("{text} for shape {shape:?}"))
        .expected(format!(
            "one of response, reference, line for each axis, joined by '-', with {lines} lines"
        ))
}
