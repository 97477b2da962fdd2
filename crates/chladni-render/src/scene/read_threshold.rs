//! The table `[threshold]`.

use super::beside::Beside;
use super::keys::KEYS;
use crate::scene::threshold::{Threshold, ThresholdTable};
use crate::tolerances;
use chladni_frf::{nearest_word, Result};
use chladni_text::toml_reader::{Table, Value};
use std::path::Path;

/// Difference limen on each side of the threshold, dB, where the scene gives none.
pub const DEFAULT_LIMEN_DB: f64 = 2.0;

pub(super) fn read_threshold(table: &Table, beside: Beside) -> Result<(Threshold, f64)> {
    table.only_keys(KEYS, "threshold")?;
    let threshold = match table.get("profile") {
        Some(value) => read_profile(&value, beside)?,
        None => Threshold::Paper,
    };
    let limen_db = table
        .get("limen_db")
        .map_or(Ok(DEFAULT_LIMEN_DB), |value| {
            value.not_negative()?;
            decibels(&value)
        })?;
    Ok((threshold, limen_db))
}

fn read_profile(value: &Value, beside: Beside) -> Result<Threshold> {
    let name = value.string()?;
    match (Threshold::built_in(name), beside) {
        (Some(profile), _) => Ok(profile),
        (None, Beside::Folder(folder)) => read_table(value, &folder.join(name)),
        (None, Beside::Tables(tables)) => {
            let same_name = |table: &&ThresholdTable| table.file.as_os_str() == name;
            let table = tables.iter().find(same_name).cloned();
            table.map(Threshold::Table).ok_or_else(|| {
                value
                    .error(
                        "no such threshold profile, and no file is looked for here",
                        Threshold::NAMES.join(", "),
                    )
                    .help("a table of your own is sent along as text, under the name that stands here")
            })
        }
    }
}

fn read_table(value: &Value, file: &Path) -> Result<Threshold> {
    if file.exists() {
        return Ok(Threshold::Table(ThresholdTable::read(file)?));
    }
    let (name, known) = (value.string()?, Threshold::NAMES);
    let expected = format!("{} or the path of a CSV file", known.join(", "));
    Err(match looks_like_file(name) {
        true => value
            .error("no such file", expected)
            .help("correct the path; it is taken relative to the scene file"),
        false => value
            .error("neither a threshold profile nor a file", expected)
            .help(format!(
                "did you mean `{}`? A path is taken relative to the scene file",
                nearest_word(name, &known).unwrap_or_default()
            )),
    })
}

/// True for a text with a separator or an extension, which names of profiles do not have.
fn looks_like_file(name: &str) -> bool {
    name.contains(['/', '\\']) || Path::new(name).extension().is_some()
}

pub(super) fn decibels(value: &Value) -> Result<f64> {
    match value.number()? {
        level if level.abs() <= tolerances::MOST_DB => Ok(level),
        _ => Err(value.error(
            "too many decibels",
            format!("a level between -{0} and {0} dB", tolerances::MOST_DB),
        )),
    }
}
