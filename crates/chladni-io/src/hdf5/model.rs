//! `/model`: a modal model, with the fields of the JSON file under their names. Values of the
//! modes are arrays over modes.
//!
//! Texts and single numbers are attributes. Some lists of texts and `options` are JSON text,
//! because HDF5 has no type that keeps them as they are.

use super::own::{add_label_lists, Own};
use crate::arrays::tree::{Attribute, Entry, Group, Values};
use crate::arrays::values::{dofs, integers, reals, texts, wrong_type, ComplexArray};
use chladni_frf::{
    Checksum, ComplexMatrix, ComplexVector, Error, Finding, ModalModel, Mode, Quality, Reasons,
    ResidualTerm, ResidualTerms, Result, Source, MODEL_FORMAT,
};
use ndarray::{Array2, Array3, Ix2, Ix3};
use num_complex::Complex64;
use serde::de::DeserializeOwned;
use serde::Serialize;

/// Numbers per mode, by their names in the file.
const MODE_NUMBERS: [&str; 6] = [
    "frequency_hz",
    "frequency_std_hz",
    "loss_factor",
    "loss_factor_std",
    "damping_ratio",
    "mpc",
];

fn mode_numbers(mode: &Mode) -> [f64; 6] {
    [
        mode.frequency_hz,
        mode.frequency_std_hz,
        mode.loss_factor,
        mode.loss_factor_std,
        mode.damping_ratio,
        mode.mpc,
    ]
}

/// The word that serde writes for a value, without quotes.
fn word(value: &impl Serialize) -> String {
    match serde_json::to_value(value) {
        Ok(serde_json::Value::String(text)) => text,
        Ok(other) => other.to_string(),
        Err(_) => String::new(),
    }
}

/// The group of a model whose sizes have been checked.
pub(super) fn model_group(model: &ModalModel) -> Group<'_> {
    let mut group = Group::new("model");
    group.set("format", model.format.as_str());
    group.set("version", Attribute::Integer(model.version.into()));
    group.set("created_by", model.created_by.as_str());
    group.set("options", word(&model.options));
    group.set("frf_kind", model.frf_kind.as_str());
    group.set("reference_unit", model.reference_unit.to_string());
    group.set("damping", word(&model.damping));
    group.set("scaling", word(&model.scaling));
    group.set("method", model.method.as_str());
    group.add_reals("band_hz", &[2], model.band_hz.to_vec());
    group.add(
        "responses",
        &[model.responses.len()],
        Values::Dofs(model.responses.clone()),
    );
    group.add(
        "references",
        &[model.references.len()],
        Values::Dofs(model.references.clone()),
    );
    group.add(
        "nodes",
        &[model.nodes.len()],
        Values::Nodes(model.nodes.clone()),
    );
    add_label_lists(&mut group, &model.lines, &model.faces);
    group.groups.push(source_group(&model.source));
    group.groups.push(modes_group(model));
    group
        .groups
        .push(residual_group(&model.residual_terms, model));
    group.groups.push(quality_group(&model.quality));
    group
}

/// Columns of a table of sources, by name. A checksum is empty where the source has the other
/// kind; `blake3` is there only where some source has it.
pub(super) fn source_columns(sources: &[Source]) -> Vec<(&'static str, Vec<String>)> {
    let names = sources.iter().map(|source| source.file.clone());
    let sums = |field: &str| -> Vec<String> {
        let of = |source: &Source| match source.checksum.field() == field {
            true => source.checksum.digits().to_owned(),
            false => String::new(),
        };
        sources.iter().map(of).collect()
    };
    let mut columns = vec![("file", names.collect()), ("sha256", sums("sha256"))];
    let is_large = |source: &Source| matches!(source.checksum, Checksum::Blake3(_));
    if sources.iter().any(is_large) {
        columns.push(("blake3", sums("blake3")));
    }
    columns
}

fn source_group(sources: &[Source]) -> Group<'static> {
    let mut group = Group::new("source");
    for (name, column) in source_columns(sources) {
        group.add_texts(name, column);
    }
    group
}

