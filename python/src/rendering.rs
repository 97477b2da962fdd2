//! Weights for a scene, and what they do on other data.

use crate::detached::detached;
use crate::error::{raised, wrong_extension, wrong_option, wrong_word};
use crate::findings::findings_json;
use crate::frf::FrfSet;
use crate::model::Model;
use chladni_frf::{Error, ErrorKind};
use chladni_io::{
    extension_of, is_same_place, refuse_output_among_inputs, try_place, write_atomically,
};
use chladni_render::{Count, MethodChoice, On, RenderOptions, Scene};
use ndarray::{Array1, Array2};
use num_complex::Complex64;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Actuator weights for a scene, and how they do in the model.
#[pyclass(frozen, module = "chladni")]
#[derive(Clone)]
pub struct Rendering(pub Arc<chladni_render::Rendering>);

impl From<chladni_render::Rendering> for Rendering {
    fn from(rendered: chladni_render::Rendering) -> Self {
        Self(Arc::new(rendered))
    }
}

#[pymethods]
impl Rendering {
    /// Place of each response, m: (response, 2).
    #[getter]
    fn points_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let points = &self.0.field.positions_m;
        Array2::from_shape_fn((points.len(), 2), |(i, axis)| points[i][axis]).into_pyarray(py)
    }

    /// Peak phasors of the weights in N or V: (actuator,).
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<Complex64>> {
        self.0
            .weights
            .weights
            .iter()
            .map(|weight| weight.value())
            .collect::<Array1<_>>()
            .into_pyarray(py)
    }

    /// Names of the actuators, as the weights.
    #[getter]
    fn references(&self) -> Vec<String> {
        self.0
            .weights
            .weights
            .iter()
            .map(|weight| weight.reference.to_string())
            .collect()
    }

    /// The same for what sounds with it at other frequencies.
    #[getter]
    fn other_tones(&self) -> Vec<Self> {
        self.0.other_tones.iter().cloned().map(Self::from).collect()
    }

    /// Drive frequency, Hz.
    #[getter]
    fn frequency_hz(&self) -> f64 {
        self.0.weights.frequency_hz
    }

    /// Velocities along +Z in the model, m/s, peak phasors: (response,).
    #[getter]
    fn velocity_m_per_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<Complex64>> {
        Array1::from(self.0.field.velocity_m_per_s.clone()).into_pyarray(py)
    }

    /// Names of the responses, as the velocities.
    #[getter]
    fn responses(&self) -> Vec<String> {
        let responses = self.0.field.responses.iter();
        responses.map(ToString::to_string).collect()
    }

    /// The method that ran.
    #[getter]
    fn method(&self) -> &str {
        &self.0.weights.method
    }

    /// True where every judged response keeps its limit within the force limits.
    #[getter]
    fn feasible(&self) -> bool {
        self.0.weights.feasible
    }

    /// Model errors, in standard deviations, under which every judged response keeps its
    /// limit.
    #[getter]
    fn kappa(&self) -> Option<f64> {
        self.0.weights.kappa
    }

    /// The sentences of cautions and faults.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.0.weights.findings.warnings()
    }

    /// All findings as JSON.
    fn _findings(&self) -> PyResult<String> {
        findings_json(&self.0.weights.findings)
    }

    /// The weights file's text.
    fn to_json(&self, py: Python<'_>) -> PyResult<String> {
        self.0.weights.to_json().map_err(|error| raised(py, &error))
    }

    /// Writes the weights file.
    ///
    /// Parameters
    /// ----------
    /// path : path
    ///     .json.
    /// force : bool
    ///     Overwrite it.
    #[pyo3(signature = (path, *, force=false))]
    fn save(&self, py: Python<'_>, path: PathBuf, force: bool) -> PyResult<()> {
        if extension_of(&path) != "json" {
            return Err(wrong_extension(py, &path, ".json"));
        }
        let text = self.to_json(py)?;
        write_atomically(&path, force, |out| out.write_all(text.as_bytes()))
            .map_err(|error| raised(py, &error))
    }

    fn __repr__(&self) -> String {
        let feasible = if self.0.weights.feasible {
            "feasible"
        } else {
            "not feasible"
        };
        format!(
            "Rendering({} actuators at {} Hz, {}, {feasible})",
            self.0.weights.weights.len(),
            self.0.weights.frequency_hz,
            self.0.weights.method
        )
    }
}

