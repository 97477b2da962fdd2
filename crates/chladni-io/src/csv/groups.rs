//! The columns of each FRF in a wide table.

use super::column_header::ColumnHeader;
use super::form::push_once;
use super::table::Table;
use super::vocabulary::Part;
use crate::limits::{LARGEST_DECIBELS, WRAPPED_DEGREES};
use chladni_frf::{Error, Finding, Result};
use std::collections::{HashMap, VecDeque};

/// The columns of one FRF.
pub(super) struct Group {
    pub(super) first: usize,
    pub(super) second: usize,
    /// True for magnitude and phase, false for real and imaginary part.
    pub(super) polar: bool,
    pub(super) coherence: Option<usize>,
}

/// Columns that have no partner yet.
struct Partners<'a> {
    heads: &'a [ColumnHeader],
    used: Vec<bool>,
    /// The columns of each part and base, in their order.
    waiting: HashMap<(Part, &'a str), VecDeque<usize>>,
}

impl<'a> Partners<'a> {
    fn new(heads: &'a [ColumnHeader]) -> Self {
        let mut waiting: HashMap<_, VecDeque<usize>> = HashMap::new();
        for (column, head) in heads.iter().enumerate().skip(1) {
            let key = (head.part, head.base.as_str());
            waiting.entry(key).or_default().push_back(column);
        }
        let mut used = vec![false; heads.len()];
        used[0] = true;
        Self {
            heads,
            used,
            waiting,
        }
    }

    /// Takes the partner of `column`: a column of the same base, else the next one where one
    /// of the two has no base.
    fn take(&mut self, wanted: Part, column: usize) -> Option<usize> {
        let used = &self.used;
        let base = self.heads[column].base.as_str();
        let named = self.waiting.get_mut(&(wanted, base)).and_then(|queue| {
            while queue.front().is_some_and(|&other| used[other]) {
                queue.pop_front();
            }
            queue.pop_front()
        });
        let beside = Some(column + 1).filter(|&other| {
            other < self.heads.len()
                && !self.used[other]
                && self.heads[other].part == wanted
                && (base.is_empty() || self.heads[other].base.is_empty())
        });
        let found = named.or(beside)?;
        self.used[found] = true;
        Some(found)
    }
}

/// The columns of every FRF.
///
/// # Errors
/// A column without its partner; one whose name does not tell its content.
pub(super) fn group_columns(
    table: &Table,
    heads: &[ColumnHeader],
    warnings: &mut Vec<Finding>,
) -> Result<Vec<Group>> {
    let mut groups: Vec<Group> = Vec::new();
    let mut partners = Partners::new(heads);
    let some_are_known = heads[1..]
        .iter()
        .any(|head| !matches!(head.part, Part::Unknown | Part::Coherence));
    for column in 1..heads.len() {
        if partners.used[column] {
            continue;
        }
        partners.used[column] = true;
        let (wanted, polar, column_is_first) = match heads[column].part {
            Part::Re => (Part::Im, false, true),
            Part::Im => (Part::Re, false, false),
            Part::Magnitude => (Part::Phase, true, true),
            Part::Phase => (Part::Magnitude, true, false),
            Part::Unknown if some_are_known => return Err(unknown_column(table, column)),
            Part::Unknown => (Part::Unknown, false, true),
            Part::Coherence => continue, // below
        };
        let other = partners.take(wanted, column).ok_or_else(|| {
            match heads.get(column + 1).map(|next| next.part) {
                Some(Part::Unknown) if wanted != Part::Unknown => unknown_column(table, column + 1),
                _ => unpaired(table, column, partner_name(wanted)),
            }
        })?;
        let polar = if wanted == Part::Unknown {
            unnamed_pair_is_polar(table, column, other, warnings)?
        } else {
            polar
        };
        let (first, second) = if column_is_first {
            (column, other)
        } else {
            (other, column)
        };
        groups.push(Group {
            first,
            second,
            polar,
            coherence: None,
        });
    }
    if groups.is_empty() {
        return Err(Error::bad_data("no FRF beside the frequency column")
            .found(format!("{} columns", table.columns))
            .expected("f,re,im or f,mag,phase")
            .help("export the values beside the frequencies"));
    }
    refuse_two_forms(table, heads, &groups)?;
    attach_coherence(table, heads, &mut groups)?;
    Ok(groups)
}