fn modes_group(model: &ModalModel) -> Group<'static> {
    let (modes, responses, references) =
        (&model.modes, model.responses.len(), model.references.len());
    let count = modes.len();
    let mut group = Group::new("modes");
    for (k, name) in MODE_NUMBERS.iter().enumerate() {
        group.add_reals(
            name,
            &[count],
            modes.iter().map(|mode| mode_numbers(mode)[k]).collect(),
        );
    }
    group.add(
        "in_band",
        &[count],
        Values::Unsigned(modes.iter().map(|mode| mode.in_band.into()).collect()),
    );
    group.add_texts(
        "trust",
        modes.iter().map(|mode| word(&mode.trust)).collect(),
    );
    group.add_texts(
        "reasons",
        modes
            .iter()
            .map(|mode| word(&mode.reasons.sentences()))
            .collect(),
    );
    group.add_texts(
        "doubts",
        modes.iter().map(|mode| word(&mode.reasons.0)).collect(),
    );
    let complex = |part: fn(&Mode) -> &ComplexVector| {
        Values::Complex64(modes.iter().flat_map(|mode| part(mode).0.clone()).collect())
    };
    group.add("shape", &[count, responses], complex(|mode| &mode.shape));
    group.add_reals(
        "shape_std",
        &[count, responses],
        modes
            .iter()
            .flat_map(|mode| mode.shape_std.clone())
            .collect(),
    );
    if modes.iter().any(|mode| mode.scale_std.is_some()) {
        let scale_std = modes.iter().map(|mode| mode.scale_std.unwrap_or(f64::NAN));
        group.add_reals("scale_std", &[count], scale_std.collect());
    }
    group.add(
        "participation",
        &[count, references],
        complex(|mode| &mode.participation),
    );
    group
}

fn residual_group(terms: &ResidualTerms, model: &ModalModel) -> Group<'static> {
    let mut group = Group::new("residual_terms");
    group.set(
        "omega_scale_rad_per_s",
        Attribute::Real(terms.omega_scale_rad_per_s),
    );
    let count = terms.terms.len();
    group.add(
        "power",
        &[count],
        Values::Signed(terms.terms.iter().map(|term| term.power.into()).collect()),
    );
    let matrices: Vec<Complex64> = terms
        .terms
        .iter()
        .flat_map(|term| term.matrix.0.iter().copied().collect::<Vec<_>>())
        .collect();
    group.add(
        "matrix",
        &[count, model.responses.len(), model.references.len()],
        Values::Complex64(matrices.into()),
    );
    group
}

fn quality_group(quality: &Quality) -> Group<'static> {
    let mut group = Group::new("quality");
    group.set("relative_error", Attribute::Real(quality.relative_error));
    group.set("chi2_per_dof", Attribute::Real(quality.chi2_per_dof));
    group.set("trusted", Attribute::Integer(quality.trusted.into()));
    if let Some(path) = &quality.path {
        group.set("path", path.as_str());
    }
    group.add_texts("warnings", quality.warnings());
    group.add_texts("findings", quality.findings.iter().map(word).collect());
    group
}

/// A group of the model; its readers name missing attributes and datasets.
struct ModelGroup<'a> {
    own: &'a Own<'a>,
    entry: &'a Entry,
}

