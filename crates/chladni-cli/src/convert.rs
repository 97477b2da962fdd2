//! `chladni convert`: measured data and models from any format to any other.

use chladni_console::input::{expand, model_of, read_weights, source, warn_of_files, Reading};
use chladni_console::output::{Output, DATA, MODEL_OR_SHAPES, SHAPES};
use chladni_console::table::counted;
use chladni_console::{Console, Outcome};
use chladni_frf::{Dof, Error, Finding, ModalModel, Result};
use chladni_io::{
    detect_format, extension_of, field_shape, model_shapes, read_contents, read_model,
    write_contents, write_model, Contents, FileFormat, Shape, ShapeForm,
};
use chladni_render::Weights;
use num_complex::Complex64;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Arguments of `convert`.
#[derive(Debug, clap::Args)]
#[command(before_help = "Examples:
  chladni convert measurement.uff -o measurement.h5
  chladni convert scan_*.uff --reference 101,102,103 -o all.h5      one file per actuator
  chladni convert model.json -o model.h5                            exact; modes.csv and model.mat for other programs
  chladni convert model.json -o shapes.unv                          mode shapes for other programs; shapes.pvd for ParaView
  chladni convert model.json weights.json -o field.vtu              the field of each tone of the weights")]
pub struct Args {
    /// Input files, folders of them, or patterns; several are merged into one set
    #[arg(required = true, value_name = "IN")]
    files: Vec<PathBuf>,
    /// File to write: .h5 (exact), .uff (binary), .unv (text), .npz, .mat, .csv; of models
    /// .json, .h5, .mat, .csv (a table of modes), or their shapes as .unv, .uff, .vtu, .pvd
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    reading: Reading,
}

/// Runs the command.
///
/// # Errors
/// Those of reading and writing.
pub fn run(args: &Args, console: &Console) -> Result<Outcome> {
    let files = expand(&args.files, console)?;
    console.stage("reading");
    if let [file] = files.as_slice() {
        if let Some(model) = model_of(file)? {
            return convert_model(args, &files, &model, console);
        }
    }
    if let [one, other] = files.as_slice() {
        let formats = [detect_format(one)?, detect_format(other)?];
        match formats {
            [FileFormat::Weights, _] => return convert_fields(args, &files, other, one, console),
            [_, FileFormat::Weights] => return convert_fields(args, &files, one, other, console),
            _ => {}
        }
    }
    let output = Output::new(&args.output, DATA, &files, console)?;
    let mut contents = read_contents(&files, &args.reading.options())?;
    warn_of_files(&files, std::mem::take(&mut contents.warnings), console);
    let not_carried = std::mem::take(&mut contents.not_carried);
    let not_carried = not_carried
        .into_iter()
        .map(|words| Finding::caution("not-carried", words));
    warn_of_files(&files, not_carried.collect(), console);
    refuse_nothing(&contents, &args.files[0])?;
    console.stage("writing");
    console.find_all(&output.write(|path, force| write_contents(path, &contents, force))?);
    let (responses, references, lines) = contents
        .frf
        .as_ref()
        .map_or((0, 0, 0), |frf| frf.values.dim());
    let json = json!({
        "output": args.output.display().to_string(),
        "source": contents.sources,
        "frf_kind": contents.frf.as_ref().and_then(|frf| frf.kind),
        "responses": responses,
        "references": references,
        "lines": lines,
        "functions": contents.functions.len(),
        "shapes": contents.shapes.len(),
        "nodes": contents.geometry().nodes.len(),
    });
    let text = format!(
        "{}: {} of {} at {}, {}, {}, {}\n",
        args.output.display(),
        counted(responses, "response"),
        counted(references, "reference"),
        counted(lines, "line"),
        counted(contents.functions.len(), "other function"),
        counted(contents.shapes.len(), "shape"),
        counted(contents.geometry().nodes.len(), "node")
    );
    Ok(Outcome::written(&args.output, json, text))
}

