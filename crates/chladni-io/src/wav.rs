//! WAV files: one time record per channel, DOFs 1:S, 2:S, ..., values as parts of full
//! scale.

use super::{Abscissa, Axis, DatasetInfo, Document, FileFormat, Function, Ordinate};
use chladni_frf::{Direction, Dof, Error, Finding, Result};
use hound::{SampleFormat, WavReader};
use std::io::Cursor;
use std::path::Path;

/// Format tag of samples that are floating-point numbers.
const FLOAT: u16 = 3;
/// Format tag whose samples a subformat names, with the same codes.
const EXTENSIBLE: u16 = 0xfffe;

/// Layout and samples of a sound file.
struct Sound {
    channels: usize,
    sample_rate: u32,
    /// True where single precision holds all samples.
    is_single: bool,
    /// The samples of all channels in turn.
    samples: Vec<f64>,
}

/// The chunk `name` of a RIFF file, cut where the file ends.
fn chunk<'a>(bytes: &'a [u8], name: &[u8; 4]) -> Option<(usize, &'a [u8])> {
    let mut rest = bytes.get(12..)?;
    loop {
        let declared = u32::from_le_bytes(rest.get(4..8)?.try_into().ok()?) as usize;
        let content = &rest[8..];
        if &rest[..4] == name {
            return Some((declared, &content[..declared.min(content.len())]));
        }
        // chunks begin at even offsets
        rest = content.get(declared.checked_add(declared % 2)?..)?;
    }
}

/// Tag and bits of the format of the samples, channels and sampling rate.
fn format_of(bytes: &[u8]) -> Option<(u16, u16, usize, u32)> {
    let (_, format) = chunk(bytes, b"fmt ")?;
    let short = |at: usize| Some(u16::from_le_bytes(format.get(at..at + 2)?.try_into().ok()?));
    let tag = match short(0)? {
        EXTENSIBLE => short(24)?,
        tag => tag,
    };
    let sample_rate = u32::from_le_bytes(format.get(4..8)?.try_into().ok()?);
    Some((tag, short(14)?, short(2)?.into(), sample_rate))
}

/// A sound file of 64-bit floating-point samples, which the library does not read; `None` for
/// others.
fn double_precision(bytes: &[u8]) -> Result<Option<Sound>> {
    let Some((FLOAT, 64, channels, sample_rate)) = format_of(bytes) else {
        return Ok(None);
    };
    let Some((declared, data)) = chunk(bytes, b"data") else {
        return Ok(None);
    };
    let samples: Vec<f64> = data
        .chunks_exact(8)
        .map(bytemuck::pod_read_unaligned::<[u8; 8]>)
        .map(f64::from_le_bytes)
        .collect();
    let sound = Sound {
        channels,
        sample_rate,
        is_single: false,
        samples,
    };
    sound.checked(declared / 8).map(Some)
}

impl Sound {
    /// The sound, which must be whole and finite.
    ///
    /// * `declared`: samples of all channels by the header
    fn checked(self, declared: usize) -> Result<Self> {
        let (samples, channels) = (&self.samples, self.channels);
        if channels == 0 || self.sample_rate == 0 {
            return Err(
                Error::bad_data("the sound file has no channel or no sampling rate")
                    .field("WAV format chunk")
                    .found(format!("{channels} channels at {} Hz", self.sample_rate))
                    .expected("at least one channel and 1 Hz")
                    .help("export it again"),
            );
        }
        if samples.len() != declared || !samples.len().is_multiple_of(channels) {
            return Err(Error::bad_data("the sound file ends early")
                .field("WAV data chunk")
                .found(format!("{} samples", samples.len()))
                .expected(format!("{declared}, a multiple of {channels} channels"))
                .help("the file is cut short; export or copy it again"));
        }
        if let Some(k) = samples.iter().position(|sample| !sample.is_finite()) {
            return Err(Error::bad_data("a sample is not finite")
                .field(format!("sample {}", k / channels + 1))
                .found(samples[k])
                .expected("finite numbers"));
        }
        Ok(self)
    }
}

/// The error of the library. A format that it does not know is named.
fn not_read(error: hound::Error, bytes: &[u8]) -> Error {
    match (&error, format_of(bytes)) {
        (hound::Error::Unsupported, Some((tag, bits, ..))) => {
            Error::bad_data("a sound file of another sample format")
                .field("WAV format chunk")
                .found(format!("format tag {tag} with {bits} bits"))
                .expected("PCM (tag 1), or float samples (tag 3) of 32 or 64 bits")
                .help("export it as PCM or as 32-bit float")
        }
        _ => damaged(error),
    }
}

fn damaged(error: hound::Error) -> Error {
    Error::bad_data("the sound file is damaged")
        .field("WAV")
        .found(error)
        .expected("PCM or float samples")
        .help("export or copy it again")
}