impl<'a> ModelGroup<'a> {
    fn open(own: &'a Own<'a>, path: &str) -> Result<Self> {
        let entry = own.find(path).ok_or_else(|| {
            Error::bad_data("a group is missing")
                .field(path)
                .found("nothing")
                .expected("a group of a model file")
        })?;
        Ok(Self { own, entry })
    }
    fn missing(&self, name: &str) -> Error {
        Error::bad_data("an attribute is missing or of the wrong type")
            .field(format!("{name} of {}", self.entry.path))
    }
    fn text(&self, name: &str) -> Result<String> {
        self.entry
            .text(name)
            .map(str::to_owned)
            .ok_or_else(|| self.missing(name))
    }
    fn real(&self, name: &str) -> Result<f64> {
        self.entry.real(name).ok_or_else(|| self.missing(name))
    }
    /// A word that serde reads: `mobility`, `structural`, ...
    fn word<T: DeserializeOwned>(&self, name: &str) -> Result<T> {
        parse_word(&self.text(name)?, &format!("{name} of {}", self.entry.path))
    }
    fn has(&self, name: &str) -> bool {
        self.own
            .find(&format!("{}/{name}", self.entry.path))
            .is_some()
    }
    fn dataset(&self, name: &str) -> Result<(&'a Entry, Values<'static>)> {
        self.own.dataset(&format!("{}/{name}", self.entry.path))
    }
    fn reals(&self, name: &str) -> Result<Vec<f64>> {
        let (entry, values) = self.dataset(name)?;
        reals(entry, values)
    }
    fn texts(&self, name: &str) -> Result<Vec<String>> {
        let (entry, values) = self.dataset(name)?;
        texts(entry, values)
    }
    fn complex(&self, name: &str) -> Result<(&'a Entry, ndarray::ArrayD<Complex64>)> {
        let (entry, values) = self.dataset(name)?;
        match ComplexArray::new(entry, values)? {
            ComplexArray::Double(array) => Ok((entry, array)),
            ComplexArray::Single(_) => Err(wrong_type(entry, "double precision")),
        }
    }
    fn matrix(&self, name: &str, rows: usize) -> Result<Array2<Complex64>> {
        let (entry, array) = self.complex(name)?;
        let array = array
            .into_dimensionality::<Ix2>()
            .map_err(|_| wrong_type(entry, "two axes"))?;
        self.expect_count(name, array.nrows(), rows)?;
        Ok(array)
    }
    fn expect_count(&self, name: &str, found: usize, expected: usize) -> Result<()> {
        if found == expected {
            return Ok(());
        }
        Err(Error::bad_data("sizes disagree")
            .field(format!("{}/{name}", self.entry.path))
            .found(found)
            .expected(expected))
    }
}

fn parse_word<T: DeserializeOwned>(text: &str, field: &str) -> Result<T> {
    let as_word = serde_json::from_value(serde_json::Value::String(text.to_owned()));
    as_word
        .or_else(|_| serde_json::from_str(text))
        .map_err(|error| Error::bad_data(error.to_string()).field(field).found(text))
}

/// Reads the model of a file; the caller checks sizes and numbers.
pub(super) fn read_model(own: &Own<'_>) -> Result<ModalModel> {
    let group = ModelGroup::open(own, "/model")?;
    let version = group
        .entry
        .integer("version")
        .ok_or_else(|| group.missing("version"))?;
    let format = group.text("format")?;
    if format != MODEL_FORMAT {
        return Err(Error::bad_data("not a modal model")
            .field("format of /model")
            .found(format)
            .expected(MODEL_FORMAT));
    }
    let dof_list = |name: &str| {
        group
            .dataset(name)
            .and_then(|(entry, values)| dofs(entry, values))
    };
    let (entry, nodes) = group.dataset("nodes")?;
    let Values::Nodes(nodes) = nodes else {
        return Err(wrong_type(entry, "records {label u64, x y z f64}"));
    };
    let band = group.reals("band_hz")?;
    group.expect_count("band_hz", band.len(), 2)?;
    Ok(ModalModel {
        format,
        version: u32::try_from(version).unwrap_or(0),
        created_by: group.text("created_by")?,
        source: read_sources(own)?,
        options: group.word("options")?,
        frf_kind: group.word("frf_kind")?,
        reference_unit: group.word("reference_unit")?,
        band_hz: [band[0], band[1]],
        damping: group.word("damping")?,
        scaling: group.word("scaling")?,
        responses: dof_list("responses")?,
        references: dof_list("references")?,
        nodes,
        lines: own.label_lists("/model/lines")?,
        faces: own.label_lists("/model/faces")?,
        method: group.text("method")?,
        modes: read_modes(own)?,
        residual_terms: read_residual_terms(own)?,
        quality: read_quality(own)?,
    })
}

fn read_sources(own: &Own<'_>) -> Result<Vec<Source>> {
    let group = ModelGroup::open(own, "/model/source")?;
    let (files, sha256) = (group.texts("file")?, group.texts("sha256")?);
    group.expect_count("sha256", sha256.len(), files.len())?;
    let blake3 = match group.has("blake3") {
        true => group.texts("blake3")?,
        false => vec![String::new(); files.len()],
    };
    group.expect_count("blake3", blake3.len(), files.len())?;
    let columns = files.into_iter().zip(sha256).zip(blake3);
    let source = |((file, sha256), blake3): ((String, String), String)| Source {
        file,
        checksum: match blake3.is_empty() {
            true => Checksum::Sha256(sha256),
            false => Checksum::Blake3(blake3),
        },
    };
    Ok(columns.map(source).collect())
}

