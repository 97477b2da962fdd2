//! The samples that a rig plays, and how large full scale is.

use crate::time::channel_map::{ChannelMap, Mapped};
use crate::time::indices::TimeEvent;
use crate::time::play::Played;
use crate::time::sidecar::{Channel, Sidecar, SIGNAL_FORMAT, SIGNAL_VERSION};
use crate::time::wav_file::{wav_bytes, SampleFormat};
use crate::tolerances;
use crate::tolerances::MOST_BYTES;
use chladni_frf::{Error, ErrorKind, Result};
use ndarray::{Array2, Axis};
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Settings of the conversion of a drive to samples.
#[derive(Debug, Clone, PartialEq)]
pub struct SignalOptions {
    /// Samples per second.
    pub rate_hz: u32,
    /// Of sound files.
    pub format: SampleFormat,
    /// Value of a sample of 1 before the gains, N or V; `None`: the smallest of 1, 2 and
    /// 5 times a power of ten that nothing exceeds.
    pub full_scale: Option<f64>,
    /// Assignment of actuators to channels; `None`: in their order.
    pub channels: Option<ChannelMap>,
}

impl Default for SignalOptions {
    fn default() -> Self {
        Self {
            rate_hz: 48_000,
            format: SampleFormat::F32,
            full_scale: None,
            channels: None,
        }
    }
}

/// A drive as samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    /// The content of the file beside it.
    pub sidecar: Sidecar,
    /// Drive of each channel, N or V; axes (frame, channel). Channels without an actuator
    /// are silent.
    pub drive: Array2<f64>,
    /// Largest |drive| over full scale.
    pub peak: f64,
}

impl Played {
    /// The drive as samples, from time 0 to its end.
    ///
    /// # Errors
    /// [`ErrorKind::Usage`]: a rate of at most twice the highest frequency of tones and
    /// ramps, a signal too long for a file, a full scale that clips, a map that lacks an
    /// actuator or knows others.
    pub fn signal(&self, options: &SignalOptions, scene: &str) -> Result<Signal> {
        let rate = f64::from(options.rate_hz);
        let map = match &options.channels {
            Some(map) => map.clone(),
            None => ChannelMap::plain(&self.references),
        };
        let columns = self.columns(&map)?;
        let width = map.0.iter().map(|mapped| mapped.channel).max().unwrap_or(0);
        let highest_hz = self.highest_hz();
        if rate <= 2.0 * highest_hz {
            return Err(usage(
                "rate_hz",
                format!("{rate} Hz"),
                format!(
                    "more than {:.0} Hz, twice the highest frequency of the drive with its ramps",
                    2.0 * highest_hz
                ),
            )
            .help("a converter plays nothing at half of its rate and above; 48000 is usual"));
        }
        let frames = (self.length_s * rate).ceil() + 1.0;
        if frames * width as f64 * options.format.bytes() as f64 > MOST_BYTES {
            return Err(usage(
                "rate_hz",
                format!("{frames} frames of {width} channels"),
                "at most 4 GiB in a file".into(),
            )
            .help("take a lower rate, fewer channels or a shorter scene"));
        }
        let frames = frames as usize;
        let mut drive = Array2::zeros((frames, width));
        let mut sum = vec![Complex64::ZERO; self.references.len()];
        for k in 0..frames {
            let time_s = k as f64 / rate;
            for tone in &self.tones {
                tone.at(time_s, &mut sum);
                // whole periods are taken off first: the phase keeps its digits
                let turn = Complex64::from_polar(1.0, TAU * (tone.frequency_hz * time_s).fract());
                for (mapped, &(column, sign)) in map.0.iter().zip(&columns) {
                    drive[[k, mapped.channel - 1]] += sign * (sum[column] * turn).re;
                }
            }
        }
        self.scaled(drive, &map, options, scene)
    }

    /// Upper end of the highest tone, as its shortest ramp spreads it.
    fn highest_hz(&self) -> f64 {
        let tones = self.tones.iter().map(|tone| tone.frequency_hz);
        let spread = |event: &TimeEvent| tolerances::RAMP_SPREAD / event.ramp_s;
        let spreads = self.indices.events.iter().map(spread);
        tones.fold(0.0, f64::max) + spreads.fold(0.0, f64::max)
    }

    fn scaled(
        &self,
        drive: Array2<f64>,
        map: &ChannelMap,
        options: &SignalOptions,
        scene: &str,
    ) -> Result<Signal> {
        let (peak, full_scale) = scale(&drive, map, options)?;
        Ok(Signal {
            sidecar: Sidecar {
                format: SIGNAL_FORMAT.into(),
                version: SIGNAL_VERSION,
                rate_hz: options.rate_hz,
                frames: drive.nrows(),
                start_s: 0.0,
                scene: scene.into(),
                source: Vec::new(),
                events: self.indices.events.clone(),
                channels: map
                    .0
                    .iter()
                    .map(|mapped| Channel {
                        channel: mapped.channel,
                        reference: mapped.reference,
                        unit: self.unit,
                        full_scale: full_scale / mapped.gain,
                        gain: mapped.gain,
                    })
                    .collect(),
            },
            drive,
            peak: peak / full_scale,
        })
    }

