//! `chladni correct`: a drive corrected by measured fields.

use crate::blame::blame_field;
use crate::indices::{indices_table, weights_table};
use crate::render::{doubt, value_of, write_weights};
use chladni_console::input::{read_weights, source};
use chladni_console::output::{Output, WEIGHTS};
use chladni_console::table::{counted, significant};
use chladni_console::{Console, Outcome};
use chladni_frf::{Error, ErrorKind, ModalModel, Result, Source};
use chladni_io::{is_same_place, read_field, read_model, sha256_of};
use chladni_render::{
    calibrate, Calibration, Correction, PlayedField, RenderOptions, Scene, Weights,
};
use serde_json::{json, Value};
use std::path::{Path, PathBuf};

/// Arguments of `correct`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni correct model.json corner.toml --weights w0.json --field scan0.csv -o w1.json
  chladni correct model.json corner.toml --weights w0.json --field scan0.csv --weights w1.json --field scan1.csv -o w2.json
  chladni correct model.json corner.toml --weights w0.json --field scan0.csv -o w1.json --calibration rig.json
      the next scene starts corrected with `calibration = \"rig.json\"` under [actuators]

A field is a table response,re,im[,std] or response,magnitude[,std] under the lines `# frequency_hz = ...` and
`# unit = m/s`; some of the responses are enough.")]
pub struct Args {
    /// Model file that the weights were rendered with
    #[arg(value_name = "MODEL")]
    model: PathBuf,
    /// Scene file
    #[arg(value_name = "SCENE.toml")]
    scene: PathBuf,
    /// Weights that were played, oldest first; one --field each
    #[arg(long, required = true, value_name = "WEIGHTS")]
    weights: Vec<PathBuf>,
    /// The field that was measured under each of them
    #[arg(long, required = true, value_name = "FIELD.csv")]
    field: Vec<PathBuf>,
    /// Weights file to write, .json
    #[arg(short, long, value_name = "WEIGHTS")]
    output: Option<PathBuf>,
    /// Calibration file to write, .json: gains, dead channels, natural frequencies and the
    /// mobility at this frequency, for the next scene. One that the scene names is where it
    /// starts from; give the fields that came after it
    #[arg(long, value_name = "OUT.json")]
    calibration: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// Those of reading and writing, and fields that do not belong to their weights.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    check(args)?;
    let inputs = [
        vec![args.model.clone(), args.scene.clone()],
        args.weights.clone(),
        args.field.clone(),
    ]
    .concat();
    let output = Output::asked("-o", args.output.as_deref(), WEIGHTS, &inputs, console)?;
    let calibration_output = Output::asked(
        "--calibration",
        args.calibration.as_deref(),
        WEIGHTS,
        &inputs,
        console,
    )?;
    console.stage("reading");
    let model = read_model(&args.model)?;
    let scene = Scene::read(&args.scene)?;
    refuse_fields_counted_twice(&args.field, &scene)?;
    let mut played = Vec::new();
    for (weights, field) in args.weights.iter().zip(&args.field) {
        played.push(PlayedField {
            weights: read_weights(weights)?,
            field: read_field(field)?,
            weights_sha256: Some(sha256_of(weights)?),
        });
    }
    console.stage("correcting");
    let (weights, calibration) = corrected(&model, &scene, &played, &inputs)
        .map_err(|error| with_file(error, args, &model, &scene, &played))?;
    console.find_all(weights.findings.iter());
    let mut text = text(&weights);
    if let (Some(path), Some(output)) = (&args.calibration, &calibration_output) {
        console.stage("writing");
        text += &write_calibration(&calibration, path, output)?;
    }
    let doubt = doubt(weights.feasible, &weights.findings).or_else(|| doubted_field(&weights));
    let outcome = match (&args.output, &output) {
        (Some(path), Some(output)) => {
            console.stage("writing");
            write_weights(output, &weights)?;
            Outcome::written(path, written(args, path, &weights), text)
        }
        _ => Outcome::shown(value_of(&weights)?, text),
    };
    Ok(outcome.doubted(doubt))
}

/// The reason that a correction is not to be trusted: its fields, or what is expected of it.
fn doubted_field(weights: &Weights) -> Option<String> {
    let has = |code: &str| weights.findings.iter().any(|finding| finding.code == code);
    if !is_explained(weights) {
        return Some("no fault of the rig explains the field: see above".into());
    }
    has("correction-no-better").then(|| "the corrected weights are no better: see above".into())
}

/// Weights corrected by the fields of `played`, and the calibration. Both name `inputs` as
/// their sources.
///
/// # Errors
/// Those of [`calibrate`] and of reading `inputs`.
pub fn corrected(
    model: &ModalModel,
    scene: &Scene,
    played: &[PlayedField],
    inputs: &[PathBuf],
) -> Result<(Weights, Calibration)> {
    let (mut weights, mut calibration) =
        calibrate(model, scene, played, &RenderOptions::default())?;
    let files = inputs.iter().map(|file| source(file));
    name_sources(
        &mut weights,
        &mut calibration,
        files.collect::<Result<_>>()?,
    );
    if let Some(before) = &scene.actuators.calibration_file {
        weights.source.push(source(before)?);
    }
    Ok((weights, calibration))
}

/// Names `inputs` as the sources of corrected weights and of their calibration.
pub fn name_sources(weights: &mut Weights, calibration: &mut Calibration, inputs: Vec<Source>) {
    for file in &inputs {
        if !calibration.source.contains(file) {
            calibration.source.push(file.clone());
        }
    }
    weights.source = inputs;
}

