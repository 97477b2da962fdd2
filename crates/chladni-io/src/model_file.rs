//! Models on disk: JSON, or the same fields under `/model` of an HDF5 file.

use super::atomic::write_atomically;
use super::json::write_json;
use super::mat::MatFile;
use super::{detect_format, hdf5, model_table, FileFormat};
use crate::limits::{CRITICAL, FARTHEST_M, LARGEST, MOST_MODES, SAME_DAMPING};
use chladni_frf::{Damping, Error, ErrorKind, ModalModel, Mode, Result, MODEL_FORMAT};
use chladni_text::door::KeptInputs;
use chladni_text::{json_error_in, read_text};
use num_complex::Complex64;
use std::path::Path;

/// Version of the model file that is written and read here.
const VERSION: u32 = 1;

/// Reads a model, JSON or HDF5 by content, and checks it.
///
/// # Errors
/// [`ErrorKind::BadData`] with line (JSON) or field when something is missing, of another
/// size than the responses and references say, not finite, or of another format or
/// version.
pub fn read_model(path: &Path) -> Result<ModalModel> {
    let _kept = KeptInputs::new();
    let model = match detect_format(path)? {
        FileFormat::Model => read_json(path)?,
        FileFormat::Hdf5 => hdf5::read_model(path)?,
        other => return Err(not_a_model(path, other)),
    };
    check(&model).map_err(|error| error.file(path))?;
    Ok(model)
}

/// The error of a file of another `format` in place of a model.
pub fn not_a_model(path: &Path, format: FileFormat) -> Error {
    let (what, help) = match format {
        FileFormat::Weights => ("weights", "give the model that the weights were made from"),
        FileFormat::Wav => ("a sound", "give the model that the sound was made with"),
        _ if super::extension_of(path) == "toml" => (
            "TOML, as of a scene or a panel",
            "give the model here, and the TOML file in its own place",
        ),
        _ => ("measured data", "fit a model first"),
    };
    Error::bad_data(format!("{what}, not a model"))
        .file(path)
        .found(what)
        .expected("a model, JSON or HDF5")
        .help(help)
}

/// Writes a model: `.json`, or `.h5` / `.hdf5`; for other programs `.mat` (MATLAB) and
/// `.csv` / `.txt` (a table of modes), which are not read again.
///
/// # Errors
/// [`ErrorKind::Usage`] for another extension, [`ErrorKind::Internal`] for a model that
/// [`read_model`] would refuse; otherwise as [`write_atomically`].
pub fn write_model(path: &Path, model: &ModalModel, force: bool) -> Result<()> {
    check(model).map_err(|error| {
        Error {
            kind: ErrorKind::Internal,
            ..error
        }
        .file(path)
    })?;
    match super::extension_of(path).as_str() {
        "json" => write_atomically(path, force, |out| write_json(out, model)),
        "h5" | "hdf5" => hdf5::write_model(path, model, force),
        "mat" => {
            let file = MatFile::of_model(model).map_err(|error| error.file(path))?;
            write_atomically(path, force, |out| file.write(out))
        }
        "csv" | "txt" => write_atomically(path, force, |out| model_table::write(out, model)),
        _ => Err(super::unknown_extension(
            path,
            ".json, .h5, .hdf5, .mat or .csv",
        )),
    }
}

/// The text of a model's `.json` file.
///
/// # Errors
/// A model that cannot be written.
pub fn model_json(model: &ModalModel) -> Result<String> {
    check(model)?;
    let mut text = Vec::new();
    write_json(&mut text, model)
        .map_err(|error| Error::new(ErrorKind::Internal, error.to_string()))?;
    String::from_utf8(text).map_err(|error| Error::new(ErrorKind::Internal, error.to_string()))
}

