//! `fit`, and the words of its options.

use crate::arrays::whole_number;
use crate::error::{unfitted, wrong_option, wrong_word};
use crate::frf::FrfSet;
use crate::model::Model;
use crate::progress::telling;
use chladni_frf::{Damping, Error, ErrorKind};
use chladni_rfp::{FitOptions, Method, RfpOptions, RfpWeight, ShapeModel, Window};
use pyo3::prelude::*;

/// Most bands of the methods rfp and grfp: as on the command line, and more than any band
/// has peaks to tell apart.
const MOST_BANDS: usize = 1000;

/// Identifies the modes in an FRF set.
///
/// band: (low, high) in Hz. modes: their number; None: decided by evidence. damping:
/// "structural" or "viscous"; None: decided. method: auto, lean, vf, lscf, plscf, aaa,
/// rfp, grfp, peak or circle. shapes: auto, free, rank1 or real. rfp_weight: linear, sk,
/// iv or gn; rfp_bands: their number, None: by the peaks; rfp_local: each FRF by itself
/// (all three: methods rfp and grfp alone). window: of the records that the FRFs were
/// averaged from, as the set says where it is None: hann, hamming, blackman, flattop,
/// rectangular, kaiser:BETA, burst:PART, hann-burst:PART, transient or none.
/// exponential_window_per_s: decay of a hammer test's window. progress: called with the
/// name of each stage; where it raises, and at Ctrl-C, the fit stops at its next stage.
#[pyfunction]
#[pyo3(signature = (frf, *, band=None, modes=None, damping=None, method="auto", shapes="auto", window=None, exponential_window_per_s=None, rfp_weight=None, rfp_bands=None, rfp_local=false, seed=0, progress=None))]
#[allow(clippy::too_many_arguments)] // keywords on the Python side
pub fn fit(
    py: Python<'_>,
    frf: &FrfSet,
    band: Option<&Bound<'_, PyAny>>,
    modes: Option<Bound<'_, PyAny>>,
    damping: Option<&str>,
    method: &str,
    shapes: &str,
    window: Option<&str>,
    exponential_window_per_s: Option<f64>,
    rfp_weight: Option<&str>,
    rfp_bands: Option<Bound<'_, PyAny>>,
    rfp_local: bool,
    seed: u64,
    progress: Option<Py<PyAny>>,
) -> PyResult<Model> {
    let named = method
        .parse::<Method>()
        .map_err(|message| wrong_word(py, "method", method, &message))?;
    let own = rfp_weight.is_some() || rfp_bands.is_some() || rfp_local;
    if own && !named.is_fraction() {
        let message = "rfp_weight, rfp_bands and rfp_local are of the methods rfp and grfp alone";
        return Err(wrong_word(py, "method", method, message));
    }
    let options = FitOptions {
        band_hz: band_of(py, band)?,
        modes: count_of(modes.as_ref())?,
        damping: law(py, damping)?,
        method: named,
        rfp: RfpOptions {
            weight: rfp_weight.map_or(Ok(RfpWeight::default()), |name| {
                name.parse::<RfpWeight>()
                    .map_err(|message| wrong_word(py, "rfp_weight", name, &message))
            })?,
            bands: bands_of(rfp_bands.as_ref())?,
            local: rfp_local,
        },
        shapes: shape_model(py, shapes)?,
        window: window_of(py, window)?,
        exponential_window_per_s: decay_of(py, exponential_window_per_s)?,
        seed,
        ..FitOptions::default()
    };
    let fitted = telling(py, progress.as_ref(), |tell, stop| {
        chladni_rfp::fit_watched(&frf.set, &options, tell, stop)
    })?;
    fitted
        .map(|fitted| Model::new(fitted.model))
        .map_err(|error| unfitted(py, &error, &options))
}

/// A band, Hz, that begins before it ends.
pub fn band_of(py: Python<'_>, band: Option<&Bound<'_, PyAny>>) -> PyResult<Option<[f64; 2]>> {
    let Some(band) = band else {
        return Ok(None);
    };
    let message = match band.extract::<[f64; 2]>() {
        Ok([low, high]) if 0.0 <= low && low < high && high.is_finite() => {
            return Ok(Some([low, high]));
        }
        Ok([low, high]) if low >= high => "the band ends before it begins",
        _ => "no band",
    };
    let error = Error::new(ErrorKind::Usage, message)
        .found(band)
        .expected("(low, high) in Hz, low below high, neither negative");
    Err(wrong_option(py, "band", error))
}

/// A number of modes.
pub fn count_of(modes: Option<&Bound<'_, PyAny>>) -> PyResult<Option<usize>> {
    let expected = "a whole number above 0, or None: as many as there is evidence for";
    let count = whole_number("modes", modes, ["no number of modes", expected])?;
    match (count, modes) {
        (Some(0), Some(modes)) => {
            let error = Error::new(ErrorKind::Usage, "no mode is asked for").found(0);
            Err(wrong_option(modes.py(), "modes", error.expected(expected)))
        }
        _ => Ok(count),
    }
}

/// A number of bands of the methods rfp and grfp.
fn bands_of(bands: Option<&Bound<'_, PyAny>>) -> PyResult<Option<usize>> {
    let message = "no number of bands";
    let expected = "a whole number from 1 to 1000, or None: by the visible peaks";
    let count = whole_number("rfp_bands", bands, [message, expected])?;
    match (
        count.filter(|count| !(1..=MOST_BANDS).contains(count)),
        bands,
    ) {
        (Some(count), Some(bands)) => {
            let error = Error::new(ErrorKind::Usage, message).found(count);
            Err(wrong_option(
                bands.py(),
                "rfp_bands",
                error.expected(expected),
            ))
        }
        _ => Ok(count),
    }
}

/// A decay of an exponential window, 1/s.
pub fn decay_of(py: Python<'_>, decay_per_s: Option<f64>) -> PyResult<Option<f64>> {
    match decay_per_s.filter(|decay| !(decay.is_finite() && *decay > 0.0)) {
        None => Ok(decay_per_s),
        Some(decay) => {
            let error = Error::new(ErrorKind::Usage, "no decay of a window").found(decay);
            let expected = "a decay in 1/s above 0, such as 3.7 (ln(1/end value)/record length)";
            let error = error.expected(expected);
            Err(wrong_option(py, "exponential_window_per_s", error))
        }
    }
}

/// A damping law by its name.
pub fn law(py: Python<'_>, name: Option<&str>) -> PyResult<Option<Damping>> {
    match name {
        None => Ok(None),
        Some("structural") => Ok(Some(Damping::Structural)),
        Some("viscous") => Ok(Some(Damping::Viscous)),
        Some(other) => Err(wrong_word(
            py,
            "damping",
            other,
            "no damping law; write structural or viscous",
        )),
    }
}

/// The shape model of this name.
pub fn shape_model(py: Python<'_>, name: &str) -> PyResult<ShapeModel> {
    name.parse()
        .map_err(|message: String| wrong_word(py, "shapes", name, &message))
}

/// A window by its name.
pub fn window_of(py: Python<'_>, name: Option<&str>) -> PyResult<Option<Window>> {
    name.map(|name| {
        name.parse()
            .map_err(|message: String| wrong_word(py, "window", name, &message))
    })
    .transpose()
}
