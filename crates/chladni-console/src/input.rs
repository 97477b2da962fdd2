//! Reading: the options shared by all commands that read FRFs, and the sources of results.

use crate::console::Console;
use crate::limits::DELAY_MOST_S;
use crate::oddities;
use crate::quoting::{shell_path, shell_word};
use chladni_frf::{Error, Finding, FrfKind, FrfSet, ModalModel, Result, Source, TimeSign};
use chladni_io::{detect_format, DeclaredDofs, Duplicates, FileFormat, PhaseUnit, ReadOptions};
use chladni_render::Weights;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde_json::{Map, Value};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// Options of reading FRFs.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Reading FRFs")]
pub struct Reading {
    /// What the FRFs are; needed where the file does not say
    #[arg(long, value_name = "KIND", env = "CHLADNI_FRF_KIND", hide_env_values = true, value_parser = PossibleValuesParser::new(["mobility", "receptance", "accelerance"])
        .try_map(|text| text.parse::<FrfKind>()))]
    pub frf_kind: Option<FrfKind>,
    /// Sign in e^(±jωt) of the data
    #[arg(long, value_name = "SIGN", allow_hyphen_values = true,
        value_parser = PossibleValuesParser::new(["+", "-"]).try_map(|text| text.parse::<TimeSign>()))]
    pub time_sign: Option<TimeSign>,
    /// Delay of all responses against the references, s: it is taken off
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true, value_parser = parse_delay)]
    pub delay: Option<f64>,
    /// Reference node of files that hold one reference: one for all files, or one for
    /// each, in their order
    #[arg(
        long,
        value_name = "N",
        value_delimiter = ',',
        allow_negative_numbers = true
    )]
    pub reference: Vec<u64>,
    /// Response node of files that hold one response (a roving hammer): one for all files,
    /// or one for each, in their order
    #[arg(
        long,
        value_name = "N",
        value_delimiter = ',',
        allow_negative_numbers = true
    )]
    pub response: Vec<u64>,
    /// List of the DOFs of all FRFs in their order: rows response,reference or
    /// file,response,reference
    #[arg(long, value_name = "FILE", value_parser = read_dofs)]
    pub dofs: Option<DofFile>,
    /// Where the arrays of a foreign HDF5 file are: frf=/data/H,freq=/data/f
    #[arg(long, value_name = "NAME=PATH", value_delimiter = ',', value_parser = parse_map)]
    pub map: Vec<(String, String)>,
    /// What to do with a pair (response, reference) that occurs twice
    #[arg(long, value_name = "WHICH", value_parser = PossibleValuesParser::new(["error", "first", "last", "mean"])
        .try_map(|text| text.parse::<Duplicates>()))]
    pub duplicates: Option<Duplicates>,
    /// Unit of phases in tables and arrays; needed where neither header nor numbers say
    #[arg(long, value_name = "UNIT", value_parser = PossibleValuesParser::new(["deg", "rad"]).try_map(|text| text.parse::<PhaseUnit>()))]
    pub phase_unit: Option<PhaseUnit>,
    /// Take the exact line spacing that the six printed digits of a universal file stand
    /// for
    #[arg(long)]
    pub snap_df: bool,
    /// Mask or leave out what cannot be read instead of refusing the file
    #[arg(long)]
    pub lenient: bool,
}

/// A list of DOFs with the name of its file.
#[derive(Debug, Clone, PartialEq)]
pub struct DofFile {
    name: String,
    list: DeclaredDofs,
}

fn read_dofs(path: &str) -> Result<DofFile> {
    let path = Path::new(path);
    Ok(DofFile {
        name: path.display().to_string(),
        list: DeclaredDofs::read(path)?,
    })
}

impl DofFile {
    /// The file.
    pub fn path(&self) -> &Path {
        Path::new(&self.name)
    }

    /// True where the list comes from the standard input.
    pub fn is_standard_input(&self) -> bool {
        self.name == "-"
    }

    /// The rows as in such a file.
    fn rows(&self) -> impl Iterator<Item = String> + '_ {
        self.list.rows.iter().map(|row| {
            let file = row
                .file
                .as_ref()
                .map_or(String::new(), |file| format!("{file},"));
            format!("{file}{},{}", row.response, row.reference)
        })
    }
}

fn parse_delay(text: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds.abs() <= DELAY_MOST_S => Ok(seconds),
        _ => Err(format!(
            "not a number of seconds from -{DELAY_MOST_S} to {DELAY_MOST_S}"
        )),
    }
}

fn parse_map(text: &str) -> std::result::Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, path)) if !name.trim().is_empty() && !path.trim().is_empty() => {
            Ok((name.trim().into(), path.trim().into()))
        }
        _ => Err("no entry NAME=PATH, as in frf=/data/H,freq=/data/f".into()),
    }
}

