//! Drives over time: bursts, fades, moving spots, and the files that a rig plays.

use crate::detached::detached;
use crate::error::{raised, wrong_extension, wrong_option, wrong_word};
use crate::model::Model;
use crate::rendering::{method_of, scene_of, Rendering};
use chladni_io::{extension_of, write_atomically, write_npz, write_together, NamedArray};
use chladni_render::{
    ChannelMap, PlayOptions, Ramps, RenderOptions, SampleFormat, Signal, SignalOptions,
};
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A drive over time, and how it does in the model.
#[pyclass(frozen, module = "chladni")]
pub struct Playing {
    played: Arc<chladni_render::Played>,
    scene: String,
}

/// Options of a signal as Python gives them: rate, format, full scale, channel map.
type Asked = (u32, String, Option<f64>, Option<Vec<(usize, String, f64)>>);

impl Playing {
    fn made(&self, py: Python<'_>, asked: Asked) -> PyResult<(Signal, SampleFormat)> {
        let (rate_hz, format, full_scale, channel_map) = asked;
        let format = format
            .parse::<SampleFormat>()
            .map_err(|error| wrong_option(py, "format", error))?;
        let channels = channel_map.map(|rows| mapped(py, rows)).transpose()?;
        let options = SignalOptions {
            rate_hz,
            format,
            full_scale,
            channels,
        };
        detached(py, || self.played.signal(&options, &self.scene))?
            .map(|signal| (signal, format))
            .map_err(|error| raised(py, &error))
    }
}

/// Rows (channel, reference, gain) as the text of a channel map, so that they are checked
/// in one place.
fn mapped(py: Python<'_>, rows: Vec<(usize, String, f64)>) -> PyResult<ChannelMap> {
    let line = |(channel, reference, gain): (usize, String, f64)| {
        format!("{channel},{reference},{gain}\n")
    };
    let text: String = rows.into_iter().map(line).collect();
    ChannelMap::parse(&format!("channel,reference,gain\n{text}"))
        .map_err(|error| raised(py, &error))
}

#[pymethods]
impl Playing {
    /// True where no ground misses its limit by the measure of the scene.
    #[getter]
    fn feasible(&self) -> bool {
        self.played.feasible
    }

