//! Arrays and words of a caller: FRFs, nodes, DOFs, kinds and units.

use crate::error::{raised, wrong_option, wrong_word};
use crate::memory::check_room;
use chladni_frf::{Direction, Dof, Error, ErrorKind, FrfKind, FrfValues, Node, ReferenceUnit};
use ndarray::{Array1, Array3, ArrayView3};
use num_complex::{Complex32, Complex64};
use numpy::{
    PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray3,
    PyUntypedArray, PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

/// Array of real numbers, float64: what a caller gave as a list, or in another type of
/// number.
///
/// * `field`: the argument that errors name
#[pyfunction]
pub fn float64<'py>(
    field: &str,
    values: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let array = any_array(field, values, "real numbers")?;
    if !matches!(array.dtype().kind(), b'i' | b'u' | b'f') {
        let found = format!("values of the type {}", array.dtype());
        return Err(no_array(values.py(), field, found, "real numbers"));
    }
    let made = values
        .py()
        .import("numpy")?
        .call_method1("asarray", (array, "float64"))?;
    Ok(made.cast_into::<PyArrayDyn<f64>>()?)
}

/// NumPy's array of `values`, of whatever type; NaN where values are masked.
fn any_array<'py>(
    field: &str,
    values: &Bound<'py, PyAny>,
    expected: &str,
) -> PyResult<Bound<'py, PyUntypedArray>> {
    let py = values.py();
    let unmasked = unmasked(values);
    let made = unmasked.and_then(|values| py.import("numpy")?.call_method1("asarray", (values,)));
    made.and_then(|array| Ok(array.cast_into::<PyUntypedArray>()?))
        .map_err(|error| no_array(py, field, error.value(py), expected))
}

/// The values, with NaN for those that a mask hides.
fn unmasked<'py>(values: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let masks = values.py().import("numpy")?.getattr("ma")?;
    let is_list = values.is_instance_of::<PyList>() || values.is_instance_of::<PyTuple>();
    let values = &match is_list {
        true => masks.call_method1("array", (values,))?,
        false => values.clone(),
    };
    if !masks.call_method1("is_masked", (values,))?.is_truthy()? {
        return Ok(values.clone());
    }
    let is_whole = matches!(
        values.getattr("dtype")?.getattr("kind")?.extract()?,
        'i' | 'u'
    );
    let values = match is_whole {
        true => values.call_method1("astype", ("float64",))?,
        false => values.clone(),
    };
    masks.call_method1("filled", (values, f64::NAN))
}

fn no_array(
    py: Python<'_>,
    field: &str,
    found: impl std::fmt::Display,
    expected: impl std::fmt::Display,
) -> PyErr {
    let error = Error::new(ErrorKind::Usage, "no array that can be used").field(field);
    raised(py, &error.found(found).expected(expected))
}

/// Frequency axis, Hz: finite, not negative.
pub fn axis_of(values: &Bound<'_, PyAny>) -> PyResult<Array1<f64>> {
    const FIELD: &str = "frequency_hz";
    let array = float64(FIELD, values)?;
    let lines: PyReadonlyArray1<'_, f64> = array.extract().map_err(|_| {
        let found = format!("{} axes", array.ndim());
        no_array(values.py(), FIELD, found, "one axis: line")
    })?;
    check_room::<f64>(
        values.py(),
        FIELD,
        array.shape(),
        "take fewer lines at a time",
    )?;
    let lines = lines.as_array().to_owned();
    match lines.iter().find(|hz| !(hz.is_finite() && **hz >= 0.0)) {
        None => Ok(lines),
        Some(hz) => {
            let error = Error::new(ErrorKind::Usage, "no frequency").field(FIELD);
            let expected = "finite numbers of Hz, 0 or more";
            Err(raised(values.py(), &error.found(hz).expected(expected)))
        }
    }
}

/// FRFs in either precision: at least one response, reference and line.
pub fn values_of(py: Python<'_>, values: &Bound<'_, PyAny>) -> PyResult<FrfValues> {
    const FIELD: &str = "values";
    const EXPECTED: &str = "complex128 or complex64, three axes: response, reference, line";
    let array = any_array(FIELD, values, EXPECTED)?;
    let found = format!("{} axes of {}", array.ndim(), array.dtype());
    let is_frf = array.ndim() == 3 && array.dtype().kind() == b'c';
    if !is_frf {
        return Err(no_array(py, FIELD, found, EXPECTED));
    }
    if array.len() == 0 {
        let found = format!("the shape {:?}", array.shape());
        let expected = "at least one response, reference and line";
        return Err(no_array(py, FIELD, found, expected));
    }
    // either byte order; numbers of another precision become double ones
    let is_single = array.dtype().itemsize() == size_of::<Complex32>();
    const HELP: &str =
        "take fewer FRFs or lines, complex64, or reduce_block for one part at a time";
    let native = |name: &str| {
        let numpy = py.import("numpy")?;
        numpy.call_method1("asarray", (&array, name))
    };
    if is_single {
        check_room::<Complex32>(py, FIELD, array.shape(), HELP)?;
        let values: PyReadonlyArray3<'_, Complex32> = native("complex64")?.extract()?;
        return Ok(FrfValues::F32(standard(values.as_array())));
    }
    check_room::<Complex64>(py, FIELD, array.shape(), HELP)?;
    let values: PyReadonlyArray3<'_, Complex64> = native("complex128")?.extract()?;
    Ok(FrfValues::F64(standard(values.as_array())))
}

