//! Modal models: loaded, selected, compared, and what notebooks ask of them.

use crate::arrays::axis_of;
use crate::detached::detached;
use crate::error::{raised, unfitted, wrong_option, wrong_word};
use crate::findings::{findings_json, warn};
use crate::frf::FrfSet;
use crate::memory::check_room;
use crate::progress::telling;
use chladni_frf::{Damping, Error, ErrorKind, ModalModel, Mode, Scaling, ShapeSet, Trust};
use chladni_io::{read_model, write_model};
use chladni_rfp::{CompareOptions, FitOptions, Method};
use ndarray::{Array1, Array2};
use num_complex::Complex64;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;
use pyo3::types::PyType;
use std::path::PathBuf;

/// A modal model. Arrays hold the modes of the band (sure and weak) by rising frequency;
/// to_dict() holds all.
#[pyclass(frozen, module = "chladni")]
pub struct Model {
    pub model: ModalModel,
}

impl Model {
    pub fn new(model: ModalModel) -> Self {
        Self { model }
    }

    fn modes(&self) -> Vec<&Mode> {
        self.model.in_band_modes().collect()
    }

    fn numbers<'py>(
        &self,
        py: Python<'py>,
        of: impl Fn(&Mode) -> f64,
    ) -> Bound<'py, PyArray1<f64>> {
        self.model
            .in_band_modes()
            .map(of)
            .collect::<Array1<f64>>()
            .into_pyarray(py)
    }

    fn rows<'py>(
        &self,
        py: Python<'py>,
        columns: usize,
        of: impl Fn(&Mode) -> &Vec<Complex64>,
    ) -> Bound<'py, PyArray2<Complex64>> {
        let modes = self.modes();
        Array2::from_shape_fn((modes.len(), columns), |(n, i)| of(modes[n])[i]).into_pyarray(py)
    }
}