    /// Findings that need attention, in words.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.played.warnings()
    }

    /// End of the drive, s.
    #[getter]
    fn length_s(&self) -> f64 {
        self.played.length_s
    }

    /// Names of the actuators.
    #[getter]
    fn references(&self) -> Vec<String> {
        self.played
            .references
            .iter()
            .map(ToString::to_string)
            .collect()
    }

    /// Times of the next three arrays, s.
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let traces = &self.played.traces;
        let times = (0..traces.drive.len()).map(|k| traces.step_s * k as f64);
        times.collect::<Vec<_>>().into_pyarray(py)
    }

    /// The weakest hot response over its limit at each instant, dB; NaN where none is hot.
    #[getter]
    fn hot_db<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        levels(&self.played.traces.hot_db).into_pyarray(py)
    }

    /// The loudest cold response over its limit at each instant, dB.
    #[getter]
    fn cold_db<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        levels(&self.played.traces.cold_db).into_pyarray(py)
    }

    /// Largest drive of an actuator at each instant, N or V.
    #[getter]
    fn largest_drive<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.played.traces.drive.clone().into_pyarray(py)
    }

    /// The indices as a JSON text.
    fn _indices(&self) -> String {
        serde_json::json!(self.played.indices).to_string()
    }

    /// The drive of each channel.
    ///
    /// Parameters
    /// ----------
    /// rate_hz : int
    ///     Frames per second.
    /// full_scale : float, optional
    ///     Largest value, N or V.
    /// channel_map : sequence of (int, str, float), optional
    ///     Rows (channel, reference, gain).
    ///
    /// Returns
    /// -------
    /// ndarray of float64, shape (frame, channel)
    ///     N or V.
    #[pyo3(signature = (rate_hz=48_000, *, full_scale=None, channel_map=None))]
    fn drive<'py>(
        &self,
        py: Python<'py>,
        rate_hz: u32,
        full_scale: Option<f64>,
        channel_map: Option<Vec<(usize, String, f64)>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let asked = (rate_hz, "f32".into(), full_scale, channel_map);
        Ok(self.made(py, asked)?.0.drive.into_pyarray(py))
    }

    /// Writes what a rig plays: .wav with a .json beside it (both or none), .csv or .npz.
    ///
    /// Parameters
    /// ----------
    /// path : path
    ///     File to write.
    /// rate_hz : int
    ///     Frames per second.
    /// format : {"f32", "i24", "i16"}
    ///     Samples of a sound file.
    /// full_scale : float, optional
    ///     What a sample of 1 means, N or V; without it the smallest round number above the peak.
    /// channel_map : sequence of (int, str, float), optional
    ///     Rows (channel, reference, gain).
    /// force : bool
    ///     Overwrite the files.
    #[pyo3(signature = (path, rate_hz=48_000, *, format="f32", full_scale=None, channel_map=None, force=false))]
    #[allow(clippy::too_many_arguments)] // keywords of Python
    fn save(
        &self,
        py: Python<'_>,
        path: PathBuf,
        rate_hz: u32,
        format: &str,
        full_scale: Option<f64>,
        channel_map: Option<Vec<(usize, String, f64)>>,
        force: bool,
    ) -> PyResult<()> {
        let asked = (rate_hz, format.to_owned(), full_scale, channel_map);
        let (signal, format) = self.made(py, asked)?;
        let written = match extension_of(&path).as_str() {
            "csv" => {
                let text = signal.csv();
                write_atomically(&path, force, |out| out.write_all(text.as_bytes()))
            }
            "npz" => {
                let drive = signal.driven();
                let values: Vec<f64> = drive.iter().copied().collect();
                let shape = drive.shape().to_vec();
                let channels = &signal.sidecar.channels;
                let names = channels.iter().map(|channel| channel.reference.to_string());
                let units = channels.iter().map(|channel| channel.unit.to_string());
                let rate = [f64::from(rate_hz)];
                let arrays = [
                    ("drive", NamedArray::Numbers(&values, shape)),
                    ("rate_hz", NamedArray::Numbers(&rate, Vec::new())),
                    ("reference", NamedArray::Texts(names.collect())),
                    ("unit", NamedArray::Texts(units.collect())),
                ];
                write_npz(&path, &arrays, force)
            }
            "wav" => signal.sidecar.to_json().and_then(|text| {
                let bytes = signal.wav(format)?;
                let sidecar = path.with_extension("json");
                let files: [(&Path, &[u8]); 2] = [(&path, &bytes), (&sidecar, text.as_bytes())];
                write_together(&files, force)
            }),
            _ => return Err(wrong_extension(py, &path, ".wav, .csv or .npz")),
        };
        written.map_err(|error| raised(py, &error))
    }

    fn __repr__(&self) -> String {
        let indices = &self.played.indices;
        format!(
            "Playing({} actuators, {:.3} s, ramps of {:.0} ms, {})",
            self.played.references.len(),
            self.played.length_s,
            1e3 * indices.ramp_s,
            if self.played.feasible {
                "feasible"
            } else {
                "not feasible"
            }
        )
    }
}

fn levels(trace: &[Option<f64>]) -> Vec<f64> {
    trace
        .iter()
        .map(|level| level.unwrap_or(f64::NAN))
        .collect()
}

/// The drive over time of a scene with a table [time].
///
/// rendering: steady weights of the scene's own zones, where they are known. ramps:
/// "modal", "plain" or "program" in place of the scene's. method: how steady weights are
/// found.
#[pyfunction]
#[pyo3(signature = (model, scene, *, rendering=None, ramps=None, method="default"))]
pub fn play(
    py: Python<'_>,
    model: &Model,
    scene: &Bound<'_, PyAny>,
    rendering: Option<&Rendering>,
    ramps: Option<&str>,
    method: &str,
) -> PyResult<Playing> {
    let ramps = ramps
        .map(|name| {
            Ramps::ALL
                .into_iter()
                .find(|ramps| ramps.as_str() == name)
                .ok_or_else(|| wrong_word(py, "ramps", name, "not modal, plain or program"))
        })
        .transpose()?;
    let options = PlayOptions {
        ramps,
        render: RenderOptions {
            method: method_of(py, method)?,
            ..RenderOptions::default()
        },
        ..PlayOptions::default()
    };
    let scene = scene_of(py, scene)?;
    let weights = rendering.map(|rendering| &rendering.0.weights);
    let played = detached(py, || {
        chladni_render::play(&model.model, &scene, weights, &options)
    })?;
    Ok(Playing {
        played: Arc::new(played.map_err(|error| raised(py, &error))?),
        scene: scene.name(),
    })
}
