//! Drives of several frequencies: tones and bands that sound at once.
//!
//! Each tone has its own threshold, its own field and its own weights. What they share is
//! the skin and the actuators. Skin of one kind adds the energy of what it feels, each
//! frequency over its own threshold (Makous, Friedman and Vierck, J. Neurosci. 15, 1995),
//! so that ground is quiet where Σ(v_k/T_k)² stays below the limit: each of n tones may
//! have an n-th of it. To be felt is asked of each tone by itself, and of a band as a
//! whole: its lines may add up. The peaks of one actuator add in the worst case: each
//! tone may have an n-th of its limit.

use crate::digits::hertz;
use crate::tolerances;
use chladni_frf::Result;
use chladni_text::toml_reader::Value;

/// The share of one tone in what all tones of a drive share.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Share {
    /// Part of the energy by which hot ground is felt: 1 for a tone, one over the number
    /// of lines for a line of a band.
    pub hot: f64,
    /// Part of the energy that quiet ground may have: one over the number of all tones.
    pub cold: f64,
    /// Part of each actuator's largest peak: one over the number of all tones.
    pub peak: f64,
}

impl Share {
    /// That of a tone which sounds alone.
    pub const ALONE: Self = Self {
        hot: 1.0,
        cold: 1.0,
        peak: 1.0,
    };
}

/// One frequency of a drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tone {
    /// Hz.
    pub frequency_hz: f64,
    /// Its share.
    pub share: Share,
}

const EXPECTED: &str =
    "a frequency in Hz, or a list of what sounds at once: frequencies, and bands [low, high]";

/// The tones of a drive: a frequency, or a list of frequencies and bands.
///
/// # Errors
/// An empty list, a frequency twice, a band without width, more than
/// `tolerances::MOST_TONES` tones.
pub(crate) fn read_tones(value: &Value) -> Result<Vec<Tone>> {
    let entries: Vec<Vec<f64>> = match value.is_list() {
        false => vec![vec![value.positive()?]],
        true => value
            .list()?
            .iter()
            .map(read_entry)
            .collect::<Result<_>>()?,
    };
    let count = entries.iter().map(Vec::len).sum::<usize>();
    if count == 0 {
        return Err(value.error("no drive frequency", EXPECTED));
    }
    if count > tolerances::MOST_TONES {
        let expected = format!(
            "at most {} tones; a band has one every {} Hz",
            tolerances::MOST_TONES,
            tolerances::BAND_STEP_HZ
        );
        return Err(value.error("too many tones at once", expected));
    }
    let all = 1.0 / count as f64;
    let mut tones: Vec<Tone> = Vec::with_capacity(count);
    for lines in &entries {
        let share = Share {
            hot: 1.0 / lines.len() as f64,
            cold: all,
            peak: all,
        };
        for &frequency_hz in lines {
            if tones
                .iter()
                .any(|tone| is_same(tone.frequency_hz, frequency_hz))
            {
                return Err(value.error(
                    "a frequency occurs twice",
                    "each frequency once, and bands that do not touch",
                ));
            }
            let near = |tone: &&Tone| {
                (tone.frequency_hz - frequency_hz).abs() < tolerances::LEAST_TONE_DISTANCE_HZ
            };
            if let Some(near) = tones.iter().find(near) {
                let message = format!(
                    "{} and {} Hz beat: they are one tone that swells and fades",
                    hertz(near.frequency_hz),
                    hertz(frequency_hz)
                );
                let expected = format!(
                    "tones {} Hz apart or more",
                    tolerances::LEAST_TONE_DISTANCE_HZ
                );
                return Err(value.error(&message, expected));
            }
            tones.push(Tone {
                frequency_hz,
                share,
            });
        }
    }
    Ok(tones)
}

/// The lines of an entry of the list, Hz: one, or those of a band.
fn read_entry(entry: &Value) -> Result<Vec<f64>> {
    if !entry.is_list() {
        return Ok(vec![entry.positive()?]);
    }
    let [low, high] = entry.numbers::<2>("a band [low, high] in Hz")?;
    let steps = ((high - low) / tolerances::BAND_STEP_HZ).ceil();
    if !(low > 0.0 && steps >= 1.0) {
        return Err(entry.error("not a band", "[low, high] in Hz, above 0, rising"));
    }
    // a count that is too large is refused as a whole
    let steps = steps.min(tolerances::MOST_TONES as f64);
    Ok((0..=steps as usize)
        .map(|k| low + (high - low) * k as f64 / steps)
        .collect())
}

/// True where two frequencies are the same line.
pub(crate) fn is_same(a_hz: f64, b_hz: f64) -> bool {
    (a_hz - b_hz).abs() <= tolerances::SAME_FREQUENCY * a_hz.max(b_hz)
}
