//! FRF sets: read, simulated, or made of NumPy arrays.

use crate::arrays::{axis_of, dofs, kind_of, nodes_of, unit, values_of, Word};
use crate::detached::detached;
use crate::error::{raised, wrong_word};
use crate::findings::{findings_json, sentences};
use crate::frf_pickle::{of_parts, parts_of, Arrays, Made, Names, Parts, Places};
use chladni_frf::{Finding, FrfKind, FrfValues, Geometry};
use chladni_io::{read_frf, write_frf, DeclaredDofs, DeclaredRow, ReadOptions};
use ndarray::{Array, Dimension};
use numpy::{Element, IntoPyArray, PyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyType;
use std::path::PathBuf;
use std::str::FromStr;

/// FRFs of a structure in SI units of the kind, per N or V.
///
/// With a driving point (a reference that is also a response), shapes are scaled to unit modal
/// mass. A set pickles.
///
/// Parameters
/// ----------
/// frequency_hz : array_like of float, shape (line,)
///     Lines, Hz.
/// values : array_like of complex, shape (response, reference, line)
///     The FRFs; complex64 stays what it is, in the byte order of the machine.
/// responses, references : list of str, optional
///     Names such as ``"12:+Z"`` (node 12, +Z); without them responses are nodes 1, 2, ...
///     and references the nodes after those.
/// kind : {"mobility", "receptance", "accelerance"}
///     What they are.
/// reference_unit : {"N", "V"}
///     Unit of the references.
/// nodes_m : array_like of float, shape (node, 3), optional
///     Positions of nodes 1, 2, ..., m.
#[pyclass(frozen, module = "chladni")]
pub struct FrfSet {
    pub set: chladni_frf::FrfSet,
    /// Findings about the files.
    pub findings: Vec<Finding>,
}

#[pymethods]
impl FrfSet {
    #[new]
    #[pyo3(
        signature = (frequency_hz, values, *, responses=None, references=None, kind=Word::from("mobility"), reference_unit=Word::from("N"), nodes_m=None),
        text_signature = "(frequency_hz, values, *, responses=None, references=None, kind='mobility', reference_unit='N', nodes_m=None)"
    )]
    #[allow(clippy::too_many_arguments)] // keywords on the Python side
    fn new(
        py: Python<'_>,
        frequency_hz: &Bound<'_, PyAny>,
        values: &Bound<'_, PyAny>,
        responses: Option<Vec<String>>,
        references: Option<Vec<String>>,
        kind: Word,
        reference_unit: Word,
        nodes_m: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let values = values_of(py, values)?;
        let (rows, columns, _) = values.dim();
        let nodes = nodes_of(nodes_m)?;
        let set = chladni_frf::FrfSet {
            frequency_hz: axis_of(frequency_hz)?,
            values,
            responses: dofs(py, "responses", responses, 1, rows)?,
            references: dofs(py, "references", references, rows as u64 + 1, columns)?,
            kind: Some(kind_of(py, &kind)?),
            reference_unit: unit(py, &reference_unit)?,
            coherence: None,
            variance: None,
            estimation: None,
            geometry: Geometry {
                nodes,
                ..Geometry::default()
            },
        };
        Ok(Self {
            set: set.checked().map_err(|error| raised(py, &error))?,
            findings: Vec::new(),
        })
    }

    /// The sentences of cautions and faults about the files.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        sentences(&self.findings)
    }

    /// All findings as JSON.
    fn _findings(&self) -> PyResult<String> {
        findings_json(&self.findings)
    }

    /// Lines, Hz: (line,).
    #[getter]
    fn frequency_hz<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<f64>> {
        lent(slf, &slf.get().set.frequency_hz)
    }

    /// FRFs without a copy, read-only: (response, reference, line), complex128 or
    /// complex64.
    #[getter]
    fn values<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyAny> {
        match &slf.get().set.values {
            FrfValues::F64(values) => lent(slf, values).into_any(),
            FrfValues::F32(values) => lent(slf, values).into_any(),
        }
    }

    /// Names of the response DOFs.
    #[getter]
    fn responses(&self) -> Vec<String> {
        self.set.responses.iter().map(ToString::to_string).collect()
    }

    /// Names of the reference DOFs.
    #[getter]
    fn references(&self) -> Vec<String> {
        self.set
            .references
            .iter()
            .map(ToString::to_string)
            .collect()
    }

    /// receptance, mobility or accelerance; None where the file does not say.
    #[getter]
    fn kind(&self) -> Option<&'static str> {
        self.set.kind.map(FrfKind::as_str)
    }

    /// Unit of the references, N or V.
    #[getter]
    fn reference_unit(&self) -> String {
        self.set.reference_unit.to_string()
    }

    /// Positions of the nodes, m: (node, 3).
    #[getter]
    fn nodes_m<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let nodes = &self.set.geometry.nodes;
        ndarray::Array2::from_shape_fn((nodes.len(), 3), |(n, axis)| nodes[n].xyz_m[axis])
            .into_pyarray(py)
    }

    /// Pickled as its arrays, names, places, estimation and findings.
    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Parts<'py>)> {
        Ok((slf.get_type().getattr("_from_parts")?, parts_of(slf)?))
    }

    /// The set of the parts that `__reduce__` gives.
    #[classmethod]
    fn _from_parts(
        class: &Bound<'_, PyType>,
        arrays: Arrays<'_>,
        names: Names,
        places: Places,
        estimation: Option<Made>,
        findings: String,
    ) -> PyResult<Self> {
        let parts = (arrays, names, places, estimation, findings);
        of_parts(class.py(), parts)
    }

    /// Writes the set; the format follows from the name (.h5, .uff, .unv, .csv, .npz).
    ///
    /// Parameters
    /// ----------
    /// path : path
    ///     File to write.
    /// force : bool
    ///     Overwrite it.
    ///
    /// Returns
    /// -------
    /// list of str
    ///     What the format cannot hold.
    #[pyo3(signature = (path, *, force=false))]
    fn save(&self, py: Python<'_>, path: PathBuf, force: bool) -> PyResult<Vec<String>> {
        let lost = detached(py, || write_frf(&path, &self.set, force))?
            .map_err(|error| raised(py, &error))?;
        Ok(lost.into_iter().map(|finding| finding.text).collect())
    }

    fn __repr__(&self) -> String {
        let (responses, references, lines) = self.set.values.dim();
        format!(
            "FrfSet({responses} responses, {references} references, {lines} lines, {})",
            self.kind().unwrap_or("kind unknown")
        )
    }
}

