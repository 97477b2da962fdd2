//! Windows that analysers have and `estimate` lacks, by their definitions.

use chladni_frf::{Channel, Run};
use chladni_rfp::Window;
use std::f64::consts::{PI, TAU};

/// Steps of the integral that is I₀: periodic, so that it converges at once.
const STEPS: usize = 64;

/// Values on `count` samples (periodic form): Kaiser's, else the flat top of ISO 18431-2.
pub(super) fn analyser_window(window: Window, count: usize) -> Vec<f64> {
    let value = |k: usize| {
        let u = k as f64 / count as f64;
        if let Window::Kaiser { beta } = window {
            return bessel_0(beta * (1.0 - (2.0 * u - 1.0).powi(2)).sqrt());
        }
        let wave = |n: f64| (TAU * n * u).cos();
        1.0 - 1.933 * wave(1.0) + 1.286 * wave(2.0) - 0.388 * wave(3.0) + 0.028 * wave(4.0)
    };
    (0..count).map(value).collect()
}

/// I₀(x) = (1/π)·∫₀^π e^{x cos θ} dθ.
fn bessel_0(x: f64) -> f64 {
    let at = |k: usize| (x * (PI * (k as f64 + 0.5) / STEPS as f64).cos()).exp();
    (0..STEPS).map(at).sum::<f64>() / STEPS as f64
}

/// Windowed blocks of a record, each a run of its own.
pub(super) fn windowed(run: &Run, window: &[f64], hop: usize) -> Vec<Run> {
    let starts = (0..=run.samples() - window.len()).step_by(hop);
    let block = |start: usize| {
        let channel = |channel: &Channel| {
            let part = channel.samples[start..start + window.len()].iter();
            Channel {
                samples: part.zip(window).map(|(x, w)| x * w).collect(),
                ..channel.clone()
            }
        };
        Run {
            channels: run.channels.iter().map(channel).collect(),
            ..run.clone()
        }
    };
    starts.map(block).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_have_their_published_bandwidths() {
        // equivalent noise bandwidth, lines: ISO 18431-2 flat top, Kaiser at β = 8.6
        for (window, expected) in [
            (Window::Flattop, 3.77),
            (Window::Kaiser { beta: 8.6 }, 1.72),
        ] {
            let values = analyser_window(window, 2048);
            let sum: f64 = values.iter().sum();
            let squares: f64 = values.iter().map(|w| w * w).sum();
            let lines = 2048.0 * squares / (sum * sum);
            assert!((lines - expected).abs() < 0.01, "{window}: {lines}");
        }
    }
}