/// A scene file, or the text of one (anything with a line end or an equals sign).
pub fn scene_of(py: Python<'_>, scene: &Bound<'_, PyAny>) -> PyResult<Scene> {
    let read = match scene.extract::<String>() {
        Ok(text) if text.contains(['\n', '=']) => Scene::parse(&text, Path::new("")),
        _ => Scene::read(&scene.extract::<PathBuf>()?),
    };
    read.map_err(|error| raised(py, &error))
}

/// A method by its name.
pub fn method_of(py: Python<'_>, name: &str) -> PyResult<MethodChoice> {
    name.parse()
        .map_err(|error| wrong_option(py, "method", error))
}

/// Weights that move the panel in the hot zones of a scene and keep it quiet in the cold
/// ones.
///
/// scene: a scene file or its TOML text. method: default, fast, best, or one of the
/// methods of `chladni render`. modes, actuators: "all" (where None), "auto" or a number.
/// measured: FRFs whose line at the drive frequency judges modes="auto".
#[pyfunction]
#[pyo3(signature = (model, scene, *, method="default", modes=None, actuators=None, measured=None))]
pub fn render(
    py: Python<'_>,
    model: &Model,
    scene: &Bound<'_, PyAny>,
    method: &str,
    modes: Option<&Bound<'_, PyAny>>,
    actuators: Option<&Bound<'_, PyAny>>,
    measured: Option<&FrfSet>,
) -> PyResult<Rendering> {
    // a number as a word
    let count = |field: &str, asked: Option<&Bound<'_, PyAny>>| {
        let Some(asked) = asked else {
            return Ok(Count::All);
        };
        let count = asked.str()?.to_string().parse::<Count>();
        count.map_err(|error| wrong_option(py, field, error))
    };
    let options = RenderOptions {
        method: method_of(py, method)?,
        modes: count("modes", modes)?,
        actuators: count("actuators", actuators)?,
        ..RenderOptions::default()
    };
    let scene = scene_of(py, scene)?;
    let rendered = detached(py, || {
        chladni_render::render_measured(
            &model.model,
            &scene,
            &options,
            measured.map(|frf| &frf.set),
        )
    })?;
    rendered
        .map(Rendering::from)
        .map_err(|error| raised(py, &error))
}

/// The files that a correction writes, each as a whole or not at all.
struct CorrectionFiles {
    weights: Option<PathBuf>,
    calibration: Option<PathBuf>,
    /// Existing files are overwritten.
    force: bool,
}

impl CorrectionFiles {
    /// Refuses, before the work, files that cannot be written and those that are read.
    fn check(&self, inputs: &[PathBuf]) -> chladni_frf::Result<()> {
        let both = self.weights.as_deref().zip(self.calibration.as_deref());
        if both.is_some_and(|(one, other)| is_same_place(one, other)) {
            return Err(
                Error::new(ErrorKind::Usage, "two outputs would be one file")
                    .field("calibration")
                    .found("the name of `output`")
                    .expected("a name of its own"),
            );
        }
        for output in [&self.weights, &self.calibration].into_iter().flatten() {
            refuse_output_among_inputs(output, inputs)?;
            try_place(output, self.force)?;
        }
        Ok(())
    }

    /// Writes the texts to the files that are wanted.
    fn write(&self, weights: &str, calibration: &str) -> chladni_frf::Result<()> {
        let texts = [(&self.calibration, calibration), (&self.weights, weights)];
        for (path, text) in texts {
            if let Some(path) = path {
                write_atomically(path, self.force, |out| out.write_all(text.as_bytes()))?;
            }
        }
        Ok(())
    }
}

