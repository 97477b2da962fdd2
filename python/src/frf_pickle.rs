//! FRF sets on their way to other processes: as their arrays, and the rest in plain
//! tuples.

use crate::arrays::{dofs, kind_of, unit, values_of, Word};
use crate::error::raised;
use crate::findings::findings_json;
use crate::frf::{lent, FrfSet};
use chladni_frf::{BlockWindow, Error, Estimation, Forcing, Geometry, Node};
use numpy::{PyReadonlyArray1, PyReadonlyArray3};
use pyo3::prelude::*;

/// frequency_hz, values, coherence, variance.
pub type Arrays<'py> = (
    Bound<'py, PyAny>,
    Bound<'py, PyAny>,
    Option<Bound<'py, PyAny>>,
    Option<Bound<'py, PyAny>>,
);
/// Responses, references, kind, reference unit.
pub type Names = (Vec<String>, Vec<String>, Option<String>, String);
/// Nodes, lines, faces.
pub type Places = (Vec<(u64, [f64; 3])>, Vec<Vec<u64>>, Vec<Vec<u64>>);
/// Estimator; window and its rate; course of the force and its part; length, gate and
/// hop in s; averages; lines per value.
pub type Made = (
    String,
    (String, Option<f64>),
    Option<(String, Option<f64>)>,
    [f64; 3],
    [usize; 2],
    usize,
);
/// Arrays, names, places, estimation, and findings as JSON.
pub type Parts<'py> = (Arrays<'py>, Names, Places, Option<Made>, String);

/// The parts of a set. Its arrays are lent, read-only.
pub fn parts_of<'py>(frf: &Bound<'py, FrfSet>) -> PyResult<Parts<'py>> {
    let (held, set) = (frf.get(), &frf.get().set);
    let arrays = (
        frf.getattr("frequency_hz")?,
        frf.getattr("values")?,
        set.coherence
            .as_ref()
            .map(|values| lent(frf, values).into_any()),
        set.variance
            .as_ref()
            .map(|values| lent(frf, values).into_any()),
    );
    let names = (
        set.responses.iter().map(ToString::to_string).collect(),
        set.references.iter().map(ToString::to_string).collect(),
        set.kind.map(|kind| kind.to_string()),
        set.reference_unit.to_string(),
    );
    let geometry = &set.geometry;
    let nodes = geometry.nodes.iter().map(|node| (node.label, node.xyz_m));
    let places = (
        nodes.collect(),
        geometry.lines.clone(),
        geometry.faces.clone(),
    );
    let findings = findings_json(&held.findings)?;
    Ok((arrays, names, places, set.estimation.map(told), findings))
}

/// The set of these parts.
pub fn of_parts(py: Python<'_>, parts: Parts<'_>) -> PyResult<FrfSet> {
    let (arrays, names, (nodes, lines, faces), estimation, findings) = parts;
    let (frequency_hz, values, coherence, variance) = arrays;
    let (responses, references, kind, reference_unit) = names;
    let values = values_of(py, &values)?;
    let (rows, columns, _) = values.dim();
    let frequency_hz: PyReadonlyArray1<'_, f64> = frequency_hz.extract()?;
    let coherence: Option<PyReadonlyArray3<'_, f32>> =
        coherence.map(|values| values.extract()).transpose()?;
    let variance: Option<PyReadonlyArray3<'_, f64>> =
        variance.map(|values| values.extract()).transpose()?;
    let estimation = estimation.map(|made| estimation_of(made).ok_or_else(|| damaged(py)));
    let node = |(label, xyz_m)| Node { label, xyz_m };
    let set = chladni_frf::FrfSet {
        frequency_hz: frequency_hz.as_array().to_owned(),
        values,
        responses: dofs(py, "responses", Some(responses), 1, rows)?,
        references: dofs(py, "references", Some(references), 1, columns)?,
        kind: kind
            .map(|kind| kind_of(py, &Word::from(kind.as_str())))
            .transpose()?,
        reference_unit: unit(py, &Word::from(reference_unit.as_str()))?,
        coherence: coherence.map(|values| values.as_array().to_owned()),
        variance: variance.map(|values| values.as_array().to_owned()),
        estimation: estimation.transpose()?,
        geometry: Geometry {
            nodes: nodes.into_iter().map(node).collect(),
            lines,
            faces,
        },
    };
    Ok(FrfSet {
        set: set.checked().map_err(|error| raised(py, &error))?,
        findings: serde_json::from_str(&findings).map_err(|_| damaged(py))?,
    })
}

fn told(made: Estimation) -> Made {
    let forcing = |forcing: Forcing| (forcing.name().to_owned(), forcing.part());
    (
        made.estimator.name().to_owned(),
        (made.window.name().to_owned(), made.window.rate_per_s()),
        made.forcing.map(forcing),
        [made.transform_s, made.gate_s, made.hop_s],
        made.averages,
        made.lines_per_value,
    )
}

fn estimation_of(made: Made) -> Option<Estimation> {
    let (estimator, (window, rate_per_s), forcing, times_s, averages, lines_per_value) = made;
    let [transform_s, gate_s, hop_s] = times_s;
    let forcing = match forcing {
        Some((name, part)) => Some(Forcing::named(&name, part)?),
        None => None,
    };
    Some(Estimation {
        estimator: estimator.parse().ok()?,
        window: BlockWindow::named(&window, rate_per_s)?,
        forcing,
        transform_s,
        gate_s,
        hop_s,
        averages,
        lines_per_value,
    })
}

fn damaged(py: Python<'_>) -> PyErr {
    let error = Error::bad_data("no FRF set, or a damaged one").expected("what pickle wrote");
    raised(py, &error)
}