fn read_json(path: &Path) -> Result<ModalModel> {
    let text = read_text(path, "a model, JSON")?;
    let explain = |error: serde_json::Error| {
        json_error_in(&text, "model", &error)
            .file(path)
            .help("correct the file at that line, or fit the model again")
    };
    check_version(
        serde_json::from_str::<Version>(&text)
            .map_err(explain)?
            .version,
    )
    .map_err(|error| error.file(path))?;
    serde_json::from_str(&text).map_err(explain)
}

/// The version of a model file, which is read first: other versions may have other fields.
#[derive(serde::Deserialize)]
struct Version {
    version: u32,
}

fn check_version(version: u32) -> Result<()> {
    if version == VERSION {
        return Ok(());
    }
    Err(Error::bad_data("a model file of another version")
        .field("version")
        .found(version)
        .expected(VERSION)
        .help("read it with the program that wrote it, or fit the model again"))
}

/// Checks a model: format, version, array sizes that agree with the DOFs, plausible numbers.
fn check(model: &ModalModel) -> Result<()> {
    if model.format != MODEL_FORMAT {
        return Err(Error::bad_data("not a modal model")
            .field("format")
            .found(&model.format)
            .expected(MODEL_FORMAT));
    }
    check_version(model.version)?;
    for (field, dofs) in [
        ("responses", &model.responses),
        ("references", &model.references),
    ] {
        let mut seen = std::collections::HashSet::new();
        if let Some(twice) = dofs.iter().find(|dof| !seen.insert(**dof)) {
            return Err(Error::bad_data("a DOF occurs twice")
                .field(field)
                .found(twice)
                .expected("every DOF once"));
        }
    }
    sane("band_hz", model.band_hz)?;
    if model.band_hz[0] > model.band_hz[1] {
        return Err(Error::bad_data("the band ends before it begins")
            .field("band_hz")
            .found(format!("{:?}", model.band_hz)));
    }
    let mut labels = std::collections::HashSet::new();
    for node in &model.nodes {
        let field = format!("nodes, label {}", node.label);
        within(&field, node.xyz_m, FARTHEST_M)?;
        if !labels.insert(node.label) {
            return Err(Error::bad_data("a node occurs twice")
                .field("nodes")
                .found(node.label)
                .expected("every node once"));
        }
    }
    if model.modes.len() > MOST_MODES {
        return Err(Error::bad_data("too many modes")
            .field("modes")
            .found(model.modes.len())
            .expected(format!("at most {MOST_MODES}")));
    }
    for (k, mode) in model.modes.iter().enumerate() {
        check_mode(model, k, mode)?;
    }
    check_residual_terms(model)?;
    finite("quality.relative_error", [model.quality.relative_error])?;
    finite("quality.chi2_per_dof", [model.quality.chi2_per_dof])
}

fn check_residual_terms(model: &ModalModel) -> Result<()> {
    let terms = &model.residual_terms;
    sane(
        "residual_terms.omega_scale_rad_per_s",
        [terms.omega_scale_rad_per_s],
    )?;
    if !terms.terms.is_empty() && terms.omega_scale_rad_per_s <= 0.0 {
        return Err(Error::bad_data("must be positive")
            .field("residual_terms.omega_scale_rad_per_s")
            .found(terms.omega_scale_rad_per_s));
    }
    for (k, term) in terms.terms.iter().enumerate() {
        let field = format!("residual_terms.terms[{k}]");
        let expected = (model.responses.len(), model.references.len());
        // in JSON a matrix without rows has no number of columns
        if term.matrix.0.dim() != expected && expected.0 != 0 {
            return Err(Error::bad_data("wrong size")
                .field(field)
                .found(format!("{:?}", term.matrix.0.dim()))
                .expected(format!("{expected:?}, responses and references")));
        }
        sane_complex(&field, &term.matrix.0)?;
    }
    Ok(())
}

