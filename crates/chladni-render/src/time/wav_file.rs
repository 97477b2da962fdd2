//! Sound files of any number of channels: WAVE_FORMAT_EXTENSIBLE with an empty speaker
//! mask, so that no player takes an actuator for a loudspeaker.

use chladni_frf::{Error, ErrorKind, Result};
use std::str::FromStr;

/// The format of a stored sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SampleFormat {
    /// 32-bit float.
    F32,
    /// 24-bit integer.
    I24,
    /// 16-bit integer.
    I16,
}

impl SampleFormat {
    /// All formats, the default first.
    pub const ALL: [Self; 3] = [Self::F32, Self::I24, Self::I16];

    /// Name as on the command line.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::I24 => "i24",
            Self::I16 => "i16",
        }
    }

    /// Steps from 0 to full scale; `None`: a sample keeps its digits however small it is.
    pub(crate) fn steps(self) -> Option<f64> {
        match self {
            Self::F32 => None,
            Self::I24 => Some(f64::from(1u32 << 23)),
            Self::I16 => Some(f64::from(1u32 << 15)),
        }
    }

    /// Bytes of a sample.
    pub fn bytes(self) -> usize {
        match self {
            Self::F32 => 4,
            Self::I24 => 3,
            Self::I16 => 2,
        }
    }
}

impl FromStr for SampleFormat {
    type Err = Error;
    /// The names of [`SampleFormat::ALL`].
    fn from_str(text: &str) -> Result<Self> {
        Self::ALL
            .into_iter()
            .find(|format| format.as_str() == text)
            .ok_or_else(|| {
                Error::new(ErrorKind::Usage, "no such sample format")
                    .field("format")
                    .found(text)
                    .expected("f32, i24 or i16")
            })
    }
}

/// Format tag of an extensible header.
const EXTENSIBLE: u16 = 0xFFFE;
/// The rest of the GUIDs of PCM and float samples, whose first two bytes are the plain
/// format tag (1, 3).
const GUID: [u8; 14] = [0, 0, 0, 0, 0x10, 0, 0x80, 0, 0, 0xAA, 0, 0x38, 0x9B, 0x71];
/// Bytes from the `RIFF` size to the samples: WAVE, fmt, fact, and the header of data.
const HEADER: usize = 4 + 8 + 40 + 8 + 4 + 8;

/// A file of interleaved `values`, −1 to 1.
pub(crate) fn wav_bytes(
    values: impl Iterator<Item = f64>,
    (frames, channels): (usize, usize),
    rate_hz: u32,
    format: SampleFormat,
) -> Result<Vec<u8>> {
    let sample = format.bytes();
    let length = frames * channels * sample;
    let too_large = || {
        Error::new(ErrorKind::Usage, "the signal is too large for a sound file")
            .found(format!("{frames} frames of {channels} channels"))
            .expected("at most 65535 channels and 4 GiB")
    };
    let count = u16::try_from(channels).map_err(|_| too_large())?;
    let frame_bytes = u16::try_from(channels * sample).map_err(|_| too_large())?;
    let size = u32::try_from(HEADER + length + length % 2).map_err(|_| too_large())?;
    let mut bytes = Vec::with_capacity(8 + HEADER + length + 1);
    let bits = 8 * sample as u16;
    let tag: u16 = if format == SampleFormat::F32 { 3 } else { 1 };
    bytes.extend(b"RIFF");
    bytes.extend(size.to_le_bytes());
    bytes.extend(b"WAVEfmt ");
    bytes.extend(40u32.to_le_bytes());
    bytes.extend(EXTENSIBLE.to_le_bytes());
    bytes.extend(count.to_le_bytes());
    bytes.extend(rate_hz.to_le_bytes());
    bytes.extend((rate_hz.saturating_mul(u32::from(frame_bytes))).to_le_bytes());
    bytes.extend(frame_bytes.to_le_bytes());
    bytes.extend(bits.to_le_bytes());
    bytes.extend(22u16.to_le_bytes());
    bytes.extend(bits.to_le_bytes());
    bytes.extend(0u32.to_le_bytes()); // no channel is a loudspeaker
    bytes.extend(tag.to_le_bytes());
    bytes.extend(GUID);
    bytes.extend(b"fact");
    bytes.extend(4u32.to_le_bytes());
    bytes.extend((frames as u32).to_le_bytes());
    bytes.extend(b"data");
    bytes.extend((length as u32).to_le_bytes());
    for value in values {
        match format {
            SampleFormat::F32 => bytes.extend((value as f32).to_le_bytes()),
            SampleFormat::I24 => bytes.extend(&integer(value, 23).to_le_bytes()[..3]),
            SampleFormat::I16 => bytes.extend(&integer(value, 15).to_le_bytes()[..2]),
        }
    }
    if length % 2 == 1 {
        bytes.push(0);
    }
    Ok(bytes)
}

/// Nearest integer; full scale itself is the largest that there is.
fn integer(value: f64, bits: u32) -> i32 {
    let scale = f64::from(1u32 << bits);
    (value * scale).round().clamp(-scale, scale - 1.0) as i32
}
