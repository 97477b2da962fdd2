//! The axes of an array that are the response, the reference, the line.

use super::choose::Source;
use super::Reader;
use chladni_frf::{Error, ErrorKind, Result};

/// Lengths that lists beside the array give its axes.
pub(super) struct Lengths {
    pub(super) response: Option<usize>,
    pub(super) reference: Option<usize>,
    pub(super) lines: usize,
}

/// Axes of response, reference and line; `None` where the array has none.
type Axes = [Option<usize>; 3];

impl Lengths {
    fn fits(&self, shape: &[usize], axes: &Axes) -> bool {
        let extent = |axis: Option<usize>| axis.map_or(1, |axis| shape[axis]);
        extent(axes[2]) == self.lines
            && self.response.is_none_or(|count| extent(axes[0]) == count)
            && self.reference.is_none_or(|count| extent(axes[1]) == count)
    }
}

/// Every way to give the axes of an array of that rank their meaning: one is the line.
/// Those with the response before the reference, and the line behind both, come first.
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

impl<'a> Reader<'a> {
    /// Axes of response, reference and line in the logical shape, and whether the file or
    /// the user says which is which.
    pub(super) fn axes(
        &self,
        source: Source<'a>,
        shape: &[usize],
        lengths: &Lengths,
    ) -> Result<(Axes, bool)> {
        let frf = source.first();
        if !(1..=3).contains(&shape.len()) {
            return Err(
                super::wrong_type(frf, "at most three axes: response, reference, line")
                    .found(format!("shape {shape:?}")),
            );
        }
        if let Some((_, text)) = self.map.iter().find(|(key, _)| key == "axes") {
            return Ok((named_axes(text, shape, lengths.lines)?, true));
        }
        if let Some(text) = self.text_near(frf, "axes") {
            if let Ok(axes) = named_axes(text, shape, lengths.lines) {
                return Ok((axes, true));
            }
        }
        let fitting: Vec<Axes> = ways(shape.len())
            .iter()
            .filter(|axes| lengths.fits(shape, axes))
            .copied()
            .collect();
        let Some(&first) = fitting.first() else {
            return Err(no_way(frf.path.as_str(), shape, lengths));
        };
        // axes of one value may change places
        let differs = |a: Option<usize>, b: Option<usize>| {
            a != b && a.or(b).is_some_and(|axis| shape[axis] > 1)
        };
        let other_line = fitting
            .iter()
            .any(|axes| axes[2] != first[2] && (lengths.lines > 1 || differs(axes[0], first[0])));
        if other_line {
            let count = shape.iter().filter(|extent| **extent == lengths.lines);
            return Err(Error::bad_data(format!(
                "{} axes are as long as the frequency axis ({})",
                count.count(),
                lengths.lines
            ))
            .field(&frf.path)
            .found(format!("shape {shape:?}"))
            .expected("one axis")
            .help(
                "name the axes in order, like `map \
                 frf=PATH,freq=PATH,axes=response-reference-line`",
            ));
        }
        let by_lists = lengths.response.is_some() || lengths.reference.is_some();
        let same = fitting
            .iter()
            .all(|axes| !differs(axes[0], first[0]) && !differs(axes[1], first[1]));
        Ok((first, by_lists && same))
    }
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
        .field("map axes")
        .found(format!("{text} for shape {shape:?}"))
        .expected(format!(
            "one of response, reference, line for each axis, joined by '-', with {lines} lines"
        )))
}
