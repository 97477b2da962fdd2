//! Tables with a frequency column and a pair of columns per FRF: one FRF per file, wide,
//! named pairs.

use super::head::{dof_pair, frequency_factor, Head, Part};
use super::table::Table;
use super::Trace;
use crate::unit_label::{frequency_unit, frf_unit};
use chladni_frf::{Error, Result};
use num_complex::Complex64;

/// Frequencies in Hz and one trace per pair of columns.
pub(super) fn traces(table: &Table, warnings: &mut Vec<String>) -> Result<(Vec<f64>, Vec<Trace>)> {
    let heads: Vec<Head> = (0..table.columns)
        .map(|column| Head::parse(&table.names[column], &table.units[column]))
        .collect();
    let frequency_hz = frequency_axis(table)?;
    let mut traces: Vec<Trace> = Vec::new();
    for group in group_columns(table, &heads, warnings)? {
        traces.push(trace(table, &heads, &group)?);
    }
    Ok((frequency_hz, traces))
}

fn frequency_axis(table: &Table) -> Result<Vec<f64>> {
    let factor = match table.keyword("x axis units", 1) {
        Some(unit) => frequency_unit(unit),
        None => frequency_factor(&table.names[0], &table.units[0]),
    };
    let factor = factor.ok_or_else(|| {
        Error::bad_data("the first column is no frequency axis, or its unit is not said")
            .field("column 1")
            .found(
                format!("{} {}", table.names[0], table.units[0])
                    .trim()
                    .to_owned(),
            )
            .expected("a frequency in Hz, kHz or rad/s, with the unit in the header")
    })?;
    let raw = table.column(0);
    for (k, pair) in raw.windows(2).enumerate() {
        if pair[1] <= pair[0] {
            let what = if pair[1] == pair[0] {
                "a frequency stands twice"
            } else {
                "the frequency axis falls"
            };
            return Err(Error::bad_data(what)
                .at_line(table.lines[k + 1])
                .field("frequency")
                .found(format!("{} after {}", pair[1], pair[0]))
                .expected("strictly rising frequencies")
                .help(
                    "sort the rows, remove doubled ones; for several FRFs in one list use the \
                     columns node,dir,ref_node,ref_dir,f,re,im",
                ));
        }
    }
    Ok(raw.into_iter().map(|f| f * factor).collect())
}

/// Columns of one FRF, and whether they are magnitude and phase.
struct Group {
    first: usize,
    second: usize,
    polar: bool,
    coherence: Option<usize>,
}