fn refuse_nothing(contents: &Contents, file: &Path) -> Result<()> {
    let nothing = contents.functions.is_empty()
        && contents.shapes.is_empty()
        && contents.geometry().nodes.is_empty();
    if contents.frf.is_none() && nothing {
        return Err(Error::bad_data("nothing in the input can be carried over")
            .file(file)
            .found("neither FRFs nor other functions, shapes or nodes")
            .expected("measured data or a model")
            .help("`chladni info` lists what is inside"));
    }
    Ok(())
}

fn convert_model(
    args: &Args,
    files: &[PathBuf],
    model: &ModalModel,
    console: &Console,
) -> Result<Outcome> {
    let output = Output::new(&args.output, MODEL_OR_SHAPES, files, console)?;
    console.stage("writing");
    if writes_shapes(&args.output) {
        return write_shapes(
            args,
            files,
            model,
            model_shapes(model, form_for(&args.output)),
            &output,
            console,
        );
    }
    output.write(|path, force| write_model(path, model, force))?;
    let modes = model.in_band_modes().count();
    let json = json!({
        "output": args.output.display().to_string(),
        "source": [source(&files[0])?],
        "frf_kind": model.frf_kind,
        "responses": model.responses.len(),
        "references": model.references.len(),
        "modes": modes,
    });
    Ok(Outcome::written(
        &args.output,
        json,
        format!(
            "{}: model with {}\n",
            args.output.display(),
            counted(modes, "mode")
        ),
    ))
}

/// The fields that weights make of a model, one for each of their tones.
fn convert_fields(
    args: &Args,
    files: &[PathBuf],
    model: &Path,
    weights: &Path,
    console: &Console,
) -> Result<Outcome> {
    let output = Output::new(&args.output, SHAPES, files, console)?;
    let (model, weights) = (read_model(model)?, read_weights(weights)?);
    let fields = weights.tones().zip(1..).map(|(tone, number)| {
        let mut field = field_of(&model, tone, form_for(&args.output))?;
        field.numbers.number = number;
        Ok(field)
    });
    let fields = fields.collect::<Result<Vec<_>>>()?;
    console.stage("writing");
    write_shapes(args, files, &model, fields, &output, console)
}

fn field_of(model: &ModalModel, tone: &Weights, form: ShapeForm) -> Result<Shape> {
    tone.check_unit(model.reference_unit)?;
    let drive: Vec<(Dof, Complex64)> = tone
        .weights
        .iter()
        .map(|one| (one.reference, Complex64::new(one.re, one.im)))
        .collect();
    field_shape(model, tone.frequency_hz, &drive, form)
}

fn write_shapes(
    args: &Args,
    files: &[PathBuf],
    model: &ModalModel,
    shapes: Vec<Shape>,
    output: &Output<'_>,
    console: &Console,
) -> Result<Outcome> {
    let contents = Contents {
        shapes,
        other_geometry: model.geometry(),
        ..Contents::default()
    };
    console.find_all(&output.write(|path, force| write_contents(path, &contents, force))?);
    let json = json!({
        "output": args.output.display().to_string(),
        "source": files.iter().map(|file| source(file)).collect::<Result<Vec<_>>>()?,
        "shapes": contents.shapes.len(),
        "nodes": model.nodes.len(),
    });
    let text = format!(
        "{}: {}, {}\n",
        args.output.display(),
        counted(contents.shapes.len(), "shape"),
        counted(model.nodes.len(), "node")
    );
    Ok(Outcome::written(&args.output, json, text))
}

fn writes_shapes(path: &Path) -> bool {
    SHAPES.contains(&extension_of(path).as_str())
}

/// Dataset of shapes: 2414 for finite-element programs (.unv), 55 for programs of measured
/// data.
fn form_for(path: &Path) -> ShapeForm {
    match extension_of(path).as_str() {
        "unv" => ShapeForm::Analysis2414,
        _ => ShapeForm::AtNodes55,
    }
}