/// A NumPy array of numbers that the set holds, without a copy, read-only.
pub fn lent<'py, T: Element, D: Dimension>(
    frf: &Bound<'py, FrfSet>,
    values: &Array<T, D>,
) -> Bound<'py, PyArray<T, D>> {
    // SAFETY: the set is frozen and lives as long as the array, which holds a reference to it
    let array = unsafe { PyArray::borrow_from_array(values, frf.clone().into_any()) };
    array.readwrite().make_nonwriteable();
    array
}

/// One node for all files, or one for each.
#[derive(FromPyObject)]
pub enum Nodes {
    One(u64),
    Each(Vec<u64>),
}

impl From<Nodes> for Vec<u64> {
    fn from(nodes: Nodes) -> Self {
        match nodes {
            Nodes::One(node) => vec![node],
            Nodes::Each(nodes) => nodes,
        }
    }
}

/// DOFs of all FRFs: a file of them, or rows (response, reference) or (file, response,
/// reference).
#[derive(FromPyObject)]
pub enum DofList {
    File(PathBuf),
    Rows(Vec<Vec<String>>),
}

impl DofList {
    fn declared(self, py: Python<'_>) -> PyResult<DeclaredDofs> {
        let list = match self {
            Self::File(path) => DeclaredDofs::read(&path),
            Self::Rows(rows) => rows
                .iter()
                .map(|row| DeclaredRow::of_cells(row))
                .collect::<chladni_frf::Result<Vec<_>>>()
                .map(|rows| DeclaredDofs { rows }),
        };
        list.map_err(|error| raised(py, &error))
    }
}

/// Reads files, a folder or a pattern as one FRF set.
///
/// Parameters
/// ----------
/// paths : path or sequence of path
///     Files, a folder, or a pattern.
/// frf_kind : {"mobility", "receptance", "accelerance"}, optional
///     Needed where the files do not say.
/// time_sign : {"+", "-"}
///     Sign in e^(±jωt) of the data.
/// delay_s : float
///     Delay of all responses against the references, s: it is taken off.
/// reference, response : int or sequence of int, optional
///     Node of files that hold one reference or one response: one for all, or one for each.
/// dofs : path or sequence of tuple, optional
///     DOFs of all FRFs in their order: rows (response, reference) or (file, response,
///     reference), or a file of them.
/// map : dict, optional
///     HDF5 or MATLAB names, such as ``{"frf": "/data/H"}``.
/// duplicates : {"error", "first", "last", "mean"}
///     What counts of a pair that occurs twice.
/// phase_unit : {"deg", "rad"}, optional
///     Where neither header nor numbers say.
/// snap_df : bool
///     Take the exact line spacing that the printed digits of a universal file stand for.
/// lenient : bool
///     Mask what cannot be read.
///
/// Returns
/// -------
/// FrfSet
#[pyfunction]
#[pyo3(signature = (paths, *, frf_kind=None, time_sign="+", delay_s=0.0, reference=None, response=None, dofs=None, map=None, duplicates="error", phase_unit=None, snap_df=false, lenient=false))]
#[allow(clippy::too_many_arguments)] // those of the command line
pub fn read(
    py: Python<'_>,
    paths: &Bound<'_, PyAny>,
    frf_kind: Option<&str>,
    time_sign: &str,
    delay_s: f64,
    reference: Option<Nodes>,
    response: Option<Nodes>,
    dofs: Option<DofList>,
    map: Option<std::collections::BTreeMap<String, String>>,
    duplicates: &str,
    phase_unit: Option<&str>,
    snap_df: bool,
    lenient: bool,
) -> PyResult<FrfSet> {
    let paths: Vec<PathBuf> = match paths.extract::<PathBuf>() {
        Ok(one) => vec![one],
        Err(_) => paths.extract()?,
    };
    let options = ReadOptions {
        frf_kind: frf_kind
            .map(|text| word(py, "frf_kind", text))
            .transpose()?,
        time_sign: word(py, "time_sign", time_sign)?,
        delay_s,
        references: reference.map(Vec::from).unwrap_or_default(),
        responses: response.map(Vec::from).unwrap_or_default(),
        dofs: dofs
            .map(|list| list.declared(py))
            .transpose()?
            .unwrap_or_default(),
        map: map.unwrap_or_default().into_iter().collect(),
        duplicates: word(py, "duplicates", duplicates)?,
        phase_unit: phase_unit
            .map(|text| word(py, "phase_unit", text))
            .transpose()?,
        snap_df,
        lenient,
        ..ReadOptions::default()
    };
    let (set, _, findings) =
        detached(py, || read_frf(&paths, &options))?.map_err(|error| raised(py, &error))?;
    Ok(FrfSet { set, findings })
}

/// The value that a word stands for.
fn word<T: FromStr>(py: Python<'_>, name: &str, text: &str) -> PyResult<T>
where
    T::Err: std::fmt::Display,
{
    text.parse()
        .map_err(|message: T::Err| wrong_word(py, name, text, &message.to_string()))
}
