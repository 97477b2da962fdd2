//! The drive as a table, for those who set amplitudes and phases by hand.

use crate::results::weights::{Weight, Weights};

/// A table of amplitude and phase, one line per weight and tone.
pub fn signal_csv(weights: &Weights) -> String {
    let line = |tone: &Weights, w: &Weight| {
        format!(
            "{},{},{},{},{}\n",
            w.reference, tone.frequency_hz, w.amplitude, w.phase_deg, w.unit
        )
    };
    let rows = weights
        .tones()
        .flat_map(|tone| tone.weights.iter().map(move |weight| line(tone, weight)));
    format!(
        "reference,frequency_hz,amplitude_peak,phase_deg,unit\n{}",
        rows.collect::<String>()
    )
}