/// Attaches each column of coherence to the FRF of its name, else to the only FRF before it
/// without coherence. Columns that are left go to the FRFs that are left in their order, if
/// there are as many.
fn attach_coherence(table: &Table, heads: &[ColumnHeader], groups: &mut [Group]) -> Result<()> {
    let mut left = Vec::new();
    for column in (1..heads.len()).filter(|&column| heads[column].part == Part::Coherence) {
        let head = &heads[column];
        let is_owner = |group: &Group| {
            let first = &heads[group.first];
            !head.base.is_empty() && head.base == first.base && head.dofs == first.dofs
        };
        let open = |group: &&mut Group| group.coherence.is_none();
        let owner = match groups
            .iter()
            .position(|group| group.coherence.is_none() && is_owner(group))
        {
            Some(at) => Some(&mut groups[at]),
            None => {
                let mut before = groups
                    .iter_mut()
                    .filter(|group| group.first.max(group.second) < column)
                    .filter(open);
                let last = before.next_back();
                last.filter(|_| before.next_back().is_none())
            }
        };
        match owner {
            Some(owner) => owner.coherence = Some(column),
            None => left.push(column),
        }
    }
    let open: Vec<_> = groups
        .iter_mut()
        .filter(|group| group.coherence.is_none())
        .collect();
    match left.first() {
        Some(&first) if open.len() != left.len() => Err(unpaired(
            table,
            first,
            "one FRF that it belongs to, by its name or its place",
        )),
        _ => {
            for (group, column) in open.into_iter().zip(left) {
                group.coherence = Some(column);
            }
            Ok(())
        }
    }
}

/// Refuses an FRF that seems to occur twice, as real and imaginary part and as magnitude
/// and phase.
fn refuse_two_forms(table: &Table, heads: &[ColumnHeader], groups: &[Group]) -> Result<()> {
    let mut forms: HashMap<&str, bool> = HashMap::new();
    for group in groups {
        let base = heads[group.first].base.as_str();
        if *forms.entry(base).or_insert(group.polar) != group.polar
            && table.keyword("y axis type", group.first).is_none()
        {
            return Err(Error::bad_data(
                "one FRF occurs twice, as real and imaginary part and as magnitude and phase",
            )
            .field(format!("column {}", group.first + 1))
            .found(&table.names[group.first])
            .expected("two columns for each FRF")
            .help("leave one of the two pairs out, or name the FRFs by their DOFs"));
        }
    }
    Ok(())
}

fn unknown_column(table: &Table, column: usize) -> Error {
    Error::bad_data("a column whose name does not say what it holds")
        .field(format!("column {}", column + 1))
        .found(&table.names[column])
        .expected("re, im, mag, phase or coherence in its name")
        .help("name it, or leave the column out")
}

fn partner_name(part: Part) -> &'static str {
    match part {
        Part::Im => "an imaginary part",
        Part::Re => "a real part",
        Part::Phase => "a phase",
        Part::Magnitude => "a magnitude",
        _ => "a second column, one pair per FRF",
    }
}

fn unpaired(table: &Table, column: usize, expected: &str) -> Error {
    let name = if table.names[column].is_empty() {
        "without a name"
    } else {
        &table.names[column]
    };
    Error::bad_data("a column without its partner")
        .field(format!("column {}", column + 1))
        .found(name)
        .expected(expected)
        .help(
            "one FRF needs two columns: real and imaginary part, or magnitude and phase; name \
               them in a header line like f,re,im",
        )
}

/// True where two columns without telling names are magnitude and phase: a keyword decides.
/// Without one, the numbers must exclude magnitude and phase, linear or in decibels.
///
/// A real part changes its sign over a band. So do decibels, but they stay below some
/// hundreds. Numbers up to 1 are no phase. Neither are numbers beyond 360 that leap by more
/// than half a turn from line to line: an unwrapped phase does not.
fn unnamed_pair_is_polar(
    table: &Table,
    column: usize,
    other: usize,
    warnings: &mut Vec<Finding>,
) -> Result<bool> {
    if let Some(kind) = table.keyword("y axis type", column) {
        let kind = kind.to_lowercase();
        if kind.starts_with("mag") {
            return Ok(true);
        }
        if kind.starts_with("real") {
            return Ok(false);
        }
    }
    let (first, second) = (table.column(column), table.column(other));
    let largest = |values: &[f64]| {
        values
            .iter()
            .fold(0.0_f64, |most, value| most.max(value.abs()))
    };
    let changes_sign = first.iter().any(|value| *value < 0.0) && first.iter().any(|v| *v > 0.0);
    let leaps = (second.windows(2)).any(|pair| (pair[1] - pair[0]).abs() > WRAPPED_DEGREES / 2.0);
    let is_no_decibel = largest(&first) > LARGEST_DECIBELS;
    let is_no_phase =
        largest(&second) <= 1.0 || (largest(&second) > WRAPPED_DEGREES && (leaps || is_no_decibel));
    let header_hints = ["mag", "phase", "ampl", "abs", "db"]
        .iter()
        .any(|word| table.header_text.to_lowercase().contains(word));
    if header_hints || !changes_sign || !is_no_phase {
        return Err(Error::bad_data(
            "the columns may be magnitude and phase, or real and imaginary part",
        )
        .field(format!("columns {} and {}", column + 1, other + 1))
        .found(if table.is_nameless() {
            "no column names".to_owned()
        } else {
            table.names[column].clone()
        })
        .expected("names that say which")
        .help("put a header line above the numbers: f,re,im or f,mag,phase"));
    }
    push_once(
        warnings,
        Finding::caution(
            "layout-guessed",
            "column names do not say what the pairs of columns are: taken as real and imaginary \
             part",
        ),
    );
    Ok(false)
}
