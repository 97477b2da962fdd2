//! `chladni fit --poles-of`: shapes of a known model, poles of new FRFs or of measured fields.

use chladni_console::input::{read_weights, source};
use chladni_console::Console;
use chladni_frf::{Error, ErrorKind, Finding, FrfSet, ModalModel, Result, Source};
use chladni_io::{read_field, read_model, sha256_of};
use chladni_render::{poles_of_fields, PlayedField, PolesOfFields};
use chladni_rfp::{poles_of, MovedPoles};
use serde_json::json;
use std::path::{Path, PathBuf};

/// Arguments that follow a known model.
#[derive(Debug, clap::Args)]
#[group(id = "following_arguments")]
pub struct Args {
    /// Keep the shapes of this model and move its poles to the FRFs, of which six are
    /// enough: temperature, another day
    #[arg(long, value_name = "MODEL", conflicts_with_all = ["band", "scene", "method", "resume", "panel",
        "window", "seed", "rfp_weight", "rfp_bands", "rfp_local", "modes", "damping", "shapes",
        "exponential_window"])]
    poles_of: Option<PathBuf>,
    /// Weights that played while the input was measured: it is a field then, no FRFs. One
    /// for each input, all of one frequency
    #[arg(long, value_name = "WEIGHTS", requires = "poles_of")]
    weights: Vec<PathBuf>,
    // clap takes -1e-4 for no number
    /// Relative change of natural frequencies per kelvin, to say the drift in kelvin
    #[arg(long, value_name = "1/K", requires = "poles_of", value_parser = parse_coefficient,
        allow_hyphen_values = true)]
    per_kelvin: Option<f64>,
}

fn parse_coefficient(text: &str) -> std::result::Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value != 0.0 => Ok(value),
        _ => Err("no relative change per kelvin such as -1e-4".into()),
    }
}

impl Args {
    /// True where a model is to be followed.
    pub fn is_given(&self) -> bool {
        self.poles_of.is_some()
    }

    /// The model with its poles moved to the measured fields `files`; `None` where no weights
    /// are given, so that the files are FRFs.
    ///
    /// # Errors
    /// Those of reading; another number of weights than of files; fields of other weights.
    pub fn followed_by_fields(
        &self,
        files: &[PathBuf],
        console: &Console,
    ) -> Result<Option<ModalModel>> {
        let (Some(file), false) = (&self.poles_of, self.weights.is_empty()) else {
            return Ok(None);
        };
        if self.weights.len() != files.len() {
            return Err(Error::new(ErrorKind::Usage, "each field has its weights")
                .field("--weights")
                .found(format!(
                    "{} weights for {} fields",
                    self.weights.len(),
                    files.len()
                ))
                .expected("one --weights for each field, in their order"));
        }
        console.stage("reading");
        let known = read_model(file)?;
        let mut played = Vec::new();
        for (weights, field) in self.weights.iter().zip(files) {
            let weights_sha256 = Some(sha256_of(weights)?);
            played.push(PlayedField {
                weights: read_weights(weights)?,
                field: read_field(field)?,
                weights_sha256,
            });
        }
        console.stage("following the poles");
        let PolesOfFields {
            model,
            common_shift,
            common_shift_std,
            ..
        } = poles_of_fields(&known, &played).map_err(|error| {
            match (error.field.as_deref(), files) {
                (Some("responses" | "modes"), _) => error.file(file),
                (_, [only]) => error.file(only),
                _ => error,
            }
        })?;
        let inputs = files.iter().chain(&self.weights);
        let sources = inputs
            .map(|file| source(file))
            .collect::<Result<Vec<_>>>()?;
        self.completed(model, [common_shift, common_shift_std], &sources, file)
            .map(Some)
    }

    /// The error of reading `files`, with advice where one is a field and its weights are
    /// missing.
    pub fn explained(&self, error: Error, files: &[PathBuf]) -> Error {
        match self.is_given() && files.iter().any(|file| read_field(file).is_ok()) {
            true => error.help("of a measured field name the weights that played: --weights"),
            false => error,
        }
    }

    /// Refuses a set that is read part by part.
    pub fn too_large(&self) -> Error {
        Error::new(
            ErrorKind::Usage,
            "the set is larger than half of the memory allowed",
        )
        .field("--poles-of")
        .found("a set that is read part by part")
        .expected("a few FRFs: six are enough")
        .help("give some of the files, or raise --memory")
    }

    /// The model with its poles moved to `frf`; `None` where no model is to be followed.
    ///
    /// # Errors
    /// Those of reading the model; FRFs between DOFs that it lacks.
    pub fn followed(
        &self,
        frf: &FrfSet,
        sources: &[Source],
        console: &Console,
    ) -> Result<Option<ModalModel>> {
        let Some(file) = &self.poles_of else {
            return Ok(None);
        };
        let known = read_model(file)?;
        console.stage("following the poles");
        let MovedPoles {
            model,
            common_shift,
            common_shift_std,
            ..
        } = poles_of(&known, frf).map_err(|error| error.file(file))?;
        self.completed(model, [common_shift, common_shift_std], sources, file)
            .map(Some)
    }

    /// The moved model with its sources and options, and with the drift in kelvin where a
    /// coefficient is given.
    fn completed(
        &self,
        mut model: ModalModel,
        [common_shift, common_shift_std]: [f64; 2],
        sources: &[Source],
        file: &Path,
    ) -> Result<ModalModel> {
        model.source = [sources, &[source(file)?]].concat();
        model
            .options
            .insert("poles_of".into(), json!(chladni_text::file_name(file)));
        if let Some(per_kelvin) = self.per_kelvin {
            let [kelvin, std] = [common_shift, common_shift_std.abs()].map(|v| v / per_kelvin);
            let words = format!(
                "the panel is {:.2} K {} than when the model was measured (± {:.2} K)",
                kelvin.abs(),
                if kelvin < 0.0 { "colder" } else { "warmer" },
                std.abs()
            );
            let told = Finding::note("drift-in-kelvin", words)
                .value("kelvin", kelvin)
                .value("kelvin_std", std.abs());
            model.quality.findings.push(told);
            model.options.insert("per_kelvin".into(), json!(per_kelvin));
        }
        Ok(model)
    }
}