/// The numbers of a mode that belong to its pole, by name.
fn pole_numbers(mode: &Mode) -> [(&'static str, f64); 5] {
    [
        ("frequency_hz", mode.frequency_hz),
        ("frequency_std_hz", mode.frequency_std_hz),
        ("loss_factor", mode.loss_factor),
        ("loss_factor_std", mode.loss_factor_std),
        ("damping_ratio", mode.damping_ratio),
    ]
}

fn check_mode(model: &ModalModel, index: usize, mode: &Mode) -> Result<()> {
    let field = |name: &str| format!("modes[{index}].{name}");
    for (name, value) in pole_numbers(mode).into_iter().chain([("mpc", mode.mpc)]) {
        sane(&field(name), [value])?;
    }
    check_pole(model, index, mode)?;
    for (name, found, expected, axis) in [
        (
            "shape",
            mode.shape.0.len(),
            model.responses.len(),
            "responses",
        ),
        (
            "shape_std",
            mode.shape_std.len(),
            model.responses.len(),
            "responses",
        ),
        (
            "participation",
            mode.participation.0.len(),
            model.references.len(),
            "references",
        ),
    ] {
        if found != expected {
            return Err(Error::bad_data("wrong size")
                .field(field(name))
                .found(found)
                .expected(format!("{expected}, one for each of the {axis}")));
        }
    }
    sane_complex(&field("shape"), &mode.shape.0)?;
    sane(&field("shape_std"), mode.shape_std.iter().copied())?;
    sane(&field("scale_std"), mode.scale_std)?;
    sane_complex(&field("participation"), &mode.participation.0)
}

/// Checks that a mode oscillates and does not gain energy, and that its two damping values
/// agree.
fn check_pole(model: &ModalModel, index: usize, mode: &Mode) -> Result<()> {
    let wrong = |message: &str, name: &str, value: f64| {
        Error::bad_data(format!("{message} in the mode at {} Hz", mode.frequency_hz))
            .field(format!("modes[{index}].{name}"))
            .found(value)
            .help("correct the mode, or take it off the list of modes")
    };
    for (name, value) in pole_numbers(mode) {
        if value < 0.0 {
            return Err(wrong("a negative number", name, value).expected("0 or more"));
        }
    }
    if model.damping == Damping::Viscous && mode.loss_factor >= CRITICAL {
        return Err(wrong(
            "viscous damping that lets nothing swing",
            "loss_factor",
            mode.loss_factor,
        )
        .expected(format!("less than {CRITICAL}, a damping ratio below 1")));
    }
    let of_loss = 0.5 * mode.loss_factor;
    if (mode.damping_ratio - of_loss).abs() > SAME_DAMPING * of_loss.max(mode.damping_ratio) {
        return Err(wrong(
            "damping that is told in two ways",
            "damping_ratio",
            mode.damping_ratio,
        )
        .expected(format!(
            "{of_loss}, half of its loss_factor of {}",
            mode.loss_factor
        )));
    }
    Ok(())
}

fn sane(field: &str, values: impl IntoIterator<Item = f64>) -> Result<()> {
    within(field, values, LARGEST)
}

fn sane_complex<'a>(field: &str, values: impl IntoIterator<Item = &'a Complex64>) -> Result<()> {
    sane(
        field,
        values.into_iter().flat_map(|value| [value.re, value.im]),
    )
}

fn within(field: &str, values: impl IntoIterator<Item = f64>, largest: f64) -> Result<()> {
    let mut too_large = None;
    let seen = values.into_iter().inspect(|value| {
        if value.abs() > largest {
            too_large.get_or_insert(*value);
        }
    });
    finite(field, seen)?;
    match too_large {
        None => Ok(()),
        Some(value) => Err(Error::bad_data("a number that no panel can have")
            .field(field)
            .found(format!("{value:e}"))
            .expected(format!("a number between -{largest:e} and {largest:e}"))),
    }
}

fn finite(field: &str, values: impl IntoIterator<Item = f64>) -> Result<()> {
    match values.into_iter().find(|value| !value.is_finite()) {
        None => Ok(()),
        Some(value) => Err(Error::bad_data("a number that is not finite")
            .field(field)
            .found(value)
            .expected("a finite number")),
    }
}