fn group_columns(table: &Table, heads: &[Head], warnings: &mut Vec<String>) -> Result<Vec<Group>> {
    let mut groups: Vec<Group> = Vec::new();
    let mut used = vec![false; heads.len()];
    used[0] = true;
    for column in 1..heads.len() {
        if used[column] {
            continue;
        }
        used[column] = true;
        let partner = |wanted: Part, used: &[bool]| {
            let fits = |&other: &usize| !used[other] && heads[other].part == wanted;
            let beside = Some(column + 1)
                .filter(|other| *other < heads.len())
                .filter(|other| fits(other));
            let named = (column + 1..heads.len())
                .filter(|other| fits(other))
                .find(|&other| heads[other].base == heads[column].base);
            named.or(beside)
        };
        let (wanted, polar, column_is_first) = match heads[column].part {
            Part::Re => (Part::Im, false, true),
            Part::Im => (Part::Re, false, false),
            Part::Magnitude => (Part::Phase, true, true),
            Part::Phase => (Part::Magnitude, true, false),
            Part::Unknown => (Part::Unknown, false, true),
            Part::Coherence => {
                let mut open = groups
                    .iter_mut()
                    .rev()
                    .filter(|group| group.coherence.is_none());
                let owner = open
                    .next()
                    .ok_or_else(|| unpaired(table, column, "an FRF before it"))?;
                owner.coherence = Some(column);
                continue;
            }
        };
        let other =
            partner(wanted, &used).ok_or_else(|| unpaired(table, column, partner_name(wanted)))?;
        used[other] = true;
        let polar = if wanted == Part::Unknown {
            unnamed_pair_is_polar(table, column, warnings)?
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
            .expected("f,re,im or f,mag,phase"));
    }
    Ok(groups)
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

/// Columns whose names say nothing: a keyword decides, else the numbers must exclude
/// magnitude and phase.
fn unnamed_pair_is_polar(table: &Table, column: usize, warnings: &mut Vec<String>) -> Result<bool> {
    if let Some(kind) = table.keyword("y axis type", column) {
        let kind = kind.to_lowercase();
        if kind.starts_with("mag") {
            return Ok(true);
        }
        if kind.starts_with("real") {
            return Ok(false);
        }
    }
    let (first, second) = (table.column(column), table.column(column + 1));
    let largest = |values: &[f64]| {
        values
            .iter()
            .fold(0.0_f64, |most, value| most.max(value.abs()))
    };
    let like_magnitude = !first.iter().any(|value| *value < 0.0);
    let like_phase = largest(&second) <= 360.0 && largest(&second) > 4.0 * largest(&first);
    let header_hints = ["mag", "phase", "ampl", "abs", "db"]
        .iter()
        .any(|word| table.header_text.contains(word));
    if header_hints || (like_magnitude && like_phase) {
        return Err(Error::bad_data(
            "the columns may be magnitude and phase, or real and imaginary part",
        )
        .field(format!("columns {} and {}", column + 1, column + 2))
        .found(if table.is_nameless() {
            "no column names".to_owned()
        } else {
            table.names[column].clone()
        })
        .expected("names that say which")
        .help("put a header line above the numbers: f,re,im or f,mag,phase"));
    }
    let warning =
        "column names do not say what the pairs of columns are: taken as real and imaginary part";
    if !warnings.iter().any(|known| known == warning) {
        warnings.push(warning.into());
    }
    Ok(false)
}

fn trace(table: &Table, heads: &[Head], group: &Group) -> Result<Trace> {
    let (first, second) = (&heads[group.first], &heads[group.second]);
    let (a, b) = (table.column(group.first), table.column(group.second));
    let mut unit = first.frf_unit().or(table
        .keyword("y axis units", group.first)
        .and_then(frf_unit));
    let mut unit_text = if first.unit.is_empty() {
        table
            .keyword("y axis units", group.first)
            .unwrap_or("")
            .to_owned()
    } else {
        first.unit.clone()
    };
    let values: Vec<Complex64> = if group.polar {
        let to_radians = if second.is_radian() {
            1.0
        } else {
            1f64.to_radians()
        };
        let decibel = first.is_decibel();
        let reference = if decibel {
            let (reference, label) = first.decibel_reference().ok_or_else(|| {
                Error::bad_data("a magnitude in dB without its reference")
                    .field(format!("column {}", group.first + 1))
                    .found(
                        format!("{} {}", table.names[group.first], table.units[group.first])
                            .trim()
                            .to_owned(),
                    )
                    .expected("a header like `Magnitude [dB re 1 m/s/N]`")
                    .help(
                        "write the reference value and unit into the header, or export linear \
                           values",
                    )
            })?;
            unit = frf_unit(label).or(unit);
            unit_text = label.to_owned();
            reference
        } else {
            1.0
        };
        let magnitude = |value: f64| {
            if decibel {
                reference * 10f64.powf(value / 20.0)
            } else {
                value
            }
        };
        a.iter()
            .zip(&b)
            .map(|(&m, &phase)| Complex64::from_polar(magnitude(m), phase * to_radians))
            .collect()
    } else {
        a.iter()
            .zip(&b)
            .map(|(&re, &im)| Complex64::new(re, im))
            .collect()
    };
    let dofs = first.dofs.or(second.dofs).or_else(|| {
        table
            .keyword("y axis dofs", group.first)
            .and_then(|text| dof_pair(first_word(text)))
    });
    Ok(Trace {
        response: dofs.map(|(response, _)| response),
        reference: dofs.and_then(|(_, reference)| reference),
        values,
        coherence: group.coherence.map(|column| table.column(column)),
        unit,
        unit_text,
    })
}

/// `1Z:3Z [2]` without its set number.
fn first_word(text: &str) -> &str {
    text.split_whitespace().next().unwrap_or("")
}
