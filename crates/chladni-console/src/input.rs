//! Reading: the options that all commands share which read FRFs, and the files behind a
//! result.

use crate::console::Console;
use crate::oddities;
use crate::quoting::shell_word;
use chladni_frf::{Error, FrfKind, FrfSet, ModalModel, Result, Source, TimeSign};
use chladni_io::PhaseUnit;
use chladni_io::{detect_format, Duplicates, FileFormat, ReadOptions};
use chladni_render::Weights;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde_json::{Map, Value};
use std::path::{Path, PathBuf};

/// How FRFs are to be read.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Reading FRFs")]
pub struct Reading {
    /// What the FRFs are; needed where the file does not say
    #[arg(long, value_name = "KIND", value_parser = PossibleValuesParser::new(["mobility", "receptance", "accelerance"])
        .try_map(|text| text.parse::<FrfKind>()))]
    pub frf_kind: Option<FrfKind>,
    /// Sign in e^(±jωt) of the data
    #[arg(long, value_name = "SIGN", allow_hyphen_values = true,
        value_parser = PossibleValuesParser::new(["+", "-"]).try_map(|text| text.parse::<TimeSign>()))]
    pub time_sign: Option<TimeSign>,
    /// Reference node of files that hold one reference: one for all files, or one for
    /// each, in their order
    #[arg(
        long,
        value_name = "N",
        value_delimiter = ',',
        allow_negative_numbers = true
    )]
    pub reference: Vec<u64>,
    /// Where the arrays of a foreign HDF5 file are: frf=/data/H,freq=/data/f
    #[arg(long, value_name = "NAME=PATH", value_delimiter = ',', value_parser = parse_map)]
    pub map: Vec<(String, String)>,
    /// What to do with a pair (response, reference) that occurs twice
    #[arg(long, value_name = "WHICH", value_parser = PossibleValuesParser::new(["error", "first", "last", "mean"]).map(duplicates))]
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

fn parse_map(text: &str) -> std::result::Result<(String, String), String> {
    match text.split_once('=') {
        Some((name, path)) if !name.trim().is_empty() && !path.trim().is_empty() => {
            Ok((name.trim().into(), path.trim().into()))
        }
        _ => Err("no entry NAME=PATH, as in frf=/data/H,freq=/data/f".into()),
    }
}

fn duplicates(name: String) -> Duplicates {
    match name.as_str() {
        "first" => Duplicates::First,
        "last" => Duplicates::Last,
        "mean" => Duplicates::Mean,
        _ => Duplicates::Error,
    }
}

impl Reading {
    /// The options as the library takes them.
    pub fn options(&self) -> ReadOptions {
        ReadOptions {
            frf_kind: self.frf_kind,
            time_sign: self.time_sign.unwrap_or_default(),
            references: self.reference.clone(),
            map: self.map.clone(),
            duplicates: self.duplicates.unwrap_or_default(),
            phase_unit: self.phase_unit,
            snap_df: self.snap_df,
            lenient: self.lenient,
        }
    }

    /// The options that were given, for the result's `options`: each can change what is
    /// read.
    pub fn echo(&self, options: &mut Map<String, Value>) {
        let mut add = |name: &str, value: Value| drop(options.insert(name.to_owned(), value));
        if let Some(kind) = self.frf_kind {
            add("frf_kind", kind.as_str().into());
        }
        if self.time_sign == Some(TimeSign::Minus) {
            add("time_sign", "-".into());
        }
        if !self.reference.is_empty() {
            add("reference", self.reference.clone().into());
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

    /// The options that were given, as on a command line of a shell.
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
            Value::Bool(_) => format!("--{}", name.replace('_', "-")),
            value => format!("--{} {}", name.replace('_', "-"), shell_word(words(value))),
        };
        echoed.iter().map(flag).collect()
    }

    /// The options that [`Self::echo`] left in a result.
    pub fn from_echo(options: &Map<String, Value>) -> Self {
        let text = |name: &str| options.get(name).and_then(Value::as_str);
        let given = |name: &str| options.get(name).and_then(Value::as_bool).unwrap_or(false);
        let map = options
            .get("map")
            .and_then(Value::as_object)
            .into_iter()
            .flatten();
        Self {
            frf_kind: text("frf_kind").and_then(|kind| kind.parse().ok()),
            time_sign: text("time_sign").and_then(|sign| sign.parse().ok()),
            reference: options
                .get("reference")
                .and_then(Value::as_array)
                .into_iter()
                .flatten()
                .filter_map(Value::as_u64)
                .collect(),
            map: map
                .filter_map(|(name, path)| Some((name.clone(), path.as_str()?.to_owned())))
                .collect(),
            duplicates: text("duplicates").map(|name| duplicates(name.to_owned())),
            phase_unit: text("phase_unit").and_then(|unit| unit.parse().ok()),
            snap_df: given("snap_df"),
            lenient: given("lenient"),
        }
    }
}

/// The files behind paths, folders and patterns; what a folder holds besides is named in
/// a warning.
///
/// # Errors
/// Those of [`chladni_io::expand_paths`].
pub fn expand(paths: &[PathBuf], console: &Console) -> Result<Vec<PathBuf>> {
    let inputs = chladni_io::expand_paths(paths)?;
    console.warn_all(inputs.warnings);
    Ok(inputs.files)
}

/// The FRFs of files as one set, whose kind is known.
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
    console.warn_all(oddities::of_set(&frf));
    frf.known_kind().map_err(|error| error.file(&files[0]))?;
    Ok((frf, sources))
}

/// Warnings about files, which they name without their folders: results are the same
/// wherever the files lie.
pub fn warn_of_files(files: &[PathBuf], warnings: Vec<String>, console: &Console) {
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
    for warning in warnings {
        console.warn(
            folders
                .iter()
                .fold(warning, |warning, folder| warning.replace(folder, "")),
        );
    }
}

/// Name and content of an input, for the result's `source`.
///
/// # Errors
/// Those of reading.
pub fn source(path: &Path) -> Result<Source> {
    Ok(Source {
        file: chladni_text::file_name(path),
        sha256: chladni_io::sha256_of(path)?,
    })
}

/// The model in a file; `None` where it holds measured data instead.
///
/// # Errors
/// Those of reading; a weights file.
pub fn model_of(file: &Path) -> Result<Option<ModalModel>> {
    match detect_format(file)? {
        FileFormat::Uff
        | FileFormat::Csv
        | FileFormat::Matlab
        | FileFormat::Numpy
        | FileFormat::Wav => Ok(None),
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