    /// Actuator of each channel of a map, and the sign by which its sense differs.
    fn columns(&self, map: &ChannelMap) -> Result<Vec<(usize, f64)>> {
        for reference in &self.references {
            if !map
                .0
                .iter()
                .any(|mapped| mapped.reference.same_axis(*reference))
            {
                return Err(
                    Error::bad_data("the channel map lacks an actuator of the drive")
                        .field("reference")
                        .found(format!("{} channels, none for {reference}", map.0.len()))
                        .expected("a channel for each actuator")
                        .help("give this actuator a line in the map, with a channel of its own"),
                );
            }
        }
        map.0
            .iter()
            .map(|mapped| {
                let column = self
                    .references
                    .iter()
                    .position(|reference| reference.same_axis(mapped.reference));
                column
                    .map(|column| {
                        let sign = self.references[column].direction.sign()
                            * mapped.reference.direction.sign();
                        (column, sign)
                    })
                    .ok_or_else(|| {
                        Error::bad_data("the channel map knows an actuator that the drive lacks")
                            .field("reference")
                            .found(mapped.reference)
                            .expected("actuators that the scene uses")
                            .help("take its line out, or let the scene use this actuator")
                    })
            })
            .collect()
    }
}

impl Signal {
    /// Samples as a sound file has them, −1 to 1; channel by channel, of one frame.
    fn values(&self) -> impl Iterator<Item = f64> + '_ {
        let mut scales = vec![0.0; self.drive.ncols()];
        for channel in &self.sidecar.channels {
            scales[channel.channel - 1] = 1.0 / channel.full_scale;
        }
        self.drive.rows().into_iter().flat_map(move |frame| {
            let values: Vec<f64> = frame
                .iter()
                .zip(&scales)
                .map(|(value, scale)| value * scale)
                .collect();
            values
        })
    }

    /// A sound file.
    ///
    /// # Errors
    /// More channels than its header can count.
    pub fn wav(&self, format: SampleFormat) -> Result<Vec<u8>> {
        wav_bytes(
            self.values(),
            self.drive.dim(),
            self.sidecar.rate_hz,
            format,
        )
    }

    /// Drive of the channels with an actuator, in the order of the sidecar, N or V; axes
    /// (frame, channel).
    pub fn driven(&self) -> Array2<f64> {
        let channels = self.sidecar.channels.iter();
        let columns: Vec<usize> = channels.map(|channel| channel.channel - 1).collect();
        self.drive.select(Axis(1), &columns)
    }

    /// A table: the time, and the drive of each channel in its unit.
    pub fn csv(&self) -> String {
        let mut text = String::from("time_s");
        for channel in &self.sidecar.channels {
            text += &format!(",{} [{}]", channel.reference, channel.unit);
        }
        text.push('\n');
        for (k, frame) in self.drive.rows().into_iter().enumerate() {
            text += &(k as f64 / f64::from(self.sidecar.rate_hz)).to_string();
            for channel in &self.sidecar.channels {
                text += &format!(",{:e}", frame[channel.channel - 1]);
            }
            text.push('\n');
        }
        text
    }
}

/// The smallest of 1, 2 and 5 times a power of ten that is not below `peak`.
fn round_above(peak: f64) -> f64 {
    if peak <= 0.0 {
        return 1.0;
    }
    let power = peak.log10().floor() as i32;
    let candidates =
        (power - 1..=power + 1).flat_map(|power| [1, 2, 5].map(|digit| (digit, power)));
    let number = |(digit, power): (i32, i32)| format!("{digit}e{power}").parse().unwrap_or(peak);
    candidates
        .map(number)
        .find(|&number| number >= peak)
        .unwrap_or(peak)
}

/// Largest |drive · gain| of all channels, and the full scale that holds it.
fn scale(drive: &Array2<f64>, map: &ChannelMap, options: &SignalOptions) -> Result<(f64, f64)> {
    let peak_of = |mapped: &Mapped| {
        let column = drive.column(mapped.channel - 1);
        column
            .iter()
            .fold(0.0, |most: f64, value| most.max(value.abs()))
            * mapped.gain.abs()
    };
    let loudest = map
        .0
        .iter()
        .max_by(|a, b| peak_of(a).total_cmp(&peak_of(b)));
    let peak = loudest.map_or(0.0, peak_of);
    let full_scale = options.full_scale.unwrap_or_else(|| round_above(peak));
    if !(full_scale > 0.0 && full_scale.is_finite()) {
        return Err(usage(
            "full_scale",
            full_scale.to_string(),
            "a number above 0".into(),
        ));
    }
    if let Some(loudest) = loudest.filter(|_| peak > full_scale) {
        return Err(usage(
            "full_scale",
            format!(
                "{full_scale}, and a peak of {peak:.4e} on channel {} ({})",
                loudest.channel, loudest.reference
            ),
            format!("at least {:.4e}, so that nothing clips", peak),
        )
        .help("`auto` takes the smallest round number above the peak"));
    }
    let steps = options
        .format
        .steps()
        .map(|steps| steps * peak / full_scale);
    if let Some(steps) = steps.filter(|&steps| peak > 0.0 && steps < tolerances::LEAST_STEPS) {
        return Err(usage(
            "full_scale",
            format!(
                "{full_scale}, and a peak of {peak:.4e}, {steps:.3} steps of {}",
                options.format.as_str()
            ),
            format!(
                "a peak of at least {} steps: rounding would move the cold ground",
                tolerances::LEAST_STEPS
            ),
        )
        .help("`auto` takes the smallest round number above the peak; f32 has no steps"));
    }
    Ok((peak, full_scale))
}

fn usage(field: &str, found: String, expected: String) -> Error {
    Error::new(ErrorKind::Usage, "no usable signal")
        .field(field)
        .found(found)
        .expected(expected)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_scale_is_the_next_round_number() {
        for (peak, expected) in [
            (1.6e-3, 2e-3),
            (2e-3, 2e-3),
            (2.01e-3, 5e-3),
            (7.0, 10.0),
            (0.0, 1.0),
        ] {
            assert_eq!(round_above(peak), expected);
        }
    }
}
