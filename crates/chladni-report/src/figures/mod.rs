//! The figures of a report, one file each, and the list of all.

mod auto_mac;
mod cmif;
mod complexity;
pub(crate) mod curves;
mod field_map;
mod frf_overlay;
mod mode_shape;
mod moving;
mod moving_shape;
pub(crate) mod plane;
mod poles;
mod speed;
mod stabilization;
mod stress;
pub(crate) mod sweep;
pub(crate) mod time;
pub(crate) mod weights_around_edge;
mod zones;

pub(crate) use cmif::Cmif;
pub use field_map::field_map;
pub(crate) use mode_shape::shown_responses;
pub use moving::moving_field;
pub(crate) use moving::moving_period;
pub(crate) use moving_shape::moving_shapes;
pub use time::time;
pub use weights_around_edge::weights_around_edge;

use crate::chart::Figure;
use crate::comparison::Comparison;
use crate::data::stabilization_options;
use crate::input::{RenderedScene, ReportInput};
use chladni_frf::{ModalModel, Result};

/// All figures, from the FRFs to the scenes.
///
/// # Errors
/// Measured FRFs that do not belong to the model; a singular value decomposition that
/// fails.
pub fn all(input: &ReportInput) -> Result<Vec<Figure>> {
    let mut figures = Vec::new();
    if let Some(comparison) = Comparison::new(input)? {
        let sums = comparison.sums();
        figures.push(frf_overlay::frf_sum(&comparison, &sums));
        let pairs = comparison.pairs(&sums);
        figures.extend(
            pairs
                .iter()
                .enumerate()
                .map(|(k, pair)| frf_overlay::frf_overlay(&comparison, pair, k + 1)),
        );
        if let Some(cmif) = Cmif::of(&comparison, input.measured)? {
            figures.push(cmif::figure(&comparison, &cmif));
            // lines without even spacing have no diagram; the page gives the reason
            let diagram = input.measured.and_then(|set| {
                chladni_rfp::stabilization(set, &stabilization_options(input.model)).ok()
            });
            figures.extend(
                diagram.map(|diagram| stabilization::stabilization(&comparison, &diagram, &cmif)),
            );
        }
    }
    if let Some(model) = input.model {
        figures.extend(poles::poles(model));
        figures.extend(auto_mac::auto_mac(model));
        figures.extend(mode_shape::mode_shapes(model));
        figures.extend(complexity::complexity(model));
    }
    for (k, scene) in input.scenes.iter().enumerate() {
        figures.extend(of_scene(scene, input.model, k + 1));
    }
    figures.extend(
        input
            .tables
            .iter()
            .enumerate()
            .filter_map(|(k, table)| speed::speed(table, k + 1)),
    );
    Ok(figures)
}

fn of_scene(scene: &RenderedScene, model: Option<&ModalModel>, number: usize) -> Vec<Figure> {
    let (weights, shown) = (scene.weights, scene.shown.as_ref());
    let mut figures = Vec::new();
    figures.extend(shown.and_then(|shown| zones::zones(shown, model, number)));
    figures.extend(shown.and_then(|shown| field_map(shown, model, weights.frequency_hz, number)));
    figures.extend(model.and_then(|model| weights_around_edge(weights, model, number)));
    figures.push(weights_around_edge::weights_by_actuator(weights, number));
    figures.extend(scene.time.map(|played| {
        let title = format!("{}: {}", weights.scene, played.indices.sentence());
        time(&format!("time-{number}"), &title, played)
    }));
    figures.extend(sweep::sweep(weights, number));
    figures.extend(curves::curves(scene, number));
    figures.extend(stress::stress(weights, number));
    figures
}

/// Level of an amplitude, dB; NaN for zero, so that curves break there.
pub(crate) fn level(amplitude: f64) -> f64 {
    if amplitude > 0.0 {
        20.0 * amplitude.log10()
    } else {
        f64::NAN
    }
}

/// Natural frequencies of the modes in the band, Hz.
pub(crate) fn natural_frequencies(model: Option<&ModalModel>) -> Vec<f64> {
    model
        .map(|model| {
            model
                .in_band_modes()
                .map(|mode| mode.frequency_hz)
                .collect()
        })
        .unwrap_or_default()
}