/// A copy with lines side by side.
fn standard<T: Clone>(values: ArrayView3<'_, T>) -> Array3<T> {
    values.as_standard_layout().into_owned()
}

/// Nodes 1, 2, ... at the places of the rows, m.
pub fn nodes_of(places: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<Node>> {
    const FIELD: &str = "nodes_m";
    let Some(places) = places else {
        return Ok(Vec::new());
    };
    let wrong = |message: &str, found: String, expected: &str| {
        let error = Error::new(ErrorKind::Usage, message).field(FIELD);
        Err(raised(places.py(), &error.found(found).expected(expected)))
    };
    let array = float64(FIELD, places)?;
    if array.ndim() != 2 || array.shape()[1] != 3 {
        let found = format!("the shape {:?}", array.shape());
        return wrong(
            "positions have three coordinates",
            found,
            "a row x, y, z in m for each node",
        );
    }
    let values: Vec<f64> = array.readonly().as_array().iter().copied().collect();
    let nodes: Vec<Node> = (1..)
        .zip(values.chunks_exact(3))
        .map(|(label, row)| Node {
            label,
            xyz_m: [row[0], row[1], row[2]],
        })
        .collect();
    match nodes
        .iter()
        .find(|node| !node.xyz_m.iter().all(|x| x.is_finite()))
    {
        None => Ok(nodes),
        Some(node) => wrong(
            "a node without a place",
            format!("{:?} for node {}", node.xyz_m, node.label),
            "finite coordinates in m for every node, or no nodes_m",
        ),
    }
}

/// DOFs by name, or nodes from `first` on along +Z.
pub fn dofs(
    py: Python<'_>,
    field: &str,
    names: Option<Vec<String>>,
    first: u64,
    count: usize,
) -> PyResult<Vec<Dof>> {
    match names {
        None => Ok((first..first + count as u64)
            .map(|node| Dof::new(node, Direction::PLUS_Z))
            .collect()),
        Some(names) => names
            .iter()
            .map(|name| {
                name.parse()
                    .map_err(|message: <Dof as std::str::FromStr>::Err| {
                        wrong_word(py, field, name, &message.to_string())
                    })
            })
            .collect(),
    }
}

/// A word of a caller. Another value is held as Python writes it (`None`), so that it is
/// refused as a wrong word is.
pub struct Word(String);

impl From<&str> for Word {
    fn from(text: &str) -> Self {
        Self(text.into())
    }
}

impl<'a, 'py> FromPyObject<'a, 'py> for Word {
    type Error = PyErr;

    fn extract(value: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let text = match value.extract::<String>() {
            Ok(text) => text,
            Err(_) => value.repr()?.to_string(),
        };
        Ok(Self(text))
    }
}

/// Unit of the references by its name.
pub fn unit(py: Python<'_>, Word(text): &Word) -> PyResult<ReferenceUnit> {
    match text.as_str() {
        "N" => Ok(ReferenceUnit::Newton),
        "V" => Ok(ReferenceUnit::Volt),
        _ => Err(wrong_word(
            py,
            "reference_unit",
            text,
            "no unit of a reference; write N or V",
        )),
    }
}

/// FRF kind by its name.
pub fn kind_of(py: Python<'_>, Word(text): &Word) -> PyResult<FrfKind> {
    text.parse::<FrfKind>()
        .map_err(|message| wrong_word(py, "kind", text, &message.to_string()))
}

/// A whole number that is not negative; `None` stays `None`.
///
/// * `field`: the argument that errors name
/// * `message`, `expected`: the words of the error about another value
pub fn whole_number(
    field: &str,
    value: Option<&Bound<'_, PyAny>>,
    [message, expected]: [&str; 2],
) -> PyResult<Option<usize>> {
    let Some(value) = value else {
        return Ok(None);
    };
    let Ok(number) = value.extract::<usize>() else {
        let error = Error::new(ErrorKind::Usage, message).found(value.repr()?);
        return Err(wrong_option(value.py(), field, error.expected(expected)));
    };
    Ok(Some(number))
}
