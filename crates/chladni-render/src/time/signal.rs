//! The samples that a rig plays: which actuator is on which channel, how large full scale
//! is, and the JSON file beside the sound file that says so.

use crate::time::play::{Played, TimeEvent};
use crate::time::tracks::Tracks;
use crate::time::wav_file::{wav_bytes, SampleFormat};
use chladni_frf::{Dof, Error, ErrorKind, ReferenceUnit, Result, Source};
use ndarray::{Array1, Array2, Axis};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Value of `format` in a signal's sidecar.
pub const SIGNAL_FORMAT: &str = "chladni.signal";
/// Version of the layout.
pub const SIGNAL_VERSION: u32 = 1;

/// Most bytes of a sound file: its header counts them in 32 bits.
const MOST_BYTES: f64 = 4_294_900_000.0;

/// How a drive becomes samples.
#[derive(Debug, Clone, PartialEq)]
pub struct SignalOptions {
    /// Samples per second.
    pub rate_hz: u32,
    /// Of sound files.
    pub format: SampleFormat,
    /// What a sample of 1 means before the gains, N or V; `None`: the smallest of 1, 2
    /// and 5 times a power of ten that nothing exceeds.
    pub full_scale: Option<f64>,
    /// Which actuator is on which channel; `None`: in their order.
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

/// A channel of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mapped {
    /// Counted from 1.
    pub channel: usize,
    /// Its actuator.
    pub reference: Dof,
    /// Factor on its samples, as V/N of its amplifier and coil.
    pub gain: f64,
}

/// Which actuator is on which channel.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelMap(pub Vec<Mapped>);

impl ChannelMap {
    /// Most channels of a converter.
    const MOST: usize = 1024;

    /// Actuators in their order, without gains.
    fn plain(references: &[Dof]) -> Self {
        let mapped = references.iter().enumerate().map(|(k, &reference)| Mapped {
            channel: k + 1,
            reference,
            gain: 1.0,
        });
        Self(mapped.collect())
    }

    /// From the text of a CSV file `channel,reference,gain`; the gain may be left out.
    ///
    /// # Errors
    /// [`ErrorKind::BadData`] with the line: another header, no channel number, no DOF, a
    /// gain of 0, a channel or an actuator twice.
    pub fn parse(text: &str) -> Result<Self> {
        let bad = |line: usize, message: &str, field: &str, found: &str, expected: &str| {
            Error::bad_data(message)
                .at_line(line as u64 + 1)
                .field(field)
                .found(found)
                .expected(expected)
        };
        let mut lines = text
            .lines()
            .enumerate()
            .map(|(k, line)| (k, line.trim().trim_start_matches('\u{feff}')))
            .filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        let cells = |line: &str| -> Vec<String> {
            line.split(',').map(|cell| cell.trim().to_owned()).collect()
        };
        let header = lines.next().map(|(k, line)| (k, cells(line)));
        let with_gain = match &header {
            Some((_, names)) if *names == ["channel", "reference", "gain"] => true,
            Some((_, names)) if *names == ["channel", "reference"] => false,
            other => {
                let (line, found) = other.clone().unwrap_or_default();
                return Err(bad(
                    line,
                    "not a channel map",
                    "header",
                    &found.join(","),
                    "channel,reference,gain",
                ));
            }
        };
        let mut mapped: Vec<Mapped> = Vec::new();
        for (line, text) in lines {
            let cells = cells(text);
            if cells.len() != 2 + usize::from(with_gain) {
                return Err(bad(
                    line,
                    "wrong number of cells",
                    "row",
                    text,
                    "one cell for each name of the header",
                ));
            }
            let channel = cells[0]
                .parse::<usize>()
                .ok()
                .filter(|channel| (1..=Self::MOST).contains(channel))
                .ok_or_else(|| {
                    bad(
                        line,
                        "no such channel",
                        "channel",
                        &cells[0],
                        "a number from 1 to 1024",
                    )
                })?;
            let reference = cells[1].parse::<Dof>().map_err(|_| {
                bad(
                    line,
                    "no DOF",
                    "reference",
                    &cells[1],
                    "a reference like 101:+Z",
                )
            })?;
            let gain = if with_gain {
                cells[2].parse::<f64>().unwrap_or(f64::NAN)
            } else {
                1.0
            };
            if !(gain.is_finite() && gain != 0.0) {
                return Err(bad(
                    line,
                    "no usable gain",
                    "gain",
                    &cells[2],
                    "a finite number other than 0",
                ));
            }
            if mapped.iter().any(|m| m.channel == channel) {
                return Err(bad(
                    line,
                    "a channel occurs twice",
                    "channel",
                    &cells[0],
                    "each channel once",
                ));
            }
            if mapped.iter().any(|m| m.reference.same_axis(reference)) {
                return Err(bad(
                    line,
                    "an actuator occurs twice",
                    "reference",
                    &cells[1],
                    "each actuator once",
                ));
            }
            mapped.push(Mapped {
                channel,
                reference,
                gain,
            });
        }
        mapped.sort_by_key(|mapped| mapped.channel);
        Ok(Self(mapped))
    }
}

/// A drive as samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    /// What the file beside it says.
    pub sidecar: Sidecar,
    /// Drive of each channel, N or V; axes (frame, channel). Channels without an actuator
    /// are silent.
    pub drive: Array2<f64>,
    /// Largest |drive| over full scale.
    pub peak: f64,
}

