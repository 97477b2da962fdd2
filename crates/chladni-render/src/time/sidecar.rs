//! The JSON file beside a signal: rate, channels, full scale, what happens when.

use crate::scene::other_kind::{self, parse_as};
use crate::time::indices::TimeEvent;
use chladni_frf::{Dof, Error, ErrorKind, ReferenceUnit, Result, Source};
use serde::{Deserialize, Serialize};

/// Value of `format` in a signal's sidecar.
pub const SIGNAL_FORMAT: &str = other_kind::SIGNAL;
/// Version of the layout.
pub const SIGNAL_VERSION: u32 = 1;

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
    /// The events and their times; empty where another program made the signal.
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
    /// Value of a sample of 1, in `unit`, the gain taken into account.
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
        const AGAIN: &str = "give the file that was written beside the signal";
        let kind = (SIGNAL_FORMAT, SIGNAL_VERSION);
        let sidecar: Self = parse_as(text, kind, "not a signal's sidecar", AGAIN)?;
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
