//! FRFs of time records, and what is read off FRFs before a fit.

use crate::arrays::{dofs, kind_of, unit, whole_number, Word};
use crate::detached::detached;
use crate::error::{raised, unfitted, wrong_word};
use crate::fit::{band_of, decay_of};
use crate::frf::FrfSet;
use chladni_frf::{
    BlockWindow, Channel, Dof, Error, ErrorKind, Estimator, FrfKind, ReferenceUnit, Run, SignalUnit,
};
use chladni_rfp::{FitOptions, Stability};
use chladni_signal::EstimateOptions;
use ndarray::{Array1, ArrayView1, ArrayView2};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

/// Words of the error about a block that is no number of samples.
const BLOCK: [&str; 2] = [
    "no possible block",
    "a whole number of samples, or None: the length is chosen",
];

/// FRFs of time records; the Python half documents it.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // keywords on the Python side
pub fn estimate(
    py: Python<'_>,
    references: Vec<PyReadonlyArray2<'_, f64>>,
    responses: Vec<PyReadonlyArray2<'_, f64>>,
    sample_rate_hz: f64,
    reference_names: Option<Vec<String>>,
    response_names: Option<Vec<String>>,
    kind: Word,
    reference_unit: Word,
    estimator: Option<&str>,
    window: Option<&str>,
    exponential_window_per_s: Option<f64>,
    block: Option<Bound<'_, PyAny>>,
    overlap: Option<f64>,
) -> PyResult<FrfSet> {
    let [drive, motion] = units_of(py, &reference_unit, &kind)?;
    check_rate(py, sample_rate_hz)?;
    let rows = |arrays: &[PyReadonlyArray2<'_, f64>]| {
        arrays.first().map_or(0, |array| array.as_array().nrows())
    };
    let (of_responses, of_references) = (rows(&responses), rows(&references));
    let response_dofs = dofs(py, "response_names", response_names, 1, of_responses)?;
    let first = of_responses as u64 + 1;
    let reference_dofs = dofs(py, "reference_names", reference_names, first, of_references)?;
    if references.len() != responses.len() {
        return Err(uneven(py, "runs", responses.len(), references.len()));
    }
    let driven = Side {
        dofs: reference_dofs,
        unit: drive,
        is_reference: true,
    };
    let measured = Side {
        dofs: response_dofs,
        unit: motion,
        is_reference: false,
    };
    let mut runs = Vec::new();
    for (references, responses) in references.iter().zip(&responses) {
        runs.push(Run {
            file: "record".into(),
            line: 0,
            sample_rate_hz,
            channels: channels(py, [references, responses], [&driven, &measured])?,
        });
    }
    let options = EstimateOptions {
        estimator: estimator_of(py, estimator)?,
        window: window_of(py, window, exponential_window_per_s)?,
        block: whole_number("block", block.as_ref(), BLOCK)?,
        overlap,
    };
    let estimated = detached(py, || chladni_signal::estimate(&runs, &options))?
        .map_err(|error| raised(py, &error))?;
    Ok(FrfSet {
        set: estimated.frf,
        findings: estimated.findings,
    })
}

/// What references and responses measure.
fn units_of(py: Python<'_>, reference_unit: &Word, kind: &Word) -> PyResult<[SignalUnit; 2]> {
    let motion = match kind_of(py, kind)? {
        FrfKind::Receptance => SignalUnit::Displacement,
        FrfKind::Mobility => SignalUnit::Velocity,
        FrfKind::Accelerance => SignalUnit::Acceleration,
    };
    let drive = match unit(py, reference_unit)? {
        ReferenceUnit::Newton => SignalUnit::Force,
        ReferenceUnit::Volt => SignalUnit::Volt,
    };
    Ok([drive, motion])
}

fn check_rate(py: Python<'_>, sample_rate_hz: f64) -> PyResult<()> {
    if !(sample_rate_hz.is_finite() && sample_rate_hz > 0.0) {
        let error = Error::new(ErrorKind::Usage, "no sampling rate")
            .field("sample_rate_hz")
            .found(sample_rate_hz);
        return Err(raised(py, &error.expected("samples per second, above 0")));
    }
    Ok(())
}

/// What the channels of references, or of responses, have in common.
struct Side {
    dofs: Vec<Dof>,
    unit: SignalUnit,
    is_reference: bool,
}