impl Reading {
    /// The options of the reading library.
    pub fn options(&self) -> ReadOptions {
        ReadOptions {
            frf_kind: self.frf_kind,
            time_sign: self.time_sign.unwrap_or_default(),
            delay_s: self.delay.unwrap_or_default(),
            references: self.reference.clone(),
            responses: self.response.clone(),
            dofs: self.dofs.clone().map(|file| file.list).unwrap_or_default(),
            map: self.map.clone(),
            duplicates: self.duplicates.unwrap_or_default(),
            phase_unit: self.phase_unit,
            snap_df: self.snap_df,
            lenient: self.lenient,
            ..ReadOptions::default()
        }
    }

    /// Adds the given options to the `options` of a result: each can change the FRFs.
    pub fn echo(&self, options: &mut Map<String, Value>) {
        let mut add = |name: &str, value: Value| drop(options.insert(name.to_owned(), value));
        if let Some(kind) = self.frf_kind {
            add("frf_kind", kind.as_str().into());
        }
        if self.time_sign == Some(TimeSign::Minus) {
            add("time_sign", "-".into());
        }
        if let Some(seconds) = self.delay {
            add("delay", seconds.into());
        }
        if !self.reference.is_empty() {
            add("reference", self.reference.clone().into());
        }
        if !self.response.is_empty() {
            add("response", self.response.clone().into());
        }
        if let Some(file) = &self.dofs {
            add("dofs", file.rows().collect::<Vec<_>>().into());
        }
        if !self.map.is_empty() {
            add(
                "map",
                self.map
                    .iter()
                    .map(|(name, path)| (name.clone(), path.clone().into()))
                    .collect::<Map<_, _>>()
                    .into(),
            );
        }
        if let Some(which) = self.duplicates {
            add("duplicates", format!("{which:?}").to_lowercase().into());
        }
        if let Some(unit) = self.phase_unit {
            add("phase_unit", unit.as_str().into());
        }
        for (name, given) in [("snap_df", self.snap_df), ("lenient", self.lenient)] {
            if given {
                add(name, true.into());
            }
        }
    }

    /// The given options, as on a command line of a shell.
    pub fn flags(&self) -> Vec<String> {
        let mut echoed = Map::new();
        self.echo(&mut echoed);
        let plain = |value: &Value| {
            value
                .as_str()
                .map_or_else(|| value.to_string(), str::to_owned)
        };
        let words = |value: &Value| match value {
            Value::Array(list) => list.iter().map(plain).collect::<Vec<_>>().join(","),
            Value::Object(map) => map
                .iter()
                .map(|(name, path)| format!("{name}={}", plain(path)))
                .collect::<Vec<_>>()
                .join(","),
            other => plain(other),
        };
        let flag = |(name, value): (&String, &Value)| match value {
            // the option names the file, not its rows
            Value::Array(_) if name == "dofs" => {
                let name = self.dofs.as_ref().map_or("", |file| file.name.as_str());
                format!("--dofs {}", shell_path(Path::new(name)))
            }
            Value::Bool(_) => format!("--{}", name.replace('_', "-")),
            value => format!("--{} {}", name.replace('_', "-"), shell_word(words(value))),
        };
        echoed.iter().map(flag).collect()
    }

    /// The options from the `options` of a result, where [`Self::echo`] put them.
    pub fn from_echo(options: &Map<String, Value>) -> Self {
        let text = |name: &str| options.get(name).and_then(Value::as_str);
        let given = |name: &str| options.get(name).and_then(Value::as_bool).unwrap_or(false);
        let map = options
            .get("map")
            .and_then(Value::as_object)
            .into_iter()
            .flatten();
        let list = |name: &str| {
            options
                .get(name)
                .and_then(Value::as_array)
                .into_iter()
                .flatten()
        };
        let rows: Vec<&str> = list("dofs").filter_map(Value::as_str).collect();
        let dofs = DeclaredDofs::parse(&rows.join("\n"))
            .ok()
            .map(|list| DofFile {
                name: String::new(),
                list,
            });
        Self {
            frf_kind: text("frf_kind").and_then(|kind| kind.parse().ok()),
            time_sign: text("time_sign").and_then(|sign| sign.parse().ok()),
            delay: options.get("delay").and_then(Value::as_f64),
            reference: list("reference").filter_map(Value::as_u64).collect(),
            response: list("response").filter_map(Value::as_u64).collect(),
            dofs,
            map: map
                .filter_map(|(name, path)| Some((name.clone(), path.as_str()?.to_owned())))
                .collect(),
            duplicates: text("duplicates").and_then(|name| name.parse().ok()),
            phase_unit: text("phase_unit").and_then(|unit| unit.parse().ok()),
            snap_df: given("snap_df"),
            lenient: given("lenient"),
        }
    }
}

