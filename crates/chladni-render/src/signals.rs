//! What to play: drive signals of given weights.
//!
//! Channel i is gain_i · Re(Σ_k A_ik e^{jω_k t}) over the tones k, times an envelope:
//! bursts with raised-cosine ramps, so that nothing clicks, or one long burst. The
//! samples are in newtons (or volts where the references are volts), not scaled to ±1:
//! 32-bit floats carry that. Phases of one tone against another mean nothing to the
//! field; from the third tone on they are Schroeder's (IEEE Trans. Inf. Theory 16, 1970),
//! which keep the lines of a band from adding up to pulses.

use crate::weights::{Weight, Weights};
use chladni_frf::{Dof, Error, ErrorKind, Result};
use hound::{SampleFormat, WavSpec, WavWriter};
use num_complex::Complex64;
use std::f64::consts::{PI, TAU};
use std::io::Cursor;

/// How the signals run in time.
#[derive(Debug, Clone, PartialEq)]
pub struct SignalOptions {
    /// Samples per second.
    pub sample_rate_hz: u32,
    /// Length of all, s.
    pub duration_s: f64,
    /// Rise and fall of each burst, s.
    pub ramp_s: f64,
    /// Length of a burst with its ramps, and from one beginning to the next, s; `None`:
    /// one burst over all.
    pub burst_s: Option<[f64; 2]>,
    /// Factor on each channel, in the order of the weights; empty: 1.
    pub gains: Vec<f64>,
}

impl Default for SignalOptions {
    /// Two seconds at 48 kHz with ramps of 50 ms.
    fn default() -> Self {
        Self {
            sample_rate_hz: 48_000,
            duration_s: 2.0,
            ramp_s: 0.05,
            burst_s: None,
            gains: Vec::new(),
        }
    }
}

impl SignalOptions {
    /// Envelope at a time, 0 to 1.
    fn envelope(&self, time_s: f64) -> f64 {
        let [length, period] = self.burst_s.unwrap_or([self.duration_s; 2]);
        let within = time_s.rem_euclid(period);
        let to_end = within.min(length - within);
        match to_end {
            t if t <= 0.0 => 0.0,
            t if t < self.ramp_s => 0.5 - 0.5 * (PI * t / self.ramp_s).cos(),
            _ => 1.0,
        }
    }

    fn check(&self, weights: &Weights) -> Result<()> {
        let refuse = |field: &str, found: String, expected: &str| {
            Err(Error::new(ErrorKind::Usage, "no usable signal")
                .field(field)
                .found(found)
                .expected(expected))
        };
        let rate = f64::from(self.sample_rate_hz);
        let highest_hz = weights
            .tones()
            .map(|tone| tone.frequency_hz)
            .fold(0.0, f64::max);
        if rate <= 2.0 * highest_hz {
            let least = format!(
                "more than {} Hz, twice the drive frequency",
                2.0 * highest_hz
            );
            return refuse("sample_rate_hz", rate.to_string(), &least);
        }
        if !(self.duration_s > 0.0
            && self.duration_s * rate * weights.weights.len() as f64 * 4.0 < f64::from(u32::MAX))
        {
            return refuse(
                "duration_s",
                self.duration_s.to_string(),
                "a length above 0 whose samples fit into a WAV file of 4 GiB",
            );
        }
        if !(self.ramp_s >= 0.0
            && self
                .burst_s
                .is_none_or(|[length, period]| length > 0.0 && period >= length))
        {
            return refuse(
                "burst_s",
                format!("{:?}, ramps of {} s", self.burst_s, self.ramp_s),
                "0 < length ≤ period, ramps of 0 or more",
            );
        }
        if !self.gains.is_empty() && self.gains.len() != weights.weights.len() {
            return refuse(
                "gains",
                self.gains.len().to_string(),
                &format!("{}, one per weight", weights.weights.len()),
            );
        }
        Ok(())
    }
}

/// A tone as it is played.
struct Played {
    frequency_hz: f64,
    /// Phasor of each channel.
    channels: Vec<Complex64>,
}

/// The tones of `weights`, channels in the order of the first one's weights.
fn played(weights: &Weights) -> Vec<Played> {
    let count = weights.tones().count() as f64;
    let tone = |(k, tone): (usize, &Weights)| {
        let turn = Complex64::from_polar(1.0, PI * (k * k.saturating_sub(1)) as f64 / count);
        let weight_of = |dof: Dof| {
            tone.weights
                .iter()
                .find(|weight| weight.reference == dof)
                .map_or(Complex64::ZERO, Weight::value)
        };
        let channels = weights
            .weights
            .iter()
            .map(|weight| turn * weight_of(weight.reference))
            .collect();
        Played {
            frequency_hz: tone.frequency_hz,
            channels,
        }
    };
    weights.tones().enumerate().map(tone).collect()
}

/// A WAV file with one channel per weight, 32-bit floats; several tones sound together.
///
/// # Errors
/// [`ErrorKind::Usage`]: a rate below twice the drive frequency, lengths that make no
/// signal, gains of another number.
pub fn wav(weights: &Weights, options: &SignalOptions) -> Result<Vec<u8>> {
    options.check(weights)?;
    let failed = |error: hound::Error| {
        Error::new(
            ErrorKind::Internal,
            format!("the signals cannot be written: {error}"),
        )
    };
    let channels = u16::try_from(weights.weights.len()).map_err(|_| {
        Error::new(ErrorKind::Usage, "too many channels")
            .found(weights.weights.len())
            .expected("at most 65535 actuators")
    })?;
    let spec = WavSpec {
        channels,
        sample_rate: options.sample_rate_hz,
        bits_per_sample: 32,
        sample_format: SampleFormat::Float,
    };
    let mut bytes = Cursor::new(Vec::new());
    let mut writer = WavWriter::new(&mut bytes, spec).map_err(failed)?;
    let rate = f64::from(options.sample_rate_hz);
    let tones = played(weights);
    for n in 0..(options.duration_s * rate).round() as u64 {
        let time_s = n as f64 / rate;
        let envelope = options.envelope(time_s);
        // whole periods are taken off first: the phase keeps its digits in long signals
        let turns: Vec<Complex64> = tones
            .iter()
            .map(|tone| Complex64::from_polar(1.0, TAU * (tone.frequency_hz * time_s).fract()))
            .collect();
        for channel in 0..usize::from(channels) {
            let gain = options.gains.get(channel).copied().unwrap_or(1.0);
            let force: f64 = tones
                .iter()
                .zip(&turns)
                .map(|(tone, turn)| (tone.channels[channel] * turn).re)
                .sum();
            writer
                .write_sample((envelope * gain * force) as f32)
                .map_err(failed)?;
        }
    }
    writer.finalize().map_err(failed)?;
    Ok(bytes.into_inner())
}

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn envelopes_rise_hold_and_fall() {
        let options = SignalOptions {
            duration_s: 1.0,
            ramp_s: 0.1,
            ..Default::default()
        };
        let expected = [(0.0, 0.0), (0.05, 0.5), (0.1, 1.0), (0.5, 1.0), (0.95, 0.5)];
        assert!(expected
            .iter()
            .all(|&(t, e)| (options.envelope(t) - e).abs() < 1e-12));
        let bursts = SignalOptions {
            burst_s: Some([0.3, 0.5]),
            ..options
        };
        let expected = [
            (0.15, 1.0),
            (0.4, 0.0),
            (0.55, 0.5),
            (0.65, 1.0),
            (0.9, 0.0),
        ];
        assert!(expected
            .iter()
            .all(|&(t, e)| (bursts.envelope(t) - e).abs() < 1e-12));
    }
}