impl Side {
    fn channels(&self, signals: ArrayView2<'_, f64>) -> Vec<Channel> {
        let channel = |(&dof, samples): (&Dof, ArrayView1<'_, f64>)| Channel {
            dof,
            unit: self.unit,
            is_reference: self.is_reference,
            samples: samples.to_vec(),
        };
        self.dofs.iter().zip(signals.rows()).map(channel).collect()
    }
}

/// The channels of one run: references, then responses.
fn channels(
    py: Python<'_>,
    signals: [&PyReadonlyArray2<'_, f64>; 2],
    [driven, measured]: [&Side; 2],
) -> PyResult<Vec<Channel>> {
    let [references, responses] = signals.map(|signals| signals.as_array());
    let (drives, dofs) = (references.nrows(), driven.dofs.len());
    if drives != dofs {
        return Err(uneven(py, "references", drives, dofs));
    }
    let (motions, dofs) = (responses.nrows(), measured.dofs.len());
    if motions != dofs {
        return Err(uneven(py, "responses", motions, dofs));
    }
    if references.ncols() != responses.ncols() {
        return Err(uneven(py, "samples", responses.ncols(), references.ncols()));
    }
    let mut all = driven.channels(references);
    all.extend(measured.channels(responses));
    Ok(all)
}

fn uneven(py: Python<'_>, what: &str, found: usize, expected: usize) -> PyErr {
    let error = Error::new(ErrorKind::Usage, "records do not fit together").field(what);
    raised(py, &error.found(found).expected(expected))
}

fn estimator_of(py: Python<'_>, name: Option<&str>) -> PyResult<Option<Estimator>> {
    name.map(|name| {
        name.parse()
            .map_err(|message: String| wrong_word(py, "estimator", name, &message))
    })
    .transpose()
}

fn window_of(
    py: Python<'_>,
    name: Option<&str>,
    rate_per_s: Option<f64>,
) -> PyResult<Option<BlockWindow>> {
    match (name, decay_of(py, rate_per_s)?) {
        (None, None) => Ok(None),
        (None | Some("exponential"), Some(rate_per_s)) => {
            Ok(Some(BlockWindow::Exponential { rate_per_s }))
        }
        (Some("hann"), None) => Ok(Some(BlockWindow::Hann)),
        (Some("rectangular"), None) => Ok(Some(BlockWindow::Rectangular)),
        (name, _) => Err(wrong_word(
            py,
            "window",
            name.unwrap_or("exponential"),
            "no window that can be used; write hann, rectangular, or exponential with exponential_window_per_s",
        )),
    }
}

/// Complex mode indicator function: singular values of the FRF matrix of each line, falling.
///
/// Parameters
/// ----------
/// frf : FrfSet
///     FRFs.
///
/// Returns
/// -------
/// ndarray of float64, shape (line, singular value)
///     In the unit of the FRFs.
#[pyfunction]
pub fn cmif<'py>(py: Python<'py>, frf: &FrfSet) -> PyResult<Bound<'py, PyArray2<f64>>> {
    detached(py, || chladni_rfp::cmif(&frf.set))?
        .map(|values| values.into_pyarray(py))
        .map_err(|error| raised(py, &Error::bad_data(error.to_string()).field("values")))
}

/// Orders, natural frequencies, damping ratios, and stability of the poles of rising
/// orders.
type Diagram<'py> = (
    Bound<'py, PyArray1<i64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Vec<&'static str>,
);

/// Poles of a stabilization diagram; the Python half makes a dictionary of it.
#[pyfunction]
pub fn stabilization<'py>(
    py: Python<'py>,
    frf: &FrfSet,
    band: Option<&Bound<'_, PyAny>>,
) -> PyResult<Diagram<'py>> {
    let options = FitOptions {
        band_hz: band_of(py, band)?,
        ..FitOptions::default()
    };
    let found = detached(py, || chladni_rfp::stabilization(&frf.set, &options))?
        .map_err(|error| unfitted(py, &error, &options))?;
    let poles = &found.poles;
    let orders: Array1<i64> = poles.iter().map(|pole| pole.order as i64).collect();
    let frequency_hz: Array1<f64> = poles.iter().map(|pole| pole.frequency_hz).collect();
    let damping_ratio: Array1<f64> = poles.iter().map(|pole| pole.damping_ratio).collect();
    let stability = poles.iter().map(|pole| match pole.stability {
        Stability::New => "new",
        Stability::Frequency => "frequency",
        Stability::Stable => "stable",
    });
    Ok((
        orders.into_pyarray(py),
        frequency_hz.into_pyarray(py),
        damping_ratio.into_pyarray(py),
        stability.collect(),
    ))
}