fn read_modes(own: &Own<'_>) -> Result<Vec<Mode>> {
    let group = ModelGroup::open(own, "/model/modes")?;
    let mut numbers = Vec::new();
    for name in MODE_NUMBERS {
        numbers.push(group.reals(name)?);
    }
    let count = numbers[0].len();
    for (name, values) in MODE_NUMBERS.iter().zip(&numbers) {
        group.expect_count(name, values.len(), count)?;
    }
    let (entry, in_band) = group.dataset("in_band")?;
    let in_band = integers(entry, in_band)?;
    group.expect_count("in_band", in_band.len(), count)?;
    let (trust, reasons) = (group.texts("trust")?, group.texts("reasons")?);
    group.expect_count("trust", trust.len(), count)?;
    group.expect_count("reasons", reasons.len(), count)?;
    let doubts = match group.has("doubts") {
        true => group.texts("doubts")?,
        false => vec!["[]".into(); count],
    };
    group.expect_count("doubts", doubts.len(), count)?;
    let (shape, participation) = (
        group.matrix("shape", count)?,
        group.matrix("participation", count)?,
    );
    let shape_std = group.reals("shape_std")?;
    group.expect_count("shape_std", shape_std.len(), shape.len())?;
    let scale_std = match group.has("scale_std") {
        true => group.reals("scale_std")?,
        false => vec![f64::NAN; count],
    };
    group.expect_count("scale_std", scale_std.len(), count)?;
    (0..count)
        .map(|k| {
            let field = |name: &str| format!("{name} of mode {}", k + 1);
            Ok(Mode {
                frequency_hz: numbers[0][k],
                frequency_std_hz: numbers[1][k],
                loss_factor: numbers[2][k],
                loss_factor_std: numbers[3][k],
                damping_ratio: numbers[4][k],
                mpc: numbers[5][k],
                in_band: in_band[k] != 0,
                trust: parse_word(&trust[k], &field("trust"))?,
                reasons: Reasons::of_file(
                    parse_word(&reasons[k], &field("reasons"))?,
                    parse_word(&doubts[k], &field("doubts"))?,
                ),
                shape: ComplexVector(shape.row(k).to_vec()),
                shape_std: shape_std[k * shape.ncols()..(k + 1) * shape.ncols()].to_vec(),
                scale_std: Some(scale_std[k]).filter(|value| !value.is_nan()),
                participation: ComplexVector(participation.row(k).to_vec()),
            })
        })
        .collect()
}

fn read_residual_terms(own: &Own<'_>) -> Result<ResidualTerms> {
    let group = ModelGroup::open(own, "/model/residual_terms")?;
    let powers = group.reals("power")?;
    let (entry, matrices) = group.complex("matrix")?;
    let matrices: Array3<Complex64> = matrices
        .into_dimensionality::<Ix3>()
        .map_err(|_| wrong_type(entry, "three axes"))?;
    group.expect_count("matrix", matrices.dim().0, powers.len())?;
    let term = |(&power, matrix): (&f64, ndarray::ArrayView2<'_, Complex64>)| ResidualTerm {
        power: power as i32,
        matrix: ComplexMatrix(matrix.to_owned()),
    };
    Ok(ResidualTerms {
        omega_scale_rad_per_s: group.real("omega_scale_rad_per_s")?,
        terms: powers.iter().zip(matrices.outer_iter()).map(term).collect(),
    })
}

fn read_quality(own: &Own<'_>) -> Result<Quality> {
    let group = ModelGroup::open(own, "/model/quality")?;
    Ok(Quality {
        relative_error: group.real("relative_error")?,
        chi2_per_dof: group.real("chi2_per_dof")?,
        trusted: group.real("trusted")? != 0.0,
        findings: match group.has("findings") {
            true => group
                .texts("findings")?
                .iter()
                .map(|text| parse_word(text, "findings"))
                .collect::<Result<_>>()?,
            false => group
                .texts("warnings")?
                .into_iter()
                .map(Finding::from)
                .collect(),
        },
        path: group.entry.text("path").map(str::to_owned),
    })
}
