//! CMIF, stabilization diagram and MAC matrix as numbers.

use super::array::{f32s, f64s, u32s, u8s};
use super::lines::thinned;
use crate::comparison::Comparison;
use crate::figures;
use crate::sizes;
use chladni_frf::{FrfSet, ModalModel, Mode, Result};
use chladni_rfp::{FitOptions, Stability};
use num_complex::Complex64;
use serde_json::{json, Value};

/// The largest singular values over frequency, axes (singular value, line); `null` where
/// measured pairs are missing and there is no model.
///
/// # Errors
/// A singular value decomposition that fails.
pub(crate) fn cmif(comparison: &Comparison, measured: Option<&FrfSet>) -> Result<Value> {
    let Some(cmif) = figures::Cmif::of(comparison, measured)? else {
        return Ok(Value::Null);
    };
    let frequency_hz = comparison.frequency_hz.to_vec();
    let lines = thinned(&frequency_hz, comparison.model, sizes::SHOWN_LINES);
    let shown = cmif.values.ncols().min(sizes::SINGULAR_VALUES);
    let values = (0..shown)
        .flat_map(|k| lines.iter().map(move |&line| (line, k)))
        .map(|(line, k)| cmif.values[[line, k]]);
    Ok(json!({
        "of": cmif.of,
        "unit": cmif.quantity.level_unit(),
        "frequency_hz": f64s(lines.iter().map(|&line| &frequency_hz[line])),
        "values": f32s(values),
    }))
}

/// Poles of rising order, or `{"missing": why}`.
pub(crate) fn stabilization(set: &FrfSet, model: Option<&ModalModel>) -> Value {
    match chladni_rfp::stabilization(set, &stabilization_options(model)) {
        Err(error) => json!({ "missing": error.to_string() }),
        Ok(diagram) => json!({
            "orders": diagram.orders,
            "order": u32s(diagram.poles.iter().map(|pole| pole.order)),
            "frequency_hz": f32s(diagram.poles.iter().map(|pole| pole.frequency_hz)),
            "damping_ratio": f32s(diagram.poles.iter().map(|pole| pole.damping_ratio)),
            "stability": u8s(diagram.poles.iter().map(|pole| match pole.stability {
                Stability::New => 0,
                Stability::Frequency => 1,
                Stability::Stable => 2,
            })),
        }),
    }
}

/// Options of the diagram: the band of the model.
pub(crate) fn stabilization_options(model: Option<&ModalModel>) -> FitOptions {
    FitOptions {
        band_hz: model.map(|model| model.band_hz),
        ..FitOptions::default()
    }
}

/// MAC of every shape with every other, row by row; `None` without modes in the band, and with
/// too few responses to tell shapes apart.
pub(crate) fn mac(model: &ModalModel) -> Option<Value> {
    if model.responses.len() < sizes::MAC_RESPONSES {
        return None;
    }
    let modes: Vec<&Mode> = model.in_band_modes().take(sizes::MAC_MODES).collect();
    let shapes: Vec<&[Complex64]> = modes.iter().map(|mode| mode.shape.0.as_slice()).collect();
    let mac = chladni_rfp::mac_matrix(&shapes, &shapes);
    (!modes.is_empty()).then(|| json!({"count": modes.len(), "values": f32s(mac)}))
}