#[pymethods]
impl Model {
    /// Undamped natural frequencies, Hz: (mode,).
    #[getter]
    fn frequency_hz<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.numbers(py, |mode| mode.frequency_hz)
    }

    /// Their standard deviations, Hz: (mode,).
    #[getter]
    fn frequency_std_hz<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.numbers(py, |mode| mode.frequency_std_hz)
    }

    /// Loss factors: (mode,).
    #[getter]
    fn loss_factor<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.numbers(py, |mode| mode.loss_factor)
    }

    /// Their standard deviations: (mode,).
    #[getter]
    fn loss_factor_std<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.numbers(py, |mode| mode.loss_factor_std)
    }

    /// Damping ratios, half the loss factors: (mode,).
    #[getter]
    fn damping_ratio<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.numbers(py, |mode| mode.damping_ratio)
    }

    /// Mode shapes: (mode, response).
    #[getter]
    fn shapes<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<Complex64>> {
        self.rows(py, self.model.responses.len(), |mode| &mode.shape.0)
    }

    /// Standard deviations of the shapes: (mode, response).
    #[getter]
    fn shapes_std<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let modes = self.modes();
        let value = |(n, i): (usize, usize)| modes[n].shape_std.get(i).copied().unwrap_or(f64::NAN);
        Array2::from_shape_fn((modes.len(), self.model.responses.len()), value).into_pyarray(py)
    }

    /// Participations: (mode, reference).
    #[getter]
    fn participations<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<Complex64>> {
        self.rows(py, self.model.references.len(), |mode| {
            &mode.participation.0
        })
    }

    /// "sure" or "weak" of each mode.
    #[getter]
    fn trust(&self) -> Vec<&'static str> {
        self.model
            .in_band_modes()
            .map(|mode| {
                if mode.trust == Trust::Sure {
                    "sure"
                } else {
                    "weak"
                }
            })
            .collect()
    }

    /// Reasons that a mode is not sure, a list for each mode.
    #[getter]
    fn reasons(&self) -> Vec<Vec<String>> {
        self.model
            .in_band_modes()
            .map(|mode| mode.reasons.sentences())
            .collect()
    }

    /// False where no mode is sure, or the data as a whole contradict the model.
    #[getter]
    fn trusted(&self) -> bool {
        self.model.quality.trusted
    }

    /// Rms residual over rms data.
    #[getter]
    fn relative_error(&self) -> f64 {
        self.model.quality.relative_error
    }

    /// χ² per degree of freedom.
    #[getter]
    fn chi2_per_dof(&self) -> f64 {
        self.model.quality.chi2_per_dof
    }

    /// Poles of the viscous law with these frequencies and damping ratios, rad/s: (mode,).
    #[getter]
    fn poles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<Complex64>> {
        let poles = self.model.in_band_modes().map(Mode::viscous_pole);
        poles.collect::<Array1<_>>().into_pyarray(py)
    }

    /// Fitted band, Hz.
    #[getter]
    fn band_hz(&self) -> (f64, f64) {
        let [low, high] = self.model.band_hz;
        (low, high)
    }

    /// receptance, mobility or accelerance: the kind of the FRFs that were fitted.
    #[getter]
    fn kind(&self) -> &'static str {
        self.model.frf_kind.as_str()
    }

    /// Unit of the references, N or V.
    #[getter]
    fn reference_unit(&self) -> String {
        self.model.reference_unit.to_string()
    }

    /// unit_modal_mass where a driving point or the panel set the scale, else unscaled.
    #[getter]
    fn scaling(&self) -> &'static str {
        match self.model.scaling {
            Scaling::UnitModalMass => "unit_modal_mass",
            Scaling::Unscaled => "unscaled",
        }
    }

    /// Positions of the responses, m, NaN where they are not known: (response, 3).
    #[getter]
    fn points_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let places: std::collections::HashMap<u64, [f64; 3]> = self
            .model
            .nodes
            .iter()
            .map(|node| (node.label, node.xyz_m))
            .collect();
        let responses = &self.model.responses;
        let coordinate = |(i, axis): (usize, usize)| {
            (places.get(&responses[i].node)).map_or(f64::NAN, |place| place[axis])
        };
        Array2::from_shape_fn((responses.len(), 3), coordinate).into_pyarray(py)
    }

    /// structural or viscous.
    #[getter]
    fn damping(&self) -> &'static str {
        match self.model.damping {
            Damping::Structural => "structural",
            Damping::Viscous => "viscous",
        }
    }

    /// The sentences of cautions and faults.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.model.quality.warnings()
    }

    /// All findings as JSON.
    fn _findings(&self) -> PyResult<String> {
        findings_json(&self.model.quality.findings)
    }

    /// Names of the response DOFs.
    #[getter]
    fn responses(&self) -> Vec<String> {
        self.model
            .responses
            .iter()
            .map(ToString::to_string)
            .collect()
    }

    /// Names of the reference DOFs.
    #[getter]
    fn references(&self) -> Vec<String> {
        self.model
            .references
            .iter()
            .map(ToString::to_string)
            .collect()
    }

    /// FRFs of the model, in the kind that it was fitted in.
    ///
    /// Parameters
    /// ----------
    /// frequency_hz : array_like of float, shape (line,)
    ///     Lines, Hz.
    ///
    /// Returns
    /// -------
    /// ndarray of complex128, shape (response, reference, line)
    ///     NaN at 0 Hz where the model moves as a rigid body, too.
    fn synthesise<'py>(
        &self,
        py: Python<'py>,
        frequency_hz: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray3<Complex64>>> {
        let lines = axis_of(frequency_hz)?;
        let [responses, references] = [&self.model.responses, &self.model.references].map(Vec::len);
        let shape = [responses, references, lines.len()];
        check_room::<Complex64>(py, "frequency_hz", &shape, "take fewer lines at a time")?;
        Ok(py.detach(|| self.model.synthesise(&lines)).into_pyarray(py))
    }

    /// One FRF of `synthesise`, by the places of its DOFs: (line,).
    fn _synthesise_one<'py>(
        &self,
        py: Python<'py>,
        response: usize,
        reference: usize,
        frequency_hz: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<Complex64>>> {
        let lines = axis_of(frequency_hz)?;
        let frf = py.detach(|| {
            let pair = self.model.at_dofs(&[response], &[reference]);
            pair.synthesise(&lines).into_iter().collect::<Array1<_>>()
        });
        Ok(frf.into_pyarray(py))
    }

    /// MAC between the shapes of this model and of another at the DOFs that both have, paired by
    /// name.
    ///
    /// Parameters
    /// ----------
    /// other : Model, optional
    ///     This model itself without one.
    ///
    /// Returns
    /// -------
    /// ndarray of float64, shape (mode, mode of the other)
    #[pyo3(signature = (other=None))]
    fn mac<'py>(
        &self,
        py: Python<'py>,
        other: Option<&Self>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let sets = [self, other.unwrap_or(self)].map(|model| ShapeSet::from(&model.model));
        let options = CompareOptions {
            pair_dofs: chladni_rfp::PairDofs::Name,
            ..CompareOptions::default()
        };
        let compared = detached(py, || chladni_rfp::compare(&sets[0], &sets[1], &options))?;
        let comparison = compared.map_err(|error| raised(py, &error))?;
        Ok(comparison.mac_matrix(|mac| mac.value).into_pyarray(py))
    }

    /// The model file's text.
    fn to_json(&self) -> PyResult<String> {
        serde_json::to_string(&self.model)
            .map_err(|error| pyo3::exceptions::PyRuntimeError::new_err(error.to_string()))
    }

    /// Writes the model.
    ///
    /// Parameters
    /// ----------
    /// path : path
    ///     .json or .h5.
    /// force : bool
    ///     Overwrite it.
    #[pyo3(signature = (path, *, force=false))]
    fn save(&self, py: Python<'_>, path: PathBuf, force: bool) -> PyResult<()> {
        detached(py, || write_model(&path, &self.model, force))?.map_err(|error| raised(py, &error))
    }

    /// Pickled as the model file's text.
    fn __reduce__(slf: &Bound<'_, Self>) -> PyResult<(Py<PyAny>, (String,))> {
        Ok((
            slf.get_type().getattr("_from_json")?.unbind(),
            (slf.get().to_json()?,),
        ))
    }

    /// The model of a text of `to_json`.
    #[classmethod]
    fn _from_json(class: &Bound<'_, PyType>, text: &str) -> PyResult<Self> {
        serde_json::from_str(text).map(Self::new).map_err(|error| {
            let error = Error::bad_data("no model, or a damaged one")
                .found(error)
                .expected("the text of a model file");
            raised(class.py(), &error)
        })
    }

    fn __len__(&self) -> usize {
        self.modes().len()
    }

    fn __repr__(&self) -> String {
        let [low, high] = self.model.band_hz;
        let trusted = if self.model.quality.trusted {
            "trusted"
        } else {
            "not trusted"
        };
        format!(
            "Model({} modes from {low} to {high} Hz, {}, {trusted})",
            self.modes().len(),
            self.damping()
        )
    }
}