/// A sound file of the formats that the library reads.
fn pcm_or_single(bytes: &[u8]) -> Result<Sound> {
    let mut reader = WavReader::new(Cursor::new(bytes)).map_err(|error| not_read(error, bytes))?;
    let (spec, declared) = (reader.spec(), reader.len() as usize);
    let samples: std::result::Result<Vec<f64>, hound::Error> = match spec.sample_format {
        SampleFormat::Float => reader
            .samples::<f32>()
            .map(|sample| sample.map(f64::from))
            .collect(),
        SampleFormat::Int => {
            let full_scale = 2f64.powi(i32::from(spec.bits_per_sample) - 1);
            reader
                .samples::<i32>()
                .map(|sample| sample.map(|value| f64::from(value) / full_scale))
                .collect()
        }
    };
    let sound = Sound {
        channels: spec.channels.into(),
        sample_rate: spec.sample_rate,
        // single precision holds 24 bits
        is_single: spec.bits_per_sample <= 24 || spec.sample_format == SampleFormat::Float,
        samples: samples.map_err(damaged)?,
    };
    sound.checked(declared)
}

/// Reads all channels; the checksum is left out.
///
/// # Errors
/// A damaged header, a file cut short, samples that are not finite.
pub(super) fn read(bytes: &[u8], file: &Path) -> Result<Document> {
    let sound = match double_precision(bytes) {
        Ok(None) => pcm_or_single(bytes),
        Ok(Some(sound)) => Ok(sound),
        Err(error) => Err(error),
    };
    let Sound {
        channels: count,
        sample_rate,
        is_single,
        samples,
    } = sound.map_err(|error| error.file(file))?;
    let mut document = Document::new(file, FileFormat::Wav);
    for channel in 0..count {
        let values = samples.iter().skip(channel).step_by(count);
        let ordinate = match is_single {
            true => Ordinate::Real32(values.map(|&value| value as f32).collect()),
            false => Ordinate::Real64(values.copied().collect()),
        };
        let response = Dof::new(channel as u64 + 1, Direction::SCALAR);
        document.datasets.push(DatasetInfo {
            name: "channel".into(),
            function: Some("time".into()),
            response: Some(response.to_string()),
            values: Some(ordinate.len()),
            ..DatasetInfo::default()
        });
        let times = Abscissa::Even {
            start: 0.0,
            step: 1.0 / f64::from(sample_rate),
        };
        document.functions.push(Function::time_record(
            response,
            times,
            Axis::default(),
            ordinate,
        ));
    }
    document.warnings.push(Finding::caution(
        "unit-assumed",
        "a sound file says no DOFs and no units: values are parts of full scale",
    ));
    Ok(document)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of two channels at 100 Hz with this format tag, sample size and data.
    fn sound(tag: u16, bits: u16, data: &[u8]) -> Vec<u8> {
        let frame = 2 * bits / 8;
        let format = [tag, 2].into_iter().flat_map(u16::to_le_bytes);
        let rates = [100, 100 * u32::from(frame)];
        let mut chunks = b"WAVEfmt \x10\0\0\0".to_vec();
        chunks.extend(format);
        chunks.extend(rates.into_iter().flat_map(u32::to_le_bytes));
        chunks.extend([frame, bits].into_iter().flat_map(u16::to_le_bytes));
        // a chunk of odd length with its padding
        chunks.extend(b"note\x03\0\0\0abc\0data");
        chunks.extend((data.len() as u32).to_le_bytes());
        chunks.extend(data);
        [&b"RIFF"[..], &(chunks.len() as u32).to_le_bytes(), &chunks].concat()
    }

    #[test]
    fn samples_in_double_precision_are_read_with_all_digits() {
        let samples = [0.1, -2.5, 1e-300, 3.0];
        let data: Vec<u8> = samples.iter().flat_map(|v: &f64| v.to_le_bytes()).collect();
        let bytes = sound(FLOAT, 64, &data);
        let document = read(&bytes, Path::new("take.wav")).unwrap();
        let ordinates: Vec<&Ordinate> = document.functions.iter().map(|f| &f.ordinate).collect();
        let [first, second] = [vec![0.1, 1e-300], vec![-2.5, 3.0]].map(Ordinate::Real64);
        assert_eq!(ordinates, [&first, &second]);
        let cut = read(&bytes[..bytes.len() - 8], Path::new("take.wav")).unwrap_err();
        assert!(cut.to_string().contains("ends early"), "{cut}");
        let infinite = sound(FLOAT, 64, &[&data[..24], &f64::NAN.to_le_bytes()].concat());
        let error = read(&infinite, Path::new("take.wav")).unwrap_err();
        assert!(error.to_string().contains("not finite"), "{error}");
    }

    #[test]
    fn a_sample_format_that_is_not_read_is_named() {
        let error = read(&sound(6, 8, &[0; 8]), Path::new("take.wav")).unwrap_err();
        let told = error.to_string();
        for words in ["another sample format", "format tag 6 with 8 bits", "PCM"] {
            assert!(told.contains(words), "{words}: {told}");
        }
    }
}
