//! Speed against accuracy on the demonstration's own FRFs: one fit by each of a few methods,
//! with errors over the Cramér-Rao bound.

use crate::limits::RESIDUAL_POWERS;
use crate::truth::Comparison;
use chladni_console::Console;
use chladni_frf::{FrfSet, FrfValues, ModalModel, Mode, Result};
use chladni_plate::{cramer_rao, noise_variance};
use chladni_report::Table;
use chladni_rfp::{fit, FitOptions, Method};
use std::time::Instant;

/// Methods beside `auto`, which the demonstration runs anyway. All are faster than `auto`, so
/// that the demonstration takes seconds.
const METHODS: [Method; 5] = [
    Method::Lean,
    Method::Vf,
    Method::Lscf,
    Method::Peak,
    Method::Circle,
];

/// Columns of the table.
const HEADER: [&str; 6] = [
    "case",
    "method",
    "time_s",
    "frequency_rmse_over_crlb",
    "missed",
    "spurious",
];

/// A row for `auto`, which took `auto_s` seconds for `model`, and for each other method;
/// columns as `chladni bench accuracy` names them.
///
/// # Errors
/// None for the built-in panel: a fit that cannot be made has no row.
pub fn speed_against_accuracy(
    frf: &FrfSet,
    truth: &ModalModel,
    snr_db: f64,
    model: &ModalModel,
    auto_s: f64,
    console: &Console,
) -> Result<Table> {
    let FrfValues::F64(values) = &frf.values else {
        return Ok(Table::default());
    };
    let variance = noise_variance(values, snr_db);
    let bounds_hz =
        cramer_rao(truth, &frf.frequency_hz, variance, &RESIDUAL_POWERS)?.frequency_std_hz;
    let known: Vec<&Mode> = truth.in_band_modes().collect();
    let row = |method: Method, time_s: f64, model: &ModalModel| {
        row(
            method,
            time_s,
            &Comparison::new(model, truth),
            &known,
            &bounds_hz,
        )
    };
    let mut rows = vec![row(Method::Auto, auto_s, model)];
    for method in METHODS {
        console.stage(&format!("speed against accuracy: {method}"));
        // `lean` needs the number of modes
        let options = FitOptions {
            method,
            modes: (method == Method::Lean).then_some(known.len()),
            ..FitOptions::default()
        };
        let start = Instant::now();
        let fitted = fit(frf, &options);
        let time_s = start.elapsed().as_secs_f64();
        rows.extend(fitted.ok().map(|fitted| row(method, time_s, &fitted.model)));
    }
    Ok(Table {
        name: "Speed against accuracy".into(),
        header: HEADER.map(String::from).to_vec(),
        rows,
    })
}

/// A row of the table: the rms error of natural frequencies over their bounds, and the
/// modes that are missed and spurious.
fn row(
    method: Method,
    time_s: f64,
    comparison: &Comparison,
    known: &[&Mode],
    bounds_hz: &[f64],
) -> Vec<String> {
    // a missed mode counts as half its bandwidth
    let over_bound = comparison
        .frequency_errors_hz
        .iter()
        .zip(known)
        .zip(bounds_hz)
        .map(|((error, mode), bound)| {
            error.unwrap_or(0.5 * mode.loss_factor * mode.frequency_hz) / bound
        });
    let error = (over_bound.map(|ratio| ratio * ratio).sum::<f64>() / known.len() as f64).sqrt();
    vec![
        "panel of the demonstration".into(),
        method.to_string(),
        format!("{time_s:.3}"),
        format!("{error:.3}"),
        comparison.missed.to_string(),
        comparison.spurious.to_string(),
    ]
}
