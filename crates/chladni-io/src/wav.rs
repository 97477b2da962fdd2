//! WAV files: one time record per channel, DOFs 1:S, 2:S, ..., values as parts of full
//! scale.

use super::{Abscissa, Axis, DatasetInfo, Document, FileFormat, Function, Ordinate};
use chladni_frf::{Direction, Dof, Error, Finding, Result};
use hound::{SampleFormat, WavReader};
use std::io::Cursor;
use std::path::Path;

fn damaged(error: hound::Error) -> Error {
    Error::bad_data("the sound file is damaged")
        .field("WAV")
        .found(error)
        .expected("PCM or float samples")
        .help("export or copy it again")
}

/// The samples of all `channels` in turn, whole and finite.
fn samples_of(reader: &mut WavReader<Cursor<&[u8]>>, channels: usize) -> Result<Vec<f64>> {
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
    let samples = samples.map_err(damaged)?;
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
    Ok(samples)
}

/// Reads all channels; the checksum is left out.
///
/// # Errors
/// A damaged header, a file cut short, samples that are not finite.
pub(super) fn read(bytes: &[u8], file: &Path) -> Result<Document> {
    let mut reader =
        WavReader::new(Cursor::new(bytes)).map_err(|error| damaged(error).file(file))?;
    let spec = reader.spec();
    let count = usize::from(spec.channels);
    if count == 0 || spec.sample_rate == 0 {
        return Err(
            Error::bad_data("the sound file has no channel or no sampling rate")
                .file(file)
                .field("WAV format chunk")
                .found(format!("{count} channels at {} Hz", spec.sample_rate))
                .expected("at least one channel and 1 Hz")
                .help("export it again"),
        );
    }
    let samples = samples_of(&mut reader, count).map_err(|error| error.file(file))?;
    let mut document = Document::new(file, FileFormat::Wav);
    for channel in 0..count {
        let values = samples.iter().skip(channel).step_by(count);
        // single precision holds 24 bits
        let ordinate = match spec.bits_per_sample > 24 && spec.sample_format == SampleFormat::Int {
            true => Ordinate::Real64(values.copied().collect()),
            false => Ordinate::Real32(values.map(|&value| value as f32).collect()),
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
            step: 1.0 / f64::from(spec.sample_rate),
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
