//! Arrays and words of a caller: FRFs, nodes, DOFs, kinds and units.

use crate::error::{raised, wrong_word};
use chladni_frf::{Direction, Dof, Error, ErrorKind, FrfKind, FrfValues, Node, ReferenceUnit};
use ndarray::Array3;
use num_complex::{Complex32, Complex64};
use numpy::{PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;

/// FRFs in either precision.
pub fn values_of(py: Python<'_>, values: &Bound<'_, PyAny>) -> PyResult<FrfValues> {
    if let Ok(values) = values.extract::<PyReadonlyArray3<'_, Complex32>>() {
        return Ok(FrfValues::F32(standard(values.as_array().to_owned())));
    }
    let values: PyReadonlyArray3<'_, Complex64> = values.extract().map_err(|_| {
        let error = Error::new(ErrorKind::Usage, "values are no FRF array").field("values");
        let expected = "complex128 or complex64, three axes: response, reference, line";
        raised(py, &error.expected(expected))
    })?;
    Ok(FrfValues::F64(standard(values.as_array().to_owned())))
}

fn standard<T: Clone>(values: Array3<T>) -> Array3<T> {
    if values.is_standard_layout() {
        values
    } else {
        values.as_standard_layout().into_owned()
    }
}

/// Nodes 1, 2, ... at the places of the rows, m.
pub fn nodes_of(py: Python<'_>, places: Option<PyReadonlyArray2<'_, f64>>) -> PyResult<Vec<Node>> {
    let Some(places) = &places else {
        return Ok(Vec::new());
    };
    let places = places.as_array();
    if places.ncols() != 3 {
        let error =
            Error::new(ErrorKind::Usage, "positions have three coordinates").field("nodes_m");
        let found = format!("{} columns", places.ncols());
        return Err(raised(py, &error.found(found).expected("x, y, z in m")));
    }
    let rows = (1..).zip(places.rows());
    let node = |(label, row): (u64, ndarray::ArrayView1<f64>)| Node {
        label,
        xyz_m: [row[0], row[1], row[2]],
    };
    Ok(rows.map(node).collect())
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

/// Unit of the references by its name.
pub fn unit(py: Python<'_>, text: &str) -> PyResult<ReferenceUnit> {
    match text {
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
pub fn kind_of(py: Python<'_>, text: &str) -> PyResult<FrfKind> {
    text.parse::<FrfKind>()
        .map_err(|message| wrong_word(py, "kind", text, &message.to_string()))
}