/// A drive corrected by measured fields, as the text of its weights file.
///
/// weights: the files that were played, oldest first; fields: what was measured under each;
/// output, calibration: files to write.
#[pyfunction]
#[pyo3(signature = (model, scene, weights, fields, output, calibration, force))]
#[allow(clippy::too_many_arguments, reason = "keywords of Python")]
pub fn correct(
    py: Python<'_>,
    model: &Model,
    scene: &Bound<'_, PyAny>,
    weights: Vec<PathBuf>,
    fields: Vec<PathBuf>,
    output: Option<PathBuf>,
    calibration: Option<PathBuf>,
    force: bool,
) -> PyResult<String> {
    if weights.len() != fields.len() {
        let found = format!("{} weights and {} fields", weights.len(), fields.len());
        return Err(wrong_word(
            py,
            "fields",
            &found,
            "weights and fields are no pairs; write one field for each of the weights",
        ));
    }
    let files = CorrectionFiles {
        weights: output,
        calibration,
        force,
    };
    let mut inputs = [weights.as_slice(), &fields].concat();
    // a scene may be its text, which is the name of no file
    inputs.extend(scene.extract::<PathBuf>().ok());
    files.check(&inputs).map_err(|error| raised(py, &error))?;
    let scene = scene_of(py, scene)?;
    let corrected = detached(py, || {
        let mut played = Vec::new();
        for (weights, field) in weights.iter().zip(&fields) {
            let text = chladni_text::read_text(weights, "weights, JSON")?;
            let read =
                chladni_render::Weights::parse(&text).map_err(|error| error.file(weights))?;
            let weights_sha256 = Some(chladni_io::sha256_of(weights)?);
            played.push(chladni_render::PlayedField {
                weights: read,
                field: chladni_io::read_field(field)?,
                weights_sha256,
            });
        }
        let options = RenderOptions::default();
        let (weights, calibration) =
            chladni_render::calibrate(&model.model, &scene, &played, &options)?;
        let text = weights.to_json()?;
        files.write(&text, &calibration.to_json()?)?;
        Ok(text)
    })?;
    corrected.map_err(|error: Error| raised(py, &error))
}

/// The indices of weights on other data, as a JSON text: measured FRFs or a model.
#[pyfunction]
#[pyo3(signature = (rendering, scene, on))]
pub fn evaluate(
    py: Python<'_>,
    rendering: &Rendering,
    scene: &Bound<'_, PyAny>,
    on: &Bound<'_, PyAny>,
) -> PyResult<String> {
    let scene = scene_of(py, scene)?;
    let weights = &rendering.0.weights;
    let on_data = match (on.cast::<Model>(), on.cast::<FrfSet>()) {
        (Ok(model), _) => On::Model(&model.get().model),
        (_, Ok(frf)) => On::Frf(&frf.get().set),
        _ => {
            return Err(wrong_word(
                py,
                "on",
                &on.get_type().to_string(),
                "nothing to judge on; write an FrfSet or a Model",
            ))
        }
    };
    let judged = detached(py, || chladni_render::evaluate(weights, &scene, on_data))?
        .map_err(|error| raised(py, &error))?;
    let in_time = match on.cast::<Model>() {
        Ok(model) if scene.time.is_some() => {
            let options = chladni_render::PlayOptions::default();
            let model = &model.get().model;
            detached(py, || {
                chladni_render::play(model, &scene, Some(weights), &options)
            })?
            .map(|played| Some(played.indices))
            .map_err(|error| raised(py, &error))?
        }
        _ => None,
    };
    let of = |tone: &chladni_render::Evaluation| serde_json::json!({"frequency_hz": tone.frequency_hz, "indices": tone.indices, "warnings": chladni_frf::warnings(&tone.findings), "findings": tone.findings});
    let mut all = of(&judged);
    if !judged.other_tones.is_empty() {
        all["other_tones"] = judged.other_tones.iter().map(of).collect();
    }
    if let Some(indices) = in_time {
        all["time"] = serde_json::json!(indices);
    }
    Ok(all.to_string())
}
