//! Data that are a delay and nothing else: constants, or gains that hardly change over the band, times
//! e^{−jωτ}, as of a cable, a loudspeaker at a distance, or a channel that hears its own drive.
//!
//! Evenly spaced poles of equal, heavy damping explain a delay to any accuracy, with error bars that
//! look like those of modes. A delay has one unknown for all FRFs, and is asked first.

use crate::data::columns::Columns;
use crate::poles::limits;
use crate::poles::whiteness::judge_columns;
use chladni_frf::{Finding, FrfKind};
use chladni_linalg::blocked::projected;
use chladni_linalg::{qr_thin, LinalgError};
use ndarray::{s, Array2, ArrayView2, Axis};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// The delay, s, that explains all columns but for white noise, if it turns them at least once
/// over the band and explains most of them.
///
/// * `hz`: frequency of x = 1
pub(crate) fn delay_alone(
    sketch: &Columns,
    kind: FrfKind,
    hz: f64,
) -> Result<Option<f64>, LinalgError> {
    if sketch.lines() < limits::DELAY_LINES_LEAST {
        return Ok(None);
    }
    let omega: Vec<f64> = sketch.x.iter().map(|x| TAU * hz * x.sqrt()).collect();
    let band = omega[omega.len() - 1] - omega[0];
    let few = sketch.columns().min(limits::DELAY_COLUMNS);
    let few = sketch.b.slice(s![.., ..few]);
    let seconds = lag(few, &omega);
    if (seconds * band).abs() < TAU {
        return Ok(None);
    }
    let gains = gains(sketch, kind, &omega, seconds)?;
    let energy = |b: ArrayView2<Complex64>| b.iter().map(|v| v.norm_sqr()).sum::<f64>();
    let left = projected(gains.view(), few).1;
    if energy(left.view()) > limits::DELAY_LEAVES * energy(few) {
        return Ok(None);
    }
    let left = projected(gains.view(), sketch.b.view()).1;
    let judged = judge_columns(sketch, &[], &left, hz);
    Ok(judged.white.then_some(seconds))
}

/// The delay by which phases fall over the lines, from neighbours to lines half a band apart.
fn lag(columns: ArrayView2<Complex64>, omega: &[f64]) -> f64 {
    let lines = omega.len();
    let (mut seconds, mut apart) = (0.0, 1);
    while apart <= lines / 2 {
        let turned: Complex64 = (0..lines - apart)
            .map(|k| {
                let pairs = columns.row(k).into_iter().zip(columns.row(k + apart));
                let product: Complex64 = pairs.map(|(near, far)| far * near.conj()).sum();
                product * Complex64::from_polar(1.0, seconds * (omega[k + apart] - omega[k]))
            })
            .sum();
        let distances = (0..lines - apart).map(|k| omega[k + apart] - omega[k]);
        seconds -= turned.arg() * (lines - apart) as f64 / distances.sum::<f64>();
        apart *= 2;
    }
    seconds
}

/// Orthonormal columns of gains that follow a parabola over the band, delayed, with the weights of
/// the lines.
fn gains(
    sketch: &Columns,
    kind: FrfKind,
    omega: &[f64],
    seconds: f64,
) -> Result<Array2<Complex64>, LinalgError> {
    let lines = omega.len();
    let half = 0.5 * (omega[lines - 1] - omega[0]);
    let power = 0.5 * f64::from(kind.omega_power());
    let mut columns = Array2::zeros((lines, 3));
    for (k, mut row) in columns.axis_iter_mut(Axis(0)).enumerate() {
        let weight = sketch.g[k] / sketch.x[k].powf(power);
        let place = (omega[k] - omega[0]) / half - 1.0;
        let value = Complex64::from_polar(weight, -omega[k] * seconds);
        for (degree, entry) in row.iter_mut().enumerate() {
            *entry = value * place.powi(degree as i32);
        }
    }
    Ok(qr_thin(columns.view())?.0)
}

/// The finding of data that are a delay and nothing else.
pub(crate) fn finding(seconds: f64) -> Finding {
    let words = format!(
        "a delay of {:.4} ms and a gain that hardly changes over the band explain all FRFs: no \
         resonance shows, and poles would describe the delay",
        1e3 * seconds
    );
    Finding::fault("delay-alone", words)
        .value("delay_ms", 1e3 * seconds)
        .help("look at what the channels are connected to")
}
