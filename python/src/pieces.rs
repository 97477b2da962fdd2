//! The fit in pieces, with partials and poles that pickle: what Dask and its like carry
//! from one worker to the next.

use crate::detached::detached;
use crate::error::{raised, unpieced, wrong_option};
use crate::findings::warn;
use crate::fit::{band_of, count_of, decay_of, law, shape_model, window_of};
use crate::frf::FrfSet;
use crate::model::Model;
use crate::progress::telling;
use chladni_frf::{Error, ErrorKind};
use chladni_rfp::pieces::{self, Solved};
use chladni_rfp::FitOptions;
use ndarray::Array1;
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyType};
use std::borrow::Cow;

/// The products of one or more blocks of FRFs after a pass over them: a few megabytes
/// whatever the size of the blocks. Made by `reduce_block` and `merge`; pickles.
#[pyclass(frozen, module = "chladni")]
pub struct Partial(pieces::Partial);

#[pymethods]
impl Partial {
    /// Number of FRFs in its blocks.
    #[getter]
    fn frfs(&self) -> usize {
        self.0.frfs()
    }

    /// Number of its blocks.
    #[getter]
    fn blocks(&self) -> usize {
        self.0.blocks()
    }

    /// Poles of the pass; None: of the first pass.
    #[getter]
    fn poles(&self) -> Option<Poles> {
        self.0.poles().cloned().map(Poles)
    }

    /// The bytes of a partial file: the same blocks give the same bytes, whoever reduced
    /// and merged them in whatever order.
    fn to_bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &py.detach(|| self.0.to_bytes()))
    }

    /// Reads the bytes of `to_bytes`; refuses another version and damaged ones.
    ///
    /// Parameters
    /// ----------
    /// data : bytes
    ///     What `to_bytes` gave.
    #[classmethod]
    fn from_bytes(class: &Bound<'_, PyType>, data: Cow<'_, [u8]>) -> PyResult<Self> {
        let py = class.py();
        detached(py, || pieces::Partial::from_bytes(&data))?
            .map(Self)
            .map_err(|error| raised(py, &error))
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        Ok((
            slf.get_type().getattr("from_bytes")?,
            (slf.get().to_bytes(slf.py()),),
        ))
    }

    /// `7 in partial`: whether block 7 is in it.
    fn __contains__(&self, number: u64) -> bool {
        self.0.holds(number)
    }

    fn __repr__(&self) -> String {
        let pass = self.0.poles().map_or("first pass".into(), |poles| {
            format!("second pass with {} poles", poles.count())
        });
        let blocks = if self.blocks() == 1 {
            "block"
        } else {
            "blocks"
        };
        format!(
            "Partial({} {blocks}, {} FRFs, {pass})",
            self.blocks(),
            self.frfs()
        )
    }
}

/// Poles to run the second pass with. Arrays hold those of the band by rising frequency,
/// as far as the first pass tells them. Made by `solve_poles`; pickles.
#[pyclass(frozen, module = "chladni")]
pub struct Poles(pieces::Poles);

impl Poles {
    fn numbers<'py>(
        &self,
        py: Python<'py>,
        of: impl Fn(&(f64, f64)) -> f64,
    ) -> Bound<'py, PyArray1<f64>> {
        self.0
            .modes()
            .iter()
            .map(of)
            .collect::<Array1<f64>>()
            .into_pyarray(py)
    }
}

#[pymethods]
impl Poles {
    /// Undamped natural frequencies, Hz: (mode,).
    #[getter]
    fn frequency_hz<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.numbers(py, |mode| mode.0)
    }

    /// Loss factors: (mode,).
    #[getter]
    fn loss_factor<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.numbers(py, |mode| mode.1)
    }

    /// The way they were found, in words.
    #[getter]
    fn evidence(&self) -> String {
        self.0.evidence()
    }

    /// The bytes of a poles file.
    fn to_bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &py.detach(|| self.0.to_bytes()))
    }

    /// Reads the bytes of `to_bytes`; refuses another version and damaged ones.
    ///
    /// Parameters
    /// ----------
    /// data : bytes
    ///     What `to_bytes` gave.
    #[classmethod]
    fn from_bytes(class: &Bound<'_, PyType>, data: Cow<'_, [u8]>) -> PyResult<Self> {
        let py = class.py();
        detached(py, || pieces::Poles::from_bytes(&data))?
            .map(Self)
            .map_err(|error| raised(py, &error))
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyAny>, (Bound<'py, PyBytes>,))> {
        Ok((
            slf.get_type().getattr("from_bytes")?,
            (slf.get().to_bytes(slf.py()),),
        ))
    }

    fn __repr__(&self) -> String {
        let modes = self.0.modes();
        let band = match (modes.first(), modes.last()) {
            (Some(first), Some(last)) => format!(" from {:.6} to {:.6} Hz", first.0, last.0),
            _ => String::new(),
        };
        format!(
            "Poles({} in the band{band}, {})",
            modes.len(),
            self.evidence()
        )
    }
}