/// The model with the modes that a selection (TOML) keeps, fitted anew to `frf` where it
/// adds some.
#[pyfunction]
#[pyo3(signature = (model, selection, frf=None))]
pub fn select(
    py: Python<'_>,
    model: &Model,
    selection: &str,
    frf: Option<&FrfSet>,
) -> PyResult<Model> {
    let failed = |error: Error| raised(py, &error);
    let before = &model.model;
    let mut selection = chladni_io::selection_from_toml(selection).map_err(failed)?;
    let mut again = None;
    if let (Some(frf), false) = (frf, selection.added_hz().is_empty()) {
        let options = FitOptions::adding_to(before, selection.added_hz());
        if options.method != Method::Auto {
            let error = Error::bad_data("modes are added to fits of the method auto");
            let error = error.field("model").found(options.method).expected("auto");
            return Err(failed(error.help("fit again without `method`")));
        }
        let unlike = detached(py, || chladni_report::unlike(before, &frf.set))?;
        let of_argument = |error: Error| Error {
            field: Some("frf".into()),
            help: Some("give the FRFs that the model was fitted to".into()),
            ..error
        };
        if let Some(finding) = unlike.map_err(of_argument).map_err(failed)? {
            warn(py, &finding)?;
        }
        let fitted = telling(py, None, |tell, stop| {
            chladni_rfp::fit_watched(&frf.set, &options, tell, stop)
        })?;
        let mut fitted = fitted
            .map_err(|error| unfitted(py, &error, &options))?
            .model;
        fitted.source.clone_from(&before.source);
        fitted.options.clone_from(&before.options);
        selection = selection.carried(before, &fitted).map_err(failed)?;
        again = Some(fitted);
    }
    let selected = selection.apply(again.as_ref().unwrap_or(before));
    selected
        .map(|selected| Model::new(selected.model))
        .map_err(failed)
}

/// Modes, of a model or of a file with shapes.
fn shape_set(py: Python<'_>, modes: &Bound<'_, PyAny>) -> PyResult<ShapeSet> {
    if let Ok(model) = modes.cast::<Model>() {
        return Ok(ShapeSet::from(&model.get().model));
    }
    let path: PathBuf = modes.extract()?;
    detached(py, || chladni_io::read_shape_set(&path))?
        .map(|(set, _)| set)
        .map_err(|error| raised(py, &error))
}

/// Two sets of modes side by side, as a JSON text.
#[pyfunction]
pub fn compare(
    py: Python<'_>,
    a: &Bound<'_, PyAny>,
    b: &Bound<'_, PyAny>,
    pair_dofs: &str,
    least_mac: f64,
) -> PyResult<String> {
    if !(0.0..=1.0).contains(&least_mac) {
        let error = Error::new(ErrorKind::Usage, "no MAC").found(least_mac);
        let error = error.expected("a number from 0 to 1, such as 0.8");
        return Err(wrong_option(py, "least_mac", error));
    }
    let options = CompareOptions {
        pair_dofs: pair_dofs
            .parse()
            .map_err(|message: String| wrong_word(py, "pair_dofs", pair_dofs, &message))?,
        least_mac,
    };
    let (a, b) = (shape_set(py, a)?, shape_set(py, b)?);
    detached(py, || chladni_rfp::compare(&a, &b, &options))?
        .map(|comparison| comparison.to_json().to_string())
        .map_err(|error| raised(py, &error))
}

/// Reads a model file.
///
/// Parameters
/// ----------
/// path : path
///     .json or .h5.
///
/// Returns
/// -------
/// Model
#[pyfunction]
pub fn load_model(py: Python<'_>, path: PathBuf) -> PyResult<Model> {
    detached(py, || read_model(&path))?
        .map(Model::new)
        .map_err(|error| raised(py, &error))
}
