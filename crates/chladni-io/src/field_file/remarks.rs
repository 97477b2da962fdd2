//! The lines with `#` of a field: frequency, unit, and the weights that were played. Lines
//! with other keys are ignored.

use super::peak::factor_to_peak;
use crate::csv::numbered_lines;
use crate::limits::VELOCITY;
use crate::unit_label;
use chladni_frf::{Error, Result};

/// The value that a line with `#` gives.
pub(super) struct Stated<T> {
    pub(super) value: T,
    /// The value as in the file.
    words: String,
    line: u64,
}

impl<T: PartialEq> Stated<T> {
    /// Notes the value of `field`.
    ///
    /// # Errors
    /// An earlier line with another value.
    fn note(self, field: &str, noted: &mut Option<Self>) -> Result<()> {
        if let Some(known) = noted.as_ref().filter(|known| known.value != self.value) {
            let message = format!(
                "lines {} and {} contradict each other",
                known.line, self.line
            );
            return Err(Error::bad_data(message)
                .at_line(self.line)
                .field(field)
                .found(format!("{}, then {}", known.words, self.words))
                .expected(format!("one line `# {field} = ...`"))
                .help("take the wrong one of the two lines out"));
        }
        *noted = Some(self);
        Ok(())
    }
}

/// The lines with `#`.
#[derive(Default)]
pub(super) struct Remarks {
    pub(super) frequency_hz: Option<Stated<f64>>,
    /// Factor to m/s, peak.
    pub(super) unit: Option<Stated<f64>>,
    pub(super) weights_sha256: Option<Stated<String>>,
}

impl Remarks {
    /// Reads the remarks of a file.
    ///
    /// # Errors
    /// A line that is not understood, or that contradicts an earlier one.
    pub(super) fn of(text: &str) -> Result<Self> {
        let mut remarks = Self::default();
        for (number, line) in numbered_lines(text) {
            if let Some(remark) = line.trim().strip_prefix('#') {
                remarks.take(remark, number)?;
            }
        }
        Ok(remarks)
    }

    /// Reads the text after `#`.
    fn take(&mut self, remark: &str, line: u64) -> Result<()> {
        let Some((key, value)) = remark.split_once('=') else {
            return Ok(());
        };
        let (key, value) = (key.trim(), value.trim());
        let wrong = |expected: &str| {
            Error::bad_data("not understood")
                .at_line(line)
                .field(key)
                .found(value)
                .expected(expected)
        };
        let words = value.to_owned();
        match key {
            "frequency_hz" => {
                let hz = value
                    .parse()
                    .ok()
                    .filter(|hz: &f64| hz.is_finite() && *hz > 0.0);
                let hz = hz.ok_or_else(|| wrong("a frequency in Hz"))?;
                Stated {
                    value: hz,
                    words,
                    line,
                }
                .note(key, &mut self.frequency_hz)?;
            }
            "unit" => {
                let (label, after) = value.split_once([' ', '\t']).unwrap_or((value, ""));
                let unit = unit_label::parse(label).filter(|unit| unit.powers == VELOCITY);
                let unit = unit.ok_or_else(|| wrong("a velocity: m/s, mm/s or um/s (peak)"))?;
                let to_peak = factor_to_peak(after).map_err(|word| {
                    wrong("after the unit nothing, peak, rms, or a remark in brackets")
                        .found(word)
                        .help("give peak values: rms times 1.414, peak-to-peak times 0.5")
                })?;
                let factor = unit.factor * to_peak;
                Stated {
                    value: factor,
                    words,
                    line,
                }
                .note(key, &mut self.unit)?;
            }
            "weights_sha256" => {
                let hexadecimal = value.len() == 64 && value.chars().all(|c| c.is_ascii_hexdigit());
                if !hexadecimal {
                    return Err(wrong("64 hexadecimal digits"));
                }
                let sha256 = value.to_ascii_lowercase();
                Stated {
                    value: sha256,
                    words,
                    line,
                }
                .note(key, &mut self.weights_sha256)?;
            }
            _ => {}
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "# frequency_hz = 300\n# unit = mm/s (peak)\n";

    #[test]
    fn lines_that_contradict_each_other_are_refused_with_both() {
        for (again, field) in [
            ("# unit = m/s", "unit"),
            ("# unit = mm/s rms", "unit"),
            ("# frequency_hz = 310", "frequency_hz"),
        ] {
            let error = Remarks::of(&format!("{HEAD}{again}\n")).err().unwrap();
            assert_eq!(
                (error.line, error.field.as_deref()),
                (Some(3), Some(field)),
                "{again}"
            );
            let first = if field == "unit" { 2 } else { 1 };
            let words = format!("lines {first} and 3");
            assert!(error.message.starts_with(&words), "{error}");
        }
        assert!(Remarks::of(&format!("{HEAD}# unit = mm/s\n# frequency_hz = 300.0\n")).is_ok());
    }
}