/// The JSON file beside a signal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Sidecar {
    /// Always [`SIGNAL_FORMAT`].
    pub format: String,
    /// Version of the layout: 1.
    pub version: u32,
    /// Samples per second.
    pub rate_hz: u32,
    /// Samples of each channel.
    pub frames: usize,
    /// Time of the first sample in the scene, s.
    pub start_s: f64,
    /// File name of the scene.
    pub scene: String,
    /// The files it was made from; filled by whoever read them.
    pub source: Vec<Source>,
    /// What happens when; empty where another program made the signal.
    #[serde(default)]
    pub events: Vec<TimeEvent>,
    /// Channels with an actuator.
    pub channels: Vec<Channel>,
}

/// A channel with an actuator.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Channel {
    /// Counted from 1.
    pub channel: usize,
    /// Its actuator.
    pub reference: Dof,
    /// Unit of sample · full scale.
    pub unit: ReferenceUnit,
    /// What a sample of 1 means, in `unit`, the gain taken into account.
    pub full_scale: f64,
    /// Factor that its samples were multiplied by, as V/N.
    pub gain: f64,
}

impl Sidecar {
    /// Reads a sidecar's text.
    ///
    /// # Errors
    /// [`ErrorKind::BadData`]: no JSON, a missing field, another format, channels that
    /// cannot be.
    pub fn parse(text: &str) -> Result<Self> {
        let sidecar: Self = serde_json::from_str(text)
            .map_err(|error| chladni_text::json_error("not a signal's sidecar", &error))?;
        if sidecar.format != SIGNAL_FORMAT || sidecar.version != SIGNAL_VERSION {
            return Err(Error::bad_data("not a sidecar that this version reads")
                .field("format")
                .found(format!("{} version {}", sidecar.format, sidecar.version))
                .expected(format!("{SIGNAL_FORMAT} version {SIGNAL_VERSION}")));
        }
        for (k, channel) in sidecar.channels.iter().enumerate() {
            let twice = sidecar.channels[..k].iter().any(|other| {
                other.channel == channel.channel || other.reference.same_axis(channel.reference)
            });
            let scale = channel.full_scale.is_finite() && channel.full_scale != 0.0;
            if channel.channel == 0 || twice || !scale {
                return Err(Error::bad_data("a channel that cannot be")
                    .field(format!("channels[{}]", k + 1))
                    .found(format!(
                        "channel {} of {}, full scale {}",
                        channel.channel, channel.reference, channel.full_scale
                    ))
                    .expected("channels from 1, each once, with a full scale"));
            }
        }
        Ok(sidecar)
    }

    /// Its text.
    ///
    /// # Errors
    /// [`ErrorKind::Internal`] where a number is not finite: a bug.
    pub fn to_json(&self) -> Result<String> {
        serde_json::to_string_pretty(self)
            .map(|text| text + "\n")
            .map_err(|error| Error::new(ErrorKind::Internal, error.to_string()))
    }
}

impl Played {
    /// The drive as samples, from time 0 to its end.
    ///
    /// # Errors
    /// [`ErrorKind::Usage`]: a rate of at most twice the highest frequency, a signal too
    /// long for a file, a full scale that clips, a map that lacks an actuator or knows
    /// others.
    pub fn signal(&self, options: &SignalOptions, scene: &str) -> Result<Signal> {
        let rate = f64::from(options.rate_hz);
        let map = match &options.channels {
            Some(map) => map.clone(),
            None => ChannelMap::plain(&self.references),
        };
        let columns = self.columns(&map)?;
        let width = map.0.iter().map(|mapped| mapped.channel).max().unwrap_or(0);
        let highest_hz = self
            .tones
            .iter()
            .map(|tone| tone.frequency_hz)
            .fold(0.0, f64::max);
        if rate <= 2.0 * highest_hz {
            return Err(usage(
                "rate_hz",
                format!("{rate} Hz"),
                format!(
                    "more than {} Hz, twice the drive frequency",
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

    fn scaled(
        &self,
        drive: Array2<f64>,
        map: &ChannelMap,
        options: &SignalOptions,
        scene: &str,
    ) -> Result<Signal> {
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
                        .expected("a channel for each actuator"),
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

fn usage(field: &str, found: String, expected: String) -> Error {
    Error::new(ErrorKind::Usage, "no usable signal")
        .field(field)
        .found(found)
        .expected(expected)
}

/// Turns of the tones against each other: phases mean nothing to the field, and
/// Schroeder's (IEEE Trans. Inf. Theory 16, 1970) keep the lines of a band from adding up
/// to pulses.
pub(crate) fn schroeder(number: usize, count: usize) -> Complex64 {
    let product = (number * number.saturating_sub(1)) as f64;
    Complex64::from_polar(1.0, std::f64::consts::PI * product / count as f64)
}

impl Tracks {
    /// The same with every pattern turned.
    pub(crate) fn turned(mut self, turn: Complex64) -> Self {
        for track in &mut self.tracks {
            track.pattern.mapv_inplace(|value| value * turn);
            if let Some(correction) = &mut track.correction {
                correction.mapv_inplace(|value| value * turn);
            }
        }
        self
    }

    /// The same through channels of these complex gains.
    pub(crate) fn with_gains(mut self, gains: &[Complex64]) -> Self {
        let gains = Array1::from(gains.to_vec());
        for track in &mut self.tracks {
            track.pattern *= &gains;
            if let Some(correction) = &mut track.correction {
                *correction *= &gains;
            }
        }
        self
    }
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