/// Reduces one block of FRFs to a partial: without poles for the first pass, with them for
/// the second.
///
/// Band, window and seed are the same for all blocks; with poles, they are those of the first
/// pass.
///
/// Parameters
/// ----------
/// frf : FrfSet
///     Any part of the FRFs (some responses, some references) with all lines.
/// number : int
///     Its own, 0, 1, 2, ...: it fixes the order of sums.
/// poles : Poles, optional
///     What the first pass led to.
/// band : (float, float), optional
///     Band, Hz.
/// window : str, optional
///     Window of the records that the FRFs were averaged from.
/// seed : int, optional
///     Of the random mixtures of FRFs.
/// blocks : int, optional
///     Number of all blocks, which are then 0 to ``blocks - 1``, the same for each:
///     `solve_poles` names those that are missing.
///
/// Returns
/// -------
/// Partial
#[pyfunction]
#[pyo3(signature = (frf, number, *, poles=None, band=None, window=None, seed=None, blocks=None))]
#[allow(clippy::too_many_arguments)] // keywords on the Python side
pub fn reduce_block(
    py: Python<'_>,
    frf: &FrfSet,
    number: u64,
    poles: Option<&Poles>,
    band: Option<&Bound<'_, PyAny>>,
    window: Option<&str>,
    seed: Option<u64>,
    blocks: Option<u64>,
) -> PyResult<Partial> {
    if let Some(blocks) = blocks.filter(|&blocks| number >= blocks) {
        let error = Error::new(ErrorKind::Usage, "there is no such block").found(number);
        let error = error.expected(format!("a number below {blocks}, that of all blocks"));
        return Err(wrong_option(
            py,
            "number",
            error.help("blocks are counted from 0"),
        ));
    }
    let poles = poles.map(|poles| &poles.0);
    let mut options = poles.map(pieces::Poles::options).unwrap_or_default();
    options.band_hz = band_of(py, band)?.or(options.band_hz);
    options.window = window_of(py, window)?.or(options.window);
    options.seed = seed.unwrap_or(options.seed);
    let reduced = detached(py, || {
        pieces::reduce(&frf.set, &options, number, Vec::new(), poles)
    })?;
    reduced
        .map(|partial| Partial(partial.of_blocks(blocks)))
        .map_err(|error| unpieced(py, &error, &options))
}

/// One partial of many, in whatever order and grouping: the same blocks give the same bits.
///
/// Parameters
/// ----------
/// partials : iterable of Partial
///     A list or a generator.
///
/// Returns
/// -------
/// Partial
#[pyfunction]
pub fn merge(py: Python<'_>, partials: &Bound<'_, PyAny>) -> PyResult<Partial> {
    let partials: Vec<Py<Partial>> = partials
        .try_iter()?
        .map(|partial| Ok(partial?.extract()?))
        .collect::<PyResult<_>>()?;
    let merged = detached(py, || {
        pieces::Partial::merge(partials.iter().map(|partial| partial.get().0.clone()))
    })?;
    merged.map(Partial).map_err(|error| raised(py, &error))
}

/// Solves the merged partials of all blocks: those of the first pass for Poles to reduce
/// every block with again, those of the second for the Model. Now and then the second
/// pass shows that poles must be sought once more, and its result is Poles again: repeat
/// until it is a Model.
///
/// First pass, modes: their number; None: decided by evidence. Second pass (the first
/// passes over them), damping: "structural" or "viscous"; None: decided; shapes: auto,
/// free, rank1 or real; exponential_window_per_s: decay of a hammer test's window. The
/// number of modes stays that of the first pass. progress: called with the name of each
/// stage. Blocks that are missing are a finding of the Model, and a warning of Python
/// beside Poles.
#[pyfunction]
#[pyo3(signature = (partial, *, modes=None, damping=None, shapes="auto", exponential_window_per_s=None, progress=None))]
pub fn solve_poles(
    py: Python<'_>,
    partial: &Partial,
    modes: Option<Bound<'_, PyAny>>,
    damping: Option<&str>,
    shapes: &str,
    exponential_window_per_s: Option<f64>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Py<PyAny>> {
    let options = FitOptions {
        modes: count_of(modes.as_ref())?,
        damping: law(py, damping)?,
        shapes: shape_model(py, shapes)?,
        exponential_window_per_s: decay_of(py, exponential_window_per_s)?,
        ..FitOptions::default()
    };
    let missing = partial.0.missing();
    let solved = telling(py, progress.as_ref(), |tell, stop| {
        pieces::solve_watched(partial.0.clone(), &options, tell, stop)
    })?;
    match solved.map_err(|error| unpieced(py, &error, &options))? {
        Solved::Poles(poles) => {
            missing.iter().try_for_each(|missing| warn(py, missing))?;
            Ok(Py::new(py, Poles(*poles))?.into_any())
        }
        Solved::Fit(mut fit) => {
            fit.model.quality.findings.extend(missing);
            Ok(Py::new(py, Model::new(fit.model))?.into_any())
        }
    }
}

/// The model of a block's FRFs at the poles of another model: shapes and participations are
/// fitted, poles and their error bars are taken as they are.
///
/// For FRFs measured later or elsewhere, and for asking each block how well it fits
/// (`relative_error`).
///
/// Parameters
/// ----------
/// frf : FrfSet
///     The block.
/// model : Model
///     Whose poles are taken.
/// window : str, optional
///     Window of the records that the FRFs were averaged from.
///
/// Returns
/// -------
/// Model
#[pyfunction]
#[pyo3(signature = (frf, model, *, window=None))]
pub fn residues_block(
    py: Python<'_>,
    frf: &FrfSet,
    model: &Model,
    window: Option<&str>,
) -> PyResult<Model> {
    let options = FitOptions {
        window: window_of(py, window)?,
        ..FitOptions::default()
    };
    let fitted = detached(py, || pieces::residues(&frf.set, &model.model, &options))?;
    fitted
        .map(Model::new)
        .map_err(|error| unpieced(py, &error, &options))
}