/// The files of paths, folders and patterns; warnings name the other files of a folder.
///
/// # Errors
/// Those of [`chladni_io::expand_paths`].
pub fn expand(paths: &[PathBuf], console: &Console) -> Result<Vec<PathBuf>> {
    let inputs = chladni_io::expand_paths(paths)?;
    console.find_all(&inputs.warnings);
    Ok(inputs.files)
}

/// The FRFs of files as one set, and the sources. The kind of the FRFs is known.
///
/// # Errors
/// Those of reading; [`chladni_frf::ErrorKind::UnknownFrfKind`].
pub fn read_frf(
    files: &[PathBuf],
    reading: &Reading,
    console: &Console,
) -> Result<(FrfSet, Vec<Source>)> {
    console.stage("reading FRFs");
    let (frf, sources, warnings) = chladni_io::read_frf(files, &reading.options())?;
    warn_of_files(files, warnings, console);
    console.find_all(&oddities::of_set(&frf));
    frf.known_kind().map_err(|error| error.file(&files[0]))?;
    Ok((frf, sources))
}

/// Adds findings about files. Their texts name files without folders, so that results do not
/// depend on where the files are.
pub fn warn_of_files(files: &[PathBuf], findings: Vec<Finding>, console: &Console) {
    let folders: Vec<String> = files
        .iter()
        .flat_map(|file| {
            [
                Some(file.as_path()).filter(|file| file.is_dir()),
                file.parent(),
            ]
        })
        .flatten()
        .map(|folder| format!("{}/", folder.display().to_string().trim_end_matches('/')))
        .filter(|folder| folder.len() > 1)
        .collect();
    for finding in told_once(files, findings) {
        let text = folders.iter().fold(finding.text.clone(), |text, folder| {
            text.replace(folder, "")
        });
        console.find(&Finding { text, ..finding });
    }
}

/// The findings, those of several files in the same words merged into one with their number.
fn told_once(files: &[PathBuf], findings: Vec<Finding>) -> Vec<Finding> {
    let names: HashSet<String> = files
        .iter()
        .map(|file| file.display().to_string())
        .collect();
    let words = |finding: &Finding| {
        let (name, words) = finding.text.split_once(": ")?;
        names.contains(name).then(|| words.to_owned())
    };
    let mut counts: HashMap<String, usize> = HashMap::new();
    for words in findings.iter().filter_map(words) {
        *counts.entry(words).or_default() += 1;
    }
    let once = |finding: Finding| match words(&finding) {
        None => Some(finding),
        // the first of them takes the count, the others find none
        Some(words) => match counts.remove(&words)? {
            1 => Some(finding),
            count => Some(Finding {
                text: format!("{} (and {} more files)", finding.text, count - 1),
                ..finding
            }),
        },
    };
    findings.into_iter().filter_map(once).collect()
}

/// Name and content of an input, for the result's `source`.
///
/// # Errors
/// Those of reading.
pub fn source(path: &Path) -> Result<Source> {
    Ok(Source {
        file: chladni_text::file_name(path),
        checksum: chladni_io::checksum_of(path)?,
    })
}

/// The model in a file; `None` where it holds measured data instead.
///
/// # Errors
/// Those of reading; a weights file.
pub fn model_of(file: &Path) -> Result<Option<ModalModel>> {
    match detect_format(file)? {
        FileFormat::Model => chladni_io::read_model(file).map(Some),
        FileFormat::Hdf5 => match chladni_io::read_model(file) {
            Ok(model) => Ok(Some(model)),
            Err(error) if error.field.as_deref() == Some("/model") => Ok(None),
            Err(error) => Err(error),
        },
        FileFormat::Weights => Err(Error::bad_data(
            "weights are neither measured data nor a model",
        )
        .file(file)
        .found("a weights file")
        .expected("FRFs or a model")
        .help("give the data or the model that the weights belong to")),
        _ => Ok(None),
    }
}

/// Reads a weights file.
///
/// # Errors
/// Those of reading.
pub fn read_weights(file: &Path) -> Result<Weights> {
    Weights::parse(&chladni_text::read_text(file, "a weights file, JSON")?)
        .map_err(|error| error.file(file))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copied_command_runs_nothing_of_the_name_of_a_list() {
        let rows = serde_json::json!({"dofs": ["1:+Z,2:+Z"]});
        let mut reading = Reading::from_echo(rows.as_object().unwrap());
        reading.dofs.as_mut().unwrap().name = "; touch X".into();
        assert_eq!(reading.flags(), ["--dofs '; touch X'"]);
    }
}
