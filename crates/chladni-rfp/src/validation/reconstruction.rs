//! The quality with which a model reproduces each FRF.

use chladni_frf::{FrfSet, ModalModel};
use ndarray::{Array2, Zip};

/// Rms of measured minus synthesised over rms of measured, of each FRF over the model's
/// band, in the measured kind; axes (response, reference). NaN where the pair was not
/// measured; lines without a value are left out.
///
/// One FRF far above the others points at its sensor, its wiring or its place in the
/// file; one mode that all FRFs miss does not.
///
/// * `frf`: of the model's responses and references, in their order, and of its kind
pub fn reconstruction_error(frf: &FrfSet, model: &ModalModel) -> Array2<f64> {
    let size = (frf.responses.len(), frf.references.len());
    let (mut error, mut total) = (Array2::<f64>::zeros(size), Array2::<f64>::zeros(size));
    let [low, high] = model.band_hz;
    for (k, &f) in frf
        .frequency_hz
        .iter()
        .enumerate()
        .filter(|(_, f)| (low..=high).contains(*f))
    {
        let fitted = model.frf_matrix(model.frf_kind, f);
        Zip::indexed(&mut error)
            .and(&mut total)
            .and(&fitted)
            .for_each(|(i, j), error, total, fitted| {
                let value = frf.values.get(i, j, k);
                if value.is_finite() && fitted.is_finite() {
                    *error += (value - fitted).norm_sqr();
                    *total += value.norm_sqr();
                }
            });
    }
    Zip::from(&mut error)
        .and(&total)
        .for_each(|e, &t| *e = if t > 0.0 { (*e / t).sqrt() } else { f64::NAN });
    error
}
