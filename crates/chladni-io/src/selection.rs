//! The selection file: modes kept or dropped by hand.
//!
//! ```toml
//! drop = [3, 7]        # numbers as in the table of modes, from 1; `keep = [...]` instead: all others go;
//!                      # `keep = "sure"`: all weak ones go
//!
//! [[mode]]             # one more of them, by its frequency
//! near_hz = 54.4
//! within_hz = 0.5
//! ```
//!
//! With `[[mode]]` tables alone, these modes are kept. `add = [{frequency_hz = 123.4}]`
//! fits anew with a mode there, beside the others; it may stand alone.

use chladni_frf::{Error, ModeName, ModePick, Result, Selection};
use chladni_text::read_text;
use chladni_text::toml_reader::{parse, Keys, Table, Value};
use std::path::Path;

const KEYS: Keys = &[
    ("", &["keep", "drop", "mode", "add"]),
    ("mode[]", &["near_hz", "within_hz"]),
    ("add[]", &["frequency_hz"]),
];

/// Value of `keep` that keeps all sure modes.
const SURE: &str = "sure";

/// Reads a selection file.
///
/// # Errors
/// As [`selection_from_toml`], with the file's name; also a file that cannot be read.
pub fn read_selection(file: &Path) -> Result<Selection> {
    let text = read_text(file, "a selection of modes as TOML")?;
    selection_from_toml(&text).map_err(|error| error.file(file))
}

/// Reads a selection.
///
/// # Errors
/// [`chladni_frf::ErrorKind::BadData`] with line and key: no TOML, an unknown key, `keep`
/// and `drop` together, no mode named, a number that is no mode number.
pub fn selection_from_toml(text: &str) -> Result<Selection> {
    let document = parse(text)?;
    let root = Table::root(text, &document);
    root.only_keys(KEYS, "")?;
    let (keep, drop) = (root.get("keep"), root.get("drop"));
    if let (Some(_), Some(drop)) = (&keep, &drop) {
        return Err(drop
            .error("a selection either keeps or drops", "one of keep and drop")
            .help("a mode that is not kept is dropped: leave one of the two lists out"));
    }
    let kept = drop.is_none();
    let mut picks = Vec::new();
    let all_sure = keep.as_ref().filter(|value| value.is_string());
    if let Some(value) = all_sure {
        if value.string()? != SURE {
            return Err(value.error("no such modes", "a list of numbers, or \"sure\""));
        }
        picks.push(ModePick {
            name: ModeName::Sure,
            line: value.line(),
            field: "keep".into(),
        });
    }
    let numbers = keep.or(drop).filter(|value| !value.is_string() || !kept);
    for (place, value) in items(numbers)?.enumerate() {
        let field = format!("{}[{}]", if kept { "keep" } else { "drop" }, place + 1);
        picks.push(ModePick {
            name: ModeName::Number(value.count()?),
            line: value.line(),
            field,
        });
    }
    for (place, value) in items(root.get("mode"))?.enumerate() {
        picks.push(by_frequency(&value, place + 1)?);
    }
    let added_hz = added(&root)?;
    if picks.is_empty() && !added_hz.is_empty() {
        // no mode is dropped
        return Ok(Selection::new(false, picks).adding(added_hz));
    }
    if picks.is_empty() {
        return Err(Error::bad_data("the selection names no mode")
            .found("no number and no frequency")
            .expected(
                "keep = [1, 2, ...], drop = [3, ...], [[mode]] tables with near_hz and \
                 within_hz, or add = [{frequency_hz = ...}]",
            )
            .help("the modes in the band are numbered from 1, in the order of the model"));
    }
    Ok(Selection::new(kept, picks).adding(added_hz))
}

/// Frequencies of the modes to add, Hz.
fn added(root: &Table) -> Result<Vec<f64>> {
    let of = |value: &Value| {
        let table = value.table()?;
        table.only_keys(KEYS, "add[]")?;
        table
            .require("frequency_hz", "where a mode was seen, Hz")?
            .positive()
    };
    items(root.get("add"))?.map(|value| of(&value)).collect()
}

/// The values of a list; empty where there is no list.
fn items<'a>(list: Option<Value<'a>>) -> Result<impl Iterator<Item = Value<'a>>> {
    let values = list.map(|list| list.list()).transpose()?;
    Ok(values.into_iter().flatten())
}

fn by_frequency(value: &Value, place: usize) -> Result<ModePick> {
    let table = value.table()?;
    table.only_keys(KEYS, "mode[]")?;
    let near_hz = table
        .require("near_hz", "the frequency of a mode, Hz")?
        .positive()?;
    let within_hz = table
        .require("within_hz", "how far from near_hz the mode may lie, Hz")?
        .positive()?;
    Ok(ModePick {
        name: ModeName::Frequency { near_hz, within_hz },
        line: value.line(),
        field: format!("mode[{place}]"),
    })
}