/// The error with the file that it is about: the field that it names, or a file of the first
/// pair that gives the same error alone.
fn with_file(
    error: Error,
    args: &Args,
    model: &ModalModel,
    scene: &Scene,
    played: &[PlayedField],
) -> Error {
    let about = error.field.as_deref().unwrap_or_default();
    let number = about.rsplit_once(" of field ").map(|(_, number)| number);
    let named = number.and_then(|number| {
        args.field
            .get(number.parse::<usize>().ok()?.checked_sub(1)?)
    });
    if let Some(named) = named {
        return error.file(named);
    }
    let options = RenderOptions::default();
    let files = args.weights.iter().zip(&args.field);
    for (pair, (weights, field)) in played.iter().zip(files) {
        let alone = calibrate(model, scene, std::slice::from_ref(pair), &options);
        let Err(alone) = alone.map(drop) else {
            continue;
        };
        // another error, or none: this pair is not the reason
        if alone.message != error.message || alone.field != error.field {
            continue;
        }
        let elsewhere =
            pair.field.frequency_hz != scene.frequency_hz && scene.other_tones.is_empty();
        return match error.field.as_deref() {
            Some("frequency_hz") if elsewhere => error.file(field),
            _ => blame_field(error, (field, weights), &args.model, scene),
        };
    }
    error
}

/// Refuses options that do not go together.
fn check(args: &Args) -> Result<()> {
    if args.weights.len() != args.field.len() {
        let found = format!(
            "{} weights and {} fields",
            args.weights.len(),
            args.field.len()
        );
        return Err(
            Error::new(ErrorKind::Usage, "weights and fields are no pairs")
                .field("--field")
                .found(found)
                .expected("one --field for each --weights, in the same order"),
        );
    }
    let outputs = args.calibration.as_deref().zip(args.output.as_deref());
    if outputs.is_some_and(|(one, other)| is_same_place(one, other)) {
        return Err(
            Error::new(ErrorKind::Usage, "two outputs would be one file")
                .field("--calibration")
                .found("the name of the weights file")
                .expected("a name of its own"),
        );
    }
    Ok(())
}

/// Writes the calibration, and returns a line about it.
fn write_calibration(calibration: &Calibration, path: &Path, output: &Output) -> Result<String> {
    output.write_bytes(calibration.to_json()?)?;
    Ok(format!(
        "calibration of {}: {}\n",
        counted(calibration.fields, "measured field"),
        path.display()
    ))
}

/// The JSON object of weights that were written to `path`.
fn written(args: &Args, path: &Path, weights: &Weights) -> Value {
    json!({
        "output": path.display().to_string(),
        "source": weights.source,
        "frequency_hz": weights.frequency_hz,
        "feasible": weights.feasible,
        "kappa": weights.kappa,
        "indices": weights.indices,
        "correction": weights.correction,
        "calibration": args.calibration.as_ref().map(|path| path.display().to_string()),
        "warnings": weights.findings.warnings(),
        "findings": weights.findings.0,
    })
}

/// Refuses a field of two pairs, and one that the calibration of the scene already contains.
fn refuse_fields_counted_twice(fields: &[PathBuf], scene: &Scene) -> Result<()> {
    let calibration = scene.actuators.calibration.as_deref();
    let calibrated = calibration.map_or(&[][..], |known| &known.source);
    let mut given: Vec<Source> = Vec::with_capacity(fields.len());
    for file in fields {
        let own = source(file)?;
        let same = |known: &&Source| known.checksum == own.checksum;
        if let Some(first) = given.iter().find(same) {
            return Err(Error::bad_data("one field is given twice")
                .file(file)
                .field("--field")
                .found(format!("the content of {}", first.file))
                .expected("another measurement for each --weights")
                .help("leave the pair out, or name the field that these weights made"));
        }
        if calibrated.iter().any(|known| same(&known)) {
            return Err(
                Error::bad_data("the calibration of the scene holds this field already")
                    .file(file)
                    .field("actuators.calibration")
                    .found("a field that would count twice")
                    .expected("fields that were measured after the calibration")
                    .help("leave the field out, or take the calibration out of the scene"),
            );
        }
        given.push(own);
    }
    Ok(())
}

fn text(weights: &Weights) -> String {
    let told = weights.correction.as_ref().map_or(String::new(), |told| {
        correction(told, is_explained(weights))
    });
    format!(
        "{told}{}{}",
        indices_table(&weights.indices),
        weights_table(weights)
    )
}

/// True where faults of the rig explain the fields: only then are its odd channels known.
fn is_explained(weights: &Weights) -> bool {
    let unexplained = |code: &str| code == "field-unlike" || code == "field-unexplained";
    !weights
        .findings
        .iter()
        .any(|finding| unexplained(&finding.code))
}

fn correction(told: &Correction, is_explained: bool) -> String {
    let fields = told.fields.iter().zip(1..).map(|(field, number)| {
        let ratio = field
            .min_ratio
            .map_or("unknown".into(), |ratio| format!("{ratio:.3}"));
        let nis = significant(field.nis, 2);
        format!("field {number}: smaller of hot and cold {ratio}, NIS {nis}\n")
    });
    let odd = told.gains.iter().filter(|gain| gain.odd && is_explained);
    let odd = odd.map(|gain| {
        format!(
            "odd channel {}: factor {:.3}{:+.3}j\n",
            gain.reference, gain.re, gain.im
        )
    });
    let drive = match (told.kept, told.best_measured) {
        (true, Some(best)) => {
            format!("the drive of field {best} is given again: it serves, or no better one is foretold\n")
        }
        _ => format!("corrected by the {} estimator\n", told.estimator.name()),
    };
    let expected = format!(
        "to be expected of these weights on the rig: smaller of hot and cold {:.3}\n",
        told.predicted
    );
    fields.chain(odd).chain([drive, expected]).collect()
}
